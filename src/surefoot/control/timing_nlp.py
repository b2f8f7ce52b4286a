"""Where and when the next N feet land, by nonlinear optimisation: after [Kryczka2015].

While the DCM error is below the threshold the ZMP tracks the plan. Past it the plan is dropped and
the next steps are decided anew, places, times and ZMPs together, once every `solve_period`; in
between, landing and time stand. It ends as the hybrid controller does: at a touchdown at which the
error is small. The problem is in `control/step_sequence.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.control.base import GaitController
from surefoot.control.belief import BELIEF, hold, look
from surefoot.control.cycle import growth_since_touchdown
from surefoot.control.defaults import DCM_GAIN, default_tau_weight, default_threshold
from surefoot.control.fields import filled, setting
from surefoot.control.registry import method
from surefoot.control.step_sequence import (
    LONGEST_HORIZON,
    PLANNED_STEPS,
    SequenceWeights,
    StepSequence,
)
from surefoot.control.tracking import (
    PLAN,
    TRACKING,
    begin_plan,
    check_gain,
    end_cycle,
    follow_plan,
    plan_landing,
    track,
    tracking_parameters,
)
from surefoot.dcm.step_problem import OFFSET_PENALTY
from surefoot.dcm.step_solver import VIOLATION_TOLERANCE
from surefoot.dcm.support import nearest_under_foot
from surefoot.errors import ParameterError
from surefoot.interface import COMMAND, OBSERVATION, Command, Mode, Observation, Status
from surefoot.record import new_array
from surefoot.robot.feet import Side

TAU_SHARE = 5.4
"""Default weight on e^(omega T) per (R / tau_nom)^2, see `control.defaults`: 0.01 for the paper's
biped [1/m^2]. Cheap time lets the foot land early while a push still goes on, of which no decision
knows. With a hundred times as much, a leg of 3 m/s survives a tenth less; with a tenth, an
unlimited one lands at the shortest time, and the rest of a push throws it over the other foot."""

DECIDED_EVERY = 10
"""Control periods from one decision to the next."""

END_WEIGHT = (20000.0, 20000.0)
"""Default weight on the DCM offset at the last landing [1/m^2]."""

PATH_WEIGHT = (1000.0, 1000.0)
"""Default weight on the DCM offsets before the last one [1/m^2]. With none, each decision leaves
the work to later steps, and the gait takes eight steps to settle instead of two."""

TIMING_NLP = np.dtype(
    [
        ("tracking", TRACKING),
        ("threshold", "f8"),
        ("solve_period", "f8"),
        ("longest", "f8"),
        ("zmp_reach", "f8", (2,)),
    ]
)
"""Parameters: of tracking, the threshold [m], how often the steps are decided and how long a step
may last [s], how far the ZMP moves in a decision [m]."""

TIMING_NLP_STATE = np.dtype(
    [
        ("plan", PLAN),
        ("belief", BELIEF),
        ("steps", PLANNED_STEPS),
        ("decided_at", "f8"),
        ("landing_time", "f8"),
        ("known", "i8"),
        ("status", "i8"),
        ("due", "i8"),
        ("command", COMMAND),
    ],
)
"""What is remembered: the plan that is tracked; the steps last decided, when that was and when the
first of them ends, since touchdown [s]; whether there are such steps; what that decision could not
keep; and, in the state that `step` is about to return, what of `DECIDE` and `CARRY_ON` is to do."""

CARRY_ON = 1
"""The steps last decided stand."""

DECIDE = 2
"""The steps are decided anew."""

_ADAPTING = int(Mode.ADAPTING)
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)


@njit
def _shift_steps(steps):
    """The second of the planned steps is the first one now; the last one is thought to repeat."""
    for k in range(LONGEST_HORIZON - 1):
        steps.duration[k] = steps.duration[k + 1]
        for i in range(2):
            steps.step[k, i] = steps.step[k + 1, i]
            steps.zmp[k, i] = steps.zmp[k + 1, i]
            steps.offset[k, i] = steps.offset[k + 1, i]


@njit
def _remember(state, next_state):
    """Take over what was known in the cycle before."""
    next_state.plan, next_state.steps = state.plan, state.steps
    next_state.decided_at, next_state.landing_time = state.decided_at, state.landing_time
    next_state.known, next_state.status, next_state.due = state.known, state.status, 0


@njit
def begin_cycle(parameters, state, observation, next_state):
    """All of a cycle that tracks or holds; of one that adapts, what comes before the decision."""
    _remember(state, next_state)
    if look(parameters.tracking.gate, state, observation, next_state):
        hold(state, next_state)
        return
    observation = next_state.belief.seen
    plan, command, tracking = next_state.plan, next_state.command, parameters.tracking
    new_step = observation.support_side != plan.support_side
    if new_step:
        begin_plan(tracking, observation, plan.adapting != 0, plan)
        plan.adapting = 0
        _shift_steps(next_state.steps)
        next_state.landing_time = next_state.steps.duration[0]
        next_state.decided_at = -math.inf
    if plan.adapting == 0:
        plan_landing(tracking, observation, plan)
    growth = growth_since_touchdown(tracking.omega, observation.elapsed)
    error = follow_plan(tracking, observation, growth, plan, command)
    # A foot that is on the ground already cannot be sent elsewhere.
    if error >= parameters.threshold and plan.closing == 0:
        plan.adapting = 1
    if plan.adapting != 0:
        waited = observation.elapsed - next_state.decided_at
        # Half a cycle early rather than one late.
        due = waited >= parameters.solve_period - 0.5 * tracking.swing.period or waited < 0.0
        next_state.due = DECIDE if due or next_state.known == 0 else CARRY_ON
        return
    next_state.known = 0
    next_state.decided_at = -math.inf
    track(tracking, observation, plan, command)
    in_the_air = plan.opening_after, plan.step_duration - plan.closing_before
    end_cycle(tracking, in_the_air, new_step, state, next_state)


@njit
def _keep_under_sole(parameters, observation, command):
    """Move the ZMP into the sole as it is turned, and the offset at landing along."""
    reach, foot = parameters.zmp_reach, observation.support_foot
    away_x, away_y = command.zmp[0] - foot[0], command.zmp[1] - foot[1]
    x, y = nearest_under_foot(away_x, away_y, reach[0], reach[1], observation.support_yaw)
    growth = math.exp(parameters.tracking.omega * (command.step_duration - observation.elapsed))
    command.zmp[0], command.zmp[1] = foot[0] + x, foot[1] + y
    command.dcm_offset[0] += (x - away_x) * (1.0 - growth)
    command.dcm_offset[1] += (y - away_y) * (1.0 - growth)


@njit
def carry_out(parameters, state, next_state):
    """Command the first of the steps that were decided."""
    observation = next_state.belief.seen
    command, steps, elapsed = next_state.command, next_state.steps, observation.elapsed
    side = observation.support_side
    command.mode, command.status, command.double_support = _ADAPTING, next_state.status, 0
    if elapsed > parameters.longest:
        command.status |= _NO_TIME_LEFT
    command.step_duration = max(next_state.landing_time, elapsed)
    for i in range(2):
        # In a step's own frame y points to its swing side.
        sign = 1 if i == 0 else side
        command.zmp[i] = observation.support_foot[i] + sign * steps.zmp[0, i]
        command.step_location[i] = observation.support_foot[i] + sign * steps.step[0, i]
        command.dcm_offset[i] = sign * steps.offset[0, i]
    if observation.support_yaw != 0.0:
        _keep_under_sole(parameters, observation, command)
    in_the_air = 0.0, command.step_duration
    end_cycle(parameters.tracking, in_the_air, side != state.plan.support_side, state, next_state)


@njit
def _begin(parameters, state, observation, next_state):
    begin_cycle(parameters[0], state[0], observation[0], next_state[0])


@njit
def _end(parameters, state, next_state):
    carry_out(parameters[0], state[0], next_state[0])


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    own, after = (TIMING_NLP, TIMING_NLP_STATE), TIMING_NLP_STATE
    return entry_point(_begin, *own, OBSERVATION, after), entry_point(_end, *own, after)


@method(
    "timing-nlp",
    label="nonlinear step timing",
    source="after Kryczka et al. 2015",
    adapts="ZMP, step location, timing",
    cannot="decides every 10 ms; a local solver may not find the best landing",
    cites=("Kryczka2015",),
    order=80,
    slow=True,
)
@dataclass(frozen=True)
class TimingNlp(GaitController):
    """Tracking for small errors, a nonlinear program over the next steps for large ones.

    IPOPT is an iterative solver on its way to a tolerance: a decision takes milliseconds, and now
    and then it ends without an answer. Then the steps of its last success go on, or the nominal
    ones if there are none, and the command's status says NOT_CONVERGED.

    Raises:
        MissingExtraError: CasADi is not installed.
        VelocityError: the velocity cannot be walked, or not on this leg.
        ParameterError: another argument is out of range.
    """

    STATE = TIMING_NLP_STATE
    NEEDS_LEG = True
    horizon: int = setting(3, "", "N, how many steps are decided together")
    threshold: float | None = setting(
        None,
        "m",
        "DCM error at which the steps are decided anew; 0 always, inf never, a tenth of the room "
        "of the gait if None",
        least=0.0,
        endless=True,
    )
    solve_period: float | None = setting(
        None, "s", "time between two decisions; ten control periods if None", least=0.0
    )
    dcm_gain: float | None = setting(
        None, "1/s", "K_f, rate at which tracking removes an error; 0.857 omega if None", above=0.0
    )
    project_zmp: bool = setting(True, "", "keep the ZMP of tracking inside the foot")
    zmp_share: float = setting(
        1.0,
        "-",
        "how much of the sole the ZMP of a decision may use, 0 for a point foot",
        least=0.0,
    )
    step_weight: tuple[float, float] = setting(
        (1.0, 1.0), "1/m^2", "on every step vector (x, y)", least=0.0, is_weight=True
    )
    tau_weight: float | None = setting(
        None, "-", "on every e^(omega T); 5.4 (R / tau_nom)^2 if None", least=0.0, is_weight=True
    )
    zmp_weight: tuple[float, float] = setting(
        (1.0, 1.0),
        "1/m^2",
        "on every ZMP, from the centre of the foot (x, y)",
        least=0.0,
        is_weight=True,
    )
    offset_weight: tuple[float, float] = setting(
        END_WEIGHT,
        "1/m^2",
        "on the DCM offset at the last landing; it must dominate (x, y)",
        least=0.0,
        is_weight=True,
    )
    path_weight: tuple[float, float] = setting(
        PATH_WEIGHT,
        "1/m^2",
        "on the DCM offsets at the landings before (x, y)",
        least=0.0,
        is_weight=True,
    )
    offset_penalty: float = setting(
        OFFSET_PENALTY,
        "1/m^2",
        "on half the squared violation of the viable set at the last landing",
        above=0.0,
        is_weight=True,
    )
    max_iterations: int = setting(60, "", "of IPOPT in one decision")
    sequence: StepSequence = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        weights = SequenceWeights(
            self.step_weight,
            filled(self.tau_weight),
            self.zmp_weight,
            self.offset_weight,
            self.path_weight,
            self.offset_penalty,
        )
        sequence = StepSequence(
            self.robot, self.gait, self.horizon, weights, self.zmp_share, self.max_iterations
        )
        object.__setattr__(self, "sequence", sequence)
        _compiled()  # Now rather than in the first control cycle.

    def check(self) -> None:
        """Refuse counts that are none, a gain that is too large and a sole that is too long."""
        check_gain(self.dcm_gain, self.period)
        for name, most in (("horizon", LONGEST_HORIZON), ("max_iterations", 10_000)):
            value = getattr(self, name)
            if not isinstance(value, int) or not 1 <= value <= most:
                raise ParameterError(
                    f"`{name}` as a whole number from 1 to {most}",
                    repr(value),
                    "leave it out for the default",
                )
        if self.zmp_share > 1.0:
            raise ParameterError(
                "`zmp_share` of at most 1", f"{self.zmp_share}", "the ZMP cannot leave the sole"
            )

    def defaults(self) -> dict[str, float]:
        """Threshold, time between decisions, gain and weight of tau."""
        return {
            "threshold": default_threshold(self.robot, self.gait),
            "solve_period": DECIDED_EVERY * self.period,
            "dcm_gain": DCM_GAIN * self.robot.omega,
            "tau_weight": default_tau_weight(self.robot, self.gait, TAU_SHARE),
        }

    def make_parameters(self) -> NDArray[np.void]:
        """The `TIMING_NLP` record."""
        parameters = new_array(TIMING_NLP)
        parameters["tracking"] = tracking_parameters(
            self.robot, self.gait, self.dcm_gain, self.project_zmp, 0.0, self.period
        )
        parameters["threshold"], parameters["solve_period"] = self.threshold, self.solve_period
        parameters["longest"] = self.robot.gait.step_duration[1]
        parameters["zmp_reach"] = self.zmp_share * np.array(self.robot.foot.half)
        return parameters

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = super().start(observation)
        state["decided_at"] = -math.inf
        return state

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        next_state = new_array(TIMING_NLP_STATE)
        begin, end = _compiled()
        begin(self.parameters, state, observation.array, next_state)
        due = next_state["due"][0]
        if due == DECIDE:
            self._decide(next_state)
        if due:
            end(self.parameters, state, next_state)
        next_state["due"] = 0
        return Command.of(next_state["command"]), next_state

    def _decide(self, next_state: NDArray[np.void]) -> None:
        """Write the next steps into the state; without an answer, those that were known go on."""
        seen = next_state["belief"]["seen"][0]
        side, elapsed = Side(int(seen["support_side"])), float(seen["elapsed"])
        guess = self.sequence.nominal(side, elapsed)
        if next_state["known"][0]:
            guess = next_state["steps"].copy()
            guess["duration"][0, 0] = max(float(next_state["landing_time"][0]) - elapsed, 0.0)
        foot = seen["support_foot"]
        dcm, swing = seen["dcm"] - foot, seen["swing_foot"][:2] - foot
        speed = seen["swing_foot_velocity"]
        steps, converged, outside = self.sequence.solve(
            side,
            elapsed,
            (float(dcm[0]), float(dcm[1])),
            (float(swing[0]), float(swing[1])),
            guess,
            (float(speed[0]), float(speed[1])),
        )
        status = Status.OK if converged else Status.NOT_CONVERGED
        if converged and outside > VIOLATION_TOLERANCE * self.sequence.size:
            status |= Status.OFFSET_VIOLATED
        steps = steps if converged else guess
        next_state["steps"], next_state["status"], next_state["known"] = steps, int(status), 1
        next_state["decided_at"] = elapsed
        next_state["landing_time"] = elapsed + float(steps["duration"][0, 0])

"""Where and when the next N feet land, by nonlinear optimisation: after [Kryczka2015].

While the DCM error is below the threshold the ZMP tracks the plan. Past it the plan is dropped and
the next steps are decided anew, places, times and ZMPs together, once every `solve_period`; in
between, landing and time stand. It ends as the hybrid controller does: at a touchdown at which the
error is small. The problem is in `control/step_sequence.py`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit, record_entry_point
from surefoot.control.base import GaitController
from surefoot.control.cycle import end_cycle
from surefoot.control.defaults import dcm_gain, tau_weight, threshold
from surefoot.control.fields import filled, setting, weight
from surefoot.control.registry import method
from surefoot.control.step_sequence import (
    MAX_HORIZON,
    PlannedSteps,
    SequenceWeights,
    StepSequence,
)
from surefoot.control.tracking import (
    Tracking,
    TrackingState,
    plan_or_drop,
    track_to_end,
    tracking_parameters,
)
from surefoot.control.validation import validate
from surefoot.dcm.step_problem import OFFSET_PENALTY
from surefoot.dcm.step_solver import VIOLATION_TOLERANCE
from surefoot.dcm.support import nearest_under_foot
from surefoot.errors import ParameterError
from surefoot.interface import Command, Mode, Observation, Status
from surefoot.record import Record, Vector2, field, new_array
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


class TimingNlpParameters(Record):
    """Of `TimingNlp`, beside those of its program."""

    tracking: Tracking = field("", "of tracking")
    threshold: float = field("m", "DCM error at which the steps are decided")
    solve_period: float = field("s", "from one decision to the next")
    longest: float = field("s", "duration of a step")
    zmp_reach: Vector2 = field("m", "how far the ZMP of a decision is from the centre of the foot")


class TimingNlpState(TrackingState):
    """What it remembers."""

    steps: PlannedSteps = field("", "that were decided last")
    decided_at: float = field("s", "when that was, since touchdown")
    landing_time: float = field("s", "when the first of them ends, since touchdown")
    known: int = field("", "whether there are such steps")
    status: int = field("", "what that decision could not keep")
    due: int = field("", "inside of `step`: `DECIDE`, `CARRY_ON`, or 0 for nothing")


CARRY_ON = 1
"""The steps last decided stand."""

DECIDE = 2
"""The steps are decided anew."""

_ADAPTING = int(Mode.ADAPTING)
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)


@njit
def _shift_steps(steps):
    """The second of the planned steps is the first one now; the last one repeats."""
    for k in range(MAX_HORIZON - 1):
        steps.duration[k] = steps.duration[k + 1]
        for i in range(2):
            steps.step[k, i] = steps.step[k + 1, i]
            steps.zmp[k, i] = steps.zmp[k + 1, i]
            steps.offset[k, i] = steps.offset[k + 1, i]


@njit
def begin_cycle(parameters, state, observation, next_state):
    """All of a cycle that tracks or holds; of one that adapts, what comes before the decision."""
    next_state.steps, next_state.landing_time = state.steps, state.landing_time
    next_state.decided_at, next_state.due = state.decided_at, 0
    next_state.known, next_state.status = state.known, state.status
    tracking = parameters.tracking
    if not validate(tracking.gate, state, observation, next_state):
        return
    new_step, _ = plan_or_drop(tracking, parameters.threshold, state, next_state)
    if new_step:
        _shift_steps(next_state.steps)
        next_state.landing_time = next_state.steps.duration[0]
        next_state.decided_at = -math.inf
    if next_state.plan.adapting == 0:
        next_state.known, next_state.decided_at = 0, -math.inf
        track_to_end(tracking, new_step, state, next_state)
        return
    waited = next_state.validated.observation.elapsed - next_state.decided_at
    # Half a cycle early rather than one late.
    due = waited >= parameters.solve_period - 0.5 * tracking.swing.period or waited < 0.0
    next_state.due = DECIDE if due or next_state.known == 0 else CARRY_ON


@njit
def _keep_under_sole(parameters, observation, command):
    """Move the ZMP into the rotated sole, and the offset at landing along."""
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
    observation = next_state.validated.observation
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


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    own, after = (TimingNlpParameters, TimingNlpState), TimingNlpState
    return (
        record_entry_point(begin_cycle, *own, Observation, after),
        record_entry_point(carry_out, *own, after),
    )


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

    STATE = TimingNlpState
    NEEDS_LEG = True
    horizon: int = setting(3, "", "N, how many steps are decided together")
    threshold: float | None = threshold("steps are")
    solve_period: float | None = setting(
        None, "s", "time between two decisions; ten control periods if None", least=0.0,
        own=lambda controller: DECIDED_EVERY * controller.period,
    )  # fmt: skip
    dcm_gain: float | None = dcm_gain("tracking removes an error")
    project_zmp: bool = setting(True, "", "keep the ZMP of tracking inside the foot")
    zmp_share: float = setting(
        1.0, "-", "how much of the sole the ZMP of a decision may use, 0 for a point foot",
        least=0.0,
    )  # fmt: skip
    step_weight: tuple[float, float] = weight((1.0, 1.0), "1/m^2", "on every step vector (x, y)")
    tau_weight: float | None = tau_weight("on every e^(omega T)", "", TAU_SHARE)
    zmp_weight: tuple[float, float] = weight(
        (1.0, 1.0), "1/m^2", "on every ZMP, from the centre of the foot (x, y)"
    )
    offset_weight: tuple[float, float] = weight(
        END_WEIGHT, "1/m^2", "on the DCM offset at the last landing; it must dominate (x, y)"
    )
    path_weight: tuple[float, float] = weight(
        PATH_WEIGHT, "1/m^2", "on the DCM offsets at the landings before (x, y)"
    )
    offset_penalty: float = weight(
        OFFSET_PENALTY, "1/m^2", "on half the squared violation of the viable set at the last "
        "landing", above=0.0,
    )  # fmt: skip
    max_iterations: int = setting(60, "", "of IPOPT in one decision")
    sequence: StepSequence = dataclasses.field(init=False, repr=False, compare=False)

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
        # Now rather than in the first control cycle.
        _ = sequence.solver, _compiled()

    def check(self) -> None:
        """Refuse counts that are none, and a sole that is too long."""
        for name, most in (("horizon", MAX_HORIZON), ("max_iterations", 10_000)):
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

    def make_parameters(self) -> TimingNlpParameters:
        """Those of tracking, and of when to decide."""
        return TimingNlpParameters(
            tracking=tracking_parameters(
                self, dcm_gain=self.dcm_gain, project_zmp=self.project_zmp
            ),
            threshold=filled(self.threshold),
            solve_period=filled(self.solve_period),
            longest=self.robot.gait.step_duration[1],
            zmp_reach=self.zmp_share * np.array(self.robot.foot.half),
        )

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        next_state = new_array(TimingNlpState.DTYPE)
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
        now = next_state["validated"]["observation"][0]
        side, elapsed = Side(int(now["support_side"])), float(now["elapsed"])
        guess = self.sequence.nominal(side, elapsed)
        if next_state["known"][0]:
            guess = next_state["steps"].copy()
            guess["duration"][0, 0] = max(float(next_state["landing_time"][0]) - elapsed, 0.0)
        foot = now["support_foot"]
        dcm, swing = now["dcm"] - foot, now["swing_foot"][:2] - foot
        speed = now["swing_foot_velocity"]
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

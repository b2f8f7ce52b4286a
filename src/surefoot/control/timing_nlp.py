"""Where and when the next N feet land, by nonlinear optimisation: after [Kryczka2015].

While the DCM error is below the threshold the ZMP tracks the plan. Past it the plan is dropped and
the next steps are decided anew, places, times and ZMPs together, once every `solve_period`; in
between, landing and time stand. It ends as the hybrid controller does: at a touchdown at which the
error is small. The problem is in `control/step_sequence.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_pair, check_weights
from surefoot.compiled import entry_point, njit
from surefoot.control.dcm_tracking import (
    check_leg,
    check_tracking,
    first_plan,
    tracking_parameters,
)
from surefoot.control.defaults import (
    DCM_GAIN,
    default_tau_weight,
    default_threshold,
    fill_in,
    filled,
)
from surefoot.control.step_sequence import LONGEST_HORIZON, SequenceWeights, StepSequence
from surefoot.control.timing_nlp_law import (
    DECIDE,
    TIMING_NLP,
    TIMING_NLP_STATE,
    begin_cycle,
    end_cycle,
)
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.dcm.step_problem import OFFSET_PENALTY
from surefoot.dcm.step_solver import VIOLATION_TOLERANCE
from surefoot.errors import ParameterError
from surefoot.interface import OBSERVATION, Command, Observation, Status
from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

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


@njit
def _begin(parameters, state, observation, next_state):
    begin_cycle(parameters[0], state[0], observation[0], next_state[0])


@njit
def _end(parameters, state, next_state):
    end_cycle(parameters[0], state[0], next_state[0])


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    own, after = (TIMING_NLP, TIMING_NLP_STATE), TIMING_NLP_STATE
    return entry_point(_begin, *own, OBSERVATION, after), entry_point(_end, *own, after)


@dataclass(frozen=True)
class TimingNlp:
    """Tracking for small errors, a nonlinear program over the next steps for large ones.

    IPOPT is an iterative solver on its way to a tolerance: a decision takes milliseconds, and now
    and then it ends without an answer. Then the steps of its last success go on, or the nominal
    ones if there are none, and the command's status says NOT_CONVERGED.

    Args:
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        horizon: N, how many steps are decided together.
        threshold: DCM error at which the steps are decided anew [m]; 0 always, inf never, a tenth
            of the room of the gait if None.
        solve_period: time between two decisions; ten control periods if None [s].
        dcm_gain: K_f, rate at which tracking removes an error; 0.857 omega if None [1/s].
        project_zmp: keep the ZMP of tracking inside the foot.
        zmp_share: how much of the sole the ZMP of a decision may use, 0 for a point foot [-].
        step_weight: on every step vector (x, y) [1/m^2].
        tau_weight: on every e^(omega T); 5.4 (R / tau_nom)^2 if None [-].
        zmp_weight: on every ZMP, from the centre of the foot (x, y) [1/m^2].
        offset_weight: on the DCM offset at the last landing; it must dominate (x, y) [1/m^2].
        path_weight: on the DCM offsets at the landings before (x, y) [1/m^2].
        offset_penalty: on half the squared violation of the viable set at the last landing [1/m^2].
        max_iterations: of IPOPT in one decision.
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        MissingExtraError: CasADi is not installed.
        VelocityError: the velocity cannot be walked, or not on this leg.
        ParameterError: another argument is out of range.
    """

    robot: Robot
    velocity: tuple[float, float]
    horizon: int = 3
    threshold: float | None = None
    solve_period: float | None = None
    dcm_gain: float | None = None
    project_zmp: bool = True
    zmp_share: float = 1.0
    step_weight: tuple[float, float] = (1.0, 1.0)
    tau_weight: float | None = None
    zmp_weight: tuple[float, float] = (1.0, 1.0)
    offset_weight: tuple[float, float] = END_WEIGHT
    path_weight: tuple[float, float] = PATH_WEIGHT
    offset_penalty: float = OFFSET_PENALTY
    max_iterations: int = 60
    step_duration: float | None = None
    period: float = 0.001
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)
    sequence: StepSequence = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_tracking(self.robot, self.dcm_gain, 0.0, self.period)
        self._check_decision()
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        check_leg(self.robot, gait)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        fill_in(
            self,
            threshold=default_threshold(self.robot, gait),
            solve_period=DECIDED_EVERY * self.period,
            dcm_gain=DCM_GAIN * self.robot.omega,
            tau_weight=default_tau_weight(self.robot, gait, TAU_SHARE),
        )
        parameters = new_array(TIMING_NLP)
        parameters["tracking"] = tracking_parameters(
            self.robot, gait, filled(self.dcm_gain), self.project_zmp, 0.0, self.period
        )
        parameters["threshold"], parameters["solve_period"] = self.threshold, self.solve_period
        parameters["longest"] = self.robot.gait.step_duration[1]
        parameters["zmp_reach"] = self.zmp_share * np.array(self.robot.foot.half)
        object.__setattr__(self, "parameters", parameters)
        weights = SequenceWeights(
            self.step_weight,
            filled(self.tau_weight),
            self.zmp_weight,
            self.offset_weight,
            self.path_weight,
            self.offset_penalty,
        )
        sequence = StepSequence(
            self.robot, gait, self.horizon, weights, self.zmp_share, self.max_iterations
        )
        object.__setattr__(self, "sequence", sequence)
        _compiled()  # Now rather than in the first control cycle.

    def _check_decision(self) -> None:
        for name, most in (("horizon", LONGEST_HORIZON), ("max_iterations", 10_000)):
            value = getattr(self, name)
            if not isinstance(value, int) or not 1 <= value <= most:
                raise ParameterError(
                    f"`{name}` as a whole number from 1 to {most}",
                    repr(value),
                    "leave it out for the default",
                )
        if self.threshold is not None:
            check_number("threshold", self.threshold, 0.0, "m", endless=True)
        if self.solve_period is not None:
            check_number("solve_period", self.solve_period, 0.0, "s")
        check_number("zmp_share", self.zmp_share, 0.0, "-")
        if self.zmp_share > 1.0:
            raise ParameterError(
                "`zmp_share` of at most 1", f"{self.zmp_share}", "the ZMP cannot leave the sole"
            )
        for name in ("step_weight", "zmp_weight", "offset_weight", "path_weight"):
            check_pair(name, getattr(self, name), 0.0, "1/m^2")
        if self.tau_weight is not None:
            check_number("tau_weight", self.tau_weight, 0.0, "-")
        check_number("offset_penalty", self.offset_penalty, 0.0, "1/m^2", above=True)
        names = (name for name in self.__dataclass_fields__ if name.endswith("_weight"))
        every = {name: getattr(self, name) for name in names}
        check_weights(**every, offset_penalty=self.offset_penalty)

    @property
    def kernel(self) -> None:
        """None: an interior-point solver is no compiled cycle, so it cannot run in a batch."""
        return None

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot on the nominal gait observes at a touchdown; right foot first by default."""
        return self.gait.observation(Side.RIGHT if support_side is None else support_side)

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = new_array(TIMING_NLP_STATE)
        first_plan(self.gait, observation, state)
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

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)

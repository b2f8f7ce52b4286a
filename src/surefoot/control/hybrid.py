"""The paper's hybrid controller: track small errors, re-plan the step for large ones.

Section III-C and Fig. 6 of [OnlineGait]. While the DCM error is below the threshold the ZMP tracks
the plan. Past it the plan is dropped, the ZMP rests at the centre of the foot, and every cycle
decides step location and timing anew. At the next touchdown the plan starts again from the nominal
offset of the new foot, and tracking resumes if the error there is below the threshold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from surefoot.compiled import njit
from surefoot.control.base import CompiledController
from surefoot.control.cycle import end_cycle, side_index
from surefoot.control.defaults import TAU_WEIGHT, dcm_gain, double_support, tau_weight, threshold
from surefoot.control.fields import filled, setting, weight
from surefoot.control.registry import method
from surefoot.control.tracking import (
    Tracking,
    TrackingState,
    plan_or_drop,
    track_to_end,
    tracking_parameters,
)
from surefoot.control.validation import validate
from surefoot.dcm.step_in_reach import SavedAfterStep, saved_by, solve_step_in_reach
from surefoot.dcm.step_problem import (
    OFFSET_PENALTY,
    OFFSET_WEIGHT,
    StepProblem,
    StepSolution,
    gait_problem,
)
from surefoot.dcm.step_solver import solve_step_record
from surefoot.interface import Mode
from surefoot.record import Array, Record, field
from surefoot.robot.feet import Side


class HybridParameters(Record):
    """Of a controller that tracks its plan, and decides the step anew past a threshold."""

    tracking: Tracking = field("", "of tracking")
    threshold: float = field("m", "DCM error at which the step is decided anew")
    knows_leg: int = field("", "1 if landings must be in reach of the leg", default=0)
    saved: SavedAfterStep = field("", "what its steps can save", default=SavedAfterStep())
    problem: Array = field("", "what is decided on either foot", shape=2, kind=StepProblem)


class HybridState(TrackingState):
    """What it remembers."""

    solution: StepSolution = field("", "of the step problem that was solved last")


_ADAPTING = int(Mode.ADAPTING)


@njit
def adapt(parameters, observation, growth, solution, command):
    """Write ZMP, landing and timing of a step that is decided now; `growth` is e^(omega t)."""
    problem = parameters.problem[side_index(observation.support_side)]
    foot, leg = observation.support_foot, parameters.tracking.swing
    growth_x = (observation.dcm[0] - foot[0]) / growth
    growth_y = (observation.dcm[1] - foot[1]) / growth
    if parameters.knows_leg != 0:
        swing, velocity = observation.swing_foot, observation.swing_foot_velocity
        solve_step_in_reach(
            problem,
            parameters.saved,
            float(observation.support_side),
            (growth_x, growth_y),
            math.log(growth) / parameters.tracking.omega,
            (swing[0] - foot[0], swing[1] - foot[1], velocity[0], velocity[1]),
            (leg.max_speed, leg.max_acceleration, parameters.tracking.omega),
            solution,
        )
    else:
        solve_step_record(problem, growth_x, growth_y, growth, solution)
    command.mode, command.status, command.double_support = _ADAPTING, solution.status, 0
    command.step_duration = max(
        math.log(solution.tau) / parameters.tracking.omega, observation.elapsed
    )
    for i in range(2):
        command.zmp[i] = observation.support_foot[i]
        command.step_location[i] = observation.support_foot[i] + solution.step[i]
        command.dcm_offset[i] = solution.offset[i]


@njit
def hybrid_cycle(parameters, state, observation, next_state):
    """One cycle of `HybridController` over records."""
    next_state.solution = state.solution
    tracking = parameters.tracking
    if not validate(tracking.gate, state, observation, next_state):
        return
    new_step, growth = plan_or_drop(tracking, parameters.threshold, state, next_state)
    if next_state.plan.adapting == 0:
        track_to_end(tracking, new_step, state, next_state)
        return
    command = next_state.command
    adapt(parameters, next_state.validated.observation, growth, next_state.solution, command)
    end_cycle(tracking, (0.0, command.step_duration), new_step, state, next_state)


class StepDecider(
    CompiledController, cycle=hybrid_cycle, parameters=HybridParameters, state=HybridState
):
    """Decides steps by the step problem; a subclass declares the settings that it is made of."""

    step_weight: tuple[float, float]
    tau_weight: float | None
    offset_weight: tuple[float, float]
    offset_penalty: float
    knows_leg: bool

    def offset_bounds(self, support_side: Side) -> tuple[tuple[float, float], tuple[float, float]]:
        """Least and largest DCM offset at landing (x, y) [m]."""
        raise NotImplementedError(f"{type(self).__name__}.offset_bounds")

    def step_problem(
        self,
        support_side: Side,
        growth: tuple[float, float] | None = None,
        elapsed: float = 0.0,
    ) -> StepProblem:
        """The step problem that this controller solves.

        Args:
            support_side: foot on the ground.
            growth: (A, B), the nominal gait if None [m].
            elapsed: t, time since touchdown [s].
        """
        return gait_problem(
            self.robot,
            self.gait,
            support_side,
            self.offset_bounds(support_side),
            growth,
            elapsed,
            step_weight=self.step_weight,
            tau_weight=filled(self.tau_weight),
            offset_weight=self.offset_weight,
            offset_penalty=self.offset_penalty,
        )

    def hybrid_parameters(self, tracking: Tracking, threshold: float) -> HybridParameters:
        """The parameters, from those of tracking and the threshold [m]."""
        problems = [self.step_problem(side).array[0] for side in (Side.RIGHT, Side.LEFT)]
        parameters = HybridParameters(tracking=tracking, threshold=threshold, problem=problems)
        # Of a leg without limits there is nothing to know.
        if not self.knows_leg or not self.robot.swing.is_limited:
            return parameters
        return parameters.replace(knows_leg=1, saved=saved_by(self.robot))


def step_weight() -> Any:
    """The setting a1, a2."""
    return weight((1.0, 1.0), "1/m^2", "(a1, a2) on the step vector", search=(None, (0.01, 100.0)))


def offset_weight(default: tuple[float, float]) -> Any:
    """The setting a4, a5."""
    words = "(a4, a5) on the DCM offset; they must dominate"
    return weight(default, "1/m^2", words, search=((1.0, 1e6), (1.0, 1e6)))


def offset_penalty(distance: str) -> Any:
    """The setting rho, on half the squared distance."""
    return weight(OFFSET_PENALTY, "1/m^2", f"on half the squared {distance}", search=(1e3, 1e9))


def knows_leg() -> Any:
    """The setting that a landing must be in reach."""
    return setting(
        False, "", "whether a landing must be in reach of `robot.swing` when the foot lands; False "
        "is as published",
    )  # fmt: skip


A3 = "a3 on tau", ", see `control.defaults`", TAU_WEIGHT, (0.001, 100.0)
"""The setting `tau_weight` of the step problem."""


@method(
    "hybrid",
    label="the paper's hybrid",
    source="On-line gait adjustment, III-C",
    adapts="ZMP or step location, timing",
    cannot="holds the ZMP while it adapts the step; knows the leg, which as published it does not",
    cites=("OnlineGait",),
    order=90,
    compared={"knows_leg": True},
)
@dataclass(frozen=True)
class HybridController(StepDecider):
    """DCM tracking for small errors, online step location and timing for large ones.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    threshold: float | None = threshold("step is", search=(0.002, 0.2))
    dcm_gain: float | None = dcm_gain("tracking removes an error", search=(0.5, 30.0))
    project_zmp: bool = setting(True, "", "keep the ZMP of tracking inside the foot")
    step_weight: tuple[float, float] = step_weight()
    tau_weight: float | None = tau_weight(*A3)
    offset_weight: tuple[float, float] = offset_weight(OFFSET_WEIGHT)
    offset_penalty: float = offset_penalty("violation of the offset bounds")
    knows_leg: bool = knows_leg()
    double_support: float = double_support(
        "fraction of the step for which both feet share the load while tracking"
    )

    def make_parameters(self) -> HybridParameters:
        """Those of tracking, and of the step problem past the threshold."""
        tracking = tracking_parameters(
            self,
            dcm_gain=self.dcm_gain,
            project_zmp=self.project_zmp,
            double_support=self.double_support,
        )
        return self.hybrid_parameters(tracking, filled(self.threshold))

    def offset_bounds(self, support_side: Side) -> tuple[tuple[float, float], tuple[float, float]]:
        """Those of the robot."""
        bound_x, bound_y = self.robot.gait.dcm_offset
        return (-bound_x, -bound_y), (bound_x, bound_y)

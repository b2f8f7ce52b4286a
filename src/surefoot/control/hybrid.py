"""The paper's hybrid controller: track small errors, re-plan the step for large ones.

Section III-C and Fig. 6 of [OnlineGait]. While the DCM error is below the threshold the ZMP tracks
the plan. Past it the plan is dropped, the ZMP rests at the centre of the foot, and every cycle
decides step location and timing anew. At the next touchdown the plan starts again from the nominal
offset of the new foot, and tracking resumes if the error there is below the threshold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.control.base import CompiledController
from surefoot.control.belief import BELIEF, hold, look
from surefoot.control.cycle import growth_since_touchdown, side_index
from surefoot.control.defaults import DCM_GAIN, default_tau_weight, default_threshold
from surefoot.control.fields import filled, setting
from surefoot.control.registry import method
from surefoot.control.tracking import (
    PLAN,
    TRACKING,
    begin_plan,
    check_double_support,
    check_gain,
    end_cycle,
    follow_plan,
    plan_landing,
    track,
    tracking_parameters,
)
from surefoot.dcm.step_in_reach import SavedAfterStep, saved_by, solve_step_in_reach
from surefoot.dcm.step_problem import (
    OFFSET_PENALTY,
    OFFSET_WEIGHT,
    STEP_PROBLEM,
    STEP_SOLUTION,
    StepProblem,
    gait_problem,
)
from surefoot.dcm.step_solver import solve_step_record
from surefoot.interface import COMMAND, Mode
from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

HYBRID = np.dtype(
    [
        ("tracking", TRACKING),
        ("threshold", "f8"),
        ("knows_leg", "i8"),
        ("saved", SavedAfterStep.DTYPE),
        ("problem", STEP_PROBLEM, (2,)),
    ]
)
"""Parameters: of tracking, the threshold [m], whether landings must be in reach of the leg, what
steps of it can save, and the step problem of each support side."""

HYBRID_STATE = np.dtype(
    [("plan", PLAN), ("belief", BELIEF), ("solution", STEP_SOLUTION), ("command", COMMAND)]
)

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
    if look(tracking.gate, state, observation, next_state):
        hold(state, next_state)
        return
    next_state.plan = state.plan
    plan, command = next_state.plan, next_state.command
    observation = next_state.belief.seen
    growth = growth_since_touchdown(tracking.omega, observation.elapsed)
    new_step = observation.support_side != plan.support_side
    if new_step:
        begin_plan(tracking, observation, plan.adapting != 0, plan)
        plan.adapting = 0
    if plan.adapting == 0:
        plan_landing(tracking, observation, plan)
    error = follow_plan(tracking, observation, growth, plan, command)
    # A foot that is on the ground already cannot be sent elsewhere.
    if error >= parameters.threshold and plan.closing == 0:
        plan.adapting = 1
    if plan.adapting != 0:
        adapt(parameters, observation, growth, next_state.solution, command)
        in_the_air = 0.0, command.step_duration
    else:
        track(tracking, observation, plan, command)
        in_the_air = plan.opening_after, plan.step_duration - plan.closing_before
    end_cycle(tracking, in_the_air, new_step, state, next_state)


@njit
def hybrid_step(parameters, state, observation, next_state):
    """The same over arrays of one record."""
    hybrid_cycle(parameters[0], state[0], observation[0], next_state[0])


def hybrid_parameters(
    tracking: NDArray[np.void],
    threshold: float,
    leg: Robot | None,
    problems: dict[Side, StepProblem],
) -> NDArray[np.void]:
    """The `HYBRID` record, shape (1,).

    Args:
        tracking: the `TRACKING` record.
        threshold: DCM error at which the step is decided anew [m].
        leg: the robot whose leg must reach a landing; None if that is not asked. Of a leg without
            limits there is nothing to know.
        problems: what is decided on either foot.
    """
    parameters = new_array(HYBRID)
    parameters["tracking"], parameters["threshold"] = tracking, threshold
    if leg is not None and leg.swing.is_limited:
        parameters["knows_leg"], parameters["saved"] = 1, saved_by(leg).array
    for side, problem in problems.items():
        parameters["problem"][0, side_index.py_func(side)] = problem.array[0]
    return parameters


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
class HybridController(
    CompiledController,
    cycle=hybrid_cycle,
    arrays=hybrid_step,
    parameters=HYBRID,
    state=HYBRID_STATE,
):
    """DCM tracking for small errors, online step location and timing for large ones.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    threshold: float | None = setting(
        None,
        "m",
        "DCM error at which the step is decided anew; 0 always, inf never, a tenth of the room of "
        "the gait if None",
        least=0.0,
        endless=True,
        search=(0.002, 0.2),
    )
    dcm_gain: float | None = setting(
        None, "1/s", "K_f, rate at which tracking removes an error; 0.857 omega if None",
        above=0.0, search=(0.5, 30.0),
    )  # fmt: skip
    project_zmp: bool = setting(True, "", "keep the ZMP of tracking inside the foot")
    step_weight: tuple[float, float] = setting(
        (1.0, 1.0), "1/m^2", "(a1, a2) on the step vector",
        least=0.0, is_weight=True, search=(None, (0.01, 100.0)),
    )  # fmt: skip
    tau_weight: float | None = setting(
        None, "-", "a3 on tau; 540 (R / tau_nom)^2 if None, see `control.defaults`",
        least=0.0, is_weight=True, search=(0.001, 100.0),
    )  # fmt: skip
    offset_weight: tuple[float, float] = setting(
        OFFSET_WEIGHT, "1/m^2", "(a4, a5) on the DCM offset; they must dominate",
        least=0.0, is_weight=True, search=((1.0, 1e6), (1.0, 1e6)),
    )  # fmt: skip
    offset_penalty: float = setting(
        OFFSET_PENALTY, "1/m^2", "on half the squared violation of the offset bounds",
        least=0.0, is_weight=True, search=(1e3, 1e9),
    )  # fmt: skip
    knows_leg: bool = setting(
        False,
        "",
        "whether a landing must be in reach of `robot.swing` when the foot lands; False is as "
        "published",
    )
    double_support: float = setting(
        0.0,
        "-",
        "fraction of the step for which both feet share the load while tracking",
        least=0.0,
    )

    def check(self) -> None:
        """Refuse a gain that is too large, and a double support that is too long."""
        check_gain(self.dcm_gain, self.period)
        check_double_support(self.double_support)

    def defaults(self) -> dict[str, float]:
        """Threshold, gain and weight of tau."""
        return {
            "threshold": default_threshold(self.robot, self.gait),
            "dcm_gain": DCM_GAIN * self.robot.omega,
            "tau_weight": default_tau_weight(self.robot, self.gait),
        }

    def make_parameters(self) -> NDArray[np.void]:
        """The `HYBRID` record."""
        tracking = tracking_parameters(
            self.robot, self.gait, self.dcm_gain, self.project_zmp, self.double_support, self.period
        )
        leg = self.robot if self.knows_leg else None
        problems = {side: self.step_problem(side) for side in Side}
        return hybrid_parameters(tracking, filled(self.threshold), leg, problems)

    def step_problem(
        self,
        support_side: Side,
        growth: tuple[float, float] | None = None,
        elapsed: float = 0.0,
    ) -> StepProblem:
        """The step problem that this controller solves.

        The offset bounds are the robot's.

        Args:
            support_side: foot on the ground.
            growth: (A, B), the nominal gait if None [m].
            elapsed: t, time since touchdown [s].
        """
        bound_x, bound_y = self.robot.gait.dcm_offset
        return gait_problem(
            self.robot,
            self.gait,
            support_side,
            ((-bound_x, -bound_y), (bound_x, bound_y)),
            growth,
            elapsed,
            step_weight=self.step_weight,
            tau_weight=filled(self.tau_weight),
            offset_weight=self.offset_weight,
            offset_penalty=self.offset_penalty,
        )

"""The paper's hybrid controller: track small errors, re-plan the step for large ones.

Section III-C and Fig. 6 of [OnlineGait]. While the DCM error is below the threshold the ZMP tracks
the plan. Past it the plan is dropped, the ZMP rests at the centre of the foot, and every cycle
decides step location and timing anew. At the next touchdown the plan starts again from the nominal
offset of the new foot, and tracking resumes if the error there is below the threshold.
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
from surefoot.control.belief import BELIEF, hold, look, mark
from surefoot.control.cycle import command_swing, growth_since_touchdown, side_index
from surefoot.control.dcm_tracking import (
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
from surefoot.control.tracking_law import (
    PLAN,
    TRACKING,
    begin_plan,
    follow_plan,
    plan_landing,
    track,
)
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
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
from surefoot.interface import COMMAND, OBSERVATION, Command, Mode, Observation
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
    command_swing(
        tracking.swing,
        observation,
        in_the_air,
        tracking.landing_yaw,
        state.command,
        plan.phase,
        new_step,
        command,
    )
    mark(next_state)


@njit
def _hybrid_step(parameters, state, observation, next_state):
    hybrid_cycle(parameters[0], state[0], observation[0], next_state[0])


@cache
def compiled_hybrid() -> Callable[..., None]:
    """The cycle as it is called from Python, on arrays of one record."""
    return entry_point(_hybrid_step, HYBRID, HYBRID_STATE, OBSERVATION, HYBRID_STATE)


@dataclass(frozen=True)
class HybridController:
    """DCM tracking for small errors, online step location and timing for large ones.

    Args:
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        threshold: DCM error at which the step is decided anew [m]; 0 always, inf never, a tenth of
            the room of the gait if None.
        dcm_gain: K_f, rate at which tracking removes an error; 0.857 omega if None [1/s].
        project_zmp: keep the ZMP of tracking inside the foot.
        step_weight: (a1, a2) on the step vector [1/m^2].
        tau_weight: a3 on tau; 540 (R / tau_nom)^2 if None, see `control.defaults` [-].
        offset_weight: (a4, a5) on the DCM offset; they must dominate [1/m^2].
        offset_penalty: on half the squared violation of the offset bounds [1/m^2].
        knows_leg: whether a landing must be in reach of `robot.swing` when the foot lands; False is
            as published.
        double_support: fraction of the step for which both feet share the load while tracking.
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    robot: Robot
    velocity: tuple[float, float]
    threshold: float | None = None
    dcm_gain: float | None = None
    project_zmp: bool = True
    step_weight: tuple[float, float] = (1.0, 1.0)
    tau_weight: float | None = None
    offset_weight: tuple[float, float] = OFFSET_WEIGHT
    offset_penalty: float = OFFSET_PENALTY
    knows_leg: bool = False
    double_support: float = 0.0
    step_duration: float | None = None
    period: float = 0.001
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_tracking(self.robot, self.dcm_gain, self.double_support, self.period)
        if self.threshold is not None:
            check_number("threshold", self.threshold, 0.0, "m", endless=True)
        check_pair("step_weight", self.step_weight, 0.0, "1/m^2")
        if self.tau_weight is not None:
            check_number("tau_weight", self.tau_weight, 0.0, "-")
        check_pair("offset_weight", self.offset_weight, 0.0, "1/m^2")
        check_number("offset_penalty", self.offset_penalty, 0.0, "1/m^2")
        check_weights(
            step_weight=self.step_weight,
            tau_weight=self.tau_weight,
            offset_weight=self.offset_weight,
            offset_penalty=self.offset_penalty,
        )
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        fill_in(
            self,
            threshold=default_threshold(self.robot, gait),
            dcm_gain=DCM_GAIN * self.robot.omega,
            tau_weight=default_tau_weight(self.robot, gait),
        )
        parameters = new_array(HYBRID)
        parameters["tracking"] = tracking_parameters(
            self.robot,
            gait,
            filled(self.dcm_gain),
            self.project_zmp,
            self.double_support,
            self.period,
        )
        parameters["threshold"] = self.threshold
        # Of a leg without limits there is nothing to know.
        parameters["knows_leg"] = self.knows_leg and self.robot.swing.is_limited
        if parameters["knows_leg"][0]:
            parameters["saved"] = saved_by(self.robot).array
        for side in Side:
            parameters["problem"][0, side_index.py_func(side)] = self.step_problem(side).array[0]
        object.__setattr__(self, "parameters", parameters)
        compiled_hybrid()  # Now rather than in the first control cycle.

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

    @property
    def kernel(self) -> Callable[..., None]:
        """The compiled cycle over records."""
        return hybrid_cycle

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot on the nominal gait observes at a touchdown; right foot first by default."""
        return self.gait.observation(Side.RIGHT if support_side is None else support_side)

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = new_array(HYBRID_STATE)
        first_plan(self.gait, observation, state)
        return state

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        next_state = new_array(HYBRID_STATE)
        compiled_hybrid()(self.parameters, state, observation.array, next_state)
        return Command.of(next_state["command"]), next_state

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)

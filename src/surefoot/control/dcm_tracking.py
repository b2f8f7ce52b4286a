"""Track the planned DCM by moving the ZMP: Eqs. (21)-(25) of [OnlineGait], after [Englsberger2015].

    zmp = zmp_plan + (1 + K_f / omega) (dcm - dcm_plan)

makes the error decay with the rate K_f, as long as the ZMP stays under the foot.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_most, check_number
from surefoot.compiled import entry_point, njit
from surefoot.control.belief import BELIEF, first_belief, hold, look, mark
from surefoot.control.cycle import (
    command_swing,
    growth_since_touchdown,
    is_usable,
    side_index,
)
from surefoot.control.defaults import DCM_GAIN, fill_in, filled
from surefoot.control.plausibility import gate_parameters
from surefoot.control.tracking_law import (
    PLAN,
    TRACKING,
    begin_plan,
    follow_plan,
    plan_landing,
    track,
)
from surefoot.dcm.leg import time_to
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.errors import ParameterError, VelocityError
from surefoot.interface import COMMAND, OBSERVATION, Command, Observation
from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

NO_GAIN = 0.0
"""For methods that take over the records of tracking, but not its law [1/s]."""

TRACKING_STATE = np.dtype([("plan", PLAN), ("belief", BELIEF), ("command", COMMAND)])

LEAST_CYCLES = 4
"""The shortest step has so many control cycles: every method walks with them, and few with less."""

LONGEST_DOUBLE_SUPPORT = 0.6
"""The largest fraction of a step for which both feet may share the load."""


@njit
def tracking_cycle(parameters, state, observation, next_state):
    """One cycle of `DcmTracking` over records."""
    if look(parameters.gate, state, observation, next_state):
        hold(state, next_state)
        return
    track_step(parameters, state, next_state)


@njit
def track_step(parameters, state, next_state):
    """The cycle of `DcmTracking` on what is believed, `next_state.belief`."""
    observation = next_state.belief.seen
    next_state.plan = state.plan
    plan, command = next_state.plan, next_state.command
    new_step = observation.support_side != plan.support_side
    if new_step:
        begin_plan(parameters, observation, False, plan)
    plan_landing(parameters, observation, plan)
    growth = growth_since_touchdown(parameters.omega, observation.elapsed)
    follow_plan(parameters, observation, growth, plan, command)
    track(parameters, observation, plan, command)
    in_the_air = plan.opening_after, plan.step_duration - plan.closing_before
    command_swing(
        parameters.swing,
        observation,
        in_the_air,
        parameters.landing_yaw,
        state.command,
        plan.phase,
        new_step,
        command,
    )
    mark(next_state)


@njit
def _tracking_step(parameters, state, observation, next_state):
    tracking_cycle(parameters[0], state[0], observation[0], next_state[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_tracking_step, TRACKING, TRACKING_STATE, OBSERVATION, TRACKING_STATE)


def check_tracking(
    robot: Robot, dcm_gain: float | None, double_support: float, period: float
) -> None:
    """Refuse what no controller that tracks can work with.

    Raises:
        ParameterError: no `Robot`, a gain or a period that is not positive or too large, or a
            double support that leaves too little of the step to move the foot in.
    """
    if not isinstance(robot, Robot):
        raise ParameterError("a Robot", repr(robot), 'load one: surefoot.load_robot("paper-biped")')
    if dcm_gain is not None:
        check_number("dcm_gain", dcm_gain, 0.0, "1/s", above=True)
    check_number("period", period, 0.0, "s", above=True)
    shortest = robot.gait.step_duration[0]
    check_most("period", period, shortest / LEAST_CYCLES, "s", f"a step lasts {shortest:g} s")
    if dcm_gain is not None:
        why = "an error is gone within a period then"
        check_most("dcm_gain", dcm_gain, 1.0 / period, "1/s", why)
    check_number("double_support", double_support, 0.0, "-")
    if double_support > LONGEST_DOUBLE_SUPPORT:
        raise ParameterError(
            f"`double_support` of at most {LONGEST_DOUBLE_SUPPORT} of the step",
            f"{double_support}",
            "people walk with about 0.2",
        )


def check_leg(robot: Robot, gait: NominalGait) -> None:
    """Refuse a leg that is late in every step of the gait, for a method that knows it.

    Raises:
        VelocityError: the leg is too slow.
    """
    swing, needed = robot.swing, 0.0
    for axis in range(2):
        stride = abs(gait.step(Side.RIGHT)[axis] + gait.step(Side.LEFT)[axis])
        needed = max(needed, time_to(stride, 0.0, swing.max_speed, swing.max_acceleration))
    if needed > gait.step_duration:
        raise VelocityError(
            f"a leg that swings in the {gait.step_duration:.3g} s of a step at {gait.velocity}",
            f"one that takes {needed:.3g} s",
            "walk more slowly, or give the leg its true speed and acceleration",
        )


def tracking_parameters(
    robot: Robot,
    gait: NominalGait,
    dcm_gain: float | None,
    project_zmp: bool,
    double_support: float,
    period: float,
) -> NDArray[np.void]:
    """The `TRACKING` record of a robot and a gait, shape (1,); K_f is the robot's own if None."""
    parameters = new_array(TRACKING)
    record = parameters[0]
    record["omega"] = robot.omega
    record["zmp_gain"] = 1.0 + (DCM_GAIN if dcm_gain is None else dcm_gain / robot.omega)
    record["half_foot"] = robot.foot.half if project_zmp else (math.inf, math.inf)
    record["step_duration"] = record["next_step_duration"] = gait.step_duration
    record["double_support"] = double_support
    for side in Side:
        row = side_index.py_func(side)
        record["start_offset"][row] = gait.start_offset(side)
        record["step_min"][row], record["step_max"][row] = robot.gait.step_box(side, robot.hip)
    swing = record["swing"]
    swing["height"] = robot.swing.height
    # At the nominal pace, the phase of a flight runs from 0 to 1 in the part of a step that both
    # transitions leave.
    flight = gait.step_duration * (1.0 - double_support)
    swing["descent"] = robot.swing.landing_velocity * flight
    swing["max_speed"], swing["period"] = robot.swing.max_speed, period
    swing["max_acceleration"] = robot.swing.max_acceleration
    record["gate"] = gate_parameters(robot, period)[0]
    swing["reach"] = record["gate"]["reach"]
    return parameters


def check_first(observation: Observation) -> None:
    """Refuse a first observation with which no walk can begin.

    Raises:
        ParameterError: it holds a NaN or an infinity, or no side.
    """
    if not is_usable(observation.array[0]):
        raise ParameterError(
            "a first observation of finite numbers and a Side",
            repr(observation),
            "wait for the estimator before starting the controller",
        )


def first_plan(gait: NominalGait, observation: Observation, state: NDArray[np.void]) -> None:
    """Fill plan and command of a new state: on the nominal gait, standing where it is.

    Raises:
        ParameterError: the observation holds a NaN or an infinity, or no side.
    """
    check_first(observation)
    side = observation.support_side
    plan, command = state["plan"][0], state["command"][0]
    plan["support_side"], plan["step_duration"] = side, gait.step_duration
    plan["start_offset"] = gait.start_offset(side)
    plan["growth"] = gait.growth
    plan["end_offset"] = command["dcm_offset"] = gait.dcm_offset(side)
    plan["step"] = gait.step(side)
    command["zmp"] = observation.support_foot
    command["dcm_plan"] = observation.dcm
    command["step_location"] = observation.support_foot + np.asarray(gait.step(side))
    command["step_duration"] = gait.step_duration
    command["swing_foot"] = observation.swing_foot
    first_belief(observation, state)


@dataclass(frozen=True)
class DcmTracking:
    """Footsteps as planned; disturbances are met by the ZMP alone.

    Args:
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        dcm_gain: K_f, rate at which an error decays; 0.857 omega if None [1/s].
        project_zmp: keep the ZMP inside the foot; False shows what the law asks for, as the
            paper's Figs. 5 and 8 do.
        double_support: fraction of the step for which both feet share the load, with a smooth
            plan from foot to foot; 0 for none.
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    robot: Robot
    velocity: tuple[float, float]
    dcm_gain: float | None = None
    project_zmp: bool = True
    double_support: float = 0.0
    step_duration: float | None = None
    period: float = 0.001
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_tracking(self.robot, self.dcm_gain, self.double_support, self.period)
        fill_in(self, dcm_gain=DCM_GAIN * self.robot.omega)
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        parameters = tracking_parameters(
            self.robot,
            gait,
            filled(self.dcm_gain),
            self.project_zmp,
            self.double_support,
            self.period,
        )
        object.__setattr__(self, "parameters", parameters)
        _compiled()  # Now rather than in the first control cycle.

    @property
    def kernel(self) -> Callable[..., None]:
        """The compiled cycle over records."""
        return tracking_cycle

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot on the nominal gait observes at a touchdown; right foot first by default."""
        return self.gait.observation(Side.RIGHT if support_side is None else support_side)

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = new_array(TRACKING_STATE)
        first_plan(self.gait, observation, state)
        return state

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        next_state = new_array(TRACKING_STATE)
        _compiled()(self.parameters, state, observation.array, next_state)
        return Command.of(next_state["command"]), next_state

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)

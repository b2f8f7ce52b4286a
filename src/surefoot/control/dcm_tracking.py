"""Track the planned DCM by moving the ZMP: Eqs. (21)-(25) of [OnlineGait], after [Englsberger2015].

    zmp = zmp_plan + (1 + K_f / omega) (dcm - dcm_plan)

makes the error decay with the rate K_f, as long as the ZMP stays under the foot.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiling import njit
from surefoot.control.cycle import (
    SWING,
    command_swing,
    growth_since_touchdown,
    is_finite,
    side_index,
)
from surefoot.errors import ParameterError
from surefoot.models.footsteps import Side
from surefoot.models.interfaces import COMMAND, Command, Mode, Observation, Status
from surefoot.models.record import new_array
from surefoot.models.robot import Robot
from surefoot.planning.dcm_plan import planned_dcm
from surefoot.planning.double_support import transition
from surefoot.planning.nominal_gait import NominalGait, nominal_gait
from surefoot.planning.support_polygon import nearest_supported

DEFAULT_DCM_GAIN = 3.0
"""K_f, the rate at which tracking removes an error [1/s]."""

TRACKING = np.dtype(
    [
        ("omega", "f8"),
        ("zmp_gain", "f8"),
        ("half_foot", "f8", (2,)),
        ("step_duration", "f8"),
        ("next_step_duration", "f8"),
        ("landing_yaw", "f8"),
        ("double_support", "f8"),
        ("start_offset", "f8", (2, 2)),
        ("step_min", "f8", (2, 2)),
        ("step_max", "f8", (2, 2)),
        ("swing", SWING),
    ],
)
"""Parameters of tracking; the first index of a table is the support side, see `side_index`."""

PLAN = np.dtype(
    [
        ("start_offset", "f8", (2,)),
        ("end_offset", "f8", (2,)),
        ("step", "f8", (2,)),
        ("came_from", "f8", (2,)),
        ("step_duration", "f8"),
        ("growth", "f8"),
        ("opening_before", "f8"),
        ("opening_after", "f8"),
        ("closing_before", "f8"),
        ("closing_after", "f8"),
        ("lift", "f8"),
        ("steps", "i8"),
        ("support_side", "i8"),
        ("closing", "i8"),
        ("adapting", "i8"),
    ],
)
"""What is remembered of the step under way: planned DCM relative to the support foot at its start
and to the landing foot at its end, its step vector, and the foot it came from [m]; its planned
duration [s] and the growth of the DCM in it; how long before and after its first and its last
instant it shares the load with the other foot [s]; the lift of the swing foot [m/s^6]."""

TRACKING_STATE = np.dtype([("plan", PLAN), ("command", COMMAND)])

LONGEST_DOUBLE_SUPPORT = 0.6
"""The largest fraction of a step for which both feet may share the load."""

EDGE_TOLERANCE = 1e-12
"""A ZMP that projection moves no further than this was inside [m]."""

_TRACKING_MODE = int(Mode.TRACKING)
_ZMP_AT_EDGE = int(Status.ZMP_AT_EDGE)
_HELD = int(Status.HELD)


@njit
def hold(state, next_state):
    """The answer to an observation that cannot be trusted: the last command again, and say so."""
    next_state.plan = state.plan
    next_state.command = state.command
    next_state.command.status = _HELD


@njit
def begin_plan(tracking, observation, nominal, plan):
    """Begin the plan of the step that starts with this observation.

    The plan goes on from where it meant to land, so that it does not jump; or, after steps that
    were adapted (`nominal`), from the nominal offset of the new foot.
    """
    plan.support_side = observation.support_side
    plan.steps += 1
    plan.step_duration = tracking.step_duration
    plan.growth = math.exp(tracking.omega * plan.step_duration)
    row = side_index(observation.support_side)
    shared = plan.closing != 0 and not nominal
    plan.opening_before = plan.closing_before if shared else 0.0
    plan.opening_after = plan.closing_after if shared else 0.0
    plan.closing = 0
    for i in range(2):
        plan.start_offset[i] = tracking.start_offset[row, i] if nominal else plan.end_offset[i]
        plan.came_from[i] = observation.swing_foot[i] - observation.support_foot[i]


@njit
def plan_landing(tracking, observation, plan):
    """Plan the step vector, p_next = dcm_plan(T) - d_nom, and the transition that ends the step.

    A new velocity may change d_nom at any time, until the foot is on the ground in the transition.
    """
    if plan.closing != 0:
        return
    row = side_index(observation.support_side)
    for i in range(2):
        dcm_at_end = plan.start_offset[i] * plan.growth
        step = dcm_at_end - tracking.start_offset[1 - row, i]
        plan.step[i] = min(max(step, tracking.step_min[row, i]), tracking.step_max[row, i])
        plan.end_offset[i] = dcm_at_end - plan.step[i]
    plan.closing_before = 0.5 * tracking.double_support * plan.step_duration
    plan.closing_after = 0.5 * tracking.double_support * tracking.next_step_duration
    shared = plan.closing_before > 0.0
    if shared and observation.elapsed >= plan.step_duration - plan.closing_before:
        plan.closing = 1


@njit
def follow_plan(tracking, observation, growth, plan, command) -> float:
    """Write planned DCM and ZMP into the command; return how far the DCM is from its plan [m]."""
    elapsed, omega = observation.elapsed, tracking.omega
    opening = elapsed < plan.opening_after
    command.double_support = 1 if opening or plan.closing != 0 else 0
    for i in range(2):
        foot, start = observation.support_foot[i], plan.start_offset[i]
        dcm, zmp = planned_dcm(0.0, start, growth), 0.0
        if opening:
            back = plan.came_from[i]
            dcm, zmp = transition(
                -back, start - back, omega, plan.opening_before, plan.opening_after, elapsed
            )
            dcm, zmp = dcm + back, zmp + back
        elif plan.closing != 0:
            dcm, zmp = transition(
                plan.step[i],
                start * plan.growth,
                omega,
                plan.closing_before,
                plan.closing_after,
                min(elapsed - plan.step_duration, plan.closing_after),
            )
        command.dcm_plan[i], command.zmp[i] = foot + dcm, foot + zmp
    return math.hypot(
        observation.dcm[0] - command.dcm_plan[0], observation.dcm[1] - command.dcm_plan[1]
    )


@njit
def track(tracking, observation, plan, command):
    """Move the planned ZMP to where it makes the DCM return, and write landing and timing."""
    foot, half = observation.support_foot, tracking.half_foot
    asked_x = command.zmp[0] + tracking.zmp_gain * (observation.dcm[0] - command.dcm_plan[0])
    asked_y = command.zmp[1] + tracking.zmp_gain * (observation.dcm[1] - command.dcm_plan[1])
    away_x, away_y = asked_x - foot[0], asked_y - foot[1]
    if math.isinf(half[0]):
        x, y = away_x, away_y
    else:
        shared = command.double_support != 0
        x, y = nearest_supported(observation, shared, away_x, away_y, half[0], half[1])
    command.mode, command.status = _TRACKING_MODE, 0
    if math.hypot(x - away_x, y - away_y) > EDGE_TOLERANCE:
        command.status |= _ZMP_AT_EDGE
    command.zmp[0], command.zmp[1] = foot[0] + x, foot[1] + y
    command.step_duration = plan.step_duration
    for i in range(2):
        command.step_location[i] = foot[i] + plan.step[i]
        command.dcm_offset[i] = plan.end_offset[i]


@njit
def tracking_cycle(parameters, state, observation, next_state):
    """One cycle of `DcmTracking` over records."""
    if not is_finite(observation):
        hold(state, next_state)
        return
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
    plan.lift = command_swing(
        parameters.swing,
        observation,
        in_the_air,
        parameters.landing_yaw,
        state.command,
        plan.lift,
        new_step,
        command,
    )


@njit
def _tracking_step(parameters, state, observation, next_state):
    tracking_cycle(parameters[0], state[0], observation[0], next_state[0])


def check_double_support(fraction: float) -> None:
    """Refuse a fraction that leaves too little of the step to move the foot in.

    Raises:
        ParameterError: it is not in [0, `LONGEST_DOUBLE_SUPPORT`].
    """
    check_number("double_support", fraction, 0.0, "-")
    if fraction > LONGEST_DOUBLE_SUPPORT:
        raise ParameterError(
            f"`double_support` of at most {LONGEST_DOUBLE_SUPPORT} of the step",
            f"{fraction}",
            "people walk with about 0.2",
        )


def check_robot(robot: Robot) -> None:
    """Refuse what is not a `Robot`.

    Raises:
        ParameterError: it is something else.
    """
    if not isinstance(robot, Robot):
        raise ParameterError("a Robot", repr(robot), 'load one: surefoot.load_robot("paper-biped")')


def tracking_parameters(
    robot: Robot,
    gait: NominalGait,
    dcm_gain: float,
    project_zmp: bool,
    double_support: float,
    period: float,
) -> NDArray[np.void]:
    """The `TRACKING` record of a robot and a gait, shape (1,)."""
    parameters = new_array(TRACKING)
    record = parameters[0]
    record["omega"] = robot.omega
    record["zmp_gain"] = 1.0 + dcm_gain / robot.omega
    record["half_foot"] = robot.foot.half if project_zmp else (math.inf, math.inf)
    record["step_duration"] = record["next_step_duration"] = gait.step_duration
    record["double_support"] = double_support
    for side in Side:
        row = side_index.py_func(side)
        record["start_offset"][row] = gait.start_offset(side)
        record["step_min"][row], record["step_max"][row] = robot.gait.step_box(side, robot.hip)
    swing = record["swing"]
    swing["height"], swing["landing_velocity"] = robot.swing.height, robot.swing.landing_velocity
    swing["max_speed"], swing["period"] = robot.swing.max_speed, period
    return parameters


def first_plan(gait: NominalGait, observation: Observation, state: NDArray[np.void]) -> None:
    """Fill plan and command of a new state: on the nominal gait, standing where it is.

    Raises:
        ParameterError: the observation holds a NaN or an infinity, or no side.
    """
    known = observation.array["support_side"][0] in tuple(Side)
    if not (known and is_finite.py_func(observation)):
        raise ParameterError(
            "a first observation of finite numbers and a Side",
            repr(observation),
            "wait for the estimator before starting the controller",
        )
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


@dataclass(frozen=True)
class DcmTracking:
    """Footsteps as planned; disturbances are met by the ZMP alone.

    Args:
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        dcm_gain: K_f, rate at which an error decays [1/s].
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
    dcm_gain: float = DEFAULT_DCM_GAIN
    project_zmp: bool = True
    double_support: float = 0.0
    step_duration: float | None = None
    period: float = 0.001
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_robot(self.robot)
        check_number("dcm_gain", self.dcm_gain, 0.0, "1/s", above=True)
        check_number("period", self.period, 0.0, "s", above=True)
        check_double_support(self.double_support)
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        parameters = tracking_parameters(
            self.robot,
            gait,
            self.dcm_gain,
            self.project_zmp,
            self.double_support,
            self.period,
        )
        object.__setattr__(self, "parameters", parameters)
        if not _tracking_step.signatures:
            # Compile, or load from the cache, now rather than in the first control cycle.
            observation = gait.observation(Side.RIGHT)
            self.step(self.start(observation), observation)

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
        _tracking_step(self.parameters, state, observation.array, next_state)
        return Command.of(next_state["command"]), next_state

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)

"""Track the planned DCM by moving the ZMP: Eqs. (20)-(25) of [OnlineGait], after [Englsberger2015].

    zmp = zmp_plan + (1 + K_f / omega) (dcm - dcm_plan)

makes the error decay with the rate K_f, as long as the ZMP stays under the foot. Plan and law are
shared by every controller that tracks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_most
from surefoot.compiled import njit
from surefoot.control.base import CompiledController
from surefoot.control.belief import BELIEF, hold, look, mark
from surefoot.control.cycle import SWING, command_swing, growth_since_touchdown, side_index
from surefoot.control.defaults import DCM_GAIN
from surefoot.control.fields import setting
from surefoot.control.plausibility import GATE, gate_parameters
from surefoot.control.registry import method, variant
from surefoot.dcm.dcm_plan import planned_dcm, transition
from surefoot.dcm.nominal_gait import NominalGait
from surefoot.dcm.support import nearest_supported
from surefoot.errors import ParameterError
from surefoot.geometry import length
from surefoot.interface import COMMAND, Mode, Status
from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

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
        ("gate", GATE),
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
        ("phase", "f8", (3,)),
        ("steps", "i8"),
        ("support_side", "i8"),
        ("closing", "i8"),
        ("adapting", "i8"),
    ],
)
"""What is remembered of the step under way: planned DCM relative to the support foot at its start
and to the landing foot at its end, its step vector, and the foot it came from [m]; its planned
duration [s] and the growth of the DCM in it; how long before and after its first and its last
instant it shares the load with the other foot [s]; the phase of the swing foot's flight with its
derivatives [-, 1/s, 1/s^2]; steps so far."""

TRACKING_STATE = np.dtype([("plan", PLAN), ("belief", BELIEF), ("command", COMMAND)])

NO_GAIN = 0.0
"""For methods that take over the records of tracking, but not its law [1/s]."""

LONGEST_DOUBLE_SUPPORT = 0.6
"""The largest fraction of a step for which both feet may share the load."""

EDGE_TOLERANCE = 1e-11
"""A ZMP that projection moves no further than this part of half a sole was inside; where the sole
may be a point, of how far the feet can be apart."""

_TRACKING_MODE = int(Mode.TRACKING)
_ZMP_AT_EDGE = int(Status.ZMP_AT_EDGE)


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


@njit(forceinline=True)
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


@njit(forceinline=True)
def keep_box(tracking, observation, command):
    """Move the landing into the box of steps; a leg that comes short of it there is UNREACHABLE."""
    row = side_index(observation.support_side)
    for i in range(2):
        foot = observation.support_foot[i]
        step = command.step_location[i] - foot
        if step < tracking.step_min[row, i]:
            command.step_location[i] = foot + tracking.step_min[row, i]
        elif step > tracking.step_max[row, i]:
            command.step_location[i] = foot + tracking.step_max[row, i]


@njit(forceinline=True)
def follow_plan(tracking, observation, growth, plan, command) -> float:
    """Write planned DCM and ZMP into the command; return how far the DCM is from its plan [m]."""
    elapsed, omega = observation.elapsed, tracking.omega
    opening = plan.opening_after > 0.0 and elapsed < plan.opening_after
    command.double_support = 1 if opening or plan.closing != 0 else 0
    for i in range(2):
        foot, start = observation.support_foot[i], plan.start_offset[i]
        dcm, zmp = planned_dcm(0.0, start, growth), 0.0
        if opening:
            back = plan.came_from[i]
            dcm, zmp = transition(
                -back,
                start - back,
                omega,
                plan.opening_before,
                plan.opening_after,
                max(elapsed, 0.0),
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
    return length(
        observation.dcm[0] - command.dcm_plan[0], observation.dcm[1] - command.dcm_plan[1]
    )


@njit(forceinline=True)
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
    if length(x - away_x, y - away_y) > EDGE_TOLERANCE * length(half[0], half[1]):
        command.status |= _ZMP_AT_EDGE
    command.zmp[0], command.zmp[1] = foot[0] + x, foot[1] + y
    command.step_duration = plan.step_duration
    for i in range(2):
        command.step_location[i] = foot[i] + plan.step[i]
        command.dcm_offset[i] = plan.end_offset[i]


@njit(forceinline=True)
def plan_step(tracking, state, next_state):
    """Begin the plan at a touchdown, plan the landing, and write planned DCM and ZMP.

    Args:
        tracking: a `TRACKING` record.
        state: of the cycle before.
        next_state: of this cycle; its belief already has the observation.

    Returns:
        Whether this is the first cycle of a step; e^(omega t), the growth since the touchdown.
    """
    next_state.plan = state.plan
    plan, observation = next_state.plan, next_state.belief.seen
    new_step = observation.support_side != plan.support_side
    if new_step:
        begin_plan(tracking, observation, plan.adapting != 0, plan)
        plan.adapting = 0
    plan_landing(tracking, observation, plan)
    growth = growth_since_touchdown(tracking.omega, observation.elapsed)
    follow_plan(tracking, observation, growth, plan, next_state.command)
    return new_step, growth


@njit(forceinline=True)
def end_cycle(tracking, in_the_air, new_step, state, next_state):
    """Complete the command of a cycle: move the swing foot, and say HELD if something is guessed.

    Args:
        tracking: a record with `swing` and `landing_yaw`, such as `TRACKING`.
        in_the_air: when the foot leaves the ground and when it is back, since touchdown [s].
        new_step: whether this is the first cycle of a step.
        state: of the cycle before.
        next_state: of this cycle; its command already has landing and timing.
    """
    command_swing(
        tracking.swing,
        next_state.belief.seen,
        in_the_air,
        tracking.landing_yaw,
        state.command,
        next_state.plan.phase,
        new_step,
        next_state.command,
    )
    mark(next_state)


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
    new_step, _ = plan_step(parameters, state, next_state)
    plan = next_state.plan
    track(parameters, next_state.belief.seen, plan, next_state.command)
    in_the_air = plan.opening_after, plan.step_duration - plan.closing_before
    end_cycle(parameters, in_the_air, new_step, state, next_state)


@njit
def _tracking_step(parameters, state, observation, next_state):
    tracking_cycle(parameters[0], state[0], observation[0], next_state[0])


def check_gain(dcm_gain: float | None, period: float) -> None:
    """Refuse a gain with which an error would be gone within a control period.

    Raises:
        ParameterError: it is too large.
    """
    if dcm_gain is not None:
        why = "an error is gone within a period then"
        check_most("dcm_gain", dcm_gain, 1.0 / period, "1/s", why)


def check_double_support(double_support: float) -> None:
    """Refuse a double support that leaves too little of the step to move the foot in.

    Raises:
        ParameterError: it is too long.
    """
    if double_support > LONGEST_DOUBLE_SUPPORT:
        raise ParameterError(
            f"`double_support` of at most {LONGEST_DOUBLE_SUPPORT} of the step",
            f"{double_support}",
            "people walk with about 0.2",
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


@method(
    "tracking",
    label="DCM tracking, K_f = 3",
    source="Englsberger, Ott, Albu-Schäffer 2015",
    adapts="ZMP",
    cannot="steps as planned: neither where nor when it steps answers a push",
    cites=("Englsberger2015",),
    order=10,
    fixed_steps=True,
)
@dataclass(frozen=True)
class DcmTracking(
    CompiledController,
    cycle=tracking_cycle,
    arrays=_tracking_step,
    parameters=TRACKING,
    state=TRACKING_STATE,
):
    """Footsteps as planned; disturbances are met by the ZMP alone.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    dcm_gain: float | None = setting(
        None, "1/s", "K_f, rate at which an error decays; 0.857 omega if None",
        above=0.0, search=(0.5, 100.0),
    )  # fmt: skip
    project_zmp: bool = setting(
        True, "", "keep the ZMP inside the foot; False shows what the law asks for, as the paper's "
        "Figs. 5 and 8 do",
    )  # fmt: skip
    double_support: float = setting(
        0.0, "-", "fraction of the step for which both feet share the load, with a smooth plan "
        "from foot to foot; 0 for none", least=0.0,
    )  # fmt: skip

    def check(self) -> None:
        """Refuse a gain that is too large, and a double support that is too long."""
        check_gain(self.dcm_gain, self.period)
        check_double_support(self.double_support)

    def defaults(self) -> dict[str, float]:
        """K_f."""
        return {"dcm_gain": DCM_GAIN * self.robot.omega}

    def make_parameters(self) -> NDArray[np.void]:
        """The `TRACKING` record."""
        return tracking_parameters(
            self.robot, self.gait, self.dcm_gain, self.project_zmp, self.double_support, self.period
        )


STIFF = variant(
    DcmTracking,
    "tracking-stiff",
    label="DCM tracking, K_f = 30",
    source="Englsberger, Ott, Albu-Schäffer 2015; ten times the paper's gain",
    order=11,
    rates={"dcm_gain": 10.0 * DCM_GAIN},
)

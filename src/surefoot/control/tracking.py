"""Track the planned DCM by moving the ZMP: Eqs. (20)-(25) of [OnlineGait], after [Englsberger2015].

    zmp = zmp_plan + (1 + K_f / omega) (dcm - dcm_plan)

makes the error decay with the rate K_f, as long as the ZMP stays under the foot. Plan and law are
shared by every controller that tracks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from surefoot.compiled import njit
from surefoot.control.base import CompiledController, GaitController
from surefoot.control.cycle import (
    SwingParameters,
    end_cycle,
    growth_since_touchdown,
    side_index,
)
from surefoot.control.defaults import DCM_GAIN, dcm_gain, double_support
from surefoot.control.fields import filled, setting
from surefoot.control.plausibility import Gate, gate_parameters
from surefoot.control.registry import method, variant
from surefoot.control.validation import Validated, validate
from surefoot.dcm.dcm_plan import planned_dcm, transition
from surefoot.dcm.support import nearest_supported
from surefoot.geometry import length
from surefoot.interface import Command, Mode, Status
from surefoot.record import Array, Record, Vector2, Vector3, field
from surefoot.robot.feet import Side


class Tracking(Record):
    """Parameters of tracking; the first index of a table is the support side, see `side_index`."""

    omega: float = field("1/s", "natural frequency")
    zmp_gain: float = field("-", "1 + K_f / omega")
    half_foot: Vector2 = field("m", "how far the ZMP may be from the centre of the sole")
    step_duration: float = field("s", "of the step under way")
    next_step_duration: float = field("s", "of the step after it")
    landing_yaw: float = field("rad", "heading with which the foot lands", default=0.0)
    double_support: float = field("-", "part of a step for which both feet share the load")
    start_offset: Array = field("m", "nominal DCM offset after a touchdown", shape=(2, 2))
    step_min: Array = field("m", "least step vector", shape=(2, 2))
    step_max: Array = field("m", "largest step vector", shape=(2, 2))
    swing: SwingParameters = field("", "of the swing foot")
    gate: Gate = field("", "of observations")


class Plan(Record):
    """What is remembered of the step under way."""

    start_offset: Vector2 = field("m", "planned DCM at its start, relative to the support foot")
    end_offset: Vector2 = field("m", "and at its end, relative to the landing foot")
    step: Vector2 = field("m", "from the support foot to the landing")
    came_from: Vector2 = field("m", "from the support foot to the last one")
    step_duration: float = field("s", "planned")
    growth: float = field("-", "of the DCM in that time")
    opening_before: float = field("s", "of its first transition, before its start")
    opening_after: float = field("s", "and after it")
    closing_before: float = field("s", "of its last transition, before its end")
    closing_after: float = field("s", "and after it")
    phase: Vector3 = field("-, 1/s, 1/s^2", "of the swing foot's flight, with its derivatives")
    steps: int = field("", "so far")
    support_side: int = field("", "which foot is on the ground")
    closing: int = field("", "1 in its last transition")
    adapting: int = field("", "1 once the plan has been dropped")


class TrackingState(Record):
    """What a controller remembers that tracks a plan."""

    plan: Plan = field("", "of the step under way")
    validated: Validated = field("", "the observation")
    command: Command = field("", "of the last cycle")


NO_GAIN = 0.0
"""Of methods that use the plan of tracking, but not its law [1/s]."""

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
        tracking: a `Tracking` record.
        state: of the cycle before.
        next_state: of this cycle, with the observation that was validated.

    Returns:
        Whether this is the first cycle of a step; e^(omega t), the growth since the touchdown.
    """
    new_step, growth = _begin_step(tracking, state, next_state)
    plan, observation = next_state.plan, next_state.validated.observation
    plan_landing(tracking, observation, plan)
    follow_plan(tracking, observation, growth, plan, next_state.command)
    return new_step, growth


@njit(forceinline=True)
def plan_or_drop(tracking, threshold, state, next_state):
    """Like `plan_step`, but a DCM error past the threshold [m] drops the plan until a touchdown."""
    new_step, growth = _begin_step(tracking, state, next_state)
    plan, observation = next_state.plan, next_state.validated.observation
    if plan.adapting == 0:
        plan_landing(tracking, observation, plan)
    error = follow_plan(tracking, observation, growth, plan, next_state.command)
    # A foot that is on the ground already cannot be sent elsewhere.
    if error >= threshold and plan.closing == 0:
        plan.adapting = 1
    return new_step, growth


@njit(forceinline=True)
def _begin_step(tracking, state, next_state):
    """Go on with the plan, or begin it anew at a touchdown; see `plan_step`."""
    next_state.plan = state.plan
    plan, observation = next_state.plan, next_state.validated.observation
    new_step = observation.support_side != plan.support_side
    if new_step:
        begin_plan(tracking, observation, plan.adapting != 0, plan)
        plan.adapting = 0
    return new_step, growth_since_touchdown(tracking.omega, observation.elapsed)


@njit(forceinline=True)
def track_to_end(tracking, new_step, state, next_state):
    """The rest of a cycle after `plan_step` that tracks."""
    plan = next_state.plan
    track(tracking, next_state.validated.observation, plan, next_state.command)
    in_the_air = plan.opening_after, plan.step_duration - plan.closing_before
    end_cycle(tracking, in_the_air, new_step, state, next_state)


@njit
def tracking_cycle(parameters, state, observation, next_state):
    """One cycle of `DcmTracking` over records."""
    if validate(parameters.gate, state, observation, next_state):
        new_step, _ = plan_step(parameters, state, next_state)
        track_to_end(parameters, new_step, state, next_state)


def tracking_parameters(
    controller: GaitController,
    *,
    dcm_gain: float | None = NO_GAIN,
    project_zmp: bool = True,
    double_support: float = 0.0,
) -> Tracking:
    """The parameters of a controller.

    Args:
        controller: of which robot, gait and period are read.
        dcm_gain: K_f, if its ZMP tracks the plan [1/s].
        project_zmp: whether that stays inside the foot.
        double_support: fraction of a step for which both feet share the load.
    """
    robot, gait, period = controller.robot, controller.gait, controller.period
    gate, swing = gate_parameters(robot, period), robot.swing
    # By support side, right first.
    sides = Side.RIGHT, Side.LEFT
    boxes = [robot.gait.step_box(side, robot.hip) for side in sides]
    # At the nominal pace, the phase of a flight runs from 0 to 1 in the part of a step that both
    # transitions leave.
    flight = gait.step_duration * (1.0 - double_support)
    return Tracking(
        omega=robot.omega,
        zmp_gain=1.0 + filled(dcm_gain) / robot.omega,
        half_foot=robot.foot.half if project_zmp else (math.inf, math.inf),
        step_duration=gait.step_duration,
        next_step_duration=gait.step_duration,
        double_support=double_support,
        start_offset=[gait.start_offset(side) for side in sides],
        step_min=[low for low, _ in boxes],
        step_max=[high for _, high in boxes],
        swing=SwingParameters(
            height=swing.height,
            descent=swing.landing_velocity * flight,
            max_speed=swing.max_speed,
            max_acceleration=swing.max_acceleration,
            period=period,
            reach=gate.reach,
        ),
        gate=gate,
    )


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
    CompiledController, cycle=tracking_cycle, parameters=Tracking, state=TrackingState
):
    """Footsteps as planned; disturbances are met by the ZMP alone.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    dcm_gain: float | None = dcm_gain("an error decays", search=(0.5, 100.0))
    project_zmp: bool = setting(
        True, "", "keep the ZMP inside the foot; False shows what the law asks for, as the paper's "
        "Figs. 5 and 8 do",
    )  # fmt: skip
    double_support: float = double_support(
        "fraction of the step for which both feet share the load, with a smooth plan from foot to "
        "foot; 0 for none"
    )

    def make_parameters(self) -> Tracking:
        """Those of the robot and its gait."""
        return tracking_parameters(
            self,
            dcm_gain=self.dcm_gain,
            project_zmp=self.project_zmp,
            double_support=self.double_support,
        )


STIFF = variant(
    DcmTracking,
    "tracking-stiff",
    label="DCM tracking, K_f = 30",
    source="Englsberger, Ott, Albu-Schäffer 2015; ten times the paper's gain",
    order=11,
    rates={"dcm_gain": 10.0 * DCM_GAIN},
)

"""The law of DCM tracking over records: plan the step, compare the DCM with it, move the ZMP.

Eqs. (20)-(25) of [OnlineGait], after [Englsberger2015]; shared by every controller that tracks.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit
from surefoot.control.cycle import SWING, side_index
from surefoot.control.plausibility import GATE
from surefoot.dcm.dcm_plan import planned_dcm, transition
from surefoot.dcm.support import nearest_supported
from surefoot.geometry import length
from surefoot.interface import Mode, Status

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

EDGE_TOLERANCE = 1e-11
"""A ZMP that projection moves no further than this part of half a sole was inside."""

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

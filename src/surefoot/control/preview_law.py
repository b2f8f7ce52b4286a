"""The law of ZMP preview control over records: what the regulator asks for, and the twin it walks.

After [Kajita2003]; everything here is relative to the support foot.
"""

from __future__ import annotations

import numpy as np

from surefoot.compiled import njit
from surefoot.control.belief import BELIEF
from surefoot.control.cycle import LAST_CYCLE, SWING, side_index
from surefoot.control.plausibility import GATE
from surefoot.control.tracking_law import EDGE_TOLERANCE
from surefoot.dcm.pendulum import com_flow
from surefoot.dcm.support import nearest_under_foot
from surefoot.interface import COMMAND

MOST_SAMPLES = 2000
"""The longest preview, in control periods."""

PREVIEW_PLAN = np.dtype(
    [
        ("com", "f8", (2,)),
        ("com_velocity", "f8", (2,)),
        ("zmp", "f8", (2,)),
        ("zmp_sum", "f8", (2,)),
        ("measured_sum", "f8", (2,)),
        ("step", "f8", (2,)),
        ("step_duration", "f8"),
        ("elapsed", "f8"),
        ("phase", "f8", (3,)),
        ("support_side", "i8"),
    ],
)
"""The undisturbed twin, relative to the support foot: CoM [m, m/s], ZMP from now on, and the sum of
its errors [m]. That sum for the robot itself [m]. The step under way: its vector [m], its duration,
the time up to which the twin has walked [s], the phase of the swing foot's flight with its
derivatives [-, 1/s, 1/s^2], and the foot that stands."""

PREVIEW = np.dtype(
    [
        ("omega", "f8"),
        ("period", "f8"),
        ("half_foot", "f8", (2,)),
        ("integral_gain", "f8"),
        ("state_gain", "f8", (3,)),
        ("step_gain", "f8", (MOST_SAMPLES + 1,)),
        ("samples", "i8"),
        ("step_duration", "f8"),
        ("step", "f8", (2, 2)),
        ("landing_yaw", "f8"),
        ("swing", SWING),
        ("gate", GATE),
        ("start", PREVIEW_PLAN, (2,)),
        ("start_zmp", "f8", (2, 2)),
        ("end_offset", "f8", (2, 2)),
    ],
)
"""Parameters. `step_gain[n]` is what a step counts that is taken n samples from now: the sum of
G_p(l) over l > n. By support side: the step vectors [m], the periodic plan at touchdown, the ZMP
that acted just before it, relative to the foot that stands then, and the DCM offset of the periodic
gait at the end of the step [m]."""

PREVIEW_STATE = np.dtype([("plan", PREVIEW_PLAN), ("belief", BELIEF), ("command", COMMAND)])


@njit
def preview_steps(parameters, plan, elapsed):
    """The part of the jerk that the steps ahead ask for (x, y) [m/s^3].

    The reference is constant from step to step, so that each step counts with the sum of all gains
    behind it. A touchdown between two samples counts in proportion.
    """
    ahead_x, ahead_y = 0.0, 0.0
    step_x, step_y, side = plan.step[0], plan.step[1], plan.support_side
    lead = max(plan.step_duration - elapsed, 0.0) / parameters.period
    while lead < parameters.samples:
        n = int(lead)
        share = lead - n
        gain = (1.0 - share) * parameters.step_gain[n] + share * parameters.step_gain[n + 1]
        ahead_x, ahead_y = ahead_x + gain * step_x, ahead_y + gain * step_y
        side = -side
        row = side_index(side)
        step_x, step_y = parameters.step[row, 0], parameters.step[row, 1]
        lead += parameters.step_duration / parameters.period
    return ahead_x, ahead_y


@njit
def _asked_zmp(parameters, com, com_velocity, zmp, zmp_sum, ahead):
    """The ZMP that the regulator asks for, one axis, relative to the support foot [m]."""
    t, per_omega = parameters.period, 1.0 / (parameters.omega * parameters.omega)
    gain = parameters.state_gain
    acceleration = (com - zmp) / per_omega
    jerk = ahead - parameters.integral_gain * zmp_sum
    jerk -= gain[0] * com + gain[1] * com_velocity + gain[2] * acceleration
    next_com = com + t * (com_velocity + t * (0.5 * acceleration + t * jerk / 6.0))
    return next_com - (acceleration + t * jerk) * per_omega


@njit
def regulate(parameters, plan, yaw, elapsed, com, com_velocity, zmp, zmp_sum):
    """One sample of the regulator; everything is relative to the support foot.

    Args:
        parameters: a `PREVIEW` record.
        plan: the footsteps, a `PREVIEW_PLAN` record.
        yaw: heading of the sole [rad].
        elapsed: time since touchdown [s].
        com, com_velocity: now (x, y) [m, m/s].
        zmp: what acted until now (x, y), and what acts from now on: written [m].
        zmp_sum: of the errors of the ZMP so far (x, y), written [m].

    Returns:
        Whether the sole limits the ZMP.
    """
    half = parameters.half_foot
    ahead_x, ahead_y = preview_steps(parameters, plan, elapsed)
    # Under the foot that has just landed, the ZMP is where it was, or as near as the sole allows.
    zmp[0], zmp[1] = nearest_under_foot(zmp[0], zmp[1], half[0], half[1], yaw)
    sum_x, sum_y = zmp_sum[0] + zmp[0], zmp_sum[1] + zmp[1]
    asked_x = _asked_zmp(parameters, com[0], com_velocity[0], zmp[0], sum_x, ahead_x)
    asked_y = _asked_zmp(parameters, com[1], com_velocity[1], zmp[1], sum_y, ahead_y)
    zmp[0], zmp[1] = nearest_under_foot(asked_x, asked_y, half[0], half[1], yaw)
    cut_x = abs(zmp[0] - asked_x) > EDGE_TOLERANCE
    cut_y = abs(zmp[1] - asked_y) > EDGE_TOLERANCE
    if not cut_x:
        zmp_sum[0] = sum_x
    if not cut_y:
        zmp_sum[1] = sum_y
    return cut_x or cut_y


@njit
def regulate_plan(parameters, yaw, plan):
    """One sample of the twin."""
    regulate(
        parameters, plan, yaw, plan.elapsed, plan.com, plan.com_velocity, plan.zmp, plan.zmp_sum
    )


@njit
def walk_plan(parameters, until, yaw, plan):
    """Walk the twin on within the step, in cycles like the robot's, also those that were missed."""
    until = min(until, plan.step_duration)
    while until - plan.elapsed > LAST_CYCLE * parameters.period:
        time = until - plan.elapsed
        if time > (1.0 + LAST_CYCLE) * parameters.period:
            time = parameters.period
        for i in range(2):
            plan.com[i], plan.com_velocity[i] = com_flow(
                plan.com[i], plan.com_velocity[i], plan.zmp[i], parameters.omega, time
            )
        plan.elapsed += time
        if plan.step_duration - plan.elapsed > LAST_CYCLE * parameters.period:
            regulate_plan(parameters, yaw, plan)


@njit
def land_plan(parameters, support_side, plan):
    """The twin lands where it was to land; from there its next step is the nominal one."""
    for i in range(2):
        plan.com[i] -= plan.step[i]
        plan.zmp[i] -= plan.step[i]
        plan.step[i] = parameters.step[side_index(support_side), i]
    plan.step_duration, plan.elapsed = parameters.step_duration, 0.0
    plan.support_side = support_side

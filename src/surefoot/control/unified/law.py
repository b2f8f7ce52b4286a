"""The law of the unified controller over records: assess, decide, and place the ZMP.

See `control.unified.controller`; the landing is decided by `control.unified.solver`.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit
from surefoot.control.cycle import MAX_EXPONENT
from surefoot.control.unified.anticipation import anticipate, corner_time, saved_share
from surefoot.control.unified.problem import Limit, saved_after, soft_error
from surefoot.dcm.support import nearest_under_foot
from surefoot.interface import Mode, Status

MOVED = 1e-6
"""A landing that differs from the plan by less than this part of the step box, or of the planned
duration, is the planned one."""

_ZMP = (int(Limit.ZMP_X), int(Limit.ZMP_Y))
_LOST = int(Limit.LOST)
_TRACKING_MODE, _ADAPTING = int(Mode.TRACKING), int(Mode.ADAPTING)
_OFFSET_VIOLATED, _NO_TIME_LEFT = int(Status.OFFSET_VIOLATED), int(Status.NO_TIME_LEFT)
_ZMP_AT_EDGE = int(Status.ZMP_AT_EDGE)


@njit(forceinline=True)
def mirror(support_side, axis):
    """+1, or -1 where the axis counts towards the swing foot and that is to the right."""
    return float(support_side) if axis == 1 else 1.0


@njit
def assess(parameters, observation, plan, last_duration, force, situation, decision):
    """Write the situation: where everything is, and what the push may still do."""
    landing, omega = parameters.landing, parameters.landing.omega
    elapsed = min(max(observation.elapsed, 0.0), MAX_EXPONENT / omega)
    fastest = landing.max_speed
    for i in range(2):
        side = mirror(observation.support_side, i)
        foot = observation.support_foot[i]
        situation.offset[i] = side * (observation.dcm[i] - foot)
        situation.foot[i] = side * (observation.swing_foot[i] - foot)
        # A foot that is measured a little faster than it can be.
        velocity = min(max(observation.swing_foot_velocity[i], -fastest), fastest)
        situation.foot_velocity[i] = side * velocity
        situation.step_ref[i], situation.offset_ref[i] = (
            side * plan.step[i],
            side * plan.end_offset[i],
        )
        decision.force[i] = force[i]
    soonest = max(landing.shortest, elapsed, min(last_duration, elapsed + parameters.commitment))
    latest = max(landing.longest, soonest)
    for i in range(2):
        # A foot beside the step box has to be back in it.
        low, high = landing.step_min[i], landing.step_max[i]
        if landing.max_acceleration == math.inf and not low <= situation.foot[i] <= high:
            edge = low if situation.foot[i] < low else high
            back = elapsed + corner_time(landing, situation, i, edge)
            soonest = min(max(soonest, back), latest)
    situation.elapsed, situation.tau_ref = elapsed, plan.growth
    situation.tau_min, situation.tau_max = math.exp(omega * soonest), math.exp(omega * latest)
    situation.earliest, situation.latest = soonest - elapsed, latest - elapsed
    for i in range(2):
        # Of the push as observed, what is expected to go on.
        side = mirror(observation.support_side, i)
        situation.force[i] = side * force[i] * parameters.anticipation
    push_x, push_y = situation.force[0], situation.force[1]
    share = saved_share(landing, situation, push_x, push_y)
    decision.share = share
    anticipate(landing, situation, share * push_x, share * push_y)


@njit(forceinline=True)
def needed_zmp(landing, situation, axis, growth, place):
    """The interval in which the ZMP has to stay for the reserve to be kept, inside the sole [m].

    For a ZMP at u until the landing, v = e' k - u (k - 1) - c - X - Z along the axis.
    """
    reach, take = landing.zmp_reach[axis], growth - 1.0
    offset = situation.anticipated[axis]
    along, _ = saved_after(landing, axis, 0, place)
    against, _ = saved_after(landing, axis, 1, place)
    # A ZMP can be taken back, so it is only asked what the push may do if it goes on.
    over = (offset - reach) * growth - place - along
    under = -(offset + reach) * growth + place - against
    low, high = -reach, reach
    # There the ZMP is at the edge: what that leaves of the reserve need not be taken.
    room = -(over + landing.reserve[axis])
    if room < 2.0 * reach * take:
        low = reach if room <= 0.0 else reach - room / take
    room = -(under + landing.reserve[axis])
    if room < 2.0 * reach * take:
        high = -reach if room <= 0.0 else room / take - reach
    if low > high:
        # Both sides in danger: the middle.
        low = high = min(max(0.5 * (low + high), -reach), reach)
    return low, high


@njit(forceinline=True)
def gentle_range(parameters, situation, axis, growth, decision):
    """How far the ZMP may move while nothing is in danger [m].

    Further than c_g by what the landing leaves of the error: next to nothing while the landing is
    free to move, and all of the sole where it is not.
    """
    landing, place = parameters.landing, decision.step[axis]
    rest = abs(soft_error(landing, situation, axis, growth, place))
    gentle = landing.gentle_zmp[axis] + parameters.tracking.zmp_gain * rest
    return min(gentle, landing.zmp_reach[axis])


@njit(forceinline=True)
def place_zmp(parameters, observation, situation, decision, command):
    """Write ZMP and expected offset: follow the plan gently, or as the reserve demands."""
    tracking, landing = parameters.tracking, parameters.landing
    growth = decision.tau * math.exp(-landing.omega * situation.elapsed)
    for i in range(2):
        side, foot = mirror(observation.support_side, i), observation.support_foot[i]
        asked = tracking.zmp_gain * side * (observation.dcm[i] - command.dcm_plan[i])
        reach = landing.zmp_reach[i]
        gentle = gentle_range(parameters, situation, i, growth, decision)
        zmp = min(max(asked, -gentle), gentle)
        low, high = needed_zmp(landing, situation, i, growth, decision.step[i])
        zmp = min(max(zmp, low), high)
        if reach > 0.0 and abs(zmp) >= reach:
            decision.active |= _ZMP[i]
            command.status |= _ZMP_AT_EDGE
        command.zmp[i] = foot + side * zmp
    half, foot, yaw = landing.zmp_reach, observation.support_foot, observation.support_yaw
    if yaw != 0.0:
        x, y = command.zmp[0] - foot[0], command.zmp[1] - foot[1]
        x, y = nearest_under_foot(x, y, half[0], half[1], yaw)
        command.zmp[0], command.zmp[1] = foot[0] + x, foot[1] + y
    for i in range(2):
        side = mirror(observation.support_side, i)
        decision.zmp[i] = side * (command.zmp[i] - foot[i])
        at_end = decision.zmp[i] + (situation.offset[i] - decision.zmp[i]) * growth
        command.dcm_offset[i] = side * (at_end - decision.step[i])


@njit(forceinline=True)
def command_landing(landing, observation, plan, decision, command):
    """Write place and time of the landing, and whether they are those of the plan."""
    duration = plan.step_duration
    if decision.tau != plan.growth:
        duration = max(math.log(decision.tau) / landing.omega, observation.elapsed)
    adapted = abs(duration - plan.step_duration) > MOVED * plan.step_duration
    for i in range(2):
        step = mirror(observation.support_side, i) * decision.step[i]
        box = landing.step_max[i] - landing.step_min[i]
        adapted = adapted or abs(step - plan.step[i]) > MOVED * box
        command.step_location[i] = observation.support_foot[i] + step
    command.step_duration = duration
    if adapted:
        plan.adapting = 1
    command.mode = _ADAPTING if adapted else _TRACKING_MODE
    command.double_support = 0
    command.status = 0
    if observation.elapsed > max(landing.longest, plan.step_duration):
        command.status |= _NO_TIME_LEFT
    if decision.active & _LOST:
        command.status |= _OFFSET_VIOLATED

"""The value of a schedule of landings for a push, both axes at once.

Both axes land together. For given times T_1, T_2, ... of the next landings each axis is a problem
of its own, and a convex one: as far as the foot gets in T_k, step by step backwards,

    D_k(L) = e^(-omega T_k) max over l of (l + D_(k+1)(l)),      |l + L| <= way of the leg in T_k,

and across likewise with alternating sides: `dcm.viable_displacement` with the times fixed. A
schedule is the times of a few landings and a period for all that follow. Its value is attained, by
the landings that it consists of.

If it is not known when the push ends, there is one demand more: at every instant of the push the
robot must be viable without it. Counted along the push, a landing at l takes l off the offset e of
the DCM, and right after a landing at L, with the push going on for r more, e has to lie in

    -(lo_k + c) <= e <= hi_k + c,
    hi_k(L) = e^(-omega T) max over l of (l + hi_(k+1)(l)) - f (1 - e^(-omega min(r, T))),
    lo_k(L) = e^(-omega T) max over l of (-l + lo_(k+1)(l)) + f (1 - e^(-omega T)), or, if less,
              Z_against(L); that alone where the push ends before the next landing.

hi is what the rest of the push leaves, lo what can be saved if it ends now, or goes on. So the rest
of the push has to fit between both ends of what can be saved: where it does not, hi + lo + 2 c < 0,
the foot must not land yet. Own derivation.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.dcm.leg import arrival, furthest, reach
from surefoot.dcm.viable_displacement import (
    BEHIND,
    NODES,
    displacement_to_come,
    interpolate,
    viable_displacement,
)
from surefoot.record import Array, Record, Vector2, field
from surefoot.robot.robot import Robot

PERIODS = 25
"""For how many periods there are tables of evenly timed steps."""

OUT_OF_REACH = -1e5
"""The value of a step from which no landing is in reach, in intervals between nodes; finite, to be
interpolated [-]."""

BOTH = -1
"""Instead of the number of the only axis that counts."""

_SETTLED = 1e-10
"""Evenly timed steps are done with when no value moves further, in intervals between nodes [-]."""


class PushState(Record):
    """A push that begins now, from the support foot: x, and y towards the swing foot."""

    offset: Vector2 = field("m", "of the DCM")
    foot: Vector2 = field("m", "the swing foot")
    foot_velocity: Vector2 = field("m/s", "its velocity")
    direction: Vector2 = field("-", "of the push, a unit vector")
    zmp_reach: Vector2 = field("m", "how far the ZMP moves")
    elapsed: float = field("s", "time since touchdown")
    duration: float = field("s", "of the push, where that matters", default=0.0)
    alone: int = field("", "the only axis that counts, or `BOTH`", default=BOTH)


class Workspace(Record):
    """What the value of a schedule is worked out in."""

    stages: Array = field("m", "two stages in turn, as in `values`", shape=(2, 2, 2, NODES))
    tail: Array = field("m", "tables of what follows the schedule", shape=(2, 2, NODES))
    found: Array = field("m", "value of the schedule, by axis and sign", shape=(2, 2))
    window: Vector2 = field("m", "first and last landing at which the rest of the push fits")


@njit
def _best_place(after, low, spacing, sign):
    """Where sign l + D(l) is largest, over the nodes: concave, so windows end there or before."""
    best, place = -math.inf, low
    for node in range(after.shape[0]):
        landing = low + node * spacing
        value = sign * landing + after[node]
        if value > best:
            best, place = value, landing
    return place


@njit
def _landing_between(after, low, spacing, sign, place, least, most):
    """The best landing between these, sign l + D(l); `place` is the best of all."""
    least, most = max(least, low), min(most, low + spacing * (after.shape[0] - 1))
    if least > most:
        return OUT_OF_REACH * spacing
    landing = min(max(place, least), most)
    return sign * landing + interpolate(after, low, spacing, landing)


@njit
def _step_back(tables, after, axis, time, now):
    """D of one axis a step earlier, in `now`, for both signs; shape (2, nodes)."""
    low, spacing = tables.low[axis], tables.spacing[axis]
    decay = math.exp(-tables.omega * time)
    way = furthest(0.0, time, tables.max_speed, tables.max_acceleration)
    for k in range(2):
        sign = 1.0 - 2.0 * k
        # Across, the next foot's inward is this foot's outward: the sides alternate.
        later = after[k] if axis == 0 else after[1 - k]
        place = _best_place(later, low, spacing, sign)
        for node in range(now.shape[1]):
            start = BEHIND[axis] * (low + node * spacing)
            now[k, node] = decay * _landing_between(
                later, low, spacing, sign, place, start - way, start + way
            )


@njit
def _even_steps(tables, times, values):
    """D if all steps take the same time, in `values`, shape (times, 2, 2, nodes)."""
    now = np.empty((2, values.shape[3]))
    for row in range(times.shape[0]):
        for axis in range(2):
            change = math.inf
            while change > _SETTLED * tables.spacing[axis]:
                _step_back(tables, values[row, axis], axis, times[row], now)
                change = 0.0
                for k in range(2):
                    for node in range(now.shape[1]):
                        change = max(change, abs(now[k, node] - values[row, axis, k, node]))
                        values[row, axis, k, node] = now[k, node]


@njit
def _write_tail(tables, tails, period, tail):
    """The tables of what follows a schedule, between those that there are."""
    shortest, longest = tables.step_duration[0], tables.step_duration[1]
    last = tails.shape[0] - 1
    part = (period - shortest) / (longest - shortest)
    place = last * math.sqrt(min(max(part, 0.0), 1.0))
    row = max(min(int(place), last - 1), 0)
    late, following = place - row, min(row + 1, last)
    for axis in range(2):
        for k in range(2):
            for node in range(tail.shape[2]):
                early = tails[row, axis, k, node]
                tail[axis, k, node] = early + late * (tails[following, axis, k, node] - early)


@njit
def _displacements(case, schedule):
    """The value of a schedule now, per axis and sign, in the workspace."""
    tables, tails, push, work = case
    last, time = schedule.shape[0] - 1, schedule[0]
    _write_tail(tables, tails, schedule[last], work.stages[last % 2])
    for axis in range(2):
        low, spacing = tables.low[axis], tables.spacing[axis]
        for stage in range(last - 1, 0, -1):
            # Stages take turns in two tables: what comes later is never written over.
            after, now = work.stages[(stage + 1) % 2, axis], work.stages[stage % 2, axis]
            _step_back(tables, after, axis, schedule[stage], now)
        after = work.stages[1, axis]
        least, most = reach(
            push.foot[axis], push.foot_velocity[axis], time, tables.max_speed,
            tables.max_acceleration,
        )  # fmt: skip
        for k in range(2):
            sign, later = 1.0 - 2.0 * k, after[k] if axis == 0 else after[1 - k]
            place = _best_place(later, low, spacing, sign)
            work.found[axis, k] = math.exp(-tables.omega * time) * _landing_between(
                later, low, spacing, sign, place, least, most
            )


@njit
def room_of_schedule(case, schedule) -> float:
    """How far the DCM can be moved along the push, if the feet land at these times [m].

    Args:
        case: a `ViableDisplacement` record; tables of all later steps, for some periods of these,
            or for no one in particular, shape (periods or 1, 2, 2, nodes) [m]; a `PushState`
            record, whose duration does not matter; a `Workspace` record.
        schedule: times from landing to landing, the first one from now, and at the end the period
            of all that follow [s].

    Returns:
        The room; far below 0 if the schedule cannot even hold the axis that is not pushed.
    """
    _displacements(case, schedule)
    tables, _, push, work = case
    most, least, slack = math.inf, 0.0, 0.0
    for axis in range(2):
        ahead = work.found[axis, 0] + push.zmp_reach[axis] - push.offset[axis]
        behind = work.found[axis, 1] + push.zmp_reach[axis] + push.offset[axis]
        part = push.direction[axis]
        if part < 0.0:
            ahead, behind, part = behind, ahead, -part
        if part > 0.0:
            most, least = min(most, ahead / part), max(least, -behind / part)
        else:
            slack = min(slack, ahead, behind)
    slack = min(slack, most - least)
    return most if slack >= 0.0 else OUT_OF_REACH * tables.spacing[0] + slack


@njit
def own_schedule(tables, push, axis, k, schedule):
    """Write the landing times that one axis would choose, in one direction: k = 0 along it."""
    foot, velocity = push.foot[axis], push.foot_velocity[axis]
    shortest, longest = tables.step_duration[0], tables.step_duration[1]
    earliest, latest = max(shortest - push.elapsed, 0.0), max(longest - push.elapsed, 0.0)
    for stage in range(schedule.shape[0]):
        later = tables.values[axis, k] if axis == 0 else tables.values[axis, 1 - k]
        value, landing = displacement_to_come(
            tables, later, axis, 1.0 - 2.0 * k, (foot, velocity), (earliest, latest)
        )
        time = latest
        if value > 0.0:
            time = arrival(
                landing - foot, velocity, earliest, tables.max_speed, tables.max_acceleration
            )
            time = min(time, latest)
        schedule[stage] = time
        foot, velocity, earliest, latest = BEHIND[axis] * landing, 0.0, shortest, longest
        k = k if axis == 0 else 1 - k


@njit
def _window(ahead, behind, low, spacing, width, window):
    """Find between which landings the rest of the push fits.

    Args:
        ahead, behind: hi and lo over the landings, both concave [m].
        low, spacing: of the landings [m].
        width: 2 c [m].
        window: first and last landing, written; if there is none, where it nearly fits.

    Returns:
        How much room is left where most is; negative if it fits nowhere [m].
    """
    last = ahead.shape[0] - 1
    best, place = -math.inf, 0
    for node in range(last + 1):
        room = ahead[node] + behind[node] + width
        if room > best:
            best, place = room, node
    window[0] = window[1] = low + place * spacing
    if best < 0.0:
        return best
    for side in range(2):
        step, end = (-1, 0) if side == 0 else (1, last)
        node, room, part = place, best, 0.0
        while node != end:
            further = ahead[node + step] + behind[node + step] + width
            if further < 0.0:
                part = room / (room - further)
                break
            node, room = node + step, further
        window[side] = low + (node + step * part) * spacing
    return best


@njit
def _write_last_stage(push, axis, schedule, work):
    """Write what follows a schedule as its last stage; the sign of the push there, and when [s]."""
    sign, end = (-1.0 if push.direction[axis] < 0.0 else 1.0), 0.0
    for stage in range(schedule.shape[0]):
        end += schedule[stage]
        sign = sign if axis == 0 else -sign
    row, last = (0 if sign > 0.0 else 1), work.stages[schedule.shape[0] % 2, axis]
    for node in range(last.shape[1]):
        last[0, node], last[1, node] = work.tail[axis, row, node], work.tail[axis, 1 - row, node]
    return sign, end


@njit
def _axis_slack(tables, push, axis, schedule, force, work):
    """How much of an axis is left over if the landings take place at these times [m].

    Args:
        tables, push, force, work: as of `causal_slack`; `work.tail` holds what follows.
        axis: 0 for x, 1 for y.
        schedule: times from landing to landing, the first one from now [s].
    """
    low, spacing, zmp_reach = tables.low[axis], tables.spacing[axis], push.zmp_reach[axis]
    nodes, count, part = tables.values.shape[2], schedule.shape[0], push.direction[axis]
    speed, acceleration, omega = tables.max_speed, tables.max_acceleration, tables.omega
    pushed, force = part != 0.0, force * abs(part)
    sign, end = _write_last_stage(push, axis, schedule, work)
    window = work.window
    window[0], window[1] = low, low + spacing * (nodes - 1)
    slack = math.inf
    for stage in range(count - 1, -1, -1):
        time = schedule[stage]
        start = end - time
        # Across, the next foot's inward is this foot's outward: the sides alternate.
        sign = sign if axis == 0 else -sign
        going_on = pushed and start < push.duration
        lands_pushed = pushed and end < push.duration
        decay, way = math.exp(-omega * time), furthest(0.0, time, speed, acceleration)
        shift = force * -math.expm1(-omega * min(max(push.duration - start, 0.0), time))
        ahead, behind = work.stages[(stage + 1) % 2, axis, 0], work.stages[(stage + 1) % 2, axis, 1]
        best_ahead = _best_place(ahead, low, spacing, sign)
        best_behind = _best_place(behind, low, spacing, -sign)
        if stage == 0:
            foot, velocity = push.foot[axis], push.foot_velocity[axis]
            least, most = reach(foot, velocity, time, speed, acceleration)
            least, most = max(least, window[0]), min(most, window[1])
            offset = sign * push.offset[axis]
            value = decay * _landing_between(ahead, low, spacing, sign, best_ahead, least, most)
            slack = min(slack, value - shift + zmp_reach - offset)
            if lands_pushed or not pushed:
                value = decay * _landing_between(
                    behind, low, spacing, -sign, best_behind, least, most
                )
                slack = min(slack, value + shift + zmp_reach + offset)
            return slack
        against, now = tables.values[axis, 1 if sign > 0.0 else 0], work.stages[stage % 2, axis]
        left = saved = 0.0
        for node in range(nodes):
            if node == 0 or way < math.inf:
                foot = BEHIND[axis] * (low + node * spacing)
                least, most = max(foot - way, window[0]), min(foot + way, window[1])
                value = _landing_between(ahead, low, spacing, sign, best_ahead, least, most)
                left = decay * value - shift
                if lands_pushed or not pushed:
                    value = _landing_between(behind, low, spacing, -sign, best_behind, least, most)
                    saved = decay * value + shift
            now[0, node] = left
            now[1, node] = saved
            if going_on:
                # Of an interrupted push the landings are as free as those of any walk.
                end_now = against[node]
                now[1, node] = min(saved, end_now) if lands_pushed else end_now
        window[0], window[1] = low, low + spacing * (nodes - 1)
        if going_on:
            slack = min(slack, _window(now[0], now[1], low, spacing, 2.0 * zmp_reach, window))
        end = start
    return slack


@njit
def causal_slack(case, schedule, force):
    """How much is left over of the axis that is worst off, if the feet land at these times [m].

    Args:
        case: as of `room_of_schedule`; its push says how long it lasts and which axes count.
        schedule: likewise; all times may lie in the push, but for the last one and the period.
        force: F / (m omega^2) [m].
    """
    tables, tails, push, work = case
    count = schedule.shape[0] - 1
    _write_tail(tables, tails, schedule[count], work.tail)
    slack = math.inf
    for axis in range(2):
        if push.alone == BOTH or axis == push.alone:
            slack = min(slack, _axis_slack(tables, push, axis, schedule[:count], force, work))
    return slack


def even_steps(robot: Robot) -> NDArray[np.float64]:
    """`evenly_timed` for `PERIODS` periods, the more of them the shorter."""
    shortest, longest = robot.gait.step_duration
    times = shortest + (longest - shortest) * np.linspace(0.0, 1.0, PERIODS) ** 2
    return evenly_timed(robot, tuple(times.tolist()))


@lru_cache(maxsize=32)
def evenly_timed(robot: Robot, periods: tuple[float, ...]) -> NDArray[np.float64]:
    """The tables of steps that all last as long.

    Args:
        robot: whose limits hold, but for those of the step duration.
        periods: from landing to landing [s].

    Returns:
        Tables as `ViableDisplacement.values` for each period, shape (periods, 2, 2, nodes) [m].

    Raises:
        RobotError: the leg is too slow to step at all.
    """
    values = np.zeros((len(periods), 2, 2, NODES))
    _even_steps(viable_displacement(robot).array[0], np.array(periods), values)
    values.flags.writeable = False
    return values

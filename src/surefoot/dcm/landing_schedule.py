"""What a schedule of landings is worth for a push, both axes at once.

Both axes land together. For given times T_1, T_2, ... of the next landings each axis is a problem
of its own, and a convex one: as far as the foot gets in T_k, step by step backwards,

    D_k(L) = e^(-omega T_k) max over l of (l + D_(k+1)(l)),      |l + L| <= way of the leg in T_k,

and across likewise with alternating sides: `dcm.viable_displacement` with the times fixed. A
schedule is the times of a few landings and a period for all that follow. Its worth is attained, by
the landings that it consists of. Own derivation.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.dcm.leg import arrival, furthest
from surefoot.dcm.viable_displacement import (
    ViableDisplacement,
    displacement_to_come,
    interpolate,
    viable_displacement,
)
from surefoot.robot.robot import Robot

PERIODS = 25
"""For how many periods there are tables of evenly timed steps."""

OUT_OF_REACH = -1e5
"""What a step is worth from which no landing is in reach, in intervals between nodes; finite, to be
interpolated [-]."""

_SETTLED = 1e-10
"""Evenly timed steps are done with when no value moves further, in intervals between nodes [-]."""

BEHIND = (-1.0, 1.0)
"""Where a step l leaves the new swing foot, per l, in the frame of its own step: x, y."""


@njit
def best_place(after, low, spacing, sign):
    """Where sign l + D(l) is largest, over the nodes: concave, so windows end there or before."""
    best, place = -math.inf, low
    for node in range(after.shape[0]):
        landing = low + node * spacing
        worth = sign * landing + after[node]
        if worth > best:
            best, place = worth, landing
    return place


@njit
def landing_between(after, low, spacing, sign, place, least, most):
    """The best landing between these, sign l + D(l); `place` is the best of all."""
    least, most = max(least, low), min(most, low + spacing * (after.shape[0] - 1))
    if least > most:
        return OUT_OF_REACH * spacing
    landing = min(max(place, least), most)
    return sign * landing + interpolate(after, low, spacing, landing)


@njit
def _step_back(after, axis, low, spacing, time, leg, now):
    """D of one axis a step earlier, in `now`, for both signs; shape (2, nodes)."""
    decay, way = math.exp(-leg[2] * time), furthest(0.0, time, leg[0], leg[1])
    for k in range(2):
        sign = 1.0 - 2.0 * k
        # Across, the next foot's inward is this foot's outward: the sides alternate.
        later = after[k] if axis == 0 else after[1 - k]
        place = best_place(later, low, spacing, sign)
        for node in range(now.shape[1]):
            start = BEHIND[axis] * (low + node * spacing)
            now[k, node] = decay * landing_between(
                later, low, spacing, sign, place, start - way, start + way
            )


@njit
def _even_steps(low, spacing, leg, times, tables):
    """D if all steps take the same time, in `tables`, shape (times, 2, 2, nodes)."""
    now = np.empty((2, tables.shape[3]))
    for row in range(times.shape[0]):
        for axis in range(2):
            change = math.inf
            while change > _SETTLED * spacing[axis]:
                _step_back(tables[row, axis], axis, low[axis], spacing[axis], times[row], leg, now)
                change = 0.0
                for k in range(2):
                    for node in range(now.shape[1]):
                        change = max(change, abs(now[k, node] - tables[row, axis, k, node]))
                        tables[row, axis, k, node] = now[k, node]


@njit
def write_tail(tails, bounds, period, tail):
    """The tables of what follows a schedule, between those that there are."""
    last = tails.shape[0] - 1
    part = (period - bounds[0]) / (bounds[1] - bounds[0])
    place = last * math.sqrt(min(max(part, 0.0), 1.0))
    row = max(min(int(place), last - 1), 0)
    late, following = place - row, min(row + 1, last)
    for axis in range(2):
        for k in range(2):
            for node in range(tail.shape[2]):
                early = tails[row, axis, k, node]
                tail[axis, k, node] = early + late * (tails[following, axis, k, node] - early)


@njit
def _displacements(tails, low, spacing, foot, velocity, leg, schedule, work, found):
    """What a schedule is worth now, per axis and sign: `found`, shape (2, 2)."""
    last = schedule.shape[0] - 1
    write_tail(tails, leg[3:5], schedule[last], work[last % 2])
    for axis in range(2):
        for stage in range(last - 1, 0, -1):
            # Stages take turns in two tables: what comes later is never written over.
            after, now = work[(stage + 1) % 2, axis], work[stage % 2, axis]
            _step_back(after, axis, low[axis], spacing[axis], schedule[stage], leg, now)
        time, after = schedule[0], work[1, axis]
        least = foot[axis] - furthest(-velocity[axis], time, leg[0], leg[1])
        most = foot[axis] + furthest(velocity[axis], time, leg[0], leg[1])
        for k in range(2):
            sign, later = 1.0 - 2.0 * k, after[k] if axis == 0 else after[1 - k]
            place = best_place(later, low[axis], spacing[axis], sign)
            found[axis, k] = math.exp(-leg[2] * time) * landing_between(
                later, low[axis], spacing[axis], sign, place, least, most
            )


@njit
def room_of_schedule(tails, low, spacing, state, leg, push, schedule, work, found) -> float:
    """How far the DCM can be moved along the push, if the feet land at these times [m].

    Args:
        tails: what all later steps are worth, for some periods of these, or for no one in
            particular: shape (periods or 1, 2, 2, nodes) [m].
        low, spacing: of their nodes, (x, y) [m].
        state: rows DCM offset, swing foot and its velocity; x, and y towards the swing foot.
        leg: V [m/s], A [m/s^2], omega [1/s], T_min, T_max [s].
        push: rows direction, a unit vector in the axes of `state`, and reach of the ZMP [m].
        schedule: times from landing to landing, the first one from now, and at the end the period
            of all that follow [s].
        work, found: space of shape (2, 2, 2, nodes) and (2, 2).

    Returns:
        The room; far below 0 if the schedule cannot even hold the axis that is not pushed.
    """
    _displacements(tails, low, spacing, state[1], state[2], leg, schedule, work, found)
    most, least, slack = math.inf, 0.0, 0.0
    for axis in range(2):
        ahead = found[axis, 0] + push[1, axis] - state[0, axis]
        behind = found[axis, 1] + push[1, axis] + state[0, axis]
        part = push[0, axis]
        if part < 0.0:
            ahead, behind, part = behind, ahead, -part
        if part > 0.0:
            most, least = min(most, ahead / part), max(least, -behind / part)
        else:
            slack = min(slack, ahead, behind)
    slack = min(slack, most - least)
    return most if slack >= 0.0 else OUT_OF_REACH * spacing[0] + slack


@njit
def own_schedule(tables, low, spacing, state, leg, axis, k, elapsed, schedule):
    """Write the landing times that one axis would choose, in one direction."""
    foot, velocity = state[1, axis], state[2, axis]
    earliest, latest = max(leg[3] - elapsed, 0.0), max(leg[4] - elapsed, 0.0)
    for stage in range(schedule.shape[0]):
        later = tables[axis, k] if axis == 0 else tables[axis, 1 - k]
        worth, landing = displacement_to_come(
            later, low[axis], spacing[axis], 1.0 - 2.0 * k, foot, velocity,
            earliest, latest, leg[0], leg[1], leg[2],
        )  # fmt: skip
        time = latest
        if worth > 0.0:
            time = min(arrival(landing - foot, velocity, earliest, leg[0], leg[1]), latest)
        schedule[stage] = time
        foot, velocity, earliest, latest = BEHIND[axis] * landing, 0.0, leg[3], leg[4]
        k = k if axis == 0 else 1 - k


@lru_cache(maxsize=16)
def even_steps(robot: Robot) -> NDArray[np.float64]:
    """What evenly timed steps are worth, for `PERIODS` periods, the more of them the shorter.

    Returns:
        Tables as `ViableDisplacement.values` for each period, shape (PERIODS, 2, 2, nodes) [m].
    """
    own = viable_displacement(robot)
    shortest, longest = own.step_duration
    times = shortest + (longest - shortest) * np.linspace(0.0, 1.0, PERIODS) ** 2
    tables = np.zeros((PERIODS, *own.values.shape))
    _even_steps(np.array(own.low), np.array(own.spacing), leg_numbers(own), times, tables)
    tables.flags.writeable = False
    return tables


@lru_cache(maxsize=16)
def evenly_timed(robot: Robot, period: float) -> NDArray[np.float64]:
    """What steps are worth that all last as long, like `ViableDisplacement.values` [m].

    Args:
        robot: whose limits hold, but for those of the step duration.
        period: from landing to landing [s].

    Raises:
        RobotError: the leg is too slow to step at all.
    """
    own = viable_displacement(robot)
    tables = np.zeros((1, *own.values.shape))
    times = np.array([period])
    _even_steps(np.array(own.low), np.array(own.spacing), leg_numbers(own), times, tables)
    tables.flags.writeable = False
    return tables[0]


def leg_numbers(tables: ViableDisplacement) -> NDArray[np.float64]:
    """The leg as the kernels take it: V [m/s], A [m/s^2], omega [1/s], T_min, T_max [s]."""
    return np.array(
        [tables.max_speed, tables.max_acceleration, tables.omega, *tables.step_duration]
    )

"""The largest push that a policy can survive which does not know when the push will end.

`dcm.push_limit` supposes that the length of the push is known. Who does not know it has to be
viable at EVERY instant of it, that is, able to be saved if it ended now. What that demands of a
schedule of landings is in `dcm.causal_schedule`; here the best schedule is searched for.

    J_c = D m omega^2 f,    f the largest for which some schedule leaves no axis short.

Where the schedule of `push_limit` is viable throughout, J_c = J and nothing is searched. So it is
in most cells, and always if the push is over before the foot may land. Otherwise the next landing
waits until the rest of the push fits between both ends of what can be saved. Own derivation.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.dcm.causal_schedule import BOTH, causal_slack
from surefoot.dcm.landing_schedule import even_steps, own_schedule
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.dcm.push_limit import (
    ImpulseLimit,
    best_landings,
    push_limit,
    step_of_push,
)
from surefoot.dcm.pushed_step import PushedStep
from surefoot.dcm.viable_displacement import NODES, viable_displacement
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

AFTER = 3
"""How many landings are timed one by one beyond those that the push leaves time for."""

FIRST_TIMES = 8
"""Times of the next landing from which the search sets out, with all later ones as they are."""

FORCES = 16
"""Parts of the limit at which a schedule is tried at first."""

CLIMBS = 2
"""From how many of the best of these it sets out."""

STRIDE = 0.1
"""First stride of the search, of 1 / omega [-]."""

FINEST = 1e-4
"""The search ends below this stride, of 1 / omega [-]."""

TOLERANCE = 1e-6
"""To this part of the limit the largest force of a schedule is found [-]."""

ROUNDING = 1e-12
"""Nothing is left over of a force if so little of the largest one is [-]."""

ALIKE = 1e-4
"""A schedule that is short of so little of the room is viable throughout: the tables tell no better
[-]."""


@njit
def _largest_force(problem, spaces, schedule, least, slack, most):
    """The largest force between these that a schedule survives [m].

    Secants, since what is left over is linear piece by piece; each with a bisection after it.

    Args:
        problem: arguments of `causal_slack` before the schedule, and `spaces` after the force.
        schedule: its times [s].
        least, slack: a force that it survives, and what is left over of that [m].
        most: no larger one is of interest [m].
    """
    over = causal_slack(*problem, schedule, most, *spaces)
    if over >= 0.0:
        return most
    accuracy = TOLERANCE * most
    while most - least > accuracy:
        for guess in range(2):
            force = 0.5 * (least + most)
            if guess == 0:
                force = least + (most - least) * min(max(slack / (slack - over), 0.01), 0.99)
            there = causal_slack(*problem, schedule, force, *spaces)
            if abs(there) <= ROUNDING * most:
                return force
            if there >= 0.0:
                least, slack = force, there
            else:
                most, over = force, there
    return least


@njit
def _first_force(problem, spaces, schedule, least, most):
    """The same if `least` need not be survived; -1 if nothing above it is [m]."""
    for part in range(FORCES):
        force = most - (most - least) * (part / FORCES)
        slack = causal_slack(*problem, schedule, force, *spaces)
        if slack >= 0.0:
            return _largest_force(
                problem, spaces, schedule, force, slack, min(force + (most - least) / FORCES, most)
            )
    return -1.0


@njit
def _climb(problem, spaces, bounds, ways, schedule, force, most, omega):
    """Improve a schedule in place, along many ways and with shrinking strides.

    It improves where more is left over of the force; as soon as anything is, the force grows.

    Returns:
        The largest force that any of the schedules has survived, at least `force` [m].
    """
    count, stride = schedule.shape[0], STRIDE / omega
    trial, came_from, change = np.empty(count), np.empty(count), np.empty(count)
    slack = causal_slack(*problem, schedule, force, *spaces)
    while stride > FINEST / omega and force < most:
        improved = False
        for stage in range(count):
            came_from[stage] = schedule[stage]
        for way in range(ways.shape[0] + 1):
            # At last once more along all that this round has brought.
            for stage in range(count):
                change[stage] = schedule[stage] - came_from[stage]
                if way < ways.shape[0]:
                    change[stage] = stride * ways[way, stage]
            while True:
                for stage in range(count):
                    time = schedule[stage] + change[stage]
                    trial[stage] = min(max(time, bounds[stage, 0]), bounds[stage, 1])
                there = causal_slack(*problem, trial, force, *spaces)
                if there <= slack + TOLERANCE * most:
                    break
                improved, slack = True, there
                for stage in range(count):
                    schedule[stage] = trial[stage]
                if slack > 0.0:
                    force = _largest_force(problem, spaces, schedule, force, slack, most)
                    slack = causal_slack(*problem, schedule, force, *spaces)
        if not improved:
            stride *= 0.5
    return force


@njit
def _search(problem, spaces, bounds, starts, ways, most, omega):
    """The largest force that any schedule survives, from these starts [m]."""
    forces = np.full(starts.shape[0], -1.0)
    force = 0.0
    for start in range(starts.shape[0]):
        forces[start] = _first_force(problem, spaces, starts[start], 0.0, most)
        force = max(force, forces[start])
        if force >= most:
            return most
    for _ in range(CLIMBS):
        best = 0
        for start in range(starts.shape[0]):
            if forces[start] > forces[best]:
                best = start
        if forces[best] < 0.0:
            break
        forces[best] = -1.0
        force = _climb(problem, spaces, bounds, ways, starts[best], force, most, omega)
    return force


@lru_cache(maxsize=64)
def _ways(count: int) -> NDArray[np.float64]:
    """Along and against the times, and some ways between: min has ridges."""
    between = np.random.default_rng(0).normal(size=(2 * count, count))
    between /= np.linalg.norm(between, axis=1, keepdims=True)
    return np.concatenate([np.eye(count), -np.eye(count), between])


def causal_push_limit(
    robot: Robot,
    direction: tuple[float, float],
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    elapsed: float = 0.1,
    duration: float = 0.2,
    support_side: Side = Side.RIGHT,
    zmp_reach: tuple[float, float] = (0.0, 0.0),
    step_duration: float | None = None,
    together: bool = True,
) -> ImpulseLimit:
    """The largest impulse that a policy can survive which does not know when the push ends.

    The push has a constant force. At every instant of it the robot has to be viable: both sides of
    both axes, by the tables of `dcm.viable_displacement`. All smaller forces are survived for
    as long. Two errors: 0.1 % of the search; and an interrupted push is taken as saved if each
    axis is at its own times of landing.

    Args:
        robot: mass, height, gait limits, and the limits of its leg.
        direction: of the push (x, y) in the world, of any length but zero.
        velocity: at which it walks [m/s].
        elapsed: time from the touchdown to the push [s].
        duration: D, how long the push lasts, which the policy does not know [s].
        support_side: foot on the ground when the push starts.
        zmp_reach: how far the ZMP can move from the centre of the foot (x, y) [m].
        step_duration: T_nom of the gait, chosen from the velocity if None [s].
        together: whether both axes land at the same times; otherwise an upper bound, see
            `push_limit`.

    Returns:
        The limit, never above `push_limit`.

    Raises:
        ParameterError, VelocityError, RobotError: as `push_limit` does.
    """
    known = push_limit(
        robot, direction, velocity=velocity, elapsed=elapsed, duration=duration,
        support_side=support_side, zmp_reach=zmp_reach, step_duration=step_duration,
        together=together,
    )  # fmt: skip
    gait = nominal_gait(robot, (velocity[0], velocity[1]), step_duration)
    reach = (float(zmp_reach[0]), float(zmp_reach[1]))
    share = _share(
        robot, gait, known.direction, elapsed, Side(support_side), reach, duration, together
    )
    return ImpulseLimit(known.direction, share * known.impulse, share * known.delta_v)


@lru_cache(maxsize=4096)
def _share(
    robot: Robot,
    gait: NominalGait,
    unit: tuple[float, float],
    elapsed: float,
    side: Side,
    zmp_reach: tuple[float, float],
    duration: float,
    together: bool,
) -> float:
    """Which share of `push_limit` is left if nobody knows when the push ends [-]."""
    if elapsed + duration <= robot.gait.step_duration[0]:
        return 1.0
    step = step_of_push(robot, gait, unit, elapsed, side, zmp_reach)
    if together:
        room, times = best_landings(robot, gait, unit, elapsed, side, zmp_reach)
        return _kept(step, duration, BOTH, room, times) if room > 0.0 else 1.0
    rooms = step.axis_rooms()
    room = min(rooms.values())
    if room <= 0.0:
        return 1.0
    # An axis with much room may be left with less than one that loses nothing.
    kept = [own * _kept(step, duration, axis, own) for (axis, _), own in rooms.items()]
    return min(1.0, min(kept) / room)


def _kept(
    step: PushedStep, duration: float, alone: int, room: float, times: tuple[float, ...] = ()
) -> float:
    """Which share of the room is left [-].

    Args:
        step: in which the push begins.
        duration: of the push [s].
        alone: the only axis that counts, or `BOTH`.
        room: for a push that is known [m].
        times: of the landings that serve it best, if both axes count [s].
    """
    tables = viable_displacement(step.robot)
    bounds = _bounds(step, duration)
    count, omega = len(bounds), tables.omega
    own, numbers = [], step.numbers(tables.values)
    for axis, sign in step.axis_rooms():
        if alone in (BOTH, axis):
            own.append(np.empty(count))
            own_schedule(*numbers[:5], axis, 0 if sign > 0 else 1, step.elapsed, own[-1])
    best = np.array([*times, *times[-1:] * count][:count]) if times else own[0]
    most = room / -math.expm1(-omega * duration)
    spaces = (np.empty((2, 2, NODES)), np.empty((2, 2, NODES)), np.empty(2))
    apart = _problem(step, duration, alone, tables.values[np.newaxis])
    if causal_slack(*apart, best, most, *spaces) >= -ALIKE * room:
        return 1.0
    problem = apart if alone != BOTH else _problem(step, duration, alone, even_steps(step.robot))
    latest = min(max(duration, bounds[0, 0]), bounds[0, 1])
    starts = []
    for schedule in (best, *own):
        for part in np.linspace(0.0, 1.0, FIRST_TIMES):
            starts.append(schedule.copy())
            starts[-1][0] += part * max(latest - schedule[0], 0.0)
    force = _search(problem, spaces, bounds, np.array(starts), _ways(count), most, omega)
    return float(force) / most


def _bounds(step: PushedStep, duration: float) -> NDArray[np.float64]:
    """Least and largest time of every landing that is timed, and of the period of all later [s]."""
    shortest, longest = step.robot.gait.step_duration
    first = max(shortest - step.elapsed, 0.0)
    pushed = math.ceil((duration - first) / shortest) if duration > first else 0
    bounds = np.full((pushed + AFTER + 1, 2), (shortest, longest))
    bounds[0] = first, max(longest - step.elapsed, 0.0)
    return bounds


def _problem(
    step: PushedStep, duration: float, alone: int, tails: NDArray[np.float64]
) -> tuple[Any, ...]:
    """The arguments of `causal_slack` before the schedule."""
    tables = viable_displacement(step.robot)
    _, low, spacing, state, leg, push = step.numbers(tails)
    return tails, tables.values, low, spacing, state, leg, push, alone, duration

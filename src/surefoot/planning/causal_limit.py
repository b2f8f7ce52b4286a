"""The largest push that a policy can survive which does not know when the push will end.

`planning.push_limit` supposes that the length of the push is known. Who does not know it has to be
viable at EVERY instant of it: could be saved if it ended now. What that demands of a schedule of
landings is in `planning.causal_schedule`; here the best schedule is searched for.

    J_c = m omega^2 D f,    f the largest for which some schedule leaves nothing below 0.

A push that is over before the next landing can take place demands nothing new: J_c = J. Likewise
where the schedule of `push_limit` is viable throughout, which is found first.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.compiling import njit
from surefoot.models.footsteps import Side
from surefoot.models.robot import Robot
from surefoot.models.viable_displacement import viable_displacement
from surefoot.planning.causal_schedule import causal_slack
from surefoot.planning.landing_schedule import even_steps, leg_numbers, own_schedule
from surefoot.planning.nominal_gait import NominalGait, nominal_gait
from surefoot.planning.push_limit import (
    ImpulseLimit,
    gait_in_step,
    impulse_per_offset,
    push_limit,
    unit_direction,
)
from surefoot.planning.pushed_step import PushedStep

AFTER = 3
"""How many landings are timed one by one beyond those that the push leaves time for."""

FIRST_TIMES = 16
"""Times of the next landing from which the search sets out, each with the later ones kept."""

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


@njit
def _largest_force(problem, spaces, schedule, least, slack, most):
    """The largest force between these that a schedule survives [m].

    Secants, each with a bisection after it, since what is left over bends.

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
            if there >= 0.0:
                least, slack = force, there
            else:
                most, over = force, there
    return least


@njit
def _first_force(problem, spaces, schedule, least, most):
    """The same from below `least` on, which the schedule need not survive; -1 if nothing above it."""
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
    count = starts.shape[1]
    forces = np.full(starts.shape[0], -1.0)
    force = 0.0
    for start in range(starts.shape[0]):
        forces[start] = _first_force(problem, spaces, starts[start], 0.0, most)
        force = max(force, forces[start])
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
    between = np.random.default_rng(0).normal(size=(4 * count, count))
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

    Args:
        robot, direction, velocity, elapsed, duration, support_side, zmp_reach, step_duration,
        together: as of `push_limit`.

    Returns:
        The limit, at most `push_limit`.

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
    side = Side(support_side)
    room = known.impulse / impulse_per_offset(robot, duration)
    share = _share(
        robot, gait, unit_direction(direction), elapsed, duration, side, reach, together, room
    )
    return ImpulseLimit(known.direction, share * known.impulse, share * known.delta_v)


@lru_cache(maxsize=4096)
def _share(
    robot: Robot,
    gait: NominalGait,
    unit: tuple[float, float],
    elapsed: float,
    duration: float,
    side: Side,
    zmp_reach: tuple[float, float],
    together: bool,
    room: float,
) -> float:
    """Which share of the limit is left to those who do not know when the push ends [-]."""
    if room == 0.0 or elapsed + duration <= robot.gait.step_duration[0]:
        return 1.0
    state = np.array(gait_in_step(gait, side, elapsed))
    step = PushedStep(robot, state, (unit[0], side * unit[1]), zmp_reach, elapsed)
    most = room / -math.expm1(-robot.omega * duration)
    if together:
        return _force(step, duration, -1, most) / most
    return min(
        min(1.0, _force(step, duration, axis, own / -math.expm1(-robot.omega * duration)) / most)
        for (axis, _), own in step.axis_rooms().items()
    )


def _force(step: PushedStep, duration: float, alone: int, most: float) -> float:
    """The largest F / (m omega^2) of a push that can be survived by landing at the same times [m].

    Args:
        step: in which the push begins.
        duration: of the push [s].
        alone: the only axis that counts, or -1.
        most: no larger one can [m].
    """
    robot, tables = step.robot, viable_displacement(step.robot)
    (shortest, longest), omega = tables.step_duration, tables.omega
    first = max(shortest - step.elapsed, 0.0)
    pushed = max(math.floor((duration - first) / shortest) + 1, 0) if first < duration else 0
    count = pushed + AFTER
    bounds = np.full((count + 1, 2), tables.step_duration)
    bounds[0] = np.maximum(bounds[0] - step.elapsed, 0.0)
    axes = [axis for axis in step.axis_rooms() if alone in (-1, axis[0])]
    numbers, schedules = step._numbers(tables.values)[:5], []
    for axis, sign in axes:
        own = np.empty(count + 1)
        own_schedule(*numbers, axis, 0 if sign > 0 else 1, step.elapsed, own)
        schedules.append(own)
    if alone < 0:
        best = list(step.best_schedule()[1])
        schedules.append(np.array((best + best[-1:] * count)[: count + 1]))
    tails = even_steps(robot) if alone < 0 else tables.values[np.newaxis]
    problem: tuple[Any, ...] = (
        tails, tables.values, np.array(tables.low), np.array(tables.spacing), step.state,
        leg_numbers(tables), np.array([step.direction, step.zmp_reach]), alone, duration,
    )  # fmt: skip
    spaces = (np.empty((2, 2, tails.shape[3])), np.empty(tails.shape[1:]), np.empty(2))
    starts = []
    for schedule in schedules:
        late = max(min(duration, bounds[0, 1]), bounds[0, 0])
        for part in np.linspace(0.0, 1.0, FIRST_TIMES):
            start = schedule.copy()
            start[0] += part * max(late - start[0], 0.0)
            starts.append(start)
    return float(
        _search(problem, spaces, bounds, np.array(starts), _ways(count + 1), most, omega)
    )

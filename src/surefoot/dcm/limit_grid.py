"""The largest survivable push once more, from a grid: a check of `dcm.push_limit`.

Backward value iteration over (time in the step, speed of the swing foot, swing foot), axis by axis:
see `dcm.limit_sweep`. Nothing here knows of discounted sums or of times of landing, so that it
fails where these are wrong. Where DCM and foot are when the push comes is the one thing that both
ways share; the tests take that from walks. The other axis is left out of it.

With time steps of 2 ms it comes within 0.3 % where the acceleration is unlimited; the lattice of a
limited one is coarser, and within 1.3 %.

For a push whose end is not known the iteration goes back through the push with both bounds of every
state at once, each cut off at what is viable unpushed: `Sweep.causal_push`. No schedule of landings
occurs in it, and where the ZMP and the foot are at best comes out by itself. What a force does is
not linear here, so the largest force is found by bisection. The next landing waits for a time step
too long on average half of the time: with time steps of 4 ms that is up to 1 % of the limit.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from operator import itemgetter
from typing import Any

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.limit_sweep import USUAL, Array, Mesh, Sweep
from surefoot.dcm.push_limit import PushCase
from surefoot.dcm.pushes import DIRECTIONS, push_direction
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

SHORTEST_PUSH = 0.001
"""A push must last for a time step or more [s]."""

FORCE = 0.1
"""F / (m omega^2) of the sweep: what a force changes is linear in it [m]."""

PRECISION = 1e-3
"""The bisection ends at this part of the limit of a push that is known [-]."""

BEYOND = 1.05
"""It begins this far above that [-]."""


def between_nodes(
    table: Array, nodes: tuple[Array, Array, Array], elapsed: float, velocity: float, foot: float
) -> float:
    """A table of (times, speeds, feet) between its nodes, linear in each."""
    times, speeds, feet = nodes
    value = 0.0
    for (row, late), (level, fast) in itertools.product(
        _neighbours(times, elapsed), _neighbours(speeds, velocity)
    ):
        if late * fast > 1e-9:
            value += late * fast * float(np.interp(foot, feet, table[row, level]))
    return value


def _neighbours(nodes: Array, place: float) -> list[tuple[int, float]]:
    """The nodes to both sides of a place, and how much each of them counts."""
    if len(nodes) == 1:
        return [(0, 1.0)]
    at = (place - nodes[0]) / (nodes[1] - nodes[0])
    node = min(max(int(at + 1e-9), 0), len(nodes) - 2)
    part = min(max(at - node, 0.0), 1.0)
    return [(node, 1.0 - part), (node + 1, part)]


@lru_cache(maxsize=4)
def force_bounds(
    robot: Robot, axis: int, duration: float, zmp_reach: float, mesh: Mesh
) -> tuple[tuple[Array, Array, Array], Array, Array]:
    """Value iteration for one axis: without a push until it settles, then through the push.

    Args:
        robot: whose limits hold; the leg's speed may be inf.
        axis: 0 for x; 1 for y, towards the swing foot.
        duration: of the push [s].
        zmp_reach: c, how far the ZMP moves [m].
        mesh: how finely states are divided.

    Returns:
        Nodes: time since touchdown, velocity of the swing foot and its place relative to the
        support foot [s, m/s, m]. For these the largest viable offsets along the axis and against
        it, shape (2, times, speeds, feet) [m], and how they change with a force F / (m omega^2)
        that acts from now on, likewise [m/m].
    """
    check_number("duration", duration, SHORTEST_PUSH, "s")
    sweep = Sweep.of(robot, axis, duration, zmp_reach, mesh)
    unpushed = sweep.settle()
    with np.errstate(invalid="ignore"):
        # Where no landing can be reached in time every bound is -inf.
        slope = (sweep.push(unpushed, FORCE) - unpushed) / FORCE
    return sweep.nodes, unpushed, slope


def grid_limit(case: PushCase, mesh: Mesh = USUAL) -> float:
    """The impulse of `push_limit` for a push along an axis, which counts by itself [N s]."""
    axis, sign, (offset, foot, foot_velocity) = _along_axis(case)
    reach = case.zmp_reach[axis]
    nodes, unpushed, slope = force_bounds(case.robot, axis, case.duration, reach, mesh)
    room, loss = (
        between_nodes(table[0 if sign > 0 else 1], nodes, case.elapsed, foot_velocity, foot)
        for table in (unpushed, slope)
    )
    force = (room - sign * offset) / -loss
    return max(force * case.robot.mass * case.robot.omega**2 * case.duration, 0.0)


def causal_grid_limit(case: PushCase, mesh: Mesh = USUAL) -> float:
    """The impulse of `causal_push_limit`, likewise [N s]."""
    check_number("duration", case.duration, SHORTEST_PUSH, "s")
    axis, sign, (offset, foot, foot_velocity) = _along_axis(case)
    sweep = Sweep.of(case.robot, axis, case.duration, case.zmp_reach[axis], mesh)
    settled, row, offset = sweep.settle(), 0 if sign > 0 else 1, sign * offset

    def survives(force: float) -> bool:
        table = sweep.causal_push(settled, force)[row]
        with np.errstate(invalid="ignore"):
            ahead, behind = (
                between_nodes(table[side], sweep.nodes, case.elapsed, foot_velocity, foot)
                for side in (row, 1 - row)
            )
        return ahead >= offset and behind >= -offset

    known = replace(case, together=False).limit().impulse
    scale = case.robot.mass * case.robot.omega**2 * case.duration
    least, most = 0.0, BEYOND * known / scale
    while most - least > PRECISION * known / scale:
        middle = 0.5 * (least + most)
        least, most = (middle, most) if survives(middle) else (least, middle)
    return 0.5 * (least + most) * scale


def _along_axis(case: PushCase) -> tuple[int, int, tuple[float, float, float]]:
    """The axis of a push, its sign, and of that axis DCM offset, swing foot and its velocity."""
    step = case.step
    axis = 0 if step.direction[1] == 0.0 else 1
    offset, foot, velocity = (pair[axis] for pair in step.state)
    return axis, 1 if step.direction[axis] > 0.0 else -1, (offset, foot, velocity)


def axis_pushes(
    robots: Sequence[Robot],
    phases: Sequence[float],
    velocity: tuple[float, float] = (0.5, 0.0),
    duration: float = 0.2,
) -> list[list[tuple[str, PushCase]]]:
    """Pushes in the `DIRECTIONS`, each axis by itself, of every robot with a point foot and a sole.

    Args:
        robots: the same one with several legs, for example.
        phases: times from the touchdown of the right foot to the push [s].
        velocity, duration: as of `push_limit`.

    Returns:
        For each robot and foot the names of the directions, and the pushes.
    """
    return [
        [
            (
                name,
                PushCase(
                    robot, push_direction(angle, Side.RIGHT), velocity=velocity, elapsed=elapsed,
                    duration=duration, zmp_reach=robot.foot.half if sole else (0.0, 0.0),
                    together=False,
                ),
            )
            for name, angle in DIRECTIONS.items()
            for elapsed in phases
        ]
        for robot, sole in itertools.product(robots, (False, True))
    ]  # fmt: skip


def largest_disagreement(pushes: list[list[tuple[str, PushCase]]]) -> dict[str, Any]:
    """Compare `push_limit` with the grid; pushes as of `axis_pushes`.

    Returns:
        The case in which they differ most, see `_compared`.
    """
    return max(
        (
            _compared(case, name, case.limit().impulse, grid_limit(case))
            for cases in pushes
            for name, case in cases
        ),
        key=itemgetter("fraction"),
    )


def largest_causal_disagreement(pushes: list[list[tuple[str, PushCase]]]) -> dict[str, Any]:
    """Compare `causal_push_limit` with the grid where not to know the end costs most.

    That is one direction and phase for each robot and foot; otherwise as `largest_disagreement`.
    """
    found = []
    for cases in pushes:
        shares = [
            (case.causal_limit().impulse / known, case.elapsed, name, case)
            for name, case in cases
            if (known := case.limit().impulse) > 0.0
        ]
        if shares:
            _, _, name, case = min(shares, key=itemgetter(0, 1, 2))
            impulse = case.causal_limit().impulse
            found.append(_compared(case, name, impulse, causal_grid_limit(case)))
    return max(found, key=itemgetter("fraction"))


def _compared(
    case: PushCase, direction: str, impulse: float, grid_impulse: float
) -> dict[str, Any]:
    """A case in SI, a limit that the leg has not being None, and what both ways say of it.

    `fraction` is |impulse - grid_impulse| / the larger one [-].
    """
    larger, swing = max(impulse, grid_impulse), case.robot.swing
    speed, acceleration = (
        limit if math.isfinite(limit) else None
        for limit in (swing.max_speed, swing.max_acceleration)
    )
    return {
        "fraction": abs(impulse - grid_impulse) / larger if larger > 0.0 else 0.0,
        "direction": direction,
        "elapsed": case.elapsed,
        "leg_speed": speed,
        "leg_acceleration": acceleration,
        "finite_foot": case.zmp_reach[0] > 0.0,
        "impulse": impulse,
        "grid_impulse": grid_impulse,
    }

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
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any, Self

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


@dataclass(frozen=True)
class LimitGrid:
    """The largest forces that can be survived for a while, for every state of one axis.

    Attributes:
        nodes: time since touchdown, velocity of the swing foot and its place relative to the
            support foot [s, m/s, m].
        unpushed: the largest viable offsets along the axis and against it, shape
            (2, times, speeds, feet) [m].
        slope: how these change with a force F / (m omega^2) that acts from now on, shape as
            before [m/m].
    """

    nodes: tuple[Array, Array, Array]
    unpushed: Array
    slope: Array

    def force(
        self, sign: int, foot: float, elapsed: float, offset: float, foot_velocity: float = 0.0
    ) -> float:
        """The largest F / (m omega^2) of a push along `sign` that begins now [m].

        Args:
            sign: +1 along the axis, -1 against it.
            foot: the swing foot [m].
            elapsed: time since touchdown [s].
            offset: of the DCM, along the push [m].
            foot_velocity: of the swing foot, where its acceleration is limited [m/s].
        """
        room, slope = (
            between_nodes(table[0 if sign > 0 else 1], self.nodes, elapsed, foot_velocity, foot)
            for table in (self.unpushed, self.slope)
        )
        return (room - offset) / -slope


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


@dataclass(frozen=True)
class Disagreement:
    """A case, and what both ways of computing its limit say.

    Attributes:
        fraction: |impulse - grid_impulse| / the larger one [-].
        direction: one of `DIRECTIONS`.
        elapsed: time from the touchdown to the push [s].
        leg_speed, leg_acceleration: V, A, may be inf [m/s, m/s^2].
        finite_foot: the whole sole, or a point foot.
        impulse: of `push_limit` [N s].
        grid_impulse: of the grid [N s].
    """

    fraction: float
    direction: str
    elapsed: float
    leg_speed: float
    leg_acceleration: float
    finite_foot: bool
    impulse: float
    grid_impulse: float

    @classmethod
    def of(cls, case: PushCase, direction: str, impulse: float, grid_impulse: float) -> Self:
        """What both ways say of a case."""
        larger, swing = max(impulse, grid_impulse), case.robot.swing
        return cls(
            abs(impulse - grid_impulse) / larger if larger > 0.0 else 0.0,
            direction, case.elapsed, swing.max_speed, swing.max_acceleration,
            case.zmp_reach[0] > 0.0, impulse, grid_impulse,
        )  # fmt: skip

    def as_numbers(self) -> dict[str, Any]:
        """The attributes by name; a limit that the leg has not is None."""
        limits = {
            name: getattr(self, name) if math.isfinite(getattr(self, name)) else None
            for name in ("leg_speed", "leg_acceleration")
        }
        return {**asdict(self), **limits}


@lru_cache(maxsize=4)
def limit_grid(robot: Robot, axis: int, duration: float, zmp_reach: float, mesh: Mesh) -> LimitGrid:
    """Value iteration for one axis: without a push until it settles, then through the push.

    Args:
        robot: whose limits hold; the leg's speed may be inf.
        axis: 0 for x; 1 for y, towards the swing foot.
        duration: of the push [s].
        zmp_reach: c, how far the ZMP moves [m].
        mesh: how finely states are divided.
    """
    check_number("duration", duration, SHORTEST_PUSH, "s")
    sweep = Sweep.of(robot, axis, duration, zmp_reach, mesh)
    unpushed = sweep.settle()
    with np.errstate(invalid="ignore"):
        # Where no landing can be reached in time every bound is -inf.
        slope = (sweep.push(unpushed, FORCE) - unpushed) / FORCE
    return LimitGrid(sweep.nodes, unpushed, slope)


def grid_limit(case: PushCase, mesh: Mesh = USUAL) -> float:
    """The impulse of `push_limit` for a push along an axis, which counts by itself [N s]."""
    axis, sign, (offset, foot, foot_velocity) = _along_axis(case)
    grid = limit_grid(case.robot, axis, case.duration, case.zmp_reach[axis], mesh)
    force = grid.force(sign, foot, case.elapsed, sign * offset, foot_velocity)
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


def largest_disagreement(pushes: list[list[tuple[str, PushCase]]]) -> Disagreement:
    """Compare `push_limit` with the grid; pushes as of `axis_pushes`."""
    found = [
        Disagreement.of(case, name, case.limit().impulse, grid_limit(case))
        for cases in pushes
        for name, case in cases
    ]
    return max(found, key=lambda disagreement: disagreement.fraction)


def largest_causal_disagreement(pushes: list[list[tuple[str, PushCase]]]) -> Disagreement:
    """Compare `causal_push_limit` with the grid where not to know the end costs most.

    That is one direction and phase for each robot and foot; pushes as of `axis_pushes`.
    """
    found = []
    for cases in pushes:
        shares = [
            (case.causal_limit().impulse / known, case.elapsed, name, case)
            for name, case in cases
            if (known := case.limit().impulse) > 0.0
        ]
        if shares:
            _, _, name, case = min(shares, key=lambda share: share[:3])
            impulse = case.causal_limit().impulse
            found.append(Disagreement.of(case, name, impulse, causal_grid_limit(case)))
    return max(found, key=lambda disagreement: disagreement.fraction)

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
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.limit_sweep import Array, Sweep
from surefoot.dcm.nominal_gait import nominal_gait
from surefoot.dcm.push_limit import causal_push_limit, check_leg, gait_in_step, push_limit
from surefoot.dcm.pushes import DIRECTIONS, push_direction
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

TIME_STEP = 0.003
"""At most; the one that nearly divides all times of a case is taken [s]."""

SHORTEST_PUSH = 0.001
"""A push must last for a time step or more [s]."""

FORCES = (0.1, 0.2)
"""F / (m omega^2) of the sweeps: what a force changes is linear in it, as the second proves [m]."""

INTERVALS = 150
"""About so many nodes of the swing foot over the step box [-]."""

LEVELS = 6
"""Speeds of the swing foot from rest to the top, where its acceleration is limited [-]."""

PRECISION = 1e-3
"""The bisection ends at this part of the limit of a push that is known [-]."""

BEYOND = 1.05
"""It begins this far above that [-]."""


@dataclass(frozen=True)
class LimitGrid:
    """The largest forces that can be survived for a while, for every state of one axis.

    Attributes:
        feet: nodes of the swing foot relative to the support foot [m].
        speeds: nodes of its velocity [m/s].
        times: nodes of the time since touchdown [s].
        unpushed: the largest viable offsets along the axis and against it, shape
            (2, times, speeds, feet) [m].
        slope: how these change with a force F / (m omega^2) that acts from now on, shape as
            before [m/m].
        nonlinearity: the largest deviation from that slope, found with another force [m].
    """

    feet: Array
    speeds: Array
    times: Array
    unpushed: Array
    slope: Array
    nonlinearity: float

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
        row = 0 if sign > 0 else 1
        room = self._at(self.unpushed[row], foot, foot_velocity, elapsed) - offset
        return room / -self._at(self.slope[row], foot, foot_velocity, elapsed)

    def _at(self, table: Array, foot: float, velocity: float, elapsed: float) -> float:
        nodes = (self.times, self.speeds, self.feet)
        return between_nodes(table, nodes, elapsed, velocity, foot)


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
    def of(
        cls, robot: Robot, direction: str, elapsed: float, zmp_reach: tuple[float, float],
        impulse: float, grid_impulse: float,
    ) -> Self:  # fmt: skip
        """The case of a robot whose ZMP reaches so far."""
        larger = max(impulse, grid_impulse)
        return cls(
            abs(impulse - grid_impulse) / larger if larger > 0.0 else 0.0,
            direction, elapsed, robot.swing.max_speed, robot.swing.max_acceleration,
            zmp_reach[0] > 0.0, impulse, grid_impulse,
        )  # fmt: skip

    def as_numbers(self) -> dict[str, Any]:
        """The attributes by name; a limit that the leg has not is None."""
        limits = {
            name: getattr(self, name) if math.isfinite(getattr(self, name)) else None
            for name in ("leg_speed", "leg_acceleration")
        }
        return {**asdict(self), **limits}


def limit_grid(
    robot: Robot,
    axis: int,
    duration: float,
    zmp_reach: float = 0.0,
    *,
    time_step: float = TIME_STEP,
    intervals: int = INTERVALS,
    levels: int = LEVELS,
) -> LimitGrid:
    """Value iteration for one axis: without a push until it settles, then through the push.

    Args:
        robot: whose limits hold; the leg's speed may be inf.
        axis: 0 for x; 1 for y, towards the swing foot.
        duration: of the push [s].
        zmp_reach: c, how far the ZMP moves [m].
        time_step: about the time between rows [s].
        intervals: between nodes of the swing foot, over the step box, if its acceleration is
            unlimited.
        levels: speeds of the swing foot from rest to the top, if it is limited; the time step is
            then no shorter than these need.

    Returns:
        The grid.
    """
    check_number("duration", duration, SHORTEST_PUSH, "s")
    problem = Sweep.of(robot, axis, duration, zmp_reach, time_step, intervals, levels)
    unpushed = problem.settle()
    pushed, harder = (problem.push(unpushed, force) for force in FORCES)
    with np.errstate(invalid="ignore"):
        # Where no landing can be reached in time every bound is -inf.
        slope = (pushed - unpushed) / FORCES[0]
        bend = np.abs(harder - unpushed - FORCES[1] * slope)
    nonlinearity = float(np.max(bend[np.isfinite(bend)]))
    return LimitGrid(problem.feet, problem.speeds, problem.times, unpushed, slope, nonlinearity)


def grid_limits(
    robot: Robot,
    phases: Sequence[float],
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    duration: float = 0.2,
    support_side: Side = Side.RIGHT,
    zmp_reach: tuple[float, float] = (0.0, 0.0),
    time_step: float = TIME_STEP,
    intervals: int = INTERVALS,
    levels: int = LEVELS,
) -> dict[str, list[float]]:
    """The impulses of `push_limit` along the axes, each axis by itself, from the grid.

    Args:
        robot: whose limits hold.
        phases: times from the touchdown to the push [s].
        velocity, duration, support_side, zmp_reach: as in `push_limit`.
        time_step, intervals, levels: as in `limit_grid`.

    Returns:
        For each of the `DIRECTIONS` the impulse at each phase [N s].
    """
    gait = nominal_gait(robot, velocity)
    check_leg(robot, gait)
    grids = [
        limit_grid(
            robot,
            axis,
            duration,
            zmp_reach[axis],
            time_step=time_step,
            intervals=intervals,
            levels=levels,
        )
        for axis in range(2)
    ]
    limits: dict[str, list[float]] = {}
    for name in DIRECTIONS:
        axis = 0 if name in ("forward", "back") else 1
        sign = -1 if name in ("back", "inward") else 1
        limits[name] = []
        for elapsed in phases:
            offset, foot, velocity_of_foot = (
                pair[axis] for pair in gait_in_step(gait, support_side, elapsed)
            )
            force = grids[axis].force(sign, foot, elapsed, sign * offset, velocity_of_foot)
            limits[name].append(max(force * robot.mass * robot.omega**2 * duration, 0.0))
    return limits


def causal_grid_limit(
    robot: Robot,
    direction: tuple[float, float],
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    elapsed: float = 0.1,
    duration: float = 0.2,
    support_side: Side = Side.RIGHT,
    zmp_reach: tuple[float, float] = (0.0, 0.0),
    time_step: float = TIME_STEP,
    intervals: int = INTERVALS,
    levels: int = LEVELS,
) -> float:
    """The impulse of `causal_push_limit` along an axis, from the grid [N s].

    Args:
        robot: whose limits hold.
        direction: of the push (x, y), along an axis.
        velocity, elapsed, duration, support_side, zmp_reach: as in `push_limit`.
        time_step, intervals, levels: as in `limit_grid`.
    """
    check_number("duration", duration, SHORTEST_PUSH, "s")
    gait = nominal_gait(robot, velocity)
    check_leg(robot, gait)
    axis = 0 if direction[1] == 0.0 else 1
    along = direction[axis] * (1 if axis == 0 else support_side)
    row = 0 if along > 0.0 else 1
    offset, foot, foot_velocity = (pair[axis] for pair in gait_in_step(gait, support_side, elapsed))
    offset = offset if row == 0 else -offset
    sweep = Sweep.of(robot, axis, duration, zmp_reach[axis], time_step, intervals, levels)
    settled, nodes = sweep.settle(), (sweep.times, sweep.speeds, sweep.feet)

    def survives(force: float) -> bool:
        table = sweep.causal_push(settled, force)[row]
        with np.errstate(invalid="ignore"):
            ahead, behind = (
                between_nodes(table[side], nodes, elapsed, foot_velocity, foot)
                for side in (row, 1 - row)
            )
        return ahead >= offset and behind >= -offset

    known = push_limit(
        robot, direction, velocity=velocity, elapsed=elapsed, duration=duration,
        support_side=support_side, zmp_reach=zmp_reach, together=False,
    ).impulse  # fmt: skip
    scale = robot.mass * robot.omega**2 * duration
    least, most = 0.0, BEYOND * known / scale
    while most - least > PRECISION * known / scale:
        middle = 0.5 * (least + most)
        least, most = (middle, most) if survives(middle) else (least, middle)
    return 0.5 * (least + most) * scale


def largest_disagreement(
    robots: Sequence[Robot],
    phases: Sequence[float],
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    duration: float = 0.2,
) -> Disagreement:
    """Compare `push_limit` with the grid in four directions, for a point foot and the whole sole.

    Args:
        robots: the same one with several legs, for example.
        phases: times from the touchdown of the right foot to the push [s].
        velocity, duration: as in `push_limit`.

    Returns:
        Where they differ most.
    """
    found = []
    for robot, reach in _robots_and_feet(robots):
        impulses = grid_limits(robot, phases, velocity=velocity, duration=duration, zmp_reach=reach)
        for name, others in impulses.items():
            for elapsed, other in zip(phases, others, strict=True):
                limit = push_limit(
                    robot, push_direction(DIRECTIONS[name], Side.RIGHT), velocity=velocity,
                    elapsed=elapsed, duration=duration, zmp_reach=reach, together=False,
                ).impulse  # fmt: skip
                found.append(Disagreement.of(robot, name, elapsed, reach, limit, other))
    return max(found, key=lambda disagreement: disagreement.fraction)


def largest_causal_disagreement(
    robots: Sequence[Robot],
    phases: Sequence[float],
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    duration: float = 0.2,
) -> Disagreement:
    """Compare `causal_push_limit` with the grid where not to know the end costs most.

    That is one direction and phase for each robot, for a point foot and for the whole sole.
    Arguments and result as of `largest_disagreement`.
    """
    found = []
    for robot, reach in _robots_and_feet(robots):
        cells = []
        for name, angle in DIRECTIONS.items():
            for elapsed in phases:
                known, causal = (
                    limit(
                        robot, push_direction(angle, Side.RIGHT), velocity=velocity,
                        elapsed=elapsed, duration=duration, zmp_reach=reach, together=False,
                    ).impulse
                    for limit in (push_limit, causal_push_limit)
                )  # fmt: skip
                if known > 0.0:
                    cells.append((causal / known, elapsed, name, causal))
        if cells:
            _, elapsed, name, impulse = min(cells)
            other = causal_grid_limit(
                robot, push_direction(DIRECTIONS[name], Side.RIGHT), velocity=velocity,
                elapsed=elapsed, duration=duration, zmp_reach=reach,
            )  # fmt: skip
            found.append(Disagreement.of(robot, name, elapsed, reach, impulse, other))
    return max(found, key=lambda disagreement: disagreement.fraction)


def _robots_and_feet(robots: Sequence[Robot]) -> Iterator[tuple[Robot, tuple[float, float]]]:
    """Every robot with a point foot and with its whole sole."""
    for robot in robots:
        for reach in ((0.0, 0.0), robot.foot.half):
            yield robot, reach

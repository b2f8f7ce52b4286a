"""The largest survivable push once more, from a grid: a check of `dcm.push_limit`.

Backward value iteration over (time in the step, speed of the swing foot, swing foot), axis by axis:
see `dcm.limit_sweep`. Nothing here knows of discounted sums or of times of landing, so that it
fails where these are wrong. Where DCM and foot are when the push comes is the one thing that both
ways share; the tests take that from walks. The other axis is left out of it.

With time steps of 2 ms it comes within 0.3 % where the acceleration is unlimited; the lattice of a
limited one is coarser, and within 1.3 %.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.limit_sweep import Array, Sweep
from surefoot.dcm.nominal_gait import nominal_gait
from surefoot.dcm.push_limit import axis_directions, check_leg, gait_in_step, push_limit
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
        direction: one of `axis_directions`.
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
        For each of the `axis_directions` the impulse at each phase [N s].
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
    for number, name in enumerate(axis_directions(support_side)):
        axis, sign = number // 2, 1 - 2 * (number % 2)
        limits[name] = []
        for elapsed in phases:
            offset, foot, velocity_of_foot = (
                pair[axis] for pair in gait_in_step(gait, support_side, elapsed)
            )
            force = grids[axis].force(sign, foot, elapsed, sign * offset, velocity_of_foot)
            limits[name].append(max(force * robot.mass * robot.omega**2 * duration, 0.0))
    return limits


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
    for robot in robots:
        for reach in ((0.0, 0.0), robot.foot.half):
            impulses = grid_limits(
                robot, phases, velocity=velocity, duration=duration, zmp_reach=reach
            )
            for name, direction in axis_directions(Side.RIGHT).items():
                for elapsed, other in zip(phases, impulses[name], strict=True):
                    limit = push_limit(
                        robot, direction, velocity=velocity, elapsed=elapsed, duration=duration,
                        zmp_reach=reach, together=False,
                    ).impulse  # fmt: skip
                    larger = max(limit, other)
                    part = abs(limit - other) / larger if larger > 0.0 else 0.0
                    found.append(
                        Disagreement(
                            part,
                            name,
                            elapsed,
                            robot.swing.max_speed,
                            robot.swing.max_acceleration,
                            reach[0] > 0.0,
                            limit,
                            other,
                        )
                    )
    return max(found, key=lambda disagreement: disagreement.fraction)

"""The largest survivable push once more, from a grid: a check of `planning.push_limit`.

Backward value iteration over (time in the step, swing foot): which DCM offsets can still be saved?
One time step back, the DCM flows, the foot has moved at most V dt, or it has just landed. Nothing
here knows of discounted sums or of times of landing, so that it fails where these are wrong. Where
DCM and foot are when the push comes is the one thing that both ways share; the tests take that from
walks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.models.footsteps import Side
from surefoot.models.robot import Robot
from surefoot.planning.nominal_gait import nominal_gait
from surefoot.planning.push_limit import axis_directions, check_leg, gait_in_step, push_limit

TIME_STEP = 0.003
"""At most; the one that nearly divides all times of a case is taken [s]."""

SHORTEST_PUSH = 0.001
"""A push must last for a time step or more [s]."""

FORCES = (0.1, 0.2)
"""F / (m omega^2) of the sweeps: what a force changes is linear in it, as the second proves [m]."""

INTERVALS = 150
"""About so many nodes of the swing foot over the step box [-]."""

SETTLED = 1e-7
"""The sweeps end when no offset moves further [m]."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LimitGrid:
    """The largest forces that can be survived for a while, for every state of one axis.

    Attributes:
        feet: nodes of the swing foot relative to the support foot [m].
        times: nodes of the time since touchdown [s].
        unpushed: the largest viable offsets along the axis and against it, shape
            (2, times, feet) [m].
        slope: how these change with a force F / (m omega^2) that acts from now on, shape as
            before [m/m].
        nonlinearity: the largest deviation from that slope, found with another force [m].
    """

    feet: Array
    times: Array
    unpushed: Array
    slope: Array
    nonlinearity: float

    def force(self, sign: int, foot: float, elapsed: float, offset: float) -> float:
        """The largest F / (m omega^2) of a push along `sign` that begins now [m].

        Args:
            sign: +1 along the axis, -1 against it.
            foot: the swing foot [m].
            elapsed: time since touchdown [s].
            offset: of the DCM, along the push [m].
        """
        row = 0 if sign > 0 else 1
        room = self._at(self.unpushed[row], foot, elapsed) - offset
        return room / -self._at(self.slope[row], foot, elapsed)

    def _at(self, table: Array, foot: float, elapsed: float) -> float:
        """A table between its nodes, linear in time and place."""
        time_step = self.times[1] - self.times[0]
        row = min(int(elapsed / time_step + 1e-9), len(self.times) - 2)
        part = elapsed / time_step - row
        early, late = (float(np.interp(foot, self.feet, table[i])) for i in (row, row + 1))
        return early if part < 1e-9 else early + part * (late - early)


@dataclass(frozen=True)
class Disagreement:
    """A case, and what both ways of computing its limit say.

    Attributes:
        fraction: |impulse - grid_impulse| / the larger one [-].
        direction: one of `axis_directions`.
        elapsed: time from the touchdown to the push [s].
        leg_speed: V, may be inf [m/s].
        finite_foot: the whole sole, or a point foot.
        impulse: of `push_limit` [N s].
        grid_impulse: of the grid [N s].
    """

    fraction: float
    direction: str
    elapsed: float
    leg_speed: float
    finite_foot: bool
    impulse: float
    grid_impulse: float

    def as_numbers(self) -> dict[str, Any]:
        """The attributes by name; an unlimited leg has the speed None."""
        speed = self.leg_speed if math.isfinite(self.leg_speed) else None
        return {**asdict(self), "leg_speed": speed}


def limit_grid(
    robot: Robot,
    axis: int,
    duration: float,
    zmp_reach: float = 0.0,
    *,
    time_step: float = TIME_STEP,
    intervals: int = INTERVALS,
) -> LimitGrid:
    """Value iteration for one axis: without a push until it settles, then through the push.

    Args:
        robot: whose limits hold; the leg's speed may be inf.
        axis: 0 for x; 1 for y, towards the swing foot.
        duration: of the push [s].
        zmp_reach: c, how far the ZMP moves [m].
        time_step: about the time between rows [s].
        intervals: between nodes of the swing foot, over the step box.

    Returns:
        The grid.
    """
    check_number("duration", duration, SHORTEST_PUSH, "s")
    problem = _Axis.of(robot, axis, duration, zmp_reach, time_step, intervals)
    unpushed = problem.settle()
    pushed, harder = (problem.push(unpushed, force) for force in FORCES)
    with np.errstate(invalid="ignore"):
        # Where no landing can be reached in time every bound is -inf.
        slope = (pushed - unpushed) / FORCES[0]
        bend = np.abs(harder - unpushed - FORCES[1] * slope)
    nonlinearity = float(np.max(bend[np.isfinite(bend)]))
    return LimitGrid(problem.feet, problem.times, unpushed, slope, nonlinearity)


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
) -> dict[str, list[float]]:
    """The impulses of `push_limit` along the axes, from the grid.

    Args:
        robot: whose limits hold.
        phases: times from the touchdown to the push [s].
        velocity, duration, support_side, zmp_reach: as in `push_limit`.
        time_step, intervals: as in `limit_grid`.

    Returns:
        For each of the `axis_directions` the impulse at each phase [N s].
    """
    gait = nominal_gait(robot, velocity)
    check_leg(robot, gait)
    grids = [
        limit_grid(robot, axis, duration, zmp_reach[axis], time_step=time_step, intervals=intervals)
        for axis in range(2)
    ]
    limits: dict[str, list[float]] = {}
    for number, name in enumerate(axis_directions(support_side)):
        axis, sign = number // 2, 1 - 2 * (number % 2)
        limits[name] = []
        for elapsed in phases:
            offset, foot = gait_in_step(gait, support_side, elapsed)
            force = grids[axis].force(sign, foot[axis], elapsed, sign * offset[axis])
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
                        zmp_reach=reach,
                    ).impulse  # fmt: skip
                    larger = max(limit, other)
                    part = abs(limit - other) / larger if larger > 0.0 else 0.0
                    found.append(
                        Disagreement(
                            part, name, elapsed, robot.swing.max_speed, reach[0] > 0.0, limit, other
                        )
                    )
    return max(found, key=lambda disagreement: disagreement.fraction)


@dataclass(frozen=True)
class _Axis:
    """What the sweeps need to know of an axis.

    Attributes:
        feet, times: nodes [m, s].
        landable: which nodes of the foot lie in the step box.
        first: the first row at which landing is allowed.
        behind: where a landing at l leaves the new swing foot, per l: -1 in x, +1 in y.
        stride: how far the foot moves in a time step [nodes].
        decay: e^(-omega dt) [-].
        reach: of the ZMP [m].
        pushed: how many time steps a push lasts.
    """

    feet: Array
    times: Array
    landable: NDArray[np.bool_]
    first: int
    behind: float
    stride: float
    decay: float
    reach: float
    pushed: int

    @classmethod
    def of(
        cls, robot: Robot, axis: int, duration: float, reach: float, about: float, intervals: int
    ) -> _Axis:
        shortest, longest = robot.gait.step_duration
        time_step = _common_step(duration, (shortest, longest), about)
        low, high = robot.gait.step_x
        if axis == 1:
            low, high = (robot.hip + bound for bound in robot.gait.step_y)
        intervals = _whole_strides(robot.swing.max_speed * time_step, high - low, intervals)
        spacing = (high - low) / intervals
        # Behind the box too, where a long step leaves the foot.
        below = math.ceil(max(low + high, 0.0) / spacing - 1e-9) if axis == 0 else 0
        above = math.ceil(max(-low - high, 0.0) / spacing - 1e-9) if axis == 0 else 0
        index = np.arange(-below, intervals + above + 1)
        return cls(
            feet=np.asarray(low + spacing * index, float),
            times=np.asarray(time_step * np.arange(round(longest / time_step) + 1), float),
            landable=(index >= 0) & (index <= intervals),
            first=round(shortest / time_step),
            behind=-1.0 if axis == 0 else 1.0,
            stride=robot.swing.max_speed * time_step / spacing,
            decay=math.exp(-robot.omega * time_step),
            reach=reach,
            pushed=round(duration / time_step),
        )

    def landed(self, fresh: Array) -> Array:
        """The largest offsets that a landing here and now can hand over, shape (2, feet).

        The new offset is e - l in x. Across, the axis turns over with the foot: l - e.

        Args:
            fresh: the largest offsets right after a landing, by where the swing foot then is.
        """
        after = np.stack([np.interp(self.behind * self.feet, self.feet, row) for row in fresh])
        if self.behind > 0.0:
            after = after[::-1]
        worth = np.stack([self.feet, -self.feet]) + after
        return np.where(self.landable, worth, -np.inf)

    def back(self, later: Array, force: float) -> Array:
        """The largest offsets a time step earlier: the foot moves, and the DCM flows.

        The force pushes each bound outward, the ZMP pulls it inward.
        """
        pivot = self.reach - force
        return pivot + (self.moved(later) - pivot) * self.decay

    def moved(self, later: Array) -> Array:
        """The best of what the foot can get to within a time step."""
        if math.isinf(self.stride):
            return np.broadcast_to(later.max(axis=-1, keepdims=True), later.shape)
        best = later.copy()
        whole = math.floor(self.stride)
        for shift in range(1, min(whole, later.shape[-1] - 1) + 1):
            _raise(best[..., :-shift], later[..., shift:])
            _raise(best[..., shift:], later[..., :-shift])
        part = self.stride - whole
        if part > 1e-9 and whole + 1 < later.shape[-1]:
            shift, end = whole + 1, later.shape[-1] - whole
            _raise(best[..., :-shift], _between(later[..., whole:-1], later[..., shift:], part))
            _raise(best[..., shift:], _between(later[..., 1:end], later[..., :-shift], part))
        return best

    def settle(self) -> Array:
        """Sweep without a push until nothing moves, shape (2, times, feet)."""
        table = np.zeros((2, len(self.times), len(self.feet)))
        change = math.inf
        while change > SETTLED:
            landed = self.landed(table[:, 0])
            before = table[:, 0].copy()
            table[:, -1] = self.at_once(landed)
            for row in range(len(self.times) - 2, -1, -1):
                table[:, row] = self.back(table[:, row + 1], 0.0)
                if row >= self.first:
                    _raise(table[:, row], self.at_once(landed))
            change = float(np.max(np.abs(table[:, 0] - before)))
        return table

    def at_once(self, landed: Array) -> Array:
        """A leg without a speed limit lands wherever it likes, without any time."""
        return self.moved(landed) if math.isinf(self.stride) else landed

    def push(self, settled: Array, force: float) -> Array:
        """Sweep back through a push from its end, where `settled` holds, to its onset."""
        table = settled
        for _ in range(self.pushed):
            earlier = np.empty_like(table)
            earlier[:, :-1] = self.back(table[:, 1:], force)
            landed = self.at_once(self.landed(earlier[:, 0]))
            earlier[:, -1] = landed
            _raise(earlier[:, self.first :], landed[:, np.newaxis])
            table = earlier
        return table


def _raise(best: Array, other: Array) -> None:
    """The larger of both, kept in the first."""
    np.maximum(best, other, out=best)


def _between(near: Array, far: Array, part: float) -> Array:
    return (1.0 - part) * near + part * far


def _whole_strides(way: float, width: float, about: int) -> int:
    """About so many intervals that the way of the foot in a time step is close to whole ones.

    Where it falls between nodes, every time step smooths the bounds a little.
    """
    if math.isinf(way):
        return about
    strides = max(round(about * way / width), 1)
    return max(round(strides * width / way), 1)


def _common_step(duration: float, others: tuple[float, ...], about: float) -> float:
    """At most `about`: a time step that divides the duration, and nearly the other times [s]."""
    least = math.ceil(duration / about - 1e-9)
    steps = duration / np.arange(least, 2 * least + 1)
    rests = [np.abs(time / steps - np.round(time / steps)) for time in others]
    return float(steps[np.argmin(np.round(np.max(rests, axis=0), 6))])

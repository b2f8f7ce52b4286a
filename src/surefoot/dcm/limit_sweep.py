"""Value iteration for one axis of the push limit: which DCM offsets can still be saved?

States are (time in the step, speed of the swing foot, swing foot). One time step back, the DCM
flows, the foot has moved on, or it has just landed. A leg of unlimited acceleration has no speed to
remember: it moves at most V dt. Otherwise the foot goes by -A, 0 or A for a time step, and the
nodes are A dt apart in speed and A dt^2 / 2 in place, so that it always gets from node to node.
Nothing is interpolated, and the price is twofold: A and V are rounded until they fit the step box,
and where the edge of the box is the best landing, it is reached up to a time step late, which costs
omega dt / 2 on average.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.robot.robot import Robot, Swing

SETTLED = 1e-7
"""The sweeps end when no offset moves further [m]."""

COARSEST = 0.009
"""No time step is longer [s]."""

Array = NDArray[np.float64]


class Mesh(NamedTuple):
    """How finely states are divided.

    Attributes:
        time_step: at most, about; the one that nearly divides all times of a case is taken [s].
        intervals: about so many between nodes of the swing foot, over the step box, if its
            acceleration is unlimited.
        levels: speeds of the swing foot from rest to the top, if it is limited; the time step is
            then no shorter than these need.
    """

    time_step: float = 0.003
    intervals: int = 150
    levels: int = 6


USUAL = Mesh()


@dataclass(frozen=True)
class Sweep:
    """What the sweeps need to know of an axis. Offsets have the shape (2, times, speeds, feet).

    Attributes:
        feet, times, speeds: nodes [m, s, m/s]; one speed, 0, if the acceleration is unlimited.
        landable: which nodes of the foot lie in the step box.
        first: the first row at which landing is allowed.
        behind: where a landing at l leaves the new swing foot, per l: -1 in x, +1 in y.
        stride: how far the foot moves in a time step, if its acceleration is unlimited [nodes].
        decay: e^(-omega dt) [-].
        reach: of the ZMP [m].
        pushed: how many time steps a push lasts.
    """

    feet: Array
    times: Array
    speeds: Array
    landable: NDArray[np.bool_]
    first: int
    behind: float
    stride: float
    decay: float
    reach: float
    pushed: int

    @classmethod
    def of(cls, robot: Robot, axis: int, duration: float, reach: float, mesh: Mesh) -> Sweep:
        """The nodes for an axis of a robot; arguments as of `limit_grid.force_bounds`."""
        about, intervals, levels = mesh
        swing, (shortest, longest) = robot.swing, robot.gait.step_duration
        low, high = robot.gait.step_x
        if axis == 1:
            low, high = (robot.hip + bound for bound in robot.gait.step_y)
        time_step = _time_step(swing, duration, (shortest, longest), about, levels)
        if math.isinf(swing.max_acceleration):
            way = swing.max_speed * time_step
            intervals, top = _whole_strides(way, high - low, intervals), 0
        else:
            intervals, top = _lattice(swing, time_step, high - low)
        spacing = (high - low) / intervals
        # Behind the box too, where a long step leaves the foot, or where a fast one runs to.
        over = min(top * top, intervals // 2)
        below, above = over, over
        if axis == 0:
            below += math.ceil(max(low + high, 0.0) / spacing - 1e-9)
            above += math.ceil(max(-low - high, 0.0) / spacing - 1e-9)
        index = np.arange(-below, intervals + above + 1)
        return cls(
            feet=np.asarray(low + spacing * index, float),
            times=np.asarray(time_step * np.arange(round(longest / time_step) + 1), float),
            speeds=np.asarray(2.0 * spacing / time_step * np.arange(-top, top + 1), float),
            landable=(index >= 0) & (index <= intervals),
            first=round(shortest / time_step),
            behind=-1.0 if axis == 0 else 1.0,
            stride=swing.max_speed * time_step / spacing,
            decay=math.exp(-robot.omega * time_step),
            reach=reach,
            pushed=round(duration / time_step),
        )

    @property
    def nodes(self) -> tuple[Array, Array, Array]:
        """Of the last three axes of a table: times, speeds and feet."""
        return self.times, self.speeds, self.feet

    @property
    def rest(self) -> int:
        """The node of a foot that does not move."""
        return len(self.speeds) // 2

    def landed(self, fresh: Array) -> Array:
        """The largest offsets that a landing here and now can hand over, shape (2, feet).

        The new offset is e - l in x. Across, the axis turns over with the foot: l - e.

        Args:
            fresh: the largest offsets right after a landing, by where the swing foot then is.
        """
        with np.errstate(invalid="ignore"):
            after = np.stack([np.interp(self.behind * self.feet, self.feet, row) for row in fresh])
        after[np.isnan(after)] = -np.inf
        if self.behind > 0.0:
            after = after[::-1]
        value = np.stack([self.feet, -self.feet]) + after
        return np.where(self.landable, value, -np.inf)

    def back(self, later: Array, force: float | Array) -> Array:
        """The largest offsets a time step earlier: the foot moves, and the DCM flows.

        The force pushes each bound outward, the ZMP pulls it inward.
        """
        pivot = self.reach - force
        return pivot + (self.moved(later) - pivot) * self.decay

    def moved(self, later: Array) -> Array:
        """The best of what the foot can get to within a time step."""
        if len(self.speeds) > 1:
            return self._accelerated(later)
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

    def _accelerated(self, later: Array) -> Array:
        """From speed v the foot moves v dt + a dt^2 / 2, where a is -A, 0 or A."""
        best = np.full_like(later, -np.inf)
        count = later.shape[-1]
        for level in range(len(self.speeds)):
            for change in (-1, 0, 1):
                if not 0 <= level + change < len(self.speeds):
                    continue
                shift = 2 * (level - self.rest) + change
                start, end = max(-shift, 0), count - max(shift, 0)
                _raise(
                    best[..., level, start:end],
                    later[..., level + change, start + shift : end + shift],
                )
        return best

    def settle(self) -> Array:
        """Sweep without a push until nothing moves."""
        table = np.zeros((2, len(self.times), len(self.speeds), len(self.feet)))
        change = math.inf
        while change > SETTLED:
            landed = self.landed(table[:, 0, self.rest])[:, np.newaxis]
            before = table[:, 0, self.rest].copy()
            table[:, -1] = self.at_once(landed)
            for row in range(len(self.times) - 2, -1, -1):
                table[:, row] = self.back(table[:, row + 1], 0.0)
                if row >= self.first:
                    _raise(table[:, row], self.at_once(landed))
            after = table[:, 0, self.rest]
            finite = np.isfinite(after)
            change = float(np.max(np.abs(after[finite] - before[finite])))
        return table

    def at_once(self, landed: Array) -> Array:
        """A leg without any limit lands wherever it likes, without any time."""
        at_once = len(self.speeds) == 1 and math.isinf(self.stride)
        return self.moved(landed) if at_once else landed

    def push(self, settled: Array, force: float) -> Array:
        """Sweep back through a push from its end, where `settled` holds, to its onset."""
        table = settled
        for _ in range(self.pushed):
            earlier = np.empty_like(table)
            earlier[:, :-1] = self.back(table[:, 1:], force)
            landed = self.at_once(self.landed(earlier[:, 0, self.rest]))[:, np.newaxis]
            earlier[:, -1] = landed
            _raise(earlier[:, self.first :], landed[:, np.newaxis])
            table = earlier
        return table

    def causal_push(self, settled: Array, force: float) -> Array:
        """The same if it is not known when the push ends: it may at every instant.

        Whatever the state is, both of its offsets have to be viable unpushed, `settled`; a push
        along the axis moves one of them outward and the other inward.

        Returns:
            The largest offsets at the onset of pushes along the axis and against it, shape
            (2, 2, times, speeds, feet); -inf where no offset can be saved.
        """
        forces = (
            force * np.array([[1.0, -1.0], [-1.0, 1.0]])[:, :, np.newaxis, np.newaxis, np.newaxis]
        )
        tables = np.stack([settled, settled])
        for _ in range(self.pushed):
            earlier = np.full_like(tables, -np.inf)
            for k in range(2):
                earlier[k, :, :-1] = self.back(tables[k, :, 1:], forces[k])
                self._viable(earlier[k], settled)
            for k in range(2):
                # Across, a push outward is inward for the foot that has just landed.
                fresh = earlier[k if self.behind < 0.0 else 1 - k, :, 0, self.rest]
                landed = self.at_once(self.landed(fresh))[:, np.newaxis]
                _raise(earlier[k, :, self.first :], landed[:, np.newaxis])
            for k in range(2):
                self._viable(earlier[k], settled)
            tables = earlier
        return tables

    def _viable(self, table: Array, settled: Array) -> None:
        """Leave only what is viable unpushed, and nothing where the two bounds have crossed."""
        np.minimum(table, settled, out=table)
        table[:, table[0] + table[1] < 0.0] = -np.inf


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


def _lattice(swing: Swing, time_step: float, width: float) -> tuple[int, int]:
    """Intervals of A dt^2 / 2 over the step box, and how often A dt goes into the top speed.

    Where no speed limits it, the foot gets no faster than across the box.
    """
    intervals = max(round(2.0 * width / (swing.max_acceleration * time_step**2)), 1)
    acceleration = 2.0 * width / intervals / time_step**2
    top = min(swing.max_speed, math.sqrt(2.0 * acceleration * width))
    return intervals, max(round(top / (acceleration * time_step)), 1)


def _time_step(
    swing: Swing, duration: float, others: tuple[float, ...], about: float, levels: int
) -> float:
    """At most `about`, or as `levels` ask: divides the duration, and nearly the other times [s]."""
    if math.isfinite(swing.max_acceleration):
        # Without a limit of speed, the ramp that a step has time for.
        ramp = min(swing.max_speed / swing.max_acceleration, others[0])
        about, others = min(max(about, ramp / levels), COARSEST), (*others, ramp)
    least = math.ceil(duration / about - 1e-9)
    steps = duration / np.arange(least, 2 * least + 1)
    rests = [np.abs(time / steps - np.round(time / steps)) for time in others]
    return float(steps[np.argmin(np.round(np.max(rests, axis=0), 6))])

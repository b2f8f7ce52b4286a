"""How much room a push finds: the best schedule of landings that serves both axes.

Where one of the pushed axes has the most room that it can have at its own best times, and the other
axis can follow these, nothing has to be searched. Else a coarse grid of landing times is, and then
from its best points with shrinking strides: `dcm.landing_schedule` says what each is worth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.dcm.landing_schedule import (
    even_steps,
    leg_numbers,
    own_schedule,
    room_of_schedule,
)
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.robot.robot import Robot

LANDINGS = 3
"""How many landings are timed one by one."""

OWN_LANDINGS = 8
"""How long both axes follow the times of one of them, before each goes by its own table: what the
times leave of anything later is below 0.4 %."""

FIRST_TIMES = 16
"""Times of the next landing on the coarse grid."""

LATER_TIMES = 4
"""Times of every later landing on it."""

STARTS = 2
"""From how many of the best points of the grid, apart in the first time, the search sets out."""

STRIDE = 0.1
"""First stride of the search, of 1 / omega [-]."""

TABLE_ERROR = 1e-4
"""The tables tell no better; a room so near to the largest is that one, a part of it [-]."""

FINEST = 4e-5
"""The search ends below this stride, of 1 / omega: it is worth as much of the limit [-]."""


@njit
def _limited(start, change, bounds, trial):
    """Write a schedule some way off another one, inside its bounds."""
    for stage in range(start.shape[0]):
        time = start[stage] + change[stage]
        trial[stage] = min(max(time, bounds[stage, 0]), bounds[stage, 1])


@njit
def _keep(source, target):
    """Copy; slices would take Numba longer to compile than all the rest."""
    for stage in range(source.shape[0]):
        target[stage] = source[stage]


@njit
def _shrink(tails, low, spacing, state, leg, push, bounds, ways, schedule, work, found):
    """Improve a schedule in place, along many ways and with shrinking strides; its room."""
    count, stride = schedule.shape[0], STRIDE / leg[2]
    trial, came_from, change = np.empty(count), np.empty(count), np.empty(count)
    room = room_of_schedule(tails, low, spacing, state, leg, push, schedule, work, found)
    while stride > FINEST / leg[2]:
        before = room
        _keep(schedule, came_from)
        for way in range(ways.shape[0] + 1):
            # At last once more along all that this round has brought.
            for stage in range(count):
                if way < ways.shape[0]:
                    change[stage] = stride * ways[way, stage]
                else:
                    change[stage] = schedule[stage] - came_from[stage]
            while True:
                _limited(schedule, change, bounds, trial)
                there = room_of_schedule(
                    tails, low, spacing, state, leg, push, trial, work, found
                )  # fmt: skip
                if there <= room:
                    break
                room = there
                _keep(trial, schedule)
        if room == before:
            stride *= 0.5
    return room


@njit
def _search(tails, low, spacing, state, leg, push, bounds, starts, grid, ways):
    """The room of the best schedule, and that; from these starts and the best of the grid."""
    count = bounds.shape[0]
    work, found = np.empty((2, 2, 2, tails.shape[3])), np.empty((2, 2))
    best, schedule, trial = -math.inf, np.empty(count), np.empty(count)
    given = starts.shape[0] - STARTS
    rooms = np.full(STARTS, -math.inf)
    for point in range(grid.shape[0]):
        for stage in range(count):
            least, most = bounds[stage]
            trial[stage] = least + grid[point, stage] * (most - least)
        room = room_of_schedule(tails, low, spacing, state, leg, push, trial, work, found)
        # Points of one first time follow each other: of these the best one counts.
        place = point * STARTS // grid.shape[0]
        if room > rooms[place]:
            rooms[place] = room
            _keep(trial, starts[given + place])
    for start in range(starts.shape[0]):
        room = _shrink(
            tails, low, spacing, state, leg, push, bounds, ways, starts[start], work, found
        )  # fmt: skip
        if room > best:
            best = room
            _keep(starts[start], schedule)
    return best, schedule


@cache
def _grid(landings: int) -> NDArray[np.float64]:
    """Points of the coarse grid as fractions of each interval, denser where it is early."""
    first = np.linspace(0.0, 1.0, FIRST_TIMES) ** 2
    later = np.linspace(0.0, 1.0, LATER_TIMES) ** 2
    return np.array(list(product(first, *[later] * (landings - 1))))


@cache
def _ways(landings: int) -> NDArray[np.float64]:
    """Along, against and across the times, and some ways between: min has ridges."""
    between = np.random.default_rng(0).normal(size=(8 * landings, landings))
    between /= np.linalg.norm(between, axis=1, keepdims=True)
    return np.concatenate([np.eye(landings), -np.eye(landings), between])


@dataclass(frozen=True)
class PushedStep:
    """A step in which a push begins, and what it is that pushes.

    Attributes:
        robot: whose limits hold.
        state: rows DCM offset, swing foot and its velocity, relative to the support foot; x, and y
            towards the swing foot [m, m, m/s].
        direction: of the push, a unit vector in these axes.
        zmp_reach: how far the ZMP moves (x, y) [m].
        elapsed: time since touchdown [s].
    """

    robot: Robot
    state: NDArray[np.float64]
    direction: tuple[float, float]
    zmp_reach: tuple[float, float]
    elapsed: float

    def axis_rooms(self) -> dict[tuple[int, int], float]:
        """The room if there were but one axis, by axis and sign, for those that are pushed [m].

        No schedule has more than the least of these.
        """
        tables, rooms = viable_displacement(self.robot), {}
        for axis, part in enumerate(self.direction):
            if part != 0.0:
                sign = 1 if part > 0.0 else -1
                offset, foot, velocity = (float(row) for row in self.state[:, axis])
                worth = tables.in_step(axis, sign, foot, self.elapsed, velocity)
                room = worth + self.zmp_reach[axis] - sign * offset
                rooms[axis, sign] = room / abs(part)
        return rooms

    def room(
        self, schedule: Sequence[float] | NDArray[np.float64], *, apart: bool = False
    ) -> float:
        """The room if both axes land at these times [m].

        Args:
            schedule: times from landing to landing, the first one from now, and at the end the
                period of all that follow [s].
            apart: after these landings each axis goes by its own best times, and the period does
                not count: the room is then at least that of every schedule that begins like this.

        Returns:
            The room; far below 0 if an axis falls in any case.
        """
        own = viable_displacement(self.robot).values[np.newaxis]
        tails, *rest = self.numbers(own if apart else even_steps(self.robot))
        return float(
            room_of_schedule(
                tails, *rest, np.array(schedule, float), np.empty((2, *tails.shape[1:])),
                np.empty((2, 2)),
            )
        )  # fmt: skip

    def best_schedule(self, landings: int = LANDINGS) -> tuple[float, tuple[float, ...]]:
        """The landing times that leave the most room.

        Args:
            landings: how many of them are timed one by one.

        Returns:
            The room [m], negative if no schedule keeps the robot even unpushed; the times from
            landing to landing, the first one from now and the last one for all that follow [s].
        """
        rooms = self.axis_rooms()
        enough, starts = min(rooms.values()), []
        tables = viable_displacement(self.robot)
        for axis, sign in rooms:
            own = np.empty(OWN_LANDINGS + 1)
            numbers = self.numbers(tables.values)[:5]
            own_schedule(*numbers, axis, 0 if sign > 0 else 1, self.elapsed, own)
            if self.room(own, apart=True) > enough - TABLE_ERROR * abs(enough):
                return enough, tuple(own.tolist())
            starts.append(own[: landings + 1])
        bounds = np.full((landings + 1, 2), tables.step_duration)
        bounds[0] = np.maximum(bounds[0] - self.elapsed, 0.0)
        room, times = _search(
            *self.numbers(even_steps(self.robot)), bounds,
            np.array(starts + starts[:1] * STARTS), _grid(landings + 1), _ways(landings + 1),
        )  # fmt: skip
        return min(float(room), enough), tuple(times.tolist())

    def numbers(self, tails: NDArray[np.float64]) -> tuple[Any, ...]:
        """The problem as the kernels take it."""
        tables = viable_displacement(self.robot)
        return (
            tails,
            np.array(tables.low),
            np.array(tables.spacing),
            np.ascontiguousarray(self.state, float),
            leg_numbers(tables),
            np.array([self.direction, self.zmp_reach]),
        )

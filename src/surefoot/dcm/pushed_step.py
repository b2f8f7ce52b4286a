"""How much room a push finds: the best schedule of landings that serves both axes.

Where one of the pushed axes has the most room that it can have at its own best times, and the other
axis can follow these, nothing has to be searched. Else a coarse grid of landing times is, and then
from its best points with shrinking strides: `dcm.landing_schedule` gives the value of each.

If it is not known when the push ends, the DCM must be viable at every instant of it. Where the
schedule for a known end is viable throughout, nothing is lost and nothing is searched. So it is in
most cells, and always if the push is over before the foot may land. Otherwise the next landing
waits until the rest of the push fits between both ends of what can be saved. Own derivation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.dcm.landing_schedule import (
    BOTH,
    PushState,
    Workspace,
    causal_slack,
    even_steps,
    own_schedule,
    room_of_schedule,
)
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.record import new_array
from surefoot.robot.robot import Robot

LANDINGS = 3
"""How many landings are timed one by one."""

OWN_LANDINGS = 8
"""How long both axes follow the times of one of them: less than 0.4 % of what is later is left."""

FIRST_TIMES, LATER_TIMES = 16, 4
"""Times of the next landing, and of every later one, on the coarse grid."""

STARTS = 2
"""From how many of the best points of the grid, with different first times, the search sets out."""

STRIDE = 0.1
"""First stride of the searches, of 1 / omega [-]."""

TABLE_ERROR = 1e-4
"""The tables are no more accurate; a room so near to the largest is that one, a part of it [-]."""

FINEST = 4e-5
"""The search ends below this stride, of 1 / omega: it changes as much of the limit [-]."""

CAUSAL_LANDINGS = 3
"""If the end is not known: how many landings are timed beyond those that the push has time for."""

CAUSAL_FIRST_TIMES = 8
"""Times of the next landing from which that search sets out, with all later ones as they are."""

CAUSAL_FINEST = 1e-4
"""It ends below this stride, of 1 / omega [-]."""

FORCES = 16
"""Parts of the limit at which a schedule is tried at first."""

CLIMBS = 2
"""From how many of the best of these it sets out."""

TOLERANCE = 1e-6
"""To this part of the limit the largest force of a schedule is found [-]."""

ROUNDING = 1e-12
"""Nothing is left over of a force if so little of the largest one is [-]."""


@njit
def _limited(start, change, bounds, trial):
    """Write a schedule some way off another one, inside its bounds."""
    for stage in range(start.shape[0]):
        trial[stage] = min(max(start[stage] + change[stage], bounds[stage, 0]), bounds[stage, 1])


@njit
def _copy(source, target):
    """Copy; slices would take Numba longer to compile than all the rest."""
    for stage in range(source.shape[0]):
        target[stage] = source[stage]


@njit
def _change(ways, way, stride, schedule, came_from, change):
    """Write where a search goes next: along a way, or at last along the sum of this round."""
    for stage in range(schedule.shape[0]):
        if way < ways.shape[0]:
            change[stage] = stride * ways[way, stage]
        else:
            change[stage] = schedule[stage] - came_from[stage]


@njit
def _shrink(case, bounds, ways, schedule):
    """Improve a schedule in place, along many ways and with shrinking strides; its room."""
    omega = case[0].omega
    count, stride = schedule.shape[0], STRIDE / omega
    trial, came_from, change = np.empty(count), np.empty(count), np.empty(count)
    room = room_of_schedule(case, schedule)
    while stride > FINEST / omega:
        before = room
        _copy(schedule, came_from)
        for way in range(ways.shape[0] + 1):
            _change(ways, way, stride, schedule, came_from, change)
            while True:
                _limited(schedule, change, bounds, trial)
                there = room_of_schedule(case, trial)
                if there <= room:
                    break
                room = there
                _copy(trial, schedule)
        if room == before:
            stride *= 0.5
    return room


@njit
def _search(case, bounds, grid, ways, starts):
    """The room of the best schedule, and that; from these starts and the best of the grid."""
    count = bounds.shape[0]
    best, schedule, trial = -math.inf, np.empty(count), np.empty(count)
    given = starts.shape[0] - STARTS
    rooms = np.full(STARTS, -math.inf)
    for point in range(grid.shape[0]):
        for stage in range(count):
            least, most = bounds[stage]
            trial[stage] = least + grid[point, stage] * (most - least)
        room = room_of_schedule(case, trial)
        # Points of one first time follow each other: of these the best one counts.
        place = point * STARTS // grid.shape[0]
        if room > rooms[place]:
            rooms[place] = room
            _copy(trial, starts[given + place])
    for start in range(starts.shape[0]):
        room = _shrink(case, bounds, ways, starts[start])
        if room > best:
            best = room
            _copy(starts[start], schedule)
    return best, schedule


@njit
def _largest_force(case, schedule, least, slack, most):
    """The largest force between these that a schedule survives [m].

    Secants, since what is left over is linear piece by piece; each with a bisection after it.

    Args:
        case: as of `causal_slack`.
        schedule: its times [s].
        least, slack: a force that it survives, and what is left over of that [m].
        most: no larger one is of interest [m].
    """
    over = causal_slack(case, schedule, most)
    if over >= 0.0:
        return most
    accuracy = TOLERANCE * most
    while most - least > accuracy:
        for guess in range(2):
            force = 0.5 * (least + most)
            if guess == 0:
                force = least + (most - least) * min(max(slack / (slack - over), 0.01), 0.99)
            there = causal_slack(case, schedule, force)
            if abs(there) <= ROUNDING * most:
                return force
            if there >= 0.0:
                least, slack = force, there
            else:
                most, over = force, there
    return least


@njit
def _first_force(case, schedule, least, most):
    """The same if `least` need not be survived; -1 if nothing above it is [m]."""
    for part in range(FORCES):
        force = most - (most - least) * (part / FORCES)
        slack = causal_slack(case, schedule, force)
        if slack >= 0.0:
            return _largest_force(
                case, schedule, force, slack, min(force + (most - least) / FORCES, most)
            )
    return -1.0


@njit
def _climb(case, bounds, ways, schedule, force, most):
    """Improve a schedule in place, along many ways and with shrinking strides.

    It improves where more is left over of the force; as soon as anything is, the force grows.

    Returns:
        The largest force that any of the schedules has survived, at least `force` [m].
    """
    omega = case[0].omega
    count, stride = schedule.shape[0], STRIDE / omega
    trial, came_from, change = np.empty(count), np.empty(count), np.empty(count)
    slack = causal_slack(case, schedule, force)
    while stride > CAUSAL_FINEST / omega and force < most:
        improved = False
        _copy(schedule, came_from)
        for way in range(ways.shape[0] + 1):
            _change(ways, way, stride, schedule, came_from, change)
            while True:
                _limited(schedule, change, bounds, trial)
                there = causal_slack(case, trial, force)
                if there <= slack + TOLERANCE * most:
                    break
                improved, slack = True, there
                _copy(trial, schedule)
                if slack > 0.0:
                    force = _largest_force(case, schedule, force, slack, most)
                    slack = causal_slack(case, schedule, force)
        if not improved:
            stride *= 0.5
    return force


@njit
def _largest_causal_force(case, bounds, starts, ways, most):
    """The largest force that any schedule survives, from these starts [m]."""
    forces, force = np.full(starts.shape[0], -1.0), 0.0
    for start in range(starts.shape[0]):
        forces[start] = _first_force(case, starts[start], 0.0, most)
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
        force = _climb(case, bounds, ways, starts[best], force, most)
    return force


@cache
def _grid(landings: int) -> NDArray[np.float64]:
    """Points of the coarse grid as fractions of each interval, denser where it is early."""
    first = np.linspace(0.0, 1.0, FIRST_TIMES) ** 2
    later = np.linspace(0.0, 1.0, LATER_TIMES) ** 2
    return np.array(list(product(first, *[later] * (landings - 1))))


@cache
def _ways(landings: int, between: int) -> NDArray[np.float64]:
    """Along and against the times, and some ways between: min has ridges."""
    across = np.random.default_rng(0).normal(size=(between, landings))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    return np.concatenate([np.eye(landings), -np.eye(landings), across])


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
    state: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
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
                offset, foot, velocity = (row[axis] for row in self.state)
                value = tables.in_step(axis, sign, foot, self.elapsed, velocity)
                room = value + self.zmp_reach[axis] - sign * offset
                rooms[axis, sign] = room / abs(part)
        return rooms

    def room(
        self, schedule: Sequence[float] | NDArray[np.float64], *, own_times: bool = False
    ) -> float:
        """The room if both axes land at these times [m].

        Args:
            schedule: times from landing to landing, the first one from now, and at the end the
                period of all that follow [s].
            own_times: after these landings each axis goes by its own best times, and the period
                does not count: no schedule that begins like this has more room.

        Returns:
            The room; far below 0 if an axis falls in any case.
        """
        return float(room_of_schedule(self.case(own_times), np.array(schedule, float)))

    def causal_share(
        self, duration: float, room: float, times: tuple[float, ...] = (), alone: int = BOTH
    ) -> float:
        """Which share of the room is left if it is not known when the push ends [-].

        Args:
            duration: of the push [s].
            room: for a push that is known [m].
            times: of the landings that serve it best, if both axes count [s].
            alone: the only axis that counts, or `BOTH`.
        """
        bounds = self._causal_bounds(duration)
        count, omega = len(bounds), self.robot.omega
        own = list(self.own_schedules(count, alone))
        best = np.array([*times, *times[-1:] * count][:count]) if times else own[0]
        most = room / -math.expm1(-omega * duration)
        if causal_slack(self.case(True, duration, alone), best, most) >= -TABLE_ERROR * room:
            return 1.0
        case = self.case(alone != BOTH, duration, alone)
        latest = min(max(duration, bounds[0, 0]), bounds[0, 1])
        starts = []
        for schedule in (best, *own):
            for part in np.linspace(0.0, 1.0, CAUSAL_FIRST_TIMES):
                starts.append(schedule.copy())
                starts[-1][0] += part * max(latest - schedule[0], 0.0)
        ways = _ways(count, 2 * count)
        force = _largest_causal_force(case, bounds, np.array(starts), ways, most)
        return float(force) / most

    def _causal_bounds(self, duration: float) -> NDArray[np.float64]:
        """Least and largest time of every landing that is timed, and of the later period [s]."""
        shortest, longest = self.robot.gait.step_duration
        first = max(shortest - self.elapsed, 0.0)
        pushed = math.ceil((duration - first) / shortest) if duration > first else 0
        bounds = np.full((pushed + CAUSAL_LANDINGS + 1, 2), (shortest, longest))
        bounds[0] = first, max(longest - self.elapsed, 0.0)
        return bounds

    def own_schedules(self, count: int, alone: int = BOTH) -> Iterator[NDArray[np.float64]]:
        """The landing times that each pushed axis would choose, of those that count [s]."""
        tables, _, push, _ = self.case(True)
        for axis, part in enumerate(self.direction):
            if part != 0.0 and alone in (BOTH, axis):
                schedule = np.empty(count)
                own_schedule(tables, push, axis, 0 if part > 0.0 else 1, schedule)
                yield schedule

    def case(
        self, own_times: bool = False, duration: float = 0.0, alone: int = BOTH
    ) -> tuple[np.void, NDArray[np.float64], np.void, np.void]:
        """Tables, tails, push and workspace, as the kernels take them."""
        tables, (offset, foot, velocity) = viable_displacement(self.robot), self.state
        push = PushState(
            offset=offset, foot=foot, foot_velocity=velocity, direction=self.direction,
            zmp_reach=self.zmp_reach, elapsed=self.elapsed, duration=duration, alone=alone,
        )  # fmt: skip
        tails = tables.values[np.newaxis] if own_times else even_steps(self.robot)
        return tables.array[0], tails, push.array[0], new_array(Workspace.DTYPE)[0]


@lru_cache(maxsize=4096)
def best_schedule(step: PushedStep) -> tuple[float, tuple[float, ...]]:
    """The landing times that leave the most room.

    Returns:
        The room [m], negative if no schedule keeps the robot even unpushed; the times from
        landing to landing, the first one from now and the last one for all that follow [s].
    """
    count = LANDINGS + 1
    enough, starts = min(step.axis_rooms().values()), []
    for own in step.own_schedules(OWN_LANDINGS + 1):
        if step.room(own, own_times=True) > enough - TABLE_ERROR * abs(enough):
            return enough, tuple(own.tolist())
        starts.append(own[:count])
    bounds = np.full((count, 2), step.robot.gait.step_duration)
    bounds[0] = np.maximum(bounds[0] - step.elapsed, 0.0)
    starts = np.array(starts + starts[:1] * STARTS)
    room, times = _search(step.case(), bounds, _grid(count), _ways(count, 8 * count), starts)
    return min(float(room), enough), tuple(times.tolist())

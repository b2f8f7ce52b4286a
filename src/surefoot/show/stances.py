"""A walk cut at its touchdowns: one foot on the ground after the other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.dcm.pushes import Push
from surefoot.errors import SurefootError
from surefoot.geometry import rotated, wrapped
from surefoot.interface import Mode
from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout

NOTICEABLE = 0.002
"""Displacements smaller than this cannot be seen in a picture [m]."""


@dataclass(frozen=True)
class Stance:
    """What happened while one foot stood.

    Attributes:
        number: of the step, from 1; the foot that it lands gets the same number.
        side: foot on the ground.
        support_foot: centre of its sole (x, y) [m].
        yaw: heading of the sole, counter-clockwise from x [rad].
        samples: the cycles of the rollout that belong to it.
        start: time of the touchdown that began it [s].
        end: time of the next touchdown, or of the last cycle [s].
        adapted: whether the step was decided online.
        landing: where the swing foot landed (x, y), None if the run ended before [m].
        planned_duration: of the step, None if it was decided online from its first cycle [s].
        gait: the nominal gait at its end, None if the plant cannot walk it.
    """

    number: int
    side: Side
    support_foot: tuple[float, float]
    yaw: float
    samples: slice
    start: float
    end: float
    adapted: bool
    landing: tuple[float, float] | None
    planned_duration: float | None
    gait: NominalGait | None

    @property
    def nominal_landing(self) -> tuple[float, float] | None:
        """Where the nominal gait would have landed (x, y) [m]."""
        if self.gait is None:
            return None
        step = self.gait.step(self.side)
        return self.support_foot[0] + step[0], self.support_foot[1] + step[1]

    @property
    def moved_from(self) -> tuple[float, float] | None:
        """The nominal landing, if the step was decided online and landed elsewhere (x, y) [m]."""
        nominal = self.nominal_landing
        if not self.adapted or self.landing is None or nominal is None:
            return None
        return nominal if math.dist(nominal, self.landing) > NOTICEABLE else None


def stances(rollout: Rollout) -> list[Stance]:
    """The finished steps of a point mass and the one under way when the run ended, in order."""
    side, time = rollout.support_side, rollout.time
    cuts = [0, *touchdown_cycles(rollout), len(time)]
    parts = []
    for index, (first, last) in enumerate(pairwise(cuts)):
        finished = last < len(time)
        foot = rollout.support_foot
        parts.append(
            Stance(
                number=index + 1,
                side=Side(int(side[first])),
                support_foot=pair(foot[first]),
                yaw=float(rollout.observations["support_yaw"][first]),
                samples=slice(first, last),
                start=float(time[first]),
                end=float(time[last] if finished else time[-1]),
                adapted=bool(rollout.adapting[first:last].any()),
                landing=pair(foot[last]) if finished else None,
                planned_duration=_planned_duration(rollout, first),
                gait=gait_at(rollout, float(time[last - 1])),
            )
        )
    return parts


class Commanded(NamedTuple):
    """What was commanded from a time on.

    Attributes:
        time: when it began [s].
        velocity: in the robot's own heading (x, y) [m/s].
        turning: rate of turn, counter-clockwise [rad/s].
        standing: whether a body was to come to a stand.
    """

    time: float
    velocity: tuple[float, float]
    turning: float
    standing: bool


def commanded(rollout: Rollout) -> list[Commanded]:
    """Every command during the run that differs from the one before, in order.

    A rollout keeps the velocities of a point mass in the world's frame: while it turns, a new one
    at every touchdown, which is the same in its own heading. Its rate of turn is not kept: it is
    the mean of what the soles turned.
    """
    if rollout.body is not None:
        return [Commanded(*command) for command in rollout.body.steering]
    velocities: list[tuple[float, tuple[float, float]]] = []
    for time, velocity in rollout.velocities:
        own = _own_velocity(velocity, heading_at(rollout, time))
        if not velocities or (time <= rollout.time[-1] and own != velocities[-1][1]):
            velocities.append((time, own))
    ends = [time for time, _ in velocities[1:]] + [math.inf]
    return [
        Commanded(start, velocity, _turning(rollout, start, end), False)
        for (start, velocity), end in zip(velocities, ends, strict=True)
    ]


def command_at(commands: Sequence[Commanded], time: float) -> Commanded:
    """The last one that has begun by a time [s]."""
    return [one for one in commands if one.time <= time + 1e-9][-1]


def _turning(rollout: Rollout, start: float, end: float) -> float:
    """Mean rate of turn of the standing soles from one touchdown to another [rad/s]."""
    cycles = np.array([0, *touchdown_cycles(rollout)])
    cycles = cycles[(rollout.time[cycles] >= start) & (rollout.time[cycles] <= end)]
    if len(cycles) < 2:
        return 0.0
    first, last = cycles[0], cycles[-1]
    away = wrapped(np.diff(rollout.observations["support_yaw"][cycles])).sum()
    return round(float(away / (rollout.time[last] - rollout.time[first])), 3) + 0.0


def heading_at(rollout: Rollout, time: float) -> float:
    """Heading of the standing sole at a time [rad]."""
    cycle = int(np.searchsorted(rollout.time, time, side="right")) - 1
    return float(rollout.observations["support_yaw"][max(cycle, 0)])


def _own_velocity(velocity: tuple[float, float], heading: float) -> tuple[float, float]:
    """A velocity of the world's frame in that of a robot with this heading [rad]."""
    if heading == 0.0:
        return velocity
    x, y = rotated(velocity, -heading)
    return round(x, 6) + 0.0, round(y, 6) + 0.0


def walks_on_footholds(rollout: Rollout) -> bool:
    """Whether places and times of the steps were given instead of a velocity."""
    return rollout.controller == "FootholdTracking"


def gait_at(rollout: Rollout, time: float) -> NominalGait | None:
    """The nominal gait for the velocity commanded at a time [s].

    None if the plant cannot walk it, because the controller plans for another robot.
    """
    commanded = [velocity for start, velocity in rollout.velocities if start <= time]
    velocity = commanded[-1] if commanded else rollout.velocities[0][1]
    try:
        return nominal_gait(rollout.robot, velocity, _fixed_duration(rollout))
    except SurefootError:
        return None


def _fixed_duration(rollout: Rollout) -> float | None:
    """T_nom if the controller was given one, else None [s].

    A rollout does not say so, but its first cycle is on the nominal gait and has its duration.
    """
    planned = _planned_duration(rollout, 0)
    chosen = nominal_gait(rollout.robot, rollout.velocities[0][1]).step_duration
    return planned if planned is not None and abs(planned - chosen) > 1e-3 else None


def _planned_duration(rollout: Rollout, first: int) -> float | None:
    """What the plan says of a step in its first cycle, unless it is adapted there already [s]."""
    command = rollout.commands[first]
    return float(command["step_duration"]) if command["mode"] == Mode.TRACKING else None


def pair(values: NDArray[np.float64]) -> tuple[float, float]:
    """A vector of two as a pair of numbers."""
    return float(values[0]), float(values[1])


def broken(values: NDArray[np.float64], parts: list[Stance]) -> NDArray[np.float64]:
    """Samples with a row of NaN before every touchdown, so that no line is drawn across it.

    Args:
        values: one row for each cycle, shape (n,) or (n, m).
        parts: the stances of the whole run.

    Returns:
        Shape (n + touchdowns, ...).
    """
    return np.insert(values, [part.samples.start for part in parts[1:]], np.nan, axis=0)


def touchdown_cycles(rollout: Rollout) -> list[int]:
    """The cycles in which a foot landed."""
    if rollout.body is None:
        side = rollout.support_side
        return (np.flatnonzero(side[1:] != side[:-1]) + 1).tolist()
    return (np.flatnonzero(np.diff(rollout.body.steps) > 0) + 1).tolist()


def acting_pushes(rollout: Rollout) -> list[Push]:
    """The pushes that act on the robot during the run, in the order in which they begin."""
    first, last = rollout.time[0], rollout.time[-1]
    acting = [push for push in rollout.pushes if push.start < last and push.end > first]
    return sorted(acting, key=lambda push: push.start)


def push_samples(rollout: Rollout, push: Push) -> slice:
    """The cycles during which a push acts, with the one in which it begins."""
    first = max(int(np.searchsorted(rollout.time, push.start, side="right")) - 1, 0)
    return slice(first, int(np.searchsorted(rollout.time, push.end, side="right")))


def push_opacity(rollout: Rollout, push: Push) -> float:
    """How strongly to colour a push: a small or lasting one must not drown the others."""
    forces = [np.hypot(*other.force) for other in acting_pushes(rollout)]
    lasting = push.duration > 0.5 * (rollout.time[-1] - rollout.time[0])
    strength = float(np.hypot(*push.force)) / max(*forces, 1e-9)
    return 0.16 if lasting else 0.16 + 0.26 * strength


def runs(flags: NDArray[np.bool_], first: int = 0) -> list[slice]:
    """Every run of True, in order; indices count from `first`."""
    edges = np.diff(np.concatenate(([0], flags.astype(int), [0])))
    pairs = np.flatnonzero(edges).reshape(-1, 2) + first
    return [slice(start, stop) for start, stop in pairs.tolist()]

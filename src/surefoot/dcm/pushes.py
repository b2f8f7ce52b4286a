"""Pushes: constant horizontal forces on the CoM over an interval of time; they add up."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.errors import ParameterError
from surefoot.record import Record, Vector2, field
from surefoot.robot.feet import Side


class PushRecord(Record):
    """A push as kernels read it."""

    start: float = field("s", "when it begins")
    end: float = field("s", "when it ends")
    force: Vector2 = field("N", "(x, y)")


PUSH = PushRecord.DTYPE
"""The same for kernels, which know no classes."""

DIRECTIONS = {"forward": 0.0, "outward": 90.0, "back": 180.0, "inward": 270.0}
"""The four directions in which studies push, by name [deg]; see `push_direction`."""

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
"""A number of a command, as a regular expression."""


@dataclass(frozen=True)
class Push:
    """A constant force on the CoM.

    Args:
        start: when it begins [s].
        duration: how long it lasts [s]; `math.inf` for a force that never ends.
        force: (x, y) [N], x forward, y to the left.

    Raises:
        ParameterError: a value is not finite, the duration not positive, or the force no pair.
    """

    start: float
    duration: float
    force: tuple[float, float]

    def __post_init__(self) -> None:
        try:
            start, duration = float(self.start), float(self.duration)
            force_x, force_y = (float(component) for component in self.force)
        except (TypeError, ValueError) as error:
            raise ParameterError(
                "numbers for start and duration [s] and a pair (x, y) for force [N]",
                f"start={self.start!r}, duration={self.duration!r}, force={self.force!r}",
                "write for example Push(start=1.1, duration=0.2, force=(176.0, 0.0))",
            ) from error
        if not (all(map(math.isfinite, (start, force_x, force_y))) and duration > 0.0):
            raise ParameterError(
                "a finite start and force and a positive duration",
                f"start={start}, duration={duration}, force={(force_x, force_y)}",
                "leave the push out if there is none",
            )
        object.__setattr__(self, "start", start)
        object.__setattr__(self, "duration", duration)
        object.__setattr__(self, "force", (force_x, force_y))

    @classmethod
    def of_impulse(
        cls, impulse: float, direction: tuple[float, float], start: float, duration: float
    ) -> Self:
        """A push by its impulse, J = F * duration.

        Args:
            impulse: J [N s].
            direction: unit vector (x, y).
            start: when it begins [s].
            duration: how long it lasts [s].

        Raises:
            ParameterError: see `Push`.
        """
        force = impulse / duration
        return cls(start, duration, (force * direction[0], force * direction[1]))

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.start + self.duration

    @property
    def impulse(self) -> tuple[float, float]:
        """J = F * duration (x, y) [N s]."""
        return (self.force[0] * self.duration, self.force[1] * self.duration)

    def delta_v(self, mass: float) -> tuple[float, float]:
        """The robot-independent figure: impulse / mass (x, y) [m/s]."""
        return (self.impulse[0] / mass, self.impulse[1] / mass)


def push_direction(angle: float, support_side: Side) -> tuple[float, float]:
    """A push's unit vector (x, y) in the world; exact on the axes.

    Args:
        angle: from forward (0) towards the swing foot, outward (90) [deg].
        support_side: the foot that stands.
    """
    quarter = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
    radians = math.radians(angle)
    x, y = quarter.get(angle, (math.cos(radians), math.sin(radians)))
    return x, support_side * y + 0.0


def acting_force(pushes: Sequence[Push], time: float) -> tuple[float, float]:
    """The sum of the pushes at an instant (x, y) [N]; one acts for start <= time < end."""
    force_x = force_y = 0.0
    for push in pushes:
        if push.start <= time < push.end:
            force_x += push.force[0]
            force_y += push.force[1]
    return force_x, force_y


def eight_directions(support_side: Side) -> dict[str, tuple[float, float]]:
    """The `DIRECTIONS` and the diagonals between them as unit vectors, once round from forward."""
    axes = [(name, push_direction(angle, support_side)) for name, angle in DIRECTIONS.items()]
    directions, half = {}, math.sqrt(0.5)
    for (name, (x, y)), (following, (next_x, next_y)) in pairwise([*axes, axes[0]]):
        directions[name] = (x, y)
        along, across = (name, following) if y == 0.0 else (following, name)
        directions[f"{along}-{across}"] = (half * (x + next_x), half * (y + next_y))
    return directions


def parse_push(text: str) -> Push:
    """A push from FX,FY@START+DURATION in newtons and seconds.

    Raises:
        ParameterError: the text has another form, or a value that no push has.
    """
    match = re.fullmatch(rf"({NUMBER}),({NUMBER})@({NUMBER})\+({NUMBER}|inf)", text)
    if match is None:
        raise ParameterError(
            "--push FX,FY@START+DURATION in newtons and seconds",
            repr(text),
            "write for example --push 176,0@1.1+0.2, without spaces",
        )
    x, y, start, duration = map(float, match.groups())
    return Push(start, duration, (x, y))


def push_records(pushes: Sequence[Push]) -> NDArray[np.void]:
    """The pushes as an array of `PUSH` records, shape (number of pushes,).

    Raises:
        ParameterError: one of them is no `Push`.
    """
    records = np.zeros(len(pushes), PUSH)
    for record, push in zip(records, pushes, strict=True):
        if not isinstance(push, Push):
            raise ParameterError(
                "a Push", repr(push), "write Push(start=1.1, duration=0.2, force=(176.0, 0.0))"
            )
        record["start"], record["end"], record["force"] = push.start, push.end, push.force
    return records


@njit(forceinline=True)
def force_until_change(pushes, time: float, horizon: float) -> tuple[float, float, float]:
    """The total force at `time`, and until when it stays so.

    Args:
        pushes: array of `PUSH` records.
        time: now [s]; a push acts for start <= time < end.
        horizon: no later than this [s].

    Returns:
        Force x [N], force y [N], and the first instant in (time, horizon] at which a push begins
        or ends, or `horizon` [s].
    """
    force_x, force_y, until = 0.0, 0.0, horizon
    for i in range(pushes.shape[0]):
        start, end = pushes[i].start, pushes[i].end
        if start <= time < end:
            force_x += pushes[i].force[0]
            force_y += pushes[i].force[1]
            until = min(until, end)
        elif time < start:
            until = min(until, start)
    return force_x, force_y, until

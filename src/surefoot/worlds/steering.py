"""What a body is asked to do: to walk somewhere, or to stand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_most, check_number, check_pair
from surefoot.geometry import rotated_by

MAX_TURNING = 2.5
"""Above this rate every preset falls within its first steps [rad/s]."""


INTERVAL, MAX_PLACES = 0.02, 100_000
"""Time between two places of a course, unless these are too many [s]; how many are too many."""


@dataclass(frozen=True)
class Steering:
    """A command to walk, or to stand.

    Args:
        velocity: forward and to the left, in the robot's own heading [m/s].
        turning: rate of turn, counter-clockwise, up to `MAX_TURNING` to either side [rad/s].
        standing: come to a stand, whatever the rest says.

    Raises:
        ParameterError: a value is not finite, or the rate of turn too large.
    """

    velocity: tuple[float, float] = (0.0, 0.0)
    turning: float = 0.0
    standing: bool = False

    @property
    def array(self) -> NDArray[np.float64]:
        """All of it as numbers, shape (4,)."""
        return np.array([*self.velocity, self.turning, self.standing])

    @classmethod
    def of(cls, array: NDArray[np.float64]) -> Self:
        """From its numbers."""
        x, y, turning, standing = array.tolist()
        return cls((x, y), turning, bool(standing))

    def __post_init__(self) -> None:
        check_pair("velocity", self.velocity, -math.inf, "m/s")
        check_number("turning", self.turning, -math.inf, "rad/s")
        why = "in faster turns the legs meet"
        check_most("turning", self.turning, MAX_TURNING, "rad/s", why)


def course_of(route: Sequence[tuple[float, Steering]], duration: float) -> NDArray[np.float64]:
    """Where commands lead from the origin, as if a robot walked from the first moment on.

    Args:
        route: (time, command) in order of time [s], the first at 0 or before.
        duration: of the walk [s].

    Returns:
        Places, shape (n, 2) [m].
    """
    interval = max(INTERVAL, duration / MAX_PLACES)
    time = np.arange(0.0, duration, interval)
    index = np.searchsorted([at for at, _ in route[1:]], time, side="right")
    stands = np.array([to.standing for _, to in route])[index]
    turning = np.array([to.turning for _, to in route])[index]
    velocity = np.array([to.velocity for _, to in route], np.float64).reshape(-1, 2)[index]
    heading = np.cumsum(np.where(stands, 0.0, turning)) * interval
    velocity[stands] = 0.0
    return np.cumsum(rotated_by(velocity, heading), axis=0) * interval

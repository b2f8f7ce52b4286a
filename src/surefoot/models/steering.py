"""What a body is asked to do: to walk somewhere, or to stand."""

from __future__ import annotations

import math
from dataclasses import dataclass

from surefoot.checks import check_number, check_pair


@dataclass(frozen=True)
class Steering:
    """A command to walk, or to stand.

    Args:
        velocity: forward and to the left, in the robot's own heading [m/s].
        turning: rate of turn, counter-clockwise [rad/s].
        standing: come to a stand, whatever the rest says.

    Raises:
        ParameterError: a value is not finite.
    """

    velocity: tuple[float, float] = (0.0, 0.0)
    turning: float = 0.0
    standing: bool = False

    def __post_init__(self) -> None:
        check_pair("velocity", self.velocity, -math.inf, "m/s")
        check_number("turning", self.turning, -math.inf, "rad/s")

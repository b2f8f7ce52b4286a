"""How the swing foot moves, and how fast it can."""

from __future__ import annotations

import math

import msgspec

from surefoot.errors import RobotError


def check_positive(owner: str, **values: float) -> None:
    """Refuse values that are not positive and finite.

    Raises:
        RobotError: one is not; it says which, and of what.
    """
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise RobotError(
                f"`{name}` of the {owner} to be positive and finite",
                f"{value}",
                "give the measured value in SI units",
            )


class Swing(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the swing foot moves.

    Attributes:
        height: apex over the ground [m].
        landing_velocity: downward speed at touchdown [m/s].
        max_speed: speed limit of the foot over ground, of each axis by itself [m/s]; inf is the
            paper's idealisation.
        max_acceleration: likewise for its acceleration [m/s^2].
    """

    height: float = 0.05
    landing_velocity: float = 0.0
    max_speed: float = math.inf
    max_acceleration: float = math.inf

    def __post_init__(self) -> None:
        check_positive("swing", height=self.height)
        if not (math.isfinite(self.landing_velocity) and self.landing_velocity >= 0.0):
            raise RobotError(
                "`landing_velocity` of the swing to be 0 or a downward speed [m/s]",
                f"{self.landing_velocity}",
                "give it as a positive number, it points down",
            )
        for name, unit in (("max_speed", "m/s"), ("max_acceleration", "m/s^2")):
            if not getattr(self, name) > 0.0:
                raise RobotError(
                    f"`{name}` of the swing to be positive [{unit}]",
                    f"{getattr(self, name)}",
                    "leave it out, or write inf, for the paper's unlimited leg",
                )

    @property
    def is_limited(self) -> bool:
        """Whether speed or acceleration limit where the foot can be."""
        return math.isfinite(self.max_speed) or math.isfinite(self.max_acceleration)

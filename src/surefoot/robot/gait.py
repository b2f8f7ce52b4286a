"""Limits of the gait: how long and how wide a step may be, how long it may last, how feet swing."""

from __future__ import annotations

import math

import msgspec

from surefoot.errors import RobotError
from surefoot.robot.feet import Side


def _check_range(name: str, unit: str, pair: tuple[float, float]) -> None:
    low, high = pair
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise RobotError(
            f"`{name}` as [min, max] with min < max {unit}",
            f"[{low}, {high}]",
            "give two finite numbers, the smaller one first",
        )


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


class GaitLimits(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The box that every step must lie in (Table 2 of [OnlineGait]).

    Attributes:
        step_duration: T_min, T_max [s].
        step_x: X_min, X_max, forward positive [m].
        step_y: how far inward (negative) and outward (positive) of the hip width it may go [m].
        dcm_offset: soft bounds on |d_x| and |d_y| [m].

    Raises:
        RobotError: an empty range, or a range of steps that does not contain standing still.
    """

    step_duration: tuple[float, float]
    step_x: tuple[float, float]
    step_y: tuple[float, float]
    dcm_offset: tuple[float, float]

    def __post_init__(self) -> None:
        _check_range("step_duration", "[s]", self.step_duration)
        _check_range("step_x", "[m]", self.step_x)
        _check_range("step_y", "[m]", self.step_y)
        if self.step_duration[0] <= 0.0:
            raise RobotError(
                "`step_duration` to begin above 0 [s]",
                f"[{self.step_duration[0]}, {self.step_duration[1]}]",
                "a step needs time: give the shortest one that the legs can do",
            )
        for name, (low, high) in (("step_x", self.step_x), ("step_y", self.step_y)):
            if not low <= 0.0 <= high:
                raise RobotError(
                    f"`{name}` to contain 0 [m], so that the robot can step in place",
                    f"[{low}, {high}]",
                    "give the range relative to the hip width, [-inward, +outward] for y",
                )
        if not all(math.isfinite(bound) and bound > 0.0 for bound in self.dcm_offset):
            raise RobotError(
                "`dcm_offset` as two positive bounds [m]",
                f"{list(self.dcm_offset)}",
                "Table 2 of the paper has [0.1, 0.05]",
            )

    def step_box(
        self, support_side: Side, hip: float
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """The box of the step vector (X, Y + s hip); its lateral side is mirrored with the foot.

        Args:
            support_side: foot on the ground.
            hip: lateral distance of the sole centres in straight walking [m].

        Returns:
            Lower and upper corner (x, y) [m].
        """
        support_side = Side(support_side)
        inner, outer = hip + self.step_y[0], hip + self.step_y[1]
        low_y, high_y = (inner, outer) if support_side is Side.RIGHT else (-outer, -inner)
        return (self.step_x[0], low_y), (self.step_x[1], high_y)


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

"""Feet on the ground: which side stands, and the step that it took."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

FEET = ("left", "right")
"""Order of all arrays with an entry for each foot."""


class Side(IntEnum):
    """The foot that is ON THE GROUND; its value is s, the sign of "towards the swing foot" in y.

    The right foot stands at the right (negative y), so its swing foot is to the left: s = +1.
    """

    RIGHT = 1
    LEFT = -1

    @property
    def other(self) -> Side:
        """The foot in the air."""
        return Side(-self.value)


@dataclass(frozen=True)
class Footstep:
    """One finished step: a foot stood, the other one landed.

    Attributes:
        index: number of the step, from 0.
        side: foot that stood during the step.
        support_foot: centre of its sole (x, y) [m].
        start: time of the touchdown that began the step [s].
        duration: total duration of the step [s].
        landing: where the swing foot landed (x, y) [m].
        dcm_offset: DCM relative to the landed foot at touchdown, d (x, y) [m].
        adapted: whether step location and timing were re-planned online during the step.
    """

    index: int
    side: Side
    support_foot: tuple[float, float]
    start: float
    duration: float
    landing: tuple[float, float]
    dcm_offset: tuple[float, float]
    adapted: bool

    @property
    def step(self) -> tuple[float, float]:
        """Step vector from the support foot to the landing (x, y) [m]."""
        return (
            self.landing[0] - self.support_foot[0],
            self.landing[1] - self.support_foot[1],
        )

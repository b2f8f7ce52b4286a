"""The part of the ground that a top view shows, and its scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray


@dataclass(frozen=True)
class Extent:
    """The part of the ground that a picture shows.

    Attributes:
        low: smallest x and y [m].
        high: largest x and y [m].
    """

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def size(self) -> tuple[float, float]:
        """Extent in x and in y [m]."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    def filling(self, width: float, height: float) -> Extent:
        """The extent, grown in one direction to the proportions of a box."""
        (size_x, size_y), middle = self.size, np.add(self.low, self.high) / 2.0
        scale = max(size_x / width, size_y / height)
        half = np.array([width, height]) * scale / 2.0
        return Extent(pair(middle - half), pair(middle + half))


def pair(values: NDArray[np.float64]) -> tuple[float, float]:
    """A vector of two as a pair of numbers."""
    return float(values[0]), float(values[1])


def metres_per_inch(ax: Axes) -> float:
    """The scale of a top view [m/in]."""
    low, high = ax.get_xlim()
    width = ax.get_position().width * ax.figure.get_figure(root=True).get_size_inches()[0]
    return (high - low) / width


def draw_ground(ax: Axes, shown: Extent) -> None:
    """Set axes up as ground seen from above.

    Args:
        ax: its box has the proportions of `shown`.
        shown: the ground to show.
    """
    ax.set_aspect("equal")
    ax.set_xlim(shown.low[0], shown.high[0])
    ax.set_ylim(shown.low[1], shown.high[1])
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.grid(color="#e8e8e8", linewidth=0.5, zorder=0)
    ax.set_axisbelow(True)

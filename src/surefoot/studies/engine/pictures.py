"""What pictures of studies share: headlines, panels, marks, and polar maps seen from above.

Each is a figure of its own, not known to pyplot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import MaxNLocator

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.show import palette
from surefoot.show.palette import Mark
from surefoot.show.picture_file import HALO, marker_path

LIMIT, FOOT_BAND = "#222222", "#d7e3ea"
"""Colours of the theoretical limit, and of what the sole adds to it."""

FIXED: dict[str, Any] = {"color": palette.QUIET, "linewidth": 0.9, "linestyle": (0, (1, 1.6))}
"""How the limit of fixed steps is drawn."""


def headline(
    figure: Figure, *parts: str, left: float = 0.25, down: float = 0.14, size: float = 12.0
) -> None:
    """Write what a figure shows above it, without parts that are empty.

    It stands so far from the `left` edge and `down` from the upper one [in]; `size` in [pt].
    """
    width, height = figure.get_size_inches()
    figure.suptitle(
        "  ·  ".join(filter(None, parts)), x=left / width, y=1.0 - down / height, ha="left",
        va="top", fontsize=size, fontweight="bold",
    )  # fmt: skip


def panel(figure: Figure, *box: float, **options: Any) -> Any:
    """Axes in a `box` of a figure of its final size: left, bottom, width and height [in]."""
    width, height = figure.get_size_inches()
    left, bottom, across, up = box
    return figure.add_axes((left / width, bottom / height, across / width, up / height), **options)


def add_box(figure: Figure, left: float, down: float, width: float, height: float) -> Axes:
    """Axes in a box: `left` and `down` from the upper left corner of the figure [in]."""
    return panel(figure, left, figure.get_figheight() - down - height, width, height)


def without_frame(ax: Axes) -> None:
    """Leave out the ticks and lines around what needs no axis."""
    ax.tick_params(length=0.0)
    for spine in ax.spines.values():
        spine.set_visible(False)


def marked(how: Mark, **options: Any) -> dict[str, Any]:
    """How the marker of a method is drawn."""
    return {"color": how.colour, "marker": marker_path(how), **options}


def add_legend(
    figure: Figure, handles: Sequence[Any], columns: int, down: float, **options: Any
) -> None:
    """Write a legend in the middle below a figure, so far from its lower edge [in]."""
    below = down / figure.get_figheight()
    figure.legend(
        handles=handles, ncols=columns, loc="lower center", frameon=False,
        bbox_to_anchor=(0.5, below), **options,
    )  # fmt: skip


@dataclass(frozen=True)
class MapGrid:
    """Polar maps of the same scale in rows, in the middle of a figure.

    Attributes:
        width: of the figure [in].
        columns: how many stand in a row.
        count: of maps.
        size: of a map [in].
        gap: between maps in a row [in].
        below: from the foot of a map to the head of the next one below [in].
        head: above the first row [in].
        foot: below the last row [in].
    """

    width: float
    columns: int
    count: int
    size: float
    gap: float
    below: float
    head: float
    foot: float

    def figure(self) -> Figure:
        """A figure with room for all of them, not known to pyplot."""
        rows = math.ceil(self.count / self.columns)
        height = self.head + rows * (self.size + self.below) + self.foot
        return Figure(figsize=(self.width, height), facecolor="white")

    def add(
        self, figure: Figure, index: int, outer: float, near: Callable[[float], float]
    ) -> PolarAxes:
        """Add one of the maps.

        Args:
            figure: of this grid.
            index: which one it is, row by row.
            outer: the largest impulse that is drawn [N s].
            near: how far out something is drawn near an angle [deg].
        """
        step = self.size + self.gap
        row, column = divmod(index, self.columns)
        left = 0.5 * (self.width - self.columns * step + self.gap) + column * step
        bottom = figure.get_figheight() - self.head - row * (self.size + self.below) - self.size
        ax = panel(figure, left, bottom, self.size, self.size, projection="polar")
        ax.set_theta_zero_location("N")
        ax.set_rlim(0.0, 1.06 * outer)
        _draw_rings(ax, near)
        return ax


def closed(angles: Sequence[float], radii: Sequence[float]) -> tuple[Any, Any]:
    """Angles [deg] and radii of a line all around, as a polar plot takes them."""
    return np.radians([*angles, angles[0]]), np.asarray([*radii, radii[0]])


def _draw_rings(ax: PolarAxes, near: Callable[[float], float]) -> None:
    """Draw rings with their impulses, and the names of the directions around."""
    ax.spines["polar"].set_visible(False)
    ax.set_axisbelow(True)
    ax.grid(color="#dcdcdc", linewidth=0.5)
    ax.set_thetagrids(list(DIRECTIONS.values()), labels=[""] * len(DIRECTIONS))
    for (name, angle), turn, place in zip(
        DIRECTIONS.items(), (0.0, 90.0, 0.0, -90.0), ("bottom", "center", "top", "center"),
        strict=True,
    ):  # fmt: skip
        across = {"outward": "right", "inward": "left"}.get(name, "center")
        ax.text(
            math.radians(angle), 1.01 * ax.get_rmax(), name, rotation=turn, va=place, ha=across,
            fontsize=7.5, color=palette.QUIET, gid=f"direction-{name}",
        )  # fmt: skip
    ticks = [tick for tick in MaxNLocator(4).tick_values(0.0, ax.get_rmax()) if tick > 0.0]
    ticks = [tick for tick in ticks if tick < 0.98 * ax.get_rmax()]
    ax.set_rgrids(ticks, labels=[""] * len(ticks))
    # Where there is least to write over.
    radii = {angle: near(angle) for angle in (225.0, 315.0, 135.0, 45.0)}
    free = math.radians(min(radii, key=radii.__getitem__))
    for tick in ticks:
        ax.text(
            free, tick, f"{tick:g}", fontsize=6.5, color=palette.QUIET,
            ha="center", va="center", path_effects=HALO, zorder=5.0,
        )  # fmt: skip

"""Where the parts of a page go: a long walk above its plots over time, a compact one beside.

A body has more plots, and a legend beside each of them: its walk is always above.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from surefoot.show.stances import pair

WIDTH, BODY_WIDTH = 11.0, 12.0
"""Of the page [in]."""

LONG = 2.2
"""From this ratio of length to breadth on, the walk takes the whole width."""

_LEFT, _RIGHT, _BODY_RIGHT, _GAP, _FOOT = 0.9, 0.3, 1.9, 0.13, 0.5
_COLUMN, _BODY_VIEW = 4.3, BODY_WIDTH - _LEFT - _BODY_RIGHT

TALLEST, SHORTEST = 4.6, 1.7
"""Of the top view of a body [in]."""

COARSEST, HIGHEST = 0.25, 7.5
"""A top view whose scale would be coarser [m/in] is as much taller, up to this height [in]."""

LINE = 0.19
"""Distance between two lines of words [in]."""

Box = tuple[float, float, float, float]
"""Left, top, width and height from the upper left corner of the page, downwards [in]."""


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


@dataclass(frozen=True)
class Page:
    """Places on a page, from its upper left corner, downwards [in].

    Attributes:
        width, height: of the page.
        shown: the ground that the top view shows, in the proportions of its box.
        top_view: box of the top view.
        time_plots: boxes of the plots over time, from the top.
        legend: left and top of the legend.
        legend_look: how its entries are set.
    """

    width: float
    height: float
    shown: Extent
    top_view: Box
    time_plots: list[Box]
    legend: tuple[float, float]
    legend_look: dict[str, Any]

    def at(self, left: float, top: float) -> tuple[float, float]:
        """A place as matplotlib wants it: parts of the figure, from the lower left corner."""
        return left / self.width, 1.0 - top / self.height


def add_axes(figure: Figure, box: Box) -> Axes:
    """Axes in a box."""
    (left, top, width, height), (across, up) = box, figure.get_size_inches()
    return figure.add_axes((left / across, 1.0 - (top + height) / up, width / across, height / up))


def width_of(ax: Axes) -> float:
    """Of axes [in]."""
    return ax.get_position().width * ax.figure.get_figure(root=True).get_size_inches()[0]


def units_per_inch(ax: Axes) -> float:
    """The scale of x: of a top view [m/in], of a plot over time [s/in]."""
    low, high = ax.get_xlim()
    return (high - low) / width_of(ax)


def view_size(extent: Extent, of_body: bool) -> tuple[float, float]:
    """Width and height of the top view [in]."""
    aspect = extent.size[0] / extent.size[1]
    if of_body:
        tallest = min(max(extent.size[1] / COARSEST, TALLEST), HIGHEST)
        return _BODY_VIEW, min(max(_BODY_VIEW / aspect, SHORTEST), tallest)
    if aspect >= LONG:
        width = WIDTH - _LEFT - _RIGHT
        return width, max(width / aspect, 1.6)
    return _COLUMN, min(_COLUMN / aspect, 5.4)


def lay_out(
    extent: Extent,
    of_body: bool,
    title_height: float,
    push_lines: int,
    entries: int,
    heights: Sequence[float],
) -> Page:
    """Plan a page.

    Args:
        extent: the ground to show.
        of_body: whether the walk is that of a body.
        title_height: what the title needs [in].
        push_lines: lines of words above the top view.
        entries: of the legend.
        heights: of the plots over time [in].
    """
    width, height = view_size(extent, of_body)
    shown, top = extent.filling(width, height), title_height + 0.12 + LINE * push_lines
    wide, below = extent.size[0] >= LONG * extent.size[1], top + height + 0.52
    columns = 1 if of_body else (6 if wide else 2)
    legend_height = 1.15 * LINE * math.ceil(entries / columns)
    look = {"ncols": columns, "borderpad": 0.0, "handlelength": 2.2, "columnspacing": 1.2}
    legend, plots = (_LEFT, below), (_LEFT, below + legend_height + 0.35, width)
    if of_body:
        legend, plots = (_LEFT + width + 0.1, top), (_LEFT, below + 0.1, width)
        look |= {"fontsize": 8.0, "handlelength": 1.6}
    elif not wide:
        left = _LEFT + width + 1.05
        plots = (left, title_height + 0.25, WIDTH - left - _RIGHT)
    boxes = _below_each_other(*plots, heights)
    end = max(boxes[-1][1] + boxes[-1][3], legend[1] + legend_height - _FOOT)
    top_view = (_LEFT, top, width, height)
    page_width = BODY_WIDTH if of_body else WIDTH
    return Page(page_width, end + _FOOT, shown, top_view, boxes, legend, look)


def _below_each_other(left: float, top: float, width: float, heights: Sequence[float]) -> list[Box]:
    boxes = []
    for height in heights:
        boxes.append((left, top, width, height))
        top += height + _GAP
    return boxes

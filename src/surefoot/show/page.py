"""Where the parts of a page go: a long walk above its plots over time, a compact one beside."""

from __future__ import annotations

import math
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from surefoot.show.ground import Extent
from surefoot.show.push_arrows import LINE
from surefoot.show.time_plots import HEIGHTS

WIDTH = 11.0
"""Of the page [in]."""

LONG = 2.2
"""From this ratio of length to breadth on, the walk takes the whole width."""

_LEFT, _RIGHT, _GAP, _FOOT = 0.9, 0.3, 0.13, 0.5
_COLUMN = 4.3
_TIME_HEIGHT = sum(HEIGHTS) + _GAP * (len(HEIGHTS) - 1)


@dataclass(frozen=True)
class Page:
    """Places on a page, from its upper left corner, downwards [in].

    Attributes:
        height: of the page.
        shown: the ground that the top view shows, in the proportions of its box.
        top_view: left, top, width, height of the top view.
        time_plots: left, top and width of the plots over time.
        legend: left and top of the legend.
        legend_columns: how many it has.
    """

    height: float
    shown: Extent
    top_view: tuple[float, float, float, float]
    time_plots: tuple[float, float, float]
    legend: tuple[float, float]
    legend_columns: int

    def add_axes(self, figure: Figure, box: tuple[float, float, float, float]) -> Axes:
        """Axes at left, top, width, height [in]."""
        left, top, width, height = box
        bottom = self.height - top - height
        return figure.add_axes(
            (left / WIDTH, bottom / self.height, width / WIDTH, height / self.height)
        )

    def add_time_axes(self, figure: Figure) -> list[Axes]:
        """The axes of the plots over time, from the top."""
        left, top, width = self.time_plots
        axes = []
        for height in HEIGHTS:
            axes.append(self.add_axes(figure, (left, top, width, height)))
            top += height + _GAP
        return axes


def view_size(extent: Extent) -> tuple[float, float]:
    """Width and height of the top view [in]."""
    aspect = extent.size[0] / extent.size[1]
    if aspect >= LONG:
        width = WIDTH - _LEFT - _RIGHT
        return width, max(width / aspect, 1.6)
    return _COLUMN, min(_COLUMN / aspect, 5.4)


def lay_out(extent: Extent, title_height: float, push_lines: int, entries: int) -> Page:
    """Plan a page.

    Args:
        extent: the ground to show.
        title_height: what the title needs [in].
        push_lines: lines of words above the top view.
        entries: of the legend.
    """
    width, height = view_size(extent)
    top = title_height + 0.12 + LINE * push_lines
    top_view = (_LEFT, top, width, height)
    below = top + height + 0.52
    wide = extent.size[0] >= LONG * extent.size[1]
    columns = 6 if wide else 2
    legend_height = 1.15 * LINE * math.ceil(entries / columns)
    if wide:
        time_plots = (_LEFT, below + legend_height + 0.35, width)
        end = time_plots[1] + _TIME_HEIGHT
    else:
        left = _LEFT + width + 1.05
        time_plots = (left, title_height + 0.25, WIDTH - left - _RIGHT)
        end = max(time_plots[1] + _TIME_HEIGHT, below + legend_height - _FOOT)
    return Page(
        height=end + _FOOT,
        shown=extent.filling(width, height),
        top_view=top_view,
        time_plots=time_plots,
        legend=(_LEFT, below),
        legend_columns=columns,
    )

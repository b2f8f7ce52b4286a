"""A sweep over one parameter, or two of which one has few values, as lines."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from surefoot.show import palette
from surefoot.show.palette import mark
from surefoot.show.picture_file import HALO, marker_path
from surefoot.studies.sweep.axes import (
    even_grid,
    mark_endless,
    mark_missing,
    missing_handles,
    place_axis,
    span_values,
)
from surefoot.studies.sweep.columns import Column, Quantity

WIDTH, HEIGHT = 6.4, 4.0
"""Of the figure [in]."""

MOST_LINES = 6
"""A second parameter of more values is drawn as a map."""

_LEFT, _RIGHT, _FOOT, _HEAD = 0.72, 0.2, 0.62, 0.92
_DIRECT = 0.95
"""Room beside the axes for words at the end of lines [in]."""


def draw_lines(figure: Figure, columns: Sequence[Column], what: Quantity) -> None:
    """Draw the quantity over one parameter, with a line for each value of another.

    Args:
        figure: of `WIDTH` and `HEIGHT`, with room for a title.
        columns: the parameters, one or two.
        what: the quantity.
    """
    over, apart = columns[0], columns[1] if len(columns) == 2 else None
    if apart is not None and len(apart.values) > MOST_LINES:
        over, apart = apart, over
    room = WIDTH - _LEFT - _RIGHT - (_DIRECT if apart is not None else 0.0)
    ax = figure.add_axes(
        (_LEFT / WIDTH, _FOOT / HEIGHT, room / WIDTH, 1.0 - (_FOOT + _HEAD) / HEIGHT)
    )
    place_axis(ax, "x", over, room)
    even_grid(ax)
    ends: list[tuple[float, str, str]] = []
    groups = [("", np.full(len(over.places), True))]
    if apart is not None:
        groups = [
            (word, apart.places == value)
            for word, value in zip(apart.words, apart.values, strict=True)
        ]
    for row, (word, chosen) in enumerate(groups):
        ends += _draw_line(ax, over.places[chosen], what, chosen, word, row, len(groups))
    _limit_values(ax, what)
    direct = _label_ends(ax, ends, room) if apart is not None else True
    _explain(figure, ax, what, apart, groups, direct)


def _draw_line(
    ax: Axes, places: NDArray[np.float64], what: Quantity, chosen: NDArray[np.bool_], word: str,
    row: int, count: int,
) -> list[tuple[float, str, str]]:  # fmt: skip
    """A line with its limit and marks; where it ends, its word and colour. The first is the
    widest, so that lines that coincide are all seen."""
    how, order = mark(row), np.argsort(places, kind="stable")
    places, values = places[order], what.values[chosen][order]
    missing = [what.missing[index] for index in np.flatnonzero(chosen)[order]]
    shown = np.where(np.isfinite(values), values, np.nan)
    wide = 1.0 + 0.6 * (count - 1 - row)
    limits = what.limits[chosen][order]
    if np.isfinite(limits).any():
        ax.plot(
            places, limits, color=how.colour, linestyle=palette.DOTS, linewidth=0.9, zorder=1.5,
            gid=f"limit-{word}",
        )  # fmt: skip
    ax.plot(
        places, shown, color=how.colour, linewidth=wide, marker=marker_path(how),
        markersize=5.0 + 0.9 * (count - 1 - row), zorder=2.0 + 0.1 * row, gid=f"line-{word}",
    )  # fmt: skip
    mark_missing(ax, places, missing, how.colour, row, word)
    mark_endless(ax, places, values, how.colour, row, word)
    last = [value for value in shown if np.isfinite(value)]
    return [(float(last[-1]), word, how.colour)] if last else []


def _limit_values(ax: Axes, what: Quantity) -> None:
    """Room for all that is drawn, from 0 on if nothing is below."""
    if what.whether:
        ax.set_ylim(-0.15, 1.15)
        ax.set_yticks([0.0, 1.0], ["no", "yes"])
        ax.set_ylabel(what.label)
        return
    ax.set_ylabel(what.label)
    if np.isnan(what.values).all():
        ax.text(
            0.5, 0.5, "no cell has a number", transform=ax.transAxes, ha="center", va="center",
            color=palette.QUIET, gid="empty",
        )  # fmt: skip
    every = np.concatenate([what.values, what.limits])
    every = every[np.isfinite(every)]
    if not len(every):
        ax.set_yticks([])
        return
    span_values(ax, every, 0.09)


def _label_ends(ax: Axes, ends: Sequence[tuple[float, str, str]], room: float) -> bool:
    """Words beside the ends of lines, if they are far enough apart."""
    bottom, top = ax.get_ylim()
    tall = ax.get_position().height * HEIGHT
    apart = np.diff(sorted(value for value, _, _ in ends)) * tall / (top - bottom)
    longest = max((len(word) for _, word, _ in ends), default=0)
    if not ends or (apart < 0.14).any() or 0.075 * longest > _DIRECT:
        return False
    for value, word, colour in ends:
        ax.annotate(
            word, (1.0, value), xycoords=("axes fraction", "data"), xytext=(6.0, 0.0),
            textcoords="offset points", ha="left", va="center", fontsize=8.5, color=colour,
            path_effects=HALO, gid=f"label-{word}", annotation_clip=False,
        )  # fmt: skip
    return True


def _explain(
    figure: Figure, ax: Axes, what: Quantity, apart: Column | None,
    groups: Sequence[tuple[str, NDArray[np.bool_]]], direct: bool,
) -> None:  # fmt: skip
    """What marks and lines mean: above the axes; lines without words at their ends beside them."""
    width, height = figure.get_size_inches()
    box = ax.get_position()
    if apart is not None:
        figure.text(
            box.x1 + 0.1 / width, box.y1 + 0.05 / height, apart.label.replace(" [", "\n["),
            ha="left", va="bottom", fontsize=8.0, color=palette.QUIET, gid="apart",
        )  # fmt: skip
    if apart is not None and not direct:
        lines = [
            Line2D([], [], color=mark(row).colour, marker=marker_path(mark(row)), markersize=6.0,
                   linewidth=1.8, label=word)
            for row, (word, _) in enumerate(groups)
        ]  # fmt: skip
        figure.legend(
            handles=lines, loc="upper left", frameon=False, handlelength=1.6, fontsize=8.5,
            bbox_to_anchor=(box.x1 + 0.02 / width, box.y1), borderaxespad=0.0,
        )  # fmt: skip
    handles = missing_handles(what.missing, what.values)
    if np.isfinite(what.limits).any():
        handles.append(
            Line2D([], [], color=palette.QUIET, linestyle=palette.DOTS, linewidth=0.9,
                   label="theoretical limit")
        )  # fmt: skip
    if handles:
        ax.legend(
            handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False,
            ncols=len(handles), borderaxespad=0.2, fontsize=8.0, columnspacing=1.2,
        )  # fmt: skip

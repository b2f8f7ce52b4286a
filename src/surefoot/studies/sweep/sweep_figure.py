"""A sweep as a picture: lines over one parameter, a map of two, a panel for each of many."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from surefoot.checks import check_writable
from surefoot.errors import ParameterError
from surefoot.show import palette
from surefoot.show.method_marks import mark
from surefoot.show.picture_file import HALO, marker_path, write_picture
from surefoot.studies.engine.push_map import FORMATS
from surefoot.studies.sweep.sweep_axes import (
    even_grid,
    mark_endless,
    mark_missing,
    missing_handles,
    place_axis,
)
from surefoot.studies.sweep.sweep_columns import Column, Quantity, Row, column, quantity
from surefoot.studies.sweep.sweep_map import draw_map
from surefoot.studies.sweep.sweep_panels import draw_panels, panels_size

MOST_LINES = 6
"""A second parameter of more values is drawn as a map."""

_WIDTH, _HEIGHT, _LEFT, _RIGHT, _FOOT, _HEAD = 6.4, 4.0, 0.72, 0.2, 0.62, 0.72
_DIRECT = 0.95
"""Room beside the axes for words at the end of lines [in]."""


def draw_sweep(
    rows: Sequence[Row], about: Mapping[str, Any], path: Path, *, quantity: str | None = None
) -> None:
    """Draw the table of a sweep into a file.

    Args:
        rows: of the table.
        about: `title`, `robot`, `controller`, `sampling`, and `varied`: the names of the parameters
            that differ, in order.
        path: file to write; its ending names the format (.png, .pdf, .svg).
        quantity: column that is drawn; the smallest failing impulse, or who survived, if None.

    Raises:
        FileError: another ending, or the file cannot be written.
        ParameterError: no rows, no such column, or nothing varies.
    """
    path = Path(path)
    check_writable(path, FORMATS)
    with style.context(["default", palette.STYLE]):
        figure = sweep_figure(rows, about, quantity)
    write_picture(figure, path, figure.get_suptitle())


def sweep_figure(rows: Sequence[Row], about: Mapping[str, Any], name: str | None = None) -> Figure:
    """The table of a sweep as a figure of its own, not known to pyplot; see `draw_sweep`.

    Raises:
        ParameterError: no rows, no such column, or nothing varies.
    """
    varied = list(about["varied"])
    if not varied:
        raise ParameterError("at least one varied parameter", "none", "name one in [vary]")
    what = quantity(rows, varied, name)
    columns = [column(rows, one, about.get("controller")) for one in varied]
    drawn = about.get("sampling", "grid") != "grid"
    if drawn or len(columns) > 2:
        figure = Figure(figsize=panels_size(len(columns)), facecolor="white")
        draw_panels(figure, columns, what)
    elif len(columns) == 2 and (
        what.whether or min(len(one.values) for one in columns) > MOST_LINES
    ):
        figure = Figure(figsize=(_WIDTH, _HEIGHT + 0.4), facecolor="white")
        draw_map(figure, columns[0], columns[1], what)
    else:
        figure = Figure(figsize=(_WIDTH, _HEIGHT), facecolor="white")
        _draw_lines(figure, columns, what)
    _write_title(figure, about, what, len(rows))
    return figure


def _write_title(figure: Figure, about: Mapping[str, Any], what: Quantity, count: int) -> None:
    width, height = figure.get_size_inches()
    title = fill(str(about.get("title") or "a sweep"), int(11.5 * width))
    sampling = about.get("sampling", "grid")
    figure.suptitle(
        title, x=0.14 / width, y=1.0 - 0.1 / height, ha="left", va="top", fontsize=10.5,
        fontweight="bold",
    )  # fmt: skip
    words = [about.get("robot"), about.get("controller"),
             f"{count} cells" if sampling == "grid" else f"{count} cells, {sampling}"]  # fmt: skip
    lines = title.count("\n")
    figure.text(
        0.14 / width, 1.0 - (0.33 + 0.17 * lines) / height, " · ".join(str(w) for w in words if w),
        ha="left", va="top", fontsize=8.5, color=palette.QUIET, gid="about",
    )  # fmt: skip


def _draw_lines(figure: Figure, columns: Sequence[Column], what: Quantity) -> None:
    """The quantity over one parameter, with a line for each value of another."""
    over, apart = columns[0], columns[1] if len(columns) == 2 else None
    if apart is not None and len(apart.values) > MOST_LINES:
        over, apart = apart, over
    head = _HEAD + 0.2
    room = _WIDTH - _LEFT - _RIGHT - (_DIRECT if apart is not None else 0.0)
    ax = figure.add_axes(
        (_LEFT / _WIDTH, _FOOT / _HEIGHT, room / _WIDTH, 1.0 - (_FOOT + head) / _HEIGHT)
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
    low, high = float(every.min()), float(every.max())
    room = 0.09 * ((high - min(low, 0.0)) or 1.0)
    ax.set_ylim(0.0 if low >= 0.0 else low - room, high + room)


def _label_ends(ax: Axes, ends: Sequence[tuple[float, str, str]], room: float) -> bool:
    """Words beside the ends of lines, if they are far enough apart."""
    bottom, top = ax.get_ylim()
    tall = ax.get_position().height * _HEIGHT
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
                   label="limit for anybody")
        )  # fmt: skip
    if handles:
        ax.legend(
            handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False,
            ncols=len(handles), borderaxespad=0.2, fontsize=8.0, columnspacing=1.2,
        )  # fmt: skip

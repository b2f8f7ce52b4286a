"""The picture of a sweep: lines over one parameter, a map of two, or a panel for each of many."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib import colormaps, style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from surefoot.checks import check_writable
from surefoot.show import palette
from surefoot.show.palette import mark
from surefoot.show.picture_file import FORMATS, HALO, marker_path, write_picture
from surefoot.studies.engine.pictures import add_box, headline
from surefoot.studies.engine.study import Measured
from surefoot.studies.sweep.axes import (
    NOTHING_FAILED,
    Bin,
    Column,
    Quantity,
    bins,
    column,
    even_grid,
    limit_values,
    mark_endless,
    mark_missing,
    missing_handles,
    name_places,
    place_axis,
    quantity,
    quantity_name,
    wilson,
)
from surefoot.studies.sweep.measure import RESULTS
from surefoot.studies.sweep.question import Sweep

WIDTH, HEIGHT, MAP_HEIGHT = 6.4, 4.0, 4.4
"""Of lines and of a map [in]."""

MAX_LINES = 6
"""A second parameter of more values is drawn as a map."""

_LINES = (0.72, 0.2, 0.62, 0.92)
_MAP = (0.95, 1.05, 0.72, 0.95)
"""Room beside, below and above the axes: left, right, foot, head [in]."""

_DIRECT = 0.95
"""Room for words at the end of lines [in]."""

_YES, _NO, _NONE, _POINT = "#a6cbe3", "#d55e00", "#f2f2f2", "#777777"
_COLOURS = "viridis"
_WRITTEN = 80
"""In no more cells than these stand their numbers."""

_ACROSS, _PANEL, _TALL, _LEFT, _RIGHT, _GAP, _BELOW, _HEAD, _ROW_HEAD = (
    3, 2.45, 1.9, 0.72, 0.2, 0.3, 0.62, 0.78, 0.24,
)  # fmt: skip


def draw_sweep(measured: Measured[Sweep], path: Path, name: str | None = None) -> None:
    """Draw the table of a sweep into a file.

    Args:
        measured: the sweep.
        path: file to write; its ending names the format (.png, .pdf, .svg).
        name: column that is drawn; the smallest failing impulse, or who survived, if None.

    Raises:
        FileError: another ending, or the file cannot be written.
        ParameterError: no such column.
    """
    path = Path(path)
    check_writable(path, FORMATS)
    with style.context(["default", palette.STYLE]):
        figure = sweep_figure(measured, name)
    write_picture(figure, path, figure.get_suptitle())


def sweep_figure(measured: Measured[Sweep], name: str | None = None) -> Figure:
    """The table of a sweep as a figure of its own, not known to pyplot; see `draw_sweep`.

    Raises:
        ParameterError: no such column.
    """
    rows, study = measured.rows, measured.study
    name = quantity_name(study.measures, name)
    what = quantity(rows, name, RESULTS[study.measures][name])
    columns = [column(rows, one, study.controller) for one in study.vary]
    crowded = what.whether or min(len(one.values) for one in columns) > MAX_LINES
    if study.sampling != "grid" or len(columns) > 2:
        figure = _panels(columns, what)
    elif len(columns) == 2 and crowded:
        figure = _map(columns[0], columns[1], what)
    else:
        figure = _lines(columns, what)
    _write_title(figure, measured)
    return figure


def _write_title(figure: Figure, measured: Measured[Sweep]) -> None:
    study, (width, height) = measured.study, figure.get_size_inches()
    title = fill(study.title or "a sweep", int(11.5 * width))
    headline(figure, title, left=0.14, down=0.1, size=10.5)
    count = f"{len(measured.rows)} cells"
    words = [measured.provenance["robot"], study.controller,
             count if study.sampling == "grid" else f"{count}, {study.sampling}"]  # fmt: skip
    lines = title.count("\n")
    figure.text(
        0.14 / width, 1.0 - (0.33 + 0.17 * lines) / height, " · ".join(words),
        ha="left", va="top", fontsize=8.5, color=palette.QUIET, gid="about",
    )  # fmt: skip


def _sheet(width: float, height: float) -> Figure:
    return Figure(figsize=(width, height), facecolor="white")


def _inside(figure: Figure, left: float, right: float, foot: float, head: float) -> Axes:
    """Axes that fill a figure but for the room around them [in]."""
    width, height = figure.get_size_inches()
    return add_box(figure, left, head, width - left - right, height - foot - head)


Group = tuple[str, NDArray[np.bool_]]
"""The cells of a line, and their word."""


def _lines(columns: Sequence[Column], what: Quantity) -> Figure:
    """The quantity over one parameter, with a line for each value of another."""
    over, other = columns[0], columns[1] if len(columns) == 2 else None
    if other is not None and len(other.values) > MAX_LINES:
        over, other = other, over
    figure, (left, right, foot, head) = _sheet(WIDTH, HEIGHT), _LINES
    right += _DIRECT if other is not None else 0.0
    ax, room = _inside(figure, left, right, foot, head), WIDTH - left - right
    place_axis(ax, "x", over, room)
    even_grid(ax)
    groups: list[Group] = [("", np.full(len(over.places), True))]
    if other is not None:
        pairs = zip(other.words, other.values, strict=True)
        groups = [(word, other.places == value) for word, value in pairs]
    ends = [
        end
        for row, group in enumerate(groups)
        for end in _draw_line(ax, over.places, what, group, row, len(groups))
    ]
    limit_values(ax, what, 0.09)
    ax.set_ylabel(what.label)
    if other is not None:
        _name_lines(figure, ax, other, groups, _label_ends(ax, ends))
    handles: list[Artist] = [*missing_handles(what.missing, what.values)]
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
    return figure


def _draw_line(
    ax: Axes, every: NDArray[np.float64], what: Quantity, group: Group, row: int, count: int
) -> list[tuple[float, str, str]]:
    """A line with its limit and marks; where it ends, its word and colour. The first is the
    widest, so that lines that coincide are all seen."""
    word, chosen = group
    how, order = mark(row), np.argsort(every[chosen], kind="stable")
    places, values = every[chosen][order], what.values[chosen][order]
    missing = [what.missing[index] for index in np.flatnonzero(chosen)[order]]
    shown = np.where(np.isfinite(values), values, np.nan)
    behind = count - 1 - row
    limits = what.limits[chosen][order]
    if np.isfinite(limits).any():
        ax.plot(
            places, limits, color=how.colour, linestyle=palette.DOTS, linewidth=0.9, zorder=1.5,
            gid=f"limit-{word}",
        )  # fmt: skip
    ax.plot(
        places, shown, color=how.colour, linewidth=1.0 + 0.6 * behind, marker=marker_path(how),
        markersize=5.0 + 0.9 * behind, zorder=2.0 + 0.1 * row, gid=f"line-{word}",
    )  # fmt: skip
    mark_missing(ax, places, missing, how.colour, row, word)
    mark_endless(ax, places, values, how.colour, row, word)
    last = [value for value in shown if np.isfinite(value)]
    return [(float(last[-1]), word, how.colour)] if last else []


def _label_ends(ax: Axes, ends: Sequence[tuple[float, str, str]]) -> bool:
    """Words beside the ends of lines, if they are far enough from each other."""
    bottom, top = ax.get_ylim()
    tall = ax.get_position().height * HEIGHT
    distances = np.diff(sorted(value for value, _, _ in ends)) * tall / (top - bottom)
    longest = max((len(word) for _, word, _ in ends), default=0)
    if not ends or (distances < 0.14).any() or 0.075 * longest > _DIRECT:
        return False
    for value, word, colour in ends:
        ax.annotate(
            word, (1.0, value), xycoords=("axes fraction", "data"), xytext=(6.0, 0.0),
            textcoords="offset points", ha="left", va="center", fontsize=8.5, color=colour,
            path_effects=HALO, gid=f"label-{word}", annotation_clip=False,
        )  # fmt: skip
    return True


def _name_lines(
    figure: Figure, ax: Axes, other: Column, groups: Sequence[Group], direct: bool
) -> None:
    """The parameter by which lines differ; its values, unless they stand at the ends."""
    (width, height), box = figure.get_size_inches(), ax.get_position()
    figure.text(
        box.x1 + 0.1 / width, box.y1 + 0.05 / height, other.label.replace(" [", "\n["),
        ha="left", va="bottom", fontsize=8.0, color=palette.QUIET, gid="apart",
    )  # fmt: skip
    if direct:
        return
    lines = [
        Line2D([], [], color=mark(row).colour, marker=marker_path(mark(row)), markersize=6.0,
               linewidth=1.8, label=word)
        for row, (word, _) in enumerate(groups)
    ]  # fmt: skip
    figure.legend(
        handles=lines, loc="upper left", frameon=False, handlelength=1.6, fontsize=8.5,
        bbox_to_anchor=(box.x1 + 0.02 / width, box.y1), borderaxespad=0.0,
    )  # fmt: skip


def _map(over: Column, up: Column, what: Quantity) -> Figure:
    """The quantity over two parameters, as colours and numbers."""
    figure = _sheet(WIDTH, MAP_HEIGHT)
    ax = _inside(figure, *_MAP)
    finite = what.values[np.isfinite(what.values)]
    scale = Normalize(*((finite.min(), finite.max()) if len(finite) else (0.0, 1.0)))
    written = len(what.values) <= _WRITTEN and not what.whether
    for place, high, value, missing in zip(
        over.places, up.places, what.values, what.missing, strict=True
    ):
        x = int(np.searchsorted(over.values, place))
        y = int(np.searchsorted(up.values, high))
        shade = 0.0 if missing else scale(min(value, scale.vmax or value))
        if missing:
            face, hatch = _NONE, "////"
        elif what.whether:
            face, hatch = (_YES if value else _NO), None
        else:
            face, hatch = colormaps[_COLOURS](shade), None
        ax.add_patch(
            Rectangle((x - 0.5, y - 0.5), 1.0, 1.0, facecolor=face, hatch=hatch,
                      edgecolor="#8a8a8a" if missing else "white", linewidth=0.8,
                      gid=f"{'missing' if missing else 'cell'}-{x}-{y}")
        )  # fmt: skip
        if written and not missing:
            ax.text(
                x, y, f"{value:.3g}" if np.isfinite(value) else "↑", ha="center", va="center",
                fontsize=7.5, color="white" if shade < 0.55 else "#111111", gid=f"word-{x}-{y}",
            )  # fmt: skip
    room = ax.get_position()
    middles = [np.arange(len(one.values), dtype=float) for one in (over, up)]
    name_places(ax, "x", middles[0], over.words, room.width * WIDTH)
    name_places(ax, "y", middles[1], up.words, room.height * MAP_HEIGHT)
    ax.set(xlabel=over.label, ylabel=up.label)
    ax.tick_params(length=0.0)
    _explain_map(figure, what, scale)
    return figure


def _explain_map(figure: Figure, what: Quantity, scale: Normalize) -> None:
    """The scale of colours, or what the two colours mean, and the hatched cells."""
    left, _, foot, head = _MAP
    edge = {"edgecolor": "#8a8a8a", "linewidth": 0.8}
    reasons = ", ".join(sorted({one for one in what.missing if one}))
    handles = [Patch(facecolor=_NONE, hatch="////", label=reasons, **edge)] if reasons else []
    if what.whether:
        words = {_YES: what.label, _NO: f"not {what.label}"}
        handles = [Patch(facecolor=c, label=word, **edge) for c, word in words.items()] + handles
    else:
        bar = add_box(figure, WIDTH - 0.85, head, 0.14, MAP_HEIGHT - foot - head)
        figure.colorbar(ScalarMappable(scale, _COLOURS), cax=bar, label=what.label)
        if np.isinf(what.values).any():
            handles.append(Patch(facecolor=colormaps[_COLOURS](1.0), label=f"↑ {NOTHING_FAILED}"))
    if handles:
        figure.legend(
            handles=handles, loc="lower left", frameon=False, ncols=len(handles), fontsize=8.0,
            bbox_to_anchor=(left / WIDTH, 1.0 - head / MAP_HEIGHT), borderaxespad=0.2,
        )  # fmt: skip


def _panels(columns: Sequence[Column], what: Quantity) -> Figure:
    """The quantity over each of many parameters, or over values that are drawn."""
    across = min(len(columns), _ACROSS)
    rows = math.ceil(len(columns) / across)
    width = max(_LEFT + across * _PANEL + (across - 1) * _GAP + _RIGHT, 5.0)
    figure = _sheet(width, _HEAD + rows * (_ROW_HEAD + _TALL + _BELOW))
    room = (width - _LEFT - _RIGHT - (across - 1) * _GAP) / across
    for number, one in enumerate(columns):
        row, place = divmod(number, across)
        down = _HEAD + _ROW_HEAD + row * (_ROW_HEAD + _TALL + _BELOW)
        ax = add_box(figure, _LEFT + place * (room + _GAP), down, room, _TALL)
        place_axis(ax, "x", one, room)
        even_grid(ax)
        limit_values(ax, what, 0.08, share=True)
        _draw_panel(ax, one, what)
        ax.tick_params(labelleft=place == 0)
        if place == 0:
            ax.set_ylabel(f"share that {what.label}" if what.whether else what.label)
    _explain_panels(figure, what)
    return figure


def _draw_panel(ax: Axes, one: Column, what: Quantity) -> None:
    """Shares or medians of the bins, with their range on top: how much the parameter matters."""
    usable = np.isfinite(what.values)
    found = bins(one, usable) if usable.any() else []
    draw = _draw_shares if what.whether else _draw_numbers
    levels = draw(ax, one, what, found)
    if levels:
        low, high = min(levels), max(levels)
        words = f"{low:.0%} – {high:.0%}" if what.whether else f"{low:.3g} – {high:.3g}"
        ax.set_title(words, loc="right", fontsize=8.0, color=palette.DCM, pad=3.0, gid=one.name)
    mark_missing(ax, one.places, what.missing, palette.QUIET, 0, one.name)
    mark_endless(ax, one.places, what.values, palette.QUIET, 0, one.name)


def _draw_shares(ax: Axes, one: Column, what: Quantity, found: Sequence[Bin]) -> list[float]:
    """How many of each bin survived, with the interval of that share."""
    shares = []
    for each in found:
        values = what.values[each.members]
        low, high = wilson(int(values.sum()), len(values))
        ax.plot(
            [each.place] * 2, [low, high], color=palette.DCM, linewidth=1.3, zorder=2.0,
            gid=f"interval-{one.name}-{each.place:.6g}",
        )  # fmt: skip
        shares.append(float(values.mean()))
    ax.plot(
        [each.place for each in found], shares, color=palette.DCM, marker="o", markersize=5.0,
        linewidth=0.8, linestyle="solid" if one.numeric else "none", zorder=3.0,
        gid=f"share-{one.name}",
    )  # fmt: skip
    return shares


def _draw_numbers(ax: Axes, one: Column, what: Quantity, found: Sequence[Bin]) -> list[float]:
    """Every cell as a point, and the median of each bin."""
    ax.plot(
        one.places, np.where(np.isfinite(what.values), what.values, np.nan), marker="o",
        markersize=3.2, markeredgewidth=0.0, alpha=0.35, color=_POINT, linestyle="none",
        zorder=2.0, gid=f"points-{one.name}",
    )  # fmt: skip
    medians = [float(np.median(what.values[each.members])) for each in found]
    ax.plot(
        [each.place for each in found], medians, color=palette.DCM, marker="D", markersize=4.5,
        linewidth=1.6, linestyle="solid" if one.numeric else "none", zorder=3.0,
        gid=f"median-{one.name}",
    )  # fmt: skip
    return medians


def _explain_panels(figure: Figure, what: Quantity) -> None:
    share = "share of a bin, 95 % interval; its range over the bins on top"
    looks = [(share, palette.DCM, "o", 5.0, 1.3, 1.0)] if what.whether else [
        ("a cell", _POINT, "o", 3.5, 0.0, 0.6),
        ("median of a bin; its range on top", palette.DCM, "D", 4.5, 1.6, 1.0),
    ]  # fmt: skip
    handles = [
        Line2D([], [], label=label, color=colour, marker=sign, markersize=size, linewidth=line,
               alpha=alpha)
        for label, colour, sign, size, line, alpha in looks
    ]  # fmt: skip
    handles += missing_handles(what.missing, what.values)
    width, height = figure.get_size_inches()
    figure.legend(
        handles=handles, loc="upper left", frameon=False, ncols=len(handles), fontsize=8.0,
        bbox_to_anchor=(0.1 / width, 1.0 - 0.48 / height), columnspacing=1.4, borderaxespad=0.0,
    )  # fmt: skip

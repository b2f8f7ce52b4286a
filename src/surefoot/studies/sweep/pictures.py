"""The picture of a sweep: lines over one parameter, a map of two, or a panel for each of many."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib import colormaps, style
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from surefoot.checks import check_writable
from surefoot.show import palette
from surefoot.show.picture_file import FORMATS, write_picture
from surefoot.studies.engine.pictures import headline
from surefoot.studies.engine.study import Measured
from surefoot.studies.sweep.axes import NOTHING_FAILED, name_places
from surefoot.studies.sweep.columns import Column, Quantity, column, quantity, quantity_name
from surefoot.studies.sweep.lines import HEIGHT, MOST_LINES, WIDTH, draw_lines
from surefoot.studies.sweep.measure import RESULTS
from surefoot.studies.sweep.panels import draw_panels, panels_size
from surefoot.studies.sweep.question import Sweep

_LEFT, _RIGHT, _FOOT, _HEAD = 0.95, 1.05, 0.72, 0.95
_YES, _NO, _NONE = "#a6cbe3", "#d55e00", "#f2f2f2"
_COLOURS = "viridis"
_WRITTEN = 80
"""In no more cells than these stand their numbers."""


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
    if study.sampling != "grid" or len(columns) > 2:
        figure = Figure(figsize=panels_size(len(columns)), facecolor="white")
        draw_panels(figure, columns, what)
    elif len(columns) == 2 and (
        what.whether or min(len(one.values) for one in columns) > MOST_LINES
    ):
        figure = Figure(figsize=(WIDTH, HEIGHT + 0.4), facecolor="white")
        draw_map(figure, columns[0], columns[1], what)
    else:
        figure = Figure(figsize=(WIDTH, HEIGHT), facecolor="white")
        draw_lines(figure, columns, what)
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


def draw_map(figure: Figure, over: Column, up: Column, what: Quantity) -> None:
    """Draw a map into an empty figure.

    Args:
        figure: with room for a title.
        over: the parameter along x.
        up: the parameter along y.
        what: the quantity.
    """
    width, height = figure.get_size_inches()
    room = width - _LEFT - _RIGHT, height - _FOOT - _HEAD
    ax = figure.add_axes((_LEFT / width, _FOOT / height, room[0] / width, room[1] / height))
    finite = what.values[np.isfinite(what.values)]
    scale = Normalize(*((finite.min(), finite.max()) if len(finite) else (0.0, 1.0)))
    from_scale = colormaps[_COLOURS]
    written = len(what.values) <= _WRITTEN and not what.whether
    for place, high, value, missing in zip(
        over.places, up.places, what.values, what.missing, strict=True
    ):
        x = int(np.searchsorted(over.values, place))
        y = int(np.searchsorted(up.values, high))
        name = f"{x}-{y}"
        if missing:
            face, hatch = _NONE, "////"
        elif what.whether:
            face, hatch = (_YES if value else _NO), None
        else:
            face, hatch = from_scale(scale(min(value, scale.vmax or value))), None
        ax.add_patch(
            Rectangle((x - 0.5, y - 0.5), 1.0, 1.0, facecolor=face, hatch=hatch,
                      edgecolor="#8a8a8a" if missing else "white", linewidth=0.8,
                      gid=f"{'missing' if missing else 'cell'}-{name}")
        )  # fmt: skip
        if written and not missing:
            dark = scale(min(value, scale.vmax or value)) < 0.55
            ax.text(
                x, y, f"{value:.3g}" if np.isfinite(value) else "↑", ha="center", va="center",
                fontsize=7.5, color="white" if dark else "#111111", gid=f"word-{name}",
            )  # fmt: skip
    name_places(ax, "x", np.arange(len(over.values), dtype=float), over.words, room[0])
    name_places(ax, "y", np.arange(len(up.values), dtype=float), up.words, room[1])
    ax.set_xlabel(over.label)
    ax.set_ylabel(up.label)
    ax.tick_params(length=0.0)
    _explain(figure, what, scale)


def _explain(figure: Figure, what: Quantity, scale: Normalize) -> None:
    """The scale of colours, or what the two colours mean, and the hatched cells."""
    width, height = figure.get_size_inches()
    edge = {"edgecolor": "#8a8a8a", "linewidth": 0.8}
    handles = [
        Patch(facecolor=_NONE, hatch="////", label=reason, **edge)
        for reason in [", ".join(sorted({one for one in what.missing if one}))]
        if reason
    ]
    if what.whether:
        words = {_YES: what.label, _NO: f"not {what.label}"}
        handles = [Patch(facecolor=c, label=word, **edge) for c, word in words.items()] + handles
    else:
        bar = figure.add_axes(
            (1.0 - 0.85 / width, _FOOT / height, 0.14 / width, 1.0 - (_FOOT + _HEAD) / height)
        )
        figure.colorbar(ScalarMappable(scale, _COLOURS), cax=bar, label=what.label)
        if np.isinf(what.values).any():
            handles.append(Patch(facecolor=colormaps[_COLOURS](1.0), label=f"↑ {NOTHING_FAILED}"))
    if handles:
        figure.legend(
            handles=handles, loc="lower left", frameon=False, ncols=len(handles), fontsize=8.0,
            bbox_to_anchor=(_LEFT / width, 1.0 - _HEAD / height), borderaxespad=0.2,
        )  # fmt: skip

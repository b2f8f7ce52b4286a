"""A sweep in the terminal and as a picture: lines over one parameter, a map of two, many panels."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from textwrap import fill
from typing import Any

from matplotlib import style
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from surefoot.checks import check_writable
from surefoot.show import palette
from surefoot.show.picture_file import write_picture
from surefoot.studies.engine.push_map import FORMATS
from surefoot.studies.sweep.columns import column, quantity, quantity_name
from surefoot.studies.sweep.lines import HEIGHT, MOST_LINES, WIDTH, draw_lines
from surefoot.studies.sweep.map import draw_map
from surefoot.studies.sweep.measure import RESULTS
from surefoot.studies.sweep.panels import draw_panels, panels_size
from surefoot.studies.sweep.sweep import SweepTable

MOST_ROWS = 40
"""A table that is longer is for a file."""


def print_sweep(measured: SweepTable, console: Console) -> None:
    """Print how the cells came out, and the cells themselves if they are few."""
    rows, study = measured.rows, measured.study
    counts = Counter(row["outcome"] for row in rows)
    words = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    console.print(f"[bold]{study.title}[/bold]: {len(rows)} cells: {words}", highlight=False)
    for error, count in Counter(row.get("error") for row in rows).most_common(4):
        if error is not None:
            console.print(f"  {count} x {error}", highlight=False, markup=False)
    if len(rows) > MOST_ROWS:
        return
    shown = {name: one.head for name, one in RESULTS[study.measures].items() if one.head}
    table = Table(box=None, pad_edge=False)
    for name in (*study.vary, *shown.values()):
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(*(_word(row.get(name)) for name in (*study.vary, *shown)))
    console.print(table)


def _word(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)) or value == -1:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def draw_sweep(measured: SweepTable, path: Path, name: str | None = None) -> None:
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


def sweep_figure(measured: SweepTable, name: str | None = None) -> Figure:
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


def _write_title(figure: Figure, measured: SweepTable) -> None:
    study, (width, height) = measured.study, figure.get_size_inches()
    title = fill(study.title or "a sweep", int(11.5 * width))
    figure.suptitle(
        title, x=0.14 / width, y=1.0 - 0.1 / height, ha="left", va="top", fontsize=10.5,
        fontweight="bold",
    )  # fmt: skip
    count = f"{len(measured.rows)} cells"
    words = [measured.provenance["robot"], study.controller,
             count if study.sampling == "grid" else f"{count}, {study.sampling}"]  # fmt: skip
    lines = title.count("\n")
    figure.text(
        0.14 / width, 1.0 - (0.33 + 0.17 * lines) / height, " · ".join(words),
        ha="left", va="top", fontsize=8.5, color=palette.QUIET, gid="about",
    )  # fmt: skip

"""The report of walks of bodies while something is wrong: Markdown, and one picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from surefoot.show import palette
from surefoot.show.picture_file import picture_bytes
from surefoot.show.plain_table import markdown_table
from surefoot.show.report_files import write_files
from surefoot.studies.compare.body_walks import NOTE, BodyWalks, falls_table, walk_table
from surefoot.version import VERSION

TEXT, PICTURE = "walks.md", "walks.png"
"""Names of the files."""

HEADING = "What a body walks through"

_LABELS, _PANEL, _ROW, _HEAD, _FOOT, _GAP = 3.3, 2.6, 0.24, 0.75, 0.95, 0.25

_TRACKING = {"marker": "o", "color": palette.DCM, "linestyle": "none", "markersize": 4.5}
_ESTIMATE = {
    "marker": "o", "color": palette.COM_PLAN, "linestyle": "none", "markersize": 4.5,
    "fillstyle": "none",
}  # fmt: skip
_FALL = {"marker": "X", "color": palette.ALARM, "linestyle": "none", "markersize": 7.0}


def write_walk_report(measured: Sequence[BodyWalks], folder: Path) -> list[Path]:
    """Write text and picture; the same walks make the same bytes.

    Args:
        measured: the walks, of one robot each.
        folder: where to write; it exists.

    Returns:
        The files, the text first.

    Raises:
        FileError: the folder cannot be written to.
    """
    with style.context(["default", palette.STYLE]):
        figure = walk_figure(measured)
    files = {
        TEXT: walk_text(measured).encode(),
        PICTURE: picture_bytes(figure, "png", figure.get_suptitle()),
    }
    return write_files(files, folder)


def walk_text(measured: Sequence[BodyWalks]) -> str:
    """The report in Markdown."""
    lines = [f"# {HEADING}", "", f"Surefoot {VERSION}. {NOTE}", ""]
    lines += [f"![Every walk: how far the DCM was off, or that it fell]({PICTURE})", ""]
    for one in measured:
        for method, _ in one.methods:
            table = walk_table(one, method)
            lines += [f"## {table.title}", ""]
            lines += markdown_table(table.columns, table.rows)
        if one.falls:
            table = falls_table(one)
            lines += [f"### {table.title}", "", *markdown_table(table.columns, table.rows)]
    for one in measured:
        lines += [f"## Provenance of {one.robot}", ""]
        lines += markdown_table(("what", "value"), list(one.provenance.items()))
    return "\n".join(lines)


def walk_figure(measured: Sequence[BodyWalks]) -> Figure:
    """A row for each condition, a panel for each robot and method, a dot for each walk.

    Args:
        measured: the walks, of one robot each.

    Returns:
        A figure of its own, not known to pyplot.
    """
    panels = [(one, method) for one in measured for method, _ in one.methods]
    conditions = list(dict.fromkeys(pair for one in measured for pair in one.conditions))
    width = _LABELS + (_PANEL + _GAP) * len(panels)
    height = _HEAD + _ROW * len(conditions) + _FOOT
    figure = Figure(figsize=(width, height), facecolor="white")
    for column, (one, method) in enumerate(panels):
        left = _LABELS + column * (_PANEL + _GAP)
        ax = figure.add_axes(
            (left / width, _FOOT / height, _PANEL / width, 1.0 - (_HEAD + _FOOT) / height)
        )
        _draw_panel(ax, one, method, [key for key, _ in conditions])
        ax.set_yticks(range(len(conditions)))
        ax.set_yticklabels([label for _, label in conditions] if column == 0 else [])
        ax.set_title(one.title(method), fontsize=9.5, fontweight="bold")
    figure.suptitle(
        HEADING, x=0.2 / width, y=1.0 - 0.12 / height, ha="left", va="top", fontsize=12.0,
        fontweight="bold",
    )  # fmt: skip
    handles = [
        Line2D([], [], label=label, **look)
        for look, label in (
            (_TRACKING, "DCM off its plan"),
            (_ESTIMATE, "its estimate off the truth"),
            (_FALL, "fell, after how long"),
        )
    ]
    figure.legend(handles=handles, loc="lower left", ncol=3, frameon=False)
    return figure


def _draw_panel(ax: Axes, measured: BodyWalks, method: str, conditions: Sequence[str]) -> None:
    errors = [1e3 * one.dcm_error for one in measured.walks if one.walked]
    right = 1.15 * max([10.0, *errors])
    ax.set_xlim(0.0, right)
    ax.set_ylim(len(conditions) - 0.4, -0.6)
    ax.set_xlabel("root mean square [mm]")
    ax.grid(axis="x", color="#e4e4e4", linewidth=0.5)
    ax.set_axisbelow(True)
    ax.tick_params(axis="y", length=0.0)
    for row, key in enumerate(conditions):
        walks = measured.of(method, key)
        stood = [one for one in walks if one.walked]
        name = f"{measured.robot}-{method}-{key}"
        for values, look, kind in (
            ([1e3 * one.dcm_error for one in stood], _TRACKING, "tracking"),
            ([1e3 * one.estimate_error for one in stood], _ESTIMATE, "estimate"),
        ):
            ax.plot(values, [row] * len(values), gid=f"{kind}-{name}", **look)
        fell = [one.time for one in walks if not one.walked]
        if fell:
            ax.plot([0.93 * right], [row], gid=f"fell-{name}", **_FALL)
            words = ", ".join(f"{time:.0f}" for time in fell) + " s"
            ax.text(
                0.88 * right, row, words, ha="right", va="center", fontsize=7.5,
                color=palette.ALARM,
            )  # fmt: skip

"""The noise-and-delay budget as a picture: one field for each method and disturbance."""

from __future__ import annotations

import math
from pathlib import Path

from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from surefoot.checks import check_writable
from surefoot.show import palette
from surefoot.show.picture_file import write_picture
from surefoot.studies.compare.budget import UNDISTURBED, Budget, Kept
from surefoot.studies.engine.push_map import FORMATS

_LABELS, _ROW, _COLUMN, _HEAD, _FOOT, _RIGHT = 2.45, 0.42, 0.5, 2.15, 0.85, 1.2
_CHANGES = LinearSegmentedColormap.from_list(
    "changes", ["#f08a3c", "#ffffff", "#5fb3e6"]
)  # fmt: skip
_RANGE = Normalize(-0.5, 0.5, clip=True)
"""Change of the share, as a fraction of what it was undisturbed."""


def draw_budget(measured: Budget, path: Path) -> None:
    """Draw the budget into a file.

    Args:
        measured: the budget.
        path: file to write; its ending names the format (.png, .pdf, .svg).

    Raises:
        FileError: another ending, or the file cannot be written.
    """
    path = Path(path)
    check_writable(path, FORMATS)
    with style.context(["default", palette.STYLE]):
        figure = budget_figure(measured)
    write_picture(figure, path, figure.get_suptitle())


def budget_figure(measured: Budget) -> Figure:
    """A field for each method (row) and disturbance (column): share of the limit, and N s lost.

    Args:
        measured: the budget.

    Returns:
        A figure of its own, not known to pyplot.
    """
    rows, columns = len(measured.methods), len(measured.wrongs)
    width = max(_LABELS + _COLUMN * columns + _RIGHT, 7.0)
    height = _HEAD + _ROW * rows + _FOOT
    figure = Figure(figsize=(width, height), facecolor="white")
    box = (_LABELS, _FOOT, _COLUMN * columns, _ROW * rows)
    ax = figure.add_axes(
        (box[0] / width, box[1] / height, box[2] / width, box[3] / height),
    )  # fmt: skip
    ax.set_xlim(0.0, columns)
    ax.set_ylim(rows, 0.0)
    ax.set_yticks([row + 0.5 for row in range(rows)])
    ax.set_yticklabels([label for _, label in measured.methods], fontsize=8.5)
    ax.xaxis.tick_top()
    ax.set_xticks([column + 0.5 for column in range(columns)])
    ax.set_xticklabels(
        [wrong.label for wrong in measured.wrongs], fontsize=8.0, rotation=45.0, ha="left",
        rotation_mode="anchor",
    )  # fmt: skip
    ax.tick_params(length=0.0)
    for spine in ax.spines.values():
        spine.set_visible(False)
    for row, (method, _) in enumerate(measured.methods):
        for column, wrong in enumerate(measured.wrongs):
            kept = measured.kept.get((method, wrong.key))
            _draw_field(ax, row, column, kept, wrong.key, method)
    robot = measured.provenance.get("robot", "")
    figure.suptitle(
        "  ·  ".join(part for part in (robot, "what is left of the margin") if part),
        x=0.25 / width, y=1.0 - 0.14 / height, ha="left", va="top", fontsize=12.0,
        fontweight="bold",
    )  # fmt: skip
    _explain(figure, width, height)
    return figure


def _draw_field(
    ax: Axes, row: int, column: int, kept: Kept | None, wrong: str, method: str
) -> None:
    colour = "#f0f0f0"
    if kept is not None and wrong != UNDISTURBED and not math.isnan(kept.change):
        colour = _CHANGES(_RANGE(kept.change))
    ax.add_patch(
        Rectangle(
            (column, row),
            1.0,
            1.0,
            facecolor=colour,
            edgecolor="white",
            linewidth=1.5,
            gid=f"field-{method}-{wrong}",
        )
    )  # fmt: skip
    if kept is None:
        ax.text(column + 0.5, row + 0.5, "–", ha="center", va="center", color=palette.QUIET)
        return
    alone = wrong == UNDISTURBED or math.isnan(kept.lost)
    ax.text(
        column + 0.5, row + (0.5 if alone else 0.36), f"{100.0 * kept.share:.0f}",
        ha="center", va="center", fontsize=9.0, fontweight="bold" if alone else "normal",
    )  # fmt: skip
    if not alone:
        ax.text(
            column + 0.5, row + 0.75, lost_words(kept.lost), ha="center", va="center",
            fontsize=6.5, color="#333333",
        )  # fmt: skip


def lost_words(lost: float) -> str:
    """What was lost as a change, with its sign and a real minus; – if it is not known [N s]."""
    if math.isnan(lost):
        return "–"
    text = f"{-lost:+.1f}" if abs(lost) < 9.95 else f"{-lost:+.0f}"
    return "0" if float(text) == 0.0 else text.replace("-", "\N{MINUS SIGN}")


def _explain(figure: Figure, width: float, height: float) -> None:
    quiet = {"fontsize": 8.0, "color": "#333333", "va": "center"}
    bar = figure.add_axes((_LABELS / width, 0.42 / height, 1.7 / width, 0.13 / height))
    bar.imshow(
        [[step / 60.0 - 0.5 for step in range(61)]], cmap=_CHANGES, norm=_RANGE, aspect="auto",
        extent=(-50.0, 50.0, 0.0, 1.0),
    )  # fmt: skip
    bar.set_yticks([])
    bar.set_xticks([-50, 0, 50])
    bar.set_xticklabels(["half lost", "unchanged", "half more"], fontsize=7.0)
    bar.tick_params(length=0.0, pad=2.0)
    for spine in bar.spines.values():
        spine.set_visible(False)
    words = (
        "Large: what is survived in the worst walk, % of the limit of any policy.",
        "Small: change against undisturbed [N s]. Means over all pushes.",
    )
    for line, text in enumerate(words):
        figure.text(
            (_LABELS + 2.1) / width, (0.52 - 0.2 * line) / height, text, **quiet
        )  # fmt: skip

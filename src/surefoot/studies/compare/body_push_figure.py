"""How much push each method survives on a body, over direction and phase."""

from __future__ import annotations

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from surefoot.show import palette
from surefoot.show.method_marks import Mark, mark
from surefoot.show.picture_file import marker_path
from surefoot.studies.compare.body_pushes import AIM, DIRECTIONS, BodyPushes, Pushed

_WIDTH, _ROW, _HEAD, _FOOT, _LEFT, _RIGHT, _GAP = 11.0, 2.35, 0.72, 1.15, 0.75, 0.25, 0.2

FEET = ("left", "right")
"""Rows of the picture: the foot that stands."""


def body_push_figure(measured: BodyPushes) -> Figure:
    """The smallest failing push as Δv over the phase: a column for each direction, a row each foot.

    Args:
        measured: the comparison.

    Returns:
        A figure of its own, not known to pyplot.
    """
    height = _HEAD + _ROW * len(FEET) + _GAP * (len(FEET) - 1) + _FOOT
    figure = Figure(figsize=(_WIDTH, height), facecolor="white")
    width = (_WIDTH - _LEFT - _RIGHT - _GAP * (len(DIRECTIONS) - 1)) / len(DIRECTIONS)
    tried = [_height(cell, measured.mass) for cell in measured.cells]
    top = 1.08 * max([AIM, *tried])
    for row, foot in enumerate(FEET):
        bottom = _FOOT + (len(FEET) - 1 - row) * (_ROW + _GAP)
        for column, direction in enumerate(DIRECTIONS):
            left = _LEFT + column * (width + _GAP)
            ax = figure.add_axes(
                (left / _WIDTH, bottom / height, width / _WIDTH, _ROW / height)
            )  # fmt: skip
            _draw_panel(ax, measured, direction, foot)
            ax.set_ylim(-0.03 * top, top)
            ax.tick_params(labelleft=column == 0, labelbottom=row == len(FEET) - 1)
            if column == 0:
                ax.set_ylabel(f"{foot} foot stands\nΔv = J / m [m/s]")
            if row == 0:
                ax.set_title(direction, fontsize=9.5, fontweight="bold")
            if row == len(FEET) - 1:
                ax.set_xlabel("push begins, part of the step")
    words = (f"{measured.robot}, {measured.mass:.3g} kg", "smallest push of 0.2 s that it fails on")
    figure.suptitle(
        "  ·  ".join(words), x=0.25 / _WIDTH, y=1.0 - 0.14 / height, ha="left", va="top",
        fontsize=12.0, fontweight="bold",
    )  # fmt: skip
    _explain(figure, measured)
    return figure


def _height(cell: Pushed, mass: float) -> float:
    """Where a scan is drawn: at its end if nothing failed."""
    return cell.delta_v if math.isfinite(cell.delta_v) else cell.scanned / mass


def _draw_panel(ax: Axes, measured: BodyPushes, direction: str, foot: str) -> None:
    ax.axhline(AIM, color="#222222", linewidth=1.0, linestyle=palette.DASHES, zorder=1.0)
    ax.grid(axis="y", color="#e4e4e4", linewidth=0.5)
    ax.set_axisbelow(True)
    ax.set_xlim(-0.06, 1.0)
    ax.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0])
    ax.set_xticklabels(["0", "¼", "½", "¾", "1"])
    for number, (key, _, _) in enumerate(measured.methods):
        cells = [cell for cell in measured.of(key, direction) if cell.foot == foot]
        cells.sort(key=lambda cell: cell.phase)
        if cells:
            heights = [_height(cell, measured.mass) for cell in cells]
            _draw_line(
                ax, cells, heights, mark(number), f"{key}-{direction}-{foot}".replace(" ", "-")
            )


def _draw_line(
    ax: Axes, cells: Sequence[Pushed], heights: Sequence[float], how: Mark, gid: str
) -> None:
    ax.plot(
        [cell.phase for cell in cells], heights, color=how.colour, linewidth=1.4,
        linestyle=(0, (5, 2)) if how.dashed else "-",
        marker=marker_path(how), markersize=6.0, markeredgewidth=0.6, markeredgecolor="white",
        gid=gid, clip_on=False,
    )  # fmt: skip
    for cell, height in zip(cells, heights, strict=True):
        if math.isinf(cell.impulse):
            ax.annotate(
                "", (cell.phase, 1.06 * height), (cell.phase, height),
                arrowprops={"arrowstyle": "->", "color": how.colour},
            )  # fmt: skip


def _explain(figure: Figure, measured: BodyPushes) -> None:
    lines = [
        Line2D(
            [], [], color=how.colour, linestyle=(0, (5, 2)) if how.dashed else "-", linewidth=1.4,
            marker=marker_path(how), markersize=6.0, label=label,
        )
        for how, label in (
            (mark(number), label) for number, (_, label, _) in enumerate(measured.methods)
        )
    ]  # fmt: skip
    lines.append(
        Line2D(
            [], [], color="#222222", linestyle=palette.DASHES, linewidth=1.0,
            label=f"the aim, {AIM:.2f} m/s",
        )
    )  # fmt: skip
    figure.legend(
        handles=lines, loc="lower center", ncol=4, frameon=False, bbox_to_anchor=(0.5, 0.0),
        handlelength=2.6, columnspacing=1.8,
    )  # fmt: skip

"""A walk in physics on one page: from above, and over time down to the motors."""

from __future__ import annotations

import textwrap
from pathlib import Path

from matplotlib import style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.body_time_plots import HEIGHTS, draw_body_time_plots
from surefoot.show.body_top_view import body_extent, draw_body_top_view
from surefoot.show.picture_file import write_picture
from surefoot.show.push_arrows import LINE, label_places
from surefoot.show.stances import acting_pushes
from surefoot.show.walk_words import title

WIDTH = 12.0
"""Of the page [in]."""

LEFT, RIGHT, GAP, FOOT = 0.95, 1.9, 0.12, 0.5
"""Margins beside, between and below the plots over time [in]."""

TALLEST, SHORTEST = 4.6, 1.7
"""Of the top view [in]."""

COARSEST, HIGHEST = 0.25, 7.5
"""A top view whose scale would be coarser [m/in] is as much taller, up to this height [in]."""


def draw_body(rollout: Rollout, trace: BodyTrace, path: Path) -> None:
    """Draw a walk in physics into a file; the same walk gives the same bytes.

    Args:
        rollout: the walk.
        trace: its `body`.
        path: file to write; its ending names the format (.png, .pdf, .svg).

    Raises:
        FileError: the file cannot be written.
    """
    with style.context(["default", palette.STYLE]):
        figure = body_figure(rollout, trace)
    write_picture(figure, path, ", ".join(title(rollout)))


def body_figure(rollout: Rollout, trace: BodyTrace) -> Figure:
    """The picture of a walk in physics, in the caller's matplotlib style.

    Args:
        rollout: the walk.
        trace: its `body`.
    """
    ground = body_extent(rollout, trace)
    width = WIDTH - LEFT - RIGHT
    tallest = min(max(ground.size[1] / COARSEST, TALLEST), HIGHEST)
    view = min(max(width * ground.size[1] / ground.size[0], SHORTEST), tallest)
    shown = ground.filling(width, view)
    headline = textwrap.fill("  ·  ".join(title(rollout)), 118)
    fall = rollout.body_fall
    evidence = "" if fall is None else textwrap.fill(f"fell: {fall.sentence}", 150)
    lines = max([level for *_, level in label_places(rollout, shown, width)], default=-1) + 1
    top = 0.3 + 0.24 * len(headline.splitlines()) + 0.2 * len(evidence.splitlines()) + LINE * lines
    plots = top + view + 0.62
    height = plots + sum(HEIGHTS) + GAP * (len(HEIGHTS) - 1) + FOOT
    figure = Figure(figsize=(WIDTH, height))

    def add_axes(left: float, below: float, across: float, down: float) -> Axes:
        box = (left / WIDTH, 1.0 - (below + down) / height, across / WIDTH, down / height)
        return figure.add_axes(box)

    figure.text(
        0.25 / WIDTH, 1.0 - 0.14 / height, headline, fontsize=12.0, fontweight="bold", va="top",
        gid="title",
    )  # fmt: skip
    if evidence:
        under = 0.2 + 0.24 * len(headline.splitlines())
        figure.text(
            0.25 / WIDTH, 1.0 - under / height, evidence, fontsize=9.0, va="top",
            color=palette.ALARM, gid="fall-evidence",
        )  # fmt: skip
    draw_body_top_view(add_axes(LEFT, top, width, view), rollout, trace, shown)
    axes = []
    for row in HEIGHTS:
        axes.append(add_axes(LEFT, plots, width, row))
        plots += row + GAP
    draw_body_time_plots(axes, rollout, trace)
    figure.legend(
        handles=_entries(rollout), loc="upper left", frameon=False, fontsize=8.0,
        bbox_to_anchor=((LEFT + width + 0.1) / WIDTH, 1.0 - (top - 0.05) / height),
        borderaxespad=0.0, labelspacing=0.35, handlelength=1.6,
    )  # fmt: skip
    return figure


def _entries(rollout: Rollout) -> list[Artist]:
    """One labelled artist for each thing that is drawn."""
    entries: list[Artist] = [
        Line2D([], [], color=palette.COM, linewidth=1.3, label="CoM"),
        Line2D([], [], color=palette.DCM, linewidth=1.8, label="DCM (ring: at touchdown)"),
        Line2D([], [], color=palette.ZMP, linewidth=1.0, label="ZMP of the floor's forces"),
        _dashed(palette.COM_PLAN, "planned CoM"),
        _dashed(palette.DCM_PLAN, "planned DCM"),
        _dashed(palette.ZMP_PLAN, "commanded ZMP"),
        _dashed(palette.ADAPTED, "target of a foot, missed"),
    ]
    for side in (Side.LEFT, Side.RIGHT):
        entries.append(
            Patch(
                facecolor=palette.SOLE[side],
                edgecolor=palette.SOLE_EDGE[side],
                linewidth=0.8,
                label=f"{side.name.lower()} sole",
            )
        )
    if rollout.body is not None and len(rollout.body.boards):
        entries.append(Patch(facecolor=palette.BOARD, linewidth=0.0, label="board on the floor"))
    if acting_pushes(rollout):
        entries.append(Patch(facecolor=palette.PUSH, alpha=0.6, linewidth=0.0, label="push"))
    entries.append(Line2D([], [], color="#b5b5b5", linewidth=0.8, label="touchdown"))
    return entries


def _dashed(colour: str, label: str) -> Line2D:
    return Line2D([], [], color=colour, linewidth=1.0, linestyle=palette.DASHES, label=label)

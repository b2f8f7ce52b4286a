"""A walk on one page: from above, and over time; that of a body down to its motors."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.page import add_axes, lay_out, view_size
from surefoot.show.picture_file import draw_picture
from surefoot.show.plotted_walk import PlottedWalk
from surefoot.show.stances import acting_pushes, commanded
from surefoot.show.time_plots import draw_time_plots, panels
from surefoot.show.top_view import draw_top_view, extent
from surefoot.show.walk_events import label_places
from surefoot.show.words import fall_evidence, title

_SEPARATOR = "  ·  "

DOTTED: dict[str, Any] = {"marker": ".", "markersize": 6.0, "markeredgewidth": 0.0}
"""A line that has dots in the view from above."""


def draw_walk(rollout: Rollout, path: Path) -> None:
    """Draw a walk into a file, see `draw_picture`; the same walk gives the same bytes."""
    about = f"{rollout.controller}({rollout.controller_parameters})"
    draw_picture(lambda: walk_figure(rollout), path, ", ".join(title(rollout)), about)


def walk_figure(rollout: Rollout) -> Figure:
    """The picture of a walk, not known to pyplot, in the caller's style of matplotlib."""
    walk, of_body = PlottedWalk(rollout), rollout.body is not None
    ground = extent(walk)
    size = view_size(ground, of_body)
    lines = [level for *_, level in label_places(rollout, ground.filling(*size), size[0])]
    entries = legend_entries(walk)
    headline = _headline(title(rollout), 112)
    evidence = textwrap.fill(fall_evidence(rollout), 150)
    headline_height = 0.24 * len(headline.splitlines())
    title_height = 0.14 + headline_height + 0.2 * len(evidence.splitlines())
    heights = [panel.height for panel in panels(rollout)]
    push_lines = max(lines, default=-1) + 1
    page = lay_out(ground, of_body, title_height, push_lines, len(entries), heights)

    figure = Figure(figsize=(page.width, page.height))
    figure.text(
        *page.at(0.25, 0.14), headline, fontsize=12.0, fontweight="bold", va="top", gid="title"
    )
    if evidence:
        figure.text(
            *page.at(0.25, 0.18 + headline_height), evidence, fontsize=9.0, va="top",
            color=palette.ALARM, gid="fall-evidence",
        )  # fmt: skip
    draw_top_view(add_axes(figure, page.top_view), walk, page.shown)
    time_axes = [add_axes(figure, box) for box in page.time_plots]
    draw_time_plots(time_axes, walk)
    figure.legend(
        handles=entries, loc="upper left", frameon=False, bbox_to_anchor=page.at(*page.legend),
        borderaxespad=0.0, labelspacing=0.35, **page.legend_look,
    )  # fmt: skip
    return figure


def _headline(parts: list[str], length: int) -> str:
    """The parts of a title, with a new line before what does not fit any more."""
    text, room = "", length
    for part in parts:
        if text and room < len(part):
            text, room = f"{text}\n{part}", length
        else:
            text = f"{text}{_SEPARATOR}{part}" if text else part
        room -= len(part) + len(_SEPARATOR)
    return text


def legend_entries(walk: PlottedWalk) -> list[Artist]:
    """One labelled artist for each thing that is drawn; only what occurs is listed."""
    rollout, body = walk.rollout, walk.rollout.body
    drawn: list[Artist] = [
        _line(curve.label, **curve.look, **(DOTTED if curve.name == "zmp" and body is None else {}))
        for curve in walk.curves
    ]
    feet = {sole.side for sole in walk.soles}
    drawn += [
        Patch(
            facecolor=palette.SOLE[side], edgecolor=palette.SOLE_EDGE[side], linewidth=0.8,
            label=f"{side.name.lower()} sole",
        )
        for side in (Side.LEFT, Side.RIGHT)
        if side in feet
    ]  # fmt: skip
    if rollout.commands["double_support"].any() and body is None:
        drawn.append(Patch(facecolor=palette.BOTH_SOLES, linewidth=0.0, label="both soles"))
    if body is not None and len(body.boards):
        drawn.append(Patch(facecolor=palette.BOARD, linewidth=0.0, label="board on the floor"))
    online = [part for part in walk.parts if part.adapted]
    edge: dict[str, Any] = {"facecolor": "none", "edgecolor": palette.ADAPTED}
    if any(part.landing is not None for part in online):
        drawn.append(Patch(**edge, linewidth=1.8, label="landing decided online"))
    if walk.missed_soles:
        missed = "nominal landing" if body is None else "target of a foot, missed"
        drawn.append(Patch(**palette.MISSED, label=missed))
    if online:
        label = "deciding online"
        drawn.append(Patch(**edge, hatch="////", linewidth=0.0, alpha=0.5, label=label))
    if acting_pushes(rollout):
        drawn.append(Patch(facecolor=palette.PUSH, alpha=0.6, linewidth=0.0, label="push"))
    if len(commanded(rollout)) > 1:
        drawn.append(_line("new velocity", palette.COM, linewidth=0.9, linestyle="dashdot"))
    if body is None:
        settled = f"limits; settled ({1e3 * rollout.settled_error:.2g} mm)"
        drawn.append(_line(settled, palette.QUIET, linewidth=0.8, linestyle="dotted"))
    else:
        drawn.append(_line("touchdown", palette.TOUCHDOWN, linewidth=0.8))
    return drawn


def _line(label: str, color: str, **look: Any) -> Line2D:
    return Line2D([], [], color=color, label=label, **look)

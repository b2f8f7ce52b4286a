"""A walk on one page: from above, and over time; that of a body down to its motors."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from matplotlib import style
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from surefoot.checks import check_writable
from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.ground import label_places
from surefoot.show.page import lay_out, view_size
from surefoot.show.picture_file import FORMATS, write_picture
from surefoot.show.stances import Stance, acting_pushes, commanded, stances
from surefoot.show.time_plots import draw_time_plots, panels
from surefoot.show.top_view import draw_top_view, extent
from surefoot.show.words import fall_evidence, title

_SEPARATOR = "  ·  "

Dash = Literal["solid", "dashed", "dashdot", "dotted"]


def draw_walk(rollout: Rollout, path: Path) -> None:
    """Draw a walk into a file; the same walk gives the same bytes.

    Args:
        rollout: the walk.
        path: file to write; its ending names the format (.png, .pdf, .svg).

    Raises:
        FileError: another ending, or the file cannot be written.
    """
    check_figure_path(path)
    with style.context(["default", palette.STYLE]):
        figure = walk_figure(rollout)
    write_picture(figure, Path(path), *_about(rollout))


def check_figure_path(path: str | Path) -> None:
    """Refuse a path to which no picture can be written, before a walk is computed.

    Nothing is left behind, and an existing file is not touched.

    Raises:
        FileError: an unknown ending, no such directory, or no permission.
    """
    check_writable(Path(path), FORMATS)


def walk_figure(rollout: Rollout) -> Figure:
    """The picture of a walk, in the caller's matplotlib style; `draw_walk` has its own.

    Args:
        rollout: the walk.

    Returns:
        A figure of its own, not known to pyplot.
    """
    of_body = rollout.body is not None
    parts = [] if of_body else stances(rollout)
    ground = extent(rollout, parts)
    size = view_size(ground, of_body)
    lines = [level for *_, level in label_places(rollout, ground.filling(*size), size[0])]
    entries = legend_entries(rollout, parts)
    headline = _headline(title(rollout), 118 if of_body else 112)
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
            *page.at(0.25, (0.2 if of_body else 0.18) + headline_height), evidence, fontsize=9.0,
            va="top", color=palette.ALARM, gid="fall-evidence",
        )  # fmt: skip
    draw_top_view(page.add_axes(figure, page.top_view), rollout, parts, page.shown)
    time_axes = [page.add_axes(figure, box) for box in page.time_plots]
    draw_time_plots(time_axes, rollout, parts)
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


def _about(rollout: Rollout) -> tuple[str, str]:
    """Title and description in the file."""
    return ", ".join(title(rollout)), f"{rollout.controller}({rollout.controller_parameters})"


def legend_entries(rollout: Rollout, parts: list[Stance]) -> list[Artist]:
    """One labelled artist for each thing that is drawn; only what occurs is listed.

    Args:
        rollout: the walk.
        parts: its stances; of a body none are needed.
    """
    of_body = rollout.body is not None
    lines = _body_lines() if of_body else _point_lines(rollout)
    feet = {Side.LEFT, Side.RIGHT} if of_body else {part.side for part in parts}
    feet = feet if of_body else feet | {parts[0].side.other}
    soles = [
        Patch(
            facecolor=palette.SOLE[side], edgecolor=palette.SOLE_EDGE[side], linewidth=0.8,
            label=f"{side.name.lower()} sole",
        )
        for side in (Side.LEFT, Side.RIGHT)
        if side in feet
    ]  # fmt: skip
    if rollout.body is None:
        return [*lines, *soles, *_point_events(rollout, parts)]
    entries = [*lines, *soles]
    if len(rollout.body.boards):
        entries.append(Patch(facecolor=palette.BOARD, linewidth=0.0, label="board on the floor"))
    entries += _push(rollout)
    return [*entries, _line("touchdown", palette.TOUCHDOWN, 0.8)]


def _body_lines() -> Iterator[Line2D]:
    yield _line("CoM", palette.COM, 1.3)
    yield _line("DCM (ring: at touchdown)", palette.DCM, 1.8)
    yield _line("ZMP of the floor's forces", palette.ZMP, 1.0)
    for label, colour in (
        ("planned CoM", palette.COM_PLAN), ("planned DCM", palette.DCM_PLAN),
        ("commanded ZMP", palette.ZMP_PLAN), ("target of a foot, missed", palette.ADAPTED),
    ):  # fmt: skip
        line = _line(label, colour, 1.0)
        line.set_linestyle(palette.DASHES)
        yield line


def _point_lines(rollout: Rollout) -> Iterator[Line2D]:
    yield _line("CoM", palette.COM, 1.4)
    yield _line("DCM (ring: at touchdown)", palette.DCM, 2.0)
    yield _line("planned DCM, duration", palette.DCM_PLAN, 1.1, "dashed")
    yield _line("ZMP", palette.ZMP, 1.3, marker=".")
    if rollout.zmp_excess.any():
        yield _line("ZMP outside the sole", palette.ALARM, 2.6)


def _point_events(rollout: Rollout, parts: list[Stance]) -> Iterator[Artist]:
    if rollout.commands["double_support"].any():
        yield Patch(facecolor=palette.BOTH_SOLES, linewidth=0.0, label="both soles")
    online = [part for part in parts if part.adapted]
    if any(part.landing is not None for part in online):
        yield _outline("landing decided online", 1.8, "solid")
    if any(part.moved_from is not None for part in online):
        yield _outline("nominal landing", 1.0, "dashed")
    if online:
        yield Patch(
            facecolor="none", edgecolor=palette.ADAPTED, hatch="////", linewidth=0.0, alpha=0.5,
            label="deciding online",
        )  # fmt: skip
    yield from _push(rollout)
    if len(commanded(rollout)) > 1:
        yield _line("new velocity", palette.COM, 0.9, "dashdot")
    settled = f"limits; settled ({1e3 * rollout.settled_error:.2g} mm)"
    yield _line(settled, palette.QUIET, 0.8, "dotted")


def _push(rollout: Rollout) -> list[Patch]:
    if not acting_pushes(rollout):
        return []
    return [Patch(facecolor=palette.PUSH, alpha=0.6, linewidth=0.0, label="push")]


def _line(label: str, color: str, width: float, dash: Dash = "solid", marker: str = "") -> Line2D:
    return Line2D(
        [], [], color=color, linewidth=width, linestyle=dash, marker=marker, markersize=6.0,
        markeredgewidth=0.0, label=label,
    )  # fmt: skip


def _outline(label: str, width: float, dash: Dash) -> Patch:
    return Patch(
        facecolor="none", edgecolor=palette.ADAPTED, linewidth=width, linestyle=dash, label=label
    )

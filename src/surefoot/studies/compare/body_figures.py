"""Pictures of what was measured on bodies: pushes over direction and phase, and disturbed walks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.robot.feet import FEET
from surefoot.show import palette
from surefoot.show.palette import Mark, mark
from surefoot.studies.compare.body_question import BodyPushes, BodyWalks
from surefoot.studies.engine.pictures import add_legend, headline, marked, panel
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import Row, select

AIM = 85.0 / 70.0
"""The Δv of the paper's largest push, 85 N s on 70 kg [m/s]."""

WALKED_THROUGH = "What a body walks through"
"""The title of the picture of walks."""

_WIDTH, _ROW, _HEAD, _FOOT, _LEFT, _RIGHT, _GAP = 11.0, 2.35, 0.72, 1.15, 0.75, 0.25, 0.2
"""Of the picture of pushes [in]."""

_LABELS, _PANEL, _LINE, _TOP, _BOTTOM, _APART = 3.3, 2.6, 0.24, 0.75, 0.95, 0.25
"""Of the picture of walks [in]."""

_TRACKING = {"marker": "o", "color": palette.DCM, "linestyle": "none", "markersize": 4.5}
_ESTIMATE = {
    "marker": "o", "color": palette.COM_PLAN, "linestyle": "none", "markersize": 4.5,
    "fillstyle": "none",
}  # fmt: skip
_FALL = {"marker": "X", "color": palette.ALARM, "linestyle": "none", "markersize": 7.0}


def push_figure(measured: Measured[BodyPushes]) -> Figure:
    """The smallest failing push as Δv over the phase; columns are directions, rows feet."""
    height = _HEAD + _ROW * len(FEET) + _GAP * (len(FEET) - 1) + _FOOT
    figure = Figure(figsize=(_WIDTH, height), facecolor="white")
    width = (_WIDTH - _LEFT - _RIGHT - _GAP * (len(DIRECTIONS) - 1)) / len(DIRECTIONS)
    mass = measured.study.mass
    tried = [_height(row, mass) for row in measured.rows]
    top = 1.08 * max([AIM, *tried])
    for row, foot in enumerate(FEET):
        bottom = _FOOT + (len(FEET) - 1 - row) * (_ROW + _GAP)
        for column, direction in enumerate(DIRECTIONS):
            left = _LEFT + column * (width + _GAP)
            ax = panel(figure, left, bottom, width, _ROW)
            _draw_scans(ax, measured, direction, foot)
            ax.set_ylim(-0.03 * top, top)
            ax.tick_params(labelleft=column == 0, labelbottom=row == len(FEET) - 1)
            if column == 0:
                ax.set_ylabel(f"{foot} foot stands\nΔv = J / m [m/s]")
            if row == 0:
                ax.set_title(direction, fontsize=9.5, fontweight="bold")
            if row == len(FEET) - 1:
                ax.set_xlabel("push begins, part of the step")
    title = (
        f"{measured.study.robot.name}, {mass:.3g} kg  ·  smallest push of 0.2 s that it fails on"
    )
    headline(figure, title)
    _add_legend(figure, measured)
    return figure


def _height(row: Row, mass: float) -> float:
    """Where a scan is drawn: at its end if nothing failed."""
    return row["delta_v"] if math.isfinite(row["delta_v"]) else row["scanned"] / mass


def _draw_scans(ax: Axes, measured: Measured[BodyPushes], direction: str, foot: str) -> None:
    ax.axhline(AIM, color="#222222", linewidth=1.0, linestyle=palette.DASHES, zorder=1.0)
    ax.grid(axis="y", color="#e4e4e4", linewidth=0.5)
    ax.set_axisbelow(True)
    ax.set_xlim(-0.06, 1.0)
    ax.set_xticks([0.0, 0.25, 0.5, 0.75, 1.0])
    ax.set_xticklabels(["0", "¼", "½", "¾", "1"])
    for number, key in enumerate(measured.study.methods):
        rows = select(measured.rows, method=key, direction=direction, foot=foot)
        if rows:
            rows.sort(key=lambda row: row["phase"])
            heights = [_height(row, measured.study.mass) for row in rows]
            _draw_line(ax, rows, heights, mark(number), f"{key}-{direction}-{foot}")


def _draw_line(
    ax: Axes, rows: Sequence[Row], heights: Sequence[float], how: Mark, gid: str
) -> None:
    ax.plot(
        [row["phase"] for row in rows], heights, gid=gid, clip_on=False,
        **_line(how, markeredgewidth=0.6, markeredgecolor="white"),
    )  # fmt: skip
    for row, height in zip(rows, heights, strict=True):
        if math.isinf(row["impulse"]):
            ax.annotate(
                "", (row["phase"], 1.06 * height), (row["phase"], height),
                arrowprops={"arrowstyle": "->", "color": how.colour},
            )  # fmt: skip


def _add_legend(figure: Figure, measured: Measured[BodyPushes]) -> None:
    lines = [
        Line2D([], [], label=one["label"], **_line(mark(number)))
        for number, one in enumerate(measured.notes["methods"])
    ]
    aim = {"color": "#222222", "linestyle": palette.DASHES, "linewidth": 1.0}
    lines.append(Line2D([], [], label=f"the aim, {AIM:.2f} m/s", **aim))
    add_legend(figure, lines, 4, 0.0, handlelength=2.6, columnspacing=1.8)


def _line(how: Mark, **options: Any) -> dict[str, Any]:
    style = (0, (5, 2)) if how.dashed else "-"
    return marked(how, markersize=6.0, linewidth=1.4, linestyle=style, **options)


def walk_title(measured: Measured[BodyWalks], method: str) -> str:
    """The robot, and the method if there are several."""
    labels = {one["key"]: one["label"] for one in measured.notes["methods"]}
    robot = measured.study.robot.name
    return robot if len(labels) == 1 else f"{robot}, {labels[method]}"


def walk_figure(measured: Sequence[Measured[BodyWalks]]) -> Figure:
    """A row for each condition, a panel for each robot and method, a dot for each walk."""
    panels = [(one, method) for one in measured for method in one.study.methods]
    conditions = {
        shown["key"]: shown["label"] for one in measured for shown in one.notes["conditions"]
    }
    width = _LABELS + (_PANEL + _APART) * len(panels)
    height = _TOP + _LINE * len(conditions) + _BOTTOM
    figure = Figure(figsize=(width, height), facecolor="white")
    for column, (one, method) in enumerate(panels):
        left = _LABELS + column * (_PANEL + _APART)
        ax = panel(figure, left, _BOTTOM, _PANEL, height - _TOP - _BOTTOM)
        _draw_walks(ax, one, method, list(conditions))
        ax.set_yticks(range(len(conditions)))
        ax.set_yticklabels(list(conditions.values()) if column == 0 else [])
        ax.set_title(walk_title(one, method), fontsize=9.5, fontweight="bold")
    headline(figure, WALKED_THROUGH, left=0.2, down=0.12)
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


def _draw_walks(
    ax: Axes, measured: Measured[BodyWalks], method: str, conditions: Sequence[str]
) -> None:
    errors = [1e3 * row["dcm_error"] for row in measured.rows if row["walked"]]
    right = 1.15 * max([10.0, *errors])
    ax.set_xlim(0.0, right)
    ax.set_ylim(len(conditions) - 0.4, -0.6)
    ax.set_xlabel("root mean square [mm]")
    ax.grid(axis="x", color="#e4e4e4", linewidth=0.5)
    ax.set_axisbelow(True)
    ax.tick_params(axis="y", length=0.0)
    for line, key in enumerate(conditions):
        walks = select(measured.rows, method=method, condition=key)
        stood = [row for row in walks if row["walked"]]
        name = f"{measured.study.robot.name}-{method}-{key}"
        for values, look, kind in (
            ([1e3 * row["dcm_error"] for row in stood], _TRACKING, "tracking"),
            ([1e3 * row["estimate_error"] for row in stood], _ESTIMATE, "estimate"),
        ):
            ax.plot(values, [line] * len(values), gid=f"{kind}-{name}", **look)
        fell = [row["time"] for row in walks if not row["walked"]]
        if fell:
            ax.plot([0.93 * right], [line], gid=f"fell-{name}", **_FALL)
            words = ", ".join(f"{time:.0f}" for time in fell) + " s"
            ax.text(
                0.88 * right, line, words, ha="right", va="center", fontsize=7.5,
                color=palette.ALARM,
            )  # fmt: skip

"""What the unified controller decides over time: margin, landing in place and time, ZMP, limits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from surefoot.control.unified.problem import Limit
from surefoot.dcm.leg import furthest
from surefoot.dcm.nominal_gait import NominalGait
from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.page import add_axes
from surefoot.show.picture_file import draw_picture
from surefoot.show.stances import Stance, broken, runs, stances
from surefoot.show.walk_events import shade_push_in_time
from surefoot.show.words import LIMIT_WORDS, title

BOX, REACH = "#e4efe9", "#a9d6c2"
"""Colours of the step box and, in it, of what the leg can reach by the time of landing."""

BEFORE, AFTER = 0.35, 1.15
"""How much is shown before the first push begins and after it [s]."""

_ROWS = (
    ("margin\n[mm]", 1.0),
    ("can still be\nsaved [%]", 0.8),
    ("landing X\n[m]", 1.2),
    ("landing Y\nto swing foot [m]", 1.0),
    ("landing time\nT [s]", 1.0),
    ("ZMP [% of the\nhalf sole]", 0.9),
    ("", 1.55),
)
"""Labels and heights [in] of the plots, from above."""

_LEFT, _RIGHT, _HEAD, _FOOT, _GAP, _SPACE = 1.25, 0.15, 0.38, 0.95, 0.13, 0.16
_BOXES = "step box, time box, sole"

_BRIEF = 0.02
"""Two limits that bind at once take turns from cycle to cycle: no gap in a bar is shorter [s]."""

_THIN = 0.004
"""A bar is at least so long, to be seen [s]."""

_WIDTH_ALONE, _WIDTH_BESIDE = 7.6, 3.3


@dataclass(frozen=True)
class DecidedWalk:
    """A walk with what was decided in it.

    Attributes:
        rollout: the walk.
        decided: its decisions (`surefoot.decisions`).
        name: what stands over its plots; empty for the title of the walk.
    """

    rollout: Rollout
    decided: NDArray[np.void]
    name: str = ""


def draw_decisions(walks: Sequence[DecidedWalk], path: Path) -> None:
    """Draw the decisions of walks into a file, beside each other; see `draw_picture`."""
    draw_picture(lambda: decision_figure(walks), path, "decisions of the unified controller")


def decision_figure(walks: Sequence[DecidedWalk]) -> Figure:
    """Plots over time, one column for each walk; the same scales in all."""
    wide = _WIDTH_ALONE if len(walks) == 1 else _WIDTH_BESIDE
    width = _LEFT + len(walks) * (wide + _SPACE) - _SPACE + _RIGHT
    head = _HEAD if all(walk.name for walk in walks) else 2.0 * _HEAD
    height = head + sum(tall + _GAP for _, tall in _ROWS) + _FOOT
    figure = Figure(figsize=(width, height), facecolor="white")
    columns = []
    for column, walk in enumerate(walks):
        left, top, axes = _LEFT + column * (wide + _SPACE), head, []
        for label, tall in _ROWS:
            ax = add_axes(figure, (left, top, wide, tall))
            top += tall + _GAP
            ax.grid(axis="y", color=palette.GRID, linewidth=0.5)
            ax.set_axisbelow(True)
            ax.tick_params(labelbottom=False, labelleft=column == 0)
            if column == 0:
                ax.set_ylabel(label)
                ax.yaxis.set_label_coords(-0.62 / wide, 0.5)
            axes.append(ax)
        axes[-1].tick_params(labelbottom=True)
        axes[-1].set_xlabel("time [s]")
        name = walk.name or _headline(walk.rollout)
        axes[0].set_title(name, loc="left", fontsize=9.5, fontweight="bold", pad=7.0)
        _draw(axes, walk)
        columns.append(axes)
    highest = max(axes[0].get_ylim()[1] for axes in columns)
    for axes in columns:
        axes[0].set_ylim(-0.07 * highest, highest)
    _explain(figure, height)
    return figure


def _headline(rollout: Rollout) -> str:
    """The title of a walk on two lines."""
    robot, *rest = title(rollout)
    return f"{robot}\n{'  ·  '.join(rest)}"


def _draw(axes: list[Axes], walk: DecidedWalk) -> None:
    rollout, parts = walk.rollout, stances(walk.rollout)
    start = min((push.start for push in rollout.pushes), default=BEFORE)
    for ax in axes:
        ax.set_xlim(max(start - BEFORE, 0.0), min(start + AFTER, float(rollout.time[-1])))
        shade_push_in_time(ax, rollout)
    time = broken(rollout.time, parts)
    margin = 1e3 * broken(walk.decided["margin"], parts)
    axes[0].fill_between(time, margin, color=palette.DCM, alpha=0.15, linewidth=0.0)
    axes[0].plot(time, margin, color=palette.DCM, linewidth=1.6, gid="margin")
    axes[0].axhline(0.0, color=palette.ALARM, linewidth=1.2)
    axes[0].set_ylim(0.0, 1.25 * max(float(np.nanmax(margin)), 1.0))
    _number_steps(axes[0], parts)
    share = 100.0 * broken(walk.decided["share"], parts)
    axes[1].plot(time, share, color=palette.COM, linewidth=1.6)
    axes[1].set_ylim(-6.0, 108.0)
    for axis in range(2):
        _draw_landing(axes[2 + axis], walk, parts, axis)
    _draw_time(axes[4], walk, parts)
    _draw_zmp(axes[5], walk, parts)
    _draw_limits(axes[6], walk)


def _number_steps(ax: Axes, parts: list[Stance]) -> None:
    first, last = ax.get_xlim()
    for part in parts:
        middle = 0.5 * (max(part.start, first) + min(part.end, last))
        if part.end > first + 0.1 and part.start < last - 0.1:
            ax.text(
                middle, 0.96, f"step {part.number}", transform=ax.get_xaxis_transform(), va="top",
                ha="center", fontsize=7.5, fontweight="bold" if part.adapted else "normal",
                color=palette.ADAPTED if part.adapted else palette.QUIET, zorder=6.0,
            )  # fmt: skip


def _draw_landing(ax: Axes, walk: DecidedWalk, parts: list[Stance], axis: int) -> None:
    """X or Y, in the step box and within reach of the leg."""
    rollout = walk.rollout
    robot = rollout.robot
    side = np.where(axis == 1, rollout.support_side, 1).astype(float)
    low, high = (robot.gait.step_x, tuple(robot.hip + y for y in robot.gait.step_y))[axis]
    foot = side * (rollout.swing_foot[:, axis] - rollout.support_foot[:, axis])
    velocity = side * rollout.observations["swing_foot_velocity"][:, axis]
    left = np.log(walk.decided["tau"]) / robot.omega - rollout.observations["elapsed"]
    leg = (robot.swing.max_speed, robot.swing.max_acceleration)
    ahead, behind = (
        np.array(
            [furthest(sign * v, max(t, 0.0), *leg) for v, t in zip(velocity, left, strict=True)]
        )
        for sign in (1.0, -1.0)
    )
    time = broken(rollout.time, parts)
    ax.axhspan(low, high, facecolor=BOX, edgecolor=palette.ZMP, linewidth=0.7, zorder=0.3)
    least, most = (np.clip(edge, low, high) for edge in (foot - behind, foot + ahead))
    ax.fill_between(
        time, broken(least, parts), broken(most, parts), color=REACH, linewidth=0.0, zorder=0.4
    )
    ax.plot(time, broken(foot, parts), color=palette.QUIET, linewidth=1.0,
            linestyle=palette.DOTS, zorder=2.0)  # fmt: skip
    _draw_nominal(ax, parts, lambda gait, foot: gait.step(foot)[axis] * (foot if axis else 1))
    ax.plot(time, broken(walk.decided["step"][:, axis], parts), color=palette.ADAPTED,
            linewidth=1.9, zorder=3.0)  # fmt: skip
    room = 0.08 * (high - low)
    ax.set_ylim(low - room, high + room)


def _draw_time(ax: Axes, walk: DecidedWalk, parts: list[Stance]) -> None:
    """T between its bounds; a step cannot have ended before now."""
    rollout = walk.rollout
    shortest, longest = rollout.robot.gait.step_duration
    for part in parts:
        time = np.linspace(part.start, part.end, 40)
        ax.fill_between(time, np.maximum(time - part.start, shortest), longest, facecolor=BOX,
                        edgecolor=palette.ZMP, linewidth=0.7, zorder=0.3)  # fmt: skip
    _draw_nominal(ax, parts, lambda gait, _: gait.step_duration)
    duration = np.log(walk.decided["tau"]) / rollout.robot.omega
    ax.plot(broken(rollout.time, parts), broken(duration, parts), color=palette.ADAPTED,
            linewidth=1.9, zorder=3.0)  # fmt: skip
    ax.set_ylim(0.0, longest + 0.1)


def _draw_nominal(
    ax: Axes, parts: list[Stance], value: Callable[[NominalGait, Side], float]
) -> None:
    for part in parts:
        if part.gait is not None:
            ax.hlines(
                value(part.gait, part.side), part.start, part.end, color=palette.DCM_PLAN,
                linewidth=1.2, linestyle="dashed", zorder=2.5,
            )  # fmt: skip


def _draw_zmp(ax: Axes, walk: DecidedWalk, parts: list[Stance]) -> None:
    rollout = walk.rollout
    time, half = broken(rollout.time, parts), np.array(rollout.robot.foot.half)
    ax.axhspan(-100.0, 100.0, facecolor=BOX, edgecolor=palette.ZMP, linewidth=0.7, zorder=0.3)
    used = 100.0 * walk.decided["zmp"] / half
    for axis, dashes in enumerate(("solid", palette.DASHES)):
        ax.plot(time, broken(used[:, axis], parts), color=palette.ZMP, linewidth=1.7,
                linestyle=dashes, zorder=3.0 + axis)  # fmt: skip
    ax.set_ylim(-118.0, 118.0)
    ax.set_yticks([-100.0, 0.0, 100.0])


def _draw_limits(ax: Axes, walk: DecidedWalk) -> None:
    """A bar for as long as a limit shaped the decisions, brief interruptions left out."""
    time, active = walk.rollout.time, walk.decided["active"]
    for row, limit in enumerate(LIMIT_WORDS):
        bars: list[tuple[float, float]] = []
        for run in runs((active & int(limit)) != 0):
            start, end = float(time[run.start]), float(time[min(run.stop, len(time) - 1)])
            if bars and start - sum(bars[-1]) < _BRIEF:
                start = bars.pop()[0]
            bars.append((start, max(end - start, _THIN)))
        serious = limit in (Limit.RESERVE, Limit.LOST)
        colour = palette.ALARM if serious else palette.COM
        ax.broken_barh(bars, (row - 0.36, 0.72), facecolor=colour, linewidth=0.0, zorder=3.0)
    ax.set_ylim(len(LIMIT_WORDS) - 0.5, -0.5)
    ax.set_yticks(range(len(LIMIT_WORDS)), list(LIMIT_WORDS.values()), fontsize=7.5)


def _explain(figure: Figure, height: float) -> None:
    handles = [
        Line2D([], [], color=palette.ADAPTED, linewidth=1.9, label="decided"),
        Line2D([], [], color=palette.DCM_PLAN, linewidth=1.2, linestyle="dashed", label="nominal"),
        Patch(facecolor=BOX, edgecolor=palette.ZMP, linewidth=0.7, label=_BOXES),
        Patch(facecolor=REACH, label="within reach at landing"),
        Line2D([], [], color=palette.QUIET, linewidth=1.0, linestyle=palette.DOTS,
               label="swing foot"),
        Line2D([], [], color=palette.ZMP, linewidth=1.7, label="ZMP in x"),
        Line2D([], [], color=palette.ZMP, linewidth=1.7, linestyle=palette.DASHES,
               label="ZMP in y"),
        Patch(facecolor=palette.PUSH, alpha=0.4, linewidth=0.0, label="push"),
    ]  # fmt: skip
    figure.legend(
        handles=handles, loc="lower center", ncols=4, frameon=False, handlelength=2.2,
        bbox_to_anchor=(0.5, 0.02 / height), borderaxespad=0.2, columnspacing=1.6,
    )  # fmt: skip

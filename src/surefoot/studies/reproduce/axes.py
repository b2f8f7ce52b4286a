"""What the pictures beside the paper are made of: ground, soles, curves, pushes, a legend."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from numpy.typing import NDArray

from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.stances import Stance, acting_pushes, broken, stances
from surefoot.show.walk_events import strong_pushes

WIDTH = 9.0
"""Of a picture [in]."""

LEFT, RIGHT, FOOT, HEAD, LEGEND = 0.72, 0.15, 0.5, 0.36, 0.5
"""Free space around the axes, and the height of the legend [in]."""

PLAN_DASH = (0, (3, 2))
SYMBOLS = {
    "dcm": r"$\xi$ (DCM)",
    "dcm_plan": r"$\xi^{plan}$",
    "zmp": r"$p_c$ (ZMP)",
    "zmp_plan": r"$p^{plan}$",
    "com": "CoM",
}
COLOURS = {
    "dcm": palette.DCM,
    "dcm_plan": palette.DCM_PLAN,
    "zmp": palette.ZMP,
    "zmp_plan": "#d6749b",
    "com": palette.COM,
}
WIDTHS = {"dcm": 1.9, "dcm_plan": 1.3, "zmp": 1.4, "zmp_plan": 2.6, "com": 1.2}


def ground_figure(
    titles: Sequence[str], low: tuple[float, float], high: tuple[float, float]
) -> tuple[Figure, list[Axes]]:
    """A picture of top views below each other, all of the same ground in true proportions.

    Args:
        titles: one for each top view.
        low: smallest x and y that are shown [m].
        high: largest x and y [m].
    """
    width = WIDTH - LEFT - RIGHT
    height = width * (high[1] - low[1]) / (high[0] - low[0])
    total = len(titles) * (HEAD + height + FOOT) + LEGEND
    figure = Figure(figsize=(WIDTH, total), facecolor="white")
    axes = []
    for index, title in enumerate(titles):
        bottom = total - (index + 1) * (HEAD + height) - index * FOOT
        ax = figure.add_axes((LEFT / WIDTH, bottom / total, width / WIDTH, height / total))
        ax.set_xlim(low[0], high[0])
        ax.set_ylim(low[1], high[1])
        ax.set_xlabel("x [m]")
        ax.set_ylabel("y [m]")
        ax.set_title(title, loc="left", fontsize=9.5, fontweight="bold")
        axes.append(ax)
    return figure, axes


def time_figure(
    title: str, labels: Sequence[str], until: float, height: float = 1.7
) -> tuple[Figure, list[Axes]]:
    """A picture of plots over time below each other.

    Args:
        title: of the picture.
        labels: of the vertical axes.
        until: last instant that is shown [s].
        height: of one plot [in].
    """
    gap, width = 0.14, WIDTH - LEFT - RIGHT
    total = HEAD + len(labels) * (height + gap) + FOOT + LEGEND
    figure = Figure(figsize=(WIDTH, total), facecolor="white")
    axes = []
    for index, label in enumerate(labels):
        bottom = total - HEAD - (index + 1) * height - index * gap
        ax = figure.add_axes((LEFT / WIDTH, bottom / total, width / WIDTH, height / total))
        ax.set_xlim(0.0, until)
        ax.set_ylabel(label)
        ax.yaxis.set_label_coords(-0.06, 0.5)
        ax.grid(axis="y", color="#e8e8e8", linewidth=0.5)
        ax.set_axisbelow(True)
        ax.tick_params(labelbottom=index == len(labels) - 1)
        axes.append(ax)
    axes[0].set_title(title, loc="left", fontsize=9.5, fontweight="bold")
    axes[-1].set_xlabel("time [s]")
    return figure, axes


def draw_soles(ax: Axes, rollout: Rollout, *, numbered: bool = True) -> list[Stance]:
    """The footprints in true size, with p_k and the number of the step that brought it there."""
    parts, foot = stances(rollout), rollout.robot.foot
    start = rollout.swing_foot[0]
    soles = [((float(start[0]), float(start[1])), parts[0].side.other, False)]
    soles += [
        (part.support_foot, part.side, before is not None and before.adapted)
        for before, part in zip([None, *parts[:-1]], parts, strict=True)
    ]
    for number, (centre, side, online) in enumerate(soles, start=-1):
        ax.add_patch(
            Rectangle(
                (centre[0] - foot.half[0], centre[1] - foot.half[1]), foot.length, foot.width,
                facecolor=palette.SOLE[side], linewidth=1.8 if online else 0.8, zorder=1.0,
                edgecolor=palette.ADAPTED if online else palette.SOLE_EDGE[side],
            )
        )  # fmt: skip
        ax.plot(*centre, "+", color=palette.QUIET, markersize=5.0, markeredgewidth=0.8, zorder=1.2)
        low, high = ax.get_xlim()
        if numbered and number > 0 and low < centre[0] < high - 0.03:
            outward = 1.0 if side is Side.LEFT else -1.0
            ax.annotate(
                str(number), (centre[0], centre[1] + outward * foot.half[1]),
                xytext=(0.0, 3.0 * outward), textcoords="offset points", ha="center",
                va="bottom" if outward > 0.0 else "top", fontsize=7.5, annotation_clip=True,
                color=palette.ADAPTED if online else palette.QUIET,
                fontweight="bold" if online else "normal",
            )  # fmt: skip
    return parts


def draw_curve(ax: Axes, name: str, points: NDArray[np.float64], **options: object) -> None:
    """One curve of the top view, in the colour that its quantity has everywhere.

    Args:
        ax: where to draw.
        name: key of `SYMBOLS`.
        points: shape (n, 2) [m].
        **options: of the line, before those of the quantity.
    """
    ax.plot(*points.T, **line_style(name, **options))  # type: ignore[arg-type]


def line_style(name: str, **options: object) -> dict[str, object]:
    """How a quantity is drawn."""
    dash = PLAN_DASH if name == "dcm_plan" else "solid"
    order = {"zmp_plan": 2.5, "zmp": 3.0, "com": 3.5, "dcm": 4.0, "dcm_plan": 4.2}[name]
    return {
        "color": COLOURS[name], "linewidth": WIDTHS[name], "linestyle": dash, "zorder": order,
        **options,
    }  # fmt: skip


def paths(rollout: Rollout, parts: list[Stance]) -> dict[str, NDArray[np.float64]]:
    """The curves of a top view, cut at touchdowns where they may jump, shape (m, 2) [m]."""
    return {
        "dcm": rollout.dcm,
        "dcm_plan": broken(rollout.dcm_plan, parts),
        "zmp": broken(rollout.zmp, parts),
        "com": rollout.com,
    }


def shade_push_in_space(ax: Axes, rollout: Rollout) -> None:
    """Yellow where the DCM is while a push acts."""
    for push in strong_pushes(rollout):
        x = np.interp([push.start, push.end], rollout.time, rollout.dcm[:, 0])
        ax.axvspan(x[0], x[1], color=palette.PUSH, alpha=0.28, linewidth=0.0, zorder=0.5)


def number_steps(ax: Axes, rollout: Rollout) -> None:
    """The number of every step, inside the upper edge; bold if it was decided online."""
    _, until = ax.get_xlim()
    for step in rollout.footsteps:
        middle = step.start + 0.5 * step.duration
        if middle < until:
            ax.text(
                middle, 0.97, str(step.index + 1), transform=ax.get_xaxis_transform(), va="top",
                ha="center", fontsize=7.5, fontweight="bold" if step.adapted else "normal",
                color=palette.ADAPTED if step.adapted else palette.QUIET, zorder=6.0,
            )  # fmt: skip


def add_legend(figure: Figure, names: Sequence[str], extra: Sequence[Artist] = ()) -> None:
    """A line or two below the picture: curves, and what else there is to name."""
    handles: list[Artist] = [
        Line2D([], [], label=SYMBOLS[name], **line_style(name))  # type: ignore[arg-type]
        for name in names
    ]
    handles += extra
    count = len(handles)
    figure.legend(
        handles=handles, loc="lower center", ncols=count if count <= 5 else math.ceil(count / 2),
        frameon=False, bbox_to_anchor=(0.5, 0.0), borderaxespad=0.2, handlelength=2.0,
        columnspacing=1.3,
    )  # fmt: skip


def push_patch(rollout: Rollout) -> Patch:
    """The legend's word for the yellow shade."""
    words = ", ".join(
        f"{math.hypot(*push.force):g} N for {push.duration:g} s" for push in strong_pushes(rollout)
    )
    for push in acting_pushes(rollout):
        if math.isinf(push.duration):
            words += f", and ({push.force[0]:g}, {push.force[1]:g}) N in every step"
    return Patch(facecolor=palette.PUSH, alpha=0.4, linewidth=0.0, label=f"push {words}")


def sole_patches() -> list[Patch]:
    """The legend's words for the soles."""
    return [
        Patch(
            facecolor=palette.SOLE[side], edgecolor=palette.SOLE_EDGE[side], linewidth=0.8,
            label=f"{side.name.lower()} sole",
        )
        for side in (Side.LEFT, Side.RIGHT)
    ]  # fmt: skip

"""What happened: touchdowns, pushes, decisions online, new commands, the fall.

From above a push is an arrow at the CoM, the stretch of CoM and DCM under it, and its words.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from surefoot.dcm.pushes import Push
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.page import LINE, Extent, units_per_inch
from surefoot.show.picture_file import HALO
from surefoot.show.plotted_walk import PlottedWalk
from surefoot.show.stances import (
    Stance,
    acting_pushes,
    commanded,
    pair,
    push_opacity,
    push_samples,
    runs,
    touchdown_cycles,
)
from surefoot.show.words import command_label, command_words, push_label

LABELLED_PUSHES = 4
"""Of more pushes than this, only the strongest have words."""


def mark_events(ax: Axes, walk: PlottedWalk) -> None:
    """Mark in a plot over time what happened when.

    Args:
        ax: the plot; its name (gid) is part of the names of the marks.
        walk: what is drawn.
    """
    rollout = walk.rollout
    _shade_pushes(ax, rollout)
    _hatch_decisions(ax, rollout, walk.parts)
    landed = rollout.time[touchdown_cycles(rollout)].tolist()
    _draw_instants(ax, "touchdowns", landed, color=palette.TOUCHDOWN, linewidth=0.5, zorder=1.6)
    changes = [command.time for command in commanded(rollout)[1:]]
    _draw_instants(
        ax, "new-velocity", changes, color=palette.COM, linewidth=0.9,
        linestyle=(0, (6, 2, 1, 2)), zorder=1.7,
    )  # fmt: skip
    _draw_fall(ax, rollout)


def _draw_fall(ax: Axes, rollout: Rollout) -> None:
    """Lines where the fall could not be averted any more, and where it ended."""
    fall, body_fall = rollout.fall, rollout.body_fall
    if fall is None:
        return
    lost, end = (
        (fall.lost_time, fall.time) if body_fall is None else (body_fall.time, body_fall.end)
    )
    alarm: dict[str, Any] = {"color": palette.ALARM, "linewidth": 1.2, "zorder": 4.5}
    _draw_instants(ax, "fell", [end], clip_on=False, **alarm)
    if lost is not None:
        _draw_instants(ax, "lost", [lost], linestyle=(0, (4, 2)), **alarm)


def strong_pushes(rollout: Rollout) -> list[Push]:
    """The pushes that end: those without end are the small ones that act in every step."""
    return [push for push in acting_pushes(rollout) if math.isfinite(push.duration)]


def shade_push_in_time(ax: Axes, rollout: Rollout) -> None:
    """Yellow while a push acts, and a thin line at every touchdown."""
    for push in strong_pushes(rollout):
        ax.axvspan(push.start, push.end, color=palette.PUSH, alpha=0.35, linewidth=0.0, zorder=0.5)
    for step in rollout.footsteps:
        ax.axvline(step.start + step.duration, color=palette.TOUCHDOWN, linewidth=0.5, zorder=0.6)


def _shade_pushes(ax: Axes, rollout: Rollout) -> None:
    for index, push in enumerate(acting_pushes(rollout)):
        ax.axvspan(
            max(push.start, rollout.time[0]), min(push.end, rollout.time[-1]),
            facecolor=palette.PUSH, edgecolor="none", alpha=push_opacity(rollout, push),
            zorder=1.5, gid=f"push-{ax.get_gid()}-{index}",
        )  # fmt: skip


def _hatch_decisions(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    for part in parts:
        for run in runs(rollout.adapting[part.samples], part.samples.start):
            end = part.end if run.stop == part.samples.stop else float(rollout.time[run.stop])
            ax.axvspan(
                float(rollout.time[run.start]), end, facecolor="none", edgecolor=palette.ADAPTED,
                hatch="////", linewidth=0.0, alpha=0.3, zorder=1.4,
                gid=f"adapting-{ax.get_gid()}-{run.start}",
            )  # fmt: skip


def _draw_instants(ax: Axes, name: str, times: list[float], **look: Any) -> None:
    """Vertical lines through the whole plot."""
    if times:
        across, gid = ax.get_xaxis_transform(), f"{name}-{ax.get_gid()}"
        ax.vlines(times, 0.0, 1.0, transform=across, gid=gid, **look)


def name_events(ax: Axes, rollout: Rollout) -> None:
    """Write beside their lines new commands, and when the robot was lost and when it fell."""
    words = command_words if rollout.body is None else command_label
    for command in commanded(rollout)[1:]:
        late = rollout.body is not None and command.time > 0.8 * float(rollout.time[-1])
        gid = f"command-{command.time:g}"
        _name(ax, words(command), command.time, 0.96, gid, left=late, fontsize=7.5, clip_on=True)
    fall, body_fall = rollout.fall, rollout.body_fall
    if fall is None:
        return
    signs = [("lost", fall.lost_time, "lost"), ("fell", fall.time, "fell")]
    if body_fall is not None:
        signs = [("lost", body_fall.time, body_fall.cause.value)]
    for height, (name, time, text) in zip((0.96, 0.75), signs, strict=False):
        if time is not None:
            _name(
                ax, text, time, height, f"{name}-label", left=True, fontsize=8.0,
                fontweight="bold", color=palette.ALARM,
            )  # fmt: skip


def _name(
    ax: Axes, text: str, time: float, height: float, gid: str, *, left: bool, **look: Any
) -> None:
    """Write a text beside the line of an instant, at a height from 0 to 1."""
    ax.annotate(
        text, (time, height), xycoords=("data", "axes fraction"),
        xytext=(-3.0 if left else 3.0, 0.0), textcoords="offset points",
        ha="right" if left else "left", va="top", path_effects=HALO, zorder=5.0, gid=gid, **look,
    )  # fmt: skip


def push_arrow(rollout: Rollout, push: Push) -> tuple[tuple[float, float], tuple[float, float]]:
    """Tail and tip of a push: the weight of the robot would be as long as its CoM is high."""
    robot = rollout.robot
    force = math.hypot(*push.force)
    tip = pair(rollout.com[push_samples(rollout, push).start])
    if force == 0.0:
        return tip, tip
    length = robot.com_height * min(max(force / (robot.mass * robot.gravity), 0.1), 0.7)
    way = np.array(push.force) / force
    return pair(tip - length * way), tip


def draw_push(ax: Axes, rollout: Rollout, push: Push, index: int) -> None:
    """Draw one push: yellow under CoM and DCM while it acts, and an arrow whose tip is at the CoM.

    Args:
        ax: the top view.
        rollout: the walk.
        push: one that acts in it.
        index: of the push, for the names of what is drawn.
    """
    acting, opacity = push_samples(rollout, push), push_opacity(rollout, push)
    for name, path in (("com", rollout.com), ("dcm", rollout.dcm)):
        ax.plot(
            *path[acting].T, color=palette.PUSH, linewidth=8.0, alpha=min(1.0, 2.0 * opacity),
            solid_capstyle="round", zorder=2.0, gid=f"push-{name}-{index}",
        )  # fmt: skip
    tail, tip = push_arrow(rollout, push)
    if tail == tip:
        return
    # A short arrow keeps its shape: its head is no more than half of it.
    points = 72.0 * math.dist(tail, tip) / units_per_inch(ax)
    head = min(9.0, 0.55 * points)
    shape = f"simple,head_length={head},head_width={head},tail_width={0.4 * head}"
    arrow = FancyArrowPatch(
        tail, tip, arrowstyle=shape, shrinkA=0.0, shrinkB=0.0, facecolor=palette.PUSH,
        edgecolor=palette.PUSH_EDGE, linewidth=0.8, zorder=5.0, gid=f"push-{index}",
    )  # fmt: skip
    ax.add_patch(arrow)


def _anchor(rollout: Rollout, push: Push) -> tuple[float, float]:
    """Where on its arrow the words about a push are tied: its upper end, or its middle."""
    tail, tip = push_arrow(rollout, push)
    if abs(tail[1] - tip[1]) > abs(tail[0] - tip[0]):
        return max(tail, tip, key=lambda end: end[1])
    return 0.5 * (tail[0] + tip[0]), 0.5 * (tail[1] + tip[1])


def label_places(rollout: Rollout, shown: Extent, width: float) -> list[tuple[Push, float, int]]:
    """Which pushes get words, and where: left end x [m], and the line above the picture, from 0.

    The words stand to the right of the line that ties them to their arrow, like a flag at its
    pole, and higher than all flags to the right that they would cover; so nothing crosses.

    Args:
        rollout: the walk.
        shown: the ground that the picture shows.
        width: of the picture [in].
    """
    pushes = acting_pushes(rollout)
    # If they are many, only the strongest have words.
    strong = sorted(pushes, key=lambda push: -math.hypot(*push.force))[:LABELLED_PUSHES]
    placed: list[tuple[Push, float, int]] = []
    for push in sorted(strong, key=lambda push: -_anchor(rollout, push)[0]):
        length = shown.size[0] / width * (0.066 * len(push_label(push)) + 0.1)
        pole = _anchor(rollout, push)[0]
        x = pole if pole + length <= shown.high[0] else max(pole - length, shown.low[0])
        covered = [level for _, other, level in placed if other <= x + length]
        placed.append((push, x, max(covered, default=-1) + 1))
    return placed


def label_pushes(ax: Axes, rollout: Rollout, shown: Extent) -> None:
    """Write force, duration and impulse of the pushes above the top view, at `label_places`."""
    scale = units_per_inch(ax)
    height, width = shown.size[1] / scale, shown.size[0] / scale
    for index, (push, x, level) in enumerate(label_places(rollout, shown, width)):
        anchor = _anchor(rollout, push)
        above = shown.high[1] + scale * (0.06 + LINE * level)
        ax.plot(
            [anchor[0]] * 2, [anchor[1], above + 0.8 * LINE * scale], linewidth=0.7,
            color=palette.PUSH_EDGE, zorder=4.9, clip_on=False, gid=f"push-pole-{index}",
        )  # fmt: skip
        ax.annotate(
            push_label(push), (x, 1.0 + (0.06 + LINE * level) / height),
            xycoords=ax.get_xaxis_transform(), xytext=(4.0, 0.0), textcoords="offset points",
            va="bottom", fontsize=8.5, fontweight="bold", color=palette.PUSH_EDGE,
            path_effects=HALO, annotation_clip=False, zorder=5.1, gid=f"push-label-{index}",
        )  # fmt: skip

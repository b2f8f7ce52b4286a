"""The ground seen from above: the part that is shown, its scale, and the pushes on it.

A push is an arrow at the CoM, the stretch of CoM and DCM under it, and its words.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from surefoot.dcm.pushes import Push
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.picture_file import HALO
from surefoot.show.stances import acting_pushes, pair, push_opacity, push_samples
from surefoot.show.words import push_label

LINE = 0.19
"""Distance between two lines of words [in]."""

LABELLED_PUSHES = 4
"""Of more pushes than this, only the strongest have words."""


@dataclass(frozen=True)
class Extent:
    """The part of the ground that a picture shows.

    Attributes:
        low: smallest x and y [m].
        high: largest x and y [m].
    """

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def size(self) -> tuple[float, float]:
        """Extent in x and in y [m]."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    def filling(self, width: float, height: float) -> Extent:
        """The extent, grown in one direction to the proportions of a box."""
        (size_x, size_y), middle = self.size, np.add(self.low, self.high) / 2.0
        scale = max(size_x / width, size_y / height)
        half = np.array([width, height]) * scale / 2.0
        return Extent(pair(middle - half), pair(middle + half))


def metres_per_inch(ax: Axes) -> float:
    """The scale of a top view [m/in]."""
    low, high = ax.get_xlim()
    width = ax.get_position().width * ax.figure.get_figure(root=True).get_size_inches()[0]
    return (high - low) / width


def draw_ground(ax: Axes, shown: Extent) -> None:
    """Set axes up as ground seen from above.

    Args:
        ax: its box has the proportions of `shown`.
        shown: the ground to show.
    """
    ax.set_aspect("equal")
    ax.set_xlim(shown.low[0], shown.high[0])
    ax.set_ylim(shown.low[1], shown.high[1])
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.grid(color="#e8e8e8", linewidth=0.5, zorder=0)
    ax.set_axisbelow(True)


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
            *path[acting].T,
            color=palette.PUSH,
            linewidth=8.0,
            alpha=min(1.0, 2.0 * opacity),
            solid_capstyle="round",
            zorder=2.0,
            gid=f"push-{name}-{index}",
        )
    tail, tip = push_arrow(rollout, push)
    if tail == tip:
        return
    # A short arrow keeps its shape: its head is no more than half of it.
    points = 72.0 * math.dist(tail, tip) / metres_per_inch(ax)
    head = min(9.0, 0.55 * points)
    arrow = FancyArrowPatch(
        tail,
        tip,
        arrowstyle=f"simple,head_length={head},head_width={head},tail_width={0.4 * head}",
        shrinkA=0.0,
        shrinkB=0.0,
        facecolor=palette.PUSH,
        edgecolor=palette.PUSH_EDGE,
        linewidth=0.8,
        zorder=5.0,
        gid=f"push-{index}",
    )
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
    scale = metres_per_inch(ax)
    height, width = shown.size[1] / scale, shown.size[0] / scale
    for index, (push, x, level) in enumerate(label_places(rollout, shown, width)):
        anchor = _anchor(rollout, push)
        above = shown.high[1] + scale * (0.06 + LINE * level)
        ax.plot(
            [anchor[0], anchor[0]],
            [anchor[1], above + 0.8 * LINE * scale],
            linewidth=0.7,
            color=palette.PUSH_EDGE,
            zorder=4.9,
            clip_on=False,
            gid=f"push-pole-{index}",
        )
        ax.annotate(
            push_label(push),
            (x, 1.0 + (0.06 + LINE * level) / height),
            xycoords=ax.get_xaxis_transform(),
            xytext=(4.0, 0.0),
            textcoords="offset points",
            va="bottom",
            fontsize=8.5,
            fontweight="bold",
            color=palette.PUSH_EDGE,
            path_effects=HALO,
            annotation_clip=False,
            zorder=5.1,
            gid=f"push-label-{index}",
        )

"""The walk from above: footprints in true size, CoM, DCM, its plan, the ZMP, and what pushed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Rectangle
from numpy.typing import NDArray

from surefoot.models.footsteps import Side
from surefoot.models.pushes import Push
from surefoot.simulation.lipm_simulator import FALL_DISTANCE
from surefoot.simulation.rollout import Rollout
from surefoot.viewers import palette
from surefoot.viewers.palette import HALO
from surefoot.viewers.stances import Stance, acting_pushes, broken, push_opacity, push_samples
from surefoot.viewers.walk_words import push_label

MARGIN = 0.1
"""Free space around what is drawn [m]."""

SMALLEST = 0.7
"""Extent of the ground that is shown at least, so that soles do not fill the picture [m]."""

SAME_PLACE = 0.05
"""Footprints of one foot that are closer than this share a number [m]."""

LABELLED_PUSHES = 6
"""More pushes than this are not told apart in words."""

NOTICEABLE = 0.002
"""Displacements smaller than this cannot be seen in a picture [m]."""


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
        return Extent(_pair(middle - half), _pair(middle + half))


def _pair(values: NDArray[np.float64]) -> tuple[float, float]:
    return float(values[0]), float(values[1])


def extent(rollout: Rollout, parts: list[Stance]) -> Extent:
    """The ground to show: all feet, CoM and DCM, and of ZMP and plan what does not run far away."""
    half = np.array(rollout.robot.foot.half)
    feet = np.array([foot for foot, _ in _soles(rollout, parts)])
    near = rollout.support_foot + np.clip(
        rollout.dcm - rollout.support_foot, -FALL_DISTANCE, FALL_DISTANCE
    )
    arrows = np.array([_arrow(rollout, push)[0] for push in acting_pushes(rollout)]).reshape(-1, 2)
    core = np.concatenate([feet - half, feet + half, rollout.com, near, arrows])
    low, high = core.min(axis=0), core.max(axis=0)
    far = np.concatenate([rollout.zmp, rollout.dcm_plan])
    low = np.maximum(np.minimum(low, far.min(axis=0)), low - 0.2)
    high = np.minimum(np.maximum(high, far.max(axis=0)), high + 0.2)
    middle = 0.5 * (low + high)
    half_size = np.maximum(0.5 * (high - low) + MARGIN, 0.5 * SMALLEST)
    return Extent(_pair(middle - half_size), _pair(middle + half_size))


def draw_top_view(ax: Axes, rollout: Rollout, parts: list[Stance], shown: Extent) -> None:
    """Draw the walk from above.

    Args:
        ax: where to draw; its box has the proportions of `shown`.
        rollout: the walk.
        parts: its stances.
        shown: the ground to show.
    """
    ax.set_aspect("equal")
    ax.set_xlim(shown.low[0], shown.high[0])
    ax.set_ylim(shown.low[1], shown.high[1])
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.grid(color="#e8e8e8", linewidth=0.5, zorder=0)
    ax.set_axisbelow(True)
    _draw_footprints(ax, rollout, parts)
    _number_footprints(ax, rollout, parts)
    for index, push in enumerate(acting_pushes(rollout)):
        _draw_push(ax, rollout, push, index)
    _draw_paths(ax, rollout, parts)
    _label_pushes(ax, rollout)
    if rollout.fall is not None:
        _mark_fall(ax, rollout, shown)


def _soles(rollout: Rollout, parts: list[Stance]) -> list[tuple[tuple[float, float], Side]]:
    """Every place where a foot stood: the swing foot's first, then in the order of landing."""
    start = rollout.swing_foot[0][:2]
    first = (_pair(start), parts[0].side.other)
    return [first, *((part.support_foot, part.side) for part in parts)]


def _draw_footprints(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    foot = rollout.robot.foot
    adapted = {part.number for part in parts if part.adapted}
    # The first sole belongs to no step of the run: it is where the swing foot came from.
    for number, (centre, side) in enumerate(_soles(rollout, parts), start=-1):
        online = number in adapted
        ax.add_patch(
            Rectangle(
                (centre[0] - foot.half[0], centre[1] - foot.half[1]),
                foot.length,
                foot.width,
                facecolor=palette.SOLE[side],
                edgecolor=palette.ADAPTED if online else palette.SOLE_EDGE[side],
                linewidth=1.8 if online else 0.8,
                zorder=1.5 if online else 1.0,
                gid=f"footprint-{number}" if number >= 0 else "footprint-start",
            )
        )
    for part in parts:
        nominal = part.nominal_landing
        if not part.adapted or part.landing is None or nominal is None:
            continue
        if math.dist(nominal, part.landing) < NOTICEABLE:
            continue
        ax.add_patch(
            Rectangle(
                (nominal[0] - foot.half[0], nominal[1] - foot.half[1]),
                foot.length,
                foot.width,
                fill=False,
                edgecolor=palette.ADAPTED,
                linewidth=1.0,
                linestyle=(0, (3.5, 2.5)),
                zorder=1.6,
                gid=f"nominal-landing-{part.number}",
            )
        )


def _number_footprints(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Write the number of its step beside every sole, on the outer side or, sideways, at the ends."""
    places: list[tuple[tuple[float, float], Side, list[int]]] = []
    for number, (centre, side) in enumerate(_soles(rollout, parts)[1:]):
        for other, other_side, numbers in places:
            if side is other_side and math.dist(centre, other) < SAME_PLACE:
                numbers.append(number)
                break
        else:
            places.append((centre, side, [number]))
    adapted = {part.number for part in parts if part.adapted}
    moved = np.abs(np.subtract(parts[-1].support_foot, parts[0].support_foot))
    sideways = moved[1] > max(moved[0], rollout.robot.hip)
    for centre, side, numbers in places:
        outward = 1.0 if side is Side.LEFT else -1.0
        half = np.array(rollout.robot.foot.half)
        way = np.array([outward, 0.0] if sideways else [0.0, outward])
        x, y = np.add(centre, way * half)
        online = not adapted.isdisjoint(numbers)
        ax.annotate(
            _run_of_numbers(numbers),
            (x, y),
            xytext=_pair(3.0 * way),
            textcoords="offset points",
            ha=("left" if outward > 0.0 else "right") if sideways else "center",
            va="center" if sideways else ("bottom" if outward > 0.0 else "top"),
            fontsize=8.5 if online else 7.5,
            fontweight="bold" if online else "normal",
            color=palette.ADAPTED if online else palette.QUIET,
            path_effects=HALO,
            clip_on=True,
            gid=f"number-{numbers[0]}",
            zorder=6.0,
        )


def _run_of_numbers(numbers: list[int]) -> str:
    if len(numbers) > 3:
        return f"{numbers[0]}, {numbers[1]} … {numbers[-1]}"
    return ", ".join(map(str, numbers))


def _draw_paths(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    zmp = broken(rollout.zmp, parts)
    ax.plot(*zmp.T, color=palette.ZMP, linewidth=1.2, zorder=3.0, gid="zmp")
    dots = rollout.zmp[_spaced(rollout.zmp)]
    ax.plot(
        *dots.T, ".", color=palette.ZMP, markersize=4.0, markeredgewidth=0, zorder=3.1,
        gid="zmp-points",
    )  # fmt: skip
    if rollout.zmp_excess.any():
        outside = np.where(rollout.zmp_excess[:, None] > 0.0, rollout.zmp, np.nan)
        ax.plot(
            *broken(outside, parts).T, color=palette.ALARM, linewidth=2.6, zorder=3.2,
            solid_capstyle="round", gid="zmp-outside",
        )  # fmt: skip
    ax.plot(*rollout.com.T, color=palette.COM, linewidth=1.3, zorder=4.15, gid="com")
    ax.plot(*rollout.dcm.T, color=palette.DCM, linewidth=2.0, zorder=4.1, gid="dcm")
    ax.plot(
        *broken(rollout.dcm_plan, parts).T, color=palette.DCM_PLAN, linewidth=1.1, zorder=4.2,
        linestyle=(0, (3, 2)), gid="dcm-plan",
    )  # fmt: skip
    landed = [part.samples.start for part in parts[1:]]
    ax.plot(
        *rollout.dcm[landed].T, "o", color="white", markeredgecolor=palette.DCM,
        markersize=3.6, markeredgewidth=1.0, zorder=4.3, gid="dcm-touchdown",
    )  # fmt: skip


def _spaced(points: NDArray[np.float64]) -> list[int]:
    """The first point and then every one that can be seen apart from the last one chosen."""
    chosen = [0]
    for index, (x, y) in enumerate(points):
        last_x, last_y = points[chosen[-1]]
        if math.hypot(x - last_x, y - last_y) > NOTICEABLE:
            chosen.append(index)
    return chosen


def _arrow(rollout: Rollout, push: Push) -> tuple[tuple[float, float], tuple[float, float]]:
    """Tail and tip of a push: the weight of the robot would be as long as its CoM is high."""
    robot = rollout.robot
    force = math.hypot(*push.force)
    tip = _pair(rollout.com[push_samples(rollout, push).start])
    if force == 0.0:
        return tip, tip
    length = robot.com_height * min(max(force / (robot.mass * robot.gravity), 0.1), 0.7)
    way = np.array(push.force) / force
    return _pair(tip - length * way), tip


def _draw_push(ax: Axes, rollout: Rollout, push: Push, index: int) -> None:
    acting, opacity = push_samples(rollout, push), push_opacity(rollout, push)
    for path in (rollout.com, rollout.dcm):
        ax.plot(
            *path[acting].T, color=palette.PUSH, linewidth=8.0, alpha=min(1.0, 2.0 * opacity),
            solid_capstyle="round", zorder=2.0, gid=f"push-path-{index}",
        )  # fmt: skip
    tail, tip = _arrow(rollout, push)
    if tail == tip:
        return
    arrow = FancyArrowPatch(
        tail,
        tip,
        arrowstyle="simple,head_length=9,head_width=9,tail_width=3.6",
        shrinkA=0.0,
        shrinkB=0.0,
        facecolor=palette.PUSH,
        edgecolor=palette.PUSH_EDGE,
        linewidth=0.8,
        zorder=5.0,
        gid=f"push-{index}",
    )
    ax.add_patch(arrow)


def label_levels(rollout: Rollout, shown: Extent, width: float) -> list[tuple[float, int]]:
    """Where the words about the pushes go: x [m] and the line above the picture, from 0.

    Args:
        rollout: the walk.
        shown: the ground that the picture shows.
        width: of the picture [in].
    """
    scale = shown.size[0] / width
    ends: list[float] = []
    places = []
    for push in _labelled(rollout):
        half = 0.5 * scale * (0.068 * len(push_label(push)) + 0.1)
        x = min(max(_arrow(rollout, push)[0][0], shown.low[0] + half), shown.high[0] - half)
        level = next((i for i, end in enumerate(ends) if x - half > end), len(ends))
        ends[level : level + 1] = [x + half]
        places.append((x, level))
    return places


def _labelled(rollout: Rollout) -> list[Push]:
    """The pushes that get words: all, or the strongest if they are many."""
    pushes = acting_pushes(rollout)
    strong = sorted(pushes, key=lambda push: -math.hypot(*push.force))[:LABELLED_PUSHES]
    return [push for push in pushes if push in strong]


def _label_pushes(ax: Axes, rollout: Rollout) -> None:
    low_x, high_x = ax.get_xlim()
    low_y, high_y = ax.get_ylim()
    box = ax.get_position()
    figure_width, figure_height = ax.figure.get_figure(root=True).get_size_inches()
    shown = Extent((low_x, low_y), (high_x, high_y))
    height = box.height * figure_height
    places = label_levels(rollout, shown, box.width * figure_width)
    for index, (push, (x, level)) in enumerate(zip(_labelled(rollout), places, strict=True)):
        ax.annotate(
            push_label(push),
            _pair(np.mean(_arrow(rollout, push), axis=0)),
            xytext=(x, 1.0 + (0.06 + 0.18 * level) / height),
            textcoords=ax.get_xaxis_transform(),
            ha="center",
            va="bottom",
            fontsize=8.5,
            fontweight="bold",
            color=palette.PUSH_EDGE,
            arrowprops={
                "arrowstyle": "-", "color": palette.PUSH_EDGE, "linewidth": 0.6, "shrinkA": 1.0,
                "shrinkB": 0.0, "relpos": (0.5, 0.0),
            },
            annotation_clip=False,
            zorder=4.9,
            gid=f"push-label-{index}",
        )  # fmt: skip


def _mark_fall(ax: Axes, rollout: Rollout, shown: Extent) -> None:
    """A cross where the DCM was at the end, tied to the foot that it ran away from."""
    foot, dcm = rollout.support_foot[-1], rollout.dcm[-1]
    ax.plot(
        *np.array([foot, dcm]).T, color=palette.ALARM, linewidth=1.0, linestyle=(0, (1, 1.5)),
        zorder=4.4, gid="fall-distance",
    )  # fmt: skip
    ax.plot(
        *dcm, "X", color=palette.ALARM, markersize=10.0, markeredgecolor="white",
        markeredgewidth=0.8, zorder=5.5, gid="fall",
    )  # fmt: skip
    x, y = _pair(np.clip(dcm, shown.low, shown.high))
    right = x > 0.5 * (shown.low[0] + shown.high[0])
    above = y < 0.5 * (shown.low[1] + shown.high[1])
    ax.annotate(
        f"fell at {rollout.time[-1]:.2f} s",
        (x, y),
        xytext=(4.0 if right else -4.0, 8.0 if above else -8.0),
        textcoords="offset points",
        ha="right" if right else "left",
        va="bottom" if above else "top",
        fontsize=8.5,
        fontweight="bold",
        color=palette.ALARM,
        path_effects=HALO,
        zorder=6.0,
        gid="fall-label",
    )

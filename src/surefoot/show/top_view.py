"""The walk from above: footprints in true size, CoM, DCM, its plan, the ZMP, and what pushed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.dcm.viability import fall_distance
from surefoot.robot.feet import Side
from surefoot.robot.robot import Foot
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.ground import Extent, draw_ground, metres_per_inch, pair
from surefoot.show.halo import HALO
from surefoot.show.palette import DASHES
from surefoot.show.push_arrows import draw_push, label_pushes, push_arrow
from surefoot.show.stances import Stance, acting_pushes, broken, sole_reach

MARGIN = 0.1
"""Free space around what is drawn [m]."""

SMALLEST = 0.7
"""Extent of the ground that is shown at least, so that soles do not fill the picture [m]."""

DOT_SPACING = 0.03
"""Distance of the dots that show the ZMP where it rests [m]."""

SAME_PLACE = 0.05
"""Footprints of one foot that are closer than this share a number [m]."""


def extent(rollout: Rollout, parts: list[Stance]) -> Extent:
    """The ground to show: all feet, CoM and DCM, and of ZMP and plan what does not run far away."""
    soles = [*_soles(rollout, parts), *_nominal_soles(parts)]
    centres = np.array([sole.centre for sole in soles])
    reach = sole_reach(rollout.robot.foot, np.array([sole.yaw for sole in soles]))
    away = fall_distance(rollout.robot)
    near = rollout.support_foot + np.clip(rollout.dcm - rollout.support_foot, -away, away)
    tails = [push_arrow(rollout, push)[0] for push in acting_pushes(rollout)]
    core = np.array([*(centres - reach), *(centres + reach), *rollout.com, *near, *tails])
    low, high = core.min(axis=0), core.max(axis=0)
    far = np.concatenate([rollout.zmp, rollout.dcm_plan])
    low = np.maximum(np.minimum(low, far.min(axis=0)), low - 0.2)
    high = np.minimum(np.maximum(high, far.max(axis=0)), high + 0.2)
    middle = 0.5 * (low + high)
    half_size = np.maximum(0.5 * (high - low) + MARGIN, 0.5 * SMALLEST)
    return Extent(pair(middle - half_size), pair(middle + half_size))


def draw_top_view(ax: Axes, rollout: Rollout, parts: list[Stance], shown: Extent) -> None:
    """Draw the walk from above.

    Args:
        ax: where to draw; its box has the proportions of `shown`.
        rollout: the walk.
        parts: its stances.
        shown: the ground to show.
    """
    draw_ground(ax, shown)
    _draw_footprints(ax, rollout, parts)
    _number_footprints(ax, rollout, parts)
    for index, push in enumerate(acting_pushes(rollout)):
        draw_push(ax, rollout, push, index)
    _draw_paths(ax, rollout, parts)
    label_pushes(ax, rollout, shown)
    if rollout.fall is not None:
        _mark_fall(ax, rollout, shown)


@dataclass(frozen=True)
class _Sole:
    """A place where a foot stood.

    Attributes:
        centre: of the sole (x, y) [m].
        yaw: its heading [rad].
        side: which foot.
        numbers: of the steps that brought it there, 0 for a foot that stood at the start.
    """

    centre: tuple[float, float]
    yaw: float
    side: Side
    numbers: tuple[int, ...]

    def rectangle(self, foot: Foot, **look: Any) -> Rectangle:
        """Its outline in true size."""
        return Rectangle(
            (self.centre[0] - foot.half[0], self.centre[1] - foot.half[1]),
            foot.length,
            foot.width,
            angle=math.degrees(self.yaw),
            rotation_point="center",
            **look,
        )


def _soles(rollout: Rollout, parts: list[Stance]) -> list[_Sole]:
    """Every place where a foot stood: the swing foot's first, then in the order of landing."""
    start, yaw = pair(rollout.swing_foot[0][:2]), float(rollout.observations["swing_yaw"][0])
    first = _Sole(start, yaw, parts[0].side.other, ())
    return [
        first,
        *(_Sole(part.support_foot, part.yaw, part.side, (part.number - 1,)) for part in parts),
    ]


def _nominal_soles(parts: list[Stance]) -> list[_Sole]:
    """Where the nominal gait would have put the feet of the steps that went elsewhere."""
    return [
        _Sole(part.moved_from, part.yaw, part.side.other, (part.number,))
        for part in parts
        if part.moved_from is not None
    ]


def _draw_footprints(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    foot = rollout.robot.foot
    adapted = {part.number for part in parts if part.adapted}
    for sole in _soles(rollout, parts):
        online = not adapted.isdisjoint(sole.numbers)
        ax.add_patch(
            sole.rectangle(
                foot,
                facecolor=palette.SOLE[sole.side],
                edgecolor=palette.ADAPTED if online else palette.SOLE_EDGE[sole.side],
                linewidth=1.8 if online else 0.8,
                zorder=1.5 if online else 1.0,
                # The swing foot's first place belongs to no step of the run.
                gid=f"footprint-{sole.numbers[0] if sole.numbers else 'start'}",
            )
        )
    for sole in _nominal_soles(parts):
        ax.add_patch(
            sole.rectangle(
                foot,
                fill=False,
                edgecolor=palette.ADAPTED,
                linewidth=1.0,
                linestyle=(0, (3.5, 2.5)),
                zorder=1.6,
                gid=f"nominal-landing-{sole.numbers[0]}",
            )
        )


def _number_footprints(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Write the number of its step at the outer side of every sole; sideways, at its ends."""
    adapted = {part.number for part in parts if part.adapted}
    ahead = np.array([1.0, 0.0] if _walks_sideways(rollout, parts) else [0.0, 1.0])
    # Where steps crowd, those that were decided online are the ones to name.
    places = sorted(_places(rollout, parts), key=lambda place: adapted.isdisjoint(place.numbers))
    taken: list[NDArray[np.float64]] = []
    for place in places:
        outward = ahead if place.side is Side.LEFT else -ahead
        spot = place.centre + _turned(outward * rollout.robot.foot.half, place.yaw)
        way = _turned(outward, place.yaw)
        apart = np.array([0.23, 0.15]) * metres_per_inch(ax)
        if any(np.all(np.abs(spot - other) < apart) for other in taken):
            continue
        taken.append(spot)
        online = not adapted.isdisjoint(place.numbers)
        ax.annotate(
            _run_of_numbers(place.numbers),
            pair(spot),
            xytext=pair(3.0 * way),
            textcoords="offset points",
            ha=("right", "center", "left")[1 + round(way[0])],
            va=("top", "center", "bottom")[1 + round(way[1])],
            fontsize=8.5 if online else 7.5,
            fontweight="bold" if online else "normal",
            color=palette.ADAPTED if online else palette.QUIET,
            path_effects=HALO,
            gid=f"number-{place.numbers[0]}",
            zorder=6.0,
        )


def _walks_sideways(rollout: Rollout, parts: list[Stance]) -> bool:
    """Whether the feet, in their own directions, moved to the side more than ahead."""
    moved = sum(
        _turned(np.subtract(after.support_foot, before.support_foot), -before.yaw)
        for before, after in pairwise(parts)
    )
    ahead, aside = np.abs(moved) * np.ones(2)
    return bool(aside > max(ahead, rollout.robot.hip))


def _turned(vector: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """A vector turned counter-clockwise by an angle [rad]."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]])


def _places(rollout: Rollout, parts: list[Stance]) -> list[_Sole]:
    """Where feet stood in the run; in place, several steps lead to the same."""
    places: list[_Sole] = []
    for sole in _soles(rollout, parts)[1:]:
        for index, place in enumerate(places):
            if sole.side is place.side and math.dist(sole.centre, place.centre) < SAME_PLACE:
                places[index] = replace(place, numbers=place.numbers + sole.numbers)
                break
        else:
            places.append(sole)
    return places


def _run_of_numbers(numbers: tuple[int, ...]) -> str:
    if len(numbers) > 4:
        return f"{numbers[0]}, {numbers[1]} … {numbers[-1]}"
    return ", ".join(map(str, numbers))


def _draw_paths(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    zmp = broken(rollout.zmp, parts)
    ax.plot(*zmp.T, color=palette.ZMP, linewidth=1.2, zorder=3.0, gid="zmp")
    dots = rollout.zmp[_spaced(rollout.zmp)]
    ax.plot(
        *dots.T,
        ".",
        color=palette.ZMP,
        markersize=4.0,
        markeredgewidth=0,
        zorder=3.1,
        gid="zmp-points",
    )
    if rollout.zmp_excess.any():
        outside = np.where(rollout.zmp_excess[:, None] > 0.0, rollout.zmp, np.nan)
        ax.plot(
            *broken(outside, parts).T,
            color=palette.ALARM,
            linewidth=2.6,
            zorder=3.2,
            solid_capstyle="round",
            gid="zmp-outside",
        )
    ax.plot(*rollout.com.T, color=palette.COM, linewidth=1.3, zorder=4.15, gid="com")
    ax.plot(*rollout.dcm.T, color=palette.DCM, linewidth=2.0, zorder=4.1, gid="dcm")
    ax.plot(
        *broken(rollout.dcm_plan, parts).T,
        color=palette.DCM_PLAN,
        linewidth=1.1,
        zorder=4.2,
        linestyle=DASHES,
        gid="dcm-plan",
    )
    landed = [part.samples.start for part in parts[1:]]
    ax.plot(
        *rollout.dcm[landed].T,
        "o",
        color="white",
        markeredgecolor=palette.DCM,
        markersize=3.6,
        markeredgewidth=1.0,
        zorder=4.3,
        gid="dcm-touchdown",
    )


def _spaced(points: NDArray[np.float64]) -> list[int]:
    """The first point, and then every one that is a spacing away from the last one chosen."""
    chosen = [0]
    for index, (x, y) in enumerate(points):
        last_x, last_y = points[chosen[-1]]
        if math.hypot(x - last_x, y - last_y) > DOT_SPACING:
            chosen.append(index)
    return chosen


def _mark_fall(ax: Axes, rollout: Rollout, shown: Extent) -> None:
    """A cross where the DCM was at the end, tied to the foot that it ran away from."""
    foot, dcm = rollout.support_foot[-1], rollout.dcm[-1]
    ax.plot(
        *np.array([foot, dcm]).T,
        color=palette.ALARM,
        linewidth=1.0,
        linestyle=(0, (1, 1.5)),
        zorder=4.4,
        gid="fall-distance",
    )
    ax.plot(
        *dcm,
        "X",
        color=palette.ALARM,
        markersize=10.0,
        markeredgecolor="white",
        markeredgewidth=0.8,
        zorder=5.5,
        gid="fall",
    )
    x, y = pair(np.clip(dcm, shown.low, shown.high))
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

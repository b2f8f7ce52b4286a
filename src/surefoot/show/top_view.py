"""The walk from above: footprints in true size, CoM, DCM, its plan, the ZMP, and what pushed."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.geometry import rotated
from surefoot.robot.feet import Side
from surefoot.robot.floor import laid_boards
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.page import Extent, units_per_inch
from surefoot.show.picture_file import HALO
from surefoot.show.plotted_walk import PlottedWalk, Sole
from surefoot.show.stances import acting_pushes, pair, touchdown_cycles
from surefoot.show.walk_events import draw_push, label_pushes, push_arrow

MARGIN = 0.1
"""Free space around what is drawn [m]."""

SMALLEST = 0.7
"""Extent of the ground that is shown at least, so that soles do not fill the picture [m]."""

SAME_PLACE = 0.05
"""Footprints of one foot that are closer than this share a number [m]."""

INSET = 0.1
"""Of the mark of a body's fall whose place is beyond the picture [in]."""

ONLY_OVER_TIME = ("zmp-plan",)
"""Lines that the view from above has no room for."""

DOT_SPACING = 0.03
"""Distance of the dots that show the ZMP where it rests [m]."""


def extent(walk: PlottedWalk) -> Extent:
    """The ground to show: what the walk needs, and all pushes."""
    rollout = walk.rollout
    tails = [push_arrow(rollout, push)[0] for push in acting_pushes(rollout)]
    walked = walk.extent(walk.soles + walk.missed_soles, walk.nearby(rollout.com))
    core = np.array([*walked, *tails])
    low, high = core.min(axis=0), core.max(axis=0)
    middle = 0.5 * (low + high)
    half_size = np.maximum(0.5 * (high - low) + MARGIN, 0.5 * SMALLEST)
    return Extent(pair(middle - half_size), pair(middle + half_size))


def draw_top_view(ax: Axes, walk: PlottedWalk, shown: Extent, *, labelled: bool = True) -> None:
    """Draw the walk from above.

    Args:
        ax: where to draw; its box has the proportions of `shown`.
        walk: what to draw.
        shown: the ground to show.
        labelled: whether the words of the pushes stand above it.
    """
    rollout = walk.rollout
    ax.set_aspect("equal")
    ax.set(
        xlim=(shown.low[0], shown.high[0]), ylim=(shown.low[1], shown.high[1]), xlabel="x [m]",
        ylabel="y [m]",
    )  # fmt: skip
    ax.grid(color=palette.GRID, linewidth=0.5, zorder=0)
    ax.set_axisbelow(True)
    if rollout.body is not None:
        _draw_boards(ax, rollout.body, shown)
    _draw_footprints(ax, walk)
    if rollout.body is None:
        _number_footprints(ax, walk)
    for index, push in enumerate(acting_pushes(rollout)):
        draw_push(ax, rollout, push, index)
    for curve in walk.curves:
        if curve.name not in ONLY_OVER_TIME:
            ax.plot(*curve.points.T, gid=curve.name, **curve.look)
    if rollout.body is None:
        dots = rollout.zmp[_spaced(rollout.zmp)]
        ax.plot(*dots.T, ".", color=palette.ZMP, markersize=4.0, markeredgewidth=0, zorder=3.1,
                gid="zmp-points")  # fmt: skip
    landed = touchdown_cycles(rollout)
    ax.plot(
        *rollout.dcm[landed].T, "o", color="white", markeredgecolor=palette.DCM, markersize=3.6,
        markeredgewidth=1.0, zorder=4.3, gid="dcm-touchdown",
    )  # fmt: skip
    if labelled:
        label_pushes(ax, rollout, shown)
    if rollout.fallen:
        _mark_fall(ax, rollout, shown)


def _draw_boards(ax: Axes, trace: BodyTrace, shown: Extent) -> None:
    for index, board in enumerate(laid_boards(trace.boards)):
        place, half = board["place"], board["half"]
        reach = float(np.hypot(*half))
        if (place + reach < shown.low).any() or (place - reach > shown.high).any():
            continue
        ax.add_patch(
            Rectangle(
                pair(place - half), *(2.0 * half), angle=math.degrees(board["heading"]),
                rotation_point="center", facecolor=palette.BOARD, linewidth=0.0, zorder=0.5,
                gid=f"board-{index}",
            )
        )  # fmt: skip


def _draw_footprints(ax: Axes, walk: PlottedWalk) -> None:
    """Draw the soles, and the outlines of those that were to land elsewhere."""
    foot = walk.rollout.robot.foot
    for sole in walk.soles:
        edge = palette.ADAPTED if sole.online else palette.SOLE_EDGE[sole.side]
        width, zorder = (1.8, 1.5) if sole.online else (0.8, 1.0)
        colour = palette.SOLE[sole.side]
        ax.add_patch(
            sole.rectangle(foot, facecolor=colour, edgecolor=edge, linewidth=width, zorder=zorder)
        )
    for sole in walk.missed_soles:
        ax.add_patch(sole.rectangle(foot, **palette.MISSED, zorder=1.6))


def _number_footprints(ax: Axes, walk: PlottedWalk) -> None:
    """Write the number of its step at the outer side of every sole; sideways, at its ends."""
    ahead = np.array([1.0, 0.0] if _walks_sideways(walk) else [0.0, 1.0])
    half, taken = walk.rollout.robot.foot.half, list[NDArray[np.float64]]()
    # Where steps crowd, those that were decided online are the ones to name.
    for place in sorted(_places(walk.soles[1:]), key=lambda place: not place.online):
        outward = ahead if place.side is Side.LEFT else -ahead
        spot = place.centre + np.array(rotated(outward * half, place.yaw))
        spacing = np.array([0.23, 0.15]) * units_per_inch(ax)
        if any(np.all(np.abs(spot - other) < spacing) for other in taken):
            continue
        taken.append(spot)
        x, y = rotated(outward, place.yaw)
        ax.annotate(
            _listed(place.numbers), pair(spot), xytext=(3.0 * x, 3.0 * y),
            textcoords="offset points", ha=("right", "center", "left")[1 + round(x)],
            va=("top", "center", "bottom")[1 + round(y)], **palette.step_number(place.online),
            path_effects=HALO, gid=f"number-{place.numbers[0]}", zorder=6.0,
        )  # fmt: skip


def _walks_sideways(walk: PlottedWalk) -> bool:
    """Whether the feet, in their own directions, moved to the side more than ahead."""
    moved = np.zeros(2)
    for before, after in pairwise(walk.parts):
        moved += rotated(np.subtract(after.support_foot, before.support_foot), -before.yaw)
    ahead, aside = np.abs(moved)
    return bool(aside > max(ahead, walk.rollout.robot.hip))


def _places(soles: list[Sole]) -> list[Sole]:
    """Where feet stood in the run; in place, several steps lead to the same."""
    places: list[Sole] = []
    for sole in soles:
        for index, place in enumerate(places):
            if sole.side is place.side and math.dist(sole.centre, place.centre) < SAME_PLACE:
                numbers, online = place.numbers + sole.numbers, place.online or sole.online
                places[index] = replace(place, numbers=numbers, online=online)
                break
        else:
            places.append(sole)
    return places


def _listed(numbers: tuple[int, ...]) -> str:
    if len(numbers) > 4:
        return f"{numbers[0]}, {numbers[1]} … {numbers[-1]}"
    return ", ".join(map(str, numbers))


def _spaced(points: NDArray[np.float64]) -> list[int]:
    """The first point, and then every one that is a spacing away from the last one chosen."""
    chosen = [0]
    for index, (x, y) in enumerate(points):
        last_x, last_y = points[chosen[-1]]
        if math.hypot(x - last_x, y - last_y) > DOT_SPACING:
            chosen.append(index)
    return chosen


def _mark_fall(ax: Axes, rollout: Rollout, shown: Extent) -> None:
    """A cross where the DCM was at the end, and when that was.

    That of a point mass is tied to the foot that it ran away from; that of a body, which ends
    further away, stays in the picture and has the cause beside it.
    """
    words, dcm = f"fell at {rollout.time[-1]:.2f} s", rollout.dcm[-1]
    fall = rollout.body_fall
    if fall is None:
        ax.plot(
            *np.array([rollout.support_foot[-1], dcm]).T, color=palette.ALARM, linewidth=1.0,
            linestyle=(0, (1, 1.5)), zorder=4.4, gid="fall-distance",
        )  # fmt: skip
        inset, offset = 0.0, -4.0
    else:
        words, inset, offset = f"{words}: {fall.cause.value}", INSET * units_per_inch(ax), 8.0
    x, y = pair(np.clip(dcm, np.add(shown.low, inset), np.subtract(shown.high, inset)))
    ax.plot(
        *(dcm if fall is None else (x, y)), "X", color=palette.ALARM, markersize=10.0,
        markeredgecolor="white", markeredgewidth=0.8, zorder=5.5, gid="fall",
    )  # fmt: skip
    right = x > 0.5 * (shown.low[0] + shown.high[0])
    above = y < 0.5 * (shown.low[1] + shown.high[1])
    ax.annotate(
        words, (x, y), xytext=(-offset if right else offset, 8.0 if above else -8.0),
        textcoords="offset points", ha="right" if right else "left",
        va="bottom" if above else "top", fontsize=8.5, fontweight="bold", color=palette.ALARM,
        path_effects=HALO, zorder=6.0, gid="fall-label",
    )  # fmt: skip

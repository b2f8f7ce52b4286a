"""A walk in physics from above: where the feet stood and were meant to, CoM, DCM, ZMP, pushes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.robot.feet import Side
from surefoot.robot.floor import laid_boards
from surefoot.robot.robot import Foot
from surefoot.rollout.measures import planned_com
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.ground import Extent, draw_ground, metres_per_inch, pair
from surefoot.show.halo import HALO
from surefoot.show.palette import DASHES
from surefoot.show.push_arrows import draw_push, label_pushes, push_arrow
from surefoot.show.stances import acting_pushes, sole_reach

MARGIN, SMALLEST = 0.1, 0.7
"""Free space around what is drawn, and extent of the ground that is shown at least [m]."""

NEARBY = 0.45
"""CoM and DCM are shown as far as this from the standing foot: those of a fall run away [m]."""

INSET = 0.1
"""Of the mark of a fall whose place is beyond the picture [in]."""

MISSED = 0.01
"""A foot that landed this far from its target has the target drawn too [m]."""


def standing_places(trace: BodyTrace) -> list[tuple[int, int, NDArray[np.float64], float]]:
    """Where feet stood: cycle in which one began to, foot, place (x, y) [m] and heading [rad].

    A place is that of the middle of the stance: a foot that lands still settles.
    """
    found = []
    for foot in (0, 1):
        carries = (~trace.walking) | (trace.support == foot)
        edges = np.flatnonzero(np.diff(np.concatenate(([0], carries.astype(int), [0]))))
        for first, last in edges.reshape(-1, 2).tolist():
            middle = (first + last) // 2
            place = trace.sole_position[middle, foot, :2]
            found.append((first, foot, place, float(trace.sole_turn[middle, foot, 2])))
    return sorted(found, key=lambda item: item[:2])


def body_extent(rollout: Rollout, trace: BodyTrace) -> Extent:
    """The ground to show: all places of feet, pushes, and CoM and DCM as far as they matter."""
    places = standing_places(trace)
    centres = np.array([place for _, _, place, _ in places])
    reach = sole_reach(trace.robot.foot, np.array([yaw for *_, yaw in places]))
    near = [
        rollout.support_foot + np.clip(path - rollout.support_foot, -NEARBY, NEARBY)
        for path in (rollout.com, rollout.dcm)
    ]
    tails = [push_arrow(rollout, push)[0] for push in acting_pushes(rollout)]
    points = np.array([*(centres - reach), *(centres + reach), *near[0], *near[1], *tails])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = 0.5 * (low + high), np.maximum(0.5 * (high - low) + MARGIN, 0.5 * SMALLEST)
    return Extent(pair(middle - half), pair(middle + half))


def draw_body_top_view(ax: Axes, rollout: Rollout, trace: BodyTrace, shown: Extent) -> None:
    """Draw the walk from above.

    Args:
        ax: where to draw; its box has the proportions of `shown`.
        rollout: the walk.
        trace: its `body`.
        shown: the ground to show.
    """
    draw_ground(ax, shown)
    _draw_boards(ax, trace, shown)
    _draw_soles(ax, rollout, trace)
    for index, push in enumerate(acting_pushes(rollout)):
        draw_push(ax, rollout, push, index)
    _draw_paths(ax, rollout, trace)
    label_pushes(ax, rollout, shown)
    fall = rollout.body_fall
    if fall is not None:
        _mark_fall(ax, rollout, shown, fall.cause.value)


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


def _draw_soles(ax: Axes, rollout: Rollout, trace: BodyTrace) -> None:
    foot = trace.robot.foot
    for index, (row, side, place, yaw) in enumerate(standing_places(trace)):
        whose = Side(2 * side - 1)
        look = {"facecolor": palette.SOLE[whose], "edgecolor": palette.SOLE_EDGE[whose]}
        ax.add_patch(
            _sole(foot, place, yaw, linewidth=0.8, zorder=1.0, gid=f"sole-{index}", **look)
        )
        if row == 0 or not trace.walking[row - 1]:
            continue
        target = rollout.commands["step_location"][row - 1]
        if math.dist(target, place) > MISSED:
            ax.add_patch(
                _sole(
                    foot,
                    target,
                    yaw,
                    fill=False,
                    edgecolor=palette.ADAPTED,
                    linewidth=0.8,
                    linestyle=DASHES,
                    zorder=1.6,
                    gid=f"target-{index}",
                )
            )


def _sole(foot: Foot, centre: NDArray[np.float64], yaw: float, **look: Any) -> Rectangle:
    corner = (centre[0] - foot.half[0], centre[1] - foot.half[1])
    return Rectangle(
        corner, foot.length, foot.width, angle=math.degrees(yaw), rotation_point="center", **look
    )


def _draw_paths(ax: Axes, rollout: Rollout, trace: BodyTrace) -> None:
    ax.plot(*rollout.zmp.T, color=palette.ZMP, linewidth=1.0, alpha=0.9, zorder=3.0, gid="zmp")
    plan = _broken(rollout.dcm_plan, trace)
    ax.plot(*rollout.dcm.T, color=palette.DCM, linewidth=1.8, zorder=4.1, gid="dcm")
    ax.plot(*rollout.com.T, color=palette.COM, linewidth=1.3, zorder=4.15, gid="com")
    look = {"linewidth": 1.0, "linestyle": DASHES}
    ax.plot(*plan.T, color=palette.DCM_PLAN, zorder=4.2, gid="dcm-plan", **look)
    com = planned_com(rollout, trace)
    ax.plot(*com.T, color=palette.COM_PLAN, zorder=4.25, gid="com-plan", **look)
    landed = np.flatnonzero(np.diff(trace.steps) > 0) + 1
    ax.plot(
        *rollout.dcm[landed].T, "o", color="white", markeredgecolor=palette.DCM, markersize=3.6,
        markeredgewidth=1.0, zorder=4.3, gid="dcm-touchdown",
    )  # fmt: skip


def _broken(values: NDArray[np.float64], trace: BodyTrace) -> NDArray[np.float64]:
    """A plan, NaN where there is none and where it jumps at a touchdown."""
    rows = values.astype(float).copy()
    rows[~trace.walking] = np.nan
    rows[1:][np.diff(trace.steps) != 0] = np.nan
    return rows


def _mark_fall(ax: Axes, rollout: Rollout, shown: Extent, cause: str) -> None:
    inset = INSET * metres_per_inch(ax)
    x, y = pair(np.clip(rollout.dcm[-1], np.add(shown.low, inset), np.subtract(shown.high, inset)))
    ax.plot(
        x, y, "X", color=palette.ALARM, markersize=10.0, markeredgecolor="white",
        markeredgewidth=0.8, zorder=5.5, gid="fall",
    )  # fmt: skip
    right = x > 0.5 * (shown.low[0] + shown.high[0])
    above = y < 0.5 * (shown.low[1] + shown.high[1])
    ax.annotate(
        f"fell at {rollout.time[-1]:.2f} s: {cause}",
        (x, y),
        xytext=(8.0 if not right else -8.0, 8.0 if above else -8.0),
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

"""The walk from above: footprints in true size, CoM, DCM, its plan, the ZMP, and what pushed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.dcm.viability import fall_distance
from surefoot.robot.floor import laid_boards
from surefoot.rollout.measures import planned_com
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.footprints import draw_footprints, missed_soles, number_footprints, soles
from surefoot.show.ground import (
    Extent,
    draw_ground,
    draw_push,
    label_pushes,
    metres_per_inch,
    push_arrow,
)
from surefoot.show.palette import DASHES
from surefoot.show.picture_file import HALO
from surefoot.show.stances import (
    Stance,
    acting_pushes,
    broken,
    broken_plan,
    pair,
    sole_reach,
    touchdown_cycles,
)

MARGIN = 0.1
"""Free space around what is drawn [m]."""

SMALLEST = 0.7
"""Extent of the ground that is shown at least, so that soles do not fill the picture [m]."""

NEARBY = 0.45
"""CoM and DCM of a body are shown as far as this from the standing foot: those of a fall run
away [m]."""

INSET = 0.1
"""Of the mark of a body's fall whose place is beyond the picture [in]."""

DOT_SPACING = 0.03
"""Distance of the dots that show the ZMP where it rests [m]."""


def extent(rollout: Rollout, parts: list[Stance]) -> Extent:
    """The ground to show: all feet and pushes, CoM and DCM as far as they matter.

    Of a point mass also ZMP and plan, but for what runs far away.
    """
    body = rollout.body
    shown = soles(rollout, parts) + (missed_soles(rollout, parts) if body is None else [])
    centres = np.array([sole.centre for sole in shown])
    foot = rollout.robot.foot if body is None else body.robot.foot
    reach = sole_reach(foot, np.array([sole.yaw for sole in shown]))
    near = NEARBY if body is not None else fall_distance(rollout.robot)
    dcm, com = (_near(rollout, path, near) for path in (rollout.dcm, rollout.com))
    tails = [push_arrow(rollout, push)[0] for push in acting_pushes(rollout)]
    core = np.array(
        [
            *(centres - reach), *(centres + reach),
            *(com if body is not None else rollout.com), *dcm, *tails,
        ]
    )  # fmt: skip
    low, high = core.min(axis=0), core.max(axis=0)
    if body is None:
        far = np.concatenate([rollout.zmp, rollout.dcm_plan])
        low = np.maximum(np.minimum(low, far.min(axis=0)), low - 0.2)
        high = np.minimum(np.maximum(high, far.max(axis=0)), high + 0.2)
    middle = 0.5 * (low + high)
    half_size = np.maximum(0.5 * (high - low) + MARGIN, 0.5 * SMALLEST)
    return Extent(pair(middle - half_size), pair(middle + half_size))


def _near(rollout: Rollout, path: NDArray[np.float64], far: float) -> NDArray[np.float64]:
    """A path, no further from the support foot than `far` along each axis [m]."""
    return rollout.support_foot + np.clip(path - rollout.support_foot, -far, far)


def draw_top_view(
    ax: Axes, rollout: Rollout, parts: list[Stance], shown: Extent, *, labelled: bool = True
) -> None:
    """Draw the walk from above.

    Args:
        ax: where to draw; its box has the proportions of `shown`.
        rollout: the walk.
        parts: its stances; of a body none are needed.
        shown: the ground to show.
        labelled: whether the words of the pushes stand above it.
    """
    draw_ground(ax, shown)
    if rollout.body is not None:
        _draw_boards(ax, rollout.body, shown)
    draw_footprints(ax, rollout, parts)
    if rollout.body is None:
        number_footprints(ax, rollout, parts)
    for index, push in enumerate(acting_pushes(rollout)):
        draw_push(ax, rollout, push, index)
    for name, points, look in _paths(rollout, parts):
        ax.plot(*points.T, gid=name, **look)
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


def _paths(
    rollout: Rollout, parts: list[Stance]
) -> Iterator[tuple[str, NDArray[np.float64], dict[str, Any]]]:
    """Name, points and look of every line; those of a body, which has more of them, are thinner."""
    plan = {"color": palette.DCM_PLAN, "linestyle": DASHES, "zorder": 4.2}
    com = {"color": palette.COM, "linewidth": 1.3, "zorder": 4.15}
    if rollout.body is not None:
        zmp = {"color": palette.ZMP, "linewidth": 1.0, "alpha": 0.9, "zorder": 3.0}
        yield "zmp", rollout.zmp, zmp
        yield "dcm", rollout.dcm, {"color": palette.DCM, "linewidth": 1.8, "zorder": 4.1}
        yield "com", rollout.com, com
        yield "dcm-plan", broken_plan(rollout, parts), {"linewidth": 1.0, **plan}
        look = {"color": palette.COM_PLAN, "linewidth": 1.0, "linestyle": DASHES, "zorder": 4.25}
        yield "com-plan", planned_com(rollout, rollout.body), look
        return
    yield "zmp", broken(rollout.zmp, parts), {"color": palette.ZMP, "linewidth": 1.2, "zorder": 3.0}
    dots = {"color": palette.ZMP, "marker": ".", "markersize": 4.0, "markeredgewidth": 0}
    yield (
        "zmp-points", rollout.zmp[_spaced(rollout.zmp)],
        {"linestyle": "none", "zorder": 3.1, **dots},
    )  # fmt: skip
    if rollout.zmp_excess.any():
        outside = np.where(rollout.zmp_excess[:, None] > 0.0, rollout.zmp, np.nan)
        look = {"color": palette.ALARM, "linewidth": 2.6, "solid_capstyle": "round", "zorder": 3.2}
        yield "zmp-outside", broken(outside, parts), look
    yield "com", rollout.com, com
    yield "dcm", rollout.dcm, {"color": palette.DCM, "linewidth": 2.0, "zorder": 4.1}
    yield "dcm-plan", broken_plan(rollout, parts), {"linewidth": 1.1, **plan}


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
        words, inset, offset = f"{words}: {fall.cause.value}", INSET * metres_per_inch(ax), 8.0
    x, y = pair(np.clip(dcm, np.add(shown.low, inset), np.subtract(shown.high, inset)))
    ax.plot(
        *(dcm if fall is None else (x, y)), "X", color=palette.ALARM, markersize=10.0,
        markeredgecolor="white", markeredgewidth=0.8, zorder=5.5, gid="fall",
    )  # fmt: skip
    right = x > 0.5 * (shown.low[0] + shown.high[0])
    above = y < 0.5 * (shown.low[1] + shown.high[1])
    ax.annotate(
        words,
        (x, y),
        xytext=(-offset if right else offset, 8.0 if above else -8.0),
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

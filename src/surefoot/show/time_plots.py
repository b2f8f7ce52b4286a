"""The walk over time: x and y with the soles that bound the ZMP, DCM error, step duration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.dcm.viability import fall_distance
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.halo import HALO
from surefoot.show.palette import DASHES, DOTS
from surefoot.show.stances import Stance, broken, sole_reach, support_bounds, zmp_outside
from surefoot.show.walk_events import mark_events, name_fall, name_velocities

HEIGHTS = (2.0, 2.0, 1.0, 1.0)
"""Of the four plots [in]."""

NAMES = ("x", "y", "error", "duration")
"""Of the four plots; what is drawn in each of them carries its name, as in "com-x"."""


def draw_time_plots(axes: Sequence[Axes], rollout: Rollout, parts: list[Stance]) -> None:
    """Draw x, y, DCM error and step duration over time, one below the other.

    Args:
        axes: four axes of the same width.
        rollout: the walk.
        parts: its stances.
    """
    for index, (ax, name) in enumerate(zip(axes, NAMES, strict=True)):
        ax.set_gid(name)
        ax.set_xlim(rollout.time[0], max(rollout.time[-1], rollout.time[0] + 1e-3))
        ax.grid(axis="y", color="#e8e8e8", linewidth=0.5, zorder=0)
        ax.set_axisbelow(True)
        ax.tick_params(labelbottom=index == len(axes) - 1)
        mark_events(ax, rollout, parts)
    axes[-1].set_xlabel("time [s]")
    for index, name in enumerate(NAMES[:2]):
        _draw_position(axes[index], rollout, parts, index)
        axes[index].set_ylabel(f"{name} [m]")
    _draw_error(axes[2], rollout, parts)
    _draw_duration(axes[3], rollout, parts)
    _number_steps(axes[0], parts)
    for ax in axes:
        ax.yaxis.set_label_coords(-0.55 / _width(ax), 0.5)


def _width(ax: Axes) -> float:
    """Of the axes [in]."""
    return ax.get_position().width * ax.figure.get_figure(root=True).get_size_inches()[0]


def _seconds_per_inch(ax: Axes) -> float:
    low, high = ax.get_xlim()
    return (high - low) / _width(ax)


def _draw_position(ax: Axes, rollout: Rollout, parts: list[Stance], axis: int) -> None:
    _draw_support(ax, rollout, parts, axis)
    outside = np.where(zmp_outside(rollout), rollout.zmp, np.nan)
    curves: list[tuple[str, NDArray[np.float64], dict[str, Any]]] = [
        ("zmp", rollout.zmp, {"color": palette.ZMP, "linewidth": 1.3, "zorder": 2.5}),
        ("com", rollout.com, {"color": palette.COM, "linewidth": 1.3, "zorder": 3.0}),
        ("dcm", rollout.dcm, {"color": palette.DCM, "linewidth": 1.9, "zorder": 3.1}),
        (
            "dcm-plan",
            rollout.dcm_plan,
            {"color": palette.DCM_PLAN, "linewidth": 1.1, "zorder": 3.2, "linestyle": DASHES},
        ),
    ]
    if not np.isnan(outside).all():
        look = {"color": palette.ALARM, "linewidth": 2.4, "zorder": 2.6}
        curves.append(("zmp-outside", outside, look))
    for name, points, look in curves:
        # CoM and DCM go on smoothly at a touchdown, ZMP and plan may jump.
        smooth = name in ("com", "dcm")
        time, values = rollout.time, points[:, axis]
        if not smooth:
            time, values = broken(time, parts), broken(values, parts)
        ax.plot(time, values, gid=f"{name}-{NAMES[axis]}", **look)
    ax.set_ylim(*_range(rollout, axis))


def _draw_support(ax: Axes, rollout: Rollout, parts: list[Stance], axis: int) -> None:
    """Fill what bounds the ZMP: the sole on the ground, and in double support all between both."""
    name = NAMES[axis]
    for part in parts:
        half = sole_reach(rollout.robot.foot, part.yaw)[axis]
        ax.add_patch(
            Rectangle(
                (part.start, part.support_foot[axis] - half),
                part.end - part.start,
                2.0 * half,
                facecolor=palette.SOLE[part.side],
                edgecolor=palette.SOLE_EDGE[part.side],
                linewidth=0.5,
                zorder=1.0,
                gid=f"support-{name}-{part.number}",
            )
        )
    shared = rollout.commands["double_support"] != 0
    if shared.any():
        low, high = support_bounds(rollout)
        ax.fill_between(
            rollout.time,
            low[:, axis],
            high[:, axis],
            where=shared,
            facecolor=palette.BOTH_SOLES,
            linewidth=0.0,
            zorder=0.9,
            gid=f"both-soles-{name}",
        )


def _range(rollout: Rollout, axis: int) -> tuple[float, float]:
    """All of CoM, DCM and soles, and of ZMP and plan what does not run far away [m]."""
    foot = rollout.support_foot[:, axis]
    far = fall_distance(rollout.robot)
    near = foot + np.clip(rollout.dcm[:, axis] - foot, -far, far)
    core = np.concatenate(
        [*(edge[:, axis] for edge in support_bounds(rollout)), rollout.com[:, axis], near]
    )
    low, high = core.min(), core.max()
    reach = 0.4 * (high - low)
    far = np.concatenate([rollout.zmp[:, axis], rollout.dcm_plan[:, axis]])
    low, high = max(min(low, far.min()), low - reach), min(max(high, far.max()), high + reach)
    margin = 0.05 * (high - low)
    return float(low - margin), float(high + margin)


def _draw_error(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    time = broken(rollout.time, parts)
    error = 1e3 * broken(np.hypot(*rollout.dcm_error.T), parts)
    settled = 1e3 * rollout.settled_error
    ax.axhline(settled, color=palette.QUIET, linewidth=0.8, linestyle=DOTS, gid="settled")
    ax.fill_between(time, error, color=palette.DCM, alpha=0.2, linewidth=0.0, zorder=2.0)
    ax.plot(time, error, color=palette.DCM, linewidth=1.3, zorder=3.0, gid="dcm-error")
    largest = min(float(np.nanmax(error)), 1e3 * fall_distance(rollout.robot))
    ax.set_ylim(0.0, 1.15 * max(1.5 * settled, largest))
    ax.set_ylabel("DCM error\n[mm]")


def _draw_duration(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    shortest, longest = rollout.robot.gait.step_duration
    time = broken(rollout.time, parts)
    decided = rollout.commands["step_duration"]
    for limit in (shortest, longest):
        ax.axhline(
            limit, color=palette.QUIET, linewidth=0.8, linestyle=DOTS, gid=f"limit-{limit:g}"
        )
    ax.plot(
        time,
        broken(decided, parts),
        color=palette.COM,
        linewidth=1.3,
        zorder=3.0,
        drawstyle="steps-post",
        gid="step-duration",
    )
    for part in parts:
        planned = part.planned_duration
        if planned is None and part.gait is not None:
            planned = part.gait.step_duration
        if planned is not None:
            ax.hlines(
                planned,
                part.start,
                part.end,
                color=palette.DCM_PLAN,
                linewidth=1.1,
                linestyle=DASHES,
                zorder=3.2,
                gid=f"planned-duration-{part.number}",
            )
    _write_adapted_durations(ax, parts)
    name_velocities(ax, rollout)
    name_fall(ax, rollout)
    ax.set_ylim(0.0, 1.3 * longest)
    ticks = _duration_ticks(rollout, parts)
    ax.set_yticks(ticks, [f"{tick:.2g}" for tick in ticks])
    ax.set_ylabel("step\nduration [s]")


def _duration_ticks(rollout: Rollout, parts: list[Stance]) -> list[float]:
    """The limits, and the first planned duration between them if its number has room [s]."""
    shortest, longest = rollout.robot.gait.step_duration
    room = 0.2 * longest
    planned = parts[0].planned_duration or shortest
    middle = [planned] if shortest + room < planned < longest - room else []
    return [shortest, *middle, longest]


def _write_adapted_durations(ax: Axes, parts: list[Stance]) -> None:
    """The durations of the steps that were decided online, where there is room."""
    apart = 0.45 * _seconds_per_inch(ax)
    last = -np.inf
    for part in parts:
        middle = 0.5 * (part.start + part.end)
        if not part.adapted or part.landing is None or middle - last < apart:
            continue
        last = middle
        ax.annotate(
            f"{part.end - part.start:.2f} s",
            (middle, 0.0),
            xytext=(0.0, 3.0),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize=8.0,
            fontweight="bold",
            color=palette.ADAPTED,
            path_effects=HALO,
            zorder=5.0,
            gid=f"duration-{part.number}",
        )


def _number_steps(ax: Axes, parts: list[Stance]) -> None:
    """Write the number of every step above its time; of a crowd, the adapted ones first."""
    apart = 0.22 * _seconds_per_inch(ax)
    taken: list[float] = []
    for part in sorted(parts, key=lambda part: not part.adapted):
        middle = 0.5 * (part.start + part.end)
        if any(abs(middle - other) < apart for other in taken):
            continue
        taken.append(middle)
        ax.text(
            middle,
            1.02,
            str(part.number),
            transform=ax.get_xaxis_transform(),
            ha="center",
            va="bottom",
            fontsize=8.5 if part.adapted else 7.5,
            fontweight="bold" if part.adapted else "normal",
            color=palette.ADAPTED if part.adapted else palette.QUIET,
            gid=f"step-{part.number}",
        )
    ax.annotate(
        "step",
        (0.0, 1.02),
        xycoords="axes fraction",
        xytext=(-26.0, 0.0),
        textcoords="offset points",
        ha="right",
        va="bottom",
        fontsize=7.5,
        color=palette.QUIET,
    )

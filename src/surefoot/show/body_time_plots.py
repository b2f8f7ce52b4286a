"""A walk in physics over time: x, y, heights of the feet, knees, and the motors of each leg."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from surefoot.robot.feet import FEET, Side
from surefoot.rollout.measures import planned_com
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.halo import HALO
from surefoot.show.palette import DASHES, DOTS
from surefoot.show.stances import acting_pushes, push_opacity, sole_reach

NAMES = ("x", "y", "feet", "knees", "left motors", "right motors")
"""Of the plots, from the top; what is drawn in each of them carries its name."""

HEIGHTS = (1.5, 1.8, 1.1, 0.9, 1.45, 1.45)
"""Of the plots [in]."""

MOTOR_COLOURS = ("#9a9a9a", "#e69f00", "#0072b2", "#009e73", "#d55e00", "#cc79a7")
"""From hip to ankle."""

FOOT_COLOUR = (palette.SOLE_EDGE[Side.LEFT], palette.SOLE_EDGE[Side.RIGHT])

MOST_LINES = 6
"""Motors of one plot, the busiest ones."""


def draw_body_time_plots(axes: Sequence[Axes], rollout: Rollout, trace: BodyTrace) -> None:
    """Draw the plots over time, one below the other.

    Args:
        axes: as many as `NAMES`, of the same width.
        rollout: the walk.
        trace: its `body`.
    """
    end = max(float(rollout.time[-1]), float(rollout.time[0]) + 1e-3)
    for index, (ax, name) in enumerate(zip(axes, NAMES, strict=True)):
        ax.set_gid(name)
        ax.set_xlim(float(rollout.time[0]), end)
        ax.grid(axis="y", color="#e8e8e8", linewidth=0.5, zorder=0)
        ax.set_axisbelow(True)
        ax.tick_params(labelbottom=index == len(axes) - 1)
        _mark_events(ax, rollout, trace)
    axes[-1].set_xlabel("time [s]")
    for axis in (0, 1):
        _draw_position(axes[axis], rollout, trace, axis)
    _draw_feet(axes[2], rollout, trace)
    _draw_knees(axes[3], rollout, trace)
    for side, ax in enumerate(axes[4:]):
        _draw_motors(ax, rollout, trace, side)
    _name_events(axes[0], rollout, trace)
    for ax in axes:
        ax.yaxis.set_label_coords(-0.055, 0.5)


def _mark_events(ax: Axes, rollout: Rollout, trace: BodyTrace) -> None:
    across = ax.get_xaxis_transform()
    for index, push in enumerate(acting_pushes(rollout)):
        ax.axvspan(
            push.start, min(push.end, float(rollout.time[-1])), facecolor=palette.PUSH,
            edgecolor="none", alpha=push_opacity(rollout, push), zorder=1.5,
            gid=f"push-{ax.get_gid()}-{index}",
        )  # fmt: skip
    landed = rollout.time[np.flatnonzero(np.diff(trace.steps) > 0) + 1]
    ax.vlines(landed, 0.0, 1.0, transform=across, color="#b5b5b5", linewidth=0.5, zorder=1.6)
    changes = [command[0] for command in trace.steering[1:]]
    ax.vlines(
        changes, 0.0, 1.0, transform=across, color=palette.COM, linewidth=0.9,
        linestyle=(0, (6, 2, 1, 2)), zorder=1.7,
    )  # fmt: skip
    fall = rollout.body_fall
    if fall is not None:
        look: dict[str, Any] = {"color": palette.ALARM, "linewidth": 1.2, "zorder": 4.5}
        ax.vlines(fall.time, 0.0, 1.0, transform=across, linestyle=(0, (4, 2)), **look)
        ax.vlines(fall.end, 0.0, 1.0, transform=across, clip_on=False, **look)


def _name_events(ax: Axes, rollout: Rollout, trace: BodyTrace) -> None:
    words = [
        (time, _command_words(velocity, turning, standing), palette.COM)
        for time, velocity, turning, standing in trace.steering[1:]
    ]
    fall = rollout.body_fall
    if fall is not None:
        words.append((fall.time, fall.cause.value, palette.ALARM))
    for time, text, colour in words:
        late = time > 0.8 * float(rollout.time[-1])
        ax.annotate(
            text, (time, 0.95), xycoords=("data", "axes fraction"),
            xytext=(-3.0 if late else 3.0, 0.0), textcoords="offset points",
            ha="right" if late else "left", va="top", fontsize=8.0, fontweight="bold",
            color=colour, path_effects=HALO, zorder=5.0,
        )  # fmt: skip


def _command_words(velocity: tuple[float, float], turning: float, standing: bool) -> str:
    if standing:
        return "stand"
    words = f"{velocity[0]:g}, {velocity[1]:g} m/s"
    return words + (f", {turning:+g} rad/s" if turning else "")


def _draw_position(ax: Axes, rollout: Rollout, trace: BodyTrace, axis: int) -> None:
    time, name = rollout.time, NAMES[axis]
    for foot in (0, 1):
        carries = (~trace.walking) | (trace.support == foot)
        centre, yaw = trace.sole_position[:, foot, axis], trace.sole_turn[:, foot, 2]
        reach = sole_reach(trace.robot.foot, yaw)[:, axis]
        whose = Side(2 * foot - 1)
        ax.fill_between(
            time, centre - reach, centre + reach, where=carries, facecolor=palette.SOLE[whose],
            edgecolor=palette.SOLE_EDGE[whose], linewidth=0.4, zorder=1.0,
            gid=f"sole-{name}-{foot}",
        )  # fmt: skip
    plan = np.where(trace.walking[:, None], rollout.dcm_plan, np.nan)
    plan[1:][np.diff(trace.steps) != 0] = np.nan
    told = rollout.commands["zmp"]
    curves: list[tuple[str, NDArray[np.float64], dict[str, Any]]] = [
        ("zmp", rollout.zmp, {"color": palette.ZMP, "linewidth": 0.9, "zorder": 2.4}),
        ("zmp-plan", told, {"color": palette.ZMP_PLAN, "linewidth": 0.9, "linestyle": DASHES}),
        ("dcm", rollout.dcm, {"color": palette.DCM, "linewidth": 1.7, "zorder": 3.0}),
        ("com", rollout.com, {"color": palette.COM, "linewidth": 1.2, "zorder": 3.1}),
        ("dcm-plan", plan, {"color": palette.DCM_PLAN, "linewidth": 1.0, "linestyle": DASHES}),
        (
            "com-plan",
            planned_com(rollout, trace),
            {"color": palette.COM_PLAN, "linewidth": 1.0, "linestyle": DASHES},
        ),
    ]
    for gid, points, look in curves:
        ax.plot(time, points[:, axis], gid=f"{gid}-{name}", **{"zorder": 3.2, **look})
    soles = trace.sole_position[:, :, axis]
    half = trace.robot.foot.half[axis]
    core = np.concatenate([soles.ravel() - half, soles.ravel() + half, rollout.com[:, axis]])
    near = np.clip(rollout.dcm[:, axis], core.min() - 0.3, core.max() + 0.3)
    low, high = min(core.min(), near.min()), max(core.max(), near.max())
    ax.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
    ax.set_ylabel(f"{name} [m]")


def _draw_feet(ax: Axes, rollout: Rollout, trace: BodyTrace) -> None:
    """Lowest corner of each sole, and the height that its middle is to have."""
    for foot, side in enumerate(FEET):
        height = 1e3 * trace.clearance[:, foot]
        swings = trace.walking & (trace.support != foot)
        plan = np.where(swings, 1e3 * trace.swing_plan[:, 2], np.nan)
        ax.plot(
            rollout.time, height, color=FOOT_COLOUR[foot], linewidth=1.3, zorder=3.0,
            gid=f"height-{side}", label=f"{side}, lowest corner",
        )  # fmt: skip
        ax.plot(
            rollout.time, plan, color=palette.COM, linewidth=0.7, linestyle=DASHES, zorder=3.1,
            gid=f"height-plan-{side}", label="planned" if foot == 0 else None,
        )  # fmt: skip
    top = max(float(np.nanpercentile(1e3 * trace.clearance, 99.5)), 40.0)
    ax.set_ylim(-8.0, 1.25 * top)
    ax.axhline(0.0, color=palette.QUIET, linewidth=0.8, zorder=2.0)
    ax.set_ylabel("feet\n[mm]")
    _legend(ax)


def _draw_knees(ax: Axes, rollout: Rollout, trace: BodyTrace) -> None:
    bends = np.degrees(np.abs(trace.joint_angles[:, list(trace.knees)]))
    for foot, side in enumerate(FEET):
        ax.plot(
            rollout.time, bends[:, foot], color=FOOT_COLOUR[foot], linewidth=1.3, zorder=3.0,
            gid=f"knee-{side}", label=side,
        )  # fmt: skip
    ax.set_ylim(0.0, 1.15 * float(bends.max()))
    ax.axhline(0.0, color=palette.ALARM, linewidth=1.6, zorder=2.0)
    ax.annotate(
        "straight", (1.0, 0.0), xycoords="axes fraction", xytext=(-3.0, 3.0),
        textcoords="offset points", ha="right", va="bottom", fontsize=7.5, color=palette.ALARM,
        path_effects=HALO,
    )  # fmt: skip
    ax.set_ylabel("knees\n[°]")
    _legend(ax)


def motors_of(trace: BodyTrace, side: str) -> list[int]:
    """The motors of a side, the busiest if they are many, in the order of the model.

    A motor is of a side if its name says so; names of other kinds are shared by both.
    """
    other = FEET[1 - FEET.index(side)]
    mine = [i for i, name in enumerate(trace.joints) if other not in name.lower()]
    busiest = sorted(mine, key=lambda i: -float(trace.torque_part[:, i].max()))[:MOST_LINES]
    return sorted(busiest)


def _draw_motors(ax: Axes, rollout: Rollout, trace: BodyTrace, side: int) -> None:
    """Torques as parts of their limits."""
    motors = motors_of(trace, FEET[side])
    for colour, motor in zip(MOTOR_COLOURS, motors, strict=False):
        limit = float(trace.torque_limit[motor])
        part = 100.0 * trace.torque[:, motor] / limit
        name = trace.joints[motor].replace(f"{FEET[side]}_", "").replace("_", " ")
        ax.plot(
            rollout.time, part, color=colour, linewidth=1.0, zorder=3.0,
            gid=f"torque-{trace.joints[motor]}", label=f"{name}, ±{limit:.0f} N m",
        )  # fmt: skip
    for limit in (-100.0, 100.0):
        ax.axhline(limit, color=palette.ALARM, linewidth=0.9, linestyle=DOTS, zorder=2.0)
    ax.set_ylim(-112.0, 112.0)
    ax.set_yticks([-100.0, 0.0, 100.0])
    ax.set_ylabel(f"{FEET[side]} motors\n[% of limit]")
    _legend(ax)


def _legend(ax: Axes) -> None:
    """To the right of the plot, where it covers nothing."""
    handles, labels = ax.get_legend_handles_labels()
    kept = [(h, name) for h, name in zip(handles, labels, strict=True) if isinstance(h, Line2D)]
    ax.legend(
        *zip(*kept, strict=True), loc="upper left", bbox_to_anchor=(1.005, 1.04), frameon=False,
        fontsize=7.5, handlelength=1.4, labelspacing=0.25, borderaxespad=0.0,
    )  # fmt: skip

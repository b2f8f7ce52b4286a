"""The feet, the knees and the motors of a body over time."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from surefoot.robot.feet import FEET, Side
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.palette import DASHES, DOTS
from surefoot.show.picture_file import HALO

MOTOR_COLOURS = ("#9a9a9a", "#e69f00", "#0072b2", "#009e73", "#d55e00", "#cc79a7")
"""From hip to ankle."""

FOOT_COLOUR = (palette.SOLE_EDGE[Side.LEFT], palette.SOLE_EDGE[Side.RIGHT])

MAX_MOTORS = len(MOTOR_COLOURS)
"""Motors in one plot; of more, those with the largest torques for their limits are drawn."""


def draw_feet(ax: Axes, rollout: Rollout, trace: BodyTrace) -> None:
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


def draw_knees(ax: Axes, rollout: Rollout, trace: BodyTrace) -> None:
    """How far the knees bend; a straight one cannot push on."""
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
    busiest = sorted(mine, key=lambda i: -float(trace.torque_part[:, i].max()))[:MAX_MOTORS]
    return sorted(busiest)


def draw_motors(ax: Axes, rollout: Rollout, trace: BodyTrace, side: str) -> None:
    """Torques of the motors of a side, "left" or "right", as parts of their limits."""
    motors = motors_of(trace, side)
    for colour, motor in zip(MOTOR_COLOURS, motors, strict=False):
        limit = float(trace.torque_limit[motor])
        part = 100.0 * trace.torque[:, motor] / limit
        name = trace.joints[motor].replace(f"{side}_", "").replace("_", " ")
        ax.plot(
            rollout.time, part, color=colour, linewidth=1.0, zorder=3.0,
            gid=f"torque-{trace.joints[motor]}", label=f"{name}, ±{limit:.0f} N m",
        )  # fmt: skip
    for limit in (-100.0, 100.0):
        ax.axhline(limit, color=palette.ALARM, linewidth=0.9, linestyle=DOTS, zorder=2.0)
    ax.set_ylim(-112.0, 112.0)
    ax.set_yticks([-100.0, 0.0, 100.0])
    ax.set_ylabel(f"{side} motors\n[% of limit]")
    _legend(ax)


def _legend(ax: Axes) -> None:
    """To the right of the plot, where it covers nothing."""
    handles, labels = ax.get_legend_handles_labels()
    kept = [(h, name) for h, name in zip(handles, labels, strict=True) if isinstance(h, Line2D)]
    ax.legend(
        *zip(*kept, strict=True), loc="upper left", bbox_to_anchor=(1.005, 1.04), frameon=False,
        fontsize=7.5, handlelength=1.4, labelspacing=0.25, borderaxespad=0.0,
    )  # fmt: skip

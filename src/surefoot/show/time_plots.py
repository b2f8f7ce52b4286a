"""The walk over time: x and y with the soles that bound the ZMP, and what else there is to see.

Of a point mass that is the DCM error and the step duration; of a body its feet, knees and motors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from surefoot.dcm.viability import fall_distance
from surefoot.robot.feet import FEET, Side
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.page import units_per_inch, width_of
from surefoot.show.palette import DASHES, DOTS
from surefoot.show.picture_file import HALO
from surefoot.show.plotted_walk import PlottedWalk, sole_reach, support_bounds, zmp_outside
from surefoot.show.stances import Stance, broken
from surefoot.show.walk_events import mark_events, name_events

MOTOR_COLOURS = ("#9a9a9a", "#e69f00", "#0072b2", "#009e73", "#d55e00", "#cc79a7")
"""From hip to ankle."""

FOOT_COLOUR = (palette.SOLE_EDGE[Side.LEFT], palette.SOLE_EDGE[Side.RIGHT])

MAX_MOTORS = len(MOTOR_COLOURS)
"""Motors in one plot; of more, those with the largest torques for their limits are drawn."""


class Panel(NamedTuple):
    """One plot over time.

    Attributes:
        name: its own, and part of the names of what is drawn in it, as in "com-x".
        height: of the plot [in].
        draw: called with the plot and the walk.
    """

    name: str
    height: float
    draw: Callable[[Axes, PlottedWalk], None]


def panels(rollout: Rollout) -> tuple[Panel, ...]:
    """The plots of a walk, from the top."""
    return POINT_PANELS if rollout.body is None else BODY_PANELS


def draw_time_plots(
    axes: Sequence[Axes], walk: PlottedWalk, shown: Sequence[Panel] | None = None
) -> None:
    """Draw the plots over time, one below the other.

    Args:
        axes: one for each plot, of the same width.
        walk: what to draw.
        shown: what is plotted; all `panels` of the walk if None.
    """
    rollout = walk.rollout
    start = float(rollout.time[0])
    for index, (ax, panel) in enumerate(zip(axes, shown or panels(rollout), strict=True)):
        ax.set_gid(panel.name)
        ax.set_xlim(start, max(float(rollout.time[-1]), start + 1e-3))
        ax.grid(axis="y", color=palette.GRID, linewidth=0.5, zorder=0)
        ax.set_axisbelow(True)
        ax.tick_params(labelbottom=index == len(axes) - 1)
        mark_events(ax, walk)
        panel.draw(ax, walk)
        ax.yaxis.set_label_coords(-0.55 / width_of(ax) if rollout.body is None else -0.055, 0.5)
    axes[-1].set_xlabel("time [s]")
    if rollout.body is None:
        _number_steps(axes[0], walk.parts)
    else:
        name_events(axes[0], rollout)


def _draw_position(ax: Axes, walk: PlottedWalk) -> None:
    """One coordinate of everything on the ground; the name of the plot says which one."""
    rollout, name = walk.rollout, str(ax.get_gid())
    axis = "xy".index(name)
    if rollout.body is None:
        _draw_support(ax, walk, axis)
    else:
        _draw_soles(ax, rollout, rollout.body, axis)
    for curve in walk.curves:
        values = curve.points[:, axis]
        if curve.name == "zmp-outside":
            # Only the coordinate that is outside.
            outside = zmp_outside(rollout)[:, axis]
            values = broken(np.where(outside, rollout.zmp[:, axis], np.nan), walk.parts)
        ax.plot(curve.time, values, gid=f"{curve.name}-{name}", **curve.look)
    carried = [sole for sole in walk.soles if sole.samples.stop > 0]
    low, high = (float(edge[axis]) for edge in walk.extent(carried, rollout.com))
    margin = 0.05 * (high - low)
    ax.set_ylim(low - margin, high + margin)
    ax.set_ylabel(f"{name} [m]")


def _draw_soles(ax: Axes, rollout: Rollout, trace: BodyTrace, axis: int) -> None:
    """Fill the soles that carry a body, which may slide."""
    for foot, side in enumerate((Side.LEFT, Side.RIGHT)):
        centre, yaw = trace.sole_position[:, foot, axis], trace.sole_turn[:, foot, 2]
        reach = sole_reach(trace.robot.foot, yaw)[:, axis]
        ax.fill_between(
            rollout.time, centre - reach, centre + reach,
            where=~trace.walking | (trace.support == foot), facecolor=palette.SOLE[side],
            edgecolor=palette.SOLE_EDGE[side], linewidth=0.4, zorder=1.0,
            gid=f"sole-{ax.get_gid()}-{foot}",
        )  # fmt: skip


def _draw_support(ax: Axes, walk: PlottedWalk, axis: int) -> None:
    """Fill what bounds the ZMP: the sole on the ground, and in double support all between both."""
    rollout, name = walk.rollout, ax.get_gid()
    for part in walk.parts:
        half = sole_reach(rollout.robot.foot, part.yaw)[axis]
        ax.add_patch(
            Rectangle(
                (part.start, part.support_foot[axis] - half), part.end - part.start, 2.0 * half,
                facecolor=palette.SOLE[part.side], edgecolor=palette.SOLE_EDGE[part.side],
                linewidth=0.5, zorder=1.0, gid=f"support-{name}-{part.number}",
            )
        )  # fmt: skip
    shared = rollout.commands["double_support"] != 0
    if shared.any():
        low, high = support_bounds(rollout)
        ax.fill_between(
            rollout.time, low[:, axis], high[:, axis], where=shared,
            facecolor=palette.BOTH_SOLES, linewidth=0.0, zorder=0.9, gid=f"both-soles-{name}",
        )  # fmt: skip


def _draw_error(ax: Axes, walk: PlottedWalk) -> None:
    rollout, parts = walk.rollout, walk.parts
    time = broken(rollout.time, parts)
    error = 1e3 * broken(np.hypot(*rollout.dcm_error.T), parts)
    settled = 1e3 * rollout.settled_error
    ax.axhline(settled, color=palette.QUIET, linewidth=0.8, linestyle=DOTS, gid="settled")
    ax.fill_between(time, error, color=palette.DCM, alpha=0.2, linewidth=0.0, zorder=2.0)
    ax.plot(time, error, color=palette.DCM, linewidth=1.3, zorder=3.0, gid="dcm-error")
    largest = min(float(np.nanmax(error)), 1e3 * fall_distance(rollout.robot))
    ax.set_ylim(0.0, 1.15 * max(1.5 * settled, largest))
    ax.set_ylabel("DCM error\n[mm]")


def _draw_duration(ax: Axes, walk: PlottedWalk) -> None:
    rollout, parts = walk.rollout, walk.parts
    shortest, longest = rollout.robot.gait.step_duration
    time = broken(rollout.time, parts)
    decided = rollout.commands["step_duration"]
    for limit in (shortest, longest):
        ax.axhline(
            limit, color=palette.QUIET, linewidth=0.8, linestyle=DOTS, gid=f"limit-{limit:g}"
        )
    ax.plot(
        time, broken(decided, parts), color=palette.COM, linewidth=1.3, zorder=3.0,
        drawstyle="steps-post", gid="step-duration",
    )  # fmt: skip
    for part in parts:
        planned = part.planned_duration
        if planned is None and part.gait is not None:
            planned = part.gait.step_duration
        if planned is not None:
            ax.hlines(
                planned, part.start, part.end, color=palette.DCM_PLAN, linewidth=1.1,
                linestyle=DASHES, zorder=3.2, gid=f"planned-duration-{part.number}",
            )  # fmt: skip
    _write_adapted_durations(ax, parts)
    name_events(ax, rollout)
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
    spacing = 0.45 * units_per_inch(ax)
    last = -np.inf
    for part in parts:
        middle = 0.5 * (part.start + part.end)
        if not part.adapted or part.landing is None or middle - last < spacing:
            continue
        last = middle
        ax.annotate(
            f"{part.end - part.start:.2f} s", (middle, 0.0), xytext=(0.0, 3.0),
            textcoords="offset points", ha="center", va="bottom", fontsize=8.0, fontweight="bold",
            color=palette.ADAPTED, path_effects=HALO, zorder=5.0, gid=f"duration-{part.number}",
        )  # fmt: skip


def _number_steps(ax: Axes, parts: list[Stance]) -> None:
    """Write the number of every step above its time; of a crowd, the adapted ones first."""
    spacing = 0.22 * units_per_inch(ax)
    taken: list[float] = []
    for part in sorted(parts, key=lambda part: not part.adapted):
        middle = 0.5 * (part.start + part.end)
        if any(abs(middle - other) < spacing for other in taken):
            continue
        taken.append(middle)
        ax.text(
            middle, 1.02, str(part.number), transform=ax.get_xaxis_transform(), ha="center",
            va="bottom", **palette.step_number(part.adapted), gid=f"step-{part.number}",
        )  # fmt: skip
    ax.annotate(
        "step", (0.0, 1.02), xycoords="axes fraction", xytext=(-26.0, 0.0),
        textcoords="offset points", ha="right", va="bottom", fontsize=7.5, color=palette.QUIET,
    )  # fmt: skip


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


def _draw_motors(ax: Axes, rollout: Rollout, trace: BodyTrace, side: str) -> None:
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


def _of_body(draw: Callable[..., None], *more: Any) -> Callable[[Axes, PlottedWalk], None]:
    """A plot of a body as that of a `Panel`."""
    return lambda ax, walk: draw(ax, walk.rollout, walk.rollout.body, *more)


POINT_PANELS = (
    Panel("x", 2.0, _draw_position),
    Panel("y", 2.0, _draw_position),
    Panel("error", 1.0, _draw_error),
    Panel("duration", 1.0, _draw_duration),
)
BODY_PANELS = (
    Panel("x", 1.5, _draw_position),
    Panel("y", 1.8, _draw_position),
    Panel("feet", 1.1, _of_body(_draw_feet)),
    Panel("knees", 0.9, _of_body(_draw_knees)),
    Panel("left motors", 1.45, _of_body(_draw_motors, "left")),
    Panel("right motors", 1.45, _of_body(_draw_motors, "right")),
)

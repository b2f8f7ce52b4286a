"""The walk over time: x and y with the soles that bound the ZMP, and what else there is to see.

Of a point mass that is the DCM error and the step duration; of a body its feet, knees and motors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.dcm.viability import fall_distance
from surefoot.robot.feet import Side
from surefoot.rollout.measures import planned_com
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.joint_plots import draw_feet, draw_knees, draw_motors
from surefoot.show.palette import DASHES, DOTS
from surefoot.show.picture_file import HALO
from surefoot.show.stances import (
    Stance,
    broken,
    broken_plan,
    sole_reach,
    support_bounds,
    zmp_outside,
)
from surefoot.show.walk_events import mark_events, name_events


class Panel(NamedTuple):
    """One plot over time.

    Attributes:
        name: its own, and part of the names of what is drawn in it, as in "com-x".
        height: of the plot [in].
        draw: called with the plot, the walk and its stances.
    """

    name: str
    height: float
    draw: Callable[[Axes, Rollout, list[Stance]], None]


def panels(rollout: Rollout) -> tuple[Panel, ...]:
    """The plots of a walk, from the top."""
    return POINT_PANELS if rollout.body is None else BODY_PANELS


def draw_time_plots(
    axes: Sequence[Axes],
    rollout: Rollout,
    parts: list[Stance],
    shown: Sequence[Panel] | None = None,
) -> None:
    """Draw the plots over time, one below the other.

    Args:
        axes: one for each plot, of the same width.
        rollout: the walk.
        parts: its stances; of a body none are needed.
        shown: what is plotted; all `panels` of the walk if None.
    """
    start = float(rollout.time[0])
    for index, (ax, panel) in enumerate(zip(axes, shown or panels(rollout), strict=True)):
        ax.set_gid(panel.name)
        ax.set_xlim(start, max(float(rollout.time[-1]), start + 1e-3))
        ax.grid(axis="y", color="#e8e8e8", linewidth=0.5, zorder=0)
        ax.set_axisbelow(True)
        ax.tick_params(labelbottom=index == len(axes) - 1)
        mark_events(ax, rollout, parts)
        panel.draw(ax, rollout, parts)
        ax.yaxis.set_label_coords(-0.55 / _width(ax) if rollout.body is None else -0.055, 0.5)
    axes[-1].set_xlabel("time [s]")
    if rollout.body is None:
        _number_steps(axes[0], parts)
    else:
        name_events(axes[0], rollout)


def _width(ax: Axes) -> float:
    """Of the axes [in]."""
    return ax.get_position().width * ax.figure.get_figure(root=True).get_size_inches()[0]


def _seconds_per_inch(ax: Axes) -> float:
    low, high = ax.get_xlim()
    return (high - low) / _width(ax)


Curve = tuple[str, NDArray[np.float64], NDArray[np.float64], dict[str, Any]]
"""Name, instants, points (x, y) and look of a line."""


def _draw_position(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """One coordinate of everything on the ground; the name of the plot says which one."""
    axis = "xy".index(str(ax.get_gid()))
    body = rollout.body
    if body is None:
        _draw_support(ax, rollout, parts, axis)
        curves, span = _point_curves(rollout, parts), _range(rollout, axis)
    else:
        _draw_soles(ax, rollout, body, axis)
        curves, span = _body_curves(rollout, parts, body), _body_range(rollout, body, axis)
    for name, time, points, look in curves:
        ax.plot(time, points[:, axis], gid=f"{name}-{ax.get_gid()}", **look)
    ax.set_ylim(*span)
    ax.set_ylabel(f"{ax.get_gid()} [m]")


def _point_curves(rollout: Rollout, parts: list[Stance]) -> Iterator[Curve]:
    """CoM and DCM go on smoothly at a touchdown, ZMP and plan may jump."""
    time, cut = rollout.time, broken(rollout.time, parts)
    zmp, outside = rollout.zmp, np.where(zmp_outside(rollout), rollout.zmp, np.nan)
    plan = {"color": palette.DCM_PLAN, "linewidth": 1.1, "zorder": 3.2, "linestyle": DASHES}
    yield "zmp", cut, broken(zmp, parts), {"color": palette.ZMP, "linewidth": 1.3, "zorder": 2.5}
    yield "com", time, rollout.com, {"color": palette.COM, "linewidth": 1.3, "zorder": 3.0}
    yield "dcm", time, rollout.dcm, {"color": palette.DCM, "linewidth": 1.9, "zorder": 3.1}
    yield "dcm-plan", cut, broken_plan(rollout, parts), plan
    if not np.isnan(outside).all():
        look = {"color": palette.ALARM, "linewidth": 2.4, "zorder": 2.6}
        yield "zmp-outside", cut, broken(outside, parts), look


def _body_curves(rollout: Rollout, parts: list[Stance], trace: BodyTrace) -> Iterator[Curve]:
    """Measured lines, and dashed those that were planned."""
    time, dashed = rollout.time, {"linestyle": DASHES, "zorder": 3.2}
    yield "zmp", time, rollout.zmp, {"color": palette.ZMP, "linewidth": 0.9, "zorder": 2.4}
    zmp = {"color": palette.ZMP_PLAN, "linewidth": 0.9, **dashed}
    yield "zmp-plan", time, rollout.commands["zmp"], zmp
    yield "dcm", time, rollout.dcm, {"color": palette.DCM, "linewidth": 1.7, "zorder": 3.0}
    yield "com", time, rollout.com, {"color": palette.COM, "linewidth": 1.2, "zorder": 3.1}
    dcm = {"color": palette.DCM_PLAN, "linewidth": 1.0, **dashed}
    yield "dcm-plan", time, broken_plan(rollout, parts), dcm
    com = {"color": palette.COM_PLAN, "linewidth": 1.0, **dashed}
    yield "com-plan", time, planned_com(rollout, trace), com


def _draw_soles(ax: Axes, rollout: Rollout, trace: BodyTrace, axis: int) -> None:
    """Fill the soles that carry a body."""
    for foot in (0, 1):
        carries = (~trace.walking) | (trace.support == foot)
        centre, yaw = trace.sole_position[:, foot, axis], trace.sole_turn[:, foot, 2]
        reach = sole_reach(trace.robot.foot, yaw)[:, axis]
        whose = Side(2 * foot - 1)
        ax.fill_between(
            rollout.time, centre - reach, centre + reach, where=carries,
            facecolor=palette.SOLE[whose], edgecolor=palette.SOLE_EDGE[whose], linewidth=0.4,
            zorder=1.0, gid=f"sole-{ax.get_gid()}-{foot}",
        )  # fmt: skip


def _body_range(rollout: Rollout, trace: BodyTrace, axis: int) -> tuple[float, float]:
    """All of soles and CoM, and of the DCM what does not run far away [m]."""
    soles, half = trace.sole_position[:, :, axis], trace.robot.foot.half[axis]
    core = np.concatenate([soles.ravel() - half, soles.ravel() + half, rollout.com[:, axis]])
    near = np.clip(rollout.dcm[:, axis], core.min() - 0.3, core.max() + 0.3)
    low, high = min(core.min(), near.min()), max(core.max(), near.max())
    margin = 0.05 * (high - low)
    return float(low - margin), float(high + margin)


def _draw_support(ax: Axes, rollout: Rollout, parts: list[Stance], axis: int) -> None:
    """Fill what bounds the ZMP: the sole on the ground, and in double support all between both."""
    name = ax.get_gid()
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
    spacing = 0.45 * _seconds_per_inch(ax)
    last = -np.inf
    for part in parts:
        middle = 0.5 * (part.start + part.end)
        if not part.adapted or part.landing is None or middle - last < spacing:
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
    spacing = 0.22 * _seconds_per_inch(ax)
    taken: list[float] = []
    for part in sorted(parts, key=lambda part: not part.adapted):
        middle = 0.5 * (part.start + part.end)
        if any(abs(middle - other) < spacing for other in taken):
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


def _of_body(
    draw: Callable[..., None], *more: Any
) -> Callable[[Axes, Rollout, list[Stance]], None]:
    """A plot of a body as that of a `Panel`."""
    return lambda ax, rollout, _: draw(ax, rollout, rollout.body, *more)


POINT_PANELS = (
    Panel("x", 2.0, _draw_position),
    Panel("y", 2.0, _draw_position),
    Panel("error", 1.0, _draw_error),
    Panel("duration", 1.0, _draw_duration),
)
BODY_PANELS = (
    Panel("x", 1.5, _draw_position),
    Panel("y", 1.8, _draw_position),
    Panel("feet", 1.1, _of_body(draw_feet)),
    Panel("knees", 0.9, _of_body(draw_knees)),
    Panel("left motors", 1.45, _of_body(draw_motors, "left")),
    Panel("right motors", 1.45, _of_body(draw_motors, "right")),
)

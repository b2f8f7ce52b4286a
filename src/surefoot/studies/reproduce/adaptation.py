"""What a step decides over time, every quantity against its bounds, and how long deciding takes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.stances import Stance, broken, stances
from surefoot.show.walk_events import shade_push_in_time
from surefoot.studies.reproduce.axes import (
    add_legend,
    number_steps,
    push_patch,
    time_figure,
)

LABELS = ("T [s]", "X [m]", "Y + s hip [m]", r"$\tau$ [-]", r"$d_x$ [m]", r"$d_y$ [m]")


def adaptation_figure(rollout: Rollout, until: float, name: str) -> Figure:
    """Step duration, step vector, tau and DCM offset as decided in every cycle.

    Args:
        rollout: the walk.
        until: last instant that is shown [s].
        name: of the walk, for the title.
    """
    figure, axes = time_figure(
        f"{name}: what is decided in every cycle, within its bounds", LABELS, until, 1.05
    )
    parts = stances(rollout)
    decided = _decisions(rollout)
    for index, ax in enumerate(axes):
        shade_push_in_time(ax, rollout)
        for part in parts:
            _draw_bounds(ax, rollout, part, index)
        ax.plot(
            broken(rollout.time, parts), broken(decided[:, index], parts), color=palette.COM,
            linewidth=1.4, zorder=3.0,
        )  # fmt: skip
        where = np.where(rollout.adapting, decided[:, index], np.nan)
        ax.plot(
            broken(rollout.time, parts), broken(where, parts), color=palette.ADAPTED,
            linewidth=2.4, zorder=3.1,
        )  # fmt: skip
        ax.yaxis.set_label_coords(-0.055, 0.5)
    number_steps(axes[0], rollout)
    lines = [
        Line2D([], [], color=palette.COM, linewidth=1.4, label="planned"),
        Line2D([], [], color=palette.ADAPTED, linewidth=2.4, label="decided online"),
        Line2D([], [], color=palette.DCM_PLAN, linewidth=1.0, linestyle="dashed", label="nominal"),
        Patch(facecolor="#e4efe9", edgecolor=palette.ZMP, linewidth=0.7, label="within bounds"),
        push_patch(rollout),
    ]
    add_legend(figure, (), lines)
    return figure


def _decisions(rollout: Rollout) -> NDArray[np.float64]:
    """T, X, Y + s hip, tau, d_x, d_y of every cycle, shape (n, 6)."""
    commands = rollout.commands
    duration = commands["step_duration"]
    step = commands["step_location"] - rollout.support_foot
    tau = np.exp(rollout.robot.omega * duration)
    return np.column_stack([duration, step, tau, commands["dcm_offset"]])


def _draw_bounds(ax: Axes, rollout: Rollout, part: Stance, index: int) -> None:
    robot = rollout.robot
    low, high = robot.gait.step_box(part.side, robot.hip)
    shortest, longest = robot.gait.step_duration
    tau = np.exp(robot.omega * np.array([shortest, longest]))
    d_x, d_y = robot.gait.dcm_offset
    bounds = [
        (shortest, longest), (low[0], high[0]), (low[1], high[1]), (tau[0], tau[1]),
        (-d_x, d_x), (-d_y, d_y),
    ]  # fmt: skip
    edge, values = bounds[index], None
    if part.gait is not None:
        gait = part.gait
        step, offset = gait.step(part.side), gait.dcm_offset(part.side)
        values = (gait.step_duration, *step, gait.growth, *offset)[index]
        if index >= 4:
            # The controller widens its bounds so that they hold the nominal offset.
            edge = (min(edge[0], values), max(edge[1], values))
    time = np.linspace(part.start, part.end, 40)
    least = np.full_like(time, edge[0])
    if index in (0, 3):
        # A step cannot have ended before now, T > t.
        elapsed = time - part.start
        least = np.maximum(least, elapsed if index == 0 else np.exp(robot.omega * elapsed))
    ax.fill_between(time, least, edge[1], facecolor="#e4efe9", edgecolor=palette.ZMP,
                    linewidth=0.7, zorder=0.3)  # fmt: skip
    if values is not None:
        ax.hlines(values, part.start, part.end, color=palette.DCM_PLAN, linewidth=1.0,
                  linestyle="dashed", zorder=2.5)  # fmt: skip


def decision_time_figure(rollouts: Mapping[str, Rollout]) -> Figure:
    """How long every decision took on this machine; wall clock, different in every run.

    Args:
        rollouts: by the name that stands beside their plot.
    """
    until = min(float(rollout.time[-1]) for rollout in rollouts.values())
    figure, axes = time_figure(
        "decision time per cycle (the control period is 1000 µs)",
        [f"{name}\n[µs]" for name in rollouts],
        until,
    )
    for ax, rollout in zip(axes, rollouts.values(), strict=True):
        shade_push_in_time(ax, rollout)
        micros = 1e6 * rollout.decision_time
        ax.semilogy(rollout.time, micros, ".", color=palette.COM, markersize=2.0)
        ax.semilogy(
            rollout.time[rollout.adapting], micros[rollout.adapting], ".", color=palette.ADAPTED,
            markersize=2.5,
        )  # fmt: skip
        ax.set_ylim(1.0, 3000.0)
        ax.set_yticks([1.0, 10.0, 100.0, 1000.0], ["1", "10", "100", "1000"])
        ax.minorticks_off()
        ax.axhline(1000.0, color=palette.ALARM, linewidth=0.9, linestyle=(0, (4, 2)))
        ax.yaxis.set_label_coords(-0.042, 0.5)
        middle, slow = np.percentile(micros, (50, 99))
        ax.text(
            0.99, 0.66, f"median {middle:.0f} µs, 99 % below {slow:.0f} µs", ha="right", va="top",
            transform=ax.transAxes, fontsize=8.5,
        )  # fmt: skip
    dots = [
        Line2D([], [], color=colour, marker=".", linestyle="none", label=label)
        for colour, label in ((palette.COM, "tracking"), (palette.ADAPTED, "deciding the step"))
    ]
    dots.append(
        Line2D([], [], color=palette.ALARM, linewidth=0.9, linestyle=(0, (4, 2)), label="period")
    )
    add_legend(figure, (), dots)
    return figure

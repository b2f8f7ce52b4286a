"""What happened when: touchdowns, pushes, decisions online, new velocities, the fall."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from surefoot.dcm.pushes import Push
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.halo import HALO
from surefoot.show.stances import Stance, acting_pushes, push_opacity
from surefoot.show.walk_words import velocity_words


def mark_events(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Mark in a plot over time what happened when.

    Args:
        ax: the plot; its name (gid) is part of the names of the marks.
        rollout: the walk.
        parts: its stances.
    """
    _shade_pushes(ax, rollout)
    _hatch_decisions(ax, rollout, parts)
    touchdowns = [part.start for part in parts[1:]]
    _draw_instants(ax, "touchdowns", touchdowns, color="#9a9a9a", linewidth=0.5, zorder=1.6)
    changes = [time for time, _ in rollout.velocities[1:]]
    _draw_instants(
        ax,
        "new-velocity",
        changes,
        color=palette.COM,
        linewidth=0.9,
        linestyle=(0, (6, 2, 1, 2)),
        zorder=1.7,
    )
    alarm: dict[str, Any] = {"color": palette.ALARM, "linewidth": 1.2, "zorder": 4.5}
    if rollout.fall is not None:
        _draw_instants(ax, "fell", [rollout.fall.time], clip_on=False, **alarm)
        if rollout.fall.lost_time is not None:
            _draw_instants(ax, "lost", [rollout.fall.lost_time], linestyle=(0, (4, 2)), **alarm)


def strong_pushes(rollout: Rollout) -> list[Push]:
    """The pushes that end: those without end are the small ones that act in every step."""
    return [push for push in acting_pushes(rollout) if math.isfinite(push.duration)]


def shade_push_in_time(ax: Axes, rollout: Rollout) -> None:
    """Yellow while a push acts, and a thin line at every touchdown."""
    for push in strong_pushes(rollout):
        ax.axvspan(push.start, push.end, color=palette.PUSH, alpha=0.35, linewidth=0.0, zorder=0.5)
    for step in rollout.footsteps:
        ax.axvline(step.start + step.duration, color="#b5b5b5", linewidth=0.5, zorder=0.6)


def _shade_pushes(ax: Axes, rollout: Rollout) -> None:
    for index, push in enumerate(acting_pushes(rollout)):
        ax.axvspan(
            max(push.start, rollout.time[0]),
            min(push.end, rollout.time[-1]),
            facecolor=palette.PUSH,
            edgecolor="none",
            alpha=push_opacity(rollout, push),
            zorder=1.5,
            gid=f"push-{ax.get_gid()}-{index}",
        )


def _hatch_decisions(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    for part in parts:
        for first, last in _runs(rollout.adapting, part.samples):
            end = part.end if last == part.samples.stop else rollout.time[last]
            ax.axvspan(
                rollout.time[first],
                end,
                facecolor="none",
                edgecolor=palette.ADAPTED,
                hatch="////",
                linewidth=0.0,
                alpha=0.3,
                zorder=1.4,
                gid=f"adapting-{ax.get_gid()}-{first}",
            )


def _draw_instants(ax: Axes, name: str, times: list[float], **look: Any) -> None:
    """Vertical lines through the whole plot."""
    if times:
        across, gid = ax.get_xaxis_transform(), f"{name}-{ax.get_gid()}"
        ax.vlines(times, 0.0, 1.0, transform=across, gid=gid, **look)


def _runs(flags: NDArray[np.bool_], samples: slice) -> list[tuple[int, int]]:
    """First index and one past the last index of every run of True among some samples."""
    edges = np.diff(np.concatenate(([0], flags[samples].astype(int), [0])))
    runs = np.flatnonzero(edges).reshape(-1, 2) + samples.start
    return [(int(first), int(last)) for first, last in runs]


def name_velocities(ax: Axes, rollout: Rollout) -> None:
    """Write every new velocity beside its line."""
    for time, velocity in rollout.velocities[1:]:
        ax.annotate(
            velocity_words(velocity),
            (time, 0.97),
            xycoords=("data", "axes fraction"),
            xytext=(3.0, 0.0),
            textcoords="offset points",
            va="top",
            fontsize=7.5,
            path_effects=HALO,
            clip_on=True,
            zorder=5.0,
            gid=f"velocity-{time:g}",
        )


def name_fall(ax: Axes, rollout: Rollout) -> None:
    """Write beside their lines when the robot was lost and when it fell, if it did."""
    fall = rollout.fall
    if fall is None:
        return
    for name, time, height in (("lost", fall.lost_time, 0.97), ("fell", fall.time, 0.76)):
        if time is not None:
            ax.annotate(
                name,
                (time, height),
                xycoords=("data", "axes fraction"),
                xytext=(-3.0, 0.0),
                textcoords="offset points",
                ha="right",
                va="top",
                fontsize=8.0,
                fontweight="bold",
                color=palette.ALARM,
                path_effects=HALO,
                zorder=5.0,
                gid=f"{name}-label",
            )

"""What happened when: touchdowns, pushes, decisions online, new commands, the fall."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from surefoot.dcm.pushes import Push
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.picture_file import HALO
from surefoot.show.stances import (
    Stance,
    acting_pushes,
    commanded,
    push_opacity,
    touchdown_cycles,
)
from surefoot.show.words import command_label, command_words


def mark_events(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Mark in a plot over time what happened when.

    Args:
        ax: the plot; its name (gid) is part of the names of the marks.
        rollout: the walk.
        parts: its stances; of a body none are needed.
    """
    body = rollout.body
    _shade_pushes(ax, rollout)
    if body is None:
        _hatch_decisions(ax, rollout, parts)
    landed = rollout.time[touchdown_cycles(rollout)].tolist()
    colour = "#9a9a9a" if body is None else palette.TOUCHDOWN
    _draw_instants(ax, "touchdowns", landed, color=colour, linewidth=0.5, zorder=1.6)
    changes = [command.time for command in commanded(rollout)[1:]]
    _draw_instants(
        ax, "new-velocity", changes, color=palette.COM, linewidth=0.9,
        linestyle=(0, (6, 2, 1, 2)), zorder=1.7,
    )  # fmt: skip
    _draw_fall(ax, rollout)


def _draw_fall(ax: Axes, rollout: Rollout) -> None:
    """Lines where the fall could not be averted any more, and where it ended."""
    fall, body_fall = rollout.fall, rollout.body_fall
    if fall is None:
        return
    lost, end = (
        (fall.lost_time, fall.time) if body_fall is None else (body_fall.time, body_fall.end)
    )
    alarm: dict[str, Any] = {"color": palette.ALARM, "linewidth": 1.2, "zorder": 4.5}
    _draw_instants(ax, "fell", [end], clip_on=False, **alarm)
    if lost is not None:
        _draw_instants(ax, "lost", [lost], linestyle=(0, (4, 2)), **alarm)


def strong_pushes(rollout: Rollout) -> list[Push]:
    """The pushes that end: those without end are the small ones that act in every step."""
    return [push for push in acting_pushes(rollout) if math.isfinite(push.duration)]


def shade_push_in_time(ax: Axes, rollout: Rollout) -> None:
    """Yellow while a push acts, and a thin line at every touchdown."""
    for push in strong_pushes(rollout):
        ax.axvspan(push.start, push.end, color=palette.PUSH, alpha=0.35, linewidth=0.0, zorder=0.5)
    for step in rollout.footsteps:
        ax.axvline(step.start + step.duration, color=palette.TOUCHDOWN, linewidth=0.5, zorder=0.6)


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


def name_events(ax: Axes, rollout: Rollout) -> None:
    """Write beside their lines new commands, and when the robot was lost and when it fell."""
    body, fall, body_fall = rollout.body, rollout.fall, rollout.body_fall
    if body is None:
        for command in commanded(rollout)[1:]:
            words, gid = command_words(command), f"velocity-{command.time:g}"
            _name(ax, words, command.time, 0.97, gid, fontsize=7.5, clip_on=True)
        if fall is not None:
            for name, time, height in (("lost", fall.lost_time, 0.97), ("fell", fall.time, 0.76)):
                if time is not None:
                    _name(
                        ax, name, time, height, f"{name}-label", left=True, fontsize=8.0,
                        fontweight="bold", color=palette.ALARM,
                    )  # fmt: skip
        return
    words = [
        (command.time, command_label(command), palette.COM, f"command-{command.time:g}")
        for command in commanded(rollout)[1:]
    ]
    if body_fall is not None:
        words.append((body_fall.time, body_fall.cause.value, palette.ALARM, "lost-label"))
    for time, text, colour, gid in words:
        _name(
            ax, text, time, 0.95, gid, left=time > 0.8 * float(rollout.time[-1]), fontsize=8.0,
            fontweight="bold", color=colour,
        )  # fmt: skip


def _name(
    ax: Axes, text: str, time: float, height: float, gid: str, *, left: bool = False, **look: Any
) -> None:
    """Write a text beside the line of an instant, at a height from 0 to 1."""
    ax.annotate(
        text, (time, height), xycoords=("data", "axes fraction"),
        xytext=(-3.0 if left else 3.0, 0.0), textcoords="offset points",
        ha="right" if left else "left", va="top", path_effects=HALO, zorder=5.0, gid=gid, **look,
    )  # fmt: skip

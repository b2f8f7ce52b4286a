"""The walk over time: x and y with the soles that bound the ZMP, the DCM error, the step duration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.simulation.lipm_simulator import FALL_DISTANCE
from surefoot.simulation.outcome import SETTLED_ERROR, Fall
from surefoot.simulation.rollout import Rollout
from surefoot.viewers import palette
from surefoot.viewers.palette import HALO
from surefoot.viewers.stances import Stance, acting_pushes, broken, push_opacity

HEIGHTS = (2.0, 2.0, 1.0, 1.0)
"""Of the four plots [in]."""

_PLAN_DASH = (0, (3, 2))


def draw_time_plots(axes: Sequence[Axes], rollout: Rollout, parts: list[Stance]) -> None:
    """Draw x, y, DCM error and step duration over time, one below the other.

    Args:
        axes: four axes of the same width.
        rollout: the walk.
        parts: its stances.
    """
    for index, ax in enumerate(axes):
        ax.set_xlim(rollout.time[0], max(rollout.time[-1], rollout.time[0] + 1e-3))
        ax.grid(axis="y", color="#e8e8e8", linewidth=0.5, zorder=0)
        ax.set_axisbelow(True)
        ax.tick_params(labelbottom=index == len(axes) - 1)
        _mark_events(ax, rollout, parts)
    axes[-1].set_xlabel("time [s]")
    for index, name in enumerate("xy"):
        _draw_position(axes[index], rollout, parts, index)
        axes[index].set_ylabel(f"{name} [m]")
    _draw_error(axes[2], rollout)
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


def _mark_events(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Touchdowns, steps that are decided online, pushes, new velocities, the fall."""
    for index, push in enumerate(acting_pushes(rollout)):
        first = max(push.start, rollout.time[0])
        ax.axvspan(
            first, min(push.end, rollout.time[-1]), facecolor=palette.PUSH, edgecolor="none",
            alpha=push_opacity(rollout, push), zorder=1.5, gid=f"push-time-{index}",
        )  # fmt: skip
    for part in parts:
        for first, last in _runs(rollout.adapting[part.samples]):
            times = rollout.time[part.samples]
            end = part.end if last == len(times) else times[last]
            ax.axvspan(
                times[first], end, facecolor="none", edgecolor=palette.ADAPTED, hatch="////",
                linewidth=0.0, alpha=0.3, zorder=1.4, gid=f"adapted-time-{part.number}",
            )  # fmt: skip
    across = ax.get_xaxis_transform()
    ax.vlines(
        [part.start for part in parts[1:]], 0.0, 1.0, transform=across, color="#9a9a9a",
        linewidth=0.5, zorder=1.6, gid="touchdowns",
    )  # fmt: skip
    if len(rollout.velocities) > 1:
        ax.vlines(
            [time for time, _ in rollout.velocities[1:]], 0.0, 1.0, transform=across,
            color=palette.COM, linewidth=0.9, linestyle=(0, (6, 2, 1, 2)), zorder=1.7,
            gid="new-velocity",
        )  # fmt: skip
    fall = rollout.fall
    if fall is not None:
        times = [time for time in (fall.lost_time, fall.time) if time is not None]
        ax.vlines(
            times, 0.0, 1.0, transform=across, color=palette.ALARM, linewidth=1.2,
            linestyle=[(0, (4, 2))] * (len(times) - 1) + ["solid"], zorder=4.5, gid="fall-time",
        ).set_clip_on(False)  # fmt: skip


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First index and one past the last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(int), [0]))))
    return [(int(first), int(last)) for first, last in edges.reshape(-1, 2)]


def _draw_position(ax: Axes, rollout: Rollout, parts: list[Stance], axis: int) -> None:
    half = rollout.robot.foot.half[axis]
    for part in parts:
        ax.add_patch(
            Rectangle(
                (part.start, part.support_foot[axis] - half),
                part.end - part.start,
                2.0 * half,
                facecolor=palette.SOLE[part.side],
                edgecolor=palette.SOLE_EDGE[part.side],
                linewidth=0.5,
                zorder=1.0,
                gid=f"support-{'xy'[axis]}-{part.number}",
            )
        )
    time = broken(rollout.time, parts)
    zmp = rollout.zmp[:, axis]
    ax.plot(time, broken(zmp, parts), color=palette.ZMP, linewidth=1.3, zorder=2.5, gid="zmp")
    if rollout.zmp_excess.any():
        out = np.abs(zmp - rollout.support_foot[:, axis]) > half + 1e-12
        ax.plot(
            time, broken(np.where(out, zmp, np.nan), parts), color=palette.ALARM, linewidth=2.4,
            zorder=2.6, gid="zmp-outside",
        )  # fmt: skip
    ax.plot(rollout.time, rollout.com[:, axis], color=palette.COM, linewidth=1.3, zorder=3.0,
            gid="com")  # fmt: skip
    ax.plot(rollout.time, rollout.dcm[:, axis], color=palette.DCM, linewidth=1.9, zorder=3.1,
            gid="dcm")  # fmt: skip
    ax.plot(
        time, broken(rollout.dcm_plan[:, axis], parts), color=palette.DCM_PLAN, linewidth=1.1,
        linestyle=_PLAN_DASH, zorder=3.2, gid="dcm-plan",
    )  # fmt: skip
    ax.set_ylim(*_range(rollout, axis))


def _range(rollout: Rollout, axis: int) -> tuple[float, float]:
    """All of CoM, DCM and soles, and of ZMP and plan what does not run far away [m]."""
    foot, half = rollout.support_foot[:, axis], rollout.robot.foot.half[axis]
    near = foot + np.clip(rollout.dcm[:, axis] - foot, -FALL_DISTANCE, FALL_DISTANCE)
    core = np.concatenate([foot - half, foot + half, rollout.com[:, axis], near])
    low, high = core.min(), core.max()
    reach = 0.4 * (high - low)
    far = np.concatenate([rollout.zmp[:, axis], rollout.dcm_plan[:, axis]])
    low, high = max(min(low, far.min()), low - reach), min(max(high, far.max()), high + reach)
    margin = 0.05 * (high - low)
    return float(low - margin), float(high + margin)


def _draw_error(ax: Axes, rollout: Rollout) -> None:
    error = 1e3 * np.hypot(*rollout.dcm_error.T)
    settled = 1e3 * SETTLED_ERROR
    ax.axhline(settled, color=palette.QUIET, linewidth=0.8, linestyle=(0, (1, 2)), gid="settled")
    _name_line(ax, settled, "settled")
    ax.fill_between(rollout.time, error, color=palette.DCM, alpha=0.2, linewidth=0.0, zorder=2.0)
    ax.plot(rollout.time, error, color=palette.DCM, linewidth=1.3, zorder=3.0, gid="dcm-error")
    ax.set_ylim(0.0, 1.15 * max(settled * 1.5, min(float(error.max()), 1e3 * FALL_DISTANCE)))
    ax.set_ylabel("DCM error\n[mm]")


def _draw_duration(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    shortest, longest = rollout.robot.gait.step_duration
    time = broken(rollout.time, parts)
    decided = rollout.commands["step_duration"]
    for limit, name in ((shortest, "shortest"), (longest, "longest")):
        _name_line(ax, limit, name)
        ax.axhline(limit, color=palette.QUIET, linewidth=0.8, linestyle=(0, (1, 2)), gid="limit")
    ax.plot(time, broken(decided, parts), color=palette.COM, linewidth=1.3, zorder=3.0,
            drawstyle="steps-post", gid="step-duration")  # fmt: skip
    for part in parts:
        if part.gait is not None:
            ax.hlines(part.gait.step_duration, part.start, part.end, color=palette.DCM_PLAN,
                      linewidth=1.1, linestyle=_PLAN_DASH, zorder=3.2,
                      gid=f"nominal-duration-{part.number}")  # fmt: skip
    _write_adapted_durations(ax, parts)
    if rollout.fall is not None:
        _name_fall(ax, rollout.fall)
    ax.set_ylim(0.0, 1.3 * longest)
    ax.set_ylabel("step\nduration [s]")


def _name_line(ax: Axes, level: float, name: str) -> None:
    ax.annotate(
        name, (0.0, level), xycoords=("axes fraction", "data"), xytext=(3.0, 1.0),
        textcoords="offset points", va="bottom", fontsize=7.0, color=palette.QUIET,
        path_effects=HALO, gid=f"name-{name}",
    )  # fmt: skip


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
            f"{part.end - part.start:.2f} s", (middle, 0.0), xytext=(0.0, 3.0),
            textcoords="offset points", ha="center", va="bottom", fontsize=8.0,
            fontweight="bold", color=palette.ADAPTED, path_effects=HALO, zorder=5.0,
            gid=f"duration-{part.number}",
        )  # fmt: skip


def _name_fall(ax: Axes, fall: Fall) -> None:
    for name, time, height in (("lost", fall.lost_time, 0.97), ("fell", fall.time, 0.76)):
        if time is not None:
            ax.annotate(
                name, (time, height), xycoords=("data", "axes fraction"), xytext=(-3.0, 0.0),
                textcoords="offset points", ha="right", va="top", fontsize=8.0,
                fontweight="bold", color=palette.ALARM, path_effects=HALO, zorder=5.0,
                gid=f"name-{name}",
            )  # fmt: skip


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
            middle, 1.02, str(part.number), transform=ax.get_xaxis_transform(), ha="center",
            va="bottom", fontsize=8.5 if part.adapted else 7.5,
            fontweight="bold" if part.adapted else "normal",
            color=palette.ADAPTED if part.adapted else palette.QUIET, gid=f"step-{part.number}",
        )  # fmt: skip
    ax.annotate(
        "step", (0.0, 1.02), xycoords="axes fraction", xytext=(-26.0, 0.0),
        textcoords="offset points", ha="right", va="bottom", fontsize=7.5, color=palette.QUIET,
    )  # fmt: skip

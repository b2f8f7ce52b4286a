"""A tuning as a picture: every trial, the front, the default and what was taken; and the scores."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter
from numpy import geomspace, quantile

from surefoot.show import palette
from surefoot.studies.tune.search import Tuned
from surefoot.studies.tune.words import changes, score_rows, title, verdict

WIDTH, HEIGHT = 11.0, 5.2
_SHOWN = 0.9
"""This part of the trials is shown in its place; what is much less gentle, or survives much less,
stands on an edge."""

_COLUMNS = (("pushes", 0.0), ("", 0.24), ("survived", 0.53), ("weakest", 0.74), ("gentleness", 1.0))


def tune_figure(tuned: Tuned) -> Figure:
    """Survival over gentleness of all trials, and the table of scores.

    Returns:
        A figure of its own, not known to pyplot.
    """
    figure = Figure(figsize=(WIDTH, HEIGHT), facecolor="white")
    figure.suptitle(title(tuned), x=0.065, y=0.975, ha="left", fontsize=12.0, fontweight="bold")
    _draw_trials(figure.add_axes((0.065, 0.115, 0.45, 0.785)), tuned)
    words = figure.add_axes((0.56, 0.115, 0.425, 0.785))
    words.set_axis_off()
    words.set_xlim(0.0, 1.0)
    words.set_ylim(0.0, 1.0)
    below = _write_scores(words, tuned)
    _write_changes(words, tuned, below)
    return figure


def _draw_trials(ax: Axes, tuned: Tuned) -> None:
    points = tuned.points()
    default = points[0]
    edge = max(1.2, float(quantile([one[1] for one in points.values()], _SHOWN)))
    floor = min(float(quantile([one[0] for one in points.values()], 1.0 - _SHOWN)), default[0])
    inside = [one for one in points.values() if one[1] <= edge and one[0] >= floor]
    outside = [one for one in points.values() if one not in inside]
    front = [reached for _, reached in tuned.front_points()]
    taken = tuned.objectives("tuned", "seen")
    least = 0.9 * min(*(one[1] for one in points.values()), taken[1])
    highest = max(one[0] for one in points.values())
    room = 0.06 * max(highest - floor, 0.02)
    ax.set_xscale("log")
    ax.set_xlim(least, 1.06 * edge)
    top = 100.0 * (highest + 2.0 * room)
    ax.set_ylim(100.0 * (floor - room), top)
    ax.fill_between([least, 1.0], 100.0 * default[0], top, color="#e8f3ec", zorder=0, gid="better")
    dots = {"color": "#9a9a9a", "markersize": 4.0, "linestyle": "none", "zorder": 2}
    ax.plot(*_axes(inside), marker="o", label=f"{len(points)} trials", gid="trials", **dots)
    if outside:
        ax.plot(
            *_axes([(max(one[0], floor), min(one[1], edge)) for one in outside]), marker="x",
            label=f"{len(outside)} of these beyond the edge", gid="outside", **dots,
        )  # fmt: skip
    shown = [one for one in front if one[1] <= edge]
    ax.plot(
        *_axes(shown), color=palette.DCM, marker="o", markersize=4.5, linewidth=1.0, zorder=3,
        drawstyle="steps-post", label="not dominated", gid="front",
    )  # fmt: skip
    ax.plot(
        *_axes([default]), color=palette.DCM_PLAN, marker="D", markersize=8.0, linestyle="none",
        zorder=4, label="default", gid="default",
    )  # fmt: skip
    ax.plot(
        *_axes([taken]), color=palette.ADAPTED, marker="*", markersize=14.0, linestyle="none",
        zorder=5, label="tuned", gid="tuned",
    )  # fmt: skip
    _explain(ax, (least, 1.06 * edge))


def _axes(points: Sequence[tuple[float, ...]]) -> tuple[list[float], list[float]]:
    return [one[1] for one in points], [100.0 * one[0] for one in points]


def _explain(ax: Axes, reach: tuple[float, float]) -> None:
    ax.set_xlabel("gentleness: how much a small push moves, over that of the default")
    ax.set_ylabel("survived, % of the theoretical limit")
    ticks = sorted({float(f"{x:.1g}") for x in geomspace(*reach, 6)} | {1.0})
    ax.set_xticks([x for x in ticks if reach[0] <= x <= reach[1]])
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.grid(visible=True, which="major", color="#e6e6e6", linewidth=0.6, zorder=0)
    ax.set_axisbelow(True)
    ax.text(
        0.012, 0.985, "no worse than the default", transform=ax.transAxes, ha="left", va="top",
        fontsize=8.0, color=palette.ZMP_PLAN,
    )  # fmt: skip
    ax.legend(loc="best", frameon=True, framealpha=0.9, edgecolor="#dddddd")


def _write_scores(ax: Axes, tuned: Tuned) -> float:
    """Write the table; how far down it goes."""
    y = 1.0
    for name, x in _COLUMNS:
        ax.text(x, y, name, ha="left" if x < 0.5 else "right", va="top", fontweight="bold")
    for number, row in enumerate(score_rows(tuned)):
        y -= 0.06 + (0.02 if number % 2 == 0 else 0.0)
        worst = row[3].split(" (")[0]
        for (_, x), text in zip(_COLUMNS, (*row[:3], worst, row[4]), strict=True):
            repeated = x == 0.0 and number % 2 == 1
            ax.text(
                x, y, "" if repeated else text, ha="left" if x < 0.5 else "right", va="top",
                fontweight="bold" if row[1] == "tuned" and x > 0.0 else "normal",
            )  # fmt: skip
    return y - 0.12


def _write_changes(ax: Axes, tuned: Tuned, y: float) -> None:
    reasons = changes(tuned) or ["The default stays."]
    ax.text(0.0, y, "what changed, and why", va="top", fontweight="bold")
    for text in [*reasons, verdict(tuned)]:
        y -= 0.02
        for line in _lines(text, 74):
            y -= 0.045
            ax.text(0.0, y, line, va="top", fontsize=8.5)


def _lines(text: str, width: int) -> list[str]:
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            lines.append(line)
            line = "   "
        line = f"{line} {word}" if line.strip() else f"{line}{word}"
    return [*lines, line] if line.strip() else lines

"""What a tuning shows: what was changed and why, whether it holds elsewhere, and every trial."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure as Picture
from matplotlib.ticker import FuncFormatter, NullFormatter
from numpy import geomspace, quantile

from surefoot.show import palette
from surefoot.studies.engine.pictures import headline
from surefoot.studies.engine.report import Details, Figure, Report, Table, Text, word_table
from surefoot.studies.engine.words import angle_words
from surefoot.studies.tune.choice import NOTICEABLE_GENTLENESS, NOTICEABLE_SURVIVAL, Objectives
from surefoot.studies.tune.search import Tuned
from surefoot.version import VERSION

COLUMNS = ("pushes", "", "survived", "weakest push", "gentleness", "ZMP", "landing", "timing")
"""Of the table of scores."""

PLACES = {"seen": "of the search", "unseen": "not seen by it"}

RULE = (
    "Survived is the largest impulse below which every push is survived, over the theoretical "
    "limit: the mean over all directions and phases, and the weakest of them. Gentleness is how "
    "much a small push moves, over how much it moves with the defaults: below 1 is gentler. What "
    "it moves are three shares: of the ZMP (mean of peak and root mean square) of half the sole's "
    "diagonal, of a landing of the way to the farthest corner of the step box, of a step's "
    "duration of the most that it can change. Landing and timing count ten times: a ZMP that stays "
    "under the sole costs little."
)

_WIDTH, _HEIGHT = 11.0, 5.2
_SHOWN = 0.9
"""This part of the trials is shown in its place; what is much less gentle, or survives much less,
stands on an edge."""

_WRITTEN = (("pushes", 0.0), ("", 0.24), ("survived", 0.53), ("weakest", 0.74), ("gentleness", 1.0))
"""Columns of the table in the picture, and where they stand."""


def report(tuned: Tuned, command: str) -> Report:
    """All of a tuning; `command` walks with the settings."""
    about = tuned.provenance
    reasons = changes(tuned)
    words = [outcome(tuned), *reasons, dropped_words(tuned)]
    alone = (
        ["What is lost without a parameter is measured with it alone set back."] if reasons else []
    )
    return Report(
        name="tune",
        heading=title(tuned),
        origin=(f"{about['trials']} trials", f"seed {about['seed']}"),
        parts=[
            *(Text(one) for one in words if one),
            Table("Does it hold?", verdict(tuned), COLUMNS, score_rows(tuned), names=2),
            Figure(
                "tune.png", "Survival over gentleness of every trial",
                lambda: tune_figure(tuned),
            ),
            Details(
                "What is measured",
                [Text(" ".join([RULE, f"The small pushes have {about['small push']}.", *alone]))],
            ),
            Details(
                "What else there is",
                [
                    Text("The trials on the Pareto front, whatever is preferred."),
                    Table("", "", ("trial", "survived", "gentleness", "values"), front_rows(tuned)),
                ],
            ),
            Details("Walk with it", [Text(f"`{command}`")]),
            Details("Provenance", [word_table(("what", "value"), about)]),
        ],
    )  # fmt: skip


def settings_notes(tuned: Tuned, command: str) -> list[str]:
    """What stands above the settings in their file."""
    about = tuned.provenance
    return [
        f"{title(tuned)} (Surefoot {VERSION}, {about['trials']} trials, seed {about['seed']})",
        *changes(tuned),
        *([verdict(tuned)] if tuned.changed else []),
        f"Walk with it: {command}",
    ]


def title(tuned: Tuned) -> str:
    """Which method was tuned for whom."""
    about = tuned.provenance
    return f"{tuned.settings.controller} tuned for {about['robot']} at {about['velocity']}"


def score_rows(tuned: Tuned) -> list[tuple[str, ...]]:
    """The table of scores: default and tuned, on the pushes of the search and on others."""
    rows = []
    for where, place in PLACES.items():
        for which in ("default", "tuned"):
            found = tuned.scores[which][where]
            survival, gentleness = tuned.objectives(which, where)
            rows.append((
                place,
                which,
                f"{100.0 * survival:.1f} %",
                f"{100.0 * found.worst:.1f} % ({angle_words(found.worst_angle)}, phase "
                f"{found.worst_phase:g})",
                f"{gentleness:.3f}",
                *(f"{100.0 * part:.2f} %" for part in (found.zmp, found.landing, found.timing)),
            ))  # fmt: skip
    return rows


def changes(tuned: Tuned) -> list[str]:
    """A sentence for each parameter that was changed."""
    after = tuned.objectives("tuned", "seen")
    return [
        f"{one.parameter} {one.default:g} → {one.value:g}: {_why(one.without, after)}"
        for one in tuned.reasons
    ]


def front_rows(tuned: Tuned) -> list[tuple[str, ...]]:
    """Number, objectives and values of every trial on the Pareto front; the gentlest first."""
    default = tuned.trials[0].values
    rows = []
    for one, (survival, gentleness) in tuned.front_points():
        changed = [f"{k} = {v:g}" for k, v in one.values.items() if v != default[k]]
        rows.append((
            f"{one.number}",
            f"{100.0 * survival:.1f} %",
            f"{gentleness:.3f}",
            ", ".join(changed) or "the default",
        ))  # fmt: skip
    return rows


def outcome(tuned: Tuned) -> str:
    """What came of it, in a sentence or two."""
    count = len(tuned.trials)
    if not tuned.changed:
        return (
            f"The default stays: of {count} trials none is noticeably better in survival or "
            "gentleness and no worse in the other."
        )
    before, after = (tuned.objectives(which, "seen") for which in ("default", "tuned"))
    return (
        f"Of {count} trials number {tuned.chosen} was taken. Survived: "
        f"{100.0 * before[0]:.1f} → {100.0 * after[0]:.1f} % of the limit; "
        f"gentleness: 1 → {after[1]:.3f}."
    )


def verdict(tuned: Tuned) -> str:
    """Whether it holds on pushes that the search did not see."""
    if not tuned.changed:
        return ""
    before, after = (tuned.objectives(which, "unseen") for which in ("default", "tuned"))
    lost = []
    if after[0] < before[0] - NOTICEABLE_SURVIVAL:
        lost.append(
            f"{100.0 * (before[0] - after[0]):.1f} % of the limit less is survived than with the "
            "defaults"
        )
    if after[1] > 1.0 + NOTICEABLE_GENTLENESS:
        lost.append(f"gentleness is {after[1]:.3f}")
    if lost:
        return (
            f"It does NOT hold on pushes that the search did not see: {' and '.join(lost)}. Search "
            "with more --directions and --phases."
        )
    return (
        "It holds on pushes that the search did not see: "
        f"{100.0 * before[0]:.1f} → {100.0 * after[0]:.1f} % of the limit, "
        f"gentleness 1 → {after[1]:.3f}."
    )


def dropped_words(tuned: Tuned) -> str:
    """What that trial had changed too, without effect."""
    if not tuned.dropped:
        return ""
    return (
        f"Set back, since it makes no noticeable difference: {', '.join(tuned.dropped)}. "
        "(Noticeable is half a percent of the limit, or one percent in gentleness.)"
    )


def _why(without: Objectives | None, after: Objectives) -> str:
    if without is None:
        return "without it the controller refuses the rest"
    survival = 100.0 * (without[0] - after[0])
    words = []
    if abs(survival) >= 0.05:
        more = "more" if survival > 0.0 else "less"
        words.append(f"{abs(survival):.1f} % of the limit {more} survived")
    if abs(without[1] - after[1]) >= 0.0005:
        words.append(f"gentleness {without[1]:.3f} instead of {after[1]:.3f}")
    return f"without it {' and '.join(words) or 'nothing changes'}"


def tune_figure(tuned: Tuned) -> Picture:
    """Survival over gentleness of all trials, and the table of scores.

    Returns:
        A figure of its own, not known to pyplot.
    """
    figure = Picture(figsize=(_WIDTH, _HEIGHT), facecolor="white")
    headline(figure, title(tuned), left=0.715, down=0.13)
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


def _axes(points: Sequence[Objectives]) -> tuple[list[float], list[float]]:
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
    for name, x in _WRITTEN:
        ax.text(x, y, name, ha="left" if x < 0.5 else "right", va="top", fontweight="bold")
    for number, row in enumerate(score_rows(tuned)):
        y -= 0.06 + (0.02 if number % 2 == 0 else 0.0)
        worst = row[3].split(" (")[0]
        for (_, x), text in zip(_WRITTEN, (*row[:3], worst, row[4]), strict=True):
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
        for line in textwrap.wrap(text, 74, subsequent_indent="   "):
            y -= 0.045
            ax.text(0.0, y, line, va="top", fontsize=8.5)

"""A tuning in words: what was changed and why, and whether it holds elsewhere."""

from __future__ import annotations

from collections.abc import Sequence

from surefoot.studies.engine.words import angle_words
from surefoot.studies.tune.choice import NOTICEABLE_GENTLENESS, NOTICEABLE_SURVIVAL
from surefoot.studies.tune.search import Tuned

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


def _why(without: Sequence[float] | None, after: Sequence[float]) -> str:
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

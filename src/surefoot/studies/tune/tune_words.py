"""A tuning in words: what was changed and why, and whether it holds elsewhere.

All of it from the plain values of `studies.tune.tune.Tuned.as_numbers`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from surefoot.studies.engine.words import angle_words

COLUMNS = ("pushes", "", "survived", "weakest push", "gentleness", "ZMP", "landing", "timing")
"""Of the table of scores."""

PLACES = {"seen": "of the search", "unseen": "not seen by it"}

HOLDS_SURVIVAL, HOLDS_GENTLENESS = 0.005, 0.01
"""What may be lost on other pushes before it is said that something does not hold."""

RULE = (
    "Survived is the largest impulse below which every push is survived, over the limit that "
    "nobody can pass: the mean over all directions and phases, and the weakest of them. Gentleness "
    "is how much a small push moves, over how much it moves with the defaults: below 1 is gentler. "
    "What it moves are three shares: of the ZMP (mean of peak and root mean square) of half the "
    "sole's diagonal, of a landing of the way to the farthest corner of the step box, of a step's "
    "duration of the most that it can change. Landing and timing count ten "
    "times: a ZMP that stays under the sole costs little."
)


def score_rows(tuned: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """The table of scores: default and tuned, on the pushes of the search and on others."""
    rows = []
    for where, place in PLACES.items():
        for which in ("default", "tuned"):
            found = tuned["scores"][which][where]
            rows.append(
                (
                    place,
                    which,
                    f"{100.0 * found['survival']:.1f} %",
                    f"{100.0 * found['worst']:.1f} % ({push_words(found)})",
                    f"{found['gentleness']:.3f}",
                    *(f"{100.0 * found[part]:.2f} %" for part in ("zmp", "landing", "timing")),
                )
            )
    return rows


def push_words(found: Mapping[str, float]) -> str:
    """Where the weakest push goes, and when it comes."""
    return f"{angle_words(found['worst_angle'])}, phase {found['worst_phase']:g}"


def changes(tuned: Mapping[str, Any]) -> list[str]:
    """A sentence for each knob that was turned."""
    after = tuned["scores"]["tuned"]["seen"]
    return [
        f"{one['knob']} {one['default']:g} → {one['value']:g}: {_why(one['without'], after)}"
        for one in tuned["reasons"]
    ]


def front_rows(tuned: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Number, objectives and values of every trial that no other one beats; the gentlest first."""
    trials = {one["number"]: one for one in tuned["trials"]}
    default = trials[0]["values"]
    rows = []
    for one in sorted((trials[n] for n in tuned["front"]), key=lambda one: one["objectives"][1]):
        survival, gentleness = one["objectives"]
        turned = [f"{k} = {v:g}" for k, v in one["values"].items() if v != default[k]]
        rows.append(
            (
                f"{one['number']}",
                f"{100.0 * survival:.1f} %",
                f"{gentleness:.3f}",
                ", ".join(turned) or "the default",
            )
        )
    return rows


def outcome(tuned: Mapping[str, Any]) -> str:
    """What came of it, in a sentence or two."""
    count = len(tuned["trials"])
    if not tuned["changed"]:
        return (
            f"The default stays: of {count} trials none is noticeably better in survival or "
            "gentleness and no worse in the other."
        )
    before, after = (tuned["scores"][which]["seen"] for which in ("default", "tuned"))
    return (
        f"Of {count} trials number {tuned['chosen']} was taken. Survived: "
        f"{100.0 * before['survival']:.1f} → {100.0 * after['survival']:.1f} % of the limit; "
        f"gentleness: 1 → {after['gentleness']:.3f}."
    )


def verdict(tuned: Mapping[str, Any]) -> str:
    """Whether it holds on pushes that the search did not see."""
    if not tuned["changed"]:
        return ""
    before, after = (tuned["scores"][which]["unseen"] for which in ("default", "tuned"))
    lost = []
    if after["survival"] < before["survival"] - HOLDS_SURVIVAL:
        lost.append(
            f"{100.0 * (before['survival'] - after['survival']):.1f} % of the limit less is "
            "survived than with the defaults"
        )
    if after["gentleness"] > 1.0 + HOLDS_GENTLENESS:
        lost.append(f"gentleness is {after['gentleness']:.3f}")
    if lost:
        return (
            f"It does NOT hold on pushes that the search did not see: {' and '.join(lost)}. Search "
            "with more --directions and --phases."
        )
    return (
        "It holds on pushes that the search did not see: "
        f"{100.0 * before['survival']:.1f} → {100.0 * after['survival']:.1f} % of the limit, "
        f"gentleness 1 → {after['gentleness']:.3f}."
    )


def dropped_words(tuned: Mapping[str, Any]) -> str:
    """What that trial had turned too, for nothing."""
    names = tuned["dropped"]
    if not names:
        return ""
    return (
        f"Turned back, since it makes no noticeable difference: {', '.join(names)}. (Noticeable is "
        "half a percent of the limit, or one percent in gentleness.)"
    )


def _why(without: Sequence[float] | None, after: Mapping[str, float]) -> str:
    if without is None:
        return "without it the controller refuses the rest"
    survival = 100.0 * (without[0] - after["survival"])
    words = []
    if abs(survival) >= 0.05:
        words.append(f"{abs(survival):.1f} % of the limit {_more(survival)} survived")
    if abs(without[1] - after["gentleness"]) >= 0.0005:
        words.append(f"gentleness {without[1]:.3f} instead of {after['gentleness']:.3f}")
    return f"without it {' and '.join(words) or 'nothing changes'}"


def _more(difference: float) -> str:
    return "more" if difference > 0.0 else "less"

"""The words of a comparison: what was measured and how, and what a reader must know."""

from __future__ import annotations

import math

from surefoot.studies.compare.comparison import Cell, Comparison
from surefoot.studies.engine.words import RECOVERED_WORDS, angle_words, list_words

ROUNDING = 1e-9
"""A limit that is passed by this fraction of it is reached."""

HEADING = "How hard a push each method survives"
"""Of page and report."""

INCOMPLETE = "*"
"""Follows a mean that stands on fewer cells than were measured by others."""


def impulse_words(cell: Cell) -> str:
    """The smallest failing impulse, or what it lies above [N s]."""
    return f"> {cell.scanned:g}" if cell.unbroken else f"{cell.impulse:g}"


def protocol(measured: Comparison) -> list[str]:
    """What was measured and how, a paragraph each."""
    count = len(measured.angles)
    directions = (
        f"{count} directions, every {360.0 / count:g}°"
        if count > 4
        else ", ".join(angle_words(angle) for angle in measured.angles)
    )
    steps = list_words(sorted({cell.step for cell in measured.cells}))
    phases = list_words([round(phase, 3) for phase in measured.phases])
    if len(measured.phases) > 10:
        first, last = measured.phases[0], measured.phases[-1]
        phases = f"{len(measured.phases)} from {first:.3g} to {last:.3g}"
    finite = [speed for speed in measured.leg_speeds if math.isfinite(speed)]
    speeds = [f"at {list_words(finite)} m/s"] if finite else []
    speeds += ["without limit"] if len(finite) < len(measured.leg_speeds) else []
    return [
        "A robot that walks steadily is pushed once, harder in every run: the impulse is scanned "
        f"upwards in steps of {steps} N s, until the robot does not recover. Survival is not "
        "monotone in the impulse, so nothing is bisected: the smallest failing impulse ends the "
        "scan, and what is survived is the largest impulse below it.",
        f"{RECOVERED_WORDS} A robot that keeps walking but does not come back has failed too; it "
        "is counted apart, as not settled.",
        f"Directions: {directions}. The right foot stands when the push comes. Outward is towards "
        "the swing foot, inward is over the supporting foot to the other side. "
        f"Pushes start at these fractions of the step: {phases}. They last "
        f"{list_words(measured.push_durations)} s. The swing foot may move "
        f"{', and '.join(speeds)}; the same for every method.",
        "The limit is the largest impulse that any policy could survive that learns of the push "
        "when it starts, with the same steps, times and leg. The share is what a method survives, "
        "divided by the limit on the robot's finite foot. No method here knows when a push ends. "
        "Who does not has to be viable at every instant of it; where that limit is lower, the "
        "share of it says more. The limit on a point foot, and that of "
        "fixed steps saved by the ZMP alone, are shown beside it. One schedule of landings has to "
        "serve both axes.",
        "Times are per control cycle, one walk at a time. A "
        "method that decides less often than in every cycle repeats its last decision in between: "
        "its median says little, its p99.9 is a decision.",
    ]


def cautions(measured: Comparison) -> list[str]:
    """What a reader of the numbers must know: holes, open ends, and limits that were passed."""
    words = []
    whole = len({cell.condition for cell in measured.cells})
    partial = [
        f"{method.label} ({len(measured.select(method=method.key))})"
        for method in measured.methods
        if len(measured.select(method=method.key)) < whole
    ]
    if partial:
        words.append(
            f"Not measured on all {whole} cells, marked {INCOMPLETE}: {', '.join(partial)}. "
            "Their means stand on the cells they have and do not compare directly."
        )
    unbroken = sum(cell.unbroken for cell in measured.cells)
    if unbroken:
        words.append(
            f"In {unbroken} cells nothing failed up to the largest impulse that was tried; these "
            "count with that impulse, and the share is a lower bound (≥)."
        )
    beyond = [c for c in measured.cells if c.survived > c.limit_finite * (1.0 + ROUNDING)]
    if beyond:
        worst = max(beyond, key=lambda cell: cell.survived / cell.limit_finite)
        words.append(
            f"In {len(beyond)} cells more was survived than the limit allows, at most "
            f"{worst.survived:g} N s against {worst.limit_finite:.4g} N s; these count as 100 %."
        )
    return words

"""What a comparison says: tables of all methods, how it was measured, what a reader must know."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from functools import partial

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.studies.compare.figures import fraction_figure, polar_figure
from surefoot.studies.compare.page import page_data
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import (
    Choice,
    Score,
    choose,
    impulse_words,
    score,
    situation,
    survived,
    unbroken,
)
from surefoot.studies.engine.report import (
    Details,
    Figure,
    Interactive,
    Part,
    Report,
    Table,
    Text,
    provenance,
)
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import Row, select, values
from surefoot.studies.engine.words import (
    RECOVERED_WORDS,
    angle_words,
    count_words,
    list_words,
    percent,
    speed_words,
    time_words,
)

HEADING = "How hard a push each method survives"

COLUMNS = (
    "method",
    "adapts",
    "mean",
    "worst",
    "causal",
    *(f"{name} [N s]" for name in DIRECTIONS),
    "fell",
    "unsettled",
    "cycle p50",
    "p99.9",
    "cells",
)
"""Of the table; the limit has a row of its own, the last."""

LIMIT = "theoretical limit"

INCOMPLETE = "*"
"""Follows a mean that stands on fewer cells than were measured by others."""

ROUNDING = 1e-9
"""A limit that is passed by this fraction of it is reached."""

PAPER_HYBRID, PAPER_MPC = 85.0, 20.0
"""What the abstract of [OnlineGait] reports: its method, and MPC with foot placement [N s]."""

HYBRID, PLACEMENT = "hybrid", "foot-placement-mpc"


def comparison_report(measured: Measured[Comparison], choice: Choice | None = None) -> Report:
    """The report.

    Args:
        measured: what was measured.
        choice: the push that single numbers are of, and with which the page opens; that of
            `choose` if None.

    Raises:
        ParameterError: nothing was measured at the choice.
    """
    rows, methods = measured.rows, measured.notes["methods"]
    choice = choose(rows) if choice is None else choose(rows, **vars(choice))
    how = [Text(words) for words in [*protocol(rows), *cautions(measured)]]
    return Report(
        "compare",
        HEADING,
        (
            measured.provenance.get("robot", ""),
            measured.provenance.get("velocity", ""),
            count_words(len(methods), "method"),
            count_words(len(rows), "scan of pushes", "scans of pushes"),
        ),
        (
            Interactive.of("surefoot.studies.compare", page_data(measured, choice)),
            *(Text(words) for words in remarks(rows)),
            Details("What was measured, and how", how),
            Figure(
                "pictures/shares.png",
                "Mean and worst share of the limit for every leg speed, and the time that a "
                "control cycle takes: median and the time that 999 of 1000 cycles keep.",
                partial(fraction_figure, measured),
            ),
            Text(note(measured, choice)),
            *_leg_parts(measured, choice),
            Details("Where methods fail by not settling", [unsettled_part(measured)]),
            Details(
                "The methods",
                [
                    Table(
                        "",
                        "",
                        ("method", "adapts", "what it cannot use", "source"),
                        [(m["label"], m["adapts"], m["cannot"], m["source"]) for m in methods],
                    )
                ],
            ),
            provenance(measured.provenance),
        ),
    )


def _leg_parts(measured: Measured[Comparison], choice: Choice) -> Iterator[Part]:
    """A table for each leg speed, and the map that the page draws itself."""
    for leg_speed in values(measured.rows, "leg_speed"):
        yield comparison_table(measured, leg_speed, choice)
        duration = choice.push_duration
        if select(measured.rows, leg_speed=leg_speed, push_duration=duration):
            yield Figure(
                f"pictures/map-{re.sub('[^0-9a-z]', '_', f'{leg_speed:g}')}.png",
                f"{speed_words(leg_speed).capitalize()}, pushes of {duration:g} s: the largest "
                "survived impulse in every direction, from above, forward up; the dark outline is "
                "the theoretical limit.",
                partial(polar_figure, measured, leg_speed, duration),
                page="none",
            )


def comparison_table(measured: Measured[Comparison], leg_speed: float, choice: Choice) -> Table:
    """All methods at one leg speed, in the columns `COLUMNS`.

    Means, worst cells and failures are over everything that was measured at that leg speed; the
    smallest failing impulses are those of the push duration and phase of the choice.
    """
    rows = select(measured.rows, leg_speed=leg_speed)
    at = {
        (row["method"], row["angle"]): row
        for row in select(rows, push_duration=choice.push_duration, phase=choice.phase)
    }
    lines = []
    for method in measured.notes["methods"]:
        found = score(method["key"], rows)
        star = "" if found.complete or not found.cells else INCOMPLETE
        lines.append(
            (
                method["label"],
                method["adapts"],
                mean_words(found),
                percent(found.worst) + star,
                percent(found.causal) + star,
                *(impulse_words(at.get((method["key"], a))) for a in DIRECTIONS.values()),
                str(found.fell) if found.cells else "–",
                str(found.unsettled) if found.cells else "–",
                time_words(method["decision_p50"]),
                time_words(method["decision_p99_9"]),
                str(found.cells) if found.complete else f"{found.cells} of {found.possible}",
            )
        )
    limits = {angle: f"{row['limit_finite']:.1f}" for (_, angle), row in at.items()}
    around = [limits.get(angle, "–") for angle in DIRECTIONS.values()]
    lines.append((LIMIT, "everything", "100 %", "100 %", "", *around, "", "", "", "", ""))
    return Table(speed_words(leg_speed).capitalize(), "", COLUMNS, lines)


def mean_words(found: Score) -> str:
    """A mean share of the limit, with ≥ and * where they belong."""
    if math.isnan(found.mean):
        return "–"
    least = "≥ " if found.at_least else ""
    return f"{least}{percent(found.mean)}{'' if found.complete else INCOMPLETE}"


def note(measured: Measured[Comparison], choice: Choice) -> str:
    """How the tables are read."""
    words = (
        "Mean and worst: what is survived as a share of the limit, over all cells of a leg speed; "
        "causal: the mean share of what can be survived without knowing when the push ends. "
        f"{', '.join(DIRECTIONS).capitalize()}: the smallest failing impulse [N s] of a push of "
        f"{choice.push_duration:g} s at phase {choice.phase:.3g}; – was not measured."
    )
    scores = [
        score(method["key"], select(measured.rows, leg_speed=leg_speed))
        for method in measured.notes["methods"]
        for leg_speed in values(measured.rows, "leg_speed")
    ]
    if not all(found.complete for found in scores):
        words += (
            f" {INCOMPLETE} stands on fewer cells than others: such a mean does not compare "
            "directly."
        )
    if any(found.at_least for found in scores):
        words += " ≥ where nothing failed up to the largest impulse that was tried."
    return words


def unsettled_part(measured: Measured[Comparison]) -> Part:
    """Where the smallest failing push left the robot walking, but not on its gait."""
    lines = []
    for method in measured.notes["methods"]:
        own = select(measured.rows, method=method["key"])
        unsettled = select(own, failure="unsettled")
        if not unsettled:
            continue
        angles = values(unsettled, "angle")
        where = ", ".join(
            f"{angle_words(angle)} ({len(select(unsettled, angle=angle))})" for angle in angles[:12]
        ) + (f" and {len(angles) - 12} directions more" if len(angles) > 12 else "")
        lines.append((method["label"], f"{len(unsettled)} of {len(own)}", where))
    if not lines:
        return Text("Nowhere: every failing push made the robot fall.")
    return Table("", "", ("method", "cells", "directions"), lines)


def protocol(rows: Sequence[Row]) -> list[str]:
    """What was measured and how, a paragraph each."""
    angles, phases = values(rows, "angle"), values(rows, "phase")
    directions = (
        f"{len(angles)} directions, every {360.0 / len(angles):g}°"
        if len(angles) > 4
        else ", ".join(angle_words(angle) for angle in angles)
    )
    around = list_words([round(phase, 3) for phase in phases])
    if len(phases) > 10:
        around = f"{len(phases)} from {phases[0]:.3g} to {phases[-1]:.3g}"
    leg_speeds = values(rows, "leg_speed")
    finite = [speed for speed in leg_speeds if math.isfinite(speed)]
    speeds = [f"at {list_words(finite)} m/s"] if finite else []
    speeds += ["without limit"] if len(finite) < len(leg_speeds) else []
    return [
        "A robot that walks steadily is pushed once, harder in every run: the impulse is scanned "
        f"upwards in steps of {list_words(values(rows, 'step'))} N s, until the robot does not "
        "recover. Survival is not monotone in the impulse, so nothing is bisected: the smallest "
        "failing impulse ends the scan, and what is survived is the largest impulse below it.",
        f"{RECOVERED_WORDS} A robot that keeps walking but does not come back has failed too; it "
        "is counted apart, as not settled.",
        f"Directions: {directions}. The right foot stands when the push comes. Outward is towards "
        "the swing foot, inward is over the supporting foot to the other side. "
        f"Pushes start at these fractions of the step: {around}. They last "
        f"{list_words(values(rows, 'push_duration'))} s. The swing foot may move "
        f"{', and '.join(speeds)}; the same for every method.",
        "The theoretical limit is the largest impulse that a robot with the same steps, times and "
        "leg could survive if its controller learned of the push when it starts. The share is what "
        "a method survives, divided by the limit on the robot's finite foot. No method here knows "
        "when a push ends. "
        "Who does not has to be viable at every instant of it; where that limit is lower, the "
        "share of it says more. The limit on a point foot, and that of "
        "fixed steps saved by the ZMP alone, are shown beside it. One schedule of landings has to "
        "serve both axes.",
        "Times are per control cycle, one walk at a time. A "
        "method that decides less often than in every cycle repeats its last decision in between: "
        "its median says little, its p99.9 is a decision.",
    ]


def cautions(measured: Measured[Comparison]) -> list[str]:
    """What a reader of the numbers must know: holes, open ends, and limits that were passed."""
    rows, words = measured.rows, []
    whole = len({situation(row) for row in rows})
    counts = {m["label"]: len(select(rows, method=m["key"])) for m in measured.notes["methods"]}
    partial = [f"{label} ({count})" for label, count in counts.items() if count < whole]
    if partial:
        words.append(
            f"Not measured on all {whole} cells, marked {INCOMPLETE}: {', '.join(partial)}. "
            "Their means stand on the cells they have and do not compare directly."
        )
    open_ends = sum(map(unbroken, rows))
    if open_ends:
        words.append(
            f"In {open_ends} cells nothing failed up to the largest impulse that was tried; these "
            "count with that impulse, and the share is a lower bound (≥)."
        )
    beyond = [row for row in rows if survived(row) > row["limit_finite"] * (1.0 + ROUNDING)]
    if beyond:
        worst = max(beyond, key=lambda row: survived(row) / row["limit_finite"])
        words.append(
            f"In {len(beyond)} cells more was survived than the limit allows, at most "
            f"{survived(worst):g} N s against {worst['limit_finite']:.4g} N s; these count as "
            "100 %."
        )
    return words


def remarks(rows: Iterable[Row]) -> list[str]:
    """Paragraphs on the paper's claim, from what was measured; none if a side of it is missing.

    Args:
        rows: of a comparison, see `studies.compare.measure`.
    """
    rows = list(rows)
    said = [_on_leg(rows, speed) for speed in sorted({row["leg_speed"] for row in rows})]
    said = [text for text in said if text]
    if not said:
        return []
    opening = (
        f"The paper reports that its hybrid survives {PAPER_HYBRID:g} N s where MPC with foot "
        f"placement alone survives {PAPER_MPC:g} N s, a ratio of {PAPER_HYBRID / PAPER_MPC:.1f}: "
        "one direction, one moment, a leg of unlimited speed, and a rival that is not described. "
        "Under one protocol, with the rival at its best, it becomes:"
    )
    return [opening, *said]


def _on_leg(rows: list[Row], leg_speed: float) -> str:
    parts = []
    for name, angle in DIRECTIONS.items():
        pairs = _pairs(rows, leg_speed, angle)
        if not pairs:
            continue
        ours, theirs = zip(*pairs, strict=True)
        wins = sum(a > b for a, b in pairs)
        parts.append(
            f"{name} {_range(ours)} against {_range(theirs)} N s ({_ratio(pairs)}the hybrid "
            f"is ahead in {wins} of {len(pairs)} cells)"
        )
    if not parts:
        return ""
    leg = "a leg of unlimited speed" if math.isinf(leg_speed) else f"a leg of {leg_speed:g} m/s"
    return f"With {leg}: {'; '.join(parts)}."


def _pairs(rows: list[Row], leg_speed: float, angle: float) -> list[tuple[float, float]]:
    """Smallest failing impulses of both methods, cell by cell where both were measured [N s]."""
    found: dict[tuple[float, float], dict[str, float]] = {}
    for row in rows:
        here = row["leg_speed"] == leg_speed and row["angle"] == angle
        if here and row["method"] in (HYBRID, PLACEMENT):
            cell = (row["phase"], row["push_duration"])
            found.setdefault(cell, {})[row["method"]] = row["impulse"]
    return [(both[HYBRID], both[PLACEMENT]) for both in found.values() if len(both) == 2]


def _ratio(pairs: list[tuple[float, float]]) -> str:
    """The geometric mean of the ratios, where all of them are numbers."""
    if any(not 0.0 < value < math.inf for pair in pairs for value in pair):
        return ""
    mean = math.exp(sum(math.log(a / b) for a, b in pairs) / len(pairs))
    return f"ratio {mean:.2f}; "


def _range(values: Iterable[float]) -> str:
    values = list(values)
    low, high = (f"{value:g}" if value < math.inf else "no" for value in (min(values), max(values)))
    return low if low == high else f"{low}–{high}"

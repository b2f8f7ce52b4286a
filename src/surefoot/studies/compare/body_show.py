"""What was measured on bodies, in words: reports of pushes and of disturbed walks."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from functools import partial

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.studies.compare.body_figures import (
    AIM,
    WALKED_THROUGH,
    push_figure,
    walk_figure,
    walk_title,
)
from surefoot.studies.compare.body_question import BodyPushes, BodyWalks
from surefoot.studies.compare.scores import impulse_words, unbroken
from surefoot.studies.engine.report import Details, Figure, Part, Report, Table, Text, provenance
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import Row, select
from surefoot.studies.engine.words import count_words

MISSING = "–"
"""Where there is no number."""

SHOWN_LIMITS = 6
"""So many active limits are named of a push."""

LATEST = "latest landing"
"""How much later than planned the last of the landings was; negative if all were early."""

USED = {
    "friction used": ("friction", 1.0, ""),
    "largest torque over its limit": ("torque", 100.0, " %"),
    "largest joint speed over its limit": ("speed", 100.0, " %"),
    "least knee bend": ("knee", math.degrees(1.0), "°"),
    "largest landing error": ("landing off by", 100.0, " cm"),
    LATEST: ("", 1000.0, " ms"),
    "largest tilt of the trunk": ("tilt", math.degrees(1.0), "°"),
}
"""Words, factor and unit of what was used, by its name in `engine.body_recovery.used_after`."""

WALK_COLUMNS = (
    "disturbance", "walked", "DCM [mm]", "estimate [mm]", "course [mm]", "heading [mrad]"
)  # fmt: skip

WALK_NOTE = (
    "Of every number the walk in which it is worst: root mean squares while walking of the DCM "
    "against its plan, and of its estimate against the truth, both relative to the standing foot; "
    "in the end, the middle of the feet beside the course and the base away from its heading. All "
    "at once are the delay, 10 % more mass, the payload, friction 0.4 and bumps. A time is "
    "that of a fall."
)


def push_report(measured: Sequence[Measured[BodyPushes]], explained: Sequence[Row] = ()) -> Report:
    """The report of pushes.

    Args:
        measured: of one robot each.
        explained: what bound in single pushes, see `body_measure.explain_worst`.
    """
    parts: list[Part] = []
    for one in measured:
        robot = one.study.robot.name
        parts.append(push_table(one))
        parts.append(
            Figure(
                f"{robot}/pushes.png",
                f"Δv over phase, direction and foot, {robot}",
                partial(push_figure, one),
            )
        )
        own = [entry for entry in explained if entry["robot"] == robot]
        if own:
            parts.append(explained_table(one, own))
        parts.append(Details(f"Every scan: {robot}", [every_scan(one)], folded=True))
    words = [Text(paragraph) for paragraph in _protocol_words(measured[0])]
    methods = {key for one in measured for key in one.study.methods}
    return Report(
        "pushes",
        "How much push a body survives",
        (
            ", ".join(one.study.robot.name for one in measured),
            count_words(len(methods), "method"),
            count_words(sum(len(m.rows) for m in measured), "scan of pushes", "scans of pushes"),
        ),
        (*parts, Details("What was measured, and how", words), *_provenances(measured)),
    )


def _protocol_words(measured: Measured[BodyPushes]) -> list[str]:
    """What was measured and how, in paragraphs."""
    study, about = measured.study, measured.provenance
    return [
        f"A robot that walks at {about['velocity']} is pushed once on its base, for 0.2 s "
        f"beginning at {count_words(study.phases, 'phase')} of a step, once while the left foot "
        "stands and once while the right one does. The impulse is scanned upwards from zero in "
        f"steps of {study.step:g} N s, never bisected: the smallest that it does not survive ends "
        "the scan. Outward is towards the swing foot, inward towards the foot on the ground.",
        "Survived means that for 5 s after the push nothing but the soles touches the floor, the "
        "legs do not touch each other, the trunk leans less than 0.8 rad and stays above 65 % of "
        "its height, and the robot goes on stepping. Motors have limits of torque, speed and "
        "position. A cause is what went wrong first in the last second before the fall.",
        f"Δv is the impulse over the mass, {study.mass:.4g} kg. The aim is that of the paper, "
        f"85 N s on 70 kg: {AIM:.2f} m/s. With timing fixed a step lasts as long as nominal to "
        "5 ms, with place fixed it lands where nominal to 5 mm; both are the unified controller "
        "with a narrower box of steps.",
        f"State that the controllers are given: {about['state']}.",
    ]


def push_table(measured: Measured[BodyPushes]) -> Table:
    """Method by method: the worst push of every direction, and what the falls came from."""
    study, rows = measured.study, []
    for one in measured.notes["methods"]:
        own = select(measured.rows, method=one["key"])
        if own:
            worst = (_worst_push(select(own, direction=direction)) for direction in DIRECTIONS)
            causes = Counter(row["cause"] for row in own if row["cause"])
            rows.append((one["label"], *worst, _mean_words(own), cause_words(causes)))
    return Table(
        f"{study.robot.name}, {study.mass:.3g} kg, at {measured.provenance['velocity']}",
        "Smallest push of 0.2 s on the base that it does not survive, N s (and Δv in m/s): the "
        f"worst of {count_words(study.phases, 'phase')} and 2 feet; every smaller one on the grid "
        f"of {study.step:g} N s is survived. The aim is a Δv of {AIM:.2f} m/s, as 85 N s on 70 kg. "
        f"State: {measured.provenance['state']}.",
        ("method", *DIRECTIONS, "mean Δv", "causes of the falls"),
        rows,
    )


def _worst_push(rows: Sequence[Row]) -> str:
    return _push_words(min(rows, key=lambda row: row["impulse"], default=None))


def _push_words(row: Row | None) -> str:
    """The smallest failing push as N s and Δv."""
    delta_v = "" if row is None or unbroken(row) else f" ({row['delta_v']:.2f})"
    return impulse_words(row) + delta_v


def cause_words(causes: Counter[str]) -> str:
    """Causes with their counts, the most frequent first."""
    return ", ".join(f"{count} {cause}" for cause, count in causes.most_common()) or "none"


def _mean_words(rows: Sequence[Row]) -> str:
    values = [row["delta_v"] for row in rows]
    return f"{math.fsum(values) / len(values):.2f}" if max(values) < math.inf else MISSING


def every_scan(measured: Measured[BodyPushes]) -> Table:
    """All scans with the signs of their falls."""
    order = list(DIRECTIONS)
    rows = [
        (
            one["label"], row["direction"], row["foot"], f"{row['phase']:.3g}", _push_words(row),
            row["words"],
        )
        for one in measured.notes["methods"]
        for row in sorted(
            select(measured.rows, method=one["key"]),
            key=lambda row: (order.index(row["direction"]), row["foot"], row["phase"]),
        )
    ]  # fmt: skip
    columns = ("method", "direction", "foot", "phase", "N s (Δv)", "signs of the fall")
    return Table("", "", columns, rows)


def explained_table(measured: Measured[BodyPushes], explained: Sequence[Row]) -> Table:
    """What bound in the push that each method fails on first, direction by direction.

    Args:
        measured: the pushes, for names and order.
        explained: those of this robot, see `body_measure.explain_worst`.
    """
    labels = {one["key"]: one["label"] for one in measured.notes["methods"]}
    rows = [
        (
            labels[entry["cell"]["method"]],
            entry["cell"]["direction"],
            f"{entry['impulse']:g} N s at {entry['cell']['phase']:.3g}, {entry['cell']['foot']}",
            entry["cause"] or "it stopped stepping",
            "; ".join(map(_binding_words, entry["bindings"][:SHOWN_LIMITS])),
            "; ".join(
                used_words(name, entry["used"][name]) for name in USED if name in entry["used"]
            ),
        )
        for entry in explained
    ]
    return Table(
        f"What binds: {measured.study.robot.name}",
        "Of the smallest push that it fails on in the worst situation of each direction: part of "
        "the first second after the push began in which a limit was active (a multiplier of the "
        "quadratic program that is not zero, or what the controller says itself), where that is "
        "more than without the push; and the most that was used.",
        ("method", "direction", "push, phase, foot", "cause", "active limits", "used"),
        rows,
        names=2,
    )


def _binding_words(one: Row) -> str:
    usual = f" (usually {100.0 * one['usual']:.0f})" if one["usual"] >= 0.005 else ""
    return f"{one['name']} {100.0 * one['share']:.0f} %{usual}"


def used_words(name: str, value: float) -> str:
    """How much of something was used, in words; `USED` has the names."""
    word, factor, unit = USED[name]
    if name == LATEST:
        return f"landing {abs(factor * value):.3g}{unit} {'early' if value < 0.0 else 'late'}"
    return f"{word} {factor * value:.3g}{unit}"


def walk_report(measured: Sequence[Measured[BodyWalks]]) -> Report:
    """The report of disturbed walks."""
    caption = "Every walk: how far the DCM was off, or that it fell"
    parts: list[Part] = [Text(WALK_NOTE)]
    parts.append(Figure("walks.png", caption, partial(walk_figure, measured)))
    for one in measured:
        parts += [walk_table(one, method) for method in one.study.methods]
        if not all(row["walked"] for row in one.rows):
            parts.append(falls_table(one))
    return Report(
        "walks",
        WALKED_THROUGH,
        (
            ", ".join(one.study.robot.name for one in measured),
            count_words(sum(len(one.rows) for one in measured), "walk"),
        ),
        (*parts, *_provenances(measured)),
    )


def walk_table(measured: Measured[BodyWalks], method: str) -> Table:
    """How a method walked under every disturbance."""
    rows = []
    for one in measured.notes["conditions"]:
        walks = select(measured.rows, method=method, condition=one["key"])
        words = (
            _walked(walks),
            _worst(walks, "dcm_error"),
            _worst(walks, "estimate_error", 1),
            _worst(walks, "drift"),
            _worst(walks, "heading"),
        )
        rows.append((one["label"], *words))
    note = measured.provenance["walks"]
    return Table(walk_title(measured, method), f"{note}.", WALK_COLUMNS, rows)


def _walked(walks: Sequence[Row]) -> str:
    if not walks:
        return MISSING
    fell = ", ".join(f"{row['time']:.1f} s" for row in walks if not row["walked"])
    stood = f"{sum(row['walked'] for row in walks)} of {len(walks)}"
    return f"{stood}; {fell}" if fell else stood


def _worst(walks: Sequence[Row], name: str, digits: int = 0) -> str:
    """The largest one, in thousandths; of a walk that fell it does not count where it ended."""
    values = [abs(row[name]) for row in walks if row["walked"] and not math.isnan(row[name])]
    return f"{1e3 * max(values):.{digits}f}" if values else MISSING


def falls_table(measured: Measured[BodyWalks]) -> Table:
    """Why walks ended before their time."""
    methods = {one["key"]: one["label"] for one in measured.notes["methods"]}
    conditions = {one["key"]: one["label"] for one in measured.notes["conditions"]}
    rows = []
    for row in measured.rows:
        if not row["walked"]:
            method = f", {methods[row['method']]}" if len(methods) > 1 else ""
            disturbance = f"{conditions[row['condition']]}{method}"
            rows.append((disturbance, f"{row['seed']}", f"{row['time']:.1f} s", row["words"]))
    columns = ("disturbance", "seed", "after", "signs")
    return Table(f"Why {measured.study.robot.name} fell", "", columns, rows)


def _provenances(measured: Sequence[Measured]) -> list[Details]:
    return [provenance(m.provenance, f"Provenance of {m.study.robot.name}") for m in measured]

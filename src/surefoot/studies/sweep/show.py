"""What a sweep shows: how its cells came out, the cells themselves if they are few, a picture."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

from surefoot.studies.engine.report import Details, Figure, Report, Table, Text, word_table
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import without_infinity
from surefoot.studies.sweep.axes import quantity_name
from surefoot.studies.sweep.measure import RESULTS
from surefoot.studies.sweep.pictures import sweep_figure
from surefoot.studies.sweep.question import Sweep

MAX_ROWS = 40
"""A table that is longer is for a file."""

MAX_ERRORS = 4
"""So many reasons why cells have no result are shown, the frequent ones first."""


def report(measured: Measured[Sweep], name: str | None = None) -> Report:
    """All of a sweep.

    Args:
        measured: the sweep.
        name: column that is drawn; the smallest failing impulse or who survived, if None.
    """
    rows, study = measured.rows, measured.study
    drawn = RESULTS[study.measures][quantity_name(study.measures, name)].words
    counts = Counter(row["outcome"] for row in rows)
    words = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    errors = Counter(row["error"] for row in rows if row["error"] is not None)
    reasons = [f"{count} x {error}" for error, count in errors.most_common(MAX_ERRORS)]
    about = measured.provenance
    return Report(
        name=study.NAME,
        heading=study.title,
        origin=(study.robot.name, study.controller, study.sampling),
        parts=[
            Text(f"{len(rows)} cells: {words}"),
            *map(Text, reasons),
            *([_cell_table(measured)] if len(rows) <= MAX_ROWS else []),
            Figure(
                f"{study.NAME}.png",
                f"{drawn[:1].upper()}{drawn[1:]}, over {', '.join(study.vary)}",
                lambda: sweep_figure(measured, name),
            ),
            Details("Provenance", [word_table(("what", "value"), about)]),
        ],
    )


def _cell_table(measured: Measured[Sweep]) -> Table:
    study = measured.study
    shown = {name: one.head for name, one in RESULTS[study.measures].items() if one.head}
    rows = [[_word(row[name]) for name in (*study.vary, *shown)] for row in measured.rows]
    return Table("", "", (*study.vary, *shown.values()), rows, names=len(study.vary))


def _word(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)) or value == -1:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def as_numbers(measured: Measured[Sweep]) -> dict[str, Any]:
    """For JSON; infinity and NaN are null."""
    return {
        "title": measured.study.title,
        "varied": list(measured.study.vary),
        "rows": without_infinity(measured.rows),
        "failures": len(measured.failures),
        "provenance": measured.provenance,
    }

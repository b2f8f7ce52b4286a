"""A sweep in the terminal and for JSON: how its cells came out, and the cells if they are few."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

from rich.console import Console
from rich.table import Table

from surefoot.studies.engine.cells import without_infinity
from surefoot.studies.engine.study import Measured
from surefoot.studies.sweep.measure import RESULTS
from surefoot.studies.sweep.question import Sweep

MOST_ROWS = 40
"""A table that is longer is for a file."""


def print_sweep(measured: Measured[Sweep], console: Console) -> None:
    """Print how the cells came out, and the cells themselves if they are few."""
    rows, study = measured.rows, measured.study
    counts = Counter(row["outcome"] for row in rows)
    words = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    console.print(f"[bold]{study.title}[/bold]: {len(rows)} cells: {words}", highlight=False)
    for error, count in Counter(row.get("error") for row in rows).most_common(4):
        if error is not None:
            console.print(f"  {count} x {error}", highlight=False, markup=False)
    if len(rows) > MOST_ROWS:
        return
    shown = {name: one.head for name, one in RESULTS[study.measures].items() if one.head}
    table = Table(box=None, pad_edge=False)
    for name in (*study.vary, *shown.values()):
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(*(_word(row.get(name)) for name in (*study.vary, *shown)))
    console.print(table)


def _word(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)) or value == -1:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def as_numbers(measured: Measured[Sweep]) -> dict[str, Any]:
    """For JSON; what is infinite or no number is null."""
    return {
        "title": measured.study.title,
        "varied": list(measured.study.vary),
        "rows": without_infinity(measured.rows),
        "failures": len(measured.failures),
        "provenance": measured.provenance,
    }

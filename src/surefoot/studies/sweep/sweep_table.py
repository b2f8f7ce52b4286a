"""A sweep in the terminal: how its cells came out, and the cells themselves if they are few."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

MOST_ROWS = 40
"""A table that is longer is for a file."""

SHOWN = ("outcome", "impulse", "delta_v", "share", "recovery_steps", "margin", "dcm_error")
"""Columns of results, as far as there are any."""

HEADS = {
    "impulse": "fails at [N s]", "delta_v": "[m/s]", "share": "of the limit",
    "recovery_steps": "steps back", "margin": "margin [m]", "dcm_error": "DCM error [m]",
}  # fmt: skip


def print_sweep(
    rows: Sequence[dict[str, Any]], varied: Sequence[str], title: str, console: Console
) -> None:
    """Print a sweep.

    Args:
        rows: of its table.
        varied: names of the parameters that differ.
        title: of the study.
        console: where to.
    """
    counts = Counter(row["outcome"] for row in rows)
    words = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    console.print(f"[bold]{title}[/bold]: {len(rows)} cells: {words}", highlight=False)
    for error, count in Counter(row.get("error") for row in rows).most_common(4):
        if error is not None:
            console.print(f"  {count} x {error}", highlight=False, markup=False)
    if len(rows) > MOST_ROWS:
        return
    shown = [name for name in SHOWN if any(row.get(name) is not None for row in rows)]
    table = Table(box=None, pad_edge=False)
    for name in (*varied, *(HEADS.get(name, name) for name in shown)):
        table.add_column(name, justify="right")
    for row in rows:
        table.add_row(*(_word(row.get(name)) for name in (*varied, *shown)))
    console.print(table)


def _word(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)) or value == -1:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)

"""How gently pushes are answered, as a table of plain numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from surefoot.studies.engine.words import speed_words

QUANTITIES = {
    "zmp_peak": "ZMP peak [mm]",
    "zmp_rms": "ZMP RMS [mm]",
    "landing": "landing [mm]",
    "timing": "timing [ms]",
}
"""What is measured, as headings: each in thousandths."""


def print_gentleness(numbers: Sequence[dict[str, Any]], console: Console) -> None:
    """Mean and largest answer of both methods, and in how many cells the first one's is larger.

    Args:
        numbers: of `Gentleness.as_numbers`, one for each leg and impulse.
        console: where to print.
    """
    for leg_speed in dict.fromkeys(entry["leg_speed"] for entry in numbers):
        rows = [entry for entry in numbers if entry["leg_speed"] == leg_speed]
        first = next(iter(rows[0]["methods"]))
        speed = float("inf") if leg_speed is None else leg_speed
        console.print(f"\n[bold]{speed_words(speed).capitalize()}[/]: mean, largest")
        table = Table(box=None, pad_edge=False, header_style="bold")
        table.add_column("push", justify="right", no_wrap=True)
        table.add_column("method", no_wrap=True)
        for heading in QUANTITIES.values():
            table.add_column(heading, justify="right", no_wrap=True)
        for entry in rows:
            for key, values in entry["methods"].items():
                cells = [
                    f"{1e3 * values[name]['mean']:.1f} {1e3 * values[name]['largest']:6.1f}"
                    for name in QUANTITIES
                ]
                table.add_row(f"{entry['impulse']:g} N s" if key == first else "", key, *cells)
            larger = entry[f"{first}_larger"]
            of = entry["cells"]
            counts = [f"{larger[name]} of {of}" for name in QUANTITIES]
            table.add_row("", f"{first} larger in", *counts, style="dim")
        console.print(table)

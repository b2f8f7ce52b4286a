"""One measured figure, and the table and file that show them all."""

from __future__ import annotations

import json
import os
import platform
import sys
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

PACKAGES = ("surefoot", "numpy", "numba", "quadprog", "daqp", "piqp")
"""Packages whose versions head the output."""

_TIMES = ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (0.0, "ns"))


@dataclass(frozen=True)
class Figure:
    """One row of the table.

    Attributes:
        what: what was measured.
        p50: its median.
        unit: "s", "1/s", "MB" or "" for a pure number.
        p999: its 99.9th percentile, where there are enough samples to have one.
        target: what p50 should reach.
        target_p999: what p999 should reach.
        more_is_better: the target is a minimum rather than a maximum.
        ratio: p50 over that of our compiled solve, both taken in the same moments.
        judged: False if the machine was too busy for a verdict.
    """

    what: str
    p50: float
    unit: str = "s"
    p999: float | None = None
    target: float | None = None
    target_p999: float | None = None
    more_is_better: bool = False
    ratio: float | None = None
    judged: bool = True

    @property
    def verdict(self) -> str:
        """Whether the targets are met; empty if there is none."""
        if self.target is None:
            return ""
        met = self.p50 >= self.target if self.more_is_better else self.p50 <= self.target
        if self.target_p999 is not None and self.p999 is not None:
            met = met and self.p999 <= self.target_p999
        return "meets" if met else "falls short" if self.judged else "machine busy"


@dataclass
class Report:
    """What one run found.

    Attributes:
        figures: the rows of the table.
        facts: what is not a figure, by name: lines for the foot of the table.
        extra: the numbers behind the facts, for the JSON file.
    """

    figures: list[Figure] = field(default_factory=list)
    facts: dict[str, str] = field(default_factory=dict)
    extra: dict[str, Any] = field(default_factory=dict)

    def write(self, path: Path) -> None:
        """Write everything as JSON; times in seconds."""
        rows = [{**asdict(figure), "verdict": figure.verdict} for figure in self.figures]
        about = {"machine": machine(), "figures": rows, "facts": self.facts, **self.extra}
        path.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")

    def show(self, console: Console) -> None:
        """Print machine, table and facts."""
        about = machine()
        console.print(f"{about['cpu']}, {about['cores']} cores, {about['system']}")
        console.print(", ".join(f"{name} {number}" for name, number in about["versions"].items()))
        table = Table(title="Speed: figures of one run")
        table.add_column("what", overflow="fold")
        for column in ("p50", "p99.9", "target"):
            table.add_column(column, justify="right", no_wrap=True)
        table.add_column("ratio to our\ncompiled solve", justify="right")
        table.add_column("verdict", no_wrap=True)
        for figure in self.figures:
            table.add_row(*_cells(figure))
        console.print(table)
        for name, text in self.facts.items():
            console.print(f"{name}: {text}", highlight=False)
        console.print(
            "Times are comparable within one run only: on a busy machine all of them change "
            "together. Ratios are taken round by round and comparable between runs."
        )


def machine() -> dict[str, Any]:
    """CPU, cores, system and versions."""
    return {
        "cpu": _cpu_model(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "versions": {
            "Python": sys.version.split()[0],
            **{name: version(name) for name in PACKAGES},
        },
    }


def in_words(value: float | None, unit: str = "s") -> str:
    """A value with three digits and a fitting unit, M/s for millions a second; a dash for none."""
    if value is None:
        return "-"
    if unit == "1/s":
        return f"{value * 1e-6:.3g} M/s"
    if unit != "s":
        return f"{value:.3g} {unit}".strip()
    scale, name = next(pair for pair in _TIMES if value >= pair[0])
    return f"{value / (scale or 1e-9):.3g} {name}"


def _cells(figure: Figure) -> tuple[str, ...]:
    """The cells of one row."""
    target = in_words(figure.target, figure.unit)
    if figure.target is not None:
        target = f"{'≥' if figure.more_is_better else '≤'} {target}"
    if figure.target_p999 is not None:
        target += f", ≤ {in_words(figure.target_p999, figure.unit)}"
    style = {"meets": "green", "falls short": "red"}.get(figure.verdict, "default")
    return (
        figure.what,
        in_words(figure.p50, figure.unit),
        in_words(figure.p999, figure.unit),
        target,
        "-" if figure.ratio is None else f"{figure.ratio:.3g}",
        f"[{style}]{figure.verdict}[/{style}]",
    )


def _cpu_model() -> str:
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown processor"

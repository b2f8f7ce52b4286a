"""Walks of a body while something is wrong, as numbers to be shown, as tables and in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table as TerminalTable

from surefoot.show.plain_table import Table

MISSING = "–"
"""Where there is no number."""

COLUMNS = (
    "what is wrong", "walked", "DCM [mm]", "estimate [mm]", "course [mm]", "heading [mrad]"
)  # fmt: skip

NOTE = (
    "Of every number the walk in which it is worst: root mean squares while walking of the DCM "
    "against its plan, and of its estimate against the truth, both seen from the standing foot; "
    "in the end, the middle of the feet beside the course and the base away from its heading. All "
    "at once are the delay, 10 % more mass, the payload, friction 0.4 and bumps. A time is "
    "that of a fall."
)


@dataclass(frozen=True)
class OneWalk:
    """A walk; see `studies.compare.body_robustness.measure_walk`."""

    method: str
    condition: str
    seed: int
    walked: bool
    time: float
    cause: str
    words: str
    dcm_error: float
    estimate_error: float
    drift: float
    heading: float
    speed: float


@dataclass(frozen=True)
class BodyWalks:
    """All walks of a robot.

    Attributes:
        robot: its name.
        walks: in the order in which they were asked for.
        methods, conditions: (key, label) in the order in which they are shown.
        provenance: what the table says of itself.
    """

    robot: str
    walks: tuple[OneWalk, ...]
    methods: tuple[tuple[str, str], ...]
    conditions: tuple[tuple[str, str], ...]
    provenance: Mapping[str, str]

    def of(self, method: str, condition: str) -> list[OneWalk]:
        """The walks of a method under a condition."""
        return [one for one in self.walks if (one.method, one.condition) == (method, condition)]

    @property
    def falls(self) -> list[OneWalk]:
        """Walks that ended before their time."""
        return [one for one in self.walks if not one.walked]

    def title(self, method: str) -> str:
        """The robot, and the method if there are several."""
        label = dict(self.methods)[method]
        return self.robot if len(self.methods) == 1 else f"{self.robot}, {label}"


def body_walks(
    rows: Sequence[Mapping[str, Any]],
    methods: Sequence[Mapping[str, str]],
    conditions: Sequence[Mapping[str, str]],
    provenance: Mapping[str, str],
) -> BodyWalks:
    """Rows of `studies.compare.body_robustness`, as what is shown of them.

    Args:
        rows: one for each walk.
        methods, conditions: `key` and `label` of each.
        provenance: what the table says of itself.
    """
    names = [one.name for one in fields(OneWalk)]
    return BodyWalks(
        provenance.get("robot", ""),
        tuple(OneWalk(**{name: row[name] for name in names}) for row in rows),
        tuple((one["key"], one["label"]) for one in methods),
        tuple((one["key"], one["label"]) for one in conditions),
        dict(provenance),
    )


def walk_table(measured: BodyWalks, method: str) -> Table:
    """How a method walked under every condition."""
    rows = []
    for key, label in measured.conditions:
        walks = measured.of(method, key)
        if not walks:
            rows.append((label, *[MISSING] * (len(COLUMNS) - 1)))
            continue
        rows.append(
            (
                label,
                _walked(walks),
                _worst(walks, lambda one: one.dcm_error),
                _worst(walks, lambda one: one.estimate_error, 1),
                _worst(walks, lambda one: one.drift),
                _worst(walks, lambda one: one.heading),
            )
        )
    return Table(measured.title(method), NOTE, COLUMNS, rows)


def _walked(walks: Sequence[OneWalk]) -> str:
    stood = sum(one.walked for one in walks)
    if stood == len(walks):
        return f"{stood} of {len(walks)}"
    fell = ", ".join(f"{one.time:.1f} s" for one in walks if not one.walked)
    return f"{stood} of {len(walks)}; {fell}"


def _worst(walks: Sequence[OneWalk], of: Callable[[OneWalk], float], digits: int = 0) -> str:
    """The largest one, in thousandths; a walk that fell is not asked where it ended."""
    values = [abs(of(one)) for one in walks if one.walked and not math.isnan(of(one))]
    return f"{1e3 * max(values):.{digits}f}" if values else MISSING


def falls_table(measured: BodyWalks) -> Table:
    """Why walks ended before their time."""
    labels = dict(measured.conditions) | dict(measured.methods)
    rows = [
        (
            f"{labels[one.condition]}, {labels[one.method]}" if len(measured.methods) > 1
            else labels[one.condition],
            f"{one.seed}", f"{one.time:.1f} s", one.words,
        )
        for one in measured.falls
    ]  # fmt: skip
    columns = ("what is wrong", "seed", "after", "what was seen")
    return Table(f"Why {measured.robot} fell", "", columns, rows)


def print_body_walks(measured: BodyWalks, console: Console) -> None:
    """Print how it walked, and why it fell.

    Args:
        measured: the walks.
        console: where to print.
    """
    for method, _ in measured.methods:
        shown = walk_table(measured, method)
        console.print(f"[bold]{shown.title}[/], {measured.provenance.get('walks', '')}")
        table = TerminalTable(box=None, padding=(0, 1), pad_edge=False, header_style="bold")
        for number, column in enumerate(shown.columns):
            table.add_column(escape(column), justify="right" if number > 1 else "left")
        for row in shown.rows:
            table.add_row(*row)
        console.print(table)
    console.print(NOTE)
    for one in measured.falls:
        label = dict(measured.conditions)[one.condition]
        console.print(
            f"[bold]fell[/] ({label}, seed {one.seed}): {one.words}", soft_wrap=True,
            highlight=False,
        )  # fmt: skip

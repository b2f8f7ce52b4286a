"""What a comparison on bodies says: worst pushes and causes of falls, as numbers and words."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Console
from rich.table import Table as TerminalTable

from surefoot.show.plain_table import Table

DIRECTIONS = ("forward", "back", "stance side", "swing side")
"""In the order in which they are shown; the stance side is that of the foot on the ground."""

AIM = 85.0 / 70.0
"""The Δv of the paper's largest push, 85 N s on 70 kg [m/s]."""


@dataclass(frozen=True)
class Pushed:
    """One scan of pushes.

    Attributes:
        method: its key.
        direction: one of `DIRECTIONS`.
        phase: of the step, when the push began [-].
        foot: that stood, "left" or "right".
        impulse: the smallest that fails, inf if none did [N s].
        delta_v: the same over the mass [m/s].
        scanned: the largest that was tried [N s].
        cause: of the fall; empty if there was none.
        words: what was seen of it.
    """

    method: str
    direction: str
    phase: float
    foot: str
    impulse: float
    delta_v: float
    scanned: float
    cause: str
    words: str


@dataclass(frozen=True)
class BodyPushes:
    """A comparison on one robot.

    Attributes:
        robot: its name.
        mass: [kg].
        step: of the scans [N s].
        methods: (key, label, what it adapts), in the order in which they are shown.
        cells: every scan.
        provenance: where the numbers are from.
    """

    robot: str
    mass: float
    step: float
    methods: tuple[tuple[str, str, str], ...]
    cells: tuple[Pushed, ...]
    provenance: dict[str, str]

    def of(self, method: str, direction: str | None = None) -> list[Pushed]:
        """The scans of a method, in one direction or in all."""
        return [
            cell
            for cell in self.cells
            if cell.method == method and direction in (None, cell.direction)
        ]

    def worst(self, method: str, direction: str) -> Pushed | None:
        """The scan that fails first, over all phases and both feet; None if there is none."""
        return min(self.of(method, direction), key=lambda cell: cell.impulse, default=None)

    def causes(self, method: str) -> Counter[str]:
        """How often each cause ended a scan."""
        return Counter(cell.cause for cell in self.of(method) if cell.cause)


def body_pushes(
    rows: Sequence[dict[str, Any]],
    methods: Sequence[dict[str, str]],
    mass: float,
    step: float,
    provenance: dict[str, str],
) -> BodyPushes:
    """A comparison from plain data, as `studies.compare.body_compare` has it.

    Args:
        rows: of its table.
        methods: `key`, `label` and `adapts` of each.
        mass: of the robot [kg].
        step: of the scans [N s].
        provenance: where the numbers are from.
    """
    names = Pushed.__dataclass_fields__
    return BodyPushes(
        provenance["robot"],
        mass,
        step,
        tuple((one["key"], one["label"], one["adapts"]) for one in methods),
        tuple(Pushed(**{name: row[name] for name in names}) for row in rows),
        provenance,
    )


def impulse_words(cell: Pushed | None) -> str:
    """The smallest failing push as N s and Δv."""
    if cell is None:
        return "–"
    if math.isinf(cell.impulse):
        return f"> {cell.scanned:g}"
    return f"{cell.impulse:g} ({cell.delta_v:.2f})"


def cause_words(causes: Counter[str]) -> str:
    """Causes with their counts, the most frequent first."""
    return ", ".join(f"{count} {cause}" for cause, count in causes.most_common()) or "none"


def body_table(measured: BodyPushes) -> Table:
    """Method by method: the worst push of every direction, and what the falls came from."""
    phases = len({cell.phase for cell in measured.cells})
    feet = len({cell.foot for cell in measured.cells})
    rows = [
        (
            label,
            *(impulse_words(measured.worst(key, direction)) for direction in DIRECTIONS),
            _mean_words(measured.of(key)),
            cause_words(measured.causes(key)),
        )
        for key, label, _ in measured.methods
        if measured.of(key)
    ]
    state = measured.provenance.get("state", "")
    return Table(
        f"{measured.robot}, {measured.mass:.3g} kg, at {measured.provenance.get('velocity', '')}",
        f"Smallest push of 0.2 s on the base that it does not survive, N s (and Δv in m/s): the "
        f"worst of {phases} phases and {feet} {'feet' if feet > 1 else 'foot'}; every smaller one "
        f"on the grid of {measured.step:g} N s is survived. The aim is a Δv of {AIM:.2f} m/s, as "
        f"85 N s on 70 kg. State: {state}.",
        ("method", *DIRECTIONS, "mean Δv", "causes of the falls"),
        rows,
    )


def _mean_words(cells: list[Pushed]) -> str:
    finite = [min(cell.delta_v, 1e9) for cell in cells]
    if any(value >= 1e9 for value in finite):
        return "–"
    return f"{math.fsum(finite) / len(finite):.2f}"


def print_body_pushes(measured: BodyPushes, console: Console) -> None:
    """Print the table of a robot.

    Args:
        measured: the comparison.
        console: where to print.
    """
    table = body_table(measured)
    console.print(f"[bold]{table.title}[/]", highlight=False)
    shown = TerminalTable(box=None, padding=(0, 1), pad_edge=False, header_style="bold")
    for index, heading in enumerate(table.columns[:-1]):
        shown.add_column(heading, justify="right" if index else "left", no_wrap=True)
    for row in table.rows:
        shown.add_row(*row[:-1])
    console.print(shown)
    console.print(f"\n[bold]{table.columns[-1]}[/]", highlight=False)
    for row in table.rows:
        console.print(f"{row[0]}: {row[-1]}", highlight=False)
    console.print(f"\n{table.note}", highlight=False)


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
"""Words, factor and unit of what was used, by its name in `studies.compare.body_limits`."""


def used_words(name: str, value: float) -> str:
    """How much of something was used, in words; `USED` has the names."""
    word, factor, unit = USED[name]
    if name == LATEST:
        return f"landing {abs(factor * value):.3g}{unit} {'early' if value < 0.0 else 'late'}"
    return f"{word} {factor * value:.3g}{unit}"


def explained_table(measured: BodyPushes, explained: Sequence[dict[str, Any]]) -> Table:
    """What bound in the push that each method fails on first, direction by direction.

    Args:
        measured: the comparison, for names and order.
        explained: of this robot: `robot`, `cell`, `impulse`, `cause`, `bindings` (each with `name`,
            `share` and `usual`) and `used`.
    """
    labels = {key: label for key, label, _ in measured.methods}
    rows = [
        (
            labels[entry["cell"]["method"]],
            entry["cell"]["direction"],
            f"{entry['impulse']:g} N s at {entry['cell']['phase']:.3g}, {entry['cell']['foot']}",
            entry["cause"] or "it stopped stepping",
            "; ".join(
                f"{one['name']} {100.0 * one['share']:.0f} %"
                + (f" (usually {100.0 * one['usual']:.0f})" if one["usual"] >= 0.005 else "")
                for one in entry["bindings"][:6]
            ),
            "; ".join(
                used_words(name, entry["used"][name]) for name in USED if name in entry["used"]
            ),
        )
        for entry in explained
    ]
    return Table(
        f"What binds: {measured.robot}",
        "Of the smallest push that it fails on in the worst situation of each direction: part of "
        "the first second after the push began in which a limit was active (a multiplier of the "
        "quadratic program that is not zero, or what the controller says itself), where that is "
        "more than without the push; and the most that was used.",
        ("method", "direction", "push, phase, foot", "cause", "active limits", "used"),
        rows,
    )


def print_explained(
    measured: BodyPushes, explained: Sequence[dict[str, Any]], console: Console
) -> None:
    """Print what bound, a paragraph for each push.

    Args:
        measured: the comparison.
        explained: see `explained_table`; those of other robots are left out.
        console: where to print.
    """
    own = [entry for entry in explained if entry["robot"] == measured.robot]
    if not own:
        return
    table = explained_table(measured, own)
    console.print(f"\n[bold]{table.title}[/]. {table.note}", highlight=False)
    for method, direction, push, cause, active, used in table.rows:
        console.print(f"\n[bold]{method}, {direction}[/], {push}: {cause}", highlight=False)
        console.print(f"  active: {active}", highlight=False)
        console.print(f"  used: {used}", highlight=False)

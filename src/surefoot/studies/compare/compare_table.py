"""A comparison of methods as a table: for the terminal, for Markdown, and for the page."""

from __future__ import annotations

import math

from rich.console import Console
from rich.table import Table as TerminalTable

from surefoot.show.plain_table import Table
from surefoot.studies.compare.compare_words import INCOMPLETE, impulse_words
from surefoot.studies.compare.comparison import (
    DIRECTIONS,
    Choice,
    Comparison,
    Method,
    Score,
    choose,
)
from surefoot.studies.engine.words import angle_words, percent, speed_words, time_words

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

LIMIT = "limit of any policy"

_WIDE = 150
"""A terminal of so many columns takes the whole table."""

_FIRST = (0, 2, 3, 5, 6, 7, 8, 9, 10)
_SECOND = (0, 1, 4, 11, 12, 13)


def compare_table(measured: Comparison, choice: Choice | None = None) -> Table:
    """All methods at one leg speed.

    Means, worst cells and failures are over everything that was measured at that leg speed; the
    smallest failing impulses are those of one push duration and phase.

    Args:
        measured: the comparison.
        choice: what is shown; that of `choose` if None.

    Returns:
        The table; its columns are `COLUMNS`.

    Raises:
        ParameterError: nothing was measured there.
    """
    choice = choose(measured) if choice is None else _checked(measured, choice)
    cells = measured.select(leg_speed=choice.leg_speed)
    at = {
        (cell.method, cell.angle): cell
        for cell in cells
        if cell.push_duration == choice.push_duration and cell.phase == choice.phase
    }
    rows = []
    for method in measured.methods:
        score = measured.score(method, cells)
        failing = [
            impulse_words(at[method.key, angle]) if (method.key, angle) in at else "–"
            for angle in DIRECTIONS.values()
        ]
        rows.append(_row(method, score, failing))
    limits = {cell.angle: cell.limit_finite for cell in at.values()}
    around = [f"{limits[angle]:.1f}" if angle in limits else "–" for angle in DIRECTIONS.values()]
    rows.append((LIMIT, "everything", "100 %", "100 %", "", *around, "", "", "", "", ""))
    return Table(
        title=speed_words(choice.leg_speed).capitalize(),
        note=_note(measured, choice),
        columns=COLUMNS,
        rows=rows,
    )


def print_compare_table(
    measured: Comparison, console: Console, choice: Choice | None = None
) -> None:
    """Print the table; in two parts where the terminal is too narrow for one.

    Args:
        measured: the comparison.
        console: where to print.
        choice: as for `compare_table`.

    Raises:
        ParameterError: nothing was measured there.
    """
    table = compare_table(measured, choice)
    robot = measured.provenance.get("robot", "")
    console.print(f"[bold]{', '.join(part for part in (robot, table.title) if part)}[/]")
    parts = [range(len(COLUMNS))] if console.width >= _WIDE else [_FIRST, _SECOND]
    for part in parts:
        terminal = TerminalTable(box=None, padding=(0, 1), pad_edge=False, header_style="bold")
        for index in part:
            words = index < 2
            terminal.add_column(
                COLUMNS[index].replace(" [N s]", ""),
                justify="left" if words else "right",
                no_wrap=not words,
            )
        for row in table.rows if part is not _SECOND else table.rows[:-1]:
            style = "dim" if row[0] == LIMIT else None
            terminal.add_row(*(_aligned(row[index], index) for index in part), style=style)
        console.print(terminal)
        console.print()
    console.print(table.note, highlight=False)


def _aligned(text: str, column: int) -> str:
    """A share with room for the sign that others have behind them."""
    share = COLUMNS[column] in ("mean", "worst", "causal")
    return f"{text} " if share and not text.endswith(INCOMPLETE) else text


def mean_words(score: Score) -> str:
    """A mean share of the limit, with ≥ and * where they belong."""
    if math.isnan(score.mean):
        return "–"
    least = "≥ " if score.at_least else ""
    return f"{least}{percent(score.mean)}{'' if score.complete else INCOMPLETE}"


def _row(method: Method, score: Score, failing: list[str]) -> tuple[str, ...]:
    none = score.cells == 0
    return (
        method.label,
        method.adapts,
        mean_words(score),
        percent(score.worst) + ("" if score.complete or none else INCOMPLETE),
        percent(score.causal) + ("" if score.complete or none else INCOMPLETE),
        *failing,
        "–" if none else str(score.fell),
        "–" if none else str(score.unsettled),
        time_words(method.decision_p50),
        time_words(method.decision_p99_9),
        str(score.cells) if score.complete else f"{score.cells} of {score.possible}",
    )


def _note(measured: Comparison, choice: Choice) -> str:
    words = (
        "Mean and worst: what is survived as a share of the limit, over all cells of this leg "
        "speed; causal: the mean share of what can be survived without knowing when the push ends. "
        f"{', '.join(angle_words(a) for a in DIRECTIONS.values())}: the smallest failing "
        f"impulse [N s] of a push of {choice.push_duration:g} s at phase {choice.phase:.3g}; "
        "– was not measured."
    ).replace("forward,", "Forward,", 1)
    cells = measured.select(leg_speed=choice.leg_speed)
    scores = [measured.score(method, cells) for method in measured.methods]
    if not all(score.complete for score in scores):
        words += (
            f" {INCOMPLETE} stands on fewer cells than others: such a mean does not compare "
            "directly."
        )
    if any(score.at_least for score in scores):
        words += " ≥ where nothing failed up to the largest impulse that was tried."
    return words


def _checked(measured: Comparison, choice: Choice) -> Choice:
    return choose(
        measured,
        leg_speed=choice.leg_speed,
        push_duration=choice.push_duration,
        phase=choice.phase,
    )

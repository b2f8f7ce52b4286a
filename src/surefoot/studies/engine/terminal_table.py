"""A table in a terminal: whole if there is room, else in pieces that all name their rows."""

from __future__ import annotations

import re
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

WORD_WIDTH = 26
"""A column of words is made no narrower than this in a terminal, unless all of it is shorter."""

GAP = 2
"""Between columns in a terminal."""

_UNIT_OR_WORD = re.compile(r"\[[^\]]*\]|\S+")


def print_rows(
    console: Console,
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    numeric: Sequence[bool],
    names: int,
) -> None:
    """Print a table; nothing in it is wider than the terminal, and no number is broken.

    Args:
        console: where to print.
        columns: headings.
        rows: a text for each column.
        numeric: which columns hold numbers; these stand to the right, on one line each.
        names: how many columns name a row; every piece begins with them.
    """
    cells = [[row[index] for row in rows] for index in range(len(columns))]
    widths = [max(map(len, (head, *own))) for head, own in zip(columns, cells, strict=True)]
    narrow = sum(width + GAP for width in widths) - GAP > console.width
    if narrow:
        widths = [
            max(map(len, (*_UNIT_OR_WORD.findall(head), *own))) if number
            else min(width, WORD_WIDTH)
            for head, own, number, width in zip(columns, cells, numeric, widths, strict=True)
        ]  # fmt: skip
    for place, piece in enumerate(_pieces(widths, names, console.width)):
        if place:
            console.print()
        shown = Table(box=None, padding=(0, 1), pad_edge=False, header_style="bold")
        for index in piece:
            number, heading = numeric[index], columns[index]
            if number and narrow:
                heading = _wrapped(heading, widths[index])
            shown.add_column(Text(heading), justify="right" if number else "left", no_wrap=number)
        for row in rows:
            shown.add_row(*(Text(row[index]) for index in piece))
        console.print(shown)


def _wrapped(heading: str, width: int) -> str:
    """A heading on lines of at most `width`; a unit stays on one."""
    lines = [""]
    for word in _UNIT_OR_WORD.findall(heading):
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return "\n".join(lines)


def _pieces(widths: Sequence[int], names: int, width: int) -> list[list[int]]:
    """The columns of each piece of a table that is to be no wider than a terminal."""
    first = list(range(names))
    pieces = [[*first]]
    for index in range(names, len(widths)):
        piece = pieces[-1]
        if len(piece) > names and sum(widths[one] + GAP for one in (*piece, index)) - GAP > width:
            pieces.append([*first])
        pieces[-1].append(index)
    return pieces

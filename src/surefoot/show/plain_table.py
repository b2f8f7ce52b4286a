"""A table of words: headings and rows of texts, for a page, a terminal or Markdown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """A table with a heading.

    Attributes:
        title: its heading.
        note: what it shows, in a sentence or two.
        columns: headings.
        rows: one text for each column; numbers as they are to be read.
    """

    title: str
    note: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


def markdown_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a table in Markdown, an empty one last."""
    lines = ["| " + " | ".join(columns) + " |", "|" + " --- |" * len(columns)]
    for row in rows:
        # A bar would end the cell.
        lines.append("| " + " | ".join(value.replace("|", "\\|") for value in row) + " |")
    return [*lines, ""]

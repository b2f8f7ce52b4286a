"""How a study on the command line ends: with every cell, with some missing, or stopped."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

INCOMPLETE, STOPPED = 1, 130
"""Exit status if a cell could not be measured, and if the study was stopped."""


@contextmanager
def stopped_by_ctrl_c(folder: Path, kept: str = "what is measured is kept") -> Iterator[None]:
    """End the command, and say that nothing is lost, when the user stops it.

    Args:
        folder: where the study goes on.
        kept: what is there already, as the begin of a sentence.
    """
    try:
        yield
    except KeyboardInterrupt:
        click.echo(f"stopped; {kept} in {folder}, and the same command goes on there", err=True)
        sys.exit(STOPPED)


def tell_failures(failures: Sequence[Any], where: Callable[[Any], str] = str) -> int:
    """Say which cells could not be measured, and why; the exit status.

    Args:
        failures: each with a `cell` and an `error`.
        where: how a cell is called.
    """
    for failure in failures:
        click.echo(
            f"could not be measured: {where(failure.cell)}: {failure.error.strip()}", err=True
        )
    return INCOMPLETE if failures else 0

"""What the commands of studies share: a bar while they run, and how they end."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from surefoot.options import progress_bar

if TYPE_CHECKING:
    from surefoot.studies.engine.study import Measured, Study
    from surefoot.studies.engine.workers import Workers

INCOMPLETE, STOPPED = 1, 130
"""Exit status if a cell could not be measured, and if the study was stopped."""

S = TypeVar("S", bound="Study")


def run_shown(
    studies: Mapping[Path, S], out: Path, *, workers: int | Workers = -1, what: str = "measuring"
) -> list[Measured[S]]:
    """Run studies one after the other, with a bar that shows how far each is.

    Args:
        studies: by the folder that keeps its rows.
        out: the folder of all of them, which is named if the user stops it.
        workers: see `study.run`.
        what: the word before the bar.

    Raises:
        SurefootError: see `study.run`.
    """
    from surefoot.studies.engine.study import run

    results = []
    with stopped_by_ctrl_c(out):
        for folder, study in studies.items():
            with progress_bar(what) as report:
                results.append(run(study, folder, workers=workers, report=report))
    return results


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

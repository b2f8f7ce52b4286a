"""What the commands of studies share: options, a bar while they run, and how they end."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from surefoot import options
from surefoot.options import Option, print_json, progress_bar

if TYPE_CHECKING:
    from surefoot.studies.engine.report import Report
    from surefoot.studies.engine.study import Measured, Study
    from surefoot.studies.engine.workers import Workers

INCOMPLETE, STOPPED = 1, 130
"""Exit status if a cell could not be measured, and if the study was stopped."""

S = TypeVar("S", bound="Study")

workers_option = click.option(
    "--workers", type=int, default=-1, help="Processes; all cores if left out."
)


def out_option(folder: str, holds: str) -> Option:
    """The folder of a study, and what will be in it."""
    return click.option(
        "--out", type=click.Path(path_type=Path), default=Path(folder), show_default=True,
        metavar="DIR", help=f"Folder for {holds}.",
    )  # fmt: skip


def velocity_option(usual: str = "0.5 0") -> Option:
    """The velocity of the walk; the help says that `usual` is the default."""
    return options.velocity_option("Of the walk that is pushed [m/s].", usual=usual)


def run_shown(
    studies: Mapping[Path, S], out: Path, *, workers: int | Workers = -1, what: str = "measuring",
    where: Callable[[Any], str] = str,
) -> tuple[list[Measured[S]], int]:  # fmt: skip
    """Run studies one after the other, with a bar that shows how far each is, and say which cells
    could not be measured, and why.

    Args:
        studies: by the folder that keeps its rows.
        out: the folder of all of them, which is named if the user stops it.
        workers: see `study.run`.
        what: the word before the bar.
        where: how a cell is called that could not be measured.

    Returns:
        What was measured, and the exit status.

    Raises:
        SurefootError: see `study.run`.
    """
    from surefoot.studies.engine.study import run

    results = []
    with stopped_by_ctrl_c(out):
        for folder, study in studies.items():
            with progress_bar(what) as report:
                results.append(run(study, folder, workers=workers, report=report))
    failures = [failure for one in results for failure in one.failures]
    for failure in failures:
        words = f"could not be measured: {where(failure.cell)}: {failure.error.strip()}"
        click.echo(words, err=True)
    return results, INCOMPLETE if failures else 0


@contextmanager
def stopped_by_ctrl_c(folder: Path) -> Iterator[None]:
    """End the command, and say that nothing is lost, when the user stops it.

    Args:
        folder: where the study goes on.
    """
    try:
        yield
    except KeyboardInterrupt:
        words = f"stopped; what is measured is kept in {folder}, and the same command goes on there"
        click.echo(words, err=True)
        sys.exit(STOPPED)


def end(
    shown: Report, out: Path, numbers: Callable[[], dict[str, Any]], *, as_json: bool,
    kept: str, beside: Sequence[Path] = (),
) -> None:  # fmt: skip
    """Write a report; print it and say where everything is, or print numbers for machines.

    Args:
        shown: the report.
        out: the folder of the report.
        numbers: what JSON says.
        as_json: print that.
        kept: what else is where, such as the table, in words.
        beside: other files that were written.
    """
    page, *others = shown.write(out)
    if as_json:
        print_json(numbers())
        return
    from rich.console import Console

    shown.print(Console())
    rest = ", ".join(map(str, [*others, *beside]))
    click.echo(f"\npage: {page}, {kept}, text and pictures: {rest}")

"""`surefoot sweep`: a study from a file, on this machine or on a cluster."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.options import check_plotting, json_option, print_json, progress_bar
from surefoot.studies.engine.command import stopped_by_ctrl_c, tell_failures

if TYPE_CHECKING:
    from surefoot.studies.sweep.sweep import SweepTable
    from surefoot.studies.sweep.sweep_study import Study


@click.command()
@click.argument("study", type=click.Path(path_type=Path), metavar="STUDY.toml")
@click.option("--workers", type=int, default=-1, help="Processes; all cores if left out.")
@click.option(
    "--cluster", metavar="ADDRESS",
    help="Measure on the workers of this dask scheduler, for example tcp://10.0.0.1:8786.",
)  # fmt: skip
@click.option(
    "--out", type=click.Path(path_type=Path), metavar="DIR",
    help="Folder for the table; named like the study if left out.",
)  # fmt: skip
@click.option(
    "--plot", type=click.Path(path_type=Path), metavar="FILE",
    help="Draw the table (.png, .pdf, .svg).",
)  # fmt: skip
@click.option(
    "--quantity", metavar="COLUMN",
    help="What is drawn; the smallest failing impulse or who survived if left out.",
)  # fmt: skip
@json_option
def sweep(
    study: Path, workers: int, cluster: str | None, out: Path | None, plot: Path | None,
    quantity: str | None, as_json: bool,
) -> None:  # fmt: skip
    """Measure what becomes of a walk over any parameters: a grid, or values that are drawn.

    STUDY.toml says which parameters of robot, gait, controller, push and disturbance are set and
    which vary. DIR/sweep.parquet holds a row for each combination. A study that was stopped or
    killed goes on when the same command is given again, and measures nothing twice.

    Exits with 1 if a cell could not be measured.
    """
    from surefoot.checks import check_writable
    from surefoot.errors import ParameterError
    from surefoot.studies.engine.workers import Cluster, Processes
    from surefoot.studies.sweep.sweep import TABLE, run_sweep
    from surefoot.studies.sweep.sweep_study import load_study

    asked = load_study(study)
    folder = out or Path(study.stem)
    if plot is not None:
        check_plotting()
        check_writable(plot, (".png", ".pdf", ".svg"))
        _check_quantity(asked, quantity)
    elif quantity is not None:
        raise ParameterError("--plot with --quantity", "no --plot", "give --plot FILE.png")
    who = Processes(workers) if cluster is None else Cluster(cluster)
    with stopped_by_ctrl_c(folder), progress_bar("measuring") as report:
        found = run_sweep(asked, folder, workers=who, report=report)
    status = tell_failures(
        found.failures,
        lambda cell: ", ".join(
            f"{name} = {value}" for name, value in zip(asked.vary, cell.values, strict=True)
        ),
    )
    if plot is not None:
        _draw(found, plot, quantity)
    if as_json:
        print_json(_numbers(found))
    else:
        _show(found)
        click.echo(f"\ntable: {folder / TABLE}" + (f", picture: {plot}" if plot else ""))
    sys.exit(status)


def _check_quantity(study: Study, name: str | None) -> None:
    """Refuse a quantity that the table will not have, before hours of measuring.

    Raises:
        ParameterError: there is none of that name.
    """
    from surefoot.studies.sweep.sweep_cell import RESULTS
    from surefoot.studies.sweep.sweep_columns import quantity

    quantity([RESULTS[study.measure]], list(study.vary), name)


def _draw(found: SweepTable, path: Path, quantity: str | None) -> None:
    from surefoot.studies.sweep.sweep_figure import draw_sweep

    about = {
        "title": found.study.title,
        "robot": found.provenance["robot"],
        "controller": found.study.controller,
        "sampling": found.study.sampling,
        "varied": list(found.study.vary),
    }
    draw_sweep(found.rows, about, path, quantity=quantity)


def _numbers(found: SweepTable) -> dict[str, Any]:
    from surefoot.studies.engine.cells import without_infinity

    return {
        "title": found.study.title,
        "varied": list(found.study.vary),
        "rows": [without_infinity(row) for row in found.rows],
        "failures": len(found.failures),
        "provenance": found.provenance,
    }


def _show(found: SweepTable) -> None:
    """What came out, in a few lines; the cells themselves if there are not many."""
    from rich.console import Console

    from surefoot.studies.sweep.sweep_table import print_sweep

    print_sweep(found.rows, list(found.study.vary), found.study.title, Console())

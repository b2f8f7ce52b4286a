"""`surefoot sweep`: a study from a file, on this machine or on a cluster."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from surefoot.options import check_plotting, json_option
from surefoot.studies.engine.command import end, run_shown, workers_option


@click.command()
@click.argument("study", type=click.Path(path_type=Path), metavar="STUDY.toml")
@workers_option
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
    which vary. DIR/sweep.parquet holds a row for each combination, sweep.html and sweep.md say what
    came out. A study that was stopped or killed goes on when the same command is given again, and
    measures nothing twice.

    Exits with 1 if a cell could not be measured.
    """
    check_plotting()
    from surefoot.checks import check_writable
    from surefoot.errors import ParameterError
    from surefoot.show.picture_file import FORMATS
    from surefoot.studies.engine.workers import Cluster
    from surefoot.studies.sweep.axes import quantity_name
    from surefoot.studies.sweep.pictures import draw_sweep
    from surefoot.studies.sweep.show import as_numbers, report
    from surefoot.studies.sweep.study_file import load_study

    asked = load_study(study)
    folder = out or Path(study.stem)
    if plot is not None:
        check_writable(plot, FORMATS)
        quantity_name(asked.measures, quantity)
    elif quantity is not None:
        raise ParameterError("--plot with --quantity", "no --plot", "give --plot FILE.png")
    who = workers if cluster is None else Cluster(cluster)
    (found,), status = run_shown(
        {folder: asked},
        folder,
        workers=who,
        where=lambda cell: ", ".join(f"{key} = {one}" for key, one in asked.columns(cell).items()),
    )
    shown = report(found, quantity)
    if plot is not None:
        draw_sweep(found, plot, quantity)
    end(
        shown,
        folder,
        lambda: as_numbers(found),
        as_json=as_json,
        kept=f"table: {folder / asked.NAME}.parquet",
        beside=() if plot is None else (plot,),
    )
    sys.exit(status)

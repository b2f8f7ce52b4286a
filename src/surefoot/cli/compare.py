"""`surefoot compare`: methods against each other, and against what is possible at all."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.cli.arguments import check_plotting, json_option, print_json, robot_option

if TYPE_CHECKING:
    from surefoot.models.robot import Robot
    from surefoot.studies.protocol import Protocol

INCOMPLETE, STOPPED = 1, 130
"""Exit status if a cell could not be measured, and if the study was stopped."""

FULL_SPEEDS, FULL_DURATIONS = (2.0, 3.0, 4.0, 6.0, math.inf), (0.1, 0.2, 0.4)
"""Leg speeds [m/s] and push durations [s] of `--full`."""


@click.command()
@robot_option
@click.option(
    "--mass", type=float, metavar="KG", help="Of the robot; its own if left out. Limits scale."
)
@click.option(
    "--velocity", nargs=2, type=float, default=(0.5, 0.0), show_default=True, metavar="VX VY",
    help="Of the walk that is pushed [m/s].",
)  # fmt: skip
@click.option(
    "--method", "methods", multiple=True, metavar="METHOD",
    help="One to compare; may be repeated. All but the slow nonlinear one if left out.",
)  # fmt: skip
@click.option(
    "--leg-speed", "leg_speeds", type=float, multiple=True, metavar="M/S",
    help="Speed limit of the swing foot, or inf; may be repeated. 3 if left out.",
)  # fmt: skip
@click.option(
    "--push-duration", "durations", type=float, multiple=True, metavar="S",
    help="May be repeated. 0.2 if left out.",
)  # fmt: skip
@click.option(
    "--full", is_flag=True, help="Leg speeds 2, 3, 4, 6 and inf; pushes of 0.1, 0.2 and 0.4 s."
)
@click.option("--directions", type=int, default=4, show_default=True, help="Evenly around.")
@click.option("--phases", type=int, default=8, show_default=True, help="Evenly over a step.")
@click.option(
    "--step", type=float, default=1.0, show_default=True, metavar="NS",
    help="Of the scan over the impulse [N s].",
)  # fmt: skip
@click.option("--workers", type=int, default=-1, help="Processes; all cores if left out.")
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("compare"), show_default=True,
    metavar="DIR", help="Folder for table, report, page and pictures.",
)  # fmt: skip
@json_option
def compare(
    robot: str, mass: float | None, velocity: tuple[float, float], methods: tuple[str, ...],
    leg_speeds: tuple[float, ...], durations: tuple[float, ...], full: bool, directions: int,
    phases: int, step: float, workers: int, out: Path, as_json: bool,
) -> None:  # fmt: skip
    """Compare control methods: the smallest push that each fails on, beside the limit for anybody.

    DIR/compare.html is a page on which to choose the leg speed; compare.md says it in words,
    compare.parquet holds every number. A study that was stopped goes on when the same command is
    given again; another one of the same robot and velocity adds to it.
    """
    from surefoot.models.robot import load_robot
    from surefoot.studies.protocol import Protocol

    check_plotting()
    body = load_robot(robot) if mass is None else load_robot(robot).replace(mass=mass)
    protocol = Protocol(
        body,
        velocity,
        methods=methods or _all_methods(body, velocity),
        directions=directions,
        phases=phases,
        leg_speeds=leg_speeds or (FULL_SPEEDS if full else (3.0,)),
        push_durations=durations or (FULL_DURATIONS if full else (0.2,)),
        step=step,
    )
    sys.exit(_compare(protocol, out, workers, as_json))


def _all_methods(robot: Robot, velocity: tuple[float, float]) -> tuple[str, ...]:
    """All that can be compared on this robot; say what is left out, and why."""
    from surefoot.control.methods import METHODS
    from surefoot.studies.compare import able_methods

    able, left_out = able_methods(robot, velocity)
    for one in METHODS:
        if one.slow:
            left_out[one.key] = f"slow; ask for it with --method {one.key}"
    for key, reason in left_out.items():
        click.echo(f"left out: {key}: {reason}", err=True)
    return tuple(able)


def _compare(protocol: Protocol, out: Path, workers: int, as_json: bool) -> int:
    from surefoot.studies.compare import compare_methods

    try:
        with _progress() as report:
            result = compare_methods(protocol, out, workers=workers, report=report)
    except KeyboardInterrupt:
        click.echo(
            f"stopped; what is measured is kept in {out}, and the same command goes on there",
            err=True,
        )
        return STOPPED
    for failure in result.failures:
        click.echo(f"could not be measured: {failure.cell}: {failure.error}", err=True)
    _show(result, out, as_json)
    return INCOMPLETE if result.failures else 0


def _show(result: Any, out: Path, as_json: bool) -> None:
    from rich.console import Console

    from surefoot.studies.compare import TABLE
    from surefoot.viewers.compare_report import write_compare_report
    from surefoot.viewers.compare_table import print_compare_table
    from surefoot.viewers.comparison import comparison

    # How long a cell took is for the table alone.
    rows = [{name: row[name] for name in row if name != "seconds"} for row in result.rows]
    measured = comparison(rows, result.methods, result.provenance)
    files = write_compare_report(measured, out, result.remarks)
    if as_json:
        print_json(result.as_numbers())
        return
    print_compare_table(measured, Console())
    for paragraph in result.remarks:
        click.echo(f"\n{paragraph}")
    click.echo(f"\ntable: {out / TABLE}, page: {files[0]}, report: {files[1]}")


@contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error, from what is there already to all that is wanted."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Left

    columns = (TextColumn("measuring"), BarColumn(), MofNCompleteColumn(), Left())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("cells", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)

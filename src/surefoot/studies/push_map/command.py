"""`surefoot push-map`: what one controller survives, in every direction and phase of a step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from surefoot.options import (
    check_plotting,
    compiling_notice,
    json_option,
    print_json,
    progress_bar,
    robot_option,
)
from surefoot.studies.engine.command import stopped_by_ctrl_c


@click.command("push-map")
@robot_option
@click.option(
    "--controller", "key", default="unified", show_default=True, metavar="METHOD",
    help="Who is pushed; a wrong METHOD lists them.",
)  # fmt: skip
@click.option(
    "--velocity", nargs=2, type=float, default=(0.5, 0.0), show_default="0.5 0", metavar="VX VY",
    help="Of the walk that is pushed [m/s].",
)  # fmt: skip
@click.option(
    "--leg-speed", type=float, default=3.0, show_default=True, metavar="M/S",
    help="Speed limit of the swing foot along each axis, or inf.",
)  # fmt: skip
@click.option("--directions", type=int, default=72, show_default=True, help="Evenly around.")
@click.option("--phases", type=int, default=20, show_default=True, help="Evenly over a step.")
@click.option(
    "--step", type=float, default=1.0, show_default=True, metavar="NS",
    help="Of the scan over the impulse [N s].",
)  # fmt: skip
@click.option(
    "--push-duration", type=float, default=0.2, show_default=True, metavar="S",
    help="How long a push lasts [s].",
)  # fmt: skip
@click.option(
    "--coarse", type=float, metavar="NS", show_default="ten steps",
    help="Walk its multiples first, then all between two of which one is survived and the other "
    "not: a hole that is narrower may be missed [N s].",
)  # fmt: skip
@click.option("--full", is_flag=True, help="Walk every impulse: no hole is missed.")
@click.option("--workers", type=int, help="Threads; all cores if left out.")
@click.option(
    "--out", type=click.Path(path_type=Path), default=Path("push-map"), show_default=True,
    metavar="DIR", help="Folder for table, page and pictures.",
)  # fmt: skip
@json_option
def push_map(
    robot: str, key: str, velocity: tuple[float, float], leg_speed: float, directions: int,
    phases: int, step: float, push_duration: float, coarse: float | None, full: bool,
    workers: int | None, out: Path, as_json: bool,
) -> None:  # fmt: skip
    """Map what one controller survives: directions, phases of a step and impulses to the limit.

    DIR/push-map.html is a page on which to look at every cell and every push; push-map.png and
    push-map-polar.png are pictures, push-map.parquet holds every walk. A map that was stopped goes
    on when the same command is given again; another one needs another DIR.
    """
    from surefoot.control.registry import find_method
    from surefoot.errors import ParameterError
    from surefoot.robot.robot import load_robot
    from surefoot.studies.push_map.push_grid import PushGrid

    if full and coarse is not None:
        raise ParameterError("`--coarse` or `--full`", "both", "leave one of them out")
    if workers is not None and workers < 1:
        raise ParameterError(
            "a number of workers of at least 1", str(workers), "leave it out for all cores"
        )
    check_plotting()
    grid = PushGrid(directions, phases, step, step if full else coarse, push_duration)
    who = find_method(key)
    controller = who.controller(load_robot(robot).with_leg(max_speed=leg_speed), velocity)
    _map(controller, who.label, grid, out, workers, as_json)


def _map(
    controller: Any, label: str, grid: Any, out: Path, workers: int | None, as_json: bool
) -> None:
    from surefoot.studies.push_map.push_cube import measure_cube, warm_up

    with stopped_by_ctrl_c(out, "the phases that are finished are kept"):
        with compiling_notice(patience=6.0, about="a minute"):
            warm_up(controller)
        with progress_bar("pushing") as report:
            result = measure_cube(controller, grid, out, name=label, workers=workers, report=report)
    _show(result, out, as_json)


def _show(result: Any, out: Path, as_json: bool) -> None:
    from rich.console import Console

    from surefoot.studies.push_map.cube import push_cube
    from surefoot.studies.push_map.push_cube import TABLE
    from surefoot.studies.push_map.push_cube_report import print_cube, write_cube_report
    from surefoot.studies.push_map.push_cube_words import summary

    cube = push_cube(result.rows, result.grid, result.provenance)
    page, *pictures = write_cube_report(cube, out)
    if as_json:
        print_json(result.as_numbers() | {"summary": summary(cube)})
        return
    print_cube(cube, Console())
    click.echo(f"\npage: {page}, table: {out / TABLE}, pictures: {', '.join(map(str, pictures))}")

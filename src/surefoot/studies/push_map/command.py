"""`surefoot push-map`: what one controller survives, in every direction and phase of a step."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import click

from surefoot.options import check_plotting, compiling_notice, json_option, robot_option
from surefoot.studies.engine.command import (
    end,
    out_option,
    run_shown,
    velocity_option,
    workers_option,
)


@click.command("push-map")
@robot_option
@click.option(
    "--controller", "key", default="unified", show_default=True, metavar="METHOD",
    help="Method of the robot that is pushed; a wrong METHOD lists them.",
)  # fmt: skip
@velocity_option()
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
@workers_option
@out_option("push-map", "table, page and pictures")
@json_option
def push_map(
    robot: str, key: str, velocity: tuple[float, float], leg_speed: float, directions: int,
    phases: int, step: float, push_duration: float, coarse: float | None, full: bool,
    workers: int, out: Path, as_json: bool,
) -> None:  # fmt: skip
    """Map what one controller survives: directions, phases of a step and impulses to the limit.

    DIR/push-map.html is a page on which to look at every cell and every push; push-map.md has its
    tables as text, push-map.png and push-map-polar.png are pictures, push-map.parquet holds every
    walk. A map that was stopped goes on when the same command is given again; another one needs
    another DIR.

    Exits with 1 if a cell could not be measured.
    """
    from surefoot.control.registry import find_method
    from surefoot.errors import ParameterError
    from surefoot.robot.robot import load_robot
    from surefoot.studies.push_map.map_numbers import MapNumbers
    from surefoot.studies.push_map.question import PushMap
    from surefoot.studies.push_map.show import as_numbers, report

    if full and coarse is not None:
        raise ParameterError("`--coarse` or `--full`", "both", "leave one of them out")
    check_plotting()
    asked = find_method(key)
    study = PushMap(
        asked.controller(load_robot(robot).with_leg(max_speed=leg_speed), velocity),
        directions, phases, step, step if full else coarse, push_duration, label=asked.label,
    )  # fmt: skip
    study.check()
    with compiling_notice(patience=6.0, about="a minute"):
        # Here, so that not every process compiles.
        few = replace(study, directions=1, phases=1, step=1e4, coarse=None)
        few.measure_many(list(few.cells()))
    (found,), status = run_shown({out: study}, out, workers=workers, what="pushing")
    if status:
        sys.exit(status)
    numbers = MapNumbers(found)
    table = f"table: {out / study.NAME}.parquet"
    end(report(numbers), out, lambda: as_numbers(numbers), as_json=as_json, kept=table)

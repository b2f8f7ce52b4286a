"""`surefoot gentleness`: what small pushes make two methods do."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from surefoot.options import check_plotting, compiling_notice, json_option, robot_option
from surefoot.studies.engine.command import end, out_option, run_shown, workers_option


@click.command()
@robot_option
@click.option(
    "--impulse", "impulses", type=float, multiple=True, metavar="NS",
    help="Of the pushes [N s]; may be repeated. 5, 10 and 20 if left out.",
)  # fmt: skip
@click.option(
    "--leg-speed", "leg_speeds", type=float, multiple=True, metavar="M/S",
    help="Speed limit of the swing foot, or inf; may be repeated. 3 and inf if left out.",
)  # fmt: skip
@workers_option
@out_option("gentleness", "table, report and page")
@json_option
def gentleness(
    robot: str, impulses: tuple[float, ...], leg_speeds: tuple[float, ...], workers: int,
    out: Path, as_json: bool,
) -> None:  # fmt: skip
    """Print how gently small pushes are answered: the unified controller beside the hybrid.

    Each push lasts 0.2 s, in four directions and at four phases of a step: how far the ZMP leaves
    the centre of the foot, and by how much landings change in place and time. A study that was
    stopped goes on when the same command is given again.
    """
    check_plotting()
    from surefoot.robot.robot import load_robot
    from surefoot.studies.gentleness.question import IMPULSES, LEG_SPEEDS, Gentleness
    from surefoot.studies.gentleness.show import gentleness_report, numbers

    study = Gentleness(
        load_robot(robot), impulses=impulses or IMPULSES, leg_speeds=leg_speeds or LEG_SPEEDS
    )
    with compiling_notice():
        study.check()
    (found,), status = run_shown({out: study}, out, workers=workers)
    table = f"table: {out / study.NAME}.parquet"
    report = gentleness_report(found)
    end(report, out, lambda: {"gentleness": numbers(found)}, as_json=as_json, kept=table)
    sys.exit(status)

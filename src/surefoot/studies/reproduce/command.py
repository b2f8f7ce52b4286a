"""`surefoot reproduce`: the paper, figure by figure and number by number."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from surefoot.options import check_plotting, compiling_notice
from surefoot.studies.engine.command import out_option, run_shown, workers_option

if TYPE_CHECKING:
    from surefoot.studies.engine.report import Report
    from surefoot.studies.reproduce.walks import Claim


@click.command()
@click.option(
    "--simulator",
    type=click.Choice(["lipm", "mujoco"]),
    default="lipm",
    show_default=True,
    help="The paper's point mass, or its pushes on a body in physics.",
)
@workers_option
@out_option("paper", "the report, its pictures and tables")
def reproduce(simulator: str, workers: int, out: Path) -> None:
    """Reproduce the paper, figure by figure and number by number; write a report.

    DIR/paper.html needs nothing else; DIR/paper.md says the same, with the pictures beside it.
    With `--simulator mujoco` the paper's robot is pushed in physics as the paper pushes a point
    mass: DIR/paper_body.html and DIR/paper_body.md. What was stopped goes on when the same command
    is given again.
    """
    check_plotting()
    from surefoot.checks import check_folder

    check_folder(out)
    sys.exit((_reproduce if simulator == "lipm" else _reproduce_on_body)(workers, out))


def _reproduce(workers: int, out: Path) -> int:
    """Walk and push the paper's point mass and write what it did; the exit status."""
    from surefoot.robot.robot import load_robot
    from surefoot.studies.reproduce.one_step import OneStepLimit
    from surefoot.studies.reproduce.question import OneStep, Paper
    from surefoot.studies.reproduce.show import claims_of, paper_report

    robot = load_robot("paper-biped").replace(mass=70.0)
    scan = {out / "one_step": OneStep(robot)}
    (limits,), failed = run_shown(scan, out, workers=workers, what="scanning")
    paper = Paper(robot, tuple(map(OneStepLimit.of, limits.rows)))
    (found,), status = run_shown({out: paper}, out, workers=workers, what="walking")
    _write(claims_of(found.rows), paper_report(found), out, lambda claim: claim.verdict)
    return failed or status


def _reproduce_on_body(workers: int, out: Path) -> int:
    """Push the paper's robot in physics and write what it did; the exit status."""
    from surefoot.checks import optional_module

    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    from surefoot.robot.robot import load_robot
    from surefoot.studies.reproduce.question import PaperOnBody
    from surefoot.studies.reproduce.show import body_report, claims_of

    study = PaperOnBody(load_robot("paper-biped"))
    with compiling_notice(20.0, "a minute"):
        (found,), status = run_shown({out / "body": study}, out, workers=workers, what="pushing")
    _write(
        claims_of(found.rows), body_report(found), out,
        lambda claim: f"{claim.ours.split(';')[0]}; {claim.verdict}",
    )  # fmt: skip
    return status


def _write(
    claims: Sequence[Claim], report: Report, out: Path, outcome: Callable[[Claim], str]
) -> None:
    """Print what became of every claim, and write the report."""
    for claim in claims:
        click.echo(f"{claim.figure}, {claim.text}: {outcome(claim)}")
    click.echo(f"report: {report.write(out)[0]}")

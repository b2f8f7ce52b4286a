"""`surefoot reproduce`: the paper, figure by figure and number by number."""

from __future__ import annotations

from pathlib import Path

import click

from surefoot.options import check_plotting, compiling_notice, progress_bar


@click.command()
@click.option(
    "--simulator",
    type=click.Choice(["lipm", "mujoco"]),
    default="lipm",
    show_default=True,
    help="The paper's point mass, or its pushes on a body in physics.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("paper"),
    show_default=True,
    metavar="DIR",
    help="Folder for the report and its pictures.",
)
def reproduce(simulator: str, out: Path) -> None:
    """Reproduce the paper, figure by figure and number by number; write a report.

    DIR/paper.html needs nothing else; DIR/paper.md says the same, with the pictures beside it.
    With `--simulator mujoco` the paper's robot is pushed in physics as the paper pushes a point
    mass: DIR/paper_body.html and DIR/paper_body.md.
    """
    check_plotting()
    if simulator == "mujoco":
        _reproduce_on_body(out)
    else:
        _reproduce(out)


def _reproduce(out: Path) -> None:
    """Walk and push the paper's point mass and write what it did."""
    from surefoot.checks import check_folder
    from surefoot.robot.robot import load_robot
    from surefoot.studies.reproduce.measure import reproduce_paper
    from surefoot.studies.reproduce.show import paper_report

    check_folder(out)
    robot = load_robot("paper-biped").replace(mass=70.0)
    click.echo("walking, pushing and scanning; this takes under a minute ...", err=True)
    results = reproduce_paper(robot)
    for claim in results.claims:
        click.echo(f"{claim.figure}, {claim.text}: {claim.verdict}")
    click.echo(f"report: {paper_report(robot, results).write(out)[0]}")


def _reproduce_on_body(out: Path) -> None:
    """Push the paper's robot in physics and write what it did."""
    from surefoot.checks import check_folder, optional_module

    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    from surefoot.robot.robot import load_robot
    from surefoot.studies.reproduce.body import body_claim, paper_push_answers
    from surefoot.studies.reproduce.show import body_report

    check_folder(out)
    robot = load_robot("paper-biped")
    click.echo("walking and pushing in physics; this takes a minute ...", err=True)
    with compiling_notice(20.0, "a minute"), progress_bar("pushing") as report:
        answers = paper_push_answers(robot, report=report)
    for claim in map(body_claim, answers):
        click.echo(f"{claim.figure}, {claim.text}: {claim.ours.split(';')[0]}; {claim.verdict}")
    click.echo(f"report: {body_report(robot, answers).write(out)[0]}")

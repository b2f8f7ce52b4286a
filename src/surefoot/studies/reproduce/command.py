"""`surefoot reproduce`: the paper, figure by figure and number by number."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from surefoot.options import check_plotting, compiling_notice

if TYPE_CHECKING:
    from surefoot.robot.robot import Robot
    from surefoot.studies.reproduce.body import BodyAnswer
    from surefoot.studies.reproduce.show import PaperReport


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
    mass: DIR/body.html and DIR/body.md.
    """
    check_plotting()
    from surefoot.checks import check_folder

    if simulator == "mujoco":
        _reproduce_on_body(out)
        return
    import dataclasses

    from surefoot.robot.robot import load_robot
    from surefoot.studies.reproduce.axes import png
    from surefoot.studies.reproduce.figures import (
        CAPTIONS,
        decision_time_figures,
        paper_figures,
    )
    from surefoot.studies.reproduce.measure import paper_parameters, reproduce_paper
    from surefoot.studies.reproduce.one_step import limits_table
    from surefoot.studies.reproduce.show import PaperReport, Table, write_paper_report

    check_folder(out)
    robot = load_robot("paper-biped").replace(mass=70.0)
    click.echo("walking, pushing and scanning; this takes under a minute ...", err=True)
    results = reproduce_paper(robot)
    report = PaperReport(
        claims=[dataclasses.astuple(claim) for claim in results.claims],
        parameters=paper_parameters(robot),
        pictures={n: png(f) for n, f in paper_figures(results.rollouts).items()},
        captions=CAPTIONS,
        tables=[Table(*limits_table(results.limits))],
        clock_pictures={n: png(f) for n, f in decision_time_figures(results.rollouts).items()},
    )
    for claim in results.claims:
        click.echo(f"{claim.figure}, {claim.text}: {claim.verdict}")
    click.echo(f"report: {write_paper_report(report, out)[0]}")


def _reproduce_on_body(out: Path) -> None:
    """Push the paper's robot in physics and write what it did."""
    from surefoot.checks import check_folder, optional_module

    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    from surefoot.robot.robot import load_robot
    from surefoot.studies.reproduce.body import paper_push_answers

    check_folder(out)
    robot = load_robot("paper-biped")
    click.echo("walking and pushing in physics; this takes a minute ...", err=True)
    with compiling_notice(20.0, "a minute"):
        answers = paper_push_answers(robot)
    report = body_report(robot, answers)
    for figure, what, _, ours, verdict, _ in report.claims:
        click.echo(f"{figure}, {what}: {ours.split(';')[0]}; {verdict}")
    from surefoot.studies.reproduce.show import write_paper_report

    click.echo(f"report: {write_paper_report(report, out)[0]}")


def body_report(robot: Robot, answers: Sequence[BodyAnswer]) -> PaperReport:
    """What a robot did with the paper's pushes, as a report.

    Args:
        robot: that was pushed.
        answers: of `studies.reproduce.body.paper_push_answers`.
    """
    import dataclasses

    from surefoot.show.walk_figure import walk_picture
    from surefoot.studies.reproduce import body
    from surefoot.studies.reproduce.show import PaperReport, Table

    pictures, captions = {}, {}
    for one in answers:
        if one.drawn and one.rollout.body is not None:
            claim = body.body_claim(one)
            name = f"body-{one.method}-{one.push.impulse:g}-{one.push.direction.replace(' ', '-')}"
            pictures[name] = walk_picture(one.rollout)
            captions[name] = f"{claim.figure}: {claim.text}. {claim.ours}."
    return PaperReport(
        claims=[dataclasses.astuple(body.body_claim(one)) for one in answers],
        parameters=body.body_parameters(robot, answers),
        pictures=pictures,
        captions=captions,
        tables=[Table(
            "Step by step",
            "From the pushed step on. The last column is how far the DCM is, when the foot lands, "
            "from where it is without a push.",
            body.STEP_COLUMNS,
            body.step_rows([one for one in answers if one.drawn]),
        )],
        name="paper_body",
        heading="The paper's pushes on a body",
        command="surefoot reproduce --simulator mujoco",
    )  # fmt: skip

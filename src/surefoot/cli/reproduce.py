"""`surefoot reproduce`: the paper, figure by figure and number by number."""

from __future__ import annotations

from pathlib import Path

import click

from surefoot.cli.arguments import check_plotting


@click.command()
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("paper"),
    show_default=True,
    metavar="DIR",
    help="Folder for the report and its pictures.",
)
def reproduce(out: Path) -> None:
    """Reproduce the paper, figure by figure and number by number; write a report.

    DIR/paper.html needs nothing else; DIR/paper.md says the same, with the pictures beside it.
    """
    import dataclasses

    check_plotting()
    from surefoot.checks import check_folder
    from surefoot.models.robot import load_robot
    from surefoot.studies.one_step import limits_table
    from surefoot.studies.paper_claims import paper_parameters, reproduce_paper
    from surefoot.viewers.paper_axes import png
    from surefoot.viewers.paper_figures import CAPTIONS, decision_time_figures, paper_figures
    from surefoot.viewers.paper_report import PaperReport, Table, write_paper_report

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

"""`surefoot robots`: what can be walked."""

from __future__ import annotations

import click


@click.command()
@click.option("--show", metavar="NAME", help="Print the file of a preset, to start your own from.")
def robots(show: str | None) -> None:
    """List the robots that Surefoot ships."""
    from surefoot.models.robot import load_robot, preset_names, preset_text

    if show is not None:
        click.echo(preset_text(show), nl=False)
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("name", "mass [kg]", "CoM height [m]", "hip [m]", "where it comes from"):
        table.add_column(column, no_wrap=column == "name")
    for name in preset_names():
        robot = load_robot(name)
        table.add_row(
            name, f"{robot.mass:g}", f"{robot.com_height:g}", f"{robot.hip:g}", robot.description
        )
    Console().print(table)

"""`surefoot gentleness`: what small pushes make two methods do."""

from __future__ import annotations

import click

from surefoot.options import compiling_notice, json_option, print_json, robot_option


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
@json_option
def gentleness(
    robot: str, impulses: tuple[float, ...], leg_speeds: tuple[float, ...], as_json: bool
) -> None:
    """Print how gently small pushes are answered: the unified controller beside the hybrid.

    Each push lasts 0.2 s, in four directions and at four phases of a step: how far the ZMP leaves
    the centre of the foot, and by how much landings change in place and time.
    """
    from surefoot.robot.robot import load_robot
    from surefoot.studies.gentleness.gentleness import IMPULSES, LEG_SPEEDS
    from surefoot.studies.gentleness.gentleness import gentleness as measure
    from surefoot.studies.gentleness.gentleness_table import print_gentleness

    with compiling_notice():
        found = measure(
            load_robot(robot),
            impulses=impulses or IMPULSES,
            leg_speeds=leg_speeds or LEG_SPEEDS,
        )
    numbers = [entry.as_numbers() for entry in found]
    if as_json:
        print_json({"gentleness": numbers})
        return
    from rich.console import Console

    print_gentleness(numbers, Console())

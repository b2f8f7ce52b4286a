"""`surefoot limits`: what a robot can do at most."""

from __future__ import annotations

import click

from surefoot.cli.arguments import (
    compiling_notice,
    json_option,
    print_json,
    robot_option,
    robot_with,
)


@click.command()
@robot_option
@click.option(
    "--velocity", nargs=2, type=float, metavar="VX VY",
    help="Of the walk that is pushed [m/s]; 0.5 forward if left out, or what it can.",
)  # fmt: skip
@click.option("--push-duration", type=float, default=0.2, show_default=True, metavar="S")
@click.option(
    "--leg-speed", "leg_speeds", type=float, multiple=True, metavar="M/S",
    help="Speed limit of the swing foot; may be repeated. The robot's own and 3 if left out.",
)  # fmt: skip
@click.option(
    "--phases", type=click.IntRange(1), default=8, show_default=True,
    help="At how many times in the step the push may start.",
)  # fmt: skip
@click.option("--check", is_flag=True, help="Compute the pushes again, on a grid (some 20 s).")
@json_option
def limits(
    robot: str, velocity: tuple[float, float] | None, push_duration: float,
    leg_speeds: tuple[float, ...], phases: int, check: bool, as_json: bool,
) -> None:  # fmt: skip
    """Print what a robot can do at most: speeds, DCM offsets, and the push that can be survived."""
    from surefoot.planning.nominal_gait import largest_speed
    from surefoot.viewers.limits_summary import limits_summary, print_limits
    from surefoot.viewers.push_limits import push_limits_summary, push_phases

    body = robot_with(robot, None)
    velocity = velocity or (min(0.5, largest_speed(body, (1.0, 0.0))), 0.0)
    with compiling_notice():
        speeds = dict.fromkeys(leg_speeds or (body.swing.max_speed, 3.0))
        bodies = [robot_with(robot, speed) for speed in speeds]
        times = push_phases(body, velocity, phases)
        pushes = push_limits_summary(bodies, times, velocity, push_duration)
    if check:
        from surefoot.studies.limit_grid import largest_disagreement

        worst = largest_disagreement(bodies, times, velocity=velocity, duration=push_duration)
        pushes["check"] = worst.as_numbers()
    numbers = {**limits_summary(body), "push_limit": pushes}
    if as_json:
        print_json(numbers)
        return
    from rich.console import Console

    print_limits(numbers, Console())

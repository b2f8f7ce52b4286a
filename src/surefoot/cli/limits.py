"""`surefoot limits`: what a robot can do at most."""

from __future__ import annotations

import click

from surefoot.options import (
    compiling_notice,
    json_option,
    number_option,
    print_json,
    robot_option,
    velocity_option,
)


@click.command()
@robot_option
@velocity_option(
    "Of the walk that is pushed [m/s]; 0.5 forward if left out, or what it can.", default=None
)
@number_option("--hip", "M", "Another hip width [m]; the robot's own.")
@click.option(
    "--push-duration", "durations", type=float, multiple=True, default=(0.2,), show_default=True,
    metavar="S", help="How long the push lasts [s]; may be repeated.",
)  # fmt: skip
@click.option(
    "--leg-speed", "leg_speeds", type=float, multiple=True, metavar="M/S",
    help="Speed limit of the swing foot along each axis; may be repeated. The robot's own and 3 if "
    "left out.",
)  # fmt: skip
@click.option(
    "--leg-acceleration", "leg_accelerations", type=float, multiple=True, metavar="M/S^2",
    help="Its acceleration limit, with each of the speeds; may be repeated. The robot's own if "
    "left out.",
)  # fmt: skip
@click.option(
    "--phases", type=click.IntRange(1), default=8, show_default=True,
    help="At how many times in the step the push may start.",
)  # fmt: skip
@click.option("--check", is_flag=True, help="Compute the pushes again, on a grid (a minute).")
@json_option
def limits(
    robot: str, velocity: tuple[float, float] | None, hip: float | None,
    durations: tuple[float, ...], leg_speeds: tuple[float, ...],
    leg_accelerations: tuple[float, ...], phases: int, check: bool, as_json: bool,
) -> None:  # fmt: skip
    """Print what a robot can do at most: speeds, DCM offsets, and the push that can be survived."""
    from surefoot.dcm.nominal_gait import largest_speed
    from surefoot.robot.robot import load_robot
    from surefoot.show.limits import (
        limits_summary,
        print_limits,
        push_limits_summary,
        push_phases,
    )

    body = load_robot(robot)
    body = body if hip is None else body.replace(hip=hip)
    velocity = velocity or (min(0.5, largest_speed(body, (1.0, 0.0))), 0.0)
    with compiling_notice():
        bodies = [
            body.with_leg(max_speed=speed, max_acceleration=acceleration)
            for speed in dict.fromkeys(leg_speeds or (body.swing.max_speed, 3.0))
            for acceleration in dict.fromkeys(leg_accelerations or (None,))
        ]
        times = push_phases(body, velocity, phases)
        pushes = push_limits_summary(bodies, times, velocity, durations)
    if check:
        from surefoot.dcm.limit_grid import (
            axis_pushes,
            largest_causal_disagreement,
            largest_disagreement,
        )

        again = axis_pushes(bodies, times, velocity, durations[0])
        causal = largest_causal_disagreement(again)
        pushes["check"] = {**largest_disagreement(again), "causal": causal}
    numbers = {**limits_summary(body), "push_limit": pushes}
    if as_json:
        print_json(numbers)
        return
    from rich.console import Console

    print_limits(numbers, Console())

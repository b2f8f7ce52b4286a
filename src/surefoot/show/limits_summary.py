"""What a robot can do at most, in numbers: speeds, viable DCM offsets, and pushes."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table

from surefoot.dcm.nominal_gait import largest_speed
from surefoot.dcm.viability import viable_offsets
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.show.push_limits import print_push_limits

_DIRECTIONS = {
    "forward": (1.0, 0.0),
    "backward": (-1.0, 0.0),
    "sideways": (0.0, 1.0),
}


def limits_summary(robot: Robot) -> dict[str, Any]:
    """The limits as plain numbers; SI.

    The lateral offsets are those at the end of a step on the right foot, so they belong to the
    left foot; the other side is their mirror image.
    """
    offsets = {
        "point_foot": viable_offsets(robot, Side.RIGHT),
        "finite_foot": viable_offsets(robot, Side.RIGHT, robot.foot.half),
    }
    return {
        "robot": robot.name,
        "omega": robot.omega,
        "largest_speed": {
            name: largest_speed(robot, direction) for name, direction in _DIRECTIONS.items()
        },
        "viable_offset": {
            foot: {
                "x": [viable.lower[0], viable.upper[0]],
                "y": [viable.lower[1], viable.upper[1]],
            }
            for foot, viable in offsets.items()
        },
    }


def print_limits(limits: dict[str, Any], console: Console) -> None:
    """The limits as a table; those of pushes, if there are any, as further ones."""
    console.print(f"[bold]{limits['robot']}[/]: omega = {limits['omega']:.4f} 1/s")
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("limit")
    table.add_column("value", justify="right")
    for name, speed in limits["largest_speed"].items():
        table.add_row(f"speed {name}", f"{speed:.3f} m/s")
    for foot, bounds in limits["viable_offset"].items():
        for axis, (low, high) in bounds.items():
            name = f"viable DCM offset {axis}, {foot.replace('_', ' ')}"
            table.add_row(name, f"{low:+.4f} .. {high:+.4f} m")
    console.print(table)
    console.print(
        "Speeds: longest steps in the shortest time. Offsets: DCM relative to the left foot as it "
        "lands (the right foot's are mirrored); outside, no sequence of steps saves the robot, "
        "however fast its leg."
    )
    if "push_limit" in limits:
        print_push_limits(limits["push_limit"], console)

"""What a robot can do at most, in numbers and as tables: speeds, viable DCM offsets, and pushes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from surefoot.dcm.nominal_gait import largest_speed, nominal_gait
from surefoot.dcm.push_limit import (
    ImpulseLimit,
    causal_push_limit,
    check_leg,
    fixed_steps_limit,
    push_limit,
)
from surefoot.dcm.pushes import eight_directions
from surefoot.dcm.viability import viable_offsets
from surefoot.errors import VelocityError
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.show.words import finite

_FEET = {"point_foot": "A point foot", "finite_foot": "The whole sole"}
"""How the feet are called in the numbers, and over a table."""

_SAME = 0.9995
"""From this share on the two limits are printed as one [-]."""

_WIDTH = 92
"""No table is wider, that its rows stay easy to follow [characters]."""


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


def push_phases(robot: Robot, velocity: tuple[float, float], count: int) -> list[float]:
    """So many times in the nominal step, evenly from the touchdown on [s].

    Raises:
        VelocityError: the velocity cannot be walked.
    """
    step_duration = nominal_gait(robot, velocity).step_duration
    return [step_duration * number / count for number in range(count)]


def push_limits_summary(
    robots: Sequence[Robot],
    phases: Sequence[float],
    velocity: tuple[float, float],
    durations: Sequence[float],
) -> dict[str, Any]:
    """The largest survivable pushes as plain numbers; SI, a limit that a leg has not is None.

    A leg that cannot swing as the gait wants has no limits, but the reason, `refused`.

    Args:
        robots: the same one with several legs.
        phases: times from the touchdown of the right foot to the push [s].
        velocity: at which it walks [m/s].
        durations: of the push [s].

    Raises:
        VelocityError: no leg can swing as the gait wants.
    """
    gait, refused = nominal_gait(robots[0], velocity), {}
    for number, robot in enumerate(robots):
        try:
            check_leg(robot, gait)
        except VelocityError as error:
            refused[number] = error
    if len(refused) == len(robots):
        raise refused[0]
    return {
        "velocity": list(velocity),
        "hip": robots[0].hip,
        "support_side": Side.RIGHT.name.lower(),
        "directions": {name: list(way) for name, way in eight_directions(Side.RIGHT).items()},
        "elapsed": list(phases),
        "legs": [
            {
                "leg_speed": finite(robot.swing.max_speed),
                "leg_acceleration": finite(robot.swing.max_acceleration),
                "duration": duration,
                **(
                    {"refused": refused[number].got}
                    if number in refused
                    else _impulses(robot, phases, velocity, duration)
                ),
            }
            for number, robot in enumerate(robots)
            for duration in durations
        ],
    }


def _impulses(
    robot: Robot, phases: Sequence[float], velocity: tuple[float, float], duration: float
) -> dict[str, Any]:
    """Impulses by foot and direction, of a push that is known and, `causal`, of one whose end is
    not; and those of the ZMP alone."""
    directions = eight_directions(Side.RIGHT)
    numbers: dict[str, Any] = {
        "fixed_steps": {
            name: _numbers([fixed_steps_limit(robot, way, duration=duration)])
            for name, way in directions.items()
        }
    }
    numbers["causal"] = {}
    for foot, reach in zip(_FEET, ((0.0, 0.0), robot.foot.half), strict=True):
        for found, limit in ((numbers, push_limit), (numbers["causal"], causal_push_limit)):
            found[foot] = {
                name: _numbers(
                    [
                        limit(
                            robot, way, velocity=velocity, elapsed=elapsed, duration=duration,
                            zmp_reach=reach,
                        )
                        for elapsed in phases
                    ]
                )
                for name, way in directions.items()
            }  # fmt: skip
    return numbers


def print_push_limits(limits: dict[str, Any], console: Console) -> None:
    """The largest survivable pushes, two tables for each leg; with the check, if it was made."""
    v_x, v_y = limits["velocity"]
    console.print(
        f"\n[bold]Theoretical limit: the largest push that can be survived[/], in a step on the\n"
        f"right foot of a walk at ({v_x:g}, {v_y:g}) m/s.\n"
        "Each entry: impulse in N s, and the change of velocity in m/s."
    )
    for leg in limits["legs"]:
        words = leg_words(leg["leg_speed"], leg["leg_acceleration"])
        console.print(f"\n[bold]{words[0].upper()}{words[1:]}[/], pushed for {leg['duration']:g} s")
        if "refused" in leg:
            console.print(f"No limit: it cannot swing as the gait wants ({leg['refused']}).")
            continue
        for foot in _FEET:
            width = min(console.width, _WIDTH)
            console.print(_table(limits["elapsed"], leg, foot, width))
            console.print(_of_unknown_end(limits["elapsed"], leg, foot, width))
    console.print(
        "\nOutward is towards the swing foot, inward over the standing foot to the other side. A "
        "point foot cannot move the ZMP, a sole moves it to its edge. 'fixed': steps as planned, "
        "the ZMP alone does what it can, at any time. The limits of a leg hold for each axis by "
        "itself. Taken for granted: the pendulum, and a push that is known as soon as it starts, "
        "its end included. If the end is not known, the DCM must be viable at every instant of it."
    )
    if "check" in limits:
        check = limits["check"]
        console.print(
            "Computed again along the axes, on a grid of time and swing foot. The largest "
            f"difference is {100.0 * check['fraction']:.2f} %: {check['impulse']:.1f} N s, on the "
            f"grid {check['grid_impulse']:.1f} N s, {check['direction']} at "
            f"{check['elapsed']:.2f} s, {'sole' if check['finite_foot'] else 'point foot'}, "
            f"{leg_words(check['leg_speed'], check['leg_acceleration'])}. Where an "
            f"unknown end costs most they differ by "
            f"{100.0 * check['causal']['fraction']:.2f} % at most."
        )


def _of_unknown_end(
    phases: Sequence[float], leg: dict[str, Any], foot: str, width: int
) -> Table | str:
    """The share of the limits that is left if the end of the push is not known."""
    shares = {name: _shares(leg, foot, name) for name in leg[foot]}
    if min(min(row) for row in shares.values()) >= _SAME:
        return "As much, if the end of the push is not known."
    table = _headed("Of that, if the end of the push is not known", leg[foot], width)
    for row, elapsed in enumerate(phases):
        percent = (100.0 * one[row] for one in shares.values())
        table.add_row(f"{elapsed:.2f}", *(f"{share:.0f} %" for share in percent))
    return table


def _shares(leg: dict[str, Any], foot: str, name: str) -> list[float]:
    known, causal = (limits[foot][name]["impulse"] for limits in (leg, leg["causal"]))
    return [one / of if of > 0.0 else 1.0 for one, of in zip(causal, known, strict=True)]


def _table(phases: Sequence[float], leg: dict[str, Any], foot: str, width: int) -> Table:
    table = _headed(_FEET[foot], leg[foot], width)
    for row, elapsed in enumerate(phases):
        table.add_row(
            f"{elapsed:.2f}",
            *(_entry(each["impulse"][row], each["delta_v"][row]) for each in leg[foot].values()),
        )
    if foot == "finite_foot":
        fixed = leg["fixed_steps"].values()
        table.add_row("fixed", *(_entry(each["impulse"][0], each["delta_v"][0]) for each in fixed))
    return table


def _headed(title: str, names: Iterable[str], width: int) -> Table:
    """An empty table with a column for the time of the push and one for each direction."""
    table = Table(
        title=title, title_justify="left", title_style="", box=None, pad_edge=False,
        padding=(0, 0, 0, 1), width=width, expand=True,
    )  # fmt: skip
    table.add_column("push\nat [s]", justify="right", no_wrap=True, header_style="bold")
    for name in names:
        first, _, second = name.partition("-")
        head = f"{first}\n{second}" if second else f"\n{first}"
        table.add_column(head, justify="right", no_wrap=True, header_style="bold")
    return table


def _entry(impulse: float, delta_v: float) -> str:
    return f"{impulse:.0f} [dim]{delta_v:.2f}[/]"


def leg_words(speed: float | None, acceleration: float | None) -> str:
    """A leg by its limits, each None if it has none."""
    bounds = [(speed, "m/s"), (acceleration, "m/s^2")]
    words = [f"{bound:g} {unit}" for bound, unit in bounds if bound is not None]
    return f"a leg of at most {' and '.join(words)}" if words else "an unlimited leg"


def _numbers(limits: Sequence[ImpulseLimit]) -> dict[str, list[float]]:
    return {
        "impulse": [limit.impulse for limit in limits],
        "delta_v": [limit.delta_v for limit in limits],
    }

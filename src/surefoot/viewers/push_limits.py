"""How large a push can be survived at all, in numbers and as a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from surefoot.models.footsteps import Side
from surefoot.models.robot import Robot
from surefoot.planning.nominal_gait import nominal_gait
from surefoot.planning.push_limit import (
    ImpulseLimit,
    axis_directions,
    fixed_steps_limit,
    push_limit,
)

_FEET = {"point_foot": "point", "finite_foot": "sole"}
"""How the feet are called in the numbers, and over a column."""

_WIDTH = 92
"""No table is wider, that its rows stay easy to follow [characters]."""


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
    duration: float,
) -> dict[str, Any]:
    """The largest survivable pushes as plain numbers; SI, an unlimited leg has the speed None.

    Args:
        robots: the same one with several legs.
        phases: times from the touchdown of the right foot to the push [s].
        velocity: at which it walks [m/s].
        duration: of the push [s].
    """
    directions = axis_directions(Side.RIGHT)
    return {
        "velocity": list(velocity),
        "duration": duration,
        "support_side": Side.RIGHT.name.lower(),
        "elapsed": list(phases),
        "fixed_steps": {
            name: _numbers([fixed_steps_limit(robots[0], way, duration=duration)])
            for name, way in directions.items()
        },
        "legs": [
            {
                "leg_speed": _finite(robot.swing.max_speed),
                **{
                    foot: {
                        name: _numbers(
                            [
                                push_limit(
                                    robot, way, velocity=velocity, elapsed=elapsed,
                                    duration=duration, zmp_reach=reach,
                                )
                                for elapsed in phases
                            ]
                        )
                        for name, way in directions.items()
                    }
                    for foot, reach in zip(_FEET, ((0.0, 0.0), robot.foot.half), strict=True)
                },
            }
            for robot in robots
        ],
    }  # fmt: skip


def print_push_limits(limits: dict[str, Any], console: Console) -> None:
    """The largest survivable pushes, a table for each leg; with the check, if it was made."""
    v_x, v_y = limits["velocity"]
    console.print(
        f"\n[bold]Largest push that any policy can survive[/]: {limits['duration']:g} s long, in a "
        f"step on the right foot of a walk at ({v_x:g}, {v_y:g}) m/s.\n"
        "Each entry: impulse in N s, and the change of velocity in m/s."
    )
    for leg in limits["legs"]:
        console.print(_table(limits, leg, min(console.width, _WIDTH)))
    console.print(
        "\nOutward is towards the swing foot, inward over the standing foot to the other side. A "
        "point foot cannot move the ZMP, a sole moves it to its edge. 'fixed': steps as planned, "
        "the ZMP alone does what it can, at any time. Taken for granted: the pendulum, a push "
        "that is known as soon as it starts, and a leg without inertia."
    )
    if "check" in limits:
        check = limits["check"]
        console.print(
            "Computed again on a grid of time and swing foot. The largest difference is "
            f"{100.0 * check['fraction']:.2f} %: {check['impulse']:.1f} N s, on the grid "
            f"{check['grid_impulse']:.1f} N s, {check['direction']} at {check['elapsed']:.2f} s, "
            f"{'sole' if check['finite_foot'] else 'point foot'}, "
            f"{_leg_words(check['leg_speed'])}."
        )


def _table(limits: dict[str, Any], leg: dict[str, Any], width: int) -> Table:
    words = _leg_words(leg["leg_speed"])
    title = f"\n[bold]{words[0].upper()}{words[1:]}[/]"
    table = Table(
        title=title, title_justify="left", title_style="", box=None, pad_edge=False,
        padding=(0, 0, 0, 1), width=width, expand=True,
    )  # fmt: skip
    table.add_column("push\nat [s]", justify="right", no_wrap=True, header_style="bold")
    for foot in _FEET:
        for name in limits["fixed_steps"]:
            table.add_column(
                f"{_FEET[foot]}\n{name}", justify="right", no_wrap=True, header_style="bold"
            )
    for row, elapsed in enumerate(limits["elapsed"]):
        entries = (leg[foot][name] for foot in _FEET for name in limits["fixed_steps"])
        table.add_row(
            f"{elapsed:.2f}",
            *(_entry(entry["impulse"][row], entry["delta_v"][row]) for entry in entries),
        )
    fixed = limits["fixed_steps"].values()
    table.add_row(
        "fixed",
        *(_entry(0.0, 0.0) for _ in fixed),
        *(_entry(entry["impulse"][0], entry["delta_v"][0]) for entry in fixed),
    )
    return table


def _entry(impulse: float, delta_v: float) -> str:
    return f"{impulse:.0f} [dim]{delta_v:.2f}[/]"


def _leg_words(speed: float | None) -> str:
    return "an unlimited leg" if speed is None else f"a leg of at most {speed:g} m/s"


def _numbers(limits: Sequence[ImpulseLimit]) -> dict[str, list[float]]:
    return {
        "impulse": [limit.impulse for limit in limits],
        "delta_v": [limit.delta_v for limit in limits],
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None

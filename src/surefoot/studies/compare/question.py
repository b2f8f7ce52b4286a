"""What a comparison of methods measures: its cells, and what must be the same for all of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from typing import Any

from msgspec import to_builtins

from surefoot.checks import check_number
from surefoot.control.registry import find_method, methods
from surefoot.dcm.nominal_gait import nominal_gait
from surefoot.dcm.push_limit import check_leg
from surefoot.dcm.pushes import push_direction
from surefoot.errors import ParameterError
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.studies.compare.conditions import UNDISTURBED, condition

PUSHED_STEP = 2
"""The push comes in the third step, as in the paper; it is one on the right foot."""


def every_method() -> tuple[str, ...]:
    """The keys of all methods but those that take milliseconds for one decision."""
    return tuple(one.key for one in methods() if not one.slow)


@dataclass(frozen=True)
class Cell:
    """One limit to be measured: the smallest failing impulse of a method in one situation.

    Attributes:
        method: its key.
        angle: of the push, from forward (0) towards the swing foot (90), back (180) and away from
            the swing foot (270) [deg].
        phase: when the push begins, as a fraction of the step.
        push_duration: how long it lasts [s].
        leg_speed: limit of the swing foot; inf for none [m/s].
        disturbance: key of what else is wrong, see `studies.compare.conditions`.
    """

    method: str
    angle: float
    phase: float
    push_duration: float
    leg_speed: float
    disturbance: str = UNDISTURBED


@dataclass(frozen=True)
class Protocol:
    """The same questions to every method.

    Args:
        robot: who is pushed; its leg speed is replaced by `leg_speeds`.
        velocity: commanded (v_x, v_y) [m/s].
        methods: keys of `control.registry`.
        directions: how many, evenly around; 4 are forward, outward, back and inward.
        phases: how many, evenly over a step.
        leg_speeds: limits of the swing foot; inf for none [m/s].
        push_durations: [s].
        step: of the scan over the impulse [N s].
        disturbances: keys of `conditions`. If anything but "none" is among them, a push is
            survived if the robot has not fallen by `recovery_time`: under noise nobody settles.
        seeds: with how many a disturbance is walked that is drawn; the worst counts.

    Raises:
        ParameterError: an argument is out of range, or there is nothing to measure.
        VelocityError: the velocity cannot be walked, or not on the slowest of the legs.
    """

    robot: Robot
    velocity: tuple[float, float] = (0.5, 0.0)
    methods: tuple[str, ...] = field(default_factory=every_method)
    directions: int = 4
    phases: int = 8
    leg_speeds: tuple[float, ...] = (3.0,)
    push_durations: tuple[float, ...] = (0.2,)
    step: float = 1.0
    disturbances: tuple[str, ...] = (UNDISTURBED,)
    seeds: int = 3

    def __post_init__(self) -> None:
        for key in self.methods:
            find_method(key)
        for key in self.disturbances:
            condition(key)
        for name, usual in (("directions", 4), ("phases", 8), ("seeds", 3)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise ParameterError(
                    f"`{name}` as a whole number of at least 1", repr(value), f"{usual} is usual"
                )
        check_number("step", self.step, 0.0, "N s", above=True)
        for name, unit in (
            ("leg_speeds", "m/s"), ("push_durations", "s"), ("methods", "-"), ("disturbances", "-"),
        ):  # fmt: skip
            values = getattr(self, name)
            if not values:
                raise ParameterError(f"at least one of `{name}`", "none", "name one")
            if len(set(values)) < len(values):
                raise ParameterError(
                    f"`{name}` without repetition", f"{values}", "name each of them once"
                )
            for value in values if unit != "-" else ():
                check_number(name, value, 0.0, unit, above=True, endless=name == "leg_speeds")
        for leg_speed in self.leg_speeds:
            check_leg(self.robot_with(leg_speed), nominal_gait(self.robot, self.velocity))

    def cells(self) -> Iterator[Cell]:
        """Everything that is to be measured."""
        for key, disturbance, leg_speed, duration, phase, direction in product(
            self.methods,
            self.disturbances,
            self.leg_speeds,
            self.push_durations,
            range(self.phases),
            range(self.directions),
        ):
            angle = 360.0 * direction / self.directions
            yield Cell(key, angle, phase / self.phases, duration, leg_speed, disturbance)

    @property
    def must_settle(self) -> bool:
        """Whether a push is survived only if the robot is back on its gait."""
        return self.disturbances == (UNDISTURBED,)

    def walked(self, cell: Cell) -> Cell:
        """The cell that is really walked for this one.

        Fixed steps are the same steps, to the bit, on every leg that is fast enough for them, if
        nothing disturbs them.
        """
        gait = nominal_gait(self.robot, self.velocity)
        fixed = find_method(cell.method).fixed_steps and cell.disturbance == UNDISTURBED
        if fixed and cell.leg_speed >= gait.swing_speed:
            return replace(cell, leg_speed=math.inf)
        return cell

    def robot_with(self, leg_speed: float) -> Robot:
        """The robot with this limit of its swing foot [m/s]."""
        return self.robot.with_leg(max_speed=leg_speed)

    def push_start(self, phase: float) -> float:
        """When the push begins [s]."""
        return (PUSHED_STEP + phase) * nominal_gait(self.robot, self.velocity).step_duration

    def direction(self, angle: float) -> tuple[float, float]:
        """The push's unit vector (x, y) in the world; exact on the axes.

        In the pushed step the right foot stands, so outward is to the left.
        """
        return push_direction(angle, Side.RIGHT)

    def same_for_all(self) -> dict[str, Any]:
        """What all cells of one table must have in common, as plain values."""
        return {
            "robot": to_builtins(self.robot),
            "velocity": list(self.velocity),
            "step": self.step,
            "must_settle": self.must_settle,
            "seeds": self.seeds,
        }


def cell_key(cell: Cell) -> tuple[str, float, float, float, float, str]:
    """A cell as a key; angles and phases rounded, so that they survive a file."""
    values = asdict(cell)
    return (
        values["method"],
        round(values["angle"], 6),
        round(values["phase"], 9),
        values["push_duration"],
        values["leg_speed"],
        values["disturbance"],
    )

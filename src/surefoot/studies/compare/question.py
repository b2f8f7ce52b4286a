"""What a comparison of methods asks: its cells, and what must be the same for all of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, ClassVar

from surefoot.checks import check_number
from surefoot.control.registry import find_method, methods
from surefoot.errors import MissingExtraError, RobotError
from surefoot.robot.robot import Robot
from surefoot.studies.compare import measure
from surefoot.studies.compare.disturbances import UNDISTURBED, named_disturbance
from surefoot.studies.engine.pushed_walk import (
    PushCell,
    PushedStudy,
    check_count,
    check_different,
    check_sizes,
    push_cells,
)
from surefoot.studies.engine.study import installed_version
from surefoot.studies.engine.table import Row

SOLVERS = ("daqp", "casadi")
"""Libraries that decide for some methods."""


def every_method() -> tuple[str, ...]:
    """The keys of all methods but those that take milliseconds for one decision."""
    return tuple(one.key for one in methods() if not one.slow)


def able_methods(robot: Robot, velocity: tuple[float, float]) -> tuple[list[str], dict[str, str]]:
    """Which methods can be compared on a robot at a velocity [m/s], and why the others cannot.

    Returns:
        Their keys, but for the slow ones; and by its key, the reason of each that is left out.
    """
    able, left_out = [], {}
    for key in every_method():
        try:
            find_method(key).controller(robot, velocity)
        except (RobotError, MissingExtraError) as error:
            left_out[key] = str(error)
        else:
            able.append(key)
    return able, left_out


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
        disturbance: key of one of `studies.compare.disturbances`.
    """

    method: str
    angle: float
    phase: float
    push_duration: float
    leg_speed: float
    disturbance: str = UNDISTURBED

    @property
    def push(self) -> PushCell:
        """The push, but for its size."""
        return PushCell(self.angle, self.phase, self.push_duration)


@dataclass(frozen=True)
class Comparison(PushedStudy):
    """The same questions to every method; rows see `studies.compare.measure.measure`.

    Args, beside those of `PushedStudy`:
        directions: how many, evenly around; 4 are forward, outward, back and inward.
        phases: how many, evenly over a step.
        push_durations: [s].
        step: of the scan over the impulse [N s].
        disturbances: keys of `named_disturbance`. If anything but "none" is among them, a push is
            survived if the robot has not fallen by `recovery_time`: under noise no method settles.
        seeds: with how many a disturbance is walked that is drawn; the worst counts.
    """

    methods: tuple[str, ...] = field(default_factory=every_method)
    directions: int = 4
    phases: int = 8
    push_durations: tuple[float, ...] = (0.2,)
    step: float = 1.0
    disturbances: tuple[str, ...] = (UNDISTURBED,)
    seeds: int = 3

    NAME: ClassVar[str] = "compare"
    LIBRARIES: ClassVar[tuple[str, ...]] = ("numpy", "numba", *SOLVERS)

    def __post_init__(self) -> None:
        super().__post_init__()
        for key in self.disturbances:
            named_disturbance(key)
        for name, usual in (("directions", 4), ("phases", 8), ("seeds", 3)):
            check_count(name, getattr(self, name), usual)
        check_number("step", self.step, 0.0, "N s", above=True)
        check_sizes("push_durations", self.push_durations, "s")
        check_different("disturbances", self.disturbances)

    @property
    def must_settle(self) -> bool:
        """Whether a push is survived only if the robot is back on its gait."""
        return self.disturbances == (UNDISTURBED,)

    def cells(self) -> Iterator[Cell]:
        """See `Study`."""
        for key, disturbance, leg_speed, push in product(
            self.methods,
            self.disturbances,
            self.leg_speeds,
            push_cells(self.directions, self.phases, self.push_durations),
        ):
            yield Cell(key, push.angle, push.phase, push.push_duration, leg_speed, disturbance)

    def measure(self, cell: Cell) -> Row:
        """See `Study`."""
        return measure.measure(self, cell)

    def measured_as(self, cell: Cell) -> Cell:
        """See `Study`. Fixed steps are the same steps, to the bit, on every leg that is fast enough
        for them, if nothing disturbs them."""
        fixed = find_method(cell.method).fixed_steps and cell.disturbance == UNDISTURBED
        if fixed and cell.leg_speed >= self.walk.gait.swing_speed:
            return replace(cell, leg_speed=math.inf)
        return cell

    def answer(self, cell: Cell, row: Row) -> Row:
        """See `Study`. The impulse is that of the other leg, the limits are not."""
        return super().answer(cell, row) | self.limits(cell)

    def limits(self, cell: Cell) -> dict[str, float]:
        """The theoretical limits of a cell, see `PushedWalk.limits`: of the robot that is really
        pushed, whatever its controller is given."""
        walk = self.walk.on_leg(cell.leg_speed)
        return self.walk.limits(cell.push, named_disturbance(cell.disturbance).plant(walk.robot))

    def common(self) -> dict[str, Any]:
        """See `Study`."""
        return super().common() | {
            "step": self.step,
            "must_settle": self.must_settle,
            "seeds": self.seeds,
            "solvers": {name: installed_version(name) for name in SOLVERS},
        }

    def notes(self, rows: Sequence[Row]) -> dict[str, Any]:
        """`methods` that were measured, see `studies.compare.measure.method_notes`; `disturbances`
        with `key`, `label` and how many `walks` a scan takes, the worst of which counts."""
        return {
            "methods": measure.method_notes(self, rows),
            "disturbances": [
                {"key": one.key, "label": one.label, "walks": len(one.walks(self.seeds))}
                for one in map(named_disturbance, self.disturbances)
            ],
        }

"""What a tuning asks: of which method on which robot, by which pushes, within which ranges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from msgspec import to_builtins

from surefoot.checks import check_number, check_seed
from surefoot.control.settings import with_settings
from surefoot.robot.robot import Robot
from surefoot.studies.engine.pushed_walk import PushedWalk, push_cells
from surefoot.studies.engine.study import installed_version, stamp
from surefoot.studies.tune.measure import Pushed, Score, score
from surefoot.studies.tune.parameters import (
    Parameter,
    changed_settings,
    chosen_parameters,
    default_settings,
)
from surefoot.version import VERSION

SMALL_SHARE = 0.1
"""A small push is this share of the smallest limit."""

STEP_SHARE = 0.02
"""The usual step of the scan over the impulse, as a share of the smallest limit."""


@dataclass(frozen=True)
class Question:
    """What is tuned, and by which pushes.

    Args:
        robot: who is pushed, with the speed limit that its leg is to have.
        velocity: commanded (v_x, v_y) [m/s].
        method: key of a control method with parameters to search.
        asked: these, `NAME` or `NAME=LOW:HIGH`; all usual ones if none.
        directions: of the pushes, evenly around.
        phases: of the pushes, evenly over a step.
        step: of the scan over the impulse, a share of the smallest limit [-].
        seed: of the search.

    Raises:
        ParameterError: an argument is out of range, or the method has no such parameters.
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the method cannot control this robot.
    """

    robot: Robot
    velocity: tuple[float, float] = (0.5, 0.0)
    method: str = "unified"
    asked: tuple[str, ...] = ()
    directions: int = 4
    phases: int = 2
    step: float = STEP_SHARE
    seed: int = 0
    parameters: tuple[Parameter, ...] = field(init=False)
    defaults: dict[str, Any] = field(init=False, repr=False)
    walk: PushedWalk = field(init=False, repr=False)
    scan_step: float = field(init=False)
    seen: tuple[Pushed, ...] = field(init=False, repr=False)
    unseen: tuple[Pushed, ...] = field(init=False, repr=False)
    impulse: float = field(init=False)

    def __post_init__(self) -> None:
        check_seed(self.seed)
        check_number("step", self.step, 0.0, "-", above=True)
        chosen = chosen_parameters(self.method, self.asked, self.robot, self.velocity)
        object.__setattr__(self, "parameters", chosen)
        # A robot that the method cannot control is refused now, not in a trial.
        defaults = default_settings(self.method, self.robot, self.velocity)
        object.__setattr__(self, "defaults", defaults)
        walk = PushedWalk(self.robot, self.velocity)
        walk.check_leg()
        cells = push_cells(self.directions, self.phases)
        # What the search does not see lies half-way between what it does.
        others = [
            replace(
                cell,
                angle=cell.angle + 180.0 / self.directions,
                phase=cell.phase + 0.5 / self.phases,
            )
            for cell in cells
        ]
        for name, some in (("seen", cells), ("unseen", others)):
            pushed = tuple(Pushed(one, walk.limits(one)["limit_finite"]) for one in some)
            object.__setattr__(self, name, pushed)
        smallest = min(one.limit for one in self.seen)
        object.__setattr__(self, "walk", walk)
        object.__setattr__(self, "scan_step", float(f"{self.step * smallest:.2g}"))
        object.__setattr__(self, "impulse", float(f"{SMALL_SHARE * smallest:.2g}"))

    @property
    def start(self) -> dict[str, float]:
        """The default of every parameter."""
        return {one.name: one.read(self.defaults) for one in self.parameters}

    def settings(self, values: Mapping[str, float]) -> dict[str, Any]:
        """What is not as by default with these values of the parameters."""
        return changed_settings(self.parameters, values, self.defaults)

    def measure(
        self, values: Mapping[str, float], cells: Sequence[Pushed], workers: int | None
    ) -> Score:
        """How the method does with these values of the parameters.

        Raises:
            SurefootError: it refuses them.
        """
        controller = with_settings(self.method, self.robot, self.velocity, self.settings(values))
        return score(controller, self.walk, cells, self.impulse, self.scan_step, workers=workers)

    def common(self) -> dict[str, Any]:
        """What a folder is kept for, as plain values."""
        return {
            "robot": to_builtins(self.robot),
            "velocity": list(self.velocity),
            "method": self.method,
            "parameters": [asdict(one) for one in self.parameters],
            "directions": self.directions,
            "phases": self.phases,
            "step": self.step,
            "seed": self.seed,
            "version": VERSION,
            "sources": stamp(type(self)),
            "optuna": installed_version("optuna"),
        }

    def provenance(self) -> dict[str, str]:
        """What a report must say of the question to have it answered again."""
        swing = self.robot.swing
        return {
            "version": VERSION,
            "sources": stamp(type(self))[:16],
            "robot": self.robot.name,
            "velocity": f"{self.velocity[0]:g}, {self.velocity[1]:g} m/s",
            "leg": f"{swing.max_speed:g} m/s, {swing.max_acceleration:g} m/s^2",
            "controller": self.method,
            "pushes": f"{self.directions} directions, {self.phases} phases of the step, "
            f"{self.seen[0].cell.push_duration:g} s long",
            "scan": f"in steps of {self.scan_step:g} N s",
            "small push": f"{self.impulse:g} N s",
        }

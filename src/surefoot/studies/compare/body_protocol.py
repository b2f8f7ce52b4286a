"""What a comparison of methods on a body measures: its cells, and what is the same for all."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from msgspec import to_builtins

from surefoot.checks import check_number, check_pair
from surefoot.control.registry import find_method
from surefoot.control.unified.fixed_landing import fixed_place, fixed_timing
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.multibody import SIDES
from surefoot.robot.robot import Robot
from surefoot.worlds.body.gait import body_controller, body_parameters
from surefoot.worlds.body.noise import BodyNoise

PUSH_DURATION = 0.2
"""How long every push lasts [s]."""

RECOVERY_TIME = 5.0
"""For so long a robot has to walk on after the push [s]."""

PUSHED_STEP = 8
"""No step before this one is pushed: two in place come first, then the gait settles."""

DIRECTIONS = ("forward", "back", "stance side", "swing side")
"""Where pushes go; the stance side is that of the foot on the ground."""


@dataclass(frozen=True)
class BodyMethod:
    """A way to keep a body on its feet.

    Attributes:
        key: its name on the command line.
        label: its name in tables.
        adapts: what it changes when it is pushed.
        make: its controller, from robot and velocity.
    """

    key: str
    label: str
    adapts: str
    make: Callable[[Robot, tuple[float, float]], Controller]


def _published(key: str) -> BodyMethod:
    one = find_method(key)
    return BodyMethod(
        key, one.label, one.adapts, lambda robot, velocity: body_controller(key, robot, velocity)
    )


BODY_METHODS = (
    _published("tracking"),
    _published("capture-point"),
    _published("step-timing"),
    _published("hybrid"),
    BodyMethod(
        "unified-fixed-timing",
        "unified, timing fixed",
        "ZMP, step location",
        lambda robot, velocity: fixed_timing(robot, velocity, **body_parameters("unified", robot)),
    ),
    BodyMethod(
        "unified-fixed-place",
        "unified, place fixed",
        "ZMP, timing",
        lambda robot, velocity: fixed_place(robot, velocity, **body_parameters("unified", robot)),
    ),
    _published("unified"),
)
"""In the order in which they are shown."""


def body_method(key: str) -> BodyMethod:
    """A method by its name on the command line.

    Raises:
        ParameterError: there is none of that name for a body.
    """
    for one in BODY_METHODS:
        if one.key == key:
            return one
    names = ", ".join(one.key for one in BODY_METHODS)
    raise ParameterError(f"a method for a body ({names})", repr(key), "choose one of these")


@dataclass(frozen=True)
class BodyCell:
    """One limit to be measured: the smallest impulse that fells a method in one situation.

    Attributes:
        method: its key.
        direction: one of `DIRECTIONS`.
        phase: when the push begins, as a fraction of the step.
        foot: that stands then, "left" or "right".
    """

    method: str
    direction: str
    phase: float
    foot: str


@dataclass(frozen=True)
class BodyProtocol:
    """The same questions to every method.

    Args:
        robot: who is pushed; it has a `[body]`.
        velocity: commanded [m/s].
        methods: keys of `BODY_METHODS`.
        phases: how many, evenly over a step.
        step: of the scan over the impulse [N s].
        largest: where a scan gives up, over the mass [m/s].
        estimate: whether the walker is told an estimate from sensors with the usual noise; else it
            is the truth.

    Raises:
        ParameterError: an argument is out of range, or there is nothing to measure.
    """

    robot: Robot
    velocity: tuple[float, float] = (0.3, 0.0)
    methods: tuple[str, ...] = field(default_factory=lambda: tuple(one.key for one in BODY_METHODS))
    phases: int = 8
    step: float = 2.0
    largest: float = 3.0
    estimate: bool = False

    def __post_init__(self) -> None:
        for key in self.methods:
            body_method(key)
        check_pair("velocity", self.velocity, -math.inf, "m/s")
        check_number("step", self.step, 0.0, "N s", above=True)
        check_number("largest", self.largest, 0.0, "m/s", above=True)
        if isinstance(self.phases, bool) or not isinstance(self.phases, int) or self.phases < 1:
            raise ParameterError(
                "`phases` as a whole number of at least 1", repr(self.phases), "8 are usual"
            )
        if not self.methods or len(set(self.methods)) < len(self.methods):
            raise ParameterError(
                "at least one of `methods`, each of them once", f"{self.methods}", "name some"
            )

    @property
    def noise(self) -> BodyNoise | None:
        """Of the sensors, None if the truth is told."""
        return BodyNoise.of(self.robot) if self.estimate else None

    def cells(self) -> Iterator[BodyCell]:
        """Everything that is to be measured; what shares a walk to the push is together."""
        for key, foot, phase, direction in product(
            self.methods, SIDES, range(self.phases), DIRECTIONS
        ):
            yield BodyCell(key, direction, phase / self.phases, foot)

    def impulses(self, mass: float) -> list[float]:
        """What is tried, from nothing upwards [N s]."""
        return [self.step * k for k in range(math.floor(self.largest * mass / self.step) + 1)]

    def same_for_all(self) -> dict[str, Any]:
        """What all cells of one table must have in common, as plain values."""
        return {
            "robot": to_builtins(self.robot),
            "velocity": list(self.velocity),
            "step": self.step,
            "largest": self.largest,
            "estimate": self.estimate,
            "noise": repr(self.noise),
            "push_duration": PUSH_DURATION,
            "recovery_time": RECOVERY_TIME,
            "pushed_step": PUSHED_STEP,
        }


def push_of(cell: BodyCell, start: float, impulse: float) -> Push:
    """The push of a cell.

    Args:
        cell: says where to.
        start: when it begins [s].
        impulse: how strong it is [N s].
    """
    force = impulse / PUSH_DURATION
    stance = 1.0 if cell.foot == "left" else -1.0
    x, y = {
        "forward": (1.0, 0.0),
        "back": (-1.0, 0.0),
        "stance side": (0.0, stance),
        "swing side": (0.0, -stance),
    }[cell.direction]
    return Push(start, PUSH_DURATION, (force * x, force * y))

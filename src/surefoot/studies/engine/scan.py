"""How much push a controller survives: the smallest impulse that fails.

Scanned upwards, never bisected: survival is not monotone in the impulse, and what counts is that
every smaller push is survived.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_pair
from surefoot.control.estimator import Estimator
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.rollout.outcome import recovery_time
from surefoot.worlds.point.batch import simulate_batch

LARGEST = 2.1
"""Where a scan gives up, as a multiple of m sqrt(g h)."""

LARGEST_SHARE, LARGEST_BEYOND = 1.25, 50.0
"""Where a study that knows the limit gives up: this share of it [-], and this much more [N s]. A
trunk is a freedom that the limit does not know, and an observer's error may let a walk survive by
luck what it could not know."""

FAILURES = ("none", "unsettled", "fell")
"""What became of the smallest failing push: there was none, or the robot kept walking beside its
gait, or it fell."""

COMPILED_PORTION, PORTION = 64, 8
"""How many impulses are tried at once, with a compiled controller and without."""


@dataclass(frozen=True)
class PushLimit:
    """The smallest failing impulse in one direction.

    Attributes:
        direction: unit vector of the push (x, y).
        impulse: the smallest that fails, 0 if the gait does not settle unpushed, inf if none up to
            `scanned` does [N s].
        delta_v: impulse / mass [m/s].
        fell: whether it fell there; otherwise it kept walking without settling.
        scanned: the largest impulse that was tried [N s].
        step: distance between neighbouring impulses [N s].
    """

    direction: tuple[float, float]
    impulse: float
    delta_v: float
    fell: bool
    scanned: float
    step: float

    @property
    def failure(self) -> str:
        """One of `FAILURES`."""
        none, unsettled, fell = FAILURES
        return none if math.isinf(self.impulse) else fell if self.fell else unsettled

    @property
    def survived(self) -> float:
        """The largest impulse that was tried below which all are survived [N s]."""
        return min(max(self.impulse - self.step, 0.0), self.scanned)


def smallest_failing_push(
    controller: Controller,
    direction: tuple[float, float],
    *,
    start: float = 1.1,
    duration: float = 0.2,
    step: float = 1.0,
    largest: float | None = None,
    first_support: Side = Side.RIGHT,
    workers: int | None = None,
    plant: Robot | None = None,
    disturbance: Disturbance | None = None,
    estimator: Estimator | None = None,
    must_settle: bool = True,
) -> PushLimit:
    """Scan the impulse upwards from zero until the robot does not recover.

    Recovered: it never falls, and within `recovery_time` after the push it is settled on the
    nominal gait (see `rollout.outcome`; of the paper's biped 8 s, and 1 cm). Under noise or with
    an offset no method settles; without `must_settle` it is enough not to have fallen by then.

    Start, duration and step of the scan are part of the question, by default those of the paper's
    biped: for a robot of another size give them as shares of its T_nom and of its `push_limit`.

    Args:
        controller: what decides.
        direction: of the push (x, y), of any length but zero.
        start: when the push begins [s].
        duration: how long it lasts [s].
        step: distance between neighbouring impulses [N s].
        largest: where the scan gives up; if None at 2.1 m sqrt(g h), 400 for the paper's biped
            [N s].
        first_support: the foot that stands in the first step.
        workers: threads, all cores if None.
        plant: the robot that is pushed, if it is not the one that the controller is given.
        disturbance: of every walk, as for `simulate`.
        estimator: between what is measured and the controller.
        must_settle: whether a robot that walks on, but beside its gait, has failed too.

    Returns:
        The limit.

    Raises:
        ParameterError: the direction is zero, a number is not positive, or the delay is no whole
            number of control periods.
    """
    check_pair("direction", direction, -math.inf, "-")
    length = math.hypot(*direction)
    if length == 0.0:
        raise ParameterError(
            "a direction (x, y) of some length", repr(direction), "write (1.0, 0.0) for forward"
        )
    pushed = plant or controller.robot
    if largest is None:
        largest = LARGEST * pushed.mass * math.sqrt(pushed.gravity * pushed.com_height)
    for name, value, unit in (
        ("duration", duration, "s"), ("step", step, "N s"), ("largest", largest, "N s"),
    ):  # fmt: skip
        check_number(name, value, 0.0, unit, above=True)
    unit_vector = (direction[0] / length, direction[1] / length)
    impulses: NDArray[np.float64] = step * np.arange(math.floor(largest / step) + 1.0)
    # In portions, so that a scan ends soon after the first failure.
    size = PORTION if controller.kernel is None else COMPILED_PORTION
    for portion in np.array_split(impulses, math.ceil(len(impulses) / size)):
        pushes = [
            [Push(start, duration, _scaled(unit_vector, impulse / duration))] for impulse in portion
        ]
        results = simulate_batch(
            controller,
            pushes,
            start + duration + recovery_time(controller),
            first_support=first_support,
            stop_when_settled=must_settle,
            workers=workers,
            plant=plant,
            disturbance=disturbance,
            estimator=estimator,
        )
        failed = np.flatnonzero(~results["settled"] if must_settle else results["fallen"])
        if len(failed):
            impulse = float(portion[failed[0]])
            fell = bool(results["fallen"][failed[0]])
            return PushLimit(unit_vector, impulse, impulse / pushed.mass, fell, impulse, step)
    return PushLimit(unit_vector, math.inf, math.inf, False, float(impulses[-1]), step)


def _scaled(vector: tuple[float, float], factor: float) -> tuple[float, float]:
    return (float(vector[0] * factor), float(vector[1] * factor))

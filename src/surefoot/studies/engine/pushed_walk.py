"""A steady walk that is pushed once: when, where to, the theoretical limits, and the answer.

Studies of pushes on a point mass ask about the same walk: the push comes in the third step, on the
right foot, so outward is to the left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from surefoot.checks import check_number, check_pair
from surefoot.control.registry import find_method
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.dcm.push_limit import PushCase, check_leg, fixed_steps_limit
from surefoot.dcm.pushes import Push, push_direction
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.outcome import Outcome
from surefoot.studies.engine.study import Study
from surefoot.worlds.point.simulate import simulate

PUSHED_STEP = 2
"""The push comes in the third step, as in the paper; it is one on the right foot."""

PUSHED_SIDE = Side.RIGHT
"""The foot that stands in that step, and so in the first one."""

ANSWER_TIME = 2.5
"""How long after the beginning of a push its answer is measured [s]."""


@dataclass(frozen=True)
class PushCell:
    """One push, but for its size.

    Attributes:
        angle: from forward (0) towards the swing foot (90), back (180) and away from the swing
            foot (270) [deg].
        phase: when the push begins, as a fraction of the step.
        push_duration: how long it lasts [s].
    """

    angle: float
    phase: float
    push_duration: float


def push_cells(
    directions: int, phases: int, push_durations: tuple[float, ...] = (0.2,)
) -> list[PushCell]:
    """Pushes evenly around and evenly over a step.

    Args:
        directions: how many; 4 are forward, outward, back and inward.
        phases: how many.
        push_durations: [s].

    Raises:
        ParameterError: a number is no whole one, or less than 1.
    """
    check_count("directions", directions, 4)
    check_count("phases", phases, 8)
    return [
        PushCell(360.0 * direction / directions, phase / phases, duration)
        for duration, phase, direction in product(push_durations, range(phases), range(directions))
    ]


def check_count(name: str, value: int, usual: int) -> None:
    """Refuse what is no whole number of at least 1.

    Raises:
        ParameterError: it is none; the message names the usual one.
    """
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise ParameterError(
            f"`{name}` as a whole number of at least 1", repr(value), f"{usual} is usual"
        )


def check_sizes(name: str, values: Sequence[float], unit: str, *, endless: bool = False) -> None:
    """Refuse numbers of which there is none, or one twice, or one that is not above 0.

    Args:
        name: what the caller calls them.
        values: what the caller gave.
        unit: of each.
        endless: whether infinity is allowed.

    Raises:
        ParameterError: they are refused.
    """
    check_different(name, values)
    for value in values:
        check_number(name, value, 0.0, unit, above=True, endless=endless)


def check_different(name: str, values: Sequence[Any]) -> None:
    """Refuse a list that is empty, or that holds something twice.

    Raises:
        ParameterError: it is refused.
    """
    if not values:
        raise ParameterError(f"at least one of `{name}`", "none", "name one")
    if len(set(values)) < len(values):
        raise ParameterError(f"`{name}` without repetition", f"{values}", "name each of them once")


def find_named(what: str, known: Sequence[Any], key: str) -> Any:
    """One of several, each with a `key`, by its name on the command line.

    Raises:
        ParameterError: there is none of that name; the message lists them.
    """
    for one in known:
        if one.key == key:
            return one
    names = ", ".join(one.key for one in known)
    raise ParameterError(f"{what} ({names})", repr(key), "choose one of these")


@dataclass(frozen=True)
class PushedWalk:
    """The walk.

    Args:
        robot: who walks.
        velocity: commanded (v_x, v_y) [m/s].

    Raises:
        VelocityError: from what needs its gait, if the velocity cannot be walked.
    """

    robot: Robot
    velocity: tuple[float, float] = (0.5, 0.0)

    @property
    def gait(self) -> NominalGait:
        """What it walks while nothing pushes it."""
        return nominal_gait(self.robot, self.velocity)

    def on_leg(self, leg_speed: float) -> PushedWalk:
        """The same walk with this limit of the swing foot; inf for none [m/s]."""
        return replace(self, robot=self.robot.with_leg(max_speed=leg_speed))

    def controller(self, key: str) -> Controller:
        """The controller of a method at its best on this robot; made once, since some take time.

        Raises:
            SurefootError: the method cannot control this robot, or its library is not installed.
        """
        return _controller(self, key)

    def check_leg(self) -> None:
        """Refuse a leg that is too slow for the gait.

        Raises:
            VelocityError: it is, or the velocity cannot be walked at all.
        """
        check_leg(self.robot, self.gait)

    def start(self, phase: float) -> float:
        """When a push of this phase begins [s]."""
        return (PUSHED_STEP + phase) * self.gait.step_duration

    def direction(self, angle: float) -> tuple[float, float]:
        """The unit vector (x, y) of an angle [deg] in the world; exact on the axes."""
        return push_direction(angle, PUSHED_SIDE)

    def push(self, cell: PushCell, impulse: float) -> Push:
        """The push of a cell with an impulse [N s]."""
        return Push.of_impulse(
            impulse, self.direction(cell.angle), self.start(cell.phase), cell.push_duration
        )

    def limits(self, cell: PushCell, plant: Robot | None = None) -> dict[str, float]:
        """The theoretical limits of a cell [N s].

        Args:
            cell: says when and where to.
            plant: the robot that is really pushed, if it is not the one of this walk.

        Returns:
            `limit_point` with the ZMP at rest in the centre of the foot, `limit_finite` with the
            whole sole, `limit_causal` with it for those who do not know when the push ends,
            `limit_fixed` with it but fixed steps.
        """
        robot = plant or self.robot
        point = PushCase(
            robot,
            self.direction(cell.angle),
            velocity=self.velocity,
            elapsed=self.start(cell.phase) - self.start(0.0),
            duration=cell.push_duration,
            support_side=PUSHED_SIDE,
        )
        whole = replace(point, zmp_reach=robot.foot.half)
        fixed = fixed_steps_limit(robot, point.direction, duration=cell.push_duration)
        return {
            "limit_point": point.limit().impulse,
            "limit_finite": whole.limit().impulse,
            "limit_causal": whole.causal_limit().impulse,
            "limit_fixed": fixed.impulse,
        }


@dataclass(frozen=True)
class MethodStudy(Study):
    """What studies of several methods share.

    Args:
        robot: who walks.
        velocity: commanded (v_x, v_y) [m/s].
        methods: their keys.

    Raises:
        ParameterError: an argument is out of range, or there is nothing to measure.
    """

    velocity: tuple[float, float] = (0.5, 0.0)
    methods: tuple[str, ...] = ("unified",)

    def __post_init__(self) -> None:
        for key in self.methods:
            self.method(key)
        check_pair("velocity", self.velocity, -math.inf, "m/s")
        check_different("methods", self.methods)

    def method(self, key: str) -> Any:
        """What is known of a method: a `Method`, or a `BodyMethod`.

        Raises:
            ParameterError: there is none of that name.
        """
        return find_method(key)

    def foreign_sources(self) -> dict[str, str]:
        """See `Study`."""
        return {key: self.method(key).sources for key in self.methods}

    def common(self) -> dict[str, Any]:
        """See `Study`."""
        return {"velocity": list(self.velocity)}

    def provenance(self) -> dict[str, str]:
        """See `Study`."""
        vx, vy = self.velocity
        said = {"mass": f"{self.robot.mass:g} kg", "velocity": f"{vx:g}, {vy:g} m/s"}
        legs = self.robot.legs
        if legs is not None and legs.heavy:
            said["legs"] = "heavy, known" if legs.known else "heavy, unknown"
        return said


@dataclass(frozen=True)
class PushedStudy(MethodStudy):
    """What studies of pushes on a point mass share, beside that: on which legs it walks.

    Args, beside those of `MethodStudy`:
        leg_speeds: limits of the swing foot, in place of the robot's; inf for none [m/s].

    Raises:
        VelocityError: the velocity cannot be walked, or not on the slowest of the legs.
    """

    leg_speeds: tuple[float, ...] = (3.0,)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_sizes("leg_speeds", self.leg_speeds, "m/s", endless=True)
        for leg_speed in self.leg_speeds:
            self.walk.on_leg(leg_speed).check_leg()

    @property
    def walk(self) -> PushedWalk:
        """What is pushed."""
        return PushedWalk(self.robot, self.velocity)

    def check(self) -> None:
        """See `Study`. A method that cannot control this robot is refused."""
        for key in self.methods:
            self.walk.on_leg(self.leg_speeds[0]).controller(key)


@lru_cache(maxsize=8)
def _controller(walk: PushedWalk, key: str) -> Controller:
    one = find_method(key)
    return one.controller(walk.robot, walk.velocity, **one.compared)


@dataclass(frozen=True)
class Answer:
    """What a method did about one push.

    Attributes:
        zmp_peak: largest distance of the ZMP from the centre of the foot [m].
        zmp_rms: its root mean square from the push on, for `ANSWER_TIME` seconds [m].
        landing: largest change of a step vector against the nominal gait [m].
        timing: largest change of a step's duration [s].
        survived: whether it did not fall.
    """

    zmp_peak: float
    zmp_rms: float
    landing: float
    timing: float
    survived: bool


def answer(controller: Controller, push: Push) -> Answer:
    """Walk, push, and measure what the controller does about it; the right foot stands first.

    Args:
        controller: what decides.
        push: one push; the walk goes on for `ANSWER_TIME` seconds after its beginning.
    """
    rollout = simulate(controller, push.start + ANSWER_TIME, [push], first_support=PUSHED_SIDE)
    moved = np.hypot(*(rollout.zmp - rollout.support_foot).T)[rollout.time >= push.start]
    gait = controller.gait
    pushed = [step for step in rollout.footsteps if step.start + step.duration > push.start]
    changes = [np.subtract(step.step, gait.step(step.side)) for step in pushed]
    return Answer(
        zmp_peak=float(moved.max()),
        zmp_rms=float(np.sqrt(np.mean(moved**2))),
        landing=max((float(np.hypot(*change)) for change in changes), default=0.0),
        timing=max((abs(step.duration - gait.step_duration) for step in pushed), default=0.0),
        survived=rollout.outcome is not Outcome.FELL,
    )

"""The theoretical limit: the largest push that can be survived, its duration known or not.

A force F for a time D moves the DCM by F / (m omega^2) (1 - e^(-omega D)) in displacement of its
onset, whatever the feet do meanwhile. So no policy, however clever, survives more than

    J = F D = D m omega^2 / (1 - e^(-omega D)) room,     room = Z_up(foot, t) + c - o  on an axis,

where o is the DCM offset along the push at its onset, c how far the ZMP can move, and Z_up the
value of the step under way and all later ones (`dcm.viable_displacement`). Both axes land at the
same times, so the room is that of the best schedule of landings (`dcm.pushed_step`), in
every direction. The policy that steps by it survives all below. Own derivation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from functools import lru_cache, wraps
from inspect import signature
from typing import ParamSpec

from surefoot.checks import check_number, check_pair
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.dcm.pushed_step import PushedStep, best_schedule
from surefoot.dcm.swing_foot import quintic
from surefoot.errors import ParameterError, VelocityError
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

_ROUNDING = 1e-9
_P = ParamSpec("_P")


@dataclass(frozen=True)
class ImpulseLimit:
    """The largest impulse that can be survived in one direction.

    Attributes:
        direction: unit vector of the push (x, y).
        impulse: no policy survives more [N s]; 0 if not even the gait itself can be kept.
        delta_v: impulse / mass [m/s].
    """

    direction: tuple[float, float]
    impulse: float
    delta_v: float


@dataclass(frozen=True)
class PushCase:
    """A push on the nominal gait, but for its strength; arguments and errors as of `push_limit`."""

    robot: Robot
    direction: tuple[float, float]
    _: KW_ONLY
    velocity: tuple[float, float] = (0.5, 0.0)
    elapsed: float = 0.1
    duration: float = 0.2
    support_side: Side = Side.RIGHT
    zmp_reach: tuple[float, float] = (0.0, 0.0)
    step_duration: float | None = None
    together: bool = True

    def __post_init__(self) -> None:
        _unit(self.direction)
        check_number("duration", self.duration, 0.0, "s", above=True)
        check_pair("zmp_reach", self.zmp_reach, 0.0, "m")
        gait = self.gait
        check_number("elapsed", self.elapsed, 0.0, "s")
        if self.elapsed > gait.step_duration:
            raise ParameterError(
                f"`elapsed` inside the step, at most {gait.step_duration:.4g} [s]",
                repr(self.elapsed),
                "count from the touchdown that began the step under way",
            )
        check_leg(self.robot, gait)

    @property
    def gait(self) -> NominalGait:
        """What the robot walks before it is pushed."""
        return nominal_gait(self.robot, self.velocity, self.step_duration)

    @property
    def step(self) -> PushedStep:
        """The step in which the push begins."""
        side, (x, y) = Side(self.support_side), _unit(self.direction)
        state = gait_in_step(self.gait, side, self.elapsed)
        return PushedStep(self.robot, state, (x, side * y), self.zmp_reach, self.elapsed)

    def limit(self) -> ImpulseLimit:
        """See `push_limit`."""
        step = self.step
        room = best_schedule(step)[0] if self.together else min(step.axis_rooms().values())
        impulse = max(impulse_per_offset(self.robot, self.duration) * room, 0.0)
        return ImpulseLimit(_unit(self.direction), impulse, impulse / self.robot.mass)

    def causal_limit(self) -> ImpulseLimit:
        """See `causal_push_limit`."""
        known, share = self.limit(), _causal_share(self.step, self.duration, self.together)
        return ImpulseLimit(known.direction, share * known.impulse, share * known.delta_v)


def _of_push(
    case: Callable[_P, PushCase],
) -> Callable[[Callable[[PushCase], ImpulseLimit]], Callable[_P, ImpulseLimit]]:
    """Let a function of a `PushCase` take the arguments that make one."""

    def decorate(limit: Callable[[PushCase], ImpulseLimit]) -> Callable[_P, ImpulseLimit]:
        @wraps(limit)
        def called(*args: _P.args, **kwargs: _P.kwargs) -> ImpulseLimit:
            return limit(case(*args, **kwargs))

        shown = signature(case).replace(return_annotation="ImpulseLimit")
        called.__signature__ = shown  # type: ignore[attr-defined]
        return called

    return decorate


@_of_push(PushCase)
def push_limit(case: PushCase) -> ImpulseLimit:
    """The largest impulse that ANY policy can survive which learns of the push when it starts.

    The push acts on the nominal gait: DCM, swing foot and its velocity are what that has at
    `elapsed`. Both axes, pushed or not, have to be held by the same landing times.

    Args:
        robot: mass, height, gait limits, and the limits of its leg.
        direction: of the push (x, y) in the world, of any length but zero.
        velocity: at which it walks [m/s].
        elapsed: time from the touchdown to the push [s].
        duration: how long the push lasts [s].
        support_side: foot on the ground when the push starts.
        zmp_reach: how far the ZMP can move from the centre of the foot: (0, 0) for a point foot,
            `robot.foot.half` for the whole sole (x, y) [m].
        step_duration: T_nom of the gait, chosen from the velocity if None [s].
        together: whether both axes land at the same times. If not, every axis that is pushed lands
            at its own best times and nothing else counts: an upper bound that is quick to have.

    Returns:
        The limit.

    Raises:
        ParameterError: a direction of no length, a time outside the step, a negative reach.
        VelocityError: the velocity cannot be walked, or the leg is too weak for the smooth swing of
            its gait: then it is not known where the foot is when the push comes.
        RobotError: the leg is too slow to step at all.
    """
    return case.limit()


@_of_push(PushCase)
def causal_push_limit(case: PushCase) -> ImpulseLimit:
    """The largest impulse that a policy can survive which does not know when the push ends.

    The push has a constant force. At every instant of it the robot has to be viable: both sides of
    both axes, by the tables of `dcm.viable_displacement`,

        J_c = D m omega^2 f,    f the largest for which some schedule leaves no axis short.

    All smaller forces are survived for as long. Two errors: 0.1 % of the search; and an interrupted
    push is taken as saved if each axis is at its own times of landing. Arguments and errors are
    those of `push_limit`; the policy does not know `duration`.

    Returns:
        The limit, never above `push_limit`.
    """
    return case.causal_limit()


@lru_cache(maxsize=4096)
def _causal_share(step: PushedStep, duration: float, together: bool) -> float:
    """Which share of `push_limit` is left if it is not known when the push ends [-]."""
    if step.elapsed + duration <= step.robot.gait.step_duration[0]:
        return 1.0
    if together:
        room, times = best_schedule(step)
        return step.causal_share(duration, room, times) if room > 0.0 else 1.0
    rooms = step.axis_rooms()
    room = min(rooms.values())
    if room <= 0.0:
        return 1.0
    # An axis with much room may be left with less than one that loses nothing.
    left = [own * step.causal_share(duration, own, alone=axis) for (axis, _), own in rooms.items()]
    return min(1.0, min(left) / room)


def check_leg(robot: Robot, gait: NominalGait) -> None:
    """Refuse a leg that cannot swing as smoothly as the gait wants it to.

    Raises:
        VelocityError: the leg is too slow, or accelerates too little.
    """
    for name, unit, needed in (
        ("max_speed", "m/s", gait.swing_speed),
        ("max_acceleration", "m/s^2", gait.swing_acceleration),
    ):
        limit = getattr(robot.swing, name)
        if needed > limit * (1.0 + _ROUNDING):
            speed = math.hypot(*gait.velocity) * limit / needed
            raise VelocityError(
                f"a leg of at least {needed:.4g} {unit} for the swing of a gait at {gait.velocity}",
                f"`{name}` {limit} {unit}",
                f"walk at less than about {speed:.2g} m/s, or give a better leg",
            )


def fixed_steps_limit(
    robot: Robot, direction: tuple[float, float], *, duration: float = 0.2
) -> ImpulseLimit:
    """The largest impulse that can be survived by the ZMP alone, with every step as planned.

    With the steps fixed, the error of the DCM grows away from the ZMP as an offset does, and no
    further than half a foot can be caught: J = D m omega^2 / (1 - e^(-omega D)) c, at any velocity
    and any time. The axes do not touch each other, so this limit is exact in all directions.

    Args:
        robot: mass, height and foot.
        direction, duration: as of `push_limit`.

    Returns:
        The limit.

    Raises:
        ParameterError: a direction of no length, or a duration that is not positive.
    """
    unit = _unit(direction)
    check_number("duration", duration, 0.0, "s", above=True)
    room = min(
        half / abs(part) for half, part in zip(robot.foot.half, unit, strict=True) if part != 0.0
    )
    impulse = impulse_per_offset(robot, duration) * room
    return ImpulseLimit(unit, impulse, impulse / robot.mass)


def impulse_per_offset(robot: Robot, duration: float) -> float:
    """D m omega^2 / (1 - e^(-omega D)): the impulse that a metre of DCM offset can take [N s/m]."""
    return duration * robot.mass * robot.omega**2 / -math.expm1(-robot.omega * duration)


def gait_in_step(
    gait: NominalGait, support_side: Side, elapsed: float
) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
    """Where the nominal gait has DCM and swing foot, relative to the support foot.

    Args:
        gait: the nominal gait.
        support_side: foot on the ground.
        elapsed: t, time since touchdown [s].

    Returns:
        DCM offset, swing foot and its velocity, each as x forward and y towards the swing foot
        [m, m, m/s].
    """
    growth = math.exp(gait.omega * elapsed)
    offset_x, offset_y = gait.start_offset(support_side)
    behind, ahead = gait.step(support_side.other), gait.step(support_side)
    (foot_x, velocity_x, _), (foot_y, velocity_y, _) = (
        quintic(-start, 0.0, 0.0, end, 0.0, gait.step_duration, elapsed)
        for start, end in zip(behind, ahead, strict=True)
    )
    return (
        (growth * offset_x, support_side * growth * offset_y),
        (foot_x, support_side * foot_y),
        (velocity_x, support_side * velocity_y),
    )


def _unit(direction: tuple[float, float]) -> tuple[float, float]:
    """The direction at length 1.

    Raises:
        ParameterError: it is no pair of numbers, or has no length.
    """
    check_pair("direction", direction, -math.inf, "-")
    length = math.hypot(*direction)
    if length == 0.0:
        raise ParameterError(
            "a direction (x, y) of some length", repr(direction), "write (1.0, 0.0) for forward"
        )
    return direction[0] / length, direction[1] / length

"""The largest push that any policy can survive which learns of it when it starts.

A force F for a time D moves the DCM by F / (m omega^2) (1 - e^(-omega D)) in displacement of its
onset, whatever the feet do meanwhile. So no policy, however clever, survives more than

    J = F D = D m omega^2 / (1 - e^(-omega D)) room,     room = Z_up(foot, t) + c - o  on an axis,

where o is the DCM offset along the push at its onset, c how far the ZMP can move, and Z_up what the
step under way and all later ones are worth (`dcm.viable_displacement`). Both axes land at the
same times, so the room is that of the best schedule of landings (`dcm.pushed_step`), in
every direction. The policy that steps by it survives all below. Own derivation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from surefoot.checks import check_number, check_pair
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.dcm.pushed_step import PushedStep
from surefoot.dcm.swing_foot import quintic
from surefoot.errors import ParameterError, VelocityError
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

_ROUNDING = 1e-9


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


def push_limit(
    robot: Robot,
    direction: tuple[float, float],
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    elapsed: float = 0.1,
    duration: float = 0.2,
    support_side: Side = Side.RIGHT,
    zmp_reach: tuple[float, float] = (0.0, 0.0),
    step_duration: float | None = None,
    together: bool = True,
) -> ImpulseLimit:
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
            its gait: then nobody knows where the foot is when the push comes.
        RobotError: the leg is too slow to step at all.
    """
    unit = unit_direction(direction)
    check_number("duration", duration, 0.0, "s", above=True)
    check_pair("zmp_reach", zmp_reach, 0.0, "m")
    gait = nominal_gait(robot, (velocity[0], velocity[1]), step_duration)
    check_number("elapsed", elapsed, 0.0, "s")
    if elapsed > gait.step_duration:
        raise ParameterError(
            f"`elapsed` inside the step, at most {gait.step_duration:.4g} [s]",
            repr(elapsed),
            "count from the touchdown that began the step under way",
        )
    check_leg(robot, gait)
    reach = (float(zmp_reach[0]), float(zmp_reach[1]))
    step = step_of_push(robot, gait, unit, elapsed, Side(support_side), reach)
    if together:
        room, _ = best_landings(robot, gait, unit, elapsed, Side(support_side), reach)
    else:
        room = min(step.axis_rooms().values())
    impulse = max(impulse_per_offset(robot, duration) * room, 0.0)
    return ImpulseLimit(unit, impulse, impulse / robot.mass)


def step_of_push(
    robot: Robot,
    gait: NominalGait,
    unit: tuple[float, float],
    elapsed: float,
    side: Side,
    zmp_reach: tuple[float, float],
) -> PushedStep:
    """The step of the nominal gait in which a push begins; arguments as of `push_limit`."""
    state = np.array(gait_in_step(gait, side, elapsed))
    return PushedStep(robot, state, (unit[0], side * unit[1]), zmp_reach, elapsed)


@lru_cache(maxsize=4096)
def best_landings(
    robot: Robot,
    gait: NominalGait,
    unit: tuple[float, float],
    elapsed: float,
    side: Side,
    zmp_reach: tuple[float, float],
) -> tuple[float, tuple[float, ...]]:
    """How far the DCM can be moved along the push [m], and the landing times that allow it [s].

    The duration of the push does not matter here. Arguments as of `push_limit`.
    """
    return step_of_push(robot, gait, unit, elapsed, side, zmp_reach).best_schedule()


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
        direction: of the push (x, y), of any length but zero.
        duration: how long the push lasts [s].

    Returns:
        The limit.

    Raises:
        ParameterError: a direction of no length, or a duration that is not positive.
    """
    unit = unit_direction(direction)
    check_number("duration", duration, 0.0, "s", above=True)
    room = min(
        half / abs(part) for half, part in zip(robot.foot.half, unit, strict=True) if part != 0.0
    )
    impulse = impulse_per_offset(robot, duration) * room
    return ImpulseLimit(unit, impulse, impulse / robot.mass)


def axis_directions(support_side: Side) -> dict[str, tuple[float, float]]:
    """The four directions along the axes: forward, back, outward, inward.

    Outward is towards the swing foot, inward over the support foot to the other side.
    """
    outward = float(support_side)
    return {
        "forward": (1.0, 0.0),
        "back": (-1.0, 0.0),
        "outward": (0.0, outward),
        "inward": (0.0, -outward),
    }


def eight_directions(support_side: Side) -> dict[str, tuple[float, float]]:
    """The `axis_directions` and the diagonals between them, once round from forward to outward."""
    outward, half = float(support_side), math.sqrt(0.5)
    forward, back, left, right = axis_directions(support_side).items()
    return dict(
        [
            forward,
            ("forward-outward", (half, half * outward)),
            left,
            ("back-outward", (-half, half * outward)),
            back,
            ("back-inward", (-half, -half * outward)),
            right,
            ("forward-inward", (half, -half * outward)),
        ]
    )


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


def unit_direction(direction: tuple[float, float]) -> tuple[float, float]:
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

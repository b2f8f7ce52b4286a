"""From a mechanism to the point mass that its controller believes in, and the two put together.

A body steps within other limits than its point mass: legs have a length and meet each other, feet
have mass, and a sole that rolls freely cannot push sideways.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import msgspec

from surefoot.control.registry import find_method
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.gait import GaitLimits, Swing
from surefoot.robot.legs import leg_limits
from surefoot.robot.multibody import Multibody
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.robot import Foot, Robot
from surefoot.worlds.body.controller import BodyControl
from surefoot.worlds.body.mapping import USUAL_MAPPING, joint_mapping

SOLE_PART = 0.8
"""Of the sole, in which the controller may place the ZMP: the rest is for what it does not know."""

NARROW = 0.0125
"""Width of the sole that a controller believes in if the ankle cannot push sideways, in heights of
the CoM."""

STEP_DURATION = (0.7, 1.75)
"""Shortest and longest step in 1 / omega, unless the body has its own limits of the gait: heavy
legs are not put down sooner, and a shorter step leaves the DCM less time."""

SWING = Swing(height=0.0625, landing_velocity=0.018, max_speed=1.43, max_acceleration=4.08)
"""Likewise how the feet swing, in `OwnUnits`: heights of the CoM, sqrt(g h) and g. One that comes
down faster is higher up when a late push sends it on, and strikes the floor on its way."""

LEG_SPEED, LEG_ACCELERATION = 0.9, 0.59
"""Nor is a foot faster than this part of what the slower of hip pitch and roll can do with a leg
that hangs straight down: the trunk turns the other way, the leg is carried, and the knee bends."""

PARAMETERS = MappingProxyType({"unified": {"horizon": 0.5, "tau_weight": 0.005, "commitment": 0.5}})
"""What a method does differently on a body, by its key in `control.registry`: times in shortest
steps.

The unified controller steps sooner rather than wider, which friction and legs limit; it does not
believe that a push goes on for long, since it sees what its model lacks as a push too; and a foot
needs half of the shortest step to come down.
"""


def walking_robot(multibody: Multibody) -> Robot:
    """The point mass that a controller of this mechanism is to believe in.

    Args:
        multibody: the mechanism; `[body.gait]` and `[body.swing]` of its robot say what is not as
            in the tables of this file.
    """
    robot, body = multibody.robot, multibody.body
    passive = body.ankle_roll == "passive"
    width = NARROW * robot.com_height if passive else SOLE_PART * robot.foot.width
    hip = robot.hip if body.step_width is None else body.step_width
    gait = body.gait or _gait_of(robot, hip)
    return robot.replace(
        body=None,
        hip=hip,
        foot=Foot(length=SOLE_PART * robot.foot.length, width=width),
        gait=gait,
        swing=body.swing or usual_swing(multibody),
    )


def _gait_of(robot: Robot, hip: float) -> GaitLimits:
    """The robot's own limits, with the durations of a body and the same places of the soles."""
    low, high = robot.gait.step_y
    shortest, longest = (part / robot.omega for part in STEP_DURATION)
    return msgspec.structs.replace(
        robot.gait,
        step_duration=(shortest, longest),
        step_y=(low + robot.hip - hip, high + robot.hip - hip),
    )


def usual_swing(multibody: Multibody) -> Swing:
    """How the feet of a mechanism swing whose robot does not say it: as `SWING`, if its hips can.

    Args:
        multibody: the mechanism; motors without limits limit nothing.
    """
    own = OwnUnits.of(multibody.robot)
    speed, acceleration = leg_limits(multibody)
    return Swing(
        height=SWING.height * own.length,
        landing_velocity=SWING.landing_velocity * own.speed,
        max_speed=min(SWING.max_speed * own.speed, LEG_SPEED * speed),
        max_acceleration=min(
            SWING.max_acceleration * own.acceleration, LEG_ACCELERATION * acceleration
        ),
    )


def body_parameters(key: str, robot: Robot) -> dict[str, Any]:
    """What a method does differently on a body of a robot, from `PARAMETERS`, in SI units.

    Args:
        key: of the method, see `control.registry`.
        robot: that `walking_robot` made.
    """
    shortest = robot.gait.step_duration[0]
    unit = {"horizon": shortest, "commitment": shortest}
    return {name: value * unit.get(name, 1.0) for name, value in PARAMETERS.get(key, {}).items()}


def body_controller(
    key: str, robot: Robot, velocity: tuple[float, float], **parameters: Any
) -> Controller:
    """The controller of a method for a robot that `walking_robot` made.

    Args:
        key: of the method, see `control.registry`.
        robot: what it believes in.
        velocity: commanded [m/s].
        **parameters: of the method, instead of its own on a body.

    Raises:
        SurefootError: there is no such method, it leans a trunk as a flywheel, or it refuses the
            arguments.
    """
    one = find_method(key)
    if one.leans:
        raise ParameterError(
            "a method that leaves the trunk upright: a body's is a link, and no flywheel",
            f"{key!r}, which leans it",
            "choose another controller, or walk the point mass",
        )
    return one.controller(robot, velocity, **{**body_parameters(key, robot), **parameters})


def body_control(
    controller: Controller, multibody: Multibody, mapping: str = USUAL_MAPPING
) -> BodyControl:
    """Walks a mechanism with a controller.

    Args:
        controller: of a robot that `walking_robot` made.
        multibody: the mechanism.
        mapping: what turns its reference into motor commands, see `worlds.body.mapping`.

    Raises:
        SurefootError: the extra `mujoco` is not installed, or there is no such mapping.
    """
    return BodyControl(controller, multibody, joint_mapping(mapping, multibody))

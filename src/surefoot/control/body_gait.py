"""From a mechanism to the point mass that its controller believes in, and the two put together.

A body steps within other limits than its point mass: legs have a length and meet each other, feet
have mass, and a sole that rolls freely cannot push sideways.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import msgspec

from surefoot.control.body_control import BodyControl
from surefoot.control.inverse_dynamics import InverseDynamics
from surefoot.control.methods import method
from surefoot.models.interfaces import Controller
from surefoot.models.multibody import Multibody
from surefoot.models.robot import Foot, Robot
from surefoot.models.swing import Swing

SOLE_PART = 0.8
"""Of the sole, in which the controller may place the ZMP: the rest is for what it does not know."""

NARROW = 0.01
"""Width of the sole that a controller believes in if the ankle cannot push sideways [m]."""

STEP_DURATION = (0.2, 0.5)
"""Shortest and longest step, unless the body has its own limits of the gait [s]: heavy legs are not
put down sooner, and a shorter step leaves the DCM less time."""

SWING = Swing(height=0.05, landing_velocity=0.15, max_speed=4.0, max_acceleration=40.0)
"""Likewise how the feet swing."""

PARAMETERS = MappingProxyType({"unified": {"horizon": 0.1, "tau_weight": 0.01, "commitment": 0.1}})
"""What a method does differently on a body, by its key in `control.methods`.

The unified controller steps sooner rather than wider, which friction and legs limit; it does not
believe that a push goes on for long, since it sees what its model lacks as a push too; and a foot
needs a tenth of a second to come down.
"""


def walking_robot(multibody: Multibody) -> Robot:
    """The point mass that a controller of this mechanism is to believe in.

    Args:
        multibody: the mechanism; `[body.gait]` and `[body.swing]` of its robot say what is not as
            in the tables of this file.
    """
    robot, body = multibody.robot, multibody.body
    width = NARROW if body.ankle_roll == "passive" else SOLE_PART * robot.foot.width
    gait = body.gait or msgspec.structs.replace(robot.gait, step_duration=STEP_DURATION)
    return robot.replace(
        body=None,
        foot=Foot(length=SOLE_PART * robot.foot.length, width=width),
        gait=gait,
        swing=body.swing or SWING,
    )


def body_controller(
    key: str, robot: Robot, velocity: tuple[float, float], **parameters: Any
) -> Controller:
    """The controller of a method for a robot that `walking_robot` made.

    Args:
        key: of the method, see `control.methods`.
        robot: what it believes in.
        velocity: commanded [m/s].
        **parameters: of the method, instead of its own on a body.

    Raises:
        SurefootError: there is no such method, or it refuses the arguments.
    """
    return method(key).controller(robot, velocity, **{**PARAMETERS.get(key, {}), **parameters})


def body_control(controller: Controller, multibody: Multibody) -> BodyControl:
    """Walks a mechanism with a controller, by inverse dynamics.

    Args:
        controller: of a robot that `walking_robot` made.
        multibody: the mechanism.

    Raises:
        MissingExtraError: the extra `mujoco` is not installed.
    """
    return BodyControl(controller, multibody, InverseDynamics(multibody))

"""How much each task of a body counts, and how stiffly it is held: names, units, defaults."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.errors import ParameterError
from surefoot.record import new_array
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.robot import Robot

WEIGHTS = np.dtype(
    [
        ("contact", "f8"),
        ("contact_turn", "f8"),
        ("contact_yaw", "f8"),
        ("zmp", "f8"),
        ("com", "f8"),
        ("height", "f8"),
        ("trunk", "f8"),
        ("trunk_yaw", "f8"),
        ("swing", "f8"),
        ("swing_height", "f8"),
        ("swing_turn", "f8"),
        ("posture", "f8"),
        ("acceleration", "f8"),
        ("turning", "f8"),
        ("wrench", "f8"),
    ],
)
"""On squared errors of accelerations: of soles, CoM and height [(m/s^2)^-2]; of how soles and trunk
turn, and of the joints' posture [(rad/s^2)^-2]; of the ZMP [m^-2]; on squared accelerations of the
base and of what turns, and on the squared wrench in parts of the weight [-]."""

STIFFNESSES = np.dtype(
    [
        ("contact", "f8"),
        ("trunk", "f8"),
        ("swing", "f8"),
        ("swing_turn", "f8"),
        ("posture", "f8"),
        ("joint_limit", "f8"),
        ("joint_speed", "f8"),
    ],
)
"""What an error of position asks for [1/s^2], critically damped; of the contact and the joint
speed, what an error of velocity asks for [1/s]."""

_OWN_WEIGHTS = {
    "contact": ("m/s^2", 1.92e6),
    "contact_turn": ("rad/s^2", 3.0e6),
    "contact_yaw": ("rad/s^2", 1.5e4),
    "zmp": ("m", 9.6e5),
    "com": ("m/s^2", 9.6e4),
    "height": ("m/s^2", 9.6e4),
    "trunk": ("rad/s^2", 7.5e5),
    "trunk_yaw": ("rad/s^2", 150.0),
    "swing": ("m/s^2", 9.6e4),
    "swing_height": ("m/s^2", 9.6e4),
    "swing_turn": ("rad/s^2", 4.5e4),
    "posture": ("rad/s^2", 1.5),
    "acceleration": ("m/s^2", 0.096),
    "turning": ("rad/s^2", 0.15),
    "wrench": ("-", 0.01),
}
"""Of errors in `OwnUnits`: accelerations in g and omega^2, the ZMP in heights of the CoM. A large
robot turns more slowly than a small one, and its ZMP has more room."""

_OWN_STIFFNESSES = {
    "contact": ("1/s", 8.57),
    "trunk": ("1/s^2", 12.2),
    "swing": ("1/s^2", 73.4),
    "swing_turn": ("1/s^2", 32.6),
    "posture": ("1/s^2", 4.89),
    "joint_limit": ("1/s^2", 32.6),
    "joint_speed": ("1/s", 14.3),
}
"""Likewise in omega and its square."""


def usual_weights(robot: Robot) -> dict[str, float]:
    """What each task of a robot counts, see `WEIGHTS`."""
    own = OwnUnits.of(robot)
    return {name: value / own.one(unit) ** 2 for name, (unit, value) in _OWN_WEIGHTS.items()}


def usual_stiffnesses(robot: Robot) -> dict[str, float]:
    """How stiffly each task of a robot is held, see `STIFFNESSES`."""
    own = OwnUnits.of(robot)
    return {name: value * own.one(unit) for name, (unit, value) in _OWN_STIFFNESSES.items()}


def filled(
    dtype: np.dtype[np.void], defaults: dict[str, float], changes: dict[str, float]
) -> NDArray[np.void]:
    """A record of defaults, with changes.

    Raises:
        ParameterError: there is no such value, or it is negative or not finite.
    """
    array = new_array(dtype)
    for name, value in {**defaults, **changes}.items():
        if name not in defaults:
            raise ParameterError(
                f"one of {', '.join(defaults)}", repr(name), "correct the name of the value"
            )
        check_number(name, value, 0.0, "-")
        array[name] = value
    return array

"""How much each task of a body counts, and how stiffly it is held: names, units, defaults."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.errors import ParameterError
from surefoot.models.record import new_array

WEIGHTS = np.dtype(
    [
        ("contact", "f8"),
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
        ("wrench", "f8"),
    ],
)
"""On squared errors of accelerations [(m/s^2)^-2, (rad/s^2)^-2]; of the ZMP [m^-2]; on the squared
wrench in parts of the weight [-]."""

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

DEFAULT_WEIGHTS = {
    "contact": 2e4,
    "contact_yaw": 1e2,
    "zmp": 1.5e6,
    "com": 1e3,
    "height": 1e3,
    "trunk": 5e3,
    "trunk_yaw": 1.0,
    "swing": 1e3,
    "swing_height": 1e3,
    "swing_turn": 3e2,
    "posture": 1e-2,
    "acceleration": 1e-3,
    "wrench": 1e-2,
}
"""See `WEIGHTS`."""

DEFAULT_STIFFNESSES = {
    "contact": 30.0,
    "trunk": 150.0,
    "swing": 900.0,
    "swing_turn": 400.0,
    "posture": 60.0,
    "joint_limit": 400.0,
    "joint_speed": 50.0,
}
"""See `STIFFNESSES`."""


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

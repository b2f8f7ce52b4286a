"""Observations and commands in a frame that is turned about the origin.

A controller walks straight ahead in its own frame; a robot that turns gives it another one at
every touchdown.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from surefoot.interface import COMMAND, OBSERVATION
from surefoot.record import copy_array

Vector = Sequence[float] | NDArray[np.float64]
"""Of which the first two are x and y."""

_YAWS = {OBSERVATION: ("support_yaw", "swing_yaw"), COMMAND: ("swing_yaw",)}
_VECTORS = {
    OBSERVATION: (
        "com", "com_velocity", "dcm", "support_foot", "swing_foot", "swing_foot_velocity",
        "trunk_lean", "trunk_lean_velocity",
    ),
    COMMAND: (
        "zmp", "dcm_plan", "step_location", "dcm_offset", "swing_foot", "swing_foot_velocity",
        "swing_foot_acceleration", "hip_torque",
    ),
}  # fmt: skip


def rotated(vector: Vector, angle: float) -> tuple[float, float]:
    """A vector turned counter-clockwise by an angle [rad]."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return (cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1])


def turned(array: NDArray[np.void], angle: float) -> NDArray[np.void]:
    """An `OBSERVATION` or `COMMAND` record as it looks turned counter-clockwise.

    Args:
        array: shape (1,), not changed.
        angle: 0 leaves every bit as it is [rad].
    """
    if angle == 0.0:
        return array
    array = copy_array(array)
    for name in _VECTORS[array.dtype]:
        vector = array[name][0]
        vector[:2] = rotated(vector, angle)
    for name in _YAWS[array.dtype]:
        array[name][0] += angle
    return array

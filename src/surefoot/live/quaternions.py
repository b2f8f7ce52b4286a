"""Turns as quaternions (w, x, y, z), as a scene wants them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

Quaternion = tuple[float, float, float, float]


def about_z(yaw: float) -> Quaternion:
    """A heading [rad]."""
    return (math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw))


def z_towards(direction: ArrayLike) -> Quaternion:
    """The shortest turn of the z axis into a direction that is not zero, shape (3,)."""
    x, y, z = np.asarray(direction, float) / np.linalg.norm(direction)
    if z < -1.0 + 1e-9:
        return (0.0, 1.0, 0.0, 0.0)
    w = math.sqrt(0.5 * (1.0 + z))
    return (w, -y / (2.0 * w), x / (2.0 * w), 0.0)

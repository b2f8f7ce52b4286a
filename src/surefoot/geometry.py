"""Lengths and rotations, in the ground plane and in space.

A rotation in space is a unit quaternion (w, x, y, z): it takes a vector of the body to one of the
world.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit

SMALL_ANGLE = 1e-12
"""A rotation by less is none [rad]."""


@njit(forceinline=True)
def length(x: float, y: float) -> float:
    """|(x, y)|; hypot takes three times as long, for magnitudes that no robot has."""
    return math.sqrt(x * x + y * y)


def rotated(vector: Sequence[float] | NDArray[np.float64], angle: float) -> tuple[float, float]:
    """A vector (x, y) rotated counter-clockwise by an angle [rad]; more components are left out."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return (cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1])


def rotated_by(vectors: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (x, y), shape (n, 2), rotated counter-clockwise by angles, shape (n,) [rad]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)


def wrapped(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same angles between -pi and pi."""
    return angle - 2.0 * math.pi * np.floor(angle / (2.0 * math.pi) + 0.5)


@njit
def rotate(q, rotation, out):
    """The rotation q exp(rotation): by a vector given in the axes of the body that is rotated.

    Args:
        q: (4,) unit quaternion.
        rotation: (3,) axis times angle [rad].
        out: (4,) the result, of length one; may be `q`.
    """
    _product((q[0], q[1], q[2], q[3]), _exponential(rotation), out)


@njit
def rotate_in_world(q, rotation, out):
    """The rotation exp(rotation) q: by a vector given in the world's axes; see `rotate`."""
    _product(_exponential(rotation), (q[0], q[1], q[2], q[3]), out)


@njit(forceinline=True)
def _exponential(rotation):
    angle = math.sqrt(rotation[0] ** 2 + rotation[1] ** 2 + rotation[2] ** 2)
    s = math.sin(0.5 * angle) / angle if angle > SMALL_ANGLE else 0.5
    return math.cos(0.5 * angle), s * rotation[0], s * rotation[1], s * rotation[2]


@njit
def _product(a, b, out):
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    w = aw * bw - ax * bx - ay * by - az * bz
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    length = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    out[0], out[1], out[2], out[3] = w * length, x * length, y * length, z * length


@njit
def rotation_matrix(q, out):
    """The matrix of a unit quaternion.

    Args:
        q: (4,).
        out: (3, 3) the result; its columns are the body's axes in the world.
    """
    w, x, y, z = q[0], q[1], q[2], q[3]
    out[0, 0], out[1, 1] = w * w + x * x - y * y - z * z, w * w - x * x + y * y - z * z
    out[2, 2] = w * w - x * x - y * y + z * z
    out[0, 1], out[1, 0] = 2.0 * (x * y - w * z), 2.0 * (x * y + w * z)
    out[0, 2], out[2, 0] = 2.0 * (x * z + w * y), 2.0 * (x * z - w * y)
    out[1, 2], out[2, 1] = 2.0 * (y * z - w * x), 2.0 * (y * z + w * x)


def quaternions(turns: NDArray[Any]) -> NDArray[np.float64]:
    """Unit quaternions, shape (n, 4), of roll, then pitch, then yaw about fixed axes x, y and z.

    Args:
        turns: shape (n, 3) [rad].
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(0.5 * turns).T, np.sin(0.5 * turns).T
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=-1,
    )

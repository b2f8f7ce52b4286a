"""Lengths and turns in the ground plane."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from surefoot.compiling import njit


@njit(forceinline=True)
def length(x: float, y: float) -> float:
    """|(x, y)|; hypot takes three times as long, for magnitudes that no robot has."""
    return math.sqrt(x * x + y * y)


def rotated_by(vectors: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (x, y), shape (n, 2), turned counter-clockwise by angles, shape (n,) [rad]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=-1)


def wrapped(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same angles between -pi and pi."""
    return angle - 2.0 * math.pi * np.floor(angle / (2.0 * math.pi) + 0.5)

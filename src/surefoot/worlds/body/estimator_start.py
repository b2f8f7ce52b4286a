"""How an estimate of a body's state begins: the robot stands still on both feet."""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit
from surefoot.geometry import rotation_matrix, turned
from surefoot.robot.leg_kinematics import SOLES, find_soles
from surefoot.robot.robot import STANDARD_GRAVITY
from surefoot.worlds.body.base_filter import BIAS, POSITION, TILT, put_foot


@njit
def begin(settings, links, base, joints, angles, velocities, accelerometer):
    """Both feet stand: the middle of the soles is the origin, and the base heads along x."""
    noise, soles, R = settings[0].base, np.zeros(1, SOLES)[0], np.empty((3, 3))
    state, c = base[0], base[0].covariance
    x, y, z = accelerometer[0], accelerometer[1], accelerometer[2]
    upright, level = np.array((1.0, 0.0, 0.0, 0.0)), np.array((0.0, 0.0, 0.0))
    level[1] = math.atan2(-x, math.sqrt(y * y + z * z))
    turned(upright, level, state.orientation)
    level[0], level[1] = math.atan2(y, z), 0.0
    turned(state.orientation, level, state.orientation)
    for k in range(joints.shape[0]):
        joints[k].angle, joints[k].velocity = angles[k], velocities[k]
        joints[k].covariance[0] = settings[0].base.encoder ** 2
        joints[k].covariance[2] = settings[0].rate ** 2
    find_soles(links, angles, soles)
    rotation_matrix(state.orientation, R)
    for i in range(3):
        for k in range(3):
            state.position[i] -= 0.5 * R[i, k] * (soles.position[0, k] + soles.position[1, k])
        c[BIAS + i, BIAS + i] = noise.bias**2
    _lean(c, state.position, noise.accelerometer / STANDARD_GRAVITY)
    for foot in range(2):
        put_foot(state, noise, soles, foot)


@njit
def _lean(c, arm, lean):
    """A lean that is wrong moves the base, `arm` over its soles, whose middle is known."""
    h = np.zeros((3, 2))
    h[0, 1], h[1, 0], h[2, 0], h[2, 1] = arm[2], -arm[2], arm[1], -arm[0]
    for j in range(2):
        c[TILT + j, TILT + j] = lean**2
        for i in range(3):
            c[POSITION + i, TILT + j] = c[TILT + j, POSITION + i] = h[i, j] * lean**2
            for k in range(3):
                c[POSITION + i, POSITION + k] += h[i, j] * h[k, j] * lean**2

"""Tasks and constraints of whole-body inverse dynamics, as the rows of a quadratic program.

Unknown are the generalised accelerations and one wrench for each sole that carries, in the axes of
that sole and as parts of the weight (moments on a lever of an eighth of the CoM's height). A sum of
squares of weighted task errors is to be least; the equations of motion of what no motor moves are
kept exactly, and friction, soles, torques, joint positions and speeds as inequalities. Own
arrangement of the inverse dynamics of [Feng2015] and [Herzog2016]; what differs is the ZMP task.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import njit
from surefoot.errors import ParameterError
from surefoot.record import new_array
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.robot import Robot

GROUND = np.dtype(
    [
        ("friction", "f8"),
        ("half", "f8", (2,)),
        ("arm", "f8"),
        ("max_force", "f8"),
        ("mass", "f8"),
        ("gravity", "f8"),
        ("rolls", "i8"),
    ],
)
"""Friction coefficient; how far the ZMP may be from the centre of the sole (x, y) [m]; unit of the
moments over the weight [m]; largest vertical force on one sole, in weights; mass [kg], gravity
[m/s^2]; whether the ankles roll passively."""

JOINTS = np.dtype(
    [
        ("dof", "i8"),
        ("position", "i8"),
        ("nominal", "f8"),
        ("low", "f8"),
        ("high", "f8"),
        ("torque", "f8"),
        ("speed", "f8"),
    ],
)
"""A motor: its degree of freedom, the index of its angle; nominal angle and limits [rad], torque
[N m], speed [rad/s]."""

WRENCH = 6
MOMENT_ARM = 0.125
"""Unit of the moments over the weight, in heights of the CoM."""

WRENCH_ROWS = 10
"""Inequalities on the wrench of a sole."""

FREE = 1e30
"""A bound that is none, to the solver."""

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


@njit
def rotation_error(axes, roll, pitch, yaw, error):
    """Write the rotation vector, in the world, that turns the axes towards roll, pitch, yaw.

    Half the sum of the cross products of actual and wanted axes: exact for small errors, and it
    never points the wrong way below a quarter turn.
    """
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    wanted = (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )
    error[:] = 0.0
    for c in range(3):
        error[0] += 0.5 * (axes[1, c] * wanted[2][c] - axes[2, c] * wanted[1][c])
        error[1] += 0.5 * (axes[2, c] * wanted[0][c] - axes[0, c] * wanted[2][c])
        error[2] += 0.5 * (axes[0, c] * wanted[1][c] - axes[1, c] * wanted[0][c])


@njit
def stand_rows(weights, stiffness, jacobian, velocity, drift, rows, right, r):
    """A sole that carries stays where it is; how much it may turn is weighted by itself."""
    for i in range(6):
        weight = weights.contact if i < 3 else weights.contact_turn
        root = math.sqrt(weight if i < 5 else weights.contact_yaw)
        for c in range(jacobian.shape[1]):
            rows[r, c] = root * jacobian[i, c]
        right[r] = root * (-drift[i] - stiffness.contact * velocity[i])
        r += 1
    return r


@njit
def swing_rows(
    weights, stiffness, rolls, reference, jacobian, velocity, drift, place, axes, error,
    rows, right, r,
):  # fmt: skip
    """The sole in the air follows its reference; a passive ankle's roll is left to its spring.

    It writes into the rows of the program, arrays of the robot's length, which no record holds.
    """
    nv, k = jacobian.shape[1], stiffness.swing
    damping = 2.0 * math.sqrt(k)
    for i in range(3):
        root = math.sqrt(weights.swing_height if i == 2 else weights.swing)
        for c in range(nv):
            rows[r, c] = root * jacobian[i, c]
        wanted = reference.swing_foot_acceleration[i]
        wanted += k * (reference.swing_foot[i] - place[i])
        wanted += damping * (reference.swing_foot_velocity[i] - velocity[i])
        right[r] = root * (wanted - drift[i])
        r += 1
    rotation_error(axes, 0.0, 0.0, reference.swing_yaw, error)
    k = stiffness.swing_turn
    root, damping = math.sqrt(weights.swing_turn), 2.0 * math.sqrt(k)
    for axis in range(1 if rolls else 0, 3):
        total = 0.0
        for c in range(nv):
            rows[r, c] = 0.0
        for i in range(3):
            rate = reference.swing_yaw_rate if i == 2 else 0.0
            wanted = k * error[i] + damping * (rate - velocity[3 + i]) - drift[3 + i]
            total += axes[i, axis] * wanted
            for c in range(nv):
                rows[r, c] += root * axes[i, axis] * jacobian[3 + i, c]
        right[r] = root * total
        r += 1
    return r


@njit
def com_rows(weights, ground, reference, axes, nv, rows, right, r):
    """Two feet carry the CoM's acceleration: the sum of their forces is m (a - g)."""
    for i in range(3):
        root = math.sqrt(weights.height if i == 2 else weights.com)
        for side in range(2):
            for c in range(3):
                rows[r, nv + WRENCH * side + c] = root * axes[side, i, c] * ground.gravity
        wanted = reference.com_acceleration[i] + (ground.gravity if i == 2 else 0.0)
        right[r] = root * wanted
        r += 1
    return r


@njit
def zmp_rows(weights, ground, reference, place, axes, nv, rows, right, r):
    """One foot: where the ground pushes, and the height; sideways only if the ankle can push.

    It writes into the rows of the program, arrays of the robot's length, which no record holds.
    """
    root = math.sqrt(weights.height)
    for c in range(3):
        rows[r, nv + c] = root * axes[2, c] * ground.gravity
    right[r] = root * (reference.com_acceleration[2] + ground.gravity)
    r += 1
    root = math.sqrt(weights.zmp)
    away_x, away_y = reference.zmp[0] - place[0], reference.zmp[1] - place[1]
    for axis in range(1 if ground.rolls else 2):
        along = axes[0, axis] * away_x + axes[1, axis] * away_y
        # x = -m_y / f_z, y = m_x / f_z.
        rows[r, nv + (4 if axis == 0 else 3)] = (
            -root * ground.arm if axis == 0 else root * ground.arm
        )
        rows[r, nv + 2] = -root * along
        right[r] = 0.0
        r += 1
    return r


@njit
def trunk_rows(weights, stiffness, reference, axes, turning, first, error, rows, right, r):
    """The trunk keeps upright and its heading; `first` is its first rotational column.

    It writes into the rows of the program, arrays of the robot's length, which no record holds.
    """
    rotation_error(axes, reference.trunk[0], reference.trunk[1], reference.trunk[2], error)
    damping = 2.0 * math.sqrt(stiffness.trunk)
    for i in range(3):
        root = math.sqrt(weights.trunk if i < 2 else weights.trunk_yaw)
        rate = -reference.trunk_yaw_rate if i == 2 else 0.0
        for c in range(3):
            rows[r, first + c] = root * axes[i, c]
            rate += axes[i, c] * turning[c]
        right[r] = root * (stiffness.trunk * error[i] - damping * rate)
        r += 1
    return r


@njit
def posture_and_bounds(weights, stiffness, joints, position, velocity, hessian, slope, low, high):
    """Joints tend to the nominal posture, and keep off their limits of position and speed.

    It writes into the arrays of the program, of the robot's length, which no record holds.
    """
    damping, stop = 2.0 * math.sqrt(stiffness.posture), 2.0 * math.sqrt(stiffness.joint_limit)
    for j in range(joints.shape[0]):
        joint = joints[j]
        dof, angle, rate = joint.dof, position[joint.position], velocity[joint.dof]
        wanted = stiffness.posture * (joint.nominal - angle) - damping * rate
        hessian[dof, dof] += weights.posture
        slope[dof] -= weights.posture * wanted
        above = stiffness.joint_limit * (joint.high - angle) - stop * rate
        below = stiffness.joint_limit * (joint.low - angle) - stop * rate
        above = min(above, stiffness.joint_speed * (joint.speed - rate))
        below = max(below, stiffness.joint_speed * (-joint.speed - rate))
        if below > above:
            below = above = 0.5 * (below + above)
        low[dof], high[dof] = below, above


@njit
def wrench_columns(ground, axes, jacobian, wrenches, first):
    """Write J'R of a sole's unit wrenches in its own axes, six rows of `wrenches` from a first."""
    weight = ground.mass * ground.gravity
    for i in range(WRENCH):
        unit = weight if i < 3 else weight * ground.arm
        block = 3 * (i // 3)
        for c in range(jacobian.shape[1]):
            total = 0.0
            for j in range(3):
                total += axes[j, i % 3] * jacobian[block + j, c]
            wrenches[first + i, c] = unit * total


@njit
def motion_rows(dof, inertia, wrenches, columns, out):
    """A row of M a - J' f; `wrenches` holds J in units of the unknowns, shape (12, nv)."""
    nv = inertia.shape[0]
    for c in range(nv):
        out[c] = inertia[dof, c]
    for c in range(columns):
        out[nv + c] = -wrenches[c, dof]


@njit
def ground_rows(ground, count, nv, n, matrix, low, high, r):
    """Friction, ZMP inside the sole, yaw moment within friction; writes the force's bounds too."""
    reach = 0.5 * (ground.half[0] + ground.half[1])
    most = (
        ground.friction, ground.friction, 0.0,
        ground.half[1] / ground.arm, ground.half[0] / ground.arm,
        ground.friction * reach / ground.arm,
    )  # fmt: skip
    for side in range(count):
        first = nv + WRENCH * side
        low[first + 2], high[first + 2] = 0.0, ground.max_force
        for i in (0, 1, 3, 4, 5):
            for sign in (1.0, -1.0):
                matrix[r, first + i], matrix[r, first + 2] = sign, -most[i]
                low[n + r], high[n + r] = -FREE, 0.0
                r += 1
    return r

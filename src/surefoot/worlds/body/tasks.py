"""Tasks and constraints of whole-body inverse dynamics, as the rows of a quadratic program.

Unknown are the generalised accelerations and one wrench for each sole that carries, in the axes of
that sole and as parts of the weight (moments on a lever of an eighth of the CoM's height). A sum of
squares of weighted task errors is to be least; the equations of motion of what no motor moves are
kept exactly, and friction, soles, torques, joint positions and speeds as inequalities. Own
arrangement of the inverse dynamics of [Feng2015] and [Herzog2016]; what differs is the ZMP task.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import njit
from surefoot.errors import ParameterError
from surefoot.record import Record, Vector2, field, new_array
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.robot import Robot


class Ground(Record):
    """What the soles can do on the ground."""

    friction: float = field("-", "coefficient of friction")
    half: Vector2 = field("m", "how far the ZMP may be from the centre of the sole (x, y)")
    arm: float = field("m", "unit of the moments over the weight")
    max_force: float = field("-", "largest vertical force on one sole, in weights")
    mass: float = field("kg", "of the body")
    gravity: float = field("m/s^2", "its acceleration")
    rolls: int = field("", "1 if the ankles roll passively")


class Motor(Record):
    """A joint with a motor."""

    dof: int = field("", "its degree of freedom")
    position: int = field("", "index of its angle")
    nominal: float = field("rad", "angle in the nominal pose")
    low: float = field("rad", "smallest angle")
    high: float = field("rad", "largest angle")
    torque: float = field("N m", "limit")
    speed: float = field("rad/s", "limit")


class Weights(Record):
    """What the squared error of a task counts, where the error is 1 in `OwnUnits`.

    The units are those of the errors. A large robot turns more slowly than a small one, and its ZMP
    has more room.
    """

    contact: float = field("m/s^2", "acceleration of a standing sole", default=1.92e6)
    contact_turn: float = field("rad/s^2", "its angular acceleration", default=3.0e6)
    contact_yaw: float = field("rad/s^2", "likewise about the vertical", default=1.5e4)
    zmp: float = field("m", "place of the ZMP", default=9.6e5)
    com: float = field("m/s^2", "acceleration of the CoM", default=9.6e4)
    height: float = field("m/s^2", "likewise, vertical", default=9.6e4)
    trunk: float = field("rad/s^2", "roll and pitch of the trunk", default=7.5e5)
    trunk_yaw: float = field("rad/s^2", "its heading", default=150.0)
    swing: float = field("m/s^2", "acceleration of the swinging sole", default=9.6e4)
    swing_height: float = field("m/s^2", "likewise, vertical", default=9.6e4)
    swing_turn: float = field("rad/s^2", "its angular acceleration", default=4.5e4)
    posture: float = field("rad/s^2", "joints off their nominal pose", default=1.5)
    acceleration: float = field("m/s^2", "any acceleration of the base", default=0.096)
    turning: float = field("rad/s^2", "any angular acceleration", default=0.15)
    wrench: float = field("-", "any wrench on a sole, in parts of the weight", default=0.01)


class Stiffnesses(Record):
    """What an error of position asks for, critically damped, in `OwnUnits`.

    Of `contact` and `joint_speed`: what an error of velocity asks for.
    """

    contact: float = field("1/s", "of a standing sole", default=8.57)
    trunk: float = field("1/s^2", "of the trunk", default=12.2)
    swing: float = field("1/s^2", "of the swinging sole's place", default=73.4)
    swing_turn: float = field("1/s^2", "of its orientation", default=32.6)
    posture: float = field("1/s^2", "of the joints", default=4.89)
    joint_limit: float = field("1/s^2", "of the ends of the joints' ranges", default=32.6)
    joint_speed: float = field("1/s", "of the joints' speed limits", default=14.3)


GROUND, MOTOR, WEIGHTS, STIFFNESSES = Ground.DTYPE, Motor.DTYPE, Weights.DTYPE, Stiffnesses.DTYPE

WRENCH = 6
MOMENT_ARM = 0.125
"""Unit of the moments over the weight, in heights of the CoM."""

WRENCH_ROWS = 10
"""Inequalities on the wrench of a sole."""

FREE = 1e30
"""A bound that is none, to the solver."""


class Sole(NamedTuple):
    """One sole: rows of the arrays in `Mechanics`."""

    jacobian: NDArray[np.float64]
    velocity: NDArray[np.float64]
    drift: NDArray[np.float64]
    place: NDArray[np.float64]
    axes: NDArray[np.float64]


class Tasks(NamedTuple):
    """Weighted task rows R and right-hand sides b of a cycle, written over in every one.

    Attributes:
        rows, right: R, shape (MAX_TASK_ROWS, unknowns), and b.
        wrenches: Jacobians of the carrying soles in units of the unknowns, shape (12, nv).
        error: scratch, shape (3,).
    """

    rows: NDArray[np.float64]
    right: NDArray[np.float64]
    wrenches: NDArray[np.float64]
    error: NDArray[np.float64]


class Program(NamedTuple):
    """Minimise x'Hx/2 + g'x with low <= (x, A x) <= high; as DAQP takes it."""

    hessian: NDArray[np.float64]
    slope: NDArray[np.float64]
    matrix: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]


def task_weights(
    robot: Robot, changes: Mapping[str, float], kind: type[Record] = Weights
) -> NDArray[np.void]:
    """The `Weights` of a robot in SI, with changes, shape (1,); as `task_stiffnesses`."""
    own = OwnUnits.of(robot)
    usual = {name: it.default / own.one(it.unit) ** 2 for name, it in kind.FIELDS.items()}
    return _filled(kind.DTYPE, usual, changes)


def task_stiffnesses(
    robot: Robot, changes: Mapping[str, float], kind: type[Record] = Stiffnesses
) -> NDArray[np.void]:
    """The `Stiffnesses` of a robot in SI, with changes, shape (1,).

    Args:
        robot: whose they are.
        changes: of single values, by name.
        kind: of records; its defaults are those in `OwnUnits`.

    Raises:
        ParameterError: there is no such value, or it is negative or not finite.
    """
    own = OwnUnits.of(robot)
    usual = {name: it.default * own.one(it.unit) for name, it in kind.FIELDS.items()}
    return _filled(kind.DTYPE, usual, changes)


def _filled(
    dtype: np.dtype[np.void], usual: dict[str, float], changes: Mapping[str, float]
) -> NDArray[np.void]:
    array = new_array(dtype)
    for name, value in {**usual, **changes}.items():
        if name not in usual:
            raise ParameterError(
                f"one of {', '.join(usual)}", repr(name), "correct the name of the value"
            )
        check_number(name, value, 0.0, "-")
        array[name] = value
    return array


@njit
def rotation_error(axes, roll, pitch, yaw, error):
    """Write the rotation vector, in the world, that turns the axes towards roll, pitch, yaw.

    Half the sum of the cross products of actual and wanted axes: exact for small errors, and it
    points the right way below a quarter turn.
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
def stand_rows(weights, stiffness, sole, tasks, r):
    """A sole that carries stays where it is; how much it may turn is weighted by itself."""
    for i in range(6):
        weight = weights.contact if i < 3 else weights.contact_turn
        root = math.sqrt(weight if i < 5 else weights.contact_yaw)
        for c in range(sole.jacobian.shape[1]):
            tasks.rows[r, c] = root * sole.jacobian[i, c]
        tasks.right[r] = root * (-sole.drift[i] - stiffness.contact * sole.velocity[i])
        r += 1
    return r


@njit
def swing_rows(weights, stiffness, ground, reference, sole, tasks, r):
    """The sole in the air follows its reference; a passive ankle's roll is left to its spring."""
    rows, right, error, jacobian = tasks.rows, tasks.right, tasks.error, sole.jacobian
    nv, k, velocity = jacobian.shape[1], stiffness.swing, sole.velocity
    damping = 2.0 * math.sqrt(k)
    for i in range(3):
        root = math.sqrt(weights.swing_height if i == 2 else weights.swing)
        for c in range(nv):
            rows[r, c] = root * jacobian[i, c]
        wanted = reference.swing_foot_acceleration[i]
        wanted += k * (reference.swing_foot[i] - sole.place[i])
        wanted += damping * (reference.swing_foot_velocity[i] - velocity[i])
        right[r] = root * (wanted - sole.drift[i])
        r += 1
    rotation_error(sole.axes, 0.0, 0.0, reference.swing_yaw, error)
    k = stiffness.swing_turn
    root, damping = math.sqrt(weights.swing_turn), 2.0 * math.sqrt(k)
    for axis in range(1 if ground.rolls else 0, 3):
        total = 0.0
        for c in range(nv):
            rows[r, c] = 0.0
        for i in range(3):
            rate = reference.swing_yaw_rate if i == 2 else 0.0
            wanted = k * error[i] + damping * (rate - velocity[3 + i]) - sole.drift[3 + i]
            total += sole.axes[i, axis] * wanted
            for c in range(nv):
                rows[r, c] += root * sole.axes[i, axis] * jacobian[3 + i, c]
        right[r] = root * total
        r += 1
    return r


@njit
def com_rows(weights, ground, reference, axes, nv, tasks, r):
    """Two feet carry the CoM's acceleration: the sum of their forces is m (a - g)."""
    for i in range(3):
        root = math.sqrt(weights.height if i == 2 else weights.com)
        for side in range(2):
            for c in range(3):
                tasks.rows[r, nv + WRENCH * side + c] = root * axes[side, i, c] * ground.gravity
        wanted = reference.com_acceleration[i] + (ground.gravity if i == 2 else 0.0)
        tasks.right[r] = root * wanted
        r += 1
    return r


@njit
def zmp_rows(weights, ground, reference, sole, tasks, r):
    """One foot: where the ground pushes, and the height; sideways only if the ankle can push."""
    rows, right, nv, axes = tasks.rows, tasks.right, sole.jacobian.shape[1], sole.axes
    root = math.sqrt(weights.height)
    for c in range(3):
        rows[r, nv + c] = root * axes[2, c] * ground.gravity
    right[r] = root * (reference.com_acceleration[2] + ground.gravity)
    r += 1
    root = math.sqrt(weights.zmp)
    away_x, away_y = reference.zmp[0] - sole.place[0], reference.zmp[1] - sole.place[1]
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
def trunk_rows(weights, stiffness, reference, axes, turning, first, tasks, r):
    """The trunk keeps upright and its heading; `first` is its first rotational column."""
    trunk, error = reference.trunk, tasks.error
    rotation_error(axes, trunk[0], trunk[1], trunk[2], error)
    damping = 2.0 * math.sqrt(stiffness.trunk)
    for i in range(3):
        root = math.sqrt(weights.trunk if i < 2 else weights.trunk_yaw)
        rate = -reference.trunk_yaw_rate if i == 2 else 0.0
        for c in range(3):
            tasks.rows[r, first + c] = root * axes[i, c]
            rate += axes[i, c] * turning[c]
        tasks.right[r] = root * (stiffness.trunk * error[i] - damping * rate)
        r += 1
    return r


@njit
def posture_and_bounds(weights, stiffness, motors, position, velocity, program):
    """Joints tend to the nominal posture, and keep off their limits of position and speed."""
    damping, stop = 2.0 * math.sqrt(stiffness.posture), 2.0 * math.sqrt(stiffness.joint_limit)
    for j in range(motors.shape[0]):
        motor = motors[j]
        dof, angle, rate = motor.dof, position[motor.position], velocity[motor.dof]
        wanted = stiffness.posture * (motor.nominal - angle) - damping * rate
        program.hessian[dof, dof] += weights.posture
        program.slope[dof] -= weights.posture * wanted
        above = stiffness.joint_limit * (motor.high - angle) - stop * rate
        below = stiffness.joint_limit * (motor.low - angle) - stop * rate
        above = min(above, stiffness.joint_speed * (motor.speed - rate))
        below = max(below, stiffness.joint_speed * (-motor.speed - rate))
        if below > above:
            below = above = 0.5 * (below + above)
        program.low[dof], program.high[dof] = below, above


@njit
def motion_rows(dof, inertia, wrenches, columns, out):
    """A row of M a - J' f; `wrenches` holds J in units of the unknowns, shape (12, nv)."""
    nv = inertia.shape[0]
    for c in range(nv):
        out[c] = inertia[dof, c]
    for c in range(columns):
        out[nv + c] = -wrenches[c, dof]


@njit
def ground_rows(ground, count, nv, program, r):
    """Friction, ZMP inside the sole, yaw moment within friction; writes the force's bounds too."""
    low, high, n = program.low, program.high, nv + WRENCH * count
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
                program.matrix[r, first + i], program.matrix[r, first + 2] = sign, -most[i]
                low[n + r], high[n + r] = -FREE, 0.0
                r += 1
    return r

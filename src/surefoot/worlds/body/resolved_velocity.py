r"""The generalised velocity that moves the CoM, the feet and the trunk of a body as they should.

Rows of one least-squares problem, after the kinematic resolution of [Choi2007]:

    J_c v = u,   J_s v = 0,   J_f v = \dot x_f + k_f (x_f - x),   R_b v = k_t e(R_b).

The sole that carries rests and what swings is embedded, so the joints of both legs are found
together; as long as all rows can be met that is the same as solving for the leg that carries.

Near a straight knee they cannot: the height hardly depends on the knee any more. As in
[Faraji2017] the straight knee is not avoided, but the vertical task yields. The velocity of a knee
is weighted against the height, more so the straighter it is (`YIELDING`), so what is lost is
height and never the feet or the horizontal CoM; far from it nothing is weighted, and all rows are
met. That source solves for positions; the weights are our choice.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.errors import RobotError
from surefoot.record import Array, Record, field
from surefoot.robot.legs import MOSTLY, find_legs, leg_joints
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.tasks import rotation_error

SOLE, SWING, ALONG, HEIGHT, TRUNK = 10.0, 3.0, 1.0, 0.3, 1.0
"""Weights of the rows: soles that carry and passive joints, the swinging sole, the CoM's horizontal
velocity, its height, how the trunk turns; of velocities in `OwnUnits`. They matter only where not
all rows can be met."""

DAMPING = 1e-3
"""Likewise of every joint's velocity: what is redundant comes to rest."""

STRAIGHT, BENT = 0.05, 0.3
"""A knee bent by less is straight, one bent by more is not weighted [rad]."""

YIELDING = 0.02
"""Weight of the velocity of a straight knee of a leg that carries; of the swinging leg, whose sole
counts more than the height, it is more by as much."""


class LegJoints(Record):
    """The joints of a leg that the ZMP and the straight knee are known by."""

    ankle: Array = field("", "degrees of freedom of its pitch and roll", shape=2, kind=int)
    knee: int = field("", "likewise of the knee")
    angle: int = field("", "index of its angle")
    sign: float = field("", "1.0 if a larger angle bends more, else -1.0")
    straight: float = field("rad", "angle at which the leg is straight")


class Rows(Record):
    """What errors of feet and trunk are answered with, and the unit of lengths."""

    trunk: float = field("1/s", "of the trunk's lean and heading")
    swing: float = field("1/s", "of the swinging sole's place and lean")
    level: float = field("1/s", "of the lean of a sole that carries")
    height: float = field("m", "of the CoM")
    rolls: int = field("", "whether the ankles roll passively")


LEG, ROWS = LegJoints.DTYPE, Rows.DTYPE
"""The same for kernels, which know no classes."""


@njit
def knee_weight(leg, angle, carries):
    """What the velocity of a knee counts: nothing, unless it is nearly straight."""
    bend = leg.sign * (angle - leg.straight)
    part = min(max((BENT - bend) / (BENT - STRAIGHT), 0.0), 1.0)
    smooth = part * part * (3.0 - 2.0 * part)
    return YIELDING * smooth * (1.0 if carries else SWING / HEIGHT)


@njit
def add_row(weight, jacobian, value, hessian, slope):
    """Add weight^2 (J v - value)^2 to the sum of squares."""
    square = weight * weight
    for i in range(jacobian.shape[0]):
        if jacobian[i] != 0.0:
            scaled = square * jacobian[i]
            slope[i] += scaled * value
            for k in range(i + 1):
                hessian[i, k] += scaled * jacobian[k]


@njit
def add_sole(rates, reference, side, falls, motion, jacobian, row, hessian, slope):
    """A sole that carries rests and levels itself; the other one follows its reference.

    Where the robot falls about passive ankles, a sole that lands rolls on until it is flat, and the
    leg does not roll with it: the roll that is measured is embedded.
    """
    stands, axes, error = reference.stands[side] == 1, motion.sole_axes[side], np.empty(3)
    weight = SOLE if stands else SWING
    for i in range(3):
        speed = 0.0
        if not stands:
            speed = reference.swing_foot_velocity[i]
            speed += rates.swing * (reference.swing_foot[i] - motion.sole_position[side, i])
        add_row(weight / rates.height, jacobian[i], speed, hessian, slope)
    yaw = math.atan2(axes[1, 0], axes[0, 0]) if stands else reference.swing_yaw
    rotation_error(axes, 0.0, 0.0, yaw, error)
    for i in range(3):
        error[i] *= rates.level if stands else rates.swing
    if not stands:
        error[2] += reference.swing_yaw_rate
    for k in range(0 if stands or rates.rolls == 0 else 1, 3):
        row[:] = 0.0
        speed = 0.0
        for i in range(3):
            rolling = falls and stands and k == 0
            speed += axes[i, k] * (motion.sole_velocity[side, 3 + i] if rolling else error[i])
            for c in range(row.shape[0]):
                row[c] += axes[i, k] * jacobian[3 + i, c]
        add_row(weight, row, speed, hessian, slope)


@njit
def add_trunk(rates, reference, axes, base, row, hessian, slope):
    """The trunk keeps upright and its heading; `base` is its first rotational column."""
    error = np.empty(3)
    rotation_error(axes, reference.trunk[0], reference.trunk[1], reference.trunk[2], error)
    for i in range(3):
        row[:] = 0.0
        for c in range(3):
            row[base + c] = axes[i, c]
        speed = rates.trunk * error[i] + (reference.trunk_yaw_rate if i == 2 else 0.0)
        add_row(TRUNK, row, speed, hessian, slope)


@njit
def add_com(rates, reference, motion, jacobian, falls, u, row, hessian, slope):
    """The CoM moves by u; not across a sole that rolls passively, where it falls."""
    h, stance = rates.height, 0 if reference.stands[0] == 1 else 1
    axes = motion.sole_axes[stance]
    yaw = math.atan2(axes[1, 0], axes[0, 0])
    cosine, sine = math.cos(yaw), math.sin(yaw)
    for i in range(1 if falls else 2):
        x, y = (cosine, sine) if i == 0 else (-sine, cosine)
        for c in range(row.shape[0]):
            row[c] = x * jacobian[0, c] + y * jacobian[1, c]
        add_row(ALONG / h, row, x * u[0] + y * u[1], hessian, slope)
    add_row(HEIGHT / h, jacobian[2], u[2], hessian, slope)


@njit
def factor_and_solve(hessian, vector):
    """Replace b by the x of A x = b, A positive definite, by Cholesky; whether it was.

    Only the lower half of A is read, and overwritten.
    """
    n = vector.shape[0]
    for i in range(n):
        for k in range(i + 1):
            total = hessian[i, k]
            for c in range(k):
                total -= hessian[i, c] * hessian[k, c]
            if k < i:
                hessian[i, k] = total / hessian[k, k]
            elif total > 0.0:
                hessian[i, i] = math.sqrt(total)
            else:
                return False
    for i in range(n):
        for k in range(i):
            vector[i] -= hessian[i, k] * vector[k]
        vector[i] /= hessian[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            vector[i] -= hessian[k, i] * vector[k]
        vector[i] /= hessian[i, i]
    return math.isfinite(vector.sum())


@njit
def resolve(
    rates, legs, passive, base, reference, motion, position, velocity, jacobians, com_jacobian,
    u, hessian, row, out,
):  # fmt: skip
    """Write the generalised velocity that carries out u and all that is embedded; whether it could.

    Its arrays have the robot's length, which no record holds, and MuJoCo's are read where they lie.

    Args:
        rates: a `Rows` record.
        legs: `LegJoints` records, left and right.
        passive: degrees of freedom of joints without a motor.
        base: first degree of freedom of the base.
        reference, motion: records of these.
        position, velocity, jacobians, com_jacobian: as in `Mechanics`.
        u: of the CoM [m/s].
        hessian, row: scratch, shapes (nv, nv), (nv,).
        out: shape (nv,), written.
    """
    falls = passive.shape[0] > 0 and reference.stands[0] != reference.stands[1]
    hessian[:, :] = 0.0
    out[:] = 0.0
    for i in range(out.shape[0]):
        hessian[i, i] = DAMPING * DAMPING
    for side in range(2):
        add_sole(rates, reference, side, falls, motion, jacobians[side], row, hessian, out)
        knee = legs[side].knee
        weight = knee_weight(legs[side], position[legs[side].angle], reference.stands[side] == 1)
        hessian[knee, knee] += weight * weight
    if falls:
        for j in range(passive.shape[0]):
            row[:] = 0.0
            row[passive[j]] = 1.0
            add_row(SOLE, row, velocity[passive[j]], hessian, out)
    add_com(rates, reference, motion, com_jacobian, falls, u, row, hessian, out)
    add_trunk(rates, reference, motion.base_axes, base + 3, row, hessian, out)
    return factor_and_solve(hessian, out)


def find_leg_joints(multibody: Multibody) -> NDArray[np.void]:
    """The `LegJoints` of both legs, shape (2,).

    Raises:
        RobotError: a leg has no hip, knee and ankle that pitch, or no ankle that rolls.
    """
    find_legs(multibody)
    model, data, found = multibody.model, multibody.data(), np.zeros(2, LEG)
    for side, foot in enumerate(multibody.feet):
        pitch = [j for j in leg_joints(multibody, foot) if abs(data.xaxis[j][1]) > MOSTLY]
        hip, knee, ankle = data.xanchor[pitch]
        thigh, shank = knee - hip, ankle - knee
        turned = math.atan2(thigh[2] * shank[0] - thigh[0] * shank[2], thigh @ shank)
        angle, sense = int(model.jnt_qposadr[pitch[1]]), float(np.sign(data.xaxis[pitch[1]][1]))
        leg = found[side]
        leg["ankle"] = model.jnt_dofadr[pitch[2]], _ankle_roll(multibody, data, foot)
        leg["knee"], leg["angle"] = model.jnt_dofadr[pitch[1]], angle
        leg["sign"] = sense * math.copysign(1.0, turned)
        leg["straight"] = multibody.nominal[angle] - sense * turned
    return found


def _ankle_roll(multibody: Multibody, data: mujoco.MjData, foot: int) -> int:
    """Degree of freedom of the hinge that rolls a foot, with a motor or not."""
    model, body = multibody.model, foot
    while body not in (0, multibody.base):
        first = int(model.body_jntadr[body])
        for joint in range(first + int(model.body_jntnum[body]) - 1, first - 1, -1):
            if abs(data.xaxis[joint][0]) > MOSTLY:
                return int(model.jnt_dofadr[joint])
        body = int(model.body_parentid[body])
    raise RobotError(
        "a leg with a joint that rolls the foot",
        f"none above {model.body(foot).name!r}",
        'give it one, or write ankle_roll = "passive"',
    )

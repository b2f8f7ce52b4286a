r"""The generalised velocity that moves the CoM, the feet and the trunk of a body as they should.

Rows of one least-squares problem, after the kinematic resolution of [Choi2007]:

    J_c v = u,   J_s v = 0,   J_f v = \dot x_f + k_f (x_f - x),   R_b v = k_t e(R_b).

The sole that carries rests and what swings is embedded, so the joints of both legs are found
together; as long as all rows can be met that is the same as solving for the leg that carries.

Near a straight knee they cannot: the height hardly depends on the knee any more. As in
[Faraji2017] the straight knee is not avoided, but the vertical task yields. The nearer a knee of a
leg that carries is to straight, the less counts the row of the height, and the more one of its own
(`KNEE`), which asks for a rate of its bend. With the thigh a, the shank b, the bend \beta and the
hip at the distance l(\beta) from the ankle,

    l^2 = a^2 + b^2 + 2 a b \cos \beta,    \dot \beta = k (\beta(l(\beta) + u_z / k) - \beta),

where \beta is never less than a guard. Of a bent knee that is the rate which u_z takes; at the
guard it is 0 for every u_z upwards, and it is finite and without a jump on the way there and back.
What is lost is height, and never the feet or the horizontal CoM. That source solves for positions
throughout; the row is our arrangement. The knee of a swinging leg is slowed down near straight.
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
from surefoot.worlds.body.program import factor_and_solve
from surefoot.worlds.body.tasks import rotation_error

SOLE, SWING, ALONG, HEIGHT, TRUNK = 10.0, 3.0, 1.0, 0.3, 1.0
"""Weights of the rows: soles that carry and passive joints, the swinging sole, the CoM's horizontal
velocity, its height, how the trunk turns; of velocities in `OwnUnits`. They matter only where not
all rows can be met."""

DAMPING = 3e-4
"""Likewise of every joint's velocity: what is redundant comes to rest."""

STRAIGHT, BENT = 0.05, 0.3
"""A knee that is bent by less is straight; one that is bent by more has no row of its own [rad]."""

KNEE = 0.1
"""Weight of the row of a straight knee of a leg that carries; of the swinging leg, whose sole
counts more, it is twice as much."""


class LegJoints(Record):
    """The joints of a leg that the ZMP and the straight knee are known by."""

    ankle: Array = field("", "degrees of freedom of its pitch and roll", shape=2, kind=int)
    knee: int = field("", "likewise of the knee")
    angle: int = field("", "index of its angle")
    sign: float = field("", "1.0 if a larger angle bends more, else -1.0")
    straight: float = field("rad", "angle at which the leg is straight")
    thigh: float = field("m", "from hip to knee")
    shank: float = field("m", "from knee to ankle")


class Rows(Record):
    """What errors of feet and trunk are answered with, and the unit of lengths."""

    trunk: float = field("1/s", "of the trunk's lean and heading")
    swing: float = field("1/s", "of the swinging sole's place and lean")
    level: float = field("1/s", "of the lean of a sole that carries")
    knee: float = field("1/s", "of the bend of a knee that is nearly straight")
    guard: float = field("rad", "least bend of a knee")
    height: float = field("m", "of the CoM")
    rolls: int = field("", "whether the ankles roll passively")


LEG, ROWS = LegJoints.DTYPE, Rows.DTYPE
"""The same for kernels, which know no classes."""


@njit
def bend_rate(rates, leg, bend, upward):
    """How fast a knee is to bend so that its hip rises, never beyond the guard [rad/s].

    Args:
        rates: a `Rows` record.
        leg: a `LegJoints` record.
        bend: of the knee, 0 if it is straight [rad].
        upward: velocity of the hip [m/s].
    """
    squares, twice = leg.thigh**2 + leg.shank**2, 2.0 * leg.thigh * leg.shank
    length = math.sqrt(squares + twice * math.cos(bend)) + upward / rates.knee
    cosine = (max(length, 0.0) ** 2 - squares) / twice
    wanted = math.acos(min(max(cosine, -1.0), math.cos(rates.guard)))
    return rates.knee * (wanted - bend)


@njit
def add_knee(rates, leg, angle, carries, upward, hessian, slope):
    """A knee that is nearly straight has a rate of its own; by how much the height yields to it."""
    bend = leg.sign * (angle - leg.straight)
    part = min(max((BENT - bend) / (BENT - STRAIGHT), 0.0), 1.0)
    straight = part * part * (3.0 - 2.0 * part)
    weight = KNEE * straight * (1.0 if carries else 2.0)
    rate = leg.sign * bend_rate(rates, leg, bend, upward) if carries else 0.0
    hessian[leg.knee, leg.knee] += weight * weight
    slope[leg.knee] += weight * weight * rate
    return straight if carries else 0.0


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
def add_com(rates, reference, motion, jacobian, falls, u, height, row, hessian, slope):
    """The CoM moves by u; not across a sole that rolls passively, where it falls.

    It writes into the arrays of the program, of the robot's length, which no record holds;
    `height` is the weight of the last row.
    """
    h, stance = rates.height, 0 if reference.stands[0] == 1 else 1
    axes = motion.sole_axes[stance]
    yaw = math.atan2(axes[1, 0], axes[0, 0])
    cosine, sine = math.cos(yaw), math.sin(yaw)
    for i in range(1 if falls else 2):
        x, y = (cosine, sine) if i == 0 else (-sine, cosine)
        for c in range(row.shape[0]):
            row[c] = x * jacobian[0, c] + y * jacobian[1, c]
        add_row(ALONG / h, row, x * u[0] + y * u[1], hessian, slope)
    add_row(height / h, jacobian[2], u[2], hessian, slope)


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
    hessian[:, :], yields = 0.0, 0.0
    out[:] = 0.0
    for i in range(out.shape[0]):
        hessian[i, i] = DAMPING * DAMPING
    for side in range(2):
        add_sole(rates, reference, side, falls, motion, jacobians[side], row, hessian, out)
        carries, angle = reference.stands[side] == 1, position[legs[side].angle]
        straight = add_knee(rates, legs[side], angle, carries, u[2], hessian, out)
        yields = max(yields, straight)
    if falls:
        for j in range(passive.shape[0]):
            row[:] = 0.0
            row[passive[j]] = 1.0
            add_row(SOLE, row, velocity[passive[j]], hessian, out)
    height = HEIGHT * (1.0 - yields)
    add_com(rates, reference, motion, com_jacobian, falls, u, height, row, hessian, out)
    add_trunk(rates, reference, motion.base_axes, base + 3, row, hessian, out)
    return factor_and_solve(hessian, out.reshape((-1, 1)))


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
        leg["thigh"], leg["shank"] = np.hypot(*thigh[[0, 2]]), np.hypot(*shank[[0, 2]])
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

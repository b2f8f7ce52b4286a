"""What a body that carries out a reference does: its accelerations, from those of base and soles.

For `balance_force`: the base moves as the CoM is to, and turns upright; a sole that carries rests,
and the other one follows its reference. With J_b, J_l the Jacobian of a sole against base and
leg, the joints of a leg solve

    J_l a_l = a_sole - dJ/dt v - J_b a_b,

damped least squares towards the posture. Joints near a limit are pushed off it. The wrenches that
this needs and those that the ground gives are compared about the CoM.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.record import Array, Record, field, new_array
from surefoot.robot.legs import find_knees, leg_joints
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.program import factor_and_solve
from surefoot.worlds.body.tasks import WRENCH, rotation_error


class Balance(Record):
    """What is constant for a mechanism."""

    inverse: Array = field(
        "1/(kg m^2)",
        "inverse of the composite inertia about the CoM in the nominal pose, in the base's axes",
        shape=(3, 3),
    )
    height: float = field("m", "of the CoM in the nominal pose")
    base: int = field("", "first degree of freedom of the base")
    place: int = field("", "index of its place among the positions")
    knees: Array = field("", "degrees of freedom, left and right", shape=2, kind=int)
    rolls: Array = field("", "likewise of passive ankle rolls, -1 without", shape=2, kind=int)


class BalanceStiffnesses(Record):
    """What an error of position asks for, critically damped, in `OwnUnits`.

    Of `joint_speed`: what an error of velocity asks for. The trunk is softer than with inverse
    dynamics: if it is to turn faster than the ground lets it, the torques of the legs are those of
    another motion.
    """

    trunk: float = field("1/s^2", "of the trunk", default=4.88)
    swing: float = field("1/s^2", "of the swinging sole's place", default=73.4)
    swing_turn: float = field("1/s^2", "of its orientation", default=32.6)
    posture: float = field("1/s^2", "of the joints", default=4.89)
    joint_limit: float = field("1/s^2", "of the ends of the joints' ranges", default=32.6)
    joint_speed: float = field("1/s", "of the joints' speed limits", default=14.3)


BALANCE, STIFFNESSES = Balance.DTYPE, BalanceStiffnesses.DTYPE


class BalanceRobot(NamedTuple):
    """What is fixed: arrays of one record, `Motor` records, and the degrees of freedom of each
    leg's motors, filled up with -1, shape (2, n)."""

    weights: NDArray[np.void]
    stiffness: NDArray[np.void]
    balance: NDArray[np.void]
    ground: NDArray[np.void]
    motors: NDArray[np.void]
    legs: NDArray[np.int64]


class BalanceState(NamedTuple):
    """Arrays of `Mechanics`, which are read where they lie."""

    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    sole_jacobian: NDArray[np.float64]
    motion: NDArray[np.void]


class Plan(NamedTuple):
    """What the body is to do in a cycle, and what that needs; written over in every one.

    Attributes:
        acceleration: of all degrees of freedom, shape (nv,).
        forces: M a + h of these, shape (nv,).
        knees: of a leg that carries: the slope of its knee against the base's accelerations, the
            knee's own one, and between which that has to be, shape (2, 9).
        needed: force and moment about the CoM, in the world, shape (6,).
        totals: likewise of the unit wrenches of the soles that carry, in columns, shape (6, 12).
    """

    acceleration: NDArray[np.float64]
    forces: NDArray[np.float64]
    knees: NDArray[np.float64]
    needed: NDArray[np.float64]
    totals: NDArray[np.float64]


DAMPING = 1e-6
"""Of the joints of a leg, where a sole that moves by the CoM's height has 1: near a straight knee
they follow the posture instead."""


@njit
def _base_motion(k, b, g, ref, m, velocity, error, acceleration):
    """Write what the base is to do: as the CoM, and upright."""
    for i in range(3):
        acceleration[b.base + i] = ref.com_acceleration[i]
    if ref.stands[0] + ref.stands[1] == 1:
        standing = m.sole_position[0 if ref.stands[0] == 1 else 1]
        high = max(m.com[2] - standing[2], 0.5 * b.height)
        for i in range(2):
            away = (m.com[i] - ref.zmp[i]) / high
            acceleration[b.base + i] = away * (g.gravity + ref.com_acceleration[2])
    axes, damping = m.base_axes, 2.0 * math.sqrt(k.trunk)
    rotation_error(axes, ref.trunk[0], ref.trunk[1], ref.trunk[2], error)
    for i in range(3):
        turn = axes[2, i] * ref.trunk_yaw_rate - velocity[b.base + 3 + i]
        wanted = damping * turn
        for j in range(3):
            wanted += k.trunk * axes[j, i] * error[j]
        acceleration[b.base + 3 + i] = wanted


@njit
def _sole_motion(k, ref, m, side, error, wanted):
    """Write J a of a sole: one that carries rests, the other one follows its reference."""
    for i in range(6):
        wanted[i] = -m.sole_drift[side, i]
    if ref.stands[side] == 1:
        return
    rotation_error(m.sole_axes[side], 0.0, 0.0, ref.swing_yaw, error)
    damping, turn_damping = 2.0 * math.sqrt(k.swing), 2.0 * math.sqrt(k.swing_turn)
    for i in range(3):
        wanted[i] += ref.swing_foot_acceleration[i]
        wanted[i] += k.swing * (ref.swing_foot[i] - m.sole_position[side, i])
        wanted[i] += damping * (ref.swing_foot_velocity[i] - m.sole_velocity[side, i])
        rate = ref.swing_yaw_rate if i == 2 else 0.0
        wanted[3 + i] += k.swing_turn * error[i]
        wanted[3 + i] += turn_damping * (rate - m.sole_velocity[side, 3 + i])


@njit
def _leg_motion(b, skip, leg, jacobian, axes, wanted, slope, acceleration):
    """Write the accelerations of a leg's joints that move its sole as wanted, least squares.

    Args:
        b: a `Balance` record.
        skip: 1 if the sole's roll is left to a passive ankle, else 0.
        leg: degrees of freedom with motors, and -1 for none.
        jacobian, axes: of the sole.
        wanted: its J a.
        slope: of the knee against the base's accelerations, written, shape (6,).
        acceleration: of all; those of base and posture in, those of the leg out.
    """
    n, count = 0, 6 - skip
    while n < leg.shape[0] and leg[n] >= 0:
        n += 1
    rows, right = np.zeros((6, n)), np.zeros((6, 7))
    for i in range(3):
        for c in range(n):
            rows[i, c] = jacobian[i, leg[c]] / b.height
        for c in range(6):
            right[i, c] = jacobian[i, b.base + c] / b.height
        right[i, 6] = wanted[i] / b.height
    for i in range(3, count):
        axis = i - 3 + skip
        for j in range(3):
            part = axes[j, axis]
            for c in range(n):
                rows[i, c] += part * jacobian[3 + j, leg[c]]
            for c in range(6):
                right[i, c] += part * jacobian[3 + j, b.base + c]
            right[i, 6] += part * wanted[3 + j]
    square, sums = np.zeros((n, n)), np.zeros((n, 7))
    for c in range(n):
        for i in range(count):
            for d in range(c + 1):
                square[c, d] += rows[i, c] * rows[i, d]
            for d in range(7):
                sums[c, d] += rows[i, c] * right[i, d]
        square[c, c] += DAMPING
        sums[c, 6] += DAMPING * acceleration[leg[c]]
    if not factor_and_solve(square, sums):
        sums[:] = math.nan
    for c in range(n):
        total = sums[c, 6]
        for i in range(6):
            total -= sums[c, i] * acceleration[b.base + i]
        acceleration[leg[c]] = total
        if leg[c] == b.knees[0] or leg[c] == b.knees[1]:
            slope[:] = sums[c, :6]


@njit
def plan_motion(robot, state, reference, error, plan):
    """Write the accelerations that carry out a reference, and the knees; `error` is scratch."""
    k, b, g, ref = robot.stiffness[0], robot.balance[0], robot.ground[0], reference[0]
    position, velocity, m = state.position, state.velocity, state.motion[0]
    motors, knees, acceleration, wanted = robot.motors, plan.knees, plan.acceleration, np.empty(6)
    acceleration[:] = 0.0
    _base_motion(k, b, g, ref, m, velocity, error, acceleration)
    damping, stop = 2.0 * math.sqrt(k.posture), 2.0 * math.sqrt(k.joint_limit)
    for j in range(motors.shape[0]):
        motor = motors[j]
        away = motor.nominal - position[motor.position]
        acceleration[motor.dof] = k.posture * away - damping * velocity[motor.dof]
    for side in range(2):
        _sole_motion(k, ref, m, side, error, wanted)
        _leg_motion(
            b, g.rolls, robot.legs[side], state.sole_jacobian[side], m.sole_axes[side], wanted,
            knees[side, :6], acceleration,
        )  # fmt: skip
    for j in range(motors.shape[0]):
        motor = motors[j]
        dof, angle, rate = motor.dof, position[motor.position], velocity[motor.dof]
        above = k.joint_limit * (motor.high - angle) - stop * rate
        below = k.joint_limit * (motor.low - angle) - stop * rate
        above = min(above, k.joint_speed * (motor.speed - rate))
        below = max(below, k.joint_speed * (-motor.speed - rate))
        if below > above:
            below = above = 0.5 * (below + above)
        carries = False
        for side in range(2):
            if dof == b.knees[side] and ref.stands[side] == 1:
                knees[side, 6], knees[side, 7], knees[side, 8] = acceleration[dof], below, above
                carries = True
        if not carries:
            acceleration[dof] = min(max(acceleration[dof], below), above)


@njit
def needed_wrench(b, m, position, forces, needed):
    """Write the force that the ground has to give, and the moment about the CoM, in the world."""
    for i in range(3):
        needed[i] = forces[b.base + i]
        needed[3 + i] = 0.0
        for j in range(3):
            needed[3 + i] += m.base_axes[i, j] * forces[b.base + 3 + j]
    for i in range(3):
        o, u = (i + 1) % 3, (i + 2) % 3
        arm_o, arm_u = m.com[o] - position[b.place + o], m.com[u] - position[b.place + u]
        needed[3 + i] -= arm_o * needed[u] - arm_u * needed[o]


@njit
def given_wrenches(g, ref, m, totals):
    """Write force and moment about the CoM of the soles' unit wrenches, in columns; their count."""
    weight, first = g.mass * g.gravity, 0
    for side in range(2):
        if ref.stands[side] == 0:
            continue
        axes, place = m.sole_axes[side], m.sole_position[side]
        for i in range(3):
            o, u = (i + 1) % 3, (i + 2) % 3
            for c in range(3):
                totals[i, first + c] = weight * axes[i, c]
                totals[i, first + 3 + c] = 0.0
                lever = (place[o] - m.com[o]) * axes[u, c] - (place[u] - m.com[u]) * axes[o, c]
                totals[3 + i, first + c] = weight * lever
                totals[3 + i, first + 3 + c] = weight * g.arm * axes[i, c]
        first += WRENCH
    return first


@njit
def knee_row(b, g, m, knee, position, needed, totals, row):
    """Write how a knee that carries accelerates with the wrenches; what it does without them.

    What they give beyond the need accelerates one rigid body, of the nominal composite inertia.
    """
    axes, turn, own, moment = m.base_axes, np.empty(3), np.empty(3), np.empty(6)
    for i in range(3):
        o, u = (i + 1) % 3, (i + 2) % 3
        arm_o, arm_u = m.com[o] - position[b.place + o], m.com[u] - position[b.place + u]
        turn[i] = arm_u * knee[o] - arm_o * knee[u]
        for j in range(3):
            turn[i] += axes[i, j] * knee[3 + j]
    for i in range(3):
        own[i] = axes[0, i] * turn[0] + axes[1, i] * turn[1] + axes[2, i] * turn[2]
    for i in range(3):
        turn[i] = b.inverse[i, 0] * own[0] + b.inverse[i, 1] * own[1] + b.inverse[i, 2] * own[2]
    rest = knee[6]
    for i in range(3):
        moment[i] = knee[i] / g.mass
        moment[3 + i] = axes[i, 0] * turn[0] + axes[i, 1] * turn[1] + axes[i, 2] * turn[2]
    for i in range(6):
        rest += moment[i] * needed[i]
    for c in range(row.shape[0]):
        row[c] = 0.0
        for i in range(6):
            row[c] -= moment[i] * totals[i, c]
    return rest


def leg_dofs(multibody: Multibody) -> NDArray[np.int64]:
    """Degrees of freedom of each leg's motors, filled up with -1, shape (2, n)."""
    address = multibody.model.jnt_dofadr
    legs = [[int(address[j]) for j in leg_joints(multibody, foot)] for foot in multibody.feet]
    table = np.full((2, max(map(len, legs))), -1, np.int64)
    for side, leg in enumerate(legs):
        table[side, : len(leg)] = leg
    return table


def nominal_balance(multibody: Multibody) -> NDArray[np.void]:
    """What is constant, a `Balance` as an array, shape (1,)."""
    model, data = multibody.model, multibody.data()
    balance, axes = new_array(BALANCE), data.xmat[multibody.base].reshape(3, 3)
    com, inertia = data.subtree_com[multibody.base], np.zeros((3, 3))
    for body in range(1, model.nbody):
        turn, away = data.ximat[body].reshape(3, 3), data.xipos[body] - com
        inertia += turn @ np.diag(model.body_inertia[body]) @ turn.T
        inertia += model.body_mass[body] * (away @ away * np.eye(3) - np.outer(away, away))
    balance["inverse"] = np.linalg.inv(axes.T @ inertia @ axes)
    balance["height"], balance["base"] = multibody.robot.com_height, multibody.base_dof
    balance["place"] = model.jnt_qposadr[model.body_jntadr[multibody.base]]
    knees = multibody.motor_dofs[list(find_knees(multibody))]
    balance["knees"], balance["rolls"] = knees, -1
    for dof in multibody.passive_dofs.tolist():
        body = model.dof_bodyid[dof]
        for side, foot in enumerate(multibody.feet):
            if body == foot != multibody.base:
                balance["rolls"][0, side] = dof
    return balance

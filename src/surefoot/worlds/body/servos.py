r"""Position servos: what they carry, where they are sent, and the ZMP that follows from it.

A servo holds its joint by a spring and a damper, so what it gives is known from how far it is off
what it was sent,

    tau = K (q_sent - q) + D (\dot q_sent - \dot q).

With the load f_z on a sole, the torques of its ankle tell where the force f on it acts: for each
axis a of the ankle, through a point a_0, f at p balances the servo,

    a . ((p - a_0) x f) = -tau,

where the line of f passes through the CoM. It is what a force sensor under the ankle would
measure, but for the weight of the foot.

The other way round, a joint that is to carry tau is sent tau / K further than it is to be. The
torques expected are those of rest,

    tau = h - \sum J^T f,

with the forces f that carry the robot at the ZMP that is asked for.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.record import Record, field
from surefoot.robot.legs import find_knees
from surefoot.robot.multibody import Multibody

POSTURE, SENT, MOVING, EXPECT = 0, 1, 2, 3
"""Rows of what is remembered of the servos: angles that are wanted, and that were sent so that they
come about [rad]; velocities that were sent [rad/s]; accelerations that are expected [rad/s^2]."""

TOUCHING, CARRIED = 0.03, 0.2
"""Parts of the weight: a sole with less does not count for the ZMP, and with less on both there is
none."""

MAX_DAMPED = 0.6
"""Of a servo's damping, over what would stop its joint within one period: a sampled one that damps
much more is unstable."""

NEWEST = 0.5
"""Share of the newest in the average of the joints' accelerations."""


class Servo(Record):
    """A joint with a motor that is held by a servo."""

    dof: int = field("", "its degree of freedom")
    position: int = field("", "index of its angle")
    low: float = field("rad", "least angle")
    high: float = field("rad", "largest")
    torque: float = field("N m", "limit")
    stiffness: float = field("N m/rad", "of the servo")
    damping: float = field("N m s/rad", "likewise")


SERVO = Servo.DTYPE
"""The same for kernels, which know no classes."""


@njit
def servo_torques(servos, sent, position, velocity, torque):
    """Write what the servos give, by degree of freedom [N m].

    Args:
        servos: `Servo` records.
        sent: shape (4, n), see `POSTURE`.
        position, velocity: generalised.
        torque: shape (nv,), written.
    """
    torque[:] = 0.0
    for j in range(servos.shape[0]):
        servo = servos[j]
        given = servo.stiffness * (sent[SENT, j] - position[servo.position])
        given += servo.damping * (sent[MOVING, j] - velocity[servo.dof])
        torque[servo.dof] = min(max(given, -servo.torque), servo.torque)


@njit
def centre_of_pressure(ankle, load, line, place, jacobian, torque, out):
    """Write where the force on a sole acts, from the torques of its ankle [m].

    Args:
        ankle: degrees of freedom of its pitch and roll.
        load: vertical force [N].
        line: direction of the force, its vertical part 1.
        place: centre of the sole [m].
        jacobian: of that, shape (6, nv).
        torque: by degree of freedom [N m].
        out: (x, y), written.
    """
    m, r = np.empty((2, 2)), np.empty(2)
    for k in range(2):
        dof = ankle[k]
        ax, ay, az = jacobian[3, dof], jacobian[4, dof], jacobian[5, dof]
        m[k, 0], m[k, 1] = line[1] * az - ay, ax - line[0] * az
        r[k] = -torque[dof] / load
        for i in range(3):
            r[k] -= line[i] * jacobian[i, dof]
    scale = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    out[0], out[1] = place[0], place[1]
    # Of a level sole it is 1 or -1; axes that coincide tell nothing.
    if abs(scale) > 0.1:
        out[0] += (r[0] * m[1, 1] - m[0, 1] * r[1]) / scale
        out[1] += (m[0, 0] * r[1] - r[0] * m[1, 0]) / scale


@njit
def zmp_error(weight, legs, forces, motion, jacobians, torque, zmp, error):
    """Replace the last ZMP error by that of now: where the ZMP should be, less where it is [m].

    Args:
        weight: of the robot [N].
        legs: records with an `ankle`, left and right.
        forces: vertical, on both soles [N].
        motion, jacobians: as in `Mechanics`.
        torque: by degree of freedom [N m].
        zmp: where it should be [m].
        error: (x, y); 0 if the soles do not carry the robot.
    """
    point, line, total, x, y = np.empty(2), np.ones(3), 0.0, 0.0, 0.0
    for side in range(2):
        load, place = forces[side], motion.sole_position[side]
        if not load > TOUCHING * weight:
            continue
        for i in range(2):
            line[i] = motion.com[i] - (zmp[i] - error[i])
            line[i] /= max(motion.com[2] - place[2], 1e-3)
        centre_of_pressure(legs[side].ankle, load, line, place, jacobians[side], torque, point)
        total += load
        x += load * point[0]
        y += load * point[1]
    carried = total > CARRIED * weight
    error[0] = zmp[0] - x / total if carried else 0.0
    error[1] = zmp[1] - y / total if carried else 0.0


@njit
def torques_at_rest(weight, rolls, shares, reference, motion, bias, jacobians, torque):
    """Write what the joints carry where the robot stands with its ZMP where it should be [N m].

    Args:
        weight: of the robot [N].
        rolls: whether the ankles roll passively, and push nowhere sideways.
        shares: of the weight on both soles [-].
        reference: a `BODY_REFERENCE` record.
        motion, bias, jacobians: as in `Mechanics`.
        torque: by degree of freedom, written.
    """
    force, moment = np.empty(3), np.empty(3)
    torque[:] = bias
    for side in range(2):
        axes, place = motion.sole_axes[side], motion.sole_position[side]
        force[2] = shares[side] * weight
        for i in range(2):
            slope = (motion.com[i] - reference.zmp[i]) / max(motion.com[2] - place[2], 1e-3)
            force[i] = slope * force[2]
        x = y = 0.0
        if reference.stands[side] > reference.stands[1 - side]:
            x, y = reference.zmp[0] - place[0], reference.zmp[1] - place[1]
            if rolls:
                along = x * axes[0, 0] + y * axes[1, 0]
                x, y = along * axes[0, 0], along * axes[1, 0]
        moment[0], moment[1], moment[2] = y * force[2], -x * force[2], x * force[1] - y * force[0]
        for c in range(torque.shape[0]):
            for i in range(3):
                torque[c] -= jacobians[side, i, c] * force[i]
                torque[c] -= jacobians[side, 3 + i, c] * moment[i]


@njit
def move_servos(period, max_acceleration, servos, position, velocity, torque, sent):
    """Move the servos on by one period, no further than their torque and range reach.

    Args:
        period: of control [s].
        max_acceleration: that is expected [rad/s^2].
        servos: `Servo` records.
        position, velocity: generalised, estimated and wanted.
        torque: that they are to carry, by degree of freedom [N m].
        sent: shape (4, n), see `POSTURE`; changed.
    """
    for j in range(servos.shape[0]):
        servo, speed = servos[j], velocity[servos[j].dof]
        change = (speed - sent[MOVING, j]) / period
        change = min(max(change, -max_acceleration), max_acceleration)
        sent[EXPECT, j] += NEWEST * (change - sent[EXPECT, j])
        lag, room = torque[servo.dof] / servo.stiffness, servo.torque / servo.stiffness
        angle, place = position[servo.position], sent[POSTURE, j] + speed * period + lag
        place = min(max(min(max(place, angle - room), angle + room), servo.low), servo.high)
        sent[POSTURE, j], sent[SENT, j], sent[MOVING, j] = place - lag, place, speed


def find_servos(
    multibody: Multibody, stiffness: float, damping_ratio: float, knees: tuple[float, float],
    period: float,
) -> NDArray[np.void]:  # fmt: skip
    """The servos of a mechanism, records of `Servo`, in the order of its motors.

    Each is damped for the inertia that its joint has in the nominal pose.

    Args:
        multibody: the mechanism.
        stiffness: of all [N m/rad].
        damping_ratio: likewise [-].
        knees: angles beyond which they do not straighten the left and the right knee [rad].
        period: of control [s].
    """
    model = multibody.model
    servos, inertia = np.zeros(len(multibody.motors), SERVO), np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, multibody.data(), inertia)
    own = np.diag(inertia)[multibody.motor_dofs]
    servos["dof"], servos["position"] = multibody.motor_dofs, multibody.motor_positions
    limited = model.jnt_limited[multibody.motors].astype(bool)
    ranges, nominal = model.jnt_range[multibody.motors], multibody.nominal
    servos["low"] = np.where(limited, ranges[:, 0], -1e9)
    servos["high"] = np.where(limited, ranges[:, 1], 1e9)
    for motor, angle in zip(find_knees(multibody), knees, strict=True):
        bent = float(nominal[multibody.motor_positions[motor]])
        side, tighter = ("low", max) if bent > angle else ("high", min)
        servos[side][motor] = tighter(float(servos[side][motor]), angle)
    servos["torque"], servos["stiffness"] = np.minimum(multibody.torque, 1e9), stiffness
    damping = 2.0 * damping_ratio * np.sqrt(stiffness * own)
    servos["damping"] = np.minimum(damping, MAX_DAMPED * own / period)
    return servos

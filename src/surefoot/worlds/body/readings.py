"""Readings of a body's sensors: which are believed, what joints follow from them, and the start.

A reading is compared with what the filters expect of it. One that is further off than `TRUSTED`
standard deviations is left out, and the filters go on with what was expected; but no more than
`DOUBTS` in a row, for what lasts is no fault of a sensor: a robot that is struck does turn. What
they measured until then is made up for.

Angle and velocity of a joint follow from its encoder, its tachometer and what the controller
expects: one Kalman filter for each joint, with the expected acceleration a as its input, so that it
smooths without a lag:

    velocity <- velocity + a dt,    angle <- angle + velocity dt,

where a has an error of white noise. An impact, or a foot that tips over an edge, is unexpected. It
shows in the velocity's innovation, averaged over the last few cycles: where that is more than
`TRUSTED` of its standard deviations, the velocity is made as uncertain as the average is large,
and follows the measurement.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit
from surefoot.geometry import rotate, rotation_matrix
from surefoot.record import Array, Record, Vector3, field
from surefoot.robot.leg_kinematics import SOLES, find_soles
from surefoot.robot.robot import STANDARD_GRAVITY
from surefoot.worlds.body.base_filter import BIAS, POSITION, TILT, VELOCITY, put_foot

FREE = 6
"""Degrees of freedom of the base, in front of those of the joints."""


class Jerk(Record):
    """How far blows and impacts take a reading from what is expected, within one cycle.

    Standard deviations, with defaults in `OwnUnits`; of turning and angles per second, since they
    take time. In landings and strong pushes of 0.2 s the largest of five robots were a tenth
    (gyroscope) to four fifths (accelerometer) of what is believed at once. Blows of 5 ms exceed it,
    and are believed a few cycles later.
    """

    turning: float = field("rad/s^2", "of the gyroscope", default=12.0)
    acceleration: float = field("m/s^2", "of the accelerometer", default=0.5)
    rate: float = field("rad/s", "of tachometers", default=1.0)
    angle: float = field("rad/s", "of encoders", default=2.0)
    force: float = field("N", "largest force on a sole", default=10.0)
    velocity: float = field(
        "m/s", "by how much the velocity is less certain, at most, without a reading", default=0.05
    )
    tilt: float = field("-", "likewise the lean", default=0.003)


TRUSTED = 4.5
"""Standard deviations beyond which a reading, or an expected acceleration, is not believed."""

DOUBTS = 4
"""So many readings in a row are left out, not more: what lasts is no fault of a sensor."""

USUAL, ENOUGH = 1.0, 10.0
"""A foot is loaded from when on its readings, less so many standard deviations each, add up to
`ENOUGH` of them, never counting less than nothing ([Page1954]). Of white noise, of which no reading
is below 0, the root t = 1.95 of e^-t (1 / 2 + e^(t^2 / 2) Phi(t)) = 1 bounds how often it comes so
far, by e^(-10 t) = 3e-9 a cycle: once in four days of a loop of 1 kHz. A force of 11 standard
deviations is believed at once, one of 5 in 3 cycles."""


class Joint(Record):
    """A joint's filter."""

    angle: float = field("rad", "estimate")
    velocity: float = field("rad/s", "estimate")
    covariance: Vector3 = field("", "of the angle, of both, of the velocity")
    surprise: float = field("rad/s", "average innovation of the velocity")
    doubts: Array = field(
        "-", "how many readings of angle and velocity in a row were left out", shape=2, kind=int
    )


JOINT = Joint.DTYPE

FRESH = 0.3
"""Share of the last innovation in the average."""

_LEAST = TRUSTED * math.sqrt(FRESH / (2.0 - FRESH))
"""The average that is not trusted, of white noise of 1."""


@njit
def begin(settings, links, memory, readings):
    """Both feet stand: the middle of the soles is the origin, and the base heads along x."""
    noise, soles, R = settings[0].base, np.zeros(1, SOLES)[0], np.empty((3, 3))
    state, joints, force = memory.base[0], memory.joints, readings.accelerometer
    angles, c = readings.joint_angles, state.covariance
    x, y, z = force[0], force[1], force[2]
    upright, level = np.array((1.0, 0.0, 0.0, 0.0)), np.array((0.0, 0.0, 0.0))
    level[1] = math.atan2(-x, math.sqrt(y * y + z * z))
    rotate(upright, level, state.orientation)
    level[0], level[1] = math.atan2(y, z), 0.0
    rotate(state.orientation, level, state.orientation)
    for k in range(joints.shape[0]):
        joints[k].angle, joints[k].velocity = angles[k], readings.joint_velocities[k]
        joints[k].covariance[0] = settings[0].base.encoder ** 2
        joints[k].covariance[2] = settings[0].rate ** 2
    find_soles(links, angles, soles)
    rotation_matrix(state.orientation, R)
    for i in range(3):
        for k in range(3):
            state.position[i] -= 0.5 * R[i, k] * (soles.position[0, k] + soles.position[1, k])
        c[BIAS + i, BIAS + i] = noise.gyro_bias**2
    _lean(c, state.position, noise.accelerometer / STANDARD_GRAVITY)
    for foot in range(2):
        put_foot(state, noise, soles, foot)


@njit
def _lean(c, arm, lean):
    """An error of the lean moves the base, `arm` over its soles, whose middle is known."""
    h = np.zeros((3, 2))
    h[0, 1], h[1, 0], h[2, 0], h[2, 1] = arm[2], -arm[2], arm[1], -arm[0]
    for j in range(2):
        c[TILT + j, TILT + j] = lean**2
        for i in range(3):
            c[POSITION + i, TILT + j] = c[TILT + j, POSITION + i] = h[i, j] * lean**2
            for k in range(3):
                c[POSITION + i, POSITION + k] += h[i, j] * h[k, j] * lean**2


@njit
def all_finite(values):
    """Whether all of an array is."""
    total = 0.0
    for i in range(values.shape[0]):
        total += values[i]
    return math.isfinite(total)


@njit
def _is_doubtful(off, variance, base, channel):
    """Whether a vector is off by more than chance, blows and impacts explain, and for how long."""
    square = off[0] * off[0] + off[1] * off[1] + off[2] * off[2]
    # A comparison with infinity: a reading that is not finite does not come here.
    if square <= TRUSTED * TRUSTED * variance:
        base.doubts[channel] = 0
        return False
    base.doubts[channel] = min(base.doubts[channel] + 1, DOUBTS + 1)
    return base.doubts[channel] <= DOUBTS


@njit
def take_gyro(settings, base, gyro, past):
    """Angular velocity of the base; one that is not measured, or not believed, is as expected.

    Where readings are believed late, what they said meanwhile is made up for.
    """
    noise, jerk, off = settings.base, settings.jerk, np.zeros(3)
    for i in range(3):
        base.turning[i] += past[3 + i] * noise.period
        off[i] = gyro[i] - base.bias[i] - base.turning[i]
    if not all_finite(gyro):
        return
    variance = 2.0 * noise.gyro**2 + jerk.turning**2
    if _is_doubtful(off, variance, base, 0):
        fast = math.sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2])
        lean = min(fast * noise.period, jerk.tilt)
        for i in range(3):
            base.withheld[0, i] += off[i]
            base.covariance[TILT + i, TILT + i] += lean * lean
        return
    turn, late = np.zeros(3), base.doubts[0] > DOUBTS
    for i in range(3):
        base.turning[i] += off[i]
        turn[i] = base.withheld[0, i] * noise.period if late else 0.0
        base.withheld[0, i] = 0.0
    rotate(base.orientation, turn, base.orientation)


@njit
def take_accelerometer(settings, base, accelerometer, past, R, acceleration):
    """Acceleration of the base; one that is not measured, or not believed, is as expected.

    Where it was not believed, the velocity is less certain, and where it is believed late, what it
    said meanwhile is made up for.
    """
    noise, jerk, off = settings.base, settings.jerk, np.zeros(3)
    for i in range(3):
        acceleration[i] = past[i]
        off[i] = -past[i] - (STANDARD_GRAVITY if i == 2 else 0.0)
        for k in range(3):
            off[i] += R[i, k] * accelerometer[k]
    if not all_finite(accelerometer):
        return
    variance = noise.accelerometer**2 + jerk.acceleration**2
    if _is_doubtful(off, variance, base, 1):
        for i in range(3):
            base.withheld[1, i] += off[i]
            speed = min(abs(off[i]) * noise.period, jerk.velocity)
            base.covariance[VELOCITY + i, VELOCITY + i] += speed * speed
        return
    late = base.doubts[1] > DOUBTS
    for i in range(3):
        acceleration[i] += off[i] + (base.withheld[1, i] if late else 0.0)
        base.withheld[1, i] = 0.0


@njit
def take_joints(settings, joints, angles, velocities, past, taken):
    """Write angles and velocities of the joints that are believed; the others are not a number.

    An angle or velocity that is believed late is followed at once.

    Args:
        settings: `Settings` of the estimator.
        joints: `Joint` records; only how often they were doubted, and covariances, are changed.
        angles, velocities: as measured.
        past: accelerations that were expected.
        taken: shape (3, n), written: angles and velocities, and angles that soles follow from.
    """
    noise, jerk, dt = settings.base, settings.jerk, settings.base.period
    for k in range(joints.shape[0]):
        joint = joints[k]
        rate = joint.velocity + past[FREE + k] * dt
        angle = joint.angle + rate * dt
        taken[0, k] = taken[2, k] = angles[k]
        taken[1, k] = velocities[k]
        for which in range(2):
            reading = angles[k] if which == 0 else velocities[k]
            if not math.isfinite(reading):
                continue
            off = reading - (angle if which == 0 else rate)
            own = (
                noise.encoder**2 + jerk.angle**2 if which == 0 else settings.rate**2 + jerk.rate**2
            )
            here = 2 * which
            if off * off <= TRUSTED * TRUSTED * (joint.covariance[here] + own):
                joint.doubts[which] = 0
                continue
            joint.doubts[which] = min(joint.doubts[which] + 1, DOUBTS + 1)
            if joint.doubts[which] > DOUBTS:
                joint.covariance[here] += off * off
            else:
                taken[which, k] = math.nan
                if which == 0:
                    taken[2, k] = angle


@njit
def take_forces(settings, base, force):
    """The force on each sole that noise does not explain.

    One that is not finite, or that no robot of this weight stands on, is held.
    """
    usual = USUAL * settings.base.force
    enough = ENOUGH * settings.base.force
    for foot in range(2):
        if not math.isfinite(force[foot]):
            continue
        if abs(force[foot]) > settings.jerk.force:
            base.doubts[2 + foot] = min(base.doubts[2 + foot] + 1, DOUBTS + 1)
            if base.doubts[2 + foot] <= DOUBTS:
                continue
        else:
            base.doubts[2 + foot] = 0
        more = max(base.evidence[foot] + force[foot] - usual, 0.0)
        base.evidence[foot] = min(more, enough)
        base.load[foot] = force[foot] if more >= enough else 0.0


@njit
def predict_joint(joint, acceleration, surprise, dt):
    """One period of motion.

    Args:
        joint: a `Joint`, changed.
        acceleration: that was expected [rad/s^2].
        surprise: standard deviation of its error [rad/s^2].
        dt: period [s].
    """
    joint.velocity += acceleration * dt
    joint.angle += joint.velocity * dt
    aa, av, vv = joint.covariance[0], joint.covariance[1], joint.covariance[2]
    vv_new = vv + (surprise * dt) ** 2
    joint.covariance[0] = aa + 2.0 * dt * av + dt * dt * vv_new
    joint.covariance[1] = av + dt * vv_new
    joint.covariance[2] = vv_new


@njit
def correct_joint(joint, angle, velocity, encoder, rate):
    """Take both measurements in; one that is not finite is left out.

    Args:
        joint: a `Joint`, changed.
        angle: measured [rad].
        velocity: measured [rad/s].
        encoder: standard deviation of the angle [rad].
        rate: likewise of the velocity [rad/s].
    """
    aa, av, vv = joint.covariance[0], joint.covariance[1], joint.covariance[2]
    if math.isfinite(velocity):
        off = velocity - joint.velocity
        joint.surprise += FRESH * (off - joint.surprise)
        if abs(joint.surprise) > _LEAST * rate:
            vv = max(vv, joint.surprise**2)
        first, second = av / (vv + rate * rate), vv / (vv + rate * rate)
        joint.angle += first * off
        joint.velocity += second * off
        joint.surprise -= second * joint.surprise
        aa, av, vv = aa - first * av, av - first * vv, vv - second * vv
    if math.isfinite(angle):
        off = angle - joint.angle
        first, second = aa / (aa + encoder * encoder), av / (aa + encoder * encoder)
        joint.angle += first * off
        joint.velocity += second * off
        aa, av, vv = aa - first * aa, av - first * av, vv - second * av
    joint.covariance[0], joint.covariance[1], joint.covariance[2] = aa, av, vv

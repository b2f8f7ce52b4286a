"""Which readings of a body's sensors are believed: those that noise, blows and impacts explain.

A reading is compared with what the filters expect of it. One that is further off than `TRUSTED`
standard deviations is left out, and the filters go on with what was expected; but no more than
`DOUBTS` in a row, for what lasts is no fault of a sensor: a robot that is struck does turn. What
they said until then is made up for.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit
from surefoot.geometry import turned
from surefoot.robot.robot import STANDARD_GRAVITY
from surefoot.worlds.body.base_filter import TILT, VELOCITY

FREE = 6
"""Degrees of freedom of the base, in front of those of the joints."""

JERK = np.dtype(
    [
        (name, "f8")
        for name in ("turning", "acceleration", "rate", "angle", "force", "velocity", "tilt")
    ]
)
"""How far blows and impacts take a reading from what is expected, within one cycle, as standard
deviations: of the gyroscope [rad/s], the accelerometer [m/s^2], tachometers [rad/s] and encoders
[rad]; largest force on a sole [N]; and by how much velocity [m/s] and lean [rad] are less certain,
at most, where a reading was not believed."""

OWN_JERK = {
    "turning": ("rad/s^2", 12.0),
    "acceleration": ("m/s^2", 0.5),
    "rate": ("rad/s", 1.0),
    "angle": ("rad/s", 2.0),
    "force": ("N", 10.0),
    "velocity": ("m/s", 0.05),
    "tilt": ("-", 0.003),
}
"""Likewise in `OwnUnits`; of turning and angles per second, since they take time. In landings and
strong pushes of 0.2 s the largest of five robots were a tenth (gyroscope) to four fifths
(accelerometer) of what is believed at once. Blows of 5 ms exceed it, and are believed a few cycles
later."""

TRUSTED = 4.5
"""Standard deviations beyond which a reading is not believed."""

DOUBTS = 4
"""So many readings in a row are left out, not more: what lasts is no fault of a sensor."""

USUAL, ENOUGH = 1.0, 10.0
"""A foot is loaded from when on its readings, less so many standard deviations each, add up to
`ENOUGH` of them, never counting less than nothing ([Page1954]). Of white noise, of which no reading
is below 0, the root t = 1.95 of e^-t (1 / 2 + e^(t^2 / 2) Phi(t)) = 1 bounds how often it comes so
far, by e^(-10 t) = 3e-9 a cycle: once in four days of a loop of 1 kHz. A force of 11 standard
deviations is believed at once, one of 5 in 3 cycles."""


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
def see_turning(settings, base, gyro, past):
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
    turned(base.orientation, turn, base.orientation)


@njit
def see_acceleration(settings, base, accelerometer, past, R, acceleration):
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
def see_joints(settings, joints, angles, velocities, past, told):
    """Write angles and velocities of the joints that are believed; the others are not a number.

    An angle or velocity that is believed late is followed at once.

    Args:
        settings: a `SETTINGS` record.
        joints: `JOINT` records; only how often they were doubted, and covariances, are changed.
        angles, velocities: as measured.
        past: accelerations that were expected.
        told: shape (3, n), written: angles and velocities, and angles that soles follow from.
    """
    noise, jerk, dt = settings.base, settings.jerk, settings.base.period
    for k in range(joints.shape[0]):
        joint = joints[k]
        rate = joint.velocity + past[FREE + k] * dt
        angle = joint.angle + rate * dt
        told[0, k] = told[2, k] = angles[k]
        told[1, k] = velocities[k]
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
                told[which, k] = math.nan
                if which == 0:
                    told[2, k] = angle


@njit
def weigh(settings, base, force):
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

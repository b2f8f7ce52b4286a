"""Angle and velocity of a joint from its encoder, its tachometer and what the controller expects.

One Kalman filter for each joint, with the expected acceleration a as its input, so that it smooths
without a lag:

    velocity <- velocity + a dt,    angle <- angle + velocity dt,

where a is wrong by white noise. An impact, or a foot that tips over an edge, is not expected. It
shows in the velocity's innovation, averaged over the last few cycles: where that is more than
`TRUSTED` of its standard deviations, the velocity is made as uncertain as the average is large,
and follows the measurement.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit

JOINT = np.dtype(
    [
        ("angle", "f8"),
        ("velocity", "f8"),
        ("covariance", "f8", (3,)),
        ("surprise", "f8"),
        ("doubts", "i8", (2,)),
    ]
)
"""A joint: angle [rad], velocity [rad/s], covariance: of the angle, of both, of the velocity; the
average innovation of the velocity [rad/s]; how many readings of angle and velocity in a row have
not been believed (`worlds.body.estimator`)."""

TRUSTED = 4.5
"""Standard deviations beyond which the expected acceleration is not trusted."""

FRESH = 0.3
"""Share of the last innovation in the average."""

_LEAST = TRUSTED * math.sqrt(FRESH / (2.0 - FRESH))
"""The average that is not trusted, of white noise of 1."""


@njit
def predict_joint(joint, acceleration, surprise, dt):
    """One period of motion.

    Args:
        joint: a `JOINT` record, changed.
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
        joint: a `JOINT` record, changed.
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

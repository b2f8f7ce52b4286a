"""What motors can give: torque within limits, less of it near the limit of speed."""

from __future__ import annotations

from surefoot.compiled import njit

DROOP = 0.9
"""Fraction of its speed limit from which on a motor loses torque in the direction of motion."""


@njit
def torque_range(torque, speed, limit):
    """What a motor can give at a speed: full torque up to a part of its limit, then less and less.

    Beyond the limit it can only brake.

    Args:
        torque, limit: of the motor [N m, rad/s].
        speed: of the joint [rad/s].

    Returns:
        Least and largest torque [N m].
    """
    part = speed / limit
    high = low = 1.0
    if part > DROOP:
        high = max((1.0 - part) / (1.0 - DROOP), -1.0)
    elif part < -DROOP:
        low = max((1.0 + part) / (1.0 - DROOP), -1.0)
    return -low * torque, high * torque


@njit
def motor_torques(wanted, gains, measured, limits, given):
    """Write what the motors give of what they are commanded.

    Args:
        wanted: torque, position and velocity, as in `JointCommand` [N m, rad, rad/s].
        gains: stiffness and damping, likewise [N m/rad, N m s/rad].
        measured: position and velocity of the joints, in the order of the motors [rad, rad/s].
        limits: torque and speed of the motors [N m, rad/s].
        given: written [N m].
    """
    torque, position, velocity = wanted
    (stiffness, damping), (angles, speeds), (max_torque, max_speed) = gains, measured, limits
    for j in range(torque.shape[0]):
        asked = torque[j] + stiffness[j] * (position[j] - angles[j])
        asked += damping[j] * (velocity[j] - speeds[j])
        low, high = torque_range(max_torque[j], speeds[j], max_speed[j])
        given[j] = min(max(asked, low), high)

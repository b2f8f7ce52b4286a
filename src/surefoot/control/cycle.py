"""What every controller does in a cycle, whatever it decides: check what it sees, move the foot."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from surefoot.models.interfaces import Status
from surefoot.planning.swing_foot import bump, bump_lift, quintic, reachable

SWING = np.dtype(
    [
        ("height", "f8"),
        ("landing_velocity", "f8"),
        ("max_speed", "f8"),
        ("period", "f8"),
    ],
)
"""Parameters of the swing foot: apex [m], downward speed at touchdown [m/s], speed limit [m/s],
control period [s]."""

_UNREACHABLE = int(Status.UNREACHABLE)


@njit(cache=True)
def is_finite(observation) -> bool:
    """Whether everything that a controller reads is a finite number."""
    total = observation.elapsed + observation.time
    for i in range(2):
        total += observation.dcm[i] + observation.com[i] + observation.com_velocity[i]
        total += observation.support_foot[i]
    for i in range(3):
        total += observation.swing_foot[i] + observation.swing_foot_velocity[i]
    # A sum with a NaN or an infinity in it is not finite.
    return math.isfinite(total)


@njit(cache=True)
def side_index(support_side: int) -> int:
    """Row of a per-side table: 0 for the right foot on the ground, 1 for the left."""
    return 0 if support_side > 0 else 1


@njit(cache=True)
def command_swing(swing, observation, previous, previous_lift, new_step, command) -> float:
    """Write the swing foot of the command, one period on; `command` already has landing and timing.

    Position and velocity are those of the observation; the acceleration is the one last commanded,
    since measured accelerations are noise.

    Args:
        swing: a `SWING` record.
        observation: an `OBSERVATION` record.
        previous: the `COMMAND` record of the cycle before.
        previous_lift: what this function returned then [m/s^6].
        new_step: whether this is the first cycle of a step: the foot leaves the ground at rest.
        command: the `COMMAND` record to complete; its status gains UNREACHABLE.

    Returns:
        The lift of the vertical bump, to be remembered [m/s^6].
    """
    left = command.step_duration - observation.elapsed
    landing_x, landing_y = command.step_location[0], command.step_location[1]
    if not reachable(
        observation.swing_foot[0],
        observation.swing_foot[1],
        landing_x,
        landing_y,
        swing.max_speed * left if left > 0.0 else 0.0,
    ) and math.isfinite(swing.max_speed):
        command.status |= _UNREACHABLE
    if left <= swing.period:
        command.swing_foot[0], command.swing_foot[1] = landing_x, landing_y
        command.swing_foot[2] = 0.0
        for i in range(3):
            command.swing_foot_velocity[i] = 0.0
            command.swing_foot_acceleration[i] = 0.0
        command.swing_foot_velocity[2] = -swing.landing_velocity
        return previous_lift
    for i in range(2):
        acceleration = 0.0 if new_step else previous.swing_foot_acceleration[i]
        (
            command.swing_foot[i],
            command.swing_foot_velocity[i],
            command.swing_foot_acceleration[i],
        ) = quintic(
            observation.swing_foot[i],
            observation.swing_foot_velocity[i],
            acceleration,
            command.step_location[i],
            0.0,
            left,
            swing.period,
        )
    z, z_velocity = observation.swing_foot[2], observation.swing_foot_velocity[2]
    acceleration = 0.0 if new_step else previous.swing_foot_acceleration[2]
    lift = bump_lift(
        z,
        z_velocity,
        acceleration,
        swing.height,
        swing.landing_velocity,
        observation.elapsed,
        command.step_duration,
        previous_lift,
        previous.step_duration,
    )
    base = quintic(z, z_velocity, acceleration, 0.0, -swing.landing_velocity, left, swing.period)
    extra = bump(lift, left, swing.period)
    command.swing_foot[2] = base[0] + extra[0]
    command.swing_foot_velocity[2] = base[1] + extra[1]
    command.swing_foot_acceleration[2] = base[2] + extra[2]
    return lift

"""What every controller does in a cycle, whatever it decides: check what it sees, move the foot."""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiling import njit
from surefoot.models.interfaces import Status
from surefoot.planning.swing_foot import bump, bump_lift, quintic

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

SPEED_SAMPLES = 12
"""Where the speed of the way ahead is looked at; a quintic has no narrower peaks."""

SPEED_TOLERANCE = 1e-3
"""Fraction of the speed limit that the samples may exceed: a foot at its limit is not too fast."""

LARGEST_EXPONENT = 60.0
"""omega t counts no further than this, some 17 s: a step has long ended by then."""

REACH_TOLERANCE = 1e-9
"""A landing no further out of reach than this is reached [m]."""

_UNREACHABLE = int(Status.UNREACHABLE)


@njit
def is_finite(observation) -> bool:
    """Whether everything that a controller reads is a finite number."""
    total = observation.elapsed + observation.time
    total += observation.support_yaw + observation.swing_yaw
    for i in range(2):
        total += observation.dcm[i] + observation.com[i] + observation.com_velocity[i]
        total += observation.support_foot[i]
    for i in range(3):
        total += observation.swing_foot[i] + observation.swing_foot_velocity[i]
    # A sum with a NaN or an infinity in it is not finite.
    return math.isfinite(total)


@njit
def growth_since_touchdown(omega: float, elapsed: float) -> float:
    """e^(omega t), for a robot that stands and stands too: it stays finite."""
    return math.exp(min(omega * elapsed, LARGEST_EXPONENT))


@njit
def side_index(support_side: int) -> int:
    """Row of a per-side table: 0 for the right foot on the ground, 1 for the left."""
    return 0 if support_side > 0 else 1


@njit
def too_fast(swing, observation, previous, new_step, left, command) -> bool:
    """Whether the smooth way to the landing would exceed the speed limit of the leg."""
    limit = swing.max_speed * (1.0 + SPEED_TOLERANCE)
    for k in range(SPEED_SAMPLES):
        speed = 0.0
        for i in range(2):
            acceleration = 0.0 if new_step else previous.swing_foot_acceleration[i]
            _, velocity, _ = quintic(
                observation.swing_foot[i],
                observation.swing_foot_velocity[i],
                acceleration,
                command.step_location[i],
                0.0,
                left,
                left * k / SPEED_SAMPLES,
            )
            speed = math.hypot(speed, velocity)
        if speed > limit:
            return True
    return False


@njit
def _move_over_ground(swing, observation, previous, new_step, left, command):
    """Write x and y of the swing foot; flag a landing that a leg of limited speed cannot reach."""
    away_x = command.step_location[0] - observation.swing_foot[0]
    away_y = command.step_location[1] - observation.swing_foot[1]
    distance = math.hypot(away_x, away_y)
    if distance > swing.max_speed * left + REACH_TOLERANCE:
        command.status |= _UNREACHABLE
    hurry = (
        swing.max_speed < math.inf
        and distance > 0.0
        and too_fast(swing, observation, previous, new_step, left, command)
    )
    for i in range(2):
        if hurry:
            direction = (away_x if i == 0 else away_y) / distance
            speed = swing.max_speed * direction
            command.swing_foot[i] = observation.swing_foot[i] + speed * swing.period
            command.swing_foot_velocity[i] = speed
            command.swing_foot_acceleration[i] = 0.0
            continue
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


@njit
def _move_up_and_down(
    swing, observation, in_the_air, previous, previous_lift, new_step, left, command
):
    """Write z of the swing foot and return the lift of its bump [m/s^6]."""
    z, z_velocity = observation.swing_foot[2], observation.swing_foot_velocity[2]
    acceleration = 0.0 if new_step else previous.swing_foot_acceleration[2]
    flight = in_the_air[1] - in_the_air[0]
    lift = bump_lift(
        z,
        z_velocity,
        acceleration,
        swing.height,
        swing.landing_velocity,
        flight - left,
        flight,
        previous_lift,
        flight + previous.step_duration - command.step_duration,
    )
    base = quintic(z, z_velocity, acceleration, 0.0, -swing.landing_velocity, left, swing.period)
    extra = bump(lift, left, swing.period)
    command.swing_foot[2] = base[0] + extra[0]
    command.swing_foot_velocity[2] = base[1] + extra[1]
    command.swing_foot_acceleration[2] = base[2] + extra[2]
    return lift


@njit
def _stand(location_x, location_y, down, command):
    """Write a swing foot that is on the ground, or arrives there."""
    command.swing_foot[0], command.swing_foot[1] = location_x, location_y
    command.swing_foot[2] = 0.0
    for i in range(3):
        command.swing_foot_velocity[i] = command.swing_foot_acceleration[i] = 0.0
    command.swing_foot_velocity[2] = -down


@njit
def command_swing(
    swing, observation, in_the_air, landing_yaw, previous, previous_lift, new_step, command
) -> float:
    """Write the swing foot of the command, one period on; `command` already has landing and timing.

    The foot follows its polynomials, C2 through every re-plan. Only where these would exceed the
    speed limit of the leg does it go straight to the landing at that limit: a late foot costs more
    than a rough one. Position and velocity are those of the observation; the acceleration is the
    one last commanded, since measured accelerations are noise.

    Args:
        swing: a `SWING` record.
        observation: an `OBSERVATION` record.
        in_the_air: when the foot leaves the ground and when it is back, since touchdown [s].
        landing_yaw: heading with which it lands [rad].
        previous: the `COMMAND` record of the cycle before.
        previous_lift: what this function returned then [m/s^6].
        new_step: whether this is the first cycle of a step: the foot leaves the ground at rest.
        command: the `COMMAND` record to complete; its status gains UNREACHABLE.

    Returns:
        The lift of the vertical bump, to be remembered [m/s^6].
    """
    command.swing_yaw = observation.swing_yaw
    if observation.elapsed < in_the_air[0]:
        _stand(observation.swing_foot[0], observation.swing_foot[1], 0.0, command)
        return previous_lift
    left = in_the_air[1] - observation.elapsed
    if left > swing.period:
        command.swing_yaw += (landing_yaw - observation.swing_yaw) * swing.period / left
        _move_over_ground(swing, observation, previous, new_step, left, command)
        return _move_up_and_down(
            swing, observation, in_the_air, previous, previous_lift, new_step, left, command
        )
    command.swing_yaw = landing_yaw
    away = math.hypot(
        command.step_location[0] - observation.swing_foot[0],
        command.step_location[1] - observation.swing_foot[1],
    )
    reach = swing.max_speed * left if left > 0.0 else 0.0
    if swing.max_speed < math.inf and away > reach + REACH_TOLERANCE:
        command.status |= _UNREACHABLE
    down = swing.landing_velocity if left > 0.0 else 0.0
    _stand(command.step_location[0], command.step_location[1], down, command)
    return previous_lift

"""What every controller does in a cycle, whatever it decides: check numbers, move the foot."""

from __future__ import annotations

import math

from surefoot.compiled import njit
from surefoot.control.validation import flag_predicted
from surefoot.dcm.leg import hurry, is_reachable
from surefoot.dcm.swing_foot import height, next_phase, quintic
from surefoot.interface import Status
from surefoot.record import Record, field


class SwingParameters(Record):
    """Of the swing foot."""

    height: float = field("m", "apex of its flight")
    descent: float = field("m", "distance that it would sink in a flight at its landing velocity")
    max_speed: float = field("m/s", "along each axis")
    max_acceleration: float = field("m/s^2", "likewise")
    period: float = field("s", "control period")
    reach: float = field("m", "how far the feet can be apart")


WILD = 4.0, 24.0
"""A foot whose velocity would take it so many times `reach` in the rest of its flight, or so its
acceleration, slows down at once: only a landing that was due at once and is not any more leaves
it as fast, and the smooth way would throw it far beyond."""

SAMPLES = 12
"""Points of the way ahead that are checked; a quintic has no narrower peaks."""

LIMIT_TOLERANCE = 1e-3
"""Fraction of a limit that the samples may exceed: a foot at its limit is not too fast."""

MAX_MAGNITUDE = 1e9
"""No place or velocity of a first observation is larger, in SI units: a double resolves it to 1e-7.
What comes later is compared with what was before, see `control.validation`."""

MAX_TIME = 1e12
"""No clock counts further [s], whatever its epoch: a double resolves it to a tenth of 1 ms."""

MAX_EXPONENT = 60.0
"""omega t counts no further than this, some 17 s: a step has long ended by then."""

LAST_CYCLE = 1e-6
"""A flight that is longer than a period by this fraction of it ends in this cycle all the same."""

AT_PLACE = 1e-7
"""A foot this near to its landing, as a fraction of the apex of its flight, is there."""

_UNREACHABLE = int(Status.UNREACHABLE)


@njit(forceinline=True)
def _is_sound(value: float) -> bool:
    # A comparison with a NaN is false.
    return abs(value) < MAX_MAGNITUDE


@njit(forceinline=True)
def is_usable(observation) -> bool:
    """Whether everything that a controller reads is a number of this world, and a foot stands."""
    sound = _is_sound(observation.elapsed) and abs(observation.time) < MAX_TIME
    sound = sound and _is_sound(observation.support_yaw) and _is_sound(observation.swing_yaw)
    for i in range(2):
        sound = sound and _is_sound(observation.dcm[i]) and _is_sound(observation.com[i])
        sound = sound and _is_sound(observation.com_velocity[i])
        sound = sound and _is_sound(observation.support_foot[i])
        sound = sound and _is_sound(observation.trunk_lean[i])
        sound = sound and _is_sound(observation.trunk_lean_velocity[i])
    for i in range(3):
        sound = sound and _is_sound(observation.swing_foot[i])
        sound = sound and _is_sound(observation.swing_foot_velocity[i])
    return sound and abs(observation.support_side) == 1


@njit(forceinline=True)
def growth_since_touchdown(omega: float, elapsed: float) -> float:
    """e^(omega t), for a robot that stands and stands too: it stays finite."""
    return math.exp(min(omega * elapsed, MAX_EXPONENT))


@njit(forceinline=True)
def side_index(support_side: int) -> int:
    """Row of a per-side table: 0 for the right foot on the ground, 1 for the left."""
    return 0 if support_side > 0 else 1


@njit(forceinline=True)
def is_surely_slow(swing, position, velocity, acceleration, landing, left) -> bool:
    """Whether the control points of the smooth way keep the limits: then all of the way does.

    A polynomial lies within the hull of its control points. With P those of the quintic, those of
    its velocity are 5 (P' - P) / R and those of its acceleration 4 (V' - V) / R.
    """
    speed, most = swing.max_speed, swing.max_acceleration
    first = velocity + 0.25 * acceleration * left
    way = landing - position - left * (0.4 * velocity + 0.05 * acceleration * left)
    second = 5.0 * way / left
    rising, falling = 4.0 * (second - first) / left, 4.0 * second / left
    slow = abs(velocity) <= speed and abs(first) <= speed and abs(second) <= speed
    return slow and abs(acceleration) <= most and abs(rising) <= most and abs(falling) <= most


@njit
def is_too_fast(swing, position, velocity, acceleration, landing, left) -> bool:
    """Whether the smooth way to the landing would ask too much of the leg, along one axis."""
    speed = swing.max_speed * (1.0 + LIMIT_TOLERANCE)
    most = swing.max_acceleration * (1.0 + LIMIT_TOLERANCE)
    if speed == math.inf and most == math.inf:
        return False
    if is_surely_slow(swing, position, velocity, acceleration, landing, left):
        return False
    for k in range(SAMPLES):
        _, then, change = quintic(
            position, velocity, acceleration, landing, 0.0, left, left * k / SAMPLES
        )
        if abs(then) > speed or abs(change) > most:
            return True
    return False


@njit(forceinline=True)
def _comes_short(swing, away, velocity, left) -> bool:
    """Whether the leg cannot bring the foot to its landing in the time left, along one axis."""
    return abs(away) > AT_PLACE * swing.height and not is_reachable(
        away, velocity, left, swing.max_speed, swing.max_acceleration
    )


@njit(forceinline=True)
def _move_over_ground(swing, observation, previous, new_step, left, command):
    """Write x and y of the swing foot; flag a landing that the leg cannot reach."""
    for i in range(2):
        foot, velocity = observation.swing_foot[i], observation.swing_foot_velocity[i]
        acceleration = 0.0 if new_step else previous.swing_foot_acceleration[i]
        fastest, hardest = WILD[0] * swing.reach / left, WILD[1] * swing.reach / (left * left)
        velocity = min(max(velocity, -fastest), fastest)
        acceleration = min(max(acceleration, -hardest), hardest)
        landing = command.step_location[i]
        away = landing - foot
        if _comes_short(swing, away, velocity, left):
            command.status |= _UNREACHABLE
        if is_too_fast(swing, foot, velocity, acceleration, landing, left):
            moved, speed, change = hurry(
                away, velocity, left, swing.period, swing.max_speed, swing.max_acceleration
            )
            command.swing_foot[i] = foot + moved
            command.swing_foot_velocity[i] = speed
            command.swing_foot_acceleration[i] = change
            continue
        (
            command.swing_foot[i],
            command.swing_foot_velocity[i],
            command.swing_foot_acceleration[i],
        ) = quintic(foot, velocity, acceleration, landing, 0.0, left, swing.period)


@njit(forceinline=True)
def _move_up_and_down(swing, left, phase, command):
    """Write z of the swing foot, from the phase of its flight one period on."""
    if phase[1] == 0.0:
        phase[1] = 1.0 / left
    phase[0], phase[1], phase[2] = next_phase(phase[0], phase[1], phase[2], left, swing.period)
    (
        command.swing_foot[2],
        command.swing_foot_velocity[2],
        command.swing_foot_acceleration[2],
    ) = height(phase[0], phase[1], phase[2], swing.height, swing.descent)


@njit(forceinline=True)
def _stand(location_x, location_y, down, command):
    """Write a swing foot that is on the ground, or arrives there."""
    command.swing_foot[0], command.swing_foot[1] = location_x, location_y
    command.swing_foot[2] = 0.0
    for i in range(3):
        command.swing_foot_velocity[i] = command.swing_foot_acceleration[i] = 0.0
    command.swing_foot_velocity[2] = -down


@njit(forceinline=True)
def command_swing(
    swing, observation, in_the_air, landing_yaw, previous, phase, new_step, command
) -> None:
    """Write the swing foot of the command, one period on; `command` already has landing and timing.

    The foot follows its polynomials, C2 through every re-plan. Only along an axis on which these
    would exceed the limits of the leg does it hurry at those: a late foot costs more than a rough
    one. Over ground, position and velocity are those of the observation and the
    acceleration is the one last commanded, since measured accelerations are noise. The height
    follows the phase of the flight, which is remembered.

    Args:
        swing: a `SwingParameters` record.
        observation: an `Observation` record.
        in_the_air: when the foot leaves the ground and when it is back, since touchdown [s].
        landing_yaw: heading with which it lands [rad].
        previous: the `Command` record of the cycle before.
        phase: of the flight, its rate [1/s] and the rate of that [1/s^2]; moved on by a period.
        new_step: whether this is the first cycle of a step: the foot leaves the ground at rest.
        command: the `Command` record to complete; its status gains UNREACHABLE.
    """
    if new_step:
        phase[0] = phase[1] = phase[2] = 0.0
    command.swing_yaw = observation.swing_yaw
    if observation.elapsed < in_the_air[0]:
        _stand(observation.swing_foot[0], observation.swing_foot[1], 0.0, command)
        return
    left = in_the_air[1] - observation.elapsed
    if left > swing.period * (1.0 + LAST_CYCLE):
        command.swing_yaw += (landing_yaw - observation.swing_yaw) * swing.period / left
        _move_over_ground(swing, observation, previous, new_step, left, command)
        _move_up_and_down(swing, left, phase, command)
        return
    command.swing_yaw = landing_yaw
    for i in range(2):
        away = command.step_location[i] - observation.swing_foot[i]
        if _comes_short(swing, away, observation.swing_foot_velocity[i], max(left, 0.0)):
            command.status |= _UNREACHABLE
    # The foot arrives at the pace of its flight; later, in double support, it rests.
    down = swing.descent * phase[1] if left > 0.0 else 0.0
    _stand(command.step_location[0], command.step_location[1], down, command)


@njit(forceinline=True)
def keep_box(tracking, observation, command):
    """Move the landing into the box of steps; a leg that comes short of it there is UNREACHABLE."""
    row = side_index(observation.support_side)
    for i in range(2):
        foot = observation.support_foot[i]
        step = command.step_location[i] - foot
        if step < tracking.step_min[row, i]:
            command.step_location[i] = foot + tracking.step_min[row, i]
        elif step > tracking.step_max[row, i]:
            command.step_location[i] = foot + tracking.step_max[row, i]


@njit(forceinline=True)
def end_cycle(tracking, in_the_air, new_step, state, next_state):
    """Complete the command of a cycle: move the swing foot; say HELD if something is predicted.

    Args:
        tracking: a record with `swing` and `landing_yaw`, such as `Tracking`.
        in_the_air: when the foot leaves the ground and when it is back, since touchdown [s].
        new_step: whether this is the first cycle of a step.
        state: of the cycle before.
        next_state: of this cycle; its command already has landing and timing.
    """
    command_swing(
        tracking.swing,
        next_state.validated.observation,
        in_the_air,
        tracking.landing_yaw,
        state.command,
        next_state.plan.phase,
        new_step,
        next_state.command,
    )
    flag_predicted(next_state)

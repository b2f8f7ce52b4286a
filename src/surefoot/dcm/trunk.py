"""The trunk as a flywheel at the hip: it borrows angular momentum, and has to give it back.

With a hip torque T that leans the trunk towards an axis (inertia J, lean a),

    J a'' = T,      com'' = omega^2 (com - zmp) + F / m - T / (m z),

so a torque acts on the CoM like a push of -T / z. Section IV of [Pratt2006], one axis at a time.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit


@njit
def trunk_flow(
    lean: float, speed: float, torque: float, inertia: float, max_lean: float, duration: float
) -> tuple[float, float, float, float]:
    """The trunk after `duration` of a constant torque, or at rest at its stop if that comes first.

    The stop is inelastic: the trunk's angular momentum goes into the body in one blow, and the
    robot loses what it had borrowed.

    Args:
        lean: now [rad].
        speed: its rate now [rad/s].
        torque: of the hip [N m].
        inertia: of the trunk [kg m^2].
        max_lean: where the stop is, to either side [rad].
        duration: time to go [s].

    Returns:
        Lean [rad] and its rate [rad/s] then; for how long the torque acted on the CoM [s]; and the
        angular momentum that the stop took [N m s].
    """
    acceleration = torque / inertia
    stop = duration
    for side in (-1.0, 1.0):
        stop = min(stop, _time_to(side * max_lean - lean, speed, acceleration, side, duration))
    if stop < duration:
        at_stop = math.copysign(max_lean, speed + acceleration * (stop if stop > 0.0 else 1.0))
        return at_stop, 0.0, stop, inertia * (speed + acceleration * stop)
    return (
        lean + (speed + 0.5 * acceleration * duration) * duration,
        speed + acceleration * duration,
        duration,
        0.0,
    )


@njit
def _time_to(distance: float, speed: float, acceleration: float, side: float, never: float):
    """When a motion crosses a stop at `distance` on this side, going outwards."""
    away, speed, acceleration = max(side * distance, 0.0), side * speed, side * acceleration
    if away == 0.0 and speed >= 0.0:
        return 0.0 if speed > 0.0 or acceleration > 0.0 else never
    # The first positive root of acceleration t^2 / 2 + speed t - away, in the form that does not
    # subtract nearly equal numbers.
    discriminant = speed * speed + 2.0 * acceleration * away
    if discriminant < 0.0 or (speed <= 0.0 and acceleration <= 0.0):
        return never
    root = math.sqrt(discriminant)
    return 2.0 * away / (speed + root) if speed >= 0.0 else (root - speed) / acceleration

"""The linear inverted pendulum and its exact flow under a constant ZMP, push and hip torque.

    com'' = omega^2 (com - zmp) + F / m - T / (m z),    dcm = com + com' / omega,    J a'' = T

Eqs. (3)-(7) of [OnlineGait]; a push acts like a shift of the ZMP, see `pushed_pivot`. The trunk is
a flywheel at the hip (inertia J, lean a): it borrows angular momentum, and has to give it back. A
torque T that leans it towards an axis acts on the CoM like a push of -T / z: Section IV of
[Pratt2006], one axis at a time.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit


@njit(forceinline=True)
def pushed_pivot(zmp: float, force: float, mass: float, omega: float) -> float:
    """The pivot p' = p - F / (m omega^2) that acts like ZMP and push together, one axis [m]."""
    return zmp - force / (mass * omega * omega)


@njit(forceinline=True)
def dcm_flow(dcm: float, pivot: float, omega: float, duration: float) -> float:
    """The DCM after `duration` about a constant pivot, one axis: Eq. (7) of [OnlineGait].

    dcm(t) = pivot + (dcm(0) - pivot) e^(omega t); a negative duration runs it backwards.

    Args:
        dcm: divergent component of motion now [m].
        pivot: ZMP, or `pushed_pivot` under a push [m].
        omega: natural frequency [1/s].
        duration: time to go [s].

    Returns:
        The DCM then [m].
    """
    return pivot + (dcm - pivot) * math.exp(omega * duration)


@njit(forceinline=True)
def com_flow(
    com: float, com_velocity: float, pivot: float, omega: float, duration: float
) -> tuple[float, float]:
    """Position and velocity of the CoM after `duration` about a constant pivot, one axis.

    x(t) = p' + (x - p') cosh(omega t) + x'/omega sinh(omega t), and its derivative.

    Args:
        com: position now [m].
        com_velocity: velocity now [m/s].
        pivot: ZMP, or `pushed_pivot` under a push [m].
        omega: natural frequency [1/s].
        duration: time to go, negative to run backwards [s].

    Returns:
        Position [m] and velocity [m/s] then.
    """
    return com_flow_by(com, com_velocity, pivot, omega, math.exp(omega * duration))


@njit(forceinline=True)
def com_flow_by(
    com: float, com_velocity: float, pivot: float, omega: float, growth: float
) -> tuple[float, float]:
    """`com_flow` for a known growth e^(omega duration), which both axes share."""
    cosh, sinh = 0.5 * (growth + 1.0 / growth), 0.5 * (growth - 1.0 / growth)
    lever = com - pivot
    return (
        pivot + lever * cosh + com_velocity / omega * sinh,
        lever * omega * sinh + com_velocity * cosh,
    )


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
        stop = min(stop, _time_to_stop(side * max_lean - lean, speed, acceleration, side, duration))
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
def _time_to_stop(distance: float, speed: float, acceleration: float, side: float, never: float):
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

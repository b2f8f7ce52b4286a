"""The linear inverted pendulum and its exact flow under a constant ZMP and a constant push.

    com'' = omega^2 (com - zmp) + F / m,      dcm = com + com' / omega

Eqs. (3)-(7) of [OnlineGait]; a push acts like a shift of the ZMP, see `pushed_pivot`.
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

"""The DCM plan of one step: Eq. (20) of [OnlineGait], and its smooth form in double support.

In single support the DCM runs away from one foot, and its rate jumps when the next one takes over.
A transition around each touchdown replaces this corner by the cubic in time that meets position
and velocity of the single-support plan at both of its ends (Section VI of [Englsberger2015]). The
ZMP follows as zmp = dcm - dcm' / omega: it leaves one foot where the transition begins and arrives
at the other where it ends, without a jump.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit


@njit
def planned_dcm(support_foot: float, start_offset: float, growth: float) -> float:
    """dcm_plan(t) = p + d_start e^(omega t), one axis.

    Args:
        support_foot: p, centre of the sole on the ground [m].
        start_offset: planned DCM relative to it at touchdown [m].
        growth: e^(omega t), t the time since touchdown.

    Returns:
        The planned DCM [m].
    """
    return support_foot + start_offset * growth


@njit
def hermite(
    start: float, start_rate: float, end: float, end_rate: float, duration: float, time: float
) -> tuple[float, float]:
    """The cubic that meets position and rate at both ends, one axis.

    Args:
        start: position at 0 [m].
        start_rate: rate at 0 [m/s].
        end: position at `duration` [m].
        end_rate: rate at `duration` [m/s].
        duration: positive [s].
        time: when to evaluate [s].

    Returns:
        Position [m] and rate [m/s].
    """
    u = time / duration
    v0, v1 = start_rate * duration, end_rate * duration
    gap = end - start
    c2 = 3.0 * gap - 2.0 * v0 - v1
    c3 = -2.0 * gap + v0 + v1
    position = start + u * (v0 + u * (c2 + u * c3))
    return position, (v0 + u * (2.0 * c2 + 3.0 * u * c3)) / duration


@njit
def transition(
    step: float, dcm: float, omega: float, before: float, after: float, time: float
) -> tuple[float, float]:
    """Planned DCM and ZMP of a transition, one axis, relative to the foot that is left.

    Args:
        step: from the foot that is left to the foot that is stepped on [m].
        dcm: single-support plan at touchdown, relative to the foot that is left [m].
        omega: natural frequency [1/s].
        before: how long before the touchdown the transition begins [s].
        after: how long after it the transition ends; both together are positive [s].
        time: since touchdown, -before <= time <= after [s].

    Returns:
        DCM and ZMP, relative to the foot that is left [m].
    """
    begin = dcm * math.exp(-omega * before)
    away = (dcm - step) * math.exp(omega * after)
    position, rate = hermite(
        begin, omega * begin, step + away, omega * away, before + after, time + before
    )
    return position, position - rate / omega

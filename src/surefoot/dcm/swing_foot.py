"""The foot in the air, re-planned every control cycle from where it is: III-C of [OnlineGait].

x, y: the quintic in time that meets position, velocity and acceleration now, and rests at the
landing. z: a bump over the phase of the flight, and the phase by such a quintic. Re-planning
towards an unchanged landing changes nothing: the rest of a polynomial is the polynomial of the
rest.
"""

from __future__ import annotations

from surefoot.compiled import njit

ARRIVED = 1e-9
"""A phase that exceeds 1 by less than this is the landing, not a foot that waits for it."""


@njit(forceinline=True)
def quintic(
    position: float,
    velocity: float,
    acceleration: float,
    end_position: float,
    end_velocity: float,
    duration: float,
    time: float,
) -> tuple[float, float, float]:
    """The quintic between two states, evaluated; its end acceleration is zero.

    Args:
        position, velocity, acceleration: now [m, m/s, m/s^2].
        end_position: there [m].
        end_velocity: there [m/s].
        duration: R, time from now to the end, positive [s].
        time: h, when to evaluate, 0 <= h <= R [s].

    Returns:
        Position, velocity, acceleration at `time` [m, m/s, m/s^2].
    """
    # In u = h / R every coefficient is a length, so a short rest of the step stays well scaled.
    u = time / duration
    v, a = velocity * duration, acceleration * duration * duration
    gap = end_position - position - v - 0.5 * a
    turn = end_velocity * duration - v - a
    c3 = 10.0 * gap - 4.0 * turn - 0.5 * a
    c4 = -15.0 * gap + 7.0 * turn + a
    c5 = 6.0 * gap - 3.0 * turn - 0.5 * a
    return (
        position + u * (v + u * (0.5 * a + u * (c3 + u * (c4 + u * c5)))),
        (v + u * (a + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / duration,
        (a + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (duration * duration),
    )


@njit(forceinline=True)
def next_phase(
    phase: float, rate: float, rate_of_rate: float, left: float, time: float
) -> tuple[float, float, float]:
    """The phase of the flight, 0 at lift-off and 1 at landing, a little later.

    The quintic that goes on from phase, rate and its rate, and arrives when the flight ends with
    the mean rate that is left to go. A flight as planned keeps a constant rate.

    Args:
        phase, rate, rate_of_rate: now [-, 1/s, 1/s^2].
        left: time to the landing, positive [s].
        time: how much later, at most `left` [s].

    Returns:
        The three then.
    """
    return quintic(phase, rate, rate_of_rate, 1.0, (1.0 - phase) / left, left, time)


@njit(forceinline=True)
def height(
    phase: float, rate: float, rate_of_rate: float, apex: float, descent: float
) -> tuple[float, float, float]:
    """Height of the foot over the ground by the phase s of its flight.

    z = 64 apex (s (1 - s))^3 + descent s^3 (1 - s). Whatever becomes of the timing, the foot
    neither rises over its apex nor sinks into the ground, for s is cut off at 0 and 1, where the
    bump has neither slope nor curvature.

    Args:
        phase, rate, rate_of_rate: s and its derivatives [-, 1/s, 1/s^2].
        apex: largest height [m].
        descent: downward speed at landing over the rate of the phase [m].

    Returns:
        Height, velocity, acceleration [m, m/s, m/s^2].
    """
    if phase < 0.0 or phase > 1.0 + ARRIVED:
        return 0.0, 0.0, 0.0
    w, dw = phase * (1.0 - phase), 1.0 - 2.0 * phase
    value = 64.0 * apex * w * w * w + descent * phase * phase * w
    slope = 192.0 * apex * w * w * dw + descent * phase * phase * (3.0 - 4.0 * phase)
    curvature = 384.0 * apex * w * (dw * dw - w) + descent * 6.0 * phase * dw
    return max(value, 0.0), slope * rate, curvature * rate * rate + slope * rate_of_rate

"""The foot in the air, re-planned every control cycle from where it is: III-C of [OnlineGait].

x, y: the quintic in time that meets position, velocity and acceleration now, and rests at the
landing. z: such a quintic plus a bump c h^3 (R - h)^3, h the time from now and R the time left,
that lifts the foot to its apex at half the step. Re-planning towards an unchanged landing changes
nothing: the rest of the polynomial is the polynomial of the rest.
"""

from __future__ import annotations

from surefoot.compiling import njit

APEX_WINDOW = 0.2
"""The apex is aimed at while at least this fraction of the time left lies before it; past that the
bump keeps its height, so that a late change of timing does not fling the foot up."""


@njit
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


@njit
def bump(lift: float, duration: float, time: float) -> tuple[float, float, float]:
    """lift h^3 (R - h)^3 with h = time, R = duration: no velocity or acceleration at both ends.

    Args:
        lift: coefficient [m/s^6].
        duration: R [s].
        time: h [s].

    Returns:
        Height, velocity, acceleration [m, m/s, m/s^2].
    """
    w, dw = time * (duration - time), duration - 2.0 * time
    return lift * w * w * w, 3.0 * lift * w * w * dw, 6.0 * lift * w * (dw * dw - w)


@njit
def bump_lift(
    z: float,
    z_velocity: float,
    z_acceleration: float,
    apex: float,
    landing_velocity: float,
    elapsed: float,
    duration: float,
    previous_lift: float,
    previous_duration: float,
) -> float:
    """The lift of the bump for the rest of the step.

    While the apex (half the step) is well ahead, the lift that takes the foot through it. Then
    the polynomial under way goes on, whose lift is constant; a change of timing stretches the
    bump in time, not in height.

    Args:
        z, z_velocity, z_acceleration: the foot now [m, m/s, m/s^2].
        apex: height to reach [m].
        landing_velocity: downward speed at touchdown [m/s].
        elapsed: t, time since touchdown [s].
        duration: T of the step, larger than t [s].
        previous_lift: what this function returned a cycle ago [m/s^6].
        previous_duration: T that it was for [s].

    Returns:
        The lift [m/s^6].
    """
    left, to_apex = duration - elapsed, 0.5 * duration - elapsed
    if to_apex >= APEX_WINDOW * left:
        base, _, _ = quintic(z, z_velocity, z_acceleration, 0.0, -landing_velocity, left, to_apex)
        w = to_apex * (left - to_apex)
        return (apex - base) / (w * w * w)
    stretch = max(previous_duration - elapsed, 0.0) / left
    return previous_lift * stretch**6

"""How fast a swing foot gets anywhere: each axis by itself, limited in speed and acceleration.

Forward and sideways motion come from different joints, so the limits hold for x and y separately.
A foot that lands is stopped by the ground, at whatever speed it comes; one that lifts off starts at
rest.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit

REACH_TOLERANCE = 1e-9
"""A place further away than the reach by no more than this part of the way is reached."""


@njit(forceinline=True)
def furthest(velocity: float, time: float, speed: float, acceleration: float) -> float:
    """The largest displacement along an axis that a foot can have after a time [m].

    Full acceleration until the speed limit, then at that. Against the axis it is
    -furthest(-velocity, ...), and every place between both can be had.

    Args:
        velocity: of the foot now, along the axis [m/s].
        time: from now, >= 0 [s].
        speed: V, largest speed, may be inf [m/s].
        acceleration: A, largest acceleration, may be inf [m/s^2].
    """
    if acceleration == math.inf:
        return math.inf if speed == math.inf else speed * time
    ramp = (speed - velocity) / acceleration
    if time <= ramp:
        return time * (velocity + 0.5 * acceleration * time)
    return speed * time - 0.5 * (speed - velocity) * ramp


@njit(forceinline=True)
def reach(foot, velocity, time, speed, acceleration):
    """Least and largest place of a foot along an axis after a time; arguments as of `furthest`."""
    behind = foot - furthest(-velocity, time, speed, acceleration)
    return behind, foot + furthest(velocity, time, speed, acceleration)


@njit
def time_to(away: float, velocity: float, speed: float, acceleration: float) -> float:
    """The least time in which a foot can be `away` ahead, the inverse of `furthest` [s].

    Args:
        away: displacement along the axis; what is behind is reached at once [m].
        velocity, speed, acceleration: as of `furthest`.
    """
    if away < 0.0:
        return 0.0
    if acceleration == math.inf:
        return away / speed
    fastest = math.sqrt(velocity * velocity + 2.0 * acceleration * away)
    if fastest > speed:
        return away / speed + 0.5 * (speed - velocity) ** 2 / (acceleration * speed)
    if velocity > 0.0:
        return 2.0 * away / (velocity + fastest)
    return (fastest - velocity) / acceleration


@njit(forceinline=True)
def is_reachable(away: float, velocity: float, time: float, speed: float, acceleration: float):
    """Whether a foot can be `away` from where it is, after a time; arguments as of `furthest`."""
    rounding = REACH_TOLERANCE * abs(away)
    return (
        away <= furthest(velocity, time, speed, acceleration) + rounding
        and -away <= furthest(-velocity, time, speed, acceleration) + rounding
    )


@njit(forceinline=True)
def reachable_interval(low, high, foot, velocity, time, speed, acceleration, rounding):
    """An interval of landings cut down to what is in reach after a time, along one axis.

    Where nothing of it is in reach, both ends are the nearest place that is.

    Args:
        low, high: of the landing, from the support foot [m].
        foot, velocity: of the swing foot, likewise [m, m/s].
        time: to the landing, >= 0 [s].
        speed, acceleration: limits of the leg, may be inf [m/s, m/s^2].
        rounding: what is out of reach by no more is in reach [m].

    Returns:
        Least and largest landing [m], and how fast each moves as the time grows, 0 at an end of the
        interval [m/s].
    """
    behind, ahead = reach(foot, velocity, time, speed, acceleration)
    back_rate = ahead_rate = speed
    if acceleration < math.inf:
        back_rate = min(speed, acceleration * time - velocity)
        ahead_rate = min(speed, acceleration * time + velocity)
    if behind > high + rounding:
        return behind, behind, -back_rate, -back_rate
    if ahead < low - rounding:
        return ahead, ahead, ahead_rate, ahead_rate
    first, last, first_rate, last_rate = low, high, 0.0, 0.0
    if behind > low:
        first, first_rate = min(behind, high), -back_rate
    if ahead < high:
        last, last_rate = max(ahead, low), ahead_rate
    return first, last, first_rate, last_rate


@njit
def arrival(
    away: float, velocity: float, earliest: float, speed: float, acceleration: float
) -> float:
    """The least time, not before `earliest`, at which a foot can be `away` from where it is [s].

    A foot that is fast runs past a place near it: it is there early, or when it has come back.
    Other arguments as of `furthest`.
    """
    if acceleration == math.inf:
        return max(earliest, abs(away) / speed)
    if is_reachable(away, velocity, earliest, speed, acceleration):
        return earliest
    side = math.copysign(1.0, away)
    first = time_to(abs(away), side * velocity, speed, acceleration)
    if first >= earliest:
        return first
    past = velocity * velocity - 2.0 * acceleration * abs(away)
    return (abs(velocity) + math.sqrt(max(past, 0.0))) / acceleration


@njit
def cruise_velocity(away: float, velocity: float, time: float, acceleration: float) -> float:
    """The velocity to take up at full acceleration and keep, to be `away` after exactly `time`.

    With u = |change of velocity|, u T - u^2 / (2 A) is what the change makes up for. Where even an
    acceleration that lasts to the end is too little, that acceleration.

    Args:
        away: displacement wanted [m].
        velocity: of the foot now [m/s].
        time: T, positive [s].
        acceleration: A, may be inf [m/s^2].
    """
    if acceleration == math.inf:
        return away / time
    missing = away - velocity * time
    rest = time * time - 2.0 * abs(missing) / acceleration
    change = acceleration * (time - math.sqrt(max(rest, 0.0)))
    return velocity + math.copysign(change, missing)


@njit
def hurry(
    away: float, velocity: float, time: float, period: float, speed: float, acceleration: float
) -> tuple[float, float, float]:
    """One period of the fastest sensible way to a landing, along one axis.

    As fast as the foot could still stop there, which leaves time for a landing that is called for
    earlier; or faster, if that is what it takes to be in time.

    Args:
        away: from the foot to the landing [m].
        velocity: of the foot now [m/s].
        time: to the landing, at least a period [s].
        period: how far ahead to look [s].
        speed, acceleration: limits of the leg, may be inf [m/s, m/s^2].

    Returns:
        Displacement, velocity and acceleration one period from now.
    """
    side = math.copysign(1.0, away)
    needed = side * cruise_velocity(away, velocity, time, acceleration)
    stopping = side * away / period
    if acceleration < math.inf:
        # A period of braking from there on is still to come.
        stopping = math.sqrt(2.0 * acceleration * abs(away)) - acceleration * period
        stopping = max(stopping, 0.0)
    wanted = side * min(max(needed, min(speed, stopping), -speed), speed)
    if acceleration == math.inf:
        return wanted * period, wanted, 0.0
    most = acceleration * period
    change = min(max(wanted - velocity, -most), most)
    reached = velocity + change
    still = math.copysign(acceleration, change) if abs(change) == most else 0.0
    return reached * period - 0.5 * change * abs(change) / acceleration, reached, still


@njit
def follow(
    away: float, wanted: float, velocity: float, time: float, speed: float, acceleration: float
) -> tuple[float, float]:
    """Where a foot of limited leg gets that is to be `away` with velocity `wanted`.

    As near as it can get; and of the velocities that it can have there, the nearest. With D what
    the place is ahead of coasting, a change of velocity x is possible there if
    |D - x T / 2| <= A T^2 / 4 - x^2 / (4 A).

    Args:
        away: displacement asked for [m].
        wanted: velocity asked for there [m/s].
        velocity: of the foot now [m/s].
        time: T, when it shall be there, from now [s].
        speed, acceleration: limits of the leg, may be inf [m/s, m/s^2].

    Returns:
        Displacement and velocity.
    """
    ahead = furthest(velocity, time, speed, acceleration)
    behind = -furthest(-velocity, time, speed, acceleration)
    place = min(max(away, behind), ahead)
    if acceleration == math.inf:
        if place != away:
            return place, math.copysign(speed, away)
        return place, wanted
    room = acceleration * time * time
    gain = 2.0 * (place - velocity * time)
    most = acceleration * time - math.sqrt(2.0 * acceleration * max(room - gain, 0.0))
    least = -acceleration * time + math.sqrt(2.0 * acceleration * max(room + gain, 0.0))
    low, high = min(most, least), max(most, least)
    changed = velocity + min(max(wanted - velocity, low), high)
    return place, min(max(changed, -speed), speed)

"""Continuous double support: the DCM plan with smooth transitions from foot to foot.

In single support the DCM runs away from one foot, and its rate jumps when the next one takes over.
A transition around each touchdown replaces this corner by the cubic in time that meets position
and velocity of the single-support plan at both of its ends (Section VI of [Englsberger2015]). The
ZMP follows as zmp = dcm - dcm' / omega: it leaves one foot where the transition begins and arrives
at the other where it ends, without a jump.
"""

from __future__ import annotations

import math

from surefoot.compiling import njit


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


@njit
def project_onto_feet(
    point_x: float, point_y: float, step_x: float, step_y: float, half_x: float, half_y: float
) -> tuple[float, float]:
    """The point of the support polygon of both feet that is nearest to a point.

    Two soles of the same size and orientation, at 0 and at `step`, span the sum of the segment
    between their centres and one sole. So the nearest point is c + clip(point - c, sole) for the
    best c on the segment: the distance is convex and piecewise quadratic along it, with a kink
    where point - c crosses an edge of the sole.

    Args:
        point_x, point_y: relative to one foot [m].
        step_x, step_y: the other foot, relative to that one [m].
        half_x, half_y: half the sole's length and width [m].

    Returns:
        The nearest point (x, y), the point itself if it is inside [m].
    """
    best_x, best_y, best = 0.0, 0.0, math.inf
    for k in range(7):
        share = _share(k, point_x, point_y, step_x, step_y, half_x, half_y)
        share = min(max(share, 0.0), 1.0)
        centre_x, centre_y = share * step_x, share * step_y
        x = centre_x + min(max(point_x - centre_x, -half_x), half_x)
        y = centre_y + min(max(point_y - centre_y, -half_y), half_y)
        distance = math.hypot(point_x - x, point_y - y)
        if distance < best:
            best_x, best_y, best = x, y, distance
    return best_x, best_y


@njit
def _share(k, point_x, point_y, step_x, step_y, half_x, half_y) -> float:
    """The k-th candidate for the best centre: a kink, or the minimum of a quadratic piece.

    0 to 3: an edge of the sole passes through the point. 4 to 6: a corner or two of the sole runs
    along an edge of the polygon, nearest to the point.
    """
    if k < 2:
        return (point_x + (half_x if k == 0 else -half_x)) / step_x if step_x != 0.0 else 0.0
    if k < 4:
        return (point_y + (half_y if k == 2 else -half_y)) / step_y if step_y != 0.0 else 0.0
    if k == 4:
        return 0.0
    length = step_x * step_x + step_y * step_y
    if length == 0.0:
        return 1.0
    # The long edges join the corners that lie most to the left or right of the step.
    turn = 1.0 if k == 5 else -1.0
    corner_x = -turn * math.copysign(half_x, step_y)
    corner_y = turn * math.copysign(half_y, step_x)
    return ((point_x - corner_x) * step_x + (point_y - corner_y) * step_y) / length


@njit
def distances_to_support(observations, commands, half_x: float, half_y: float, distances):
    """How far each ZMP of a log is from the support polygon of its time.

    Args:
        observations: array of `OBSERVATION` records.
        commands: array of `COMMAND` records of the same length.
        half_x, half_y: half the sole's length and width [m].
        distances: written, 0 inside, shape (n,) [m].
    """
    for k in range(len(distances)):
        foot, other = observations[k].support_foot, observations[k].swing_foot
        shared = commands[k].double_support != 0
        away_x, away_y = commands[k].zmp[0] - foot[0], commands[k].zmp[1] - foot[1]
        step_x = other[0] - foot[0] if shared else 0.0
        step_y = other[1] - foot[1] if shared else 0.0
        x, y = project_onto_feet(away_x, away_y, step_x, step_y, half_x, half_y)
        distances[k] = math.hypot(away_x - x, away_y - y)

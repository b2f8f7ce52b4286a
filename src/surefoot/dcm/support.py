"""Where the ZMP can be: under one sole, or in the convex hull of two."""

from __future__ import annotations

import math

from surefoot.compiled import njit

ROUNDING = 1e-10
"""Corners that differ by less, as a part of the size of both soles, are one."""


@njit
def nearest_under_foot(
    x: float, y: float, half_x: float, half_y: float, yaw: float
) -> tuple[float, float]:
    """The point of a sole, centred at 0, that is nearest to a point.

    Args:
        x, y: the point [m].
        half_x, half_y: half the sole's length and width [m].
        yaw: heading of the sole [rad].

    Returns:
        The nearest point (x, y), the point itself if it is inside [m].
    """
    cos, sin = math.cos(yaw), math.sin(yaw)
    along = min(max(cos * x + sin * y, -half_x), half_x)
    across = min(max(cos * y - sin * x, -half_y), half_y)
    return cos * along - sin * across, sin * along + cos * across


@njit
def _corner(k, other_x, other_y, half_x, half_y, yaw, other_yaw):
    """Corner k of two soles: 0 to 3 of the one at 0, 4 to 7 of the other."""
    cos, sin = math.cos(yaw if k < 4 else other_yaw), math.sin(yaw if k < 4 else other_yaw)
    along = half_x if k % 4 < 2 else -half_x
    across = half_y if k % 2 == 0 else -half_y
    x, y = cos * along - sin * across, sin * along + cos * across
    return (x, y) if k < 4 else (x + other_x, y + other_y)


@njit
def nearest_under_feet(
    x: float,
    y: float,
    other_x: float,
    other_y: float,
    half_x: float,
    half_y: float,
    yaw: float,
    other_yaw: float,
) -> tuple[float, float]:
    """The point of the convex hull of two soles that is nearest to a point.

    Two corners span an edge of the hull if all corners lie on one side of their line. A point that
    is on that side of every edge is inside; for any other one the nearest point is on an edge.

    Args:
        x, y: the point, relative to the centre of one sole [m].
        other_x, other_y: centre of the other sole [m].
        half_x, half_y: half a sole's length and width [m].
        yaw, other_yaw: heading of the soles [rad].

    Returns:
        The nearest point (x, y), the point itself if it is inside [m].
    """
    inside, best, best_x, best_y = True, math.inf, x, y
    size = half_x * half_x + half_y * half_y + other_x * other_x + other_y * other_y
    for i in range(8):
        from_x, from_y = _corner(i, other_x, other_y, half_x, half_y, yaw, other_yaw)
        for j in range(8):
            to_x, to_y = _corner(j, other_x, other_y, half_x, half_y, yaw, other_yaw)
            edge_x, edge_y = to_x - from_x, to_y - from_y
            length = edge_x * edge_x + edge_y * edge_y
            if length < ROUNDING * ROUNDING * size:
                continue
            least = 0.0
            for k in range(8):
                far_x, far_y = _corner(k, other_x, other_y, half_x, half_y, yaw, other_yaw)
                least = min(least, edge_x * (far_y - from_y) - edge_y * (far_x - from_x))
            if least < -ROUNDING * size:
                continue
            away_x, away_y = x - from_x, y - from_y
            if edge_x * away_y - edge_y * away_x < 0.0:
                inside = False
            share = min(max((edge_x * away_x + edge_y * away_y) / length, 0.0), 1.0)
            near_x, near_y = from_x + share * edge_x, from_y + share * edge_y
            distance = math.hypot(x - near_x, y - near_y)
            if distance < best:
                best, best_x, best_y = distance, near_x, near_y
    return (x, y) if inside else (best_x, best_y)


@njit
def nearest_supported(observation, shared: bool, x: float, y: float, half_x: float, half_y: float):
    """The point of the support polygon nearest to (x, y), both relative to the support foot.

    Args:
        observation: an `OBSERVATION` record.
        shared: whether the other foot is on the ground too.
        x, y: the point [m].
        half_x, half_y: half a sole's length and width [m].

    Returns:
        The nearest point (x, y) [m].
    """
    if not shared:
        return nearest_under_foot(x, y, half_x, half_y, observation.support_yaw)
    return nearest_under_feet(
        x,
        y,
        observation.swing_foot[0] - observation.support_foot[0],
        observation.swing_foot[1] - observation.support_foot[1],
        half_x,
        half_y,
        observation.support_yaw,
        observation.swing_yaw,
    )


@njit
def distances_to_support(observations, commands, half_x: float, half_y: float, distances):
    """How far each ZMP of a log is from the support polygon of its time.

    Args:
        observations: array of `OBSERVATION` records.
        commands: array of `COMMAND` records of the same length.
        half_x, half_y: half a sole's length and width [m].
        distances: written, 0 inside, shape (n,) [m].
    """
    for k in range(len(distances)):
        foot, zmp = observations[k].support_foot, commands[k].zmp
        away_x, away_y = zmp[0] - foot[0], zmp[1] - foot[1]
        shared = commands[k].double_support != 0
        x, y = nearest_supported(observations[k], shared, away_x, away_y, half_x, half_y)
        distances[k] = math.hypot(away_x - x, away_y - y)

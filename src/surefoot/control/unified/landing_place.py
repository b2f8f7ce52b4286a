"""The landing that costs an axis least, for a given time: the inner problem of `solver`.

For one tau the cost of an axis is piecewise quadratic in the landing X, with kinks at the nodes of
Z and where a penalty sets in, and convex where Z is concave. Newton's method inside a bracket finds
its minimum; where the Z of a slow leg bends up a little, one that costs the same to 1e-3.
"""

from __future__ import annotations

from surefoot.compiled import njit
from surefoot.control.unified.anticipation import worth_after

NEWTON_STEPS = 30
"""At most; the pieces of the cost are few, so three are usual."""

RESOLUTION = 1e-13
"""A step of Newton's method that is no longer than this part of a cell is the last."""


@njit(forceinline=True)
def soft_error(landing, situation, axis, growth, place):
    """What ZMP and next step cannot take of the error at landing: beyond the dead zone [m]."""
    error = situation.offset[axis] * growth - situation.offset_ref[axis] - place
    zone = landing.gentle_zmp[axis] * (growth - 1.0) + landing.gentle_offset[axis]
    return error - zone if error > zone else (error + zone if error < -zone else 0.0)


@njit(forceinline=True)
def excess(landing, situation, axis, growth, place, along, against):
    """v of both sides: how far a landing is outside of what can be saved after it [m].

    Args:
        along, against: Z there, for an offset along the axis and against it [m].
    """
    rate, shift, zmp = situation.rate, situation.shift, landing.zmp_reach[axis]
    return (
        (rate[axis, 0] - zmp) * growth + shift[axis, 0] - place - along,
        -(rate[axis, 1] + zmp) * growth - shift[axis, 1] + place - against,
    )


@njit(forceinline=True)
def excess_at(landing, situation, axis, growth, place):
    """v of both sides at a landing [m]."""
    along, _ = worth_after(landing.worth, landing, axis, 0, place)
    against, _ = worth_after(landing.worth, landing, axis, 1, place)
    return excess(landing, situation, axis, growth, place, along, against)


@njit(forceinline=True)
def reserved(landing, axis, growth):
    """How far v has to stay below 0 for a ZMP within c_g: rho, and what it leaves [m]."""
    spare = landing.zmp_reach[axis] - landing.gentle_zmp[axis]
    return landing.reserve[axis] + spare * (growth - 1.0)


@njit(forceinline=True)
def place_slope(landing, situation, axis, growth, place, cell):
    """First and second derivative of an axis's cost in X, with the slopes of Z in one cell."""
    spacing, low = landing.spacing[axis], landing.step_min[axis]
    into = place - low - cell * spacing
    up, down = landing.worth[axis, 0, cell], landing.worth[axis, 1, cell]
    up_slope = (landing.worth[axis, 0, cell + 1] - up) / spacing
    down_slope = (landing.worth[axis, 1, cell + 1] - down) / spacing
    over, under = excess(
        landing, situation, axis, growth, place, up + up_slope * into, down + down_slope * into
    )
    error = soft_error(landing, situation, axis, growth, place)
    weight, stiff = landing.step_weight[axis], landing.offset_weight[axis]
    reserve, gentle = landing.reserve[axis], reserved(landing, axis, growth)
    slope = weight * (place - situation.step_ref[axis]) - stiff * error
    second = weight + (stiff if error != 0.0 else 0.0)
    for k in range(2):
        side = 1.0 + up_slope if k == 0 else down_slope - 1.0
        value = over if k == 0 else under
        if value > 0.0:
            slope -= side * landing.lost_weight * value
            second += side * side * landing.lost_weight
        if value > -gentle:
            slope -= side * landing.gentle_weight * (value + gentle)
            second += side * side * landing.gentle_weight
        if value > -reserve:
            slope -= side * landing.reserve_weight * (value + reserve)
            second += side * side * landing.reserve_weight
    return slope, second


@njit(forceinline=True)
def place_cell(landing, axis, place):
    """The cell of the tables in which a place lies; the last one holds all beyond it."""
    cell = int((place - landing.step_min[axis]) / landing.spacing[axis])
    return min(max(cell, 0), landing.worth.shape[2] - 2)


@njit(forceinline=True)
def end_slope(landing, situation, axis, growth, place):
    """The slope of the cost at an end of the interval."""
    cell = place_cell(landing, axis, place)
    return place_slope(landing, situation, axis, growth, place, cell)[0]


@njit(forceinline=True)
def best_place(landing, situation, axis, growth, low, high, guess):
    """The landing that costs an axis least, for one tau.

    Newton's method from a guess, inside a bracket; between two cells it may end at their node.

    Args:
        low, high: the interval of landings [m].
        guess: where to begin; it changes the way there, not the answer [m].

    Returns:
        X, the slope of the cost there (of which only an end of the interval leaves any), and at
        which end it is: -1, 0 or 1.
    """
    if high <= low:
        slope = end_slope(landing, situation, axis, growth, low)
        return low, slope, -1 if slope > 0.0 else 1
    at_low = at_high = False  # Whether the bracket's end is known to be one.
    place = min(max(guess, low), high)
    for _ in range(NEWTON_STEPS):
        cell = place_cell(landing, axis, place)
        slope, second = place_slope(landing, situation, axis, growth, place, cell)
        if slope > 0.0:
            if place <= low:
                return place, slope, -1
            high, at_high = place, True
        elif slope < 0.0:
            if place >= high:
                return place, slope, 1
            low, at_low = place, True
        else:
            return place, 0.0, 0
        nearer = place - slope / second
        if abs(nearer - place) <= RESOLUTION * landing.spacing[axis]:
            return nearer, 0.0, 0
        if at_low and at_high:
            first, last = place_cell(landing, axis, low), place_cell(landing, axis, high)
            if last == first + 1:
                node = landing.step_min[axis] + last * landing.spacing[axis]
                left, _ = place_slope(landing, situation, axis, growth, node, first)
                right, _ = place_slope(landing, situation, axis, growth, node, last)
                if left <= 0.0 <= right:
                    return node, 0.0, 0
                if left > 0.0:
                    high = node
                else:
                    low = node
            if not low < nearer < high:
                nearer = 0.5 * (low + high)
        place = min(max(nearer, low), high)
    return place, 0.0, 0

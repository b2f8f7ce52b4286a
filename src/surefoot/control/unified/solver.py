"""Solve the problem of `control.unified.problem` in a bounded number of steps.

For a given tau the axes share nothing. The cost of one is piecewise quadratic in its landing X,
with kinks at the nodes of Z and where a penalty sets in, and convex where Z is concave: Newton's
method inside a bracket finds its minimum; where the Z of a slow leg bends up a little, one that
costs the same to 1e-3. What remains is a function of tau alone, convex where Z is concave; the
envelope theorem gives its derivative, in which an active reach of the leg counts with its
multiplier, and a bracketing secant method finds the root. Nothing is allocated.

With a leg of limited acceleration the reach is convex in time until full speed, and has a kink
where it comes to an end of the step box. There the problem is not convex: the best of some landing
times comes first, and the decision costs no more than that.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit
from surefoot.control.unified.anticipation import SAME, corner_time, reach
from surefoot.control.unified.problem import (
    Limit,
    excess,
    excess_at,
    outside,
    reserved,
    soft_error,
)
from surefoot.dcm.leg import furthest

TAU_EVALUATIONS = 60
"""At most; a dozen is usual."""

PARTS = 16
"""Of the interval of tau, among which the best is sought where the problem is not quite convex;
shorter ones first, for a leg gets further the longer it has accelerated."""

SPECIAL = 6
"""Landing times that are tried beside these, see `special_tau`."""

CLOSED = 1e-11
"""Fraction of tau to which the bracket closes."""

NEAR = 2e-3
"""Fraction of tau by which a decision may move from one cycle to the next; most do so less."""

FLAT = 1e-10
"""A derivative of the cost over tau / tau_ref that is no larger than this is zero: the cost is
strongly convex in it."""

NEWTON_STEPS = 30
"""For one axis at most; the pieces of its cost are few, so three are usual."""

RESOLUTION = 1e-13
"""A step of Newton's method that is no longer than this part of a cell is the last."""

_STEP = (int(Limit.STEP_X), int(Limit.STEP_Y))
_LEG = (int(Limit.LEG_X), int(Limit.LEG_Y))
_SHORTEST, _LONGEST = int(Limit.SHORTEST), int(Limit.LONGEST)
_RESERVE, _LOST = int(Limit.RESERVE), int(Limit.LOST)


@njit(forceinline=True)
def place_slope(landing, situation, axis, growth, place, cell):
    """First and second derivative of an axis's cost in X, with the slopes of Z in one cell."""
    spacing, low = landing.spacing[axis], landing.step_min[axis]
    into = place - low - cell * spacing
    up, down = landing.saved[axis, 0, cell], landing.saved[axis, 1, cell]
    up_slope = (landing.saved[axis, 0, cell + 1] - up) / spacing
    down_slope = (landing.saved[axis, 1, cell + 1] - down) / spacing
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
    return min(max(cell, 0), landing.saved.shape[2] - 2)


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


@njit
def tau_slope(landing, situation, tau, decision):
    """d(cost)/d(tau) with the best landings for this tau, which are written into the decision."""
    omega = landing.omega
    shrink = math.exp(-omega * situation.elapsed)
    growth = tau * shrink
    left = max(math.log(tau) / omega - situation.elapsed, 0.0)
    total = landing.tau_weight * (tau - situation.tau_ref)
    for axis in range(2):
        low, high, low_rate, high_rate = reach(landing, situation, axis, left)
        guess = decision.step[axis]
        place, slope, end = best_place(landing, situation, axis, growth, low, high, guess)
        decision.step[axis] = place
        if end != 0:
            rate = low_rate if end < 0 else high_rate
            slope += landing.lost_weight * outside(landing, axis, place)
            total += slope * rate / (omega * tau)
        over, under = excess_at(landing, situation, axis, growth, place)
        part = pressure(landing, situation, axis, growth, over, 1.0)
        part += pressure(landing, situation, axis, growth, under, -1.0)
        error = soft_error(landing, situation, axis, growth, place)
        if error != 0.0:
            gain = situation.offset[axis] - math.copysign(landing.gentle_zmp[axis], error)
            part += landing.offset_weight[axis] * error * gain
        total += shrink * part
    return total


@njit(forceinline=True)
def pressure(landing, situation, axis, growth, value, sign):
    """How what v of a side costs changes with the growth k."""
    offset = sign * situation.rate[axis, 0 if sign > 0.0 else 1]
    lost, short = max(value, 0.0), max(value + landing.reserve[axis], 0.0)
    weighed = landing.lost_weight * lost + landing.reserve_weight * short
    eager = landing.gentle_weight * max(value + reserved(landing, axis, growth), 0.0)
    return weighed * (offset - landing.zmp_reach[axis]) + eager * (
        offset - landing.gentle_zmp[axis]
    )


@njit
def cost_of(landing, situation, tau, decision):
    """The cost of a tau and of the landings in the decision."""
    growth = tau * math.exp(-landing.omega * situation.elapsed)
    off = tau - situation.tau_ref
    total = landing.tau_weight * off * off
    for axis in range(2):
        place = decision.step[axis]
        moved = place - situation.step_ref[axis]
        error = soft_error(landing, situation, axis, growth, place)
        beyond = outside(landing, axis, place)
        total += landing.lost_weight * beyond * beyond
        total += landing.step_weight[axis] * moved * moved
        total += landing.offset_weight[axis] * error * error
        for value in excess_at(landing, situation, axis, growth, place):
            short, lost = max(value + landing.reserve[axis], 0.0), max(value, 0.0)
            eager = max(value + reserved(landing, axis, growth), 0.0)
            total += landing.lost_weight * lost * lost + landing.reserve_weight * short * short
            total += landing.gentle_weight * eager * eager
    return 0.5 * total


@njit(forceinline=True)
def special_tau(landing, situation, guess, k):
    """Landing times at which the cost may have a kink or its minimum, by number: `SPECIAL` of them.

    The foot just reaches an end of the box on an axis; the plan; and the last decision.
    """
    if k == 4:
        return situation.tau_ref
    if k == 5:
        return guess
    edge = landing.step_min[k // 2] if k % 2 == 0 else landing.step_max[k // 2]
    time = situation.elapsed + corner_time(landing, situation, k // 2, edge)
    return math.exp(landing.omega * min(time, landing.longest))


@njit
def best_part(landing, situation, low, high, guess, decision):
    """The best of some landing times, and its neighbours.

    A leg of limited acceleration gets nowhere in the first moments, so that to land at once and to
    land a little later can both be better than what lies between.

    Returns:
        tau before, of, and after the least cost, and that.
    """
    length = math.log(high / low)
    best, where = math.inf, low
    for k in range(PARTS + 1 + SPECIAL):
        if k <= PARTS:
            tau = low * math.exp(length * (k / PARTS) ** 2)
        else:
            tau = special_tau(landing, situation, guess, k - PARTS - 1)
            if not low < tau < high:
                continue
        tau_slope(landing, situation, tau, decision)
        decision.iterations += 1
        cost = cost_of(landing, situation, tau, decision)
        if cost < best:
            best, where = cost, tau
    part = PARTS * math.sqrt(max(math.log(where / low), 0.0) / length)
    before = low * math.exp(length * (max(math.ceil(part - SAME) - 1, 0) / PARTS) ** 2)
    after = low * math.exp(length * (min(math.floor(part + SAME) + 1, PARTS) / PARTS) ** 2)
    for k in range(SPECIAL):
        tau = special_tau(landing, situation, guess, k)
        if before < tau < where * (1.0 - NEAR):
            before = tau
        if where * (1.0 + NEAR) < tau < after:
            after = tau
    return before, where, after, best


@njit
def narrow(landing, situation, low, at_low, high, at_high, guess, decision):
    """A bracket of tau, made narrow around a guess if the root is close to it."""
    if not low < guess < high:
        return low, at_low, high, at_high
    for k in range(2):
        tau = guess
        if k == 1:
            tau *= 1.0 + NEAR if low == guess else 1.0 - NEAR
            if not low < tau < high:
                break
        slope = tau_slope(landing, situation, tau, decision)
        decision.iterations += 1
        if slope < 0.0:
            low, at_low = tau, slope
        else:
            high, at_high = tau, slope
    return low, at_low, high, at_high


@njit
def decide_landing(landing, situation, guess, decision):
    """Write step, tau, active limits and iterations of the decision.

    Args:
        landing: a `LandingParameters` record.
        situation: a `Situation` record.
        guess: of tau, such as the last one; it changes the way to the answer, not the answer.
        decision: a `Decision` record.
    """
    decision.step, decision.iterations = situation.step_ref, 1
    best, least = 0.0, math.inf
    low, high = situation.tau_min, max(situation.tau_max, situation.tau_min)
    tau = min(max(situation.tau_ref, low), high)
    slope, flat = tau_slope(landing, situation, tau, decision), FLAT / situation.tau_ref
    if abs(slope) > flat and landing.max_acceleration < math.inf and high > low:
        low, best, high, least = best_part(landing, situation, low, high, guess, decision)
        tau, slope = best, tau_slope(landing, situation, best, decision)
    if abs(slope) > flat:
        at_low = at_high = slope
        end = low if slope > 0.0 else high
        at_end = tau_slope(landing, situation, end, decision) if end != tau else slope
        decision.iterations += 1
        if (at_end < 0.0) == (slope < 0.0):
            tau = end
        else:
            low, at_low = (end, at_end) if slope > 0.0 else (tau, slope)
            high, at_high = (tau, slope) if slope > 0.0 else (end, at_end)
            low, at_low, high, at_high = narrow(
                landing, situation, low, at_low, high, at_high, guess, decision
            )
            tau = root(landing, situation, low, at_low, high, at_high, flat, decision)
        if cost_of(landing, situation, tau, decision) > least:
            tau = best
            slope = tau_slope(landing, situation, tau, decision)
    decision.tau = tau
    decision.active = 0
    if slope > flat and tau <= situation.tau_min:
        decision.active |= _SHORTEST
    if slope < -flat and tau >= situation.tau_max:
        decision.active |= _LONGEST
    flag_limits(landing, situation, decision)


@njit
def root(landing, situation, low, at_low, high, at_high, flat, decision):
    """The tau between two at which the slope is zero: inverse quadratic steps that never fail.

    The method of Chandrupatla (1997); the decision holds the landings for the tau returned.
    """
    newest, at_newest, old, at_old = low, at_low, high, at_high
    older, at_older = old, at_old
    part = at_newest / (at_newest - at_old)
    tau = newest
    for _ in range(TAU_EVALUATIONS):
        tau = newest + part * (old - newest)
        at_tau = tau_slope(landing, situation, tau, decision)
        decision.iterations += 1
        if (at_tau < 0.0) == (at_newest < 0.0):
            older, at_older = newest, at_newest
        else:
            older, at_older, old, at_old = old, at_old, newest, at_newest
        newest, at_newest = tau, at_tau
        width = abs(old - newest)
        if abs(at_tau) <= flat or width <= CLOSED * tau:
            break
        xi = (newest - old) / (older - old)
        phi = (at_newest - at_old) / (at_older - at_old)
        part = 0.5
        if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
            part = at_newest / (at_old - at_newest) * at_older / (at_old - at_older)
            rise = at_newest / (at_older - at_newest) * at_old / (at_older - at_old)
            part += (older - newest) / (old - newest) * rise
        edge = 0.5 * CLOSED * tau / width
        part = min(max(part, edge), 1.0 - edge)
    return tau


@njit
def flag_limits(landing, situation, decision):
    """Write the flags of the limits that hold a landing; those of the time are kept."""
    tau, active = decision.tau, decision.active & (_SHORTEST | _LONGEST)
    left = max(math.log(tau) / landing.omega - situation.elapsed, 0.0)
    growth = tau * math.exp(-landing.omega * situation.elapsed)
    speed, acceleration = landing.max_speed, landing.max_acceleration
    for axis in range(2):
        place = decision.step[axis]
        if place <= landing.step_min[axis] or place >= landing.step_max[axis]:
            active |= _STEP[axis]
        away, velocity = place - situation.foot[axis], situation.foot_velocity[axis]
        if (
            away > furthest(velocity, left, speed, acceleration) - landing.tolerance
            or -away > furthest(-velocity, left, speed, acceleration) - landing.tolerance
        ):
            active |= _LEG[axis]
        for value in excess_at(landing, situation, axis, growth, place):
            if value > -landing.reserve[axis]:
                active |= _RESERVE
            if value > landing.tolerance:
                active |= _LOST
    decision.active = active

"""How much can still be saved: the margin of the moment, and the share of a push that goes on.

A force F that lasts for h more seconds moves the DCM as much as a displacement of
F / (m omega^2) (1 - e^(-omega h)) now would, across touchdowns too. So what a push MAY still do is
added to the offset before the landing is decided; but never more than can be saved at all, since a
decision for a hopeless case would be a bad one for all others.

It is not known when a push ends. A landing cannot be taken back, and a leg takes time to come back.
So only landings count that also save the robot if the push ends as soon as they cannot be taken
back any more, and a foot in the air goes no further than it can come back from. Own derivation.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit
from surefoot.control.unified.problem import saved_after
from surefoot.dcm.leg import reachable_interval, time_to

GOLDEN = 0.6180339887498949
"""Each round keeps this much of the bracket."""

PARTS = 16
"""Of the interval of landing times, before the best of them is refined; shorter ones first."""

ROUNDS = 10
"""Of the search for the time at which a push is best answered: 1e-2 of a part, and flat there."""

MARGIN_ROUNDS = 20
"""The same for the margin, which is published: 1e-4 of a part."""

ROUNDS_BACK = 5
"""For the way back of a foot, which is only a matter of how far it goes ahead."""

PARTS_ALONE = 24
"""The same if one axis lands alone."""

ROUNDS_ALONE = 6
"""Of the search for the time at which one axis lands, from piece to piece."""

SAME = 1e-6
"""A time that is no further from a sample, in parts, is the sample."""

EDGE = 1e-9
"""A foot that is this part of the step box beside it is at its edge."""

NEWTON_STEPS = 12
"""At most, for the place from which the robot can still turn back; two or three are usual."""

MOMENT = 4e-6
"""Shorter times make no difference [1/omega]."""


@njit(forceinline=True)
def reach(landing, situation, axis, time):
    """Where the foot can land after a time, inside the step box, and how that changes with it.

    Where the leg cannot be in the box in time, both ends are the nearest place that it can get to.

    Returns:
        Least and largest place [m]; velocity of each end, 0 at an end of the box [m/s].
    """
    low, high = landing.step_min[axis], landing.step_max[axis]
    return reachable_interval(
        low, high, situation.foot[axis], situation.foot_velocity[axis], time,
        landing.max_speed, landing.max_acceleration, EDGE * (high - low),
    )  # fmt: skip


@njit(forceinline=True)
def saved_by_landing(landing, situation, axis, sign, time):
    """The largest displacement along `sign` that a landing after a time can save, for c = 0.

    Returns:
        It [m], and how it grows with the time but for its decay [m/s].
    """
    low, high, low_rate, high_rate = reach(landing, situation, axis, time)
    row, place, rate = (0, high, high_rate) if sign > 0.0 else (1, low, low_rate)
    after, slope = saved_after(landing, axis, row, place)
    shrink = math.exp(-landing.omega * time)
    return shrink * (sign * place + after), shrink * (sign + slope) * rate


@njit(forceinline=True)
def corner_time(landing, situation, axis, end):
    """When the foot just reaches an end of the step box, from now [s]; there is a kink."""
    away, velocity = end - situation.foot[axis], situation.foot_velocity[axis]
    side = math.copysign(1.0, away)
    return time_to(abs(away), side * velocity, landing.max_speed, landing.max_acceleration)


@njit
def best_landing(landing, situation, axis, sign, enough, rounds):
    """The landing that saves the largest displacement along `sign`, whatever the other axis does.

    Without a limit of acceleration the saved is linear in time but for its decay, piece by piece,
    and largest where it is its growth over omega; once the foot is at the end of the box, waiting
    only costs. Otherwise the best of some times is refined by golden section.

    Args:
        enough: the search ends at a landing that saves so much beyond the offset [m].
        rounds: of the golden section.

    Returns:
        The displacement that can be saved, beyond the offset and with the ZMP at its edge [m]; and
        the time from now [s].
    """
    earliest, latest = situation.earliest, situation.latest
    end = landing.step_max[axis] if sign > 0.0 else landing.step_min[axis]
    there = corner_time(landing, situation, axis, end)
    beyond = landing.zmp_reach[axis] - sign * situation.offset[axis]
    best, when = saved_by_landing(landing, situation, axis, sign, latest)[0], latest
    if landing.max_acceleration == math.inf:
        time = last = min(max(there, earliest), latest)
        for k in range(ROUNDS_ALONE):
            # Just before the foot is there, for the growth it had.
            before = max(time - MOMENT / landing.omega, earliest) if k == 0 else time
            saved, growth = saved_by_landing(landing, situation, axis, sign, before)
            if saved > best:
                best, when = saved, before
            if growth <= 0.0:
                break
            time = min(max(before + 1.0 / landing.omega - saved / growth, earliest), last)
            if abs(time - before) <= 2.0 * MOMENT / landing.omega:
                break
        saved = saved_by_landing(landing, situation, axis, sign, time)[0]
        if saved > best:
            best, when = saved, time
    else:
        length = latest - earliest
        for k in range(-1, PARTS_ALONE):
            time = earliest + length * (k / PARTS_ALONE) ** 2 if k >= 0 else there
            if not earliest <= time <= latest:
                continue
            saved = saved_by_landing(landing, situation, axis, sign, time)[0]
            if saved > best:
                best, when = saved, time
                if best + beyond >= enough:
                    return best + beyond, when
        part = PARTS_ALONE * math.sqrt(max(when - earliest, 0.0) / length) if length > 0.0 else 0.0
        low = earliest + length * (max(math.floor(part + SAME) - 1, 0) / PARTS_ALONE) ** 2
        high = earliest + length * (min(math.ceil(part - SAME) + 1, PARTS_ALONE) / PARTS_ALONE) ** 2
        for _ in range(rounds):
            left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            at_left = saved_by_landing(landing, situation, axis, sign, left)[0]
            at_right = saved_by_landing(landing, situation, axis, sign, right)[0]
            if max(at_left, at_right) > best:
                best, when = max(at_left, at_right), left if at_left > at_right else right
            if at_left < at_right:
                low = left
            else:
                high = right
    return best + beyond, when


@njit(forceinline=True)
def way_back(landing, situation, axis, sign, growth):
    """How far a landing may be along `sign`, less Z against it, for the DCM not to be left behind.

    The push goes on until the landing cannot be taken back any more, and ends then [m].
    """
    offset, force = situation.offset[axis], situation.force[axis]
    offset = offset * growth + force * (growth - landing.commitment)
    return sign * offset + landing.zmp_reach[axis] * growth


@njit(forceinline=True)
def returning_place(landing, axis, sign, allowed, low, high):
    """The landing furthest along `sign` after which the robot is saved if the push ends.

    sign X - Z_against(X) <= allowed is monotone in the place and linear from node to node: Newton's
    method finds its end inside a bracket.

    Args:
        allowed: of `way_back` [m].
        low, high: the interval of landings [m].

    Returns:
        The place, the end of the interval that is behind if there is none [m]; and how far this is
        inside what is allowed, negative if there is none [m].
    """
    row, near, far = (1, low, high) if sign > 0.0 else (0, high, low)
    left = allowed - sign * far + saved_after(landing, axis, row, far)[0]
    if left >= 0.0:
        return far, left
    left = allowed - sign * near + saved_after(landing, axis, row, near)[0]
    if left < 0.0:
        return near, left
    inside, beyond, place = near, far, near
    _, rise = saved_after(landing, axis, row, near)
    for _ in range(NEWTON_STEPS):
        if sign * rise < 1.0:
            place += left / (sign - rise)
        if not min(inside, beyond) < place < max(inside, beyond):
            place = 0.5 * (inside + beyond)
        value, rise = saved_after(landing, axis, row, place)
        left = allowed - sign * place + value
        if abs(left) <= EDGE * (landing.step_max[axis] - landing.step_min[axis]):
            return place, 0.0
        if left > 0.0:
            inside = place
        else:
            beyond = place
    return inside, 0.0


@njit
def share_at(landing, situation, push_x, push_y, time):
    """The multiple of a displacement that both axes save, if they land after this time.

    A landing that the push would call for counts only as far as it also saves the robot if the push
    ends, see `way_back`. An axis that is not pushed has to keep its reserve: what it lacks of that
    counts as what is lacking of the push.
    """
    least = math.inf
    growth = math.exp(landing.omega * time)
    for axis in range(2):
        push = push_x if axis == 0 else push_y
        low, high, _, _ = reach(landing, situation, axis, time)
        sign = -1.0 if push < 0.0 else 1.0
        allowed = way_back(landing, situation, axis, sign, growth)
        place, left = returning_place(landing, axis, sign, allowed, low, high)
        value, _ = saved_after(landing, axis, 0 if sign > 0.0 else 1, place)
        room = (sign * place + value) / growth + landing.zmp_reach[axis]
        room -= sign * situation.offset[axis]
        rounding = EDGE * (landing.step_max[axis] - landing.step_min[axis])
        if left < -rounding or (push == 0.0 and room < -rounding):
            return -math.inf
        if push != 0.0:
            least = min(least, room / abs(push))
        elif landing.reserve[axis] > 0.0:
            room *= growth
            least = min(least, min(room, 0.5 * (room + left)) / landing.reserve[axis])
    return least


@njit
def max_saved(landing, situation, push_x, push_y, earliest, latest, enough, rounds):
    """The largest `share_at` of all times; the search ends at one that is enough.

    The axes land together, so it is the time that is best for the worse one. Of evenly growing
    samples, and the times at which the leg just reaches an end of the box, the best is refined by
    golden section.
    """
    best, where = -math.inf, earliest
    length = latest - earliest
    for k in range(PARTS + 5):
        if k <= PARTS:
            time = earliest + length * (k / PARTS) ** 2
        else:
            axis, end = (k - PARTS - 1) // 2, (k - PARTS - 1) % 2
            edge = landing.step_max[axis] if end == 0 else landing.step_min[axis]
            time = corner_time(landing, situation, axis, edge)
            if not earliest < time < latest:
                continue
        share = share_at(landing, situation, push_x, push_y, time)
        if share >= enough:
            return share
        if share > best:
            best, where = share, time
    if not length > 0.0:
        return best
    part = PARTS * math.sqrt((where - earliest) / length)
    before, after = max(math.floor(part + SAME) - 1, 0), min(math.ceil(part - SAME) + 1, PARTS)
    low = earliest + length * (before / PARTS) ** 2
    high = earliest + length * (after / PARTS) ** 2
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left = share_at(landing, situation, push_x, push_y, left)
    at_right = share_at(landing, situation, push_x, push_y, right)
    for _ in range(rounds):
        best = max(best, at_left, at_right)
        if best >= enough:
            return best
        if at_left < at_right:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = share_at(landing, situation, push_x, push_y, right)
        else:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = share_at(landing, situation, push_x, push_y, left)
    return best


@njit
def saved_share(landing, situation, push_x, push_y):
    """How much of a displacement that is still to come can be saved: 0 to 1.

    Args:
        landing: a `LandingParameters` record.
        situation: a `Situation` record; reads times, offset, force and foot.
        push_x, push_y: what the push may still do [m].
    """
    if push_x == 0.0 and push_y == 0.0:
        return 1.0
    earliest, latest = situation.earliest, situation.latest
    share = max_saved(landing, situation, push_x, push_y, earliest, latest, 1.0, ROUNDS)
    return min(max(share, 0.0), 1.0)


@njit(forceinline=True)
def anticipate(landing, situation, more_x, more_y):
    """Write what the DCM may be at the landing: the push goes on, or ends just before it.

    Until the landing can no longer be taken back the push can be observed, so for the side
    away from it counts that it ends then: e k + f (k - e^(omega t_c)).
    """
    for i in range(2):
        more, force = (more_x if i == 0 else more_y), situation.force[i]
        situation.anticipated[i] = situation.offset[i] + more
        ending, shift = situation.offset[i] + force, -force * landing.commitment
        for k in range(2):
            goes_on = force == 0.0 or (force > 0.0) == (k == 0)
            situation.rate[i, k] = situation.anticipated[i] if goes_on else ending
            situation.shift[i, k] = 0.0 if goes_on else shift


@njit
def margin(landing, situation):
    """The displacement of the DCM along an axis that can still be saved, in the worst case [m].

    No decision depends on it, so it is found when it is asked for; it takes as long as a decision.

    Args:
        landing: a `LandingParameters` record.
        situation: a `Situation` record; reads times, offset and foot.
    """
    least = math.inf
    for axis in range(2):
        for sign in (1.0, -1.0):
            room, _ = best_landing(landing, situation, axis, sign, math.inf, MARGIN_ROUNDS)
            least = min(least, room)
    return least


@njit
def keep_way_back(landing, situation, decision) -> bool:
    """Move the foot only as far as the robot can still be saved if the push ends now.

    A leg takes time to come back. While what could still be saved against the push is less than the
    reserve, the landing is drawn towards the one that would save it, the more the less it is.

    Returns:
        Whether it is drawn there.
    """
    drawn = False
    for axis in range(2):
        force = situation.force[axis]
        if force == 0.0:
            continue
        sign = -1.0 if force > 0.0 else 1.0
        reserve = landing.reserve[axis]
        room, time = best_landing(landing, situation, axis, sign, reserve, ROUNDS_BACK)
        if room >= reserve:
            continue
        low, high, _, _ = reach(landing, situation, axis, time)
        back = high if sign > 0.0 else low
        if sign * (back - decision.step[axis]) > 0.0:
            part = max(room / reserve, 0.0)
            decision.step[axis] = back + part * (decision.step[axis] - back)
            drawn = True
    return drawn

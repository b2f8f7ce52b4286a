"""What a schedule of landings is worth for a push whose end nobody knows.

`dcm.landing_schedule` with one demand more: at every instant of the push the robot must be
viable without it. Counted along the push, a landing at l takes l off the offset e of the DCM, and
right after a landing at L, with the push going on for r more, e has to lie in

    -(lo_k + c) <= e <= hi_k + c,
    hi_k(L) = e^(-omega T) max over l of (l + hi_(k+1)(l)) - f (1 - e^(-omega min(r, T))),
    lo_k(L) = e^(-omega T) max over l of (-l + lo_(k+1)(l)) + f (1 - e^(-omega T)), or, if less,
              Z_against(L); that alone where the push ends before the next landing.

hi is what the rest of the push leaves, lo what can be saved if it ends now, or goes on. So the rest
of the push has to fit between both ends of what can be saved: where it does not, hi + lo + 2 c < 0,
the foot must not land yet. Own derivation.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit
from surefoot.dcm.landing_schedule import BEHIND, best_place, landing_between, write_tail
from surefoot.dcm.leg import furthest

BOTH = -1
"""Instead of the number of the only axis that counts."""


@njit
def _window(ahead, behind, low, spacing, width, window):
    """Find between which landings the rest of the push fits.

    Args:
        ahead, behind: hi and lo over the landings, both concave [m].
        low, spacing: of the landings [m].
        width: 2 c [m].
        window: first and last landing, written; if there is none, where it nearly fits.

    Returns:
        How much room is left where most is; negative if it fits nowhere [m].
    """
    last = ahead.shape[0] - 1
    best, place = -math.inf, 0
    for node in range(last + 1):
        room = ahead[node] + behind[node] + width
        if room > best:
            best, place = room, node
    window[0] = window[1] = low + place * spacing
    if best < 0.0:
        return best
    for side in range(2):
        step, end = (-1, 0) if side == 0 else (1, last)
        node, room, part = place, best, 0.0
        while node != end:
            further = ahead[node + step] + behind[node + step] + width
            if further < 0.0:
                part = room / (room - further)
                break
            node, room = node + step, further
        window[side] = low + (node + step * part) * spacing
    return best


@njit
def axis_slack(
    own, tail, axis, low, spacing, state, leg, part, reach, duration, schedule, force, work, window
):
    """How much of an axis is left over if the landings take place at these times [m].

    Args:
        own: Z of the axis, shape (2, nodes) [m].
        tail: what all is worth that follows the schedule, likewise.
        axis: 0 for x, 1 for y; `low` and `spacing` of its nodes [m].
        state: DCM offset, swing foot and its velocity [m, m, m/s].
        leg: V [m/s], A [m/s^2], omega [1/s], T_min, T_max [s].
        part: of the push along the axis; 0 if it is not pushed.
        reach: c of the ZMP [m].
        duration: D of the push, which begins now [s].
        schedule: times from landing to landing, the first one from now [s].
        force: f = F / (m omega^2) of the push [m].
        work, window: space of shape (2, 2, nodes) and (2,).
    """
    omega, nodes, count = leg[2], own.shape[1], schedule.shape[0]
    pushed, force = part != 0.0, force * abs(part)
    sign = -1.0 if part < 0.0 else 1.0
    end = 0.0
    for stage in range(count):
        end += schedule[stage]
        sign = sign if axis == 0 else -sign
    row = 0 if sign > 0.0 else 1
    for node in range(nodes):
        work[count % 2, 0, node], work[count % 2, 1, node] = tail[row, node], tail[1 - row, node]
    window[0], window[1] = low, low + spacing * (nodes - 1)
    slack = math.inf
    for stage in range(count - 1, -1, -1):
        time = schedule[stage]
        start = end - time
        # Across, the next foot's inward is this foot's outward: the sides alternate.
        sign = sign if axis == 0 else -sign
        going_on = pushed and start < duration
        lands_pushed = pushed and end < duration
        decay, way = math.exp(-omega * time), furthest(0.0, time, leg[0], leg[1])
        push = force * -math.expm1(-omega * min(max(duration - start, 0.0), time))
        ahead, behind = work[(stage + 1) % 2, 0], work[(stage + 1) % 2, 1]
        most_ahead = best_place(ahead, low, spacing, sign)
        most_behind = best_place(behind, low, spacing, -sign)
        if stage == 0:
            least = state[1] - furthest(-state[2], time, leg[0], leg[1])
            most = state[1] + furthest(state[2], time, leg[0], leg[1])
            least, most = max(least, window[0]), min(most, window[1])
            offset = sign * state[0]
            worth = decay * landing_between(ahead, low, spacing, sign, most_ahead, least, most)
            slack = min(slack, worth - push + reach - offset)
            if lands_pushed or not pushed:
                worth = decay * landing_between(
                    behind, low, spacing, -sign, most_behind, least, most
                )  # fmt: skip
                slack = min(slack, worth + push + reach + offset)
            return slack
        against = own[1 if sign > 0.0 else 0]
        left = saved = 0.0
        for node in range(nodes):
            if node == 0 or way < math.inf:
                foot = BEHIND[axis] * (low + node * spacing)
                least, most = max(foot - way, window[0]), min(foot + way, window[1])
                worth = landing_between(ahead, low, spacing, sign, most_ahead, least, most)
                left = decay * worth - push
                if lands_pushed or not pushed:
                    worth = landing_between(behind, low, spacing, -sign, most_behind, least, most)
                    saved = decay * worth + push
            work[stage % 2, 0, node] = left
            work[stage % 2, 1, node] = saved
            if going_on:
                # Of an interrupted push the landings are as free as those of any walk.
                end_now = against[node]
                work[stage % 2, 1, node] = min(saved, end_now) if lands_pushed else end_now
        window[0], window[1] = low, low + spacing * (nodes - 1)
        if going_on:
            ahead, behind = work[stage % 2, 0], work[stage % 2, 1]
            slack = min(slack, _window(ahead, behind, low, spacing, 2.0 * reach, window))
        end = start
    return slack


@njit
def causal_slack(
    tails, own, low, spacing, state, leg, push, alone, duration, schedule, force, work, tail, window
):
    """How much is left over of the axis that is worst off, if the feet land at these times [m].

    Args:
        tails: what all later steps are worth, for some periods of these, or for no one in
            particular: shape (periods or 1, 2, 2, nodes) [m].
        own: Z, shape (2, 2, nodes) [m].
        low, spacing: of their nodes, (x, y) [m].
        state: rows DCM offset, swing foot and its velocity; x, and y towards the swing foot.
        leg: V [m/s], A [m/s^2], omega [1/s], T_min, T_max [s].
        push: rows direction, a unit vector in the axes of `state`, and reach of the ZMP [m].
        alone: the only axis that counts, or `BOTH`.
        duration: of the push, which begins now [s].
        schedule: times from landing to landing, the first one from now, and at the end the period
            of all that follow [s]; all before it may lie in the push, but the last one.
        force: F / (m omega^2) [m].
        work, tail, window: space of shape (2, 2, nodes) twice, and (2,).
    """
    count = schedule.shape[0] - 1
    write_tail(tails, leg[3:5], schedule[count], tail)
    slack = math.inf
    for axis in range(2):
        if alone != BOTH and axis != alone:
            continue
        room = axis_slack(
            own[axis], tail[axis], axis, low[axis], spacing[axis], state[:, axis], leg,
            push[0, axis], push[1, axis], duration, schedule[:count], force, work, window,
        )  # fmt: skip
        slack = min(slack, room)
    return slack

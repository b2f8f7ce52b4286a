"""The step problem for a leg that takes its time: the landing is in reach when the foot lands.

    minimise    the cost of `dcm.step_solver`
    subject to  its limits, and on each axis  |landing - foot| within reach of the leg in T - t

and the offset d stays within what steps of this leg can still save after a step X, -Z(X) <= d <=
Z(X), see `dcm.viable_displacement`; a violation costs more than all else. A long step that takes
its time leaves the least offset, but a short one at once may be what saves the robot.

What the leg reaches grows with T = ln(tau) / omega. For a given tau the axes separate as before,
each with its box of steps cut down to what is in reach, so the value is a function of tau alone and
its derivative is known. A leg of limited acceleration gets nowhere in the first moments: to land at
once and to land later can both be good. So samples choose a bracket, and the root of the derivative
in it is found to the last bit by halving. The leg also says what is too early: before the foot is
over the box of steps there is no landing.

Where the solution without a leg is in reach it is the solution, and mostly it is. Own derivation.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit
from surefoot.dcm.leg import arrival, is_reachable, reachable_interval
from surefoot.dcm.step_solver import (
    prepare_axes,
    solve_axis,
    solve_step_record,
    write_solution,
)
from surefoot.dcm.viable_displacement import NODES, value_after, viable_displacement
from surefoot.interface import Status
from surefoot.record import Array, Record, Vector2, field
from surefoot.robot.robot import Robot

PARTS = 24
"""Of the interval of landing times among which the best is chosen; the early ones are shorter."""

HALVINGS = 60
"""A bracket of tau is halved no more often: by then its ends are neighbouring numbers."""

LOST_WEIGHT = 1e3
"""On half the squared distance from what can be saved, as a multiple of the largest weight."""

KEPT = 0.9
"""How much of what can be saved an offset may take; on the edge itself the gait would ride for
ever, since every step at its best only just saves the next one."""

_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)


class SavedAfterStep(Record):
    """What can be saved after a step by a leg, as `ViableDisplacement` has it.

    y counts towards the swing foot of the step.
    """

    values: Array = field("m", "Z, or the part of it that counts", shape=(2, 2, NODES), default=0.0)
    low: Vector2 = field("m", "the first step (x, y)", default=(0.0, 0.0))
    spacing: Vector2 = field("m", "between neighbouring steps (x, y)", default=(1.0, 1.0))
    known: int = field("", "0 if there are no tables, for a leg without limits", default=0)


@njit(forceinline=True)
def _cut(axis, foot, velocity, left, leg):
    """An axis whose box of steps is what is in reach, and how fast its ends move."""
    weight, nominal, low, high = axis[0]
    low, high, low_rate, high_rate = reachable_interval(
        low, high, foot, velocity, left, leg[0], leg[1], 0.0
    )
    return ((weight, nominal, low, high), axis[1], axis[2]), low_rate, high_rate


@njit(forceinline=True)
def _of_axis(axis, growth, tau, foot, velocity, left, leg):
    """One axis at its best for a tau: step, offset, how the step moves with tau, dV/dtau."""
    cut, low_rate, high_rate = _cut(axis, foot, velocity, left, leg)
    weight, nominal, low, high = cut[0]
    step, offset, pull, bend, _ = solve_axis(growth * tau, cut)
    # How the cost grows with the step, if the offset makes up for it: 0 where it is free to move.
    push = weight * (step - nominal) - pull
    slope, moving = growth * pull, 0.0
    if push < 0.0 and step >= high:
        moving = high_rate / (leg[2] * tau)
    elif push > 0.0 and step <= low:
        moving = low_rate / (leg[2] * tau)
    elif low < step < high:
        return step, offset, growth * bend / weight, slope
    return step, offset, moving, slope + push * moving


@njit(forceinline=True)
def _lost(problem, saved, side, axis, step, offset, moving, growth):
    """By how far an offset is beyond what can be saved, and how that moves with tau."""
    nominal = problem.nominal_offset[axis]
    sign = 1.0 if axis == 0 else side
    lost = rate = 0.0
    for way in (1.0, -1.0):
        # Across, ahead of this step is inward of the next one.
        ahead = way > 0.0
        row = (0 if ahead else 1) if axis == 0 else (1 if ahead else 0)
        value, slope = value_after(
            saved.values[axis, row], saved.low[axis], saved.spacing[axis], sign * step
        )
        least = way * sign * nominal
        if value < least:
            value, slope = least, 0.0
        beyond = way * sign * offset - value
        if beyond > 0.0:
            lost = beyond
            rate = way * sign * (growth - moving) - slope * sign * moving
    return lost, rate


@njit
def _slope_and_cost(case, tau):
    """The derivative over tau of value and loss, and these; `case` as in `solve_step_in_reach`."""
    problem, saved, side, axes, growth, now, swing, leg = case
    left = max(math.log(tau) / leg[2] - now, 0.0)
    off = tau - problem.nominal_tau
    slope, cost = problem.tau_weight * off, problem.tau_weight * off * off
    for i in range(2):
        axis = axes[0] if i == 0 else axes[1]
        step, offset, moving, part = _of_axis(
            axis, growth[i], tau, swing[i], swing[2 + i], left, leg
        )
        slope += part
        outside = max(0.0, problem.offset_min[i] - offset, offset - problem.offset_max[i])
        moved, missed = step - problem.nominal_step[i], offset - problem.nominal_offset[i]
        cost += problem.step_weight[i] * moved * moved + problem.offset_weight[i] * missed * missed
        cost += problem.offset_penalty * outside * outside
        if saved.known != 0:
            heavy = LOST_WEIGHT * max(problem.offset_penalty, problem.offset_weight[i])
            lost, rate = _lost(problem, saved, side, i, step, offset, moving, growth[i])
            slope += heavy * lost * rate
            cost += heavy * lost * lost
    return slope, 0.5 * cost


@njit
def _best_part(case, low, high):
    """The two neighbouring parts of an interval of tau whose common end costs least."""
    omega = case[-1][2]
    first, length = math.log(low) / omega, math.log(high / low) / omega
    best, place = math.inf, 0
    for k in range(PARTS + 1):
        _, cost = _slope_and_cost(case, math.exp(omega * (first + length * (k / PARTS) ** 2)))
        if cost < best:
            best, place = cost, k
    before, after = max(place - 1, 0) / PARTS, min(place + 1, PARTS) / PARTS
    return (
        max(math.exp(omega * (first + length * before**2)), low),
        min(math.exp(omega * (first + length * after**2)), high),
    )


@njit
def _best_tau_in_reach(case, low, high):
    """The minimiser over tau in [low, high], and how often the derivative was evaluated."""
    evaluations = 2
    if high > low:
        low, high = _best_part(case, low, high)
        evaluations += PARTS + 1
    if _slope_and_cost(case, low)[0] >= 0.0:
        return low, evaluations
    if _slope_and_cost(case, high)[0] <= 0.0:
        return high, evaluations
    for _ in range(HALVINGS):
        tau = 0.5 * (low + high)
        if tau <= low or tau >= high:
            break
        evaluations += 1
        if _slope_and_cost(case, tau)[0] < 0.0:
            low = tau
        else:
            high = tau
    return high, evaluations


@njit(forceinline=True)
def _earliest(axes, swing, leg, soonest):
    """The least time from now after which the foot is over the box of steps [s]."""
    earliest = soonest
    for i in range(2):
        axis = axes[0] if i == 0 else axes[1]
        away = min(max(swing[i], axis[0][2]), axis[0][3]) - swing[i]
        earliest = max(earliest, arrival(away, swing[2 + i], soonest, leg[0], leg[1]))
    return earliest


@njit
def solve_step_in_reach(problem, saved, side, growth, now, swing, leg, solution):
    """Like `solve_step_record`, for a landing that the swing foot is at in time.

    Args:
        problem: a `StepProblem` record; its `growth` is not read.
        saved: a `SavedAfterStep` record.
        side: the foot that stands, +1 the right one, -1 the left one.
        growth: A and B [m].
        now: t, time since touchdown [s].
        swing: swing foot (x, y) relative to the support foot, and its velocity [m, m, m/s, m/s].
        leg: limits of speed and acceleration, and omega [m/s, m/s^2, 1/s].
        solution: a `StepSolution` record, written.
    """
    tau_now = math.exp(leg[2] * now)
    solve_step_record(problem, growth[0], growth[1], tau_now, solution)
    left = max(math.log(solution.tau) / leg[2] - now, 0.0)
    in_reach = True
    for i in range(2):
        away = solution.step[i] - swing[i]
        in_reach = in_reach and is_reachable(away, swing[2 + i], left, leg[0], leg[1])
    if in_reach:
        return
    x_axis, y_axis, _, status = prepare_axes(problem)
    axes = (x_axis, y_axis)
    low, high = max(problem.tau_min, tau_now), problem.tau_max
    if low > high:
        high = low
        status |= _NO_TIME_LEFT
    soonest = max(math.log(low) / leg[2] - now, 0.0)
    earliest = _earliest(axes, swing, leg, soonest)
    if earliest > soonest:
        low = min(math.exp(leg[2] * (now + earliest)), high)
    case = (problem, saved, side, axes, growth, now, swing, leg)
    tau, evaluations = _best_tau_in_reach(case, low, high)
    left = max(math.log(tau) / leg[2] - now, 0.0)
    x_cut, _, _ = _cut(x_axis, swing[0], swing[2], left, leg)
    y_cut, _, _ = _cut(y_axis, swing[1], swing[3], left, leg)
    evaluations += solution.iterations
    solution.status, solution.iterations = status, evaluations
    write_solution(problem, x_cut, y_cut, growth[0], growth[1], tau, solution)


def saved_by(robot: Robot) -> SavedAfterStep:
    """What a robot can save after a step.

    Raises:
        RobotError: the leg is too slow to step at all.
    """
    if not robot.swing.is_limited:
        return SavedAfterStep()
    tables = viable_displacement(robot)
    return SavedAfterStep(
        values=KEPT * tables.values, low=tables.low, spacing=tables.spacing, known=1
    )

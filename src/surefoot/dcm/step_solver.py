"""Where and when to land: the step problem, Eqs. (26)-(34) of [OnlineGait], solved exactly.

    minimise    1/2 a1 (X - X_nom)^2 + 1/2 a2 (Y - Y_nom)^2 + 1/2 a3 (tau - tau_nom)^2
              + 1/2 a4 (d_x - d_x,nom)^2 + 1/2 a5 (d_y - d_y,nom)^2 + 1/2 rho (violation of d)^2
    subject to  X + d_x = A tau,   Y + d_y = B tau,   X, Y, tau in their intervals

with tau = e^(omega T), A = (dcm_x - p_x) e^(-omega t), B likewise in y, and Y the whole lateral
step (the paper's Y + s hip). For a given tau the axes separate, and each is the minimum of a
convex piecewise quadratic in one variable. So the derivative of the value over tau is continuous,
non-decreasing and LINEAR between at most eight known kinks. Newton's method ends exactly as soon as
two iterates share a piece; otherwise the kinks are bisected until one piece is left, whose root is
the solution. No iteration to a tolerance, no allocation.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from surefoot.compiled import entry_point, njit
from surefoot.dcm.step_problem import StepProblem, StepSolution
from surefoot.interface import Status
from surefoot.record import new_array

NEWTON_STEPS = 4
"""Newton's method rarely needs more than two or three evaluations; then the kinks are bisected."""

MAX_ITERATIONS = NEWTON_STEPS + 8 + 2
"""No solve evaluates the derivative more often: Newton, eight kinks, and the last piece twice."""

VIOLATION_TOLERANCE = 1e-6
"""A larger violation of the soft offset bounds is reported in the status, as a fraction of the
longer side of the step box."""

_MIN_WEIGHT = 1e-16
"""Relative floor of the weights: where the problem has many solutions, the nearest to nominal."""

_OFFSET_VIOLATED = int(Status.OFFSET_VIOLATED)
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)
_NO_STEP_LEFT = int(Status.NO_STEP_LEFT)


def solve_step(problem: StepProblem) -> StepSolution:
    """Solve the step problem exactly, in bounded time.

    An empty interval of tau ends the step now: tau = tau_min. An empty interval of the step
    collapses to its middle. Offset bounds are soft, so they never make a problem infeasible.
    The status says which of these happened.

    Args:
        problem: what to solve; not changed.

    Returns:
        The minimiser. Where weights of zero leave many, the one nearest to nominal.
    """
    solution = new_array(StepSolution.DTYPE)
    _compiled()(problem.array, solution)
    return StepSolution.of(solution)


@njit(forceinline=True)
def prepare_axis(step, offset):
    """One axis, ready to be evaluated: its numbers, and what every evaluation divides by.

    The derivative of the cost of the offset over d has the slope `outside` beyond both offset
    bounds, and `inside` between them (with both penalties there if the bounds are crossed).

    Args:
        step: weight, nominal value and bounds of the step [1/m^2, m, m, m].
        offset: weight, penalty, nominal value and bounds of d [1/m^2, 1/m^2, m, m, m].
    """
    weight, (d_weight, penalty, d_nominal, d_low, d_high) = step[0], offset
    inside = d_weight if d_low <= d_high else d_weight + 2.0 * penalty
    outside = d_weight + penalty
    first, second = min(d_low, d_high), max(d_low, d_high)
    pull_first = d_weight * (first - d_nominal) + penalty * max(first - d_high, 0.0)
    pull_first -= penalty * max(d_low - first, 0.0)
    pull_second = d_weight * (second - d_nominal) + penalty * max(second - d_high, 0.0)
    pull_second -= penalty * max(d_low - second, 0.0)
    return (
        step,
        (first, second, pull_first, pull_second),
        (inside, outside, 1.0 / (weight + inside), 1.0 / (weight + outside)),
    )


@njit(forceinline=True)
def solve_axis(r, axis):
    """The best step X and offset d = r - X of one axis, for r = A tau.

    The free d is where the pull of the offset equals that of the step; it lies on one of three
    lines. Clipping X is then exact, since the cost is convex in X.

    Returns:
        X [m], d [m], the multiplier dV/dr, its slope d2V/dr2, and the number of the linear piece.
    """
    (weight, nominal, low, high), (first, second, pull_first, pull_second), slopes = axis
    inside, outside, per_inside, per_outside = slopes
    excess_first = pull_first - weight * (r - first - nominal)
    excess_second = pull_second - weight * (r - second - nominal)
    if excess_first >= 0.0:
        piece, slope, per, d = 0, outside, per_outside, first - excess_first * per_outside
    elif excess_second <= 0.0:
        piece, slope, per, d = 1, outside, per_outside, second - excess_second * per_outside
    else:
        piece, slope, per, d = 2, inside, per_inside, first - excess_first * per_inside
    step = r - d
    if low <= step <= high:
        return step, d, weight * (step - nominal), weight * slope * per, piece
    if step < low:
        piece, step = 3, low
    else:
        piece, step = 6, high
    d = r - step
    if d <= first:
        return step, d, pull_first + outside * (d - first), outside, piece
    if d >= second:
        return step, d, pull_second + outside * (d - second), outside, piece + 1
    return step, d, pull_first + inside * (d - first), inside, piece + 2


@njit
def _offset_at(multiplier, axis):
    """The d at which the pull of the offset equals the multiplier."""
    first, second, pull_first, pull_second = axis[1]
    inside, outside = axis[2][0], axis[2][1]
    if multiplier <= pull_first:
        return first + (multiplier - pull_first) / outside
    if multiplier >= pull_second:
        return second + (multiplier - pull_second) / outside
    return first + (multiplier - pull_first) / inside


@njit
def axis_kinks(axis):
    """The four values of r = A tau at which the best step or offset meets a bound [m]."""
    weight, nominal, low, high = axis[0]
    first, second, pull_first, pull_second = axis[1]
    return (
        first + min(max(nominal + pull_first / weight, low), high),
        second + min(max(nominal + pull_second / weight, low), high),
        low + _offset_at(weight * (low - nominal), axis),
        high + _offset_at(weight * (high - nominal), axis),
    )


@njit(forceinline=True)
def _slope_of_value(tau, case):
    """First and second derivative of the value over tau, and the number of the linear piece."""
    tau_weight, nominal_tau, growth_x, growth_y, x_axis, y_axis = case
    _, _, pull_x, slope_x, piece_x = solve_axis(growth_x * tau, x_axis)
    _, _, pull_y, slope_y, piece_y = solve_axis(growth_y * tau, y_axis)
    gradient = tau_weight * (tau - nominal_tau) + growth_x * pull_x + growth_y * pull_y
    curvature = tau_weight + growth_x * growth_x * slope_x + growth_y * growth_y * slope_y
    return gradient, curvature, 9 * piece_x + piece_y


@njit
def _bisect_kinks(low, high, evaluations, case):
    """`best_tau` from a bracket: cut it at every kink inside, until it holds one piece only.

    A function of its own: it is rarely needed, and too long to be compiled into its caller.
    """
    _, _, growth_x, growth_y, x_axis, y_axis = case
    kinks_x, kinks_y = axis_kinks(x_axis), axis_kinks(y_axis)
    for i in range(8):
        kink = kinks_x[i] / growth_x if i < 4 else kinks_y[i - 4] / growth_y
        if low < kink < high:
            evaluations += 1
            if _slope_of_value(kink, case)[0] < 0.0:
                low = kink
            else:
                high = kink
    tau, previous = 0.5 * (low + high), -1
    for _ in range(2):
        gradient, curvature, piece = _slope_of_value(tau, case)
        evaluations += 1
        # The second time removes the rounding of the first, but not where the root is a kink: the
        # piece behind it may be all but flat, and rounding would send tau to its other end.
        if previous in (-1, piece):
            tau = min(max(tau - gradient / curvature, low), high)
        previous = piece
    return tau, evaluations


@njit
def best_tau(low, high, case):
    """The minimiser over tau in [low, high], and how often the derivative was evaluated.

    Newton's method ends at once when two iterates share a linear piece, which is the rule. If it
    wanders, the bracket it leaves is cut at every kink inside, until it holds one piece only.

    Args:
        low, high: of tau.
        case: weight and nominal value of tau, growth A and B, and both axes.
    """
    tau, previous, evaluations = min(max(case[1], low), high), -1, 0
    while evaluations < NEWTON_STEPS:
        gradient, curvature, piece = _slope_of_value(tau, case)
        evaluations += 1
        if gradient < 0.0:
            low = tau
        else:
            high = tau
        if piece == previous or low >= high:
            # On the same line as the iterate before: what is left is rounding.
            return min(max(tau - gradient / curvature, low), high), evaluations
        tau, previous = min(max(tau - gradient / curvature, low), high), piece
    return _bisect_kinks(low, high, evaluations, case)


@njit(forceinline=True)
def prepare_axes(problem):
    """Both axes of a `StepProblem` record, ready to be evaluated; the weight on tau; the status.

    A box of steps that is empty collapses to its middle.
    """
    status = 0
    x_low, x_high = problem.step_min[0], problem.step_max[0]
    y_low, y_high = problem.step_min[1], problem.step_max[1]
    if x_low > x_high or y_low > y_high:
        status |= _NO_STEP_LEFT
    if x_low > x_high:
        x_low = x_high = 0.5 * (x_low + x_high)
    if y_low > y_high:
        y_low = y_high = 0.5 * (y_low + y_high)
    step_weight, offset_weight = problem.step_weight, problem.offset_weight
    floor = _MIN_WEIGHT * max(
        1.0, problem.tau_weight, step_weight[0], step_weight[1], offset_weight[0], offset_weight[1]
    )
    x_axis = prepare_axis(
        (max(step_weight[0], floor), problem.nominal_step[0], x_low, x_high),
        (max(offset_weight[0], floor), problem.offset_penalty, problem.nominal_offset[0],
         problem.offset_min[0], problem.offset_max[0]),
    )  # fmt: skip
    y_axis = prepare_axis(
        (max(step_weight[1], floor), problem.nominal_step[1], y_low, y_high),
        (max(offset_weight[1], floor), problem.offset_penalty, problem.nominal_offset[1],
         problem.offset_min[1], problem.offset_max[1]),
    )  # fmt: skip
    return x_axis, y_axis, max(problem.tau_weight, floor), status


@njit(forceinline=True)
def write_solution(problem, x_axis, y_axis, growth_x, growth_y, tau, solution):
    """Write the best landing for a tau, its multipliers and violation; add to the status."""
    x, d_x, pull_x, _, _ = solve_axis(growth_x * tau, x_axis)
    y, d_y, pull_y, _, _ = solve_axis(growth_y * tau, y_axis)
    violation = max(
        0.0,
        max(problem.offset_min[0] - d_x, d_x - problem.offset_max[0]),
        max(problem.offset_min[1] - d_y, d_y - problem.offset_max[1]),
    )
    size = max(problem.step_max[0] - problem.step_min[0], problem.step_max[1] - problem.step_min[1])
    if violation > VIOLATION_TOLERANCE * size:
        solution.status |= _OFFSET_VIOLATED
    solution.step[0], solution.step[1], solution.tau = x, y, tau
    solution.offset[0], solution.offset[1] = d_x, d_y
    solution.multiplier[0], solution.multiplier[1] = pull_x, pull_y
    solution.violation = violation


@njit
def solve_step_record(problem, growth_x, growth_y, tau_now, solution):
    """`solve_step` over records, with what changes from cycle to cycle beside the problem.

    Args:
        problem: a `StepProblem` record; its `growth` is not read.
        growth_x: A [m].
        growth_y: B [m].
        tau_now: e^(omega t): no landing before now.
        solution: a `StepSolution` record, written.
    """
    x_axis, y_axis, tau_weight, status = prepare_axes(problem)
    tau_low, tau_high = max(problem.tau_min, tau_now), problem.tau_max
    if tau_low > tau_high:
        tau_high = tau_low
        status |= _NO_TIME_LEFT
    case = (tau_weight, problem.nominal_tau, growth_x, growth_y, x_axis, y_axis)
    tau, evaluations = best_tau(tau_low, tau_high, case)
    solution.status, solution.iterations = status, evaluations
    write_solution(problem, x_axis, y_axis, growth_x, growth_y, tau, solution)


@njit
def _solve_first(problems, solutions):
    """`solve_step_record` on arrays of one record, as they come from Python."""
    problem = problems[0]
    solve_step_record(problem, problem.growth[0], problem.growth[1], 0.0, solutions[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_solve_first, StepProblem, StepSolution)

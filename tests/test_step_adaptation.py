"""The step problem is solved exactly: random ones, realistic and nasty, against a general QP."""

from __future__ import annotations

import math
from typing import Any

import daqp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import surefoot as sf
from surefoot.dcm.step_solver import MAX_ITERATIONS

KINDS = (
    "plain",
    "fixed step",
    "fixed timing",
    "fixed offset",
    "crossed offset bounds",
    "no time left",
    "no step left",
    "no growth in one axis",
    "step weights zero",
    "one offset weight zero",
    "timing weight zero",
    "far out",
    "everything at once",
)
UNIQUE = frozenset(KINDS) - {
    "step weights zero",
    "one offset weight zero",
    "timing weight zero",
    "everything at once",
}
INFINITE = 1e30


def random_problem(rng: np.random.Generator, kind: str) -> dict[str, Any]:
    """Arguments of `StepProblem`."""
    omega = rng.uniform(2.5, 5.0)
    shortest = rng.uniform(0.1, 0.4)
    longest = shortest + rng.uniform(0.0, 0.6)
    low = rng.uniform(-0.6, 0.1, 2)
    high = low + rng.uniform(0.0, 0.9, 2)
    d_low = rng.uniform(-0.2, 0.05, 2)
    d_high = d_low + rng.uniform(0.0, 0.25, 2)
    growth = rng.normal(0.0, 0.15, 2)
    step_weight = 10.0 ** rng.uniform(-1.0, 1.0, 2)
    offset_weight = 10.0 ** rng.uniform(0.0, 4.5, 2)
    tau_weight = 10.0 ** rng.uniform(-1.0, 1.0)
    axis = rng.integers(2)
    if kind == "fixed step":
        high = low.copy()
    elif kind == "fixed timing":
        longest = shortest
    elif kind == "fixed offset":
        d_high = d_low.copy()
    elif kind == "crossed offset bounds":
        d_low, d_high = d_high, d_low
    elif kind == "no time left":
        longest = shortest - rng.uniform(0.001, 0.1)
    elif kind == "no step left":
        low, high = high, low
    elif kind == "no growth in one axis":
        growth[axis] = 0.0
    elif kind == "step weights zero":
        step_weight[:] = 0.0
    elif kind == "one offset weight zero":
        offset_weight[axis] = 0.0
    elif kind == "timing weight zero":
        tau_weight = 0.0
    elif kind == "far out":
        growth *= 10.0
    elif kind == "everything at once":
        step_weight, offset_weight = rng.choice((0.0, 1.0, 10.0, 1000.0), (2, 2))
        tau_weight = rng.choice((0.0, 1.0, 10.0))
        for lower, upper in ((low, high), (d_low, d_high)):
            if rng.random() < 0.5:
                upper[axis] = lower[axis] - rng.choice((0.0, 0.1))
        growth[rng.integers(2)] *= rng.choice((0.0, 1.0))
    return {
        "growth": tuple(growth),
        "nominal_step": tuple(rng.uniform(-0.4, 0.4, 2)),
        "nominal_tau": float(np.exp(omega * rng.uniform(0.2, 0.8))),
        "nominal_offset": tuple(rng.uniform(-0.1, 0.1, 2)),
        "step_min": tuple(low),
        "step_max": tuple(high),
        "tau_min": float(np.exp(omega * shortest)),
        "tau_max": float(np.exp(omega * longest)),
        "offset_min": tuple(d_low),
        "offset_max": tuple(d_high),
        "step_weight": tuple(step_weight),
        "tau_weight": float(tau_weight),
        "offset_weight": tuple(offset_weight),
        "offset_penalty": 1e6,
    }


def as_qp(p: dict[str, Any]) -> tuple[NDArray[np.float64], ...]:
    """H, f, A, upper, lower over (X, Y, tau, d_x, d_y, excess above x, y, excess below x, y).

    min 1/2 v H v + f v subject to lower <= (v, A v) <= upper; the two first rows of A are
    equalities. Empty intervals are replaced by what `solve_step` promises for them.
    """
    hessian = np.diag(
        [*p["step_weight"], p["tau_weight"], *p["offset_weight"], *4 * [p["offset_penalty"]]]
    )
    target = np.array([*p["nominal_step"], p["nominal_tau"], *p["nominal_offset"], 0, 0, 0, 0])
    rows = np.zeros((6, 9))
    for i in range(2):
        rows[i, [i, 3 + i, 2]] = 1.0, 1.0, -p["growth"][i]
        rows[2 + i, [3 + i, 5 + i]] = 1.0, -1.0
        rows[4 + i, [3 + i, 7 + i]] = 1.0, 1.0
    low, high = np.array(p["step_min"]), np.array(p["step_max"])
    middle, empty = 0.5 * (low + high), low > high
    low, high = np.where(empty, middle, low), np.where(empty, middle, high)
    free = 6 * [INFINITE]
    lower = [*low, p["tau_min"], *np.negative(free), 0.0, 0.0, -INFINITE, -INFINITE]
    upper = [*high, max(p["tau_min"], p["tau_max"]), *free, 0.0, 0.0, *p["offset_max"]]
    return (
        hessian,
        -hessian @ target,
        rows,
        np.array([*upper, INFINITE, INFINITE]),
        np.array([*lower, *p["offset_min"]]),
    )


PROBLEMS_PER_KIND = 9000  # 13 kinds: 117,000 problems

ROBOT = sf.load_robot("paper-biped")


@pytest.mark.parametrize("kind", KINDS)
def test_against_an_independent_qp_solver(kind: str) -> None:
    """Agreement, optimality, bounded iterations and finite numbers on every kind of problem."""
    rng = np.random.default_rng(20190 + KINDS.index(kind))
    sense = np.zeros(15, np.int32)
    sense[9:11] = 5  # equalities
    worst = worst_residual = 0.0
    for _ in range(PROBLEMS_PER_KIND):
        arguments = random_problem(rng, kind)
        problem = sf.StepProblem(**arguments)
        solution = sf.solve_step(problem)
        mine = np.array([*solution.step, solution.tau, *solution.offset])
        assert np.isfinite(mine).all()
        assert solution.iterations <= MAX_ITERATIONS
        worst_residual = max(worst_residual, sf.kkt_residual(problem, solution).largest)
        if kind in UNIQUE:
            theirs, _, flag, _ = daqp.solve(
                *as_qp(arguments), sense, primal_tol=1e-12, dual_tol=1e-12
            )
            assert flag == 1
            worst = max(worst, np.abs(mine - theirs[:5]).max())
    assert worst_residual <= 1e-9
    assert worst <= 1e-9


@given(
    st.floats(0.0, 0.49),
    st.sampled_from(list(sf.Side)),
    st.sampled_from([(0.5, 0.0), (-0.3, 0.0), (0.0, 0.2), (0.3, -0.15), (0.0, 0.0), (1.5, 0.0)]),
)
def test_the_nominal_state_gives_the_nominal_step(phase, side, velocity) -> None:
    controller = sf.HybridController(ROBOT, velocity)
    gait = controller.gait
    solution = sf.solve_step(controller.step_problem(side, elapsed=phase * gait.step_duration))
    assert solution.step == pytest.approx(gait.step(side), abs=1e-12)
    assert solution.tau == pytest.approx(gait.growth, rel=1e-14)
    assert solution.offset == pytest.approx(gait.dcm_offset(side), abs=1e-12)
    assert solution.status == sf.Status.OK
    assert solution.violation < 1e-12


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.sampled_from([(0.5, 0.0), (0.2, 0.2)]))
def test_the_solution_is_mirrored_with_the_problem(a, b, velocity) -> None:
    mirrored = (velocity[0], -velocity[1])
    right = sf.HybridController(ROBOT, velocity).step_problem(sf.Side.RIGHT, growth=(a, b))
    left = sf.HybridController(ROBOT, mirrored).step_problem(sf.Side.LEFT, growth=(a, -b))
    here, there = sf.solve_step(right), sf.solve_step(left)
    assert here.tau == pytest.approx(there.tau, rel=1e-12)
    assert here.step * (1.0, -1.0) == pytest.approx(there.step, abs=1e-9)
    assert here.offset * (1.0, -1.0) == pytest.approx(there.offset, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_a_problem_is_not_changed_and_has_one_answer(kind: str) -> None:
    problem = sf.StepProblem(**random_problem(np.random.default_rng(7), kind))
    before = problem.array.tobytes()
    first, second = sf.solve_step(problem), sf.solve_step(problem)
    assert problem.array.tobytes() == before
    assert first == second
    with pytest.raises(AttributeError, match="is a value"):
        problem.nominal_tau = 1.0


def test_a_root_on_a_kink_before_a_flat_piece() -> None:
    """Rounding must not send tau along the flat piece to its other end."""
    problem = sf.StepProblem(
        growth=(0.0, -0.07),
        nominal_step=(0.0, -0.09),
        nominal_tau=3.0,
        nominal_offset=(0.0, 0.09),
        step_min=(-0.06, -0.39),
        step_max=(0.06, -0.25),
        tau_min=2.5,
        tau_max=6.0,
        offset_min=(-0.1, -0.07),
        offset_max=(0.1, -0.07),
        step_weight=(1.0, 0.0),
        tau_weight=0.0,
        offset_weight=(1.0, 1.0),
    )
    solution = sf.solve_step(problem)
    assert sf.kkt_residual(problem, solution).largest < 1e-9
    assert solution.tau == pytest.approx(32.0 / 7.0, abs=1e-5)  # but for the soft bound


def test_no_time_left_ends_the_step_now() -> None:
    arguments = random_problem(np.random.default_rng(1), "no time left")
    solution = sf.solve_step(sf.StepProblem(**arguments))
    assert solution.tau == arguments["tau_min"]
    assert sf.Status.NO_TIME_LEFT in solution.status


def test_no_step_left_uses_the_middle() -> None:
    arguments = random_problem(np.random.default_rng(1), "no step left")
    solution = sf.solve_step(sf.StepProblem(**arguments))
    middle = 0.5 * np.add(arguments["step_min"], arguments["step_max"])
    assert solution.step == pytest.approx(middle)
    assert sf.Status.NO_STEP_LEFT in solution.status


@pytest.mark.parametrize(
    ("side", "growth", "axis", "bound"),
    [
        (sf.Side.RIGHT, (0.5, 0.03), 0, 0.1),
        (sf.Side.RIGHT, (0.05, 0.5), 1, 0.05),
        (sf.Side.LEFT, (0.05, -0.5), 1, 0.05),
    ],
)
def test_a_violation_is_reported_with_its_size(side, growth, axis: int, bound: float) -> None:
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    solution = sf.solve_step(controller.step_problem(side, growth=growth))
    assert sf.Status.OFFSET_VIOLATED in solution.status
    assert solution.violation == pytest.approx(abs(solution.offset[axis]) - bound)
    assert solution.violation > 0.1


def test_the_residual_refuses_a_wrong_solution() -> None:
    """The judge must be able to say no."""
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    problem = controller.step_problem(sf.Side.RIGHT, growth=(0.08, 0.03))
    solution = sf.solve_step(problem)
    assert sf.kkt_residual(problem, solution).largest < 1e-12
    later = solution.replace(tau=solution.tau + 1e-3)
    assert sf.kkt_residual(problem, later).primal > 1e-5
    assert sf.kkt_residual(problem, later).stationarity > 1e-5


def test_a_changed_problem_is_checked_like_a_new_one() -> None:
    problem = sf.HybridController(ROBOT, (0.5, 0.0)).step_problem(sf.Side.RIGHT)
    assert problem.replace(tau_max=9.0).tau_max == 9.0
    with pytest.raises(sf.ParameterError, match="`growth` to be a pair of finite numbers"):
        problem.replace(growth=(math.nan, 0.0))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"growth": (math.nan, 0.0)}, "`growth` to be a pair of finite numbers"),
        ({"growth": 0.1}, "`growth` to be a pair"),
        ({"nominal_tau": (1.0, 2.0)}, "`nominal_tau` to be a finite number"),
        ({"tau_max": math.inf}, "`tau_max` to be a finite number"),
        ({"step_weight": (1.0, -1.0)}, "`step_weight` not to be negative"),
        ({"offset_penalty": -1.0}, "`offset_penalty` not to be negative"),
        ({"step_min": ("a", "b")}, "`step_min` to be a pair"),
    ],
)
def test_a_problem_that_makes_no_sense(changes, message: str) -> None:
    arguments = random_problem(np.random.default_rng(1), "plain") | changes
    with pytest.raises(sf.ParameterError, match=message):
        sf.StepProblem(**arguments)

from __future__ import annotations

import math

import daqp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import surefoot as sf
from step_problems import KINDS, UNIQUE, as_qp, random_problem
from surefoot.dcm.step_solver import MAX_ITERATIONS

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


@pytest.mark.parametrize("side", list(sf.Side))
def test_a_lateral_violation_is_reported_too(side: sf.Side) -> None:
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    solution = sf.solve_step(controller.step_problem(side, growth=(0.05, 0.5 * side)))
    assert sf.Status.OFFSET_VIOLATED in solution.status
    assert solution.violation == pytest.approx(abs(solution.offset[1]) - 0.05)


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


def test_a_violation_is_reported_with_its_size() -> None:
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    solution = sf.solve_step(controller.step_problem(sf.Side.RIGHT, growth=(0.5, 0.03)))
    assert sf.Status.OFFSET_VIOLATED in solution.status
    assert solution.violation == pytest.approx(solution.offset[0] - 0.1)
    assert solution.violation > 0.1


def test_the_residual_sees_a_wrong_solution() -> None:
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

"""The programs of online footstep optimisation and of push recovery two steps ahead."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

import surefoot as sf
from surefoot.control.mpc.footstep_optimisation import FootstepOptimisation, value_matrix
from surefoot.control.mpc.horizon import horizon
from surefoot.control.mpc.push_recovery import PushRecoveryMpc

ROBOT = sf.load_robot("paper-biped").with_leg(max_speed=3.0)
VELOCITY = (0.5, 0.0)


@pytest.mark.parametrize("weights", [(0.1, 0.1, 1.0), (2.0, 0.0, 0.3), (0.0, 5.0, 7.0)])
def test_the_value_function_solves_the_riccati_equation(weights) -> None:
    com, velocity, zmp = weights
    a, b = np.array([[0.0, 1.0], [1.0, 0.0]]), np.array([[0.0], [-1.0]])
    general = solve_continuous_are(a, b, np.diag([com, velocity]), [[zmp]])
    assert np.allclose(value_matrix(*weights), general, rtol=1e-9, atol=1e-12)


def _answer(mpc, samples: int) -> np.ndarray:
    """ZMP and first landing that the program answers a deviation of the DCM of 1 m with."""
    ahead = horizon(0.1, mpc.node, samples, mpc.samples_per_step)
    hessian, gain, _, _ = mpc.make_program(ahead)
    solution = np.linalg.solve(hessian, -gain[:, 0])
    return solution[[0, mpc.samples]]


def test_with_the_value_function_a_longer_horizon_says_the_same() -> None:
    """V is the cost of all that comes after the horizon, with ZMPs that change at any time: only
    that they are constant on intervals is left, and V expects no second landing to be moved."""
    fine = {"sample": 0.02, "step_weight": 1e9}
    one = _answer(FootstepOptimisation(ROBOT, VELOCITY, samples=25, **fine), 25)
    two = _answer(FootstepOptimisation(ROBOT, VELOCITY, samples=50, **fine), 50)
    assert one[0] == pytest.approx(two[0], rel=1e-3)
    without = FootstepOptimisation(ROBOT, VELOCITY, samples=5, **fine)
    assert abs(_answer(without, 5)[0] / two[0] - 1.0) < 2e-2


@pytest.mark.parametrize("method", [FootstepOptimisation, PushRecoveryMpc])
def test_landings_answer_what_the_zmp_does_not(method) -> None:
    """A DCM ahead is met by a ZMP ahead and a step ahead; a heavier step moves less."""
    light = method(ROBOT, VELOCITY)
    heavy = method(ROBOT, VELOCITY, step_weight=1e3 * light.step_weight)
    zmp, step = _answer(light, light.samples)
    assert zmp > 0.0
    assert step > _answer(heavy, heavy.samples)[1] > 0.0


def test_they_look_one_and_two_steps_ahead() -> None:
    assert FootstepOptimisation(ROBOT, VELOCITY).steps_ahead == 1
    assert PushRecoveryMpc(ROBOT, VELOCITY).steps_ahead == 2

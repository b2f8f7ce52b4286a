"""The landing problem is solved exactly, whatever the situation; and what its flags say is true."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec import structs
from numpy.typing import NDArray

import landing_reference as reference
import surefoot as sf
from surefoot.compiled import njit, record_entry_point
from surefoot.control.unified.problem import Decision, LandingParameters, Situation
from surefoot.control.unified.solver import TAU_EVALUATIONS, decide_landing
from surefoot.record import new_array

ROBOT = sf.load_robot("paper-biped")
LEGS = (2.0, 3.0, 6.0, math.inf)
STATES = 12_000
AGREEMENT, ROUNDING = 1e-7, 1e-14


@njit
def _solve(landing, situation, decision):
    decide_landing(landing, situation, situation.tau_ref, decision)


SOLVE = record_entry_point(_solve, LandingParameters, Situation, Decision)


def solve_landing(landing: NDArray[np.void], situation: NDArray[np.void]) -> Decision:
    """The decision for one situation; ZMP and margin are not its part."""
    decision = new_array(Decision.DTYPE)
    SOLVE(landing, situation, decision)
    return Decision.of(decision)


def with_leg(speed: float) -> sf.Robot:
    return ROBOT.replace(swing=structs.replace(ROBOT.swing, max_speed=speed))


def test_it_agrees_with_a_general_solver() -> None:
    """12,000 states of a leg without limits, whose tables are concave: landing and tau to 1e-7.

    Or both cost the same to the last bits: where a state is hopeless the costs are 1e10.
    """
    rng = np.random.default_rng(0)
    even, active = 0, 0
    for _ in range(STATES // 100):
        parameters = reference.random_parameters(ROBOT, rng)
        for _ in range(100):
            situation = reference.random_situation(parameters, rng)
            mine = solve_landing(parameters, situation)
            place, tau = reference.solve(parameters, situation)
            if max(*np.abs(mine.step - place), abs(mine.tau - tau)) > AGREEMENT:
                costs = [
                    reference.cost(parameters, situation, *answer)
                    for answer in ((mine.step, mine.tau), (place, tau))
                ]
                assert costs[0] <= costs[1] * (1.0 + ROUNDING)
                even += 1
            active |= int(mine.active)
            assert mine.iterations <= TAU_EVALUATIONS + 2
    assert even <= STATES // 1000
    seen = sf.Limit(active)
    assert sf.Limit.STEP_X in seen
    assert sf.Limit.SHORTEST in seen
    assert sf.Limit.LOST in seen
    assert sf.Limit.LEG_Y not in seen


@pytest.mark.parametrize("speed", LEGS)
def test_nothing_costs_less(speed: float) -> None:
    """Than the decision, of 100,000 landings and times in each of 200 situations of every leg.

    The tables of a slow leg bend up a little; the last part in a thousand of the cost is for that.
    """
    rng = np.random.default_rng(int(10 * min(speed, 10.0)))
    active = 0
    for _ in range(20):
        parameters = reference.random_parameters(with_leg(speed), rng)
        for _ in range(10):
            situation = reference.random_situation(parameters, rng)
            mine = solve_landing(parameters, situation)
            found = reference.cost(parameters, situation, mine.step, mine.tau)
            assert found <= reference.least_cost(parameters, situation) * (1.0 + 1e-3) + 1e-9
            active |= int(mine.active)
    assert (sf.Limit.LEG_Y in sf.Limit(active)) == math.isfinite(speed)

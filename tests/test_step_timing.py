"""Step location and timing alone: the best decision in every cycle, and viable offsets."""

from __future__ import annotations

import math

import pytest

import surefoot as sf
from surefoot.robot.robot import Swing

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
LARGE = sf.Push(1.1, 0.2, (900.0, 0.0))


@pytest.fixture(scope="module")
def controller() -> sf.StepTiming:
    return sf.StepTiming(ROBOT, (0.5, 0.0))


def decision(rollout: sf.Rollout, controller: sf.StepTiming, k: int) -> sf.StepSolution:
    """What the step problem of cycle k says, solved from outside the cycle."""
    side, elapsed = sf.Side(rollout.support_side[k]), rollout.observations["elapsed"][k]
    away = rollout.dcm[k] - rollout.support_foot[k]
    a, b = away * math.exp(-ROBOT.omega * elapsed)
    problem = controller.step_problem(side, (a, b), elapsed)
    solution = sf.solve_step(problem)
    assert sf.kkt_residual(problem, solution).largest < 1e-6
    return solution


def test_every_cycle_takes_the_best_decision(controller: sf.StepTiming) -> None:
    rollout = sf.simulate(controller, 3.0, [sf.Push(1.1, 0.2, (300.0, 120.0))])
    for k in range(0, len(rollout.time), 7):
        best = decision(rollout, controller, k)
        command = rollout.commands[k]
        step = command["step_location"] - rollout.support_foot[k]
        assert step == pytest.approx(best.step, abs=1e-9)
        assert command["step_duration"] == pytest.approx(math.log(best.tau) / ROBOT.omega, abs=1e-9)
        assert command["dcm_offset"] == pytest.approx(best.offset, abs=1e-9)


def test_a_push_that_no_step_in_its_box_answers_is_answered_by_landing_early(controller) -> None:
    durations = [
        sf.simulate(controller, 2.0, [sf.Push(1.1, 0.2, force)]).footsteps[2].duration
        for force in ((0.0, -30.0), (200.0, 0.0), (-500.0, 0.0), (0.0, 200.0))
    ]
    assert durations[0] == pytest.approx(controller.gait.step_duration, abs=1e-3)
    assert max(durations[1:]) < controller.gait.step_duration - 0.05


@pytest.mark.parametrize("side", sf.Side)
def test_the_bounds_on_the_offset_are_those_of_viability(controller, side: sf.Side) -> None:
    viable = sf.viable_offsets(ROBOT, side)
    problem = controller.step_problem(side)
    assert tuple(problem.offset_min) == viable.lower
    assert tuple(problem.offset_max) == viable.upper
    assert viable.margin(controller.gait.dcm_offset(side)) > 0.05
    # They are mirror images, and wider than the soft bounds of the hybrid.
    other = controller.step_problem(side.other)
    assert problem.offset_min[1] == pytest.approx(-other.offset_max[1], abs=1e-12)
    hybrid = sf.HybridController(ROBOT, (0.5, 0.0)).step_problem(side)
    assert (problem.offset_min < hybrid.offset_min).all()
    assert (problem.offset_max > hybrid.offset_max).all()


def test_an_offset_is_flagged_where_it_cannot_be_saved_and_not_before(controller) -> None:
    saved = sf.simulate(controller, 6.0, [LARGE])
    assert saved.outcome is sf.Outcome.RECOVERED
    after_push = saved.time > LARGE.end
    flagged = saved.commands["status"] & int(sf.Status.OFFSET_VIOLATED) != 0
    assert max(step.dcm_offset[0] for step in saved.footsteps) > 0.2  # far beyond Table 2's 0.1
    assert not flagged[after_push].any()
    lost = sf.simulate(controller, 6.0, [sf.Push(1.1, 0.2, (1200.0, 0.0))])
    assert lost.outcome is sf.Outcome.FELL
    assert (lost.commands["status"][-10:] & int(sf.Status.OFFSET_VIOLATED) != 0).all()


def test_a_dominant_weight_on_the_offset_saves_a_slow_leg() -> None:
    slow = ROBOT.replace(swing=Swing(max_speed=3.0))
    strong, weak = (
        sf.smallest_failing_push(sf.StepTiming(slow, (0.5, 0.0), offset_weight=weight), (0.0, -1.0))
        for weight in ((1e5, 1e5), (1000.0, 1000.0))
    )
    assert strong.impulse > 1.15 * weak.impulse


def test_the_weights_are_those_that_were_given() -> None:
    weights = {
        "step_weight": (2.0, 3.0),
        "tau_weight": 4.0,
        "offset_weight": (5.0, 6.0),
        "offset_penalty": 7.0,
    }
    problem = sf.StepTiming(ROBOT, (0.5, 0.0), **weights).step_problem(sf.Side.LEFT)
    for name, weight in weights.items():
        assert getattr(problem, name) == pytest.approx(weight), name

"""The nonlinear program over the next steps, and the controller that walks with it."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from surefoot.checks import optional_module
from surefoot.conformance import closed_loop
from surefoot.control import step_sequence
from surefoot.control.step_sequence import SequenceWeights, StepSequence
from surefoot.robot.robot import Swing

ROBOT = sf.load_robot("paper-biped")
SLOW_LEG = ROBOT.replace(swing=Swing(max_speed=3.0))
PUSH = sf.Push(1.1, 0.2, (240.0, 60.0))
"""Four times as much as tracking survives."""

ONE_STEP = SequenceWeights((1.0, 1.0), 1.0, (1.0, 1.0), (20000.0, 1000.0), (0.0, 0.0), 1e6)
"""The weights of the step problem, for a horizon of one."""

MORE_STEPS = SequenceWeights((1.0, 1.0), 1e-2, (1.0, 1.0), (2e4, 2e4), (1e3, 1e3), 1e6)
"""The controller's own weights."""


def random_moments(robot: sf.Robot, gait: sf.NominalGait, count: int):
    """Side, time since touchdown, DCM and swing foot relative to the support foot."""
    rng = np.random.default_rng(5)
    for _ in range(count):
        side = sf.Side(int(rng.choice([-1, 1])))
        elapsed = float(rng.uniform(0.0, 0.6))
        dcm = np.multiply(gait.start_offset(side), math.exp(gait.omega * elapsed))
        dcm += rng.normal(0.0, 0.08, 2)
        foot = np.multiply(gait.step(side), 2.0 * elapsed / gait.step_duration - 1.0)
        yield side, elapsed, (float(dcm[0]), float(dcm[1])), (float(foot[0]), float(foot[1]))


def cost(problem: sf.StepProblem, step, tau: float, offset) -> float:
    """What the step problem minimises."""
    record = problem.array[0]
    outside = np.maximum(record["offset_min"] - offset, 0.0)
    outside += np.maximum(offset - record["offset_max"], 0.0)
    return 0.5 * float(
        np.sum(record["step_weight"] * (step - record["nominal_step"]) ** 2)
        + record["tau_weight"] * (tau - record["nominal_tau"]) ** 2
        + np.sum(record["offset_weight"] * (offset - record["nominal_offset"]) ** 2)
        + record["offset_penalty"] * np.sum(outside**2)
    )


def test_one_step_of_a_point_foot_is_the_exact_solution() -> None:
    """Two independent solvers, one problem: the closed form and the interior point agree."""
    gait = sf.nominal_gait(ROBOT, (0.4, 0.1))
    sequence = StepSequence(ROBOT, gait, 1, ONE_STEP, 0.0, 200)
    hybrid = sf.HybridController(ROBOT, (0.4, 0.1))
    for side, elapsed, dcm, foot in random_moments(ROBOT, gait, 100):
        viable = sf.viable_offsets(ROBOT, side)
        growth = np.multiply(dcm, math.exp(-gait.omega * elapsed))
        problem = hybrid.step_problem(side, (growth[0], growth[1]), elapsed).replace(
            offset_min=viable.lower,
            offset_max=viable.upper,
            offset_weight=ONE_STEP.offset,
            tau_weight=ONE_STEP.tau,
        )
        exact = sf.solve_step(problem)
        nominal = sequence.nominal(side, elapsed)
        steps, converged, outside = sequence.solve(side, elapsed, dcm, foot, nominal)
        assert converged
        step, offset = (steps[name][0, 0] * (1, side) for name in ("step", "offset"))
        tau = math.exp(gait.omega * (elapsed + steps["duration"][0, 0]))
        best = cost(problem, exact.step, exact.tau, exact.offset)
        assert cost(problem, step, tau, offset) == pytest.approx(best, abs=1e-6, rel=1e-6)
        assert step == pytest.approx(exact.step, abs=1e-5)
        assert tau == pytest.approx(exact.tau, abs=1e-4)
        assert outside == pytest.approx(exact.violation, abs=1e-6)


@pytest.mark.parametrize("horizon", [1, 2, 3])
def test_the_steps_keep_their_limits_and_the_flow(horizon: int) -> None:
    gait = sf.nominal_gait(SLOW_LEG, (0.4, 0.1))
    sequence = StepSequence(SLOW_LEG, gait, horizon, MORE_STEPS, 1.0, 60)
    low, high = SLOW_LEG.gait.step_box(sf.Side.RIGHT, SLOW_LEG.hip)
    shortest, longest = SLOW_LEG.gait.step_duration
    late = 0
    for side, elapsed, dcm, foot in random_moments(SLOW_LEG, gait, 40):
        nominal = sequence.nominal(side, elapsed)
        steps, converged, _ = sequence.solve(side, elapsed, dcm, foot, nominal)
        assert converged
        flip = np.array((1.0, -1.0))
        offset, came_from = np.array(dcm) * (1, side), np.array(foot) * (1, side)
        for k in range(horizon):
            time, step, zmp = (steps[name][0, k] for name in ("duration", "step", "zmp"))
            total = time + (elapsed if k == 0 else 0.0)
            assert max(shortest, elapsed if k == 0 else 0.0) - 1e-9 <= total <= longest + 1e-9
            assert (step >= np.array(low) - 1e-9).all()
            assert (step <= np.array(high) + 1e-9).all()
            assert (np.abs(zmp) <= np.array(SLOW_LEG.foot.half) + 1e-9).all()
            offset = zmp + (offset - zmp) * math.exp(gait.omega * time) - step
            assert steps["offset"][0, k] == pytest.approx(offset, abs=1e-6)
            late += np.abs(step - came_from).max() > 3.0 * time + 1e-6
            offset, came_from = steps["offset"][0, k] * flip, -step * flip
    assert late == 0


def test_on_the_nominal_gait_the_nominal_steps_are_the_answer() -> None:
    gait = sf.nominal_gait(SLOW_LEG, (0.3, -0.15))
    sequence = StepSequence(SLOW_LEG, gait, 3, MORE_STEPS, 1.0, 60)
    for side in sf.Side:
        back = -np.array(gait.step(side.other))
        nominal = sequence.nominal(side, 0.0)
        dcm = gait.start_offset(side)
        steps, converged, outside = sequence.solve(side, 0.0, dcm, (back[0], back[1]), nominal)
        assert converged
        assert outside < 1e-9
        for name in ("duration", "step", "zmp", "offset"):
            assert steps[name] == pytest.approx(nominal[name], abs=1e-6), name


def test_a_problem_and_its_mirror_image_have_the_same_bits() -> None:
    gaits = [sf.nominal_gait(SLOW_LEG, (0.3, v_y)) for v_y in (-0.1, 0.1)]
    here, there = (StepSequence(SLOW_LEG, gait, 2, MORE_STEPS, 1.0, 60) for gait in gaits)
    for side, elapsed, dcm, foot in random_moments(SLOW_LEG, gaits[0], 10):
        one = here.solve(side, elapsed, dcm, foot, here.nominal(side, elapsed))
        mirrored = (dcm[0], -dcm[1]), (foot[0], -foot[1])
        other = there.solve(side.other, elapsed, *mirrored, there.nominal(side.other, elapsed))
        assert one[0].tobytes() == other[0].tobytes()


def adapting_moment(controller: sf.TimingNlp, cycles: int = 1):
    """State and observation some cycles after the first decision."""
    observation = controller.first_observation()
    observation = observation.replace(dcm=np.add(observation.dcm, (0.06, 0.02)))
    *walk, last = closed_loop(controller, observation, cycles + 1)
    assert all(cycle.command.mode is sf.Mode.ADAPTING for cycle in walk)
    return walk[-1].state, last.observation


def test_between_two_decisions_landing_and_time_stand() -> None:
    controller = sf.TimingNlp(ROBOT, (0.5, 0.0), solve_period=0.01)
    state, observation = adapting_moment(controller, 1)
    decided_at = []
    # A disturbance changes the best landing; it must wait for the next decision.
    observation = observation.replace(dcm=np.add(observation.dcm, (0.0, 0.03)))
    first, _ = controller.step(state, observation)
    for k in range(1, 22):
        seen = observation.replace(elapsed=0.001 * k)
        command, state = controller.step(state, seen)
        if k < 10:
            assert command.step_location == pytest.approx(first.step_location, abs=0.0)
            assert command.step_duration == first.step_duration
        decided_at.append(float(state["decided_at"][0]))
    assert command.step_location != pytest.approx(first.step_location, abs=1e-4)
    assert sorted(set(decided_at)) == pytest.approx([0.0, 0.01, 0.02], abs=1e-9)


def test_the_warm_start_is_in_the_state_and_saves_iterations() -> None:
    controller = sf.TimingNlp(ROBOT, (0.5, 0.0), solve_period=0.0)
    state, observation = adapting_moment(controller, 5)
    assert state["known"][0] == 1
    command, _ = controller.step(state, observation)
    # Another controller knows nothing but the state: its answer is the same to the last bit.
    other, _ = sf.TimingNlp(ROBOT, (0.5, 0.0), solve_period=0.0).step(state, observation)
    assert other == command
    # Whoever has never decided starts from the nominal steps, and comes to the same answer.
    cold = state.copy()
    cold["known"], cold["steps"] = 0, np.zeros(1, step_sequence.PlannedSteps.DTYPE)
    from_nominal, _ = controller.step(cold, observation)
    assert from_nominal != command
    assert from_nominal.step_location == pytest.approx(command.step_location, abs=1e-5)


def test_without_an_answer_the_last_plan_goes_on_and_the_status_says_so() -> None:
    able = sf.TimingNlp(ROBOT, (0.5, 0.0), solve_period=0.0)
    hasty = replace(able, max_iterations=1)
    state, observation = adapting_moment(able, 3)
    last, _ = able.step(state, observation)
    command, next_state = hasty.step(state, observation)
    assert command.status == sf.Status.NOT_CONVERGED
    # The state holds the decision of the cycle before, and its landing and time stand.
    assert command.step_duration == pytest.approx(float(state["landing_time"][0]), abs=1e-12)
    assert command.step_location == pytest.approx(last.step_location, abs=1e-3)
    for name in command.DTYPE.names or ():
        assert np.isfinite(command.array[name]).all(), name
    # The next one that finds an answer says nothing of it any more.
    again, _ = able.step(next_state, observation)
    assert again.status == sf.Status.OK


def test_without_any_answer_the_steps_are_nominal_and_the_status_says_so() -> None:
    controller = sf.TimingNlp(ROBOT, (0.5, 0.0), max_iterations=1)
    begin = controller.first_observation()
    pushed = begin.replace(dcm=np.add(begin.dcm, (0.06, 0.0)))
    command, _ = controller.step(controller.start(begin), pushed)
    assert command.mode is sf.Mode.ADAPTING
    assert command.status == sf.Status.NOT_CONVERGED
    step = controller.gait.step(sf.Side.RIGHT)
    assert command.step_location - begin.support_foot == pytest.approx(step, abs=1e-12)
    assert command.step_duration == pytest.approx(controller.gait.step_duration, abs=1e-12)


@pytest.mark.parametrize("dcm", [(1e8, 0.0), (3.0, -3.0), (-0.8, 0.8)])
def test_a_hopeless_dcm_gets_a_finite_command_with_a_flag(dcm) -> None:
    controller = sf.TimingNlp(SLOW_LEG, (0.5, 0.0))
    hopeless = controller.first_observation().replace(dcm=dcm)
    held, state = controller.step(controller.start(hopeless), hopeless)
    # A robot that has fallen is held in the first cycle, and decided on in the next.
    command, _ = controller.step(state, hopeless)
    for name in command.DTYPE.names or ():
        assert np.isfinite(held.array[name]).all(), name
        assert np.isfinite(command.array[name]).all(), name
    assert command.status & (sf.Status.OFFSET_VIOLATED | sf.Status.NOT_CONVERGED)


@pytest.mark.parametrize("robot", [ROBOT, SLOW_LEG], ids=["unlimited", "slow-leg"])
def test_it_recovers_from_more_than_tracking_does_and_settles(robot: sf.Robot) -> None:
    rollout = sf.simulate(sf.TimingNlp(robot, (0.5, 0.0)), 5.0, [PUSH])
    assert rollout.outcome is sf.Outcome.RECOVERED
    assert sf.simulate(sf.DcmTracking(robot, (0.5, 0.0)), 5.0, [PUSH]).outcome is sf.Outcome.FELL
    # Back to tracking in the third step after the push at the latest.
    assert not rollout.adapting[rollout.time > 3.0].any()


def test_without_casadi_the_message_says_how_to_get_it(monkeypatch) -> None:
    step_sequence._build.cache_clear()
    # None in sys.modules is how Python itself marks a module that cannot be imported.
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(sf.MissingExtraError, match=r'nonlinear step timing.*"surefoot\[nlp\]"'):
        sf.TimingNlp(ROBOT, (0.5, 0.0))


def test_a_mistake_inside_an_optional_module_is_not_hidden(tmp_path, monkeypatch) -> None:
    (tmp_path / "optional_thing.py").write_text("import not_there_at_all\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(ModuleNotFoundError, match="not_there_at_all") as caught:
        optional_module("optional_thing", "a test", "test")
    assert not isinstance(caught.value, sf.MissingExtraError)
    assert optional_module("math", "a test", "test") is math


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"horizon": 0}, "`horizon` as a whole number from 1 to 5; got 0"),
        ({"horizon": 2.0}, "`horizon` as a whole number"),
        ({"max_iterations": 0}, "`max_iterations` as a whole number"),
        ({"zmp_share": 1.5}, "`zmp_share` of at most 1; got 1.5"),
    ],
)
def test_parameters_of_the_program_that_make_no_sense(arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        sf.TimingNlp(ROBOT, (0.5, 0.0), **arguments)

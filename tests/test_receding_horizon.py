"""Linear MPC: the programs say what they mean, their solutions are optimal, and they walk."""

from __future__ import annotations

import math
from importlib import import_module

import numpy as np
import pytest
import quadprog

import surefoot as sf
from surefoot.control.mpc import horizon as mpc_horizon
from surefoot.control.mpc.cycle import SOLVE, MpcState, Work, prepare
from surefoot.control.mpc.horizon import (
    com_response,
    horizon,
    lean_response,
    placed_feet,
    velocity_response,
)
from surefoot.dcm.pendulum import com_flow, trunk_flow

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
OMEGA = ROBOT.omega
KINDS = {
    "linear-mpc": sf.LinearMpc,
    "foot-placement-mpc": sf.FootPlacementMpc,
    "ankle-hip-step-mpc": sf.AnkleHipStepMpc,
}
AXES = {"forward": (1.0, 0.0), "back": (-1.0, 0.0), "outward": (0.0, 1.0), "inward": (0.0, -1.0)}


@pytest.fixture(params=KINDS)
def kind(request):
    return KINDS[request.param]


@pytest.mark.parametrize("elapsed", [0.0, 0.005, 0.1, 0.33, 0.495])
def test_every_touchdown_is_a_node(elapsed: float) -> None:
    seen = horizon(elapsed, 0.1, 16, 5)
    ends = elapsed + np.cumsum(seen.lengths)
    assert ends / 0.1 == pytest.approx(np.round(ends / 0.1), abs=1e-9)
    assert (seen.lengths > 0.0).all()
    starts = ends - seen.lengths
    assert seen.feet.tolist() == np.floor(starts / 0.5 + 1e-9).astype(int).tolist()


def test_the_responses_are_the_flow() -> None:
    rng = np.random.default_rng(1)
    lengths, zmp, dcm = rng.uniform(0.01, 0.2, 7), rng.normal(size=7), rng.normal()
    from_dcm, from_zmp = com_response(OMEGA, lengths)
    com, velocity, walked = 0.5 * dcm, 0.5 * OMEGA * dcm, []
    for length, pivot in zip(lengths, zmp, strict=True):
        com, velocity = com_flow(com, velocity, pivot, OMEGA, length)
        walked.append((com, velocity))
    assert pytest.approx(np.array(walked), abs=1e-12) == (from_dcm * dcm + from_zmp @ zmp).T
    from_dcm, from_zmp = velocity_response(OMEGA, lengths)
    velocities = [velocity for _, velocity in walked]
    assert from_dcm * dcm + from_zmp @ zmp == pytest.approx(velocities, abs=1e-12)


def test_the_lean_response_is_the_flow() -> None:
    rng = np.random.default_rng(2)
    lengths, torque, state = rng.uniform(0.01, 0.2, 7), rng.normal(size=7), rng.normal(size=2)
    from_state, from_torque = lean_response(4.4, lengths)
    lean, rate, walked = state[0], state[1], []
    for length, pull in zip(lengths, torque, strict=True):
        lean, rate, _, _ = trunk_flow(lean, rate, pull, 4.4, 1e6, length)
        walked.append((lean, rate))
    assert from_state @ state + from_torque @ torque == pytest.approx(np.array(walked), abs=1e-12)


def random_moment(controller, rng):
    """A pushed robot somewhere in a step, with the program that is due there."""
    cycle = int(rng.integers(0, controller.programs.gain.shape[0]))
    elapsed = cycle * controller.period
    begin = controller.first_observation()
    plan = np.array(controller.gait.start_offset(sf.Side.RIGHT)) * math.exp(OMEGA * elapsed)
    observation = begin.replace(
        elapsed=elapsed,
        com=begin.support_foot + plan + rng.normal(scale=0.05, size=2),
        com_velocity=rng.normal(scale=0.3, size=2),
    )
    observation = observation.replace(
        dcm=observation.com + observation.com_velocity / OMEGA,
        trunk_lean=rng.normal(scale=0.1, size=2),
        trunk_lean_velocity=rng.normal(scale=0.3, size=2),
    )
    # It begins here: no robot gets there from the gait in one cycle.
    state, next_state = controller.start(observation), np.zeros(1, MpcState.DTYPE)
    work = Work.of(controller.programs)
    decided = prepare(
        controller.parameters, controller.programs, state, observation.array, next_state, work
    )
    assert decided == (SOLVE, cycle)
    return cycle, work


def walked_cost(controller, cycle: int, deviation, unknowns) -> float:
    """The cost of a choice, by walking it with the flow of the pendulum, weight by weight."""
    seen, node = controller.horizons()[cycle], controller.node
    free = getattr(controller, "step_weight", None)
    steps = 0 if free is None else controller.steps_ahead
    zmp, moved = unknowns[: controller.samples], unknowns[controller.samples :][:steps]
    shift = unknowns[controller.samples + steps :]
    feet = placed_feet(seen.feet, steps) @ moved
    com, velocity = 0.5 * deviation[0], 0.5 * OMEGA * deviation[0]
    lean, rate = deviation[1:3] if len(deviation) == 4 else (0.0, 0.0)
    # A push that goes on for a while acts like a ZMP further back.
    push = deviation[-1] if len(deviation) > 1 else 0.0
    lasting, begins = getattr(controller, "push_horizon", 0.0), np.cumsum(seen.lengths)
    weight, cost = ROBOT.mass * ROBOT.gravity, 0.0
    for i, length in enumerate(seen.lengths):
        share = length / node
        pivot = zmp[i] + feet[i] + (shift[i] if len(shift) else 0.0)
        pivot -= push * min(max((lasting - begins[i] + length) / length, 0.0), 1.0)
        com, velocity = com_flow(com, velocity, pivot, OMEGA, length)
        cost += 0.5 * share * controller.velocity_weight * velocity**2
        cost += 0.5 * share * controller.zmp_weight * zmp[i] ** 2
        if len(shift):
            lean, rate, _, _ = trunk_flow(lean, rate, weight * shift[i], 4.4, 1e6, length)
            cost += 0.5 * share * controller.torque_weight * shift[i] ** 2
            cost += 0.5 * share * controller.lean_weight * lean**2
            cost += 0.5 * share * controller.lean_rate_weight * rate**2
    return cost + (0.5 * free * float(moved @ moved) if steps else 0.0)


def test_the_program_is_the_cost_of_the_walk(kind) -> None:
    """Its quadratic form and a walk through the horizon differ by a constant only."""
    rng = np.random.default_rng(3)
    controller = kind(ROBOT, (0.5, 0.0))
    for _ in range(5):
        cycle, (deviation, gradient, _, _) = random_moment(controller, rng)
        if deviation.shape[1] > 1:
            # It has seen nothing before, so no push either.
            assert (deviation[:, -1] == 0.0).all()
            deviation[:, -1] = rng.normal(scale=0.05, size=2)
            gradient += np.outer(deviation[:, -1], controller.programs.gain[cycle, :, -1])
        for axis in range(2):
            nothing = np.zeros(gradient.shape[1])
            base = walked_cost(controller, cycle, deviation[axis], nothing)
            choice = rng.normal(scale=0.05, size=gradient.shape[1])
            quadratic = 0.5 * choice @ controller.programs.hessian[cycle] @ choice
            said = quadratic + gradient[axis] @ choice
            walked = walked_cost(controller, cycle, deviation[axis], choice) - base
            assert said == pytest.approx(walked, rel=1e-6, abs=1e-9)


def test_the_solution_agrees_with_another_solver(kind) -> None:
    """DAQP in the controller, quadprog here, on programs with many active bounds."""
    rng = np.random.default_rng(4)
    controller, active = kind(ROBOT, (0.5, 0.0)), 0
    solve = import_module("daqp").solve
    for _ in range(20):
        cycle, (_, gradient, lower, upper) = random_moment(controller, rng)
        hessian, rows = controller.programs.hessian[cycle], controller.programs.rows[cycle]
        for axis in range(2):
            mine, _, flag, _ = solve(
                hessian, gradient[axis], rows, upper[axis], lower[axis],
                np.zeros(len(upper[axis]), np.int32),
            )  # fmt: skip
            if flag != 1:
                continue  # a lean that nothing keeps from its stop
            sides = np.vstack([np.eye(len(hessian)), rows])
            theirs = quadprog.solve_qp(
                hessian, -gradient[axis], np.hstack([sides.T, -sides.T]),
                np.concatenate([lower[axis], -upper[axis]]),
            )[0]  # fmt: skip
            assert mine == pytest.approx(theirs, abs=1e-6)
            active += int((np.abs(mine - upper[axis][: len(mine)]) < 1e-9).sum())
    assert active > 20


def pushed(controller, impulse: float, direction=(1.0, 0.0)) -> sf.Rollout:
    force = (direction[0] * impulse / 0.2, direction[1] * impulse / 0.2)
    return sf.simulate(controller, 4.0, [sf.Push(1.1, 0.2, force)])


def test_a_landing_is_within_reach_of_the_leg() -> None:
    """With a slow leg the program itself does not ask for more than the foot can do per axis."""
    slow = ROBOT.replace(swing=sf.Swing(max_speed=2.0))
    controller = sf.FootPlacementMpc(slow, (0.5, 0.0))
    rollout = sf.simulate(controller, 3.0, [sf.Push(1.4, 0.05, (900.0, 0.0))])
    asked = rollout.commands["step_location"] - rollout.observations["swing_foot"][:, :2]
    left = rollout.commands["step_duration"] - rollout.observations["elapsed"]
    assert (np.abs(asked) <= 2.0 * left[:, None] + 1e-9).all()
    free = sf.simulate(
        sf.FootPlacementMpc(ROBOT, (0.5, 0.0)), 3.0, [sf.Push(1.4, 0.05, (900.0, 0.0))]
    )
    assert free.footsteps[2].step[0] > rollout.footsteps[2].step[0] + 0.01


PROTOTYPE = {
    "linear-mpc": (20.0, 23.0, 10.0, 13.0),
    "foot-placement-mpc": (58.0, 92.0, 47.8, 22.0),
    "ankle-hip-step-mpc": (58.0, 92.0, 47.8, 22.0),
}
"""Smallest failing impulses of other implementations, forward, back, outward, inward [N s]; the
57 N s outward of foot placement is more than fixed timing allows in this step box, see
`test_what_fixed_timing_allows`."""


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("direction", AXES)
def test_it_is_at_its_best(name: str, direction: str) -> None:
    """At least nine tenths of what others reach with the method."""
    controller = KINDS[name](ROBOT, (0.5, 0.0))
    least = 0.9 * PROTOTYPE[name][list(AXES).index(direction)]
    assert pushed(controller, least, AXES[direction]).outcome is sf.Outcome.RECOVERED
    half = pushed(controller, 0.5 * least, AXES[direction])
    assert half.outcome is sf.Outcome.RECOVERED


def test_what_fixed_timing_allows() -> None:
    """With every step of 0.5 s, the theoretical limit towards the swing foot is 47.8 N s."""
    growth, left = math.exp(OMEGA * 0.5), math.exp(-OMEGA * 0.4)
    narrow, wide = 0.0, 0.5
    least = (growth * narrow - wide) / (growth**2 - 1.0)
    offset = 0.2 / (1.0 + growth) * math.exp(OMEGA * 0.1)
    per_offset = 0.2 * 70.0 * OMEGA**2 / (1.0 - math.exp(-OMEGA * 0.2))
    limit = per_offset * (left * (wide - least) - offset + 0.055)
    assert limit == pytest.approx(47.8, abs=0.1)
    controller = sf.FootPlacementMpc(ROBOT, (0.5, 0.0))
    assert pushed(controller, limit - 2.0, (0.0, 1.0)).outcome is sf.Outcome.RECOVERED
    assert pushed(controller, limit + 1.0, (0.0, 1.0)).outcome is sf.Outcome.FELL


LATE = {"forward": 103.0, "back": 200.0, "outward": 83.0, "inward": 78.0}
"""Survived of a push of 0.2 s that begins 0.1 s before a touchdown [N s]; forward and outward by an
independent version of the method, the others three quarters of the limit of fixed timing."""


@pytest.mark.parametrize("direction", AXES)
def test_a_push_late_in_the_step_is_expected_to_go_on(direction: str) -> None:
    force = np.array(AXES[direction]) * LATE[direction] / 0.2
    push = [sf.Push(1.4, 0.2, (float(force[0]), float(force[1])))]
    controller = sf.FootPlacementMpc(ROBOT, (0.5, 0.0))
    assert sf.simulate(controller, 6.0, push).outcome is sf.Outcome.RECOVERED
    published = sf.FootPlacementMpc(ROBOT, (0.5, 0.0), push_horizon=0.0)
    assert sf.simulate(published, 6.0, push).outcome is sf.Outcome.FELL


@pytest.mark.parametrize("direction", AXES)
@pytest.mark.parametrize("duration", [0.05, 0.1])
def test_a_push_that_ends_before_it_is_expected_to_costs_nothing(direction, duration) -> None:
    """What was decided for a push that goes on can be taken back."""
    for share in (0.3, 0.6, 0.85):
        impulse = (
            share * {"forward": 88.0, "back": 200.0, "outward": 80.0, "inward": 64.0}[direction]
        )
        force = np.array(AXES[direction]) * impulse / duration
        push = [sf.Push(1.4, duration, (float(force[0]), float(force[1])))]
        rollout = sf.simulate(sf.FootPlacementMpc(ROBOT, (0.5, 0.0)), 6.0, push)
        assert rollout.outcome is sf.Outcome.RECOVERED, share


def test_hips_survive_what_feet_alone_do_not() -> None:
    feet, hips = sf.FootPlacementMpc(ROBOT, (0.5, 0.0)), sf.AnkleHipStepMpc(ROBOT, (0.5, 0.0))
    assert pushed(feet, 61.0).outcome is sf.Outcome.FELL
    rollout = pushed(hips, 61.0)
    assert rollout.outcome is sf.Outcome.RECOVERED
    lean, torque = rollout.observations["trunk_lean"], rollout.commands["hip_torque"]
    assert 0.2 < np.abs(lean).max() <= 0.5
    assert 50.0 < np.abs(torque).max() <= 100.0 + 1e-6
    assert np.abs(lean[-1]).max() < 0.01  # what was borrowed is given back


def test_solved_less_often_it_reacts_later() -> None:
    often = sf.FootPlacementMpc(ROBOT, (0.5, 0.0))
    seldom = sf.FootPlacementMpc(ROBOT, (0.5, 0.0), solve_period=0.1)
    push = sf.Push(1.13, 0.05, (400.0, 0.0))
    reacted = []
    for controller in (often, seldom):
        rollout = sf.simulate(controller, 2.0, [push])
        off = np.hypot(*(rollout.zmp - rollout.support_foot).T) > 1e-6
        reacted.append(rollout.time[off][0])
    assert reacted == pytest.approx([1.135, 1.2], abs=1e-6)


def test_a_solver_that_fails_is_flagged(kind, monkeypatch) -> None:
    """The robot stands on the centre of its foot and steps as planned; nothing raises."""
    controller = kind(ROBOT, (0.5, 0.0))
    monkeypatch.setattr(mpc_horizon, "_solver", lambda: lambda *_: (None, 0.0, -1, {}))
    observation = controller.first_observation()
    command, _ = controller.step(controller.start(observation), observation)
    assert sf.Status.NOT_CONVERGED in command.status
    assert command.zmp == pytest.approx(observation.support_foot)
    planned = observation.support_foot + controller.gait.step(sf.Side.RIGHT)
    assert command.step_location == pytest.approx(planned, abs=1e-12)


def test_without_its_solver_the_message_names_the_installation(kind, monkeypatch) -> None:
    def missing(name: str):
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr("surefoot.checks.import_module", missing)
    mpc_horizon._solver.cache_clear()
    try:
        with pytest.raises(sf.MissingExtraError, match=r'pip install "surefoot\[mpc\]"'):
            kind(ROBOT, (0.5, 0.0))
    finally:
        mpc_horizon._solver.cache_clear()


def test_hips_need_a_trunk() -> None:
    with pytest.raises(sf.RobotError, match=r"a robot with a trunk .* add a table \[trunk\]"):
        sf.AnkleHipStepMpc(ROBOT.replace(trunk=None), (0.5, 0.0))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"samples": 0}, "`samples` as a whole number of at least 1"),
        ({"samples": 1.5}, "`samples` as a whole number"),
        ({"solve_period": 0.001}, r"`solve_period` of at least 0.005 \[s\]"),
    ],
)
def test_parameters_that_make_no_sense(kind, arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        kind(ROBOT, (0.5, 0.0), **arguments)


def test_a_new_velocity_takes_the_programs_over() -> None:
    """They depend on the duration of a step; a body changes its velocity at every touchdown."""
    mpc = sf.FootPlacementMpc(ROBOT, (0.5, 0.0), step_duration=0.5)
    assert mpc.with_velocity((0.48, 0.01)).programs is mpc.programs
    for other in (
        sf.FootPlacementMpc(ROBOT, (0.5, 0.0), step_duration=0.4),
        sf.FootPlacementMpc(ROBOT, (0.5, 0.0), step_duration=0.5, step_weight=2e-3),
    ):
        assert not np.array_equal(other.programs.hessian, mpc.programs.hessian)

"""The conformance suite of simulators, run on the LIPM."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.dcm.pendulum import com_flow, dcm_flow, pushed_pivot
from surefoot.dcm.viability import fall_distance
from surefoot.robot.robot import Swing

ROBOT = sf.load_robot("paper-biped")
GAIT = sf.nominal_gait(ROBOT, (0.5, 0.0))


def standing_command(**changes) -> sf.Command:
    """Stand on the right foot's centre; land where the nominal gait lands."""
    controller = sf.DcmTracking(ROBOT, (0.5, 0.0))
    observation = GAIT.observation(sf.Side.RIGHT)
    command, _ = controller.step(controller.start(observation), observation)
    return command.replace(**changes)


def test_a_cycle_is_the_exact_flow() -> None:
    simulator = sf.LipmSimulator(ROBOT, period=0.003)
    begin = GAIT.observation(sf.Side.RIGHT)
    command = standing_command(zmp=(0.02, -0.12))
    after, _ = simulator.step(simulator.start(begin), command)
    for i in range(2):
        expected = com_flow(begin.com[i], begin.com_velocity[i], command.zmp[i], ROBOT.omega, 0.003)
        assert (after.com[i], after.com_velocity[i]) == pytest.approx(expected, abs=1e-14)
        assert after.dcm[i] == pytest.approx(
            dcm_flow(begin.dcm[i], command.zmp[i], ROBOT.omega, 0.003), abs=1e-14
        )
    assert after.time == after.elapsed == pytest.approx(0.003)


def test_many_short_cycles_are_one_long_one() -> None:
    command = standing_command(step_duration=0.8)
    begin = GAIT.observation(sf.Side.RIGHT)
    ends = []
    for period in (0.1, 0.001):
        pushes = [sf.Push(0.0123, 0.0456, (200.0, -50.0)), sf.Push(0.03, 0.01, (0.0, 80.0))]
        simulator = sf.LipmSimulator(ROBOT, period, pushes)
        world, observation = simulator.start(begin), begin
        for _ in range(round(0.1 / period)):
            observation, world = simulator.step(world, command)
        ends.append(observation)
    assert ends[0].com == pytest.approx(ends[1].com, abs=1e-12)
    assert ends[0].com_velocity == pytest.approx(ends[1].com_velocity, abs=1e-12)


def test_a_push_begins_and_ends_at_its_exact_instants() -> None:
    """In one cycle of 10 ms: 3 ms without, 5 ms with, 2 ms without the push."""
    simulator = sf.LipmSimulator(ROBOT, 0.01, [sf.Push(0.003, 0.005, (300.0, 0.0))])
    begin = GAIT.observation(sf.Side.RIGHT)
    after, _ = simulator.step(simulator.start(begin), standing_command(step_duration=0.8))
    dcm = dcm_flow(begin.dcm[0], 0.0, ROBOT.omega, 0.003)
    dcm = dcm_flow(dcm, pushed_pivot(0.0, 300.0, ROBOT.mass, ROBOT.omega), ROBOT.omega, 0.005)
    dcm = dcm_flow(dcm, 0.0, ROBOT.omega, 0.002)
    assert after.dcm[0] == pytest.approx(dcm, abs=1e-14)


def test_an_impulse_changes_the_velocity_by_impulse_over_mass() -> None:
    short = sf.Push(0.0, 1e-6, (5e6, 0.0))
    simulator = sf.LipmSimulator(ROBOT, 1e-6, [short])
    begin = GAIT.observation(sf.Side.RIGHT)
    after, _ = simulator.step(simulator.start(begin), standing_command())
    assert after.com_velocity[0] - begin.com_velocity[0] == pytest.approx(
        short.delta_v(ROBOT.mass)[0],
        rel=1e-4,  # the pendulum accelerates too
    )


def test_touchdown_happens_at_the_exact_instant() -> None:
    simulator = sf.LipmSimulator(ROBOT, 0.001)
    begin = GAIT.observation(sf.Side.RIGHT)
    command = standing_command(step_duration=0.12345, swing_foot=(0.25, 0.1, 0.0))
    world, observation = simulator.start(begin), begin
    while observation.support_side == sf.Side.RIGHT:
        observation, world = simulator.step(world, command)
    assert observation.time == pytest.approx(0.12345, abs=1e-15)
    assert observation.elapsed == 0.0
    assert observation.support_side == sf.Side.LEFT
    assert observation.support_foot == pytest.approx((0.25, 0.1))
    assert observation.swing_foot == pytest.approx((*begin.support_foot, 0.0))
    assert observation.swing_foot_velocity == pytest.approx((0.0, 0.0, 0.0))
    assert observation.dcm[0] == pytest.approx(
        dcm_flow(begin.dcm[0], 0.0, ROBOT.omega, 0.12345), abs=1e-13
    )


def test_a_foot_cannot_land_in_the_cycle_in_which_it_lifts() -> None:
    simulator = sf.LipmSimulator(ROBOT, 0.001)
    world, command = simulator.start(GAIT.observation(sf.Side.RIGHT)), standing_command()
    after, _ = simulator.step(world, command.replace(step_duration=0.0))
    assert after.time == pytest.approx(0.001)


def test_a_slow_leg_lands_where_it_is() -> None:
    slow = ROBOT.replace(swing=Swing(max_speed=0.4))
    rollout = sf.simulate(sf.HybridController(ROBOT, (0.5, 0.0)), 0.6, plant=slow)
    step = rollout.footsteps[0]
    # 0.5 m away, half a second, 0.4 m/s: it gets no further than 0.2 m from where it left.
    travelled = step.landing[0] - rollout.swing_foot[0, 0]
    assert 0.15 < travelled <= 0.2 + 1e-9
    speed = np.hypot(*(np.diff(rollout.swing_foot[:, :2], axis=0)[:400].T)) / 0.001
    assert speed.max() <= 0.4 + 1e-9


def test_the_speed_limit_that_is_not_reached_changes_nothing() -> None:
    fast = ROBOT.replace(swing=Swing(max_speed=50.0))
    free, limited = (
        sf.simulate(sf.HybridController(robot, (0.5, 0.0)), 2.0) for robot in (ROBOT, fast)
    )
    assert free.observations.tobytes() == limited.observations.tobytes()


def test_it_falls_when_the_dcm_runs_away() -> None:
    rollout = sf.simulate(sf.DcmTracking(ROBOT, (0.5, 0.0)), 6.0, [sf.Push(1.1, 0.2, (500.0, 0.0))])
    assert rollout.outcome is sf.Outcome.FELL
    distance = np.hypot(*(rollout.dcm - rollout.support_foot).T)
    assert distance[-1] > fall_distance(ROBOT)
    assert distance[:-1].max() <= fall_distance(ROBOT)


def test_the_world_is_a_value() -> None:
    simulator = sf.LipmSimulator(ROBOT)
    world, command = simulator.start(GAIT.observation(sf.Side.RIGHT)), standing_command()
    before = world.tobytes(), command.array.tobytes()
    first, _ = simulator.step(world, command)
    second, _ = simulator.step(world, command)
    assert (world.tobytes(), command.array.tobytes()) == before
    assert first == second


@pytest.mark.parametrize("period", [0.0, -1.0, math.nan])
def test_a_period_that_makes_no_sense(period: float) -> None:
    with pytest.raises(sf.ParameterError, match=r"`period` above 0 \[s\]"):
        sf.LipmSimulator(ROBOT, period)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"duration": 0.0}, r"`duration` above 0 \[s\]"),
        ({"duration": math.inf}, "`duration` above 0 .* and finite"),
        ({"velocity_changes": [(2.0, (0.1, 0.0)), (1.0, (0.2, 0.0))]}, "in order of time"),
        # Before a walk that would take days.
        ({"duration": 1e6, "velocity_changes": [(1e5, (9.0, 0.0))]}, r"at most 2\.5000 m/s"),
    ],
)
def test_a_walk_that_makes_no_sense(arguments, message: str) -> None:
    with pytest.raises(sf.SurefootError, match=message):
        sf.simulate(sf.DcmTracking(ROBOT, (0.5, 0.0)), **arguments)

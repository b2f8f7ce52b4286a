from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import surefoot as sf
from surefoot.dcm.swing_foot import height, next_phase, quintic
from surefoot.robot.robot import Swing

PERIOD = 0.001
PUSH = sf.Push(1.1, 0.2, (250.0, 0.0))
small = st.floats(-0.5, 0.5)


@given(small, small, small, small, small, st.floats(0.05, 0.8))
def test_the_quintic_meets_both_ends(p, v, a, end, end_v, duration) -> None:
    assert quintic(p, v, a, end, end_v, duration, 0.0) == pytest.approx((p, v, a), abs=1e-9)
    there = quintic(p, v, a, end, end_v, duration, duration)
    assert there == pytest.approx((end, end_v, 0.0), abs=1e-7)


@given(small, small, small, small, st.floats(0.05, 0.8), st.floats(0.05, 0.9))
def test_the_quintic_is_consistent_under_replanning(p, v, a, end, duration, part) -> None:
    """From any point of it, the same landing gives the rest of the same quintic."""
    time = part * duration
    half_way = quintic(p, v, a, end, 0.0, duration, time)
    rest = duration - time
    for h in (0.0, 0.3 * rest, rest):
        again = quintic(*half_way, end, 0.0, rest, h)
        assert again == pytest.approx(quintic(p, v, a, end, 0.0, duration, time + h), abs=1e-5)
        assert again[0] == pytest.approx(
            quintic(p, v, a, end, 0.0, duration, time + h)[0], abs=1e-9
        )


@given(small, small, small, small, st.floats(0.1, 0.8), st.floats(0.1, 0.9))
def test_the_quintic_returns_its_own_derivatives(p, v, a, end, duration, part) -> None:
    h, time = 1e-5, part * duration
    here = quintic(p, v, a, end, 0.0, duration, time)
    before = quintic(p, v, a, end, 0.0, duration, time - h)
    after = quintic(p, v, a, end, 0.0, duration, time + h)
    scale = 1.0 + abs(here[2]) + 60.0 * (abs(end - p) + abs(v) + abs(a)) / duration**3
    assert (after[0] - before[0]) / (2 * h) == pytest.approx(here[1], abs=1e-6 * scale)
    assert (after[1] - before[1]) / (2 * h) == pytest.approx(here[2], abs=1e-5 * scale)


@given(st.floats(0.01, 0.99), st.floats(0.5, 10.0), st.floats(-20.0, 20.0), st.floats(0.0, 0.1))
def test_the_height_returns_its_own_derivatives(phase, rate, rate_of_rate, descent) -> None:
    h = 1e-6
    here = height(phase, rate, rate_of_rate, 0.05, descent)
    later, earlier = (
        height(
            phase + rate * t + 0.5 * rate_of_rate * t * t,
            rate + rate_of_rate * t,
            0.0,
            0.05,
            descent,
        )
        for t in (h, -h)
    )
    assert (later[0] - earlier[0]) / (2 * h) == pytest.approx(here[1], abs=1e-6)
    assert (later[1] - earlier[1]) / (2 * h) == pytest.approx(here[2], abs=1e-4)


@given(st.floats(-3.0, 4.0), st.floats(-20.0, 20.0), st.floats(-100.0, 100.0))
def test_the_foot_neither_rises_over_its_apex_nor_sinks(phase, rate, rate_of_rate) -> None:
    assert 0.0 <= height(phase, rate, rate_of_rate, 0.05, 0.0)[0] <= 0.05 * (1.0 + 1e-12)


@pytest.mark.parametrize("edge", [0.0, 1.0])
def test_the_height_is_cut_off_without_a_kink(edge: float) -> None:
    for side in (-1e-6, 1e-6):
        z, velocity, acceleration = height(edge + side, 3.0, 1.0, 0.05, 0.0)
        assert abs(z) < 1e-12
        assert abs(velocity) < 1e-9
        assert abs(acceleration) < 1e-3


@given(st.floats(0.2, 0.8), st.floats(0.0, 0.95))
def test_a_flight_as_planned_keeps_its_pace(duration, part) -> None:
    left = duration * (1.0 - part)
    after = next_phase(part, 1.0 / duration, 0.0, left, 0.5 * left)
    assert after == pytest.approx((0.5 * (1.0 + part), 1.0 / duration, 0.0), abs=1e-9)


def moving_swing(seed: int, push: float) -> sf.Rollout:
    """A walk whose landing and timing move every cycle: noise on the DCM at threshold 0."""
    controller = sf.HybridController(sf.load_robot("paper-biped"), (0.5, 0.0), threshold=0.0)
    rng = np.random.default_rng(seed)
    pushes = [
        sf.Push(0.05 * k, 0.05, tuple(rng.normal(0.0, push, 2)))  # type: ignore[arg-type]
        for k in range(40)
    ]
    return sf.simulate(controller, 2.0, pushes)


def boundary_value_quintic(start, end_position: float, duration: float, time: float):
    """The same quintic by a linear system of its six conditions: an independent implementation."""

    def rows(t: float) -> list[list[float]]:
        return [
            [t**k for k in range(6)],
            [k * t ** (k - 1) if k else 0.0 for k in range(6)],
            [k * (k - 1) * t ** (k - 2) if k > 1 else 0.0 for k in range(6)],
        ]

    conditions = np.array(rows(0.0) + rows(duration))
    coefficients = np.linalg.solve(conditions, [*start, end_position, 0.0, 0.0])
    return np.array(rows(time)) @ coefficients


@pytest.mark.parametrize("seed", range(4))
def test_the_swing_foot_is_twice_differentiable_through_replans(seed: int) -> None:
    """Every cycle goes on from exactly the position, velocity and acceleration at which the last
    one ended, while landing and timing move: within a cycle it is a polynomial, so it is C2."""
    rollout = moving_swing(seed, push=150.0)
    commands, observations = rollout.commands, rollout.observations
    elapsed, duration = observations["elapsed"], commands["step_duration"]
    assert np.ptp(duration) > 1e-3  # timing does move
    assert np.ptp(commands["step_location"][:100], axis=0).min() > 1e-3  # and so does the landing
    checked = 0
    for k in range(1, len(elapsed)):
        left = duration[k] - elapsed[k]
        if elapsed[k] == 0.0 or left <= PERIOD:
            continue
        before, now = commands[k - 1], commands[k]
        for i in range(2):
            start = [
                before[name][i]
                for name in ("swing_foot", "swing_foot_velocity", "swing_foot_acceleration")
            ]
            assert observations["swing_foot"][k, i] == start[0]
            assert observations["swing_foot_velocity"][k, i] == start[1]
            if left < 0.01:
                continue  # the linear system becomes ill-conditioned
            end = boundary_value_quintic(start, now["step_location"][i], left, PERIOD)
            size = 1.0 + abs(start[2])
            assert now["swing_foot"][i] == pytest.approx(end[0], abs=1e-9 * size)
            assert now["swing_foot_velocity"][i] == pytest.approx(end[1], abs=1e-7 * size)
            assert now["swing_foot_acceleration"][i] == pytest.approx(end[2], abs=1e-5 * size)
            checked += 1
    assert checked > 3000


@pytest.mark.parametrize("seed", range(6))
def test_the_height_is_smooth_and_bounded_through_replans(seed: int) -> None:
    """While the timing moves: z in [0, apex], and velocity and acceleration are its derivatives."""
    rollout = moving_swing(seed, push=150.0)
    commands, observations = rollout.commands, rollout.observations
    z = observations["swing_foot"][:, 2]
    assert z.min() >= 0.0
    assert z.max() <= 0.05 * (1.0 + 1e-9)
    elapsed = observations["elapsed"]
    inside = (elapsed[1:] > elapsed[:-1]) & (elapsed[:-1] > 0.0)
    velocity = observations["swing_foot_velocity"][:, 2]
    acceleration = commands["swing_foot_acceleration"][:, 2]
    # Over a cycle the velocity changes by what the accelerations at its ends say, to the order
    # that a bounded third derivative leaves; a jump would not shrink with the cycle.
    late = (commands["step_duration"] - elapsed)[1:] > 0.02
    gained = (velocity[1:] - velocity[:-1])[1:][(inside & late)[1:]]
    mean = 0.5 * (acceleration[1:] + acceleration[:-1])[:-1][(inside & late)[1:]]
    moved = (z[1:] - z[:-1])[inside & late]
    mean_velocity = 0.5 * (velocity[1:] + velocity[:-1])[inside & late]
    assert np.abs(moved - PERIOD * mean_velocity).max() < 2e-5
    assert np.abs(gained - PERIOD * mean).max() < 0.05 * np.abs(velocity).max()


def test_a_push_that_hurries_the_step_does_not_fling_the_foot_up(robot: sf.Robot) -> None:
    """The foot used to pass its apex height on the way to three times of it."""
    controller = sf.HybridController(robot, (0.5, 0.0))
    for angle in np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False):
        force = (1200.0 * np.cos(angle), 1200.0 * np.sin(angle))
        for start in (1.02, 1.06, 1.2):
            rollout = sf.simulate(controller, 2.2, [sf.Push(start, 0.05, force)])
            assert rollout.swing_foot[:, 2].max() <= 0.05 * (1.0 + 1e-9)
            assert rollout.swing_foot[:, 2].min() >= 0.0


def test_the_foot_lands_with_the_velocity_asked_for(robot: sf.Robot) -> None:
    """Downward; slower feet and double support included."""
    falling = robot.replace(swing=Swing(landing_velocity=0.1))
    for double_support in (0.0, 0.2):
        controller = sf.HybridController(falling, (0.5, 0.0), double_support=double_support)
        rollout = sf.simulate(controller, 2.0)
        down = rollout.commands["swing_foot_velocity"][:, 2]
        last = np.flatnonzero(rollout.swing_foot[1:, 2] < rollout.swing_foot[:-1, 2])
        assert down.min() < -0.1  # faster on the way
        ends = [k for k in last if rollout.commands["swing_foot"][k, 2] == 0.0]
        assert len(ends) >= 3
        # The first step begins without a transition, so its flight is longer and slower.
        assert down[ends[1:]] == pytest.approx(-0.1, rel=0.01)


def test_the_foot_reaches_its_apex_and_lands_softly(pushed_walk: sf.Rollout) -> None:
    height = pushed_walk.swing_foot[:, 2]
    assert height.max() == pytest.approx(0.05, rel=0.05)
    assert height.min() > -1e-6
    for step in pushed_walk.footsteps:
        during = (pushed_walk.time >= step.start) & (
            pushed_walk.time < step.start + step.duration - 1e-9
        )
        last = np.flatnonzero(during)[-1]
        assert height[during].max() > 0.03
        assert abs(height[last]) < 1e-4
        assert abs(pushed_walk.commands["swing_foot_velocity"][last, 2]) < 0.05


def test_a_leg_that_is_just_fast_enough_changes_nothing(robot: sf.Robot) -> None:
    """0.5 m in 0.5 s peak at 15/8 m/s on the smooth way; a limit above that is not felt."""
    limited = robot.replace(swing=Swing(max_speed=1.9))
    free, slow = (
        sf.simulate(sf.HybridController(each, (0.5, 0.0)), 3.0) for each in (robot, limited)
    )
    assert free.observations.tobytes() == slow.observations.tobytes()


def test_a_leg_of_limited_speed_hurries_no_faster_than_it_can(robot: sf.Robot) -> None:
    """It runs straight to the landing where the smooth way would be too fast, and says when even
    that is too slow."""
    limited = robot.with_leg(max_speed=3.0)
    rollout = sf.simulate(sf.HybridController(limited, (0.5, 0.0)), 6.0, [PUSH])
    speed = np.abs(rollout.commands["swing_foot_velocity"][:, :2])
    assert speed.max() == pytest.approx(3.0, rel=1e-3)
    assert rollout.outcome is sf.Outcome.RECOVERED
    status = rollout.commands["status"]
    late = (status & sf.Status.UNREACHABLE) != 0
    away = np.abs(rollout.commands["step_location"] - rollout.swing_foot[:, :2]).max(axis=1)
    left = rollout.commands["step_duration"] - rollout.observations["elapsed"]
    reach = 3.0 * np.maximum(left, 0.001)
    assert (late == (away > reach + 1e-9)).all()
    assert late.any()
    assert not late.all()


def test_a_leg_of_limited_acceleration_keeps_to_it(robot: sf.Robot) -> None:
    limited = robot.with_leg(max_speed=3.0, max_acceleration=60.0)
    rollout = sf.simulate(sf.HybridController(limited, (0.5, 0.0)), 6.0, [PUSH])
    speed = rollout.observations["swing_foot_velocity"][:, :2]
    assert np.abs(speed).max() == pytest.approx(3.0, rel=1e-3)
    inside = np.diff(rollout.observations["elapsed"]) > 0.5 * PERIOD
    gained = np.abs(np.diff(speed, axis=0)[inside])
    assert gained.max() == pytest.approx(60.0 * PERIOD, rel=1e-6)


def test_each_axis_of_a_diagonal_step_has_the_whole_limit(robot: sf.Robot) -> None:
    """Forward and sideways motion come from different joints: 1.2 m/s along both are no 1.7."""
    slow = robot.with_leg(max_speed=1.2)
    rollout = sf.simulate(sf.HybridController(slow, (0.3, 0.25)), 3.0)
    free = sf.simulate(sf.HybridController(robot, (0.3, 0.25)), 3.0)
    speed = rollout.commands["swing_foot_velocity"][:, :2]
    assert np.hypot(*speed.T).max() > 1.4
    assert rollout.observations.tobytes() == free.observations.tobytes()

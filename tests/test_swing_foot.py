from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import surefoot as sf
from surefoot.models.robot import Swing
from surefoot.planning.swing_foot import APEX_WINDOW, bump, bump_lift, quintic

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


@given(st.floats(0.1, 0.8), st.floats(0.01, 0.99))
def test_the_bump_returns_its_own_derivatives(duration, part) -> None:
    h, time, lift = 1e-5, part * duration, 1.0 / duration**6
    here = bump(lift, duration, time)
    before, after = bump(lift, duration, time - h), bump(lift, duration, time + h)
    assert (after[0] - before[0]) / (2 * h) == pytest.approx(here[1], abs=1e-5 / duration**3)
    assert (after[1] - before[1]) / (2 * h) == pytest.approx(here[2], abs=1e-4 / duration**4)


@given(
    st.floats(0.2, 0.8),
    st.floats(0.0, 1.0),
    st.floats(-0.1, 0.1),
    st.floats(-3.0, 3.0),
    st.floats(-20.0, 20.0),
    st.floats(0.0, 0.3),
)
def test_the_lift_of_the_plan_under_way_goes_on(duration, part, z, vz, az, down) -> None:
    """Re-planning towards an unchanged landing changes nothing, before and after the apex."""
    lift = bump_lift(z, vz, az, 0.05, down, 0.0, duration, 0.0, duration)
    time = part * 0.95 * duration
    left = duration - time
    base = quintic(z, vz, az, 0.0, -down, duration, time)
    state = np.add(base, bump(lift, duration, time))
    again = bump_lift(*state, 0.05, down, time, duration, lift, duration)
    size = 1.0 + abs(vz) + abs(az)
    for h in (0.25 * left, 0.6 * left):
        replanned = np.add(quintic(*state, 0.0, -down, left, h), bump(again, left, h))
        original = np.add(
            quintic(z, vz, az, 0.0, -down, duration, time + h), bump(lift, duration, time + h)
        )
        assert replanned[0] == pytest.approx(original[0], abs=1e-8 * size)
    assert 0.0 < APEX_WINDOW < 0.5


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


@given(st.floats(-1e5, 1e5), st.floats(0.01, 0.8))
def test_the_bump_starts_and_ends_without_a_trace(lift, duration) -> None:
    assert bump(lift, duration, 0.0) == (0.0, 0.0, 0.0)
    assert bump(lift, duration, duration) == (0.0, 0.0, 0.0)


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
    limited = robot.replace(swing=Swing(max_speed=3.0))
    rollout = sf.simulate(sf.HybridController(limited, (0.5, 0.0)), 6.0, [PUSH])
    speed = np.hypot(*rollout.commands["swing_foot_velocity"][:, :2].T)
    assert speed.max() == pytest.approx(3.0, rel=1e-3)
    assert rollout.outcome is sf.Outcome.RECOVERED
    status = rollout.commands["status"]
    late = (status & sf.Status.UNREACHABLE) != 0
    away = np.hypot(*(rollout.commands["step_location"] - rollout.swing_foot[:, :2]).T)
    left = rollout.commands["step_duration"] - rollout.observations["elapsed"]
    reach = 3.0 * np.maximum(left, 0.001)
    assert (late == (away > reach + 1e-9)).all()
    assert late.any()
    assert not late.all()

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import surefoot as sf
from surefoot.dcm.dcm_plan import hermite, transition
from surefoot.dcm.support import nearest_under_feet, nearest_under_foot

OMEGA = 3.5
numbers = st.floats(-0.6, 0.6)
times = st.floats(0.01, 0.2)


@given(numbers, numbers, numbers, numbers, times)
def test_the_cubic_meets_both_ends(start, start_rate, end, end_rate, duration) -> None:
    ends = (start, start_rate, end, end_rate, duration)
    assert hermite(*ends, 0.0) == pytest.approx((start, start_rate), abs=1e-12)
    assert hermite(*ends, duration) == pytest.approx((end, end_rate), abs=1e-9)


@given(numbers, numbers, times, times)
def test_a_transition_continues_the_single_support_on_both_sides(step, dcm, before, after) -> None:
    """Position, and with the ZMP also the rate, are those of the plan without transitions."""
    begin = transition(step, dcm, OMEGA, before, after, -before)
    assert begin == pytest.approx((dcm * math.exp(-OMEGA * before), 0.0), abs=1e-9)
    end = transition(step, dcm, OMEGA, before, after, after)
    away = (dcm - step) * math.exp(OMEGA * after)
    assert end == pytest.approx((step + away, step), abs=1e-9)


@given(numbers, numbers, times, st.floats(0.1, 0.9))
def test_the_zmp_makes_the_dcm_move_as_planned(step, dcm, half, part) -> None:
    """dcm' = omega (dcm - zmp), by differences."""
    time, h = (2.0 * part - 1.0) * half, 1e-6
    here, zmp = transition(step, dcm, OMEGA, half, half, time)
    later, _ = transition(step, dcm, OMEGA, half, half, time + h)
    earlier, _ = transition(step, dcm, OMEGA, half, half, time - h)
    assert (later - earlier) / (2.0 * h) == pytest.approx(OMEGA * (here - zmp), abs=1e-5)


@given(numbers, numbers, st.floats(-1.0, 1.0))
def test_a_short_transition_is_none(step, dcm, part) -> None:
    half = 1e-6
    here, _ = transition(step, dcm, OMEGA, half, half, part * half)
    assert here == pytest.approx(dcm, abs=1e-5)


def corners_of(centre, yaw: float, half) -> np.ndarray:
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])
    return centre + (signs * half) @ turn.T


def hull_distance(point, corners: np.ndarray) -> float:
    """Independent: the distance to the convex hull of some corners, as a small QP by projection.

    Frank-Wolfe with away steps would do; for eight corners every pair of them is tried instead:
    the nearest point lies on a segment between two corners, or the point is inside a triangle.
    """
    point = np.asarray(point)
    for i in range(len(corners)):
        for j in range(i):
            for k in range(j):
                a, b, c = corners[i], corners[j], corners[k]
                system = np.array([b - a, c - a]).T
                if abs(np.linalg.det(system)) < 1e-12:
                    continue
                u, v = np.linalg.solve(system, point - a)
                if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                    return 0.0
    nearest = math.inf
    for i in range(len(corners)):
        for j in range(i):
            edge = corners[j] - corners[i]
            length = max(edge @ edge, 1e-300)
            along = np.clip((point - corners[i]) @ edge / length, 0.0, 1.0)
            nearest = min(nearest, float(np.hypot(*(point - corners[i] - along * edge))))
    return nearest


HALF = (0.1, 0.055)
yaws = st.floats(-1.5, 1.5)


@given(st.tuples(numbers, numbers), st.tuples(numbers, numbers), yaws, yaws)
@settings(max_examples=40)
def test_the_projection_is_the_nearest_point_of_the_hull(point, other, yaw, other_yaw) -> None:
    corners = np.vstack([corners_of((0.0, 0.0), yaw, HALF), corners_of(other, other_yaw, HALF)])
    x, y = nearest_under_feet(*point, *other, *HALF, yaw, other_yaw)
    expected = hull_distance(point, corners)
    assert math.hypot(point[0] - x, point[1] - y) == pytest.approx(expected, abs=1e-9)
    assert hull_distance((x, y), corners) == pytest.approx(0.0, abs=1e-9)


@given(st.tuples(numbers, numbers), yaws)
def test_under_one_foot(point, yaw) -> None:
    corners = corners_of((0.0, 0.0), yaw, HALF)
    x, y = nearest_under_foot(*point, *HALF, yaw)
    expected = hull_distance(point, corners)
    assert math.hypot(point[0] - x, point[1] - y) == pytest.approx(expected, abs=1e-9)


ROBOT = sf.load_robot("paper-biped")
KINDS = [sf.DcmTracking, sf.HybridController]
VELOCITIES = [(0.5, 0.0), (0.0, 0.0), (-0.3, 0.1), (0.0, 0.2)]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("velocity", VELOCITIES)
@pytest.mark.parametrize("fraction", [0.05, 0.2, 0.6])
def test_dcm_and_zmp_move_without_a_jump_inside_the_polygon(kind, velocity, fraction) -> None:
    rollout = sf.simulate(kind(ROBOT, velocity, double_support=fraction), 4.0)
    assert rollout.outcome is sf.Outcome.WALKED
    assert rollout.zmp_excess.max() == 0.0
    gait = sf.nominal_gait(ROBOT, velocity)
    # The ZMP crosses from foot to foot in fraction * T; on the way it is at most twice as fast
    # as on average, and the first step begins without a transition.
    fastest = 2.0 * math.hypot(*gait.step(sf.Side.RIGHT)) / (fraction * gait.step_duration)
    moved = np.hypot(*np.diff(rollout.zmp, axis=0).T)
    assert moved.max() < 1.2 * fastest * 0.001
    # The planned DCM is continuous, and so is its rate.
    regular = np.isclose(np.diff(rollout.time), 0.001, atol=1e-9)
    rate = np.diff(rollout.dcm_plan, axis=0)[regular] / 0.001
    assert np.abs(rate).max() < 3.0
    assert np.abs(np.diff(rate, axis=0)).max() < 3.0 * fastest * ROBOT.omega * 0.001
    assert np.hypot(*rollout.dcm_error.T).max() < 1e-3  # the ZMP is held for a millisecond
    shared = rollout.commands["double_support"].mean()
    assert shared == pytest.approx(fraction, abs=0.06)


def test_both_feet_rest_on_the_ground_while_they_share_the_load() -> None:
    rollout = sf.simulate(sf.DcmTracking(ROBOT, (0.5, 0.0), double_support=0.3), 4.0)
    shared = rollout.commands["double_support"] != 0
    assert np.abs(rollout.swing_foot[shared, 2]).max() < 1e-9
    speed = rollout.observations["swing_foot_velocity"][shared]
    assert np.abs(speed).max() < 0.02  # but for the cycle in which it arrives
    assert rollout.swing_foot[~shared, 2].max() > 0.045


@pytest.mark.parametrize("kind", KINDS)
def test_no_double_support_is_the_limit_of_a_short_one(kind) -> None:
    without = sf.simulate(kind(ROBOT, (0.4, 0.1)), 3.0)
    short = sf.simulate(kind(ROBOT, (0.4, 0.1), double_support=1e-6), 3.0)
    assert without.time == pytest.approx(short.time, abs=1e-6)
    for name in ("dcm", "dcm_plan", "com", "support_foot"):
        assert getattr(without, name) == pytest.approx(getattr(short, name), abs=1e-3), name


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_mirrored_with_the_robot(kind) -> None:
    push = sf.Push(1.1, 0.2, (30.0, 10.0))
    here = sf.simulate(
        kind(ROBOT, (0.4, 0.1), double_support=0.2), 3.0, [push], first_support=sf.Side.RIGHT
    )
    there = sf.simulate(
        kind(ROBOT, (0.4, -0.1), double_support=0.2),
        3.0,
        [replace(push, force=(30.0, -10.0))],
        first_support=sf.Side.LEFT,
    )
    mirror = np.array((1.0, -1.0))
    for name in ("dcm", "zmp", "dcm_plan"):
        assert getattr(here, name) * mirror == pytest.approx(getattr(there, name), abs=1e-9), name


def test_a_new_velocity_does_not_make_the_plan_jump() -> None:
    """Also when it comes while both feet are on the ground and the landing is settled."""
    controller = sf.DcmTracking(ROBOT, (0.5, 0.0), double_support=0.3)
    for time in (0.73, 0.97, 1.03, 0.99):
        rollout = sf.simulate(controller, 4.0, velocity_changes=[(time, (0.1, 0.1))])
        assert rollout.outcome is sf.Outcome.WALKED
        assert np.abs(np.diff(rollout.dcm_plan, axis=0)).max() < 0.003
        assert np.abs(np.diff(rollout.zmp, axis=0)).max() < 0.01
        assert rollout.final_velocity == pytest.approx((0.1, 0.1), abs=1e-3)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("fraction", [-0.1, 0.7, math.nan])
def test_a_fraction_that_makes_no_sense(kind, fraction) -> None:
    with pytest.raises(sf.ParameterError, match="`double_support` of at"):
        kind(ROBOT, (0.5, 0.0), double_support=fraction)

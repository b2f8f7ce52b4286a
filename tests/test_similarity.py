"""Dynamic similarity: a robot that is alike but for its size walks alike, and ends alike.

Lengths times lambda, times times sqrt(lambda), masses times mu: nothing in Surefoot knows one size.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import surefoot as sf
from random_cells import random_cell
from scales import UNITY, Scale, largest_difference
from surefoot.control.registry import Method, methods
from surefoot.dcm.nominal_gait import gait_room, largest_speed
from surefoot.dcm.push_limit import PushCase, fixed_steps_limit
from surefoot.dcm.viability import fall_distance
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.rollout.outcome import recovery_time, settled_error

ROBOT = sf.load_robot("paper-biped").replace(body=None).with_leg(max_speed=3.0)
NIMBLE = ROBOT.with_leg(max_acceleration=60.0)
VELOCITY = (0.4, 0.05)
PUSHES = (sf.Push(1.1, 0.15, (280.0, 240.0)), sf.Push(2.8, 0.01, (-1500.0, 500.0)))
WEAK = (sf.Push(1.1, 0.15, (40.0, 40.0)), sf.Push(2.8, 0.01, (-800.0, 300.0)))
"""That those survive which step as planned."""

SCALES = (Scale(0.25, 3.0), Scale(4.0, 100.0), Scale(0.1, 0.01), Scale(10.0, 3.0))


def walk(one: Method, scale: Scale, robot: sf.Robot = ROBOT, duration: float = 4.5) -> sf.Rollout:
    """A pushed walk of a method in some size.

    How often it decides is a matter of its computer, and so absolute: that is scaled by hand.
    """
    known = one.make.__dataclass_fields__
    given = {
        name: one.parameters.get(name, known[name].default)
        for name in ("period", "solve_period")
        if name in known
    }
    # What is left out follows from these.
    periods = {name: scale.time * value for name, value in given.items() if value is not None}
    controller = one.controller(scale.robot(robot), scale.velocity(VELOCITY), **periods)
    pushes = [scale.push(push) for push in (WEAK if one.fixed_steps else PUSHES)]
    return sf.simulate(controller, scale.time * duration, pushes)


@cache
def usual_walk(key: str, duration: float = 4.5) -> sf.Rollout:
    (one,) = (method for method in methods() if method.key == key)
    return walk(one, UNITY, duration=duration)


def assert_alike(usual: sf.Rollout, scaled: sf.Rollout, scale: Scale) -> None:
    assert largest_difference(UNITY.back(usual), scale.back(scaled)) == ""
    assert scaled.outcome is usual.outcome
    assert len(scaled.footsteps) == len(usual.footsteps)


@pytest.mark.parametrize("scale", SCALES, ids=str)
@pytest.mark.parametrize("key", [one.key for one in methods()])
def test_every_method_walks_alike(key: str, scale: Scale) -> None:
    (one,) = (method for method in methods() if method.key == key)
    duration = 1.6 if one.slow else 4.5
    assert_alike(usual_walk(key, duration), walk(one, scale, duration=duration), scale)


@pytest.mark.parametrize("scale", SCALES, ids=str)
@pytest.mark.parametrize("key", ["hybrid", "unified"])
def test_a_leg_that_accelerates_is_alike(key: str, scale: Scale) -> None:
    (one,) = (method for method in methods() if method.key == key)
    usual, scaled = walk(one, UNITY, NIMBLE), walk(one, scale, NIMBLE)
    if math.log2(scale.length) % 2.0 == 0.0:
        assert_alike(usual, scaled, scale)
        return
    # What may be reached is not convex: rounding may choose between landings that cost the same.
    assert scaled.outcome is usual.outcome
    for here, there in zip(usual.footsteps, scaled.footsteps, strict=True):
        assert np.array(there.step) / scale.length == pytest.approx(here.step, abs=0.01)
        assert there.duration / scale.time == pytest.approx(here.duration, abs=0.01)


@pytest.mark.parametrize("scale", SCALES, ids=str)
@pytest.mark.parametrize("key", ["tracking", "hybrid", "unified"])
def test_what_disturbs_and_what_estimates_is_alike(key: str, scale: Scale) -> None:
    disturbance = sf.Disturbance(
        dcm_noise=0.002, velocity_noise=0.01, delay=0.003, com_offset=(0.005, -0.004),
        landing_error=0.005, touchdown_shift=-0.004, seed=5,
    )  # fmt: skip
    (one,) = (method for method in methods() if method.key == key)

    def disturbed(size: Scale) -> sf.Rollout:
        robot, period = size.robot(ROBOT), 0.001 * size.time
        times = {"delay": 0.003, "filter_time": 0.02, "bias_time": 0.6}
        return sf.simulate(
            one.controller(robot, size.velocity(VELOCITY), period=period),
            3.0 * size.time,
            [size.push(PUSHES[0])],
            disturbance=size.disturbance(disturbance),
            estimator=sf.Estimator(
                robot, period=period, **{name: size.time * value for name, value in times.items()}
            ),
            plant=robot.replace(mass=1.1 * robot.mass, com_height=1.05 * robot.com_height),
        )

    assert_alike(disturbed(UNITY), disturbed(scale), scale)


@pytest.mark.parametrize("scale", SCALES, ids=str)
@pytest.mark.parametrize("key", ["tracking", "capture-point", "hybrid", "unified"])
def test_the_same_share_of_the_limit_fails(key: str, scale: Scale) -> None:
    (one,) = (method for method in methods() if method.key == key)

    def smallest(size: Scale) -> tuple[float, bool, float]:
        robot = size.robot(ROBOT)
        limit = sf.push_limit(
            robot, (0.0, 1.0), velocity=size.velocity(VELOCITY), elapsed=size.time * 0.1,
            duration=size.time * 0.1, zmp_reach=robot.foot.half,
        ).impulse  # fmt: skip
        found = sf.smallest_failing_push(
            one.controller(robot, size.velocity(VELOCITY), period=size.time * 0.001),
            (0.0, 1.0),
            start=size.time * 1.1,
            duration=size.time * 0.1,
            step=0.07 * limit,
            largest=1.15 * limit,
        )
        return found.impulse / limit, found.fell, limit / size.impulse

    assert smallest(scale) == pytest.approx(smallest(UNITY), rel=1e-9)


@pytest.mark.parametrize("scale", SCALES, ids=str)
@pytest.mark.parametrize("robot", [ROBOT, NIMBLE, ROBOT.with_leg(max_speed=math.inf)])
def test_limits_and_rules_are_alike(robot: sf.Robot, scale: Scale) -> None:
    other = scale.robot(robot)
    usual, scaled = viable_displacement(robot), viable_displacement(other)
    assert scaled.values / scale.length == pytest.approx(usual.values, rel=1e-9, abs=1e-9)
    assert fall_distance(other) == pytest.approx(scale.length * fall_distance(robot), rel=1e-12)
    speeds = [largest_speed(one, (1.0, 0.4)) for one in (robot, other)]
    assert speeds[1] == pytest.approx(scale.time * speeds[0], rel=1e-12)
    walks = [
        sf.HybridController(one, velocity)
        for one, velocity in ((robot, VELOCITY), (other, scale.velocity(VELOCITY)))
    ]
    rooms = [gait_room(one.robot, one.gait, one.robot.foot.half) for one in walks]
    assert rooms[1] == pytest.approx(scale.length * rooms[0], rel=1e-9)
    errors, times = [settled_error(one) for one in walks], [recovery_time(one) for one in walks]
    assert errors[1] == pytest.approx(scale.length * errors[0], rel=1e-9)
    assert times[1] == pytest.approx(scale.time * times[0], rel=1e-12)
    for angle in (0.0, 0.7, 2.5, 4.0):
        direction = (math.cos(angle), math.sin(angle))
        case = PushCase(
            robot, direction, velocity=VELOCITY, elapsed=0.13, duration=0.05,
            zmp_reach=robot.foot.half,
        )  # fmt: skip
        limits = [size.case(case).limit().impulse for size in (UNITY, scale)]
        assert limits[1] == pytest.approx(scale.impulse * limits[0], rel=1e-9)
    fixed = [
        fixed_steps_limit(one, (0.6, 0.8), duration=size.time * 0.05).impulse
        for one, size in ((robot, UNITY), (other, scale))
    ]
    assert fixed[1] == pytest.approx(scale.impulse * fixed[0], rel=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_limits_of_any_robot_are_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cell = random_cell(seed, acceleration=seed % 2 == 1)
    scale = Scale(10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-2.0, 2.0))
    expected = scale.impulse * cell.limit().impulse
    assert scale.case(cell).limit().impulse == pytest.approx(expected, rel=1e-9)


@given(
    st.integers(0, 10**6),
    st.sampled_from((0.0625, 0.25, 4.0, 16.0)),
    st.sampled_from((0.015625, 0.5, 8.0, 64.0)),
    st.booleans(),
    st.floats(0.1, 1.3),
)
def test_any_robot_walks_alike_to_the_bit(
    seed: int, length: float, mass: float, acceleration: bool, share: float
) -> None:
    """In powers of two a change of size is exact, so nothing may differ, not even by rounding.

    In other sizes rounding may choose between landings that cost the same.
    """
    cell, scale = random_cell(seed, acceleration=acceleration), Scale(length, mass)
    impulse = share * cell.limit().impulse
    rollouts = []
    for one, size in ((cell, UNITY), (scale.case(cell), scale)):
        controller = one.controller(period=0.001 * size.time)
        push = one.push(size.impulse * impulse)
        end = push.end + 6.0 / one.robot.omega
        rollouts.append(sf.simulate(controller, end, [push], first_support=one.support_side))
    usual, other = rollouts
    assert other.outcome is usual.outcome
    back = scale.back(other)
    assert all(np.array_equal(back[name], values) for name, values in UNITY.back(usual).items())


def test_a_scaled_robot_has_everything_scaled() -> None:
    robot = sf.load_robot("paper-biped").replace(body=None)
    small = robot.scaled(length=0.25, mass=0.1)
    assert small.omega == 2.0 * robot.omega
    assert (small.mass, small.com_height, small.hip) == pytest.approx((6.8, 0.2, 0.05))
    assert small.gait.step_duration == pytest.approx((0.1, 0.4))
    assert small.gait.step_y == pytest.approx((-0.05, 0.075))
    assert small.swing.max_acceleration == robot.swing.max_acceleration
    assert small.trunk is not None
    assert robot.trunk is not None
    # A torque is a share of m g h, an inertia one of m h^2.
    for one in (small, robot):
        assert one.trunk is not None
        assert one.trunk.max_torque / (one.mass * one.gravity * one.com_height) == pytest.approx(
            0.18736, abs=1e-4
        )
        assert one.trunk.inertia / (one.mass * one.com_height**2) == pytest.approx(0.1011, abs=1e-4)


def test_a_body_is_not_scaled() -> None:
    with pytest.raises(sf.RobotError, match=r"without a body.*replace\(body=None\)"):
        sf.load_robot("paper-biped").scaled(length=2.0)
    with pytest.raises(sf.RobotError, match="`length` of the scale to be positive"):
        ROBOT.scaled(length=0.0)


@pytest.mark.parametrize("make", [sf.HybridController, sf.StepTiming, sf.TimingNlp])
def test_what_is_left_out_follows_the_gait_and_what_is_given_stays(make) -> None:
    made = make(ROBOT, (0.5, 0.0))
    slow = made.with_velocity((0.2, 0.1))
    assert slow == make(ROBOT, (0.2, 0.1))
    assert slow.tau_weight != made.tau_weight
    given = make(ROBOT, (0.5, 0.0), tau_weight=3.0)
    assert given.with_velocity((0.2, 0.1)).tau_weight == 3.0


def test_the_defaults_are_those_of_the_papers_biped() -> None:
    hybrid = sf.HybridController(sf.load_robot("paper-biped"), (0.5, 0.0))
    assert hybrid.dcm_gain == pytest.approx(3.0, rel=1e-3)
    assert hybrid.threshold == pytest.approx(0.025, rel=0.01)
    assert hybrid.tau_weight == pytest.approx(1.0, rel=0.01)

"""The nominal gait, and the largest speed, which every compiled method walks for ever."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import surefoot as sf
from surefoot.control.registry import methods
from surefoot.dcm.pendulum import com_flow, dcm_flow
from surefoot.robot.gait import GaitLimits

ROBOTS = [sf.load_robot(name) for name in sf.preset_names()]
robots = st.sampled_from(ROBOTS)
headings = st.floats(-math.pi, math.pi)
fractions = st.floats(0.0, 0.999)
sides = st.sampled_from(list(sf.Side))


def walkable(robot: sf.Robot, heading: float, fraction: float) -> tuple[float, float]:
    """A velocity as a fraction of the largest speed in its direction."""
    direction = (math.cos(heading), math.sin(heading))
    speed = fraction * sf.largest_speed(robot, direction)
    return speed * direction[0], speed * direction[1]


def test_the_papers_gait() -> None:
    gait = sf.nominal_gait(sf.load_robot("paper-biped"), (0.5, 0.0))
    assert gait.step_duration == pytest.approx(0.5)
    assert gait.step_length == pytest.approx(0.25)
    assert gait.dcm_offset(sf.Side.RIGHT)[0] == pytest.approx(0.052524, abs=5e-7)


@given(robots, headings, fractions, sides)
def test_the_offset_repeats_step_after_step(robot, heading, fraction, side) -> None:
    """dcm(T) - p_next is d_nom of the next foot, which is where its step starts."""
    gait = sf.nominal_gait(robot, walkable(robot, heading, fraction))
    foot = np.zeros(2)
    dcm = foot + gait.start_offset(side)
    for _ in range(4):
        dcm = np.array([dcm_flow(dcm[i], foot[i], gait.omega, gait.step_duration) for i in (0, 1)])
        foot = foot + gait.step(side)
        assert dcm - foot == pytest.approx(gait.dcm_offset(side), abs=1e-9)
        side = side.other
        assert dcm - foot == pytest.approx(gait.start_offset(side), abs=1e-9)
        dcm = foot + gait.start_offset(side)  # keep rounding from growing


@given(robots, headings, fractions, sides)
def test_com_and_mean_velocity_repeat(robot, heading, fraction, side) -> None:
    gait = sf.nominal_gait(robot, walkable(robot, heading, fraction))
    begin = gait.observation(side)
    com, velocity, foot = begin.com.copy(), begin.com_velocity.copy(), begin.support_foot.copy()
    for _ in range(2):
        flown = [
            com_flow(com[i], velocity[i], foot[i], gait.omega, gait.step_duration) for i in (0, 1)
        ]
        com, velocity = np.array(flown).T
        foot, side = foot + gait.step(side), side.other
    assert velocity == pytest.approx(begin.com_velocity, abs=1e-9)
    assert (com - begin.com) / (2.0 * gait.step_duration) == pytest.approx(gait.velocity, abs=1e-9)


@given(robots, headings, fractions, sides)
def test_every_nominal_step_lies_in_its_box(robot, heading, fraction, side) -> None:
    gait = sf.nominal_gait(robot, walkable(robot, heading, fraction))
    low, high = robot.gait.step_box(side, robot.hip)
    step = np.array(gait.step(side))
    assert (step >= np.array(low) - 1e-12).all()
    assert (step <= np.array(high) + 1e-12).all()
    assert robot.gait.step_duration[0] <= gait.step_duration <= robot.gait.step_duration[1]


@given(robots, headings, fractions, sides)
def test_the_gait_is_mirrored_with_the_velocity(robot, heading, fraction, side) -> None:
    v_x, v_y = walkable(robot, heading, fraction)
    here, there = sf.nominal_gait(robot, (v_x, v_y)), sf.nominal_gait(robot, (v_x, -v_y))
    mirror = np.array([1.0, -1.0])
    assert here.step_duration == there.step_duration
    for name in ("step", "start_offset", "dcm_offset", "com_offset"):
        mine = np.array(getattr(here, name)(side))
        theirs = np.array(getattr(there, name)(side.other))
        assert mine * mirror == pytest.approx(theirs, abs=1e-12), name


def test_backwards_uses_the_backward_limit() -> None:
    robot = sf.load_robot("paper-biped")
    short = robot.replace(
        gait=GaitLimits(
            step_duration=(0.2, 0.8), step_x=(-0.2, 0.5), step_y=(-0.2, 0.3), dcm_offset=(0.1, 0.05)
        )
    )
    assert sf.largest_speed(short, (1.0, 0.0)) == pytest.approx(2.5)
    assert sf.largest_speed(short, (-1.0, 0.0)) == pytest.approx(1.0)
    assert sf.nominal_gait(short, (-0.5, 0.0)).step_length == pytest.approx(-0.5 * (0.2 + 0.4) / 2)


@given(robots, headings)
def test_the_largest_speed_named_can_be_walked_and_no_more(robot, heading) -> None:
    direction = (math.cos(heading), math.sin(heading))
    largest = sf.largest_speed(robot, direction)
    with pytest.raises(sf.VelocityError) as caught:
        sf.nominal_gait(robot, (1.001 * largest * direction[0], 1.001 * largest * direction[1]))
    named = float(caught.value.expected.split()[2])
    assert named == pytest.approx(largest, abs=1.1e-4)
    assert named <= largest
    sf.nominal_gait(robot, (named * direction[0], named * direction[1]))


def test_no_direction_no_speed() -> None:
    with pytest.raises(sf.VelocityError, match="a direction of some length"):
        sf.largest_speed(sf.load_robot("paper-biped"), (0.0, 0.0))


@pytest.mark.parametrize("velocity", [(math.nan, 0.0), (0.5,), 0.5, "fast", (0.0, math.inf), None])
def test_a_velocity_that_is_none(velocity) -> None:
    with pytest.raises(sf.VelocityError, match="two finite numbers"):
        sf.nominal_gait(sf.load_robot("paper-biped"), velocity)


def test_a_fixed_step_duration() -> None:
    robot = sf.load_robot("paper-biped")
    assert sf.nominal_gait(robot, (0.5, 0.0), 0.4).step_length == pytest.approx(0.2)
    with pytest.raises(sf.ParameterError, match=r"a step duration in \[0.2, 0.8\] s"):
        sf.nominal_gait(robot, (0.5, 0.0), 0.9)
    with pytest.raises(sf.ParameterError, match="`step_duration` above 0"):
        sf.nominal_gait(robot, (0.5, 0.0), "long")  # type: ignore[arg-type]
    # At 1 m/s a step of 0.5 m takes 0.5 s: longer ones do not fit.
    with pytest.raises(sf.ParameterError, match=r"\[0.2, 0.5\]"):
        sf.nominal_gait(robot, (1.0, 0.0), 0.6)


@given(robots, headings, fractions, sides)
def test_the_nominal_offset_is_viable(robot, heading, fraction, side) -> None:
    gait = sf.nominal_gait(robot, walkable(robot, heading, fraction))
    margin = sf.viable_offsets(robot, side).margin(gait.dcm_offset(side))
    assert margin > -1e-12
    assume(fraction < 0.9)
    assert margin > 0.0


FAST = [one for one in methods() if not one.slow and not one.leans and "mpc" not in one.key]
LONG = 60.0
"""Rounding grows a thousandfold in 2 s: by then it has fallen if nothing takes it back [s]."""


def random_robot(seed: int) -> sf.Robot:
    rng = np.random.default_rng(seed)
    height = rng.uniform(0.25, 1.2)
    time = math.sqrt(height / 9.81)
    shortest, hip = rng.uniform(0.6, 1.0) * time, rng.uniform(0.15, 0.4) * height
    return sf.Robot(
        name=f"random-{seed}",
        mass=rng.uniform(3.0, 120.0),
        com_height=height,
        hip=hip,
        foot=sf.Foot(length=rng.uniform(0.1, 0.3) * height, width=rng.uniform(0.05, 0.2) * height),
        gait=GaitLimits(
            step_duration=(shortest, rng.uniform(1.5, 4.0) * shortest),
            step_x=(-rng.uniform(0.2, 0.8) * height, rng.uniform(0.2, 0.8) * height),
            step_y=(-rng.uniform(0.1, 0.9) * hip, rng.uniform(0.2, 0.5) * height),
            dcm_offset=(0.1 * height, 0.05 * height),
        ),
    )


RANDOM_ROBOTS = [sf.load_robot("paper-biped"), *map(random_robot, range(4))]
HEADINGS = [0.0, 90.0, 180.0, 270.0, 25.0, 200.0]


@pytest.mark.parametrize("robot", RANDOM_ROBOTS, ids=lambda robot: robot.name)
def test_the_largest_speed_is_walked_for_ever(robot: sf.Robot) -> None:
    for heading in HEADINGS:
        x, y = math.cos(math.radians(heading)), math.sin(math.radians(heading))
        speed = sf.largest_speed(robot, (x, y))
        for one in FAST:
            controller = one.controller(robot, (speed * x, speed * y))
            (result,) = sf.simulate_batch(controller, [[]], LONG, workers=1)
            assert not result["fallen"], (one.key, heading)
            assert result["settled"], (one.key, heading)


@pytest.mark.parametrize("robot", RANDOM_ROBOTS, ids=lambda robot: robot.name)
def test_the_gait_at_the_largest_speed_has_room_for_rounding_and_no_more(robot) -> None:
    for heading in HEADINGS:
        x, y = math.cos(math.radians(heading)), math.sin(math.radians(heading))
        speed = sf.largest_speed(robot, (x, y))
        gait = sf.nominal_gait(robot, (speed * x, speed * y))
        rooms = []
        for side in sf.Side:
            step = np.array(gait.step(side))
            low, high = map(np.array, robot.gait.step_box(side, robot.hip))
            rooms += [*(step - low), *(high - step)]
        assert 0.0 < min(rooms) < 2e-7 * robot.com_height
        assert np.hypot(gait.step_length, gait.lateral_step) == pytest.approx(
            speed * gait.step_duration, rel=2e-7
        )


@pytest.mark.parametrize("speed", [0.7, 1.1])
def test_a_step_duration_that_ends_at_the_box_is_walked_for_ever(speed: float) -> None:
    """Not the largest speed, but the longest step: the same room."""
    robot = sf.load_robot("paper-biped")
    for make in (sf.DcmTracking, sf.StepTiming, sf.HybridController):
        controller = make(robot, (speed, 0.0), step_duration=0.5 / speed)
        (result,) = sf.simulate_batch(controller, [[]], LONG, workers=1)
        assert result["settled"]

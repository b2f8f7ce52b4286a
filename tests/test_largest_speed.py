"""What `largest_speed` says is walked for ever, by every compiled method, in every direction."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.control.registry import methods
from surefoot.robot.gait import GaitLimits

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


ROBOTS = [sf.load_robot("paper-biped"), *map(random_robot, range(4))]
HEADINGS = [0.0, 90.0, 180.0, 270.0, 25.0, 200.0]


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
def test_the_largest_speed_is_walked_for_ever(robot: sf.Robot) -> None:
    for heading in HEADINGS:
        x, y = math.cos(math.radians(heading)), math.sin(math.radians(heading))
        speed = sf.largest_speed(robot, (x, y))
        for one in FAST:
            controller = one.controller(robot, (speed * x, speed * y))
            (result,) = sf.simulate_batch(controller, [[]], LONG, workers=1)
            assert not result["fallen"], (one.key, heading)
            assert result["settled"], (one.key, heading)


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)
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

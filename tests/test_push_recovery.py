"""Golden numbers of the step-and-timing adaptation, and the protocol that finds them.

Reference: v = (0.5, 0) m/s, 0.2 s from 1.1 s, 70 kg, hip 0.2 m, unlimited leg, no ZMP motion,
weights (1, 1, 1, 1000, 1000): 213 / 263 / 131 / 93 N s forward, back, towards the swing foot, away
from it; tracking alone 28 / 28 / 15 / 15. Both were found by an independent prototype.
"""

from __future__ import annotations

import math

import pytest

import surefoot as sf
from surefoot.robot.robot import Swing

DIRECTIONS = {
    "forward": (1.0, 0.0),
    "back": (-1.0, 0.0),
    "towards the swing foot": (0.0, 1.0),
    "away from it": (0.0, -1.0),
}


@pytest.mark.parametrize(
    ("direction", "reference"), list(zip(DIRECTIONS, (213.0, 263.0, 131.0, 93.0), strict=True))
)
def test_step_and_timing_alone(robot_70kg: sf.Robot, direction: str, reference: float) -> None:
    controller = sf.HybridController(
        robot_70kg, (0.5, 0.0), threshold=0.0, offset_weight=(1000.0, 1000.0)
    )
    limit = sf.smallest_failing_push(controller, DIRECTIONS[direction])
    assert abs(limit.impulse - reference) <= 2.0
    assert limit.delta_v == pytest.approx(limit.impulse / 70.0)
    assert limit.fell


@pytest.mark.parametrize(
    ("direction", "reference"), list(zip(DIRECTIONS, (28.0, 28.0, 15.0, 15.0), strict=True))
)
def test_tracking_alone(robot_70kg: sf.Robot, direction: str, reference: float) -> None:
    limit = sf.smallest_failing_push(
        sf.DcmTracking(robot_70kg, (0.5, 0.0)), DIRECTIONS[direction], largest=60.0
    )
    assert abs(limit.impulse - reference) <= 2.0


def test_the_limits_scale_with_the_mass(robot: sf.Robot) -> None:
    """Delta v is the robot-independent figure: the mass cancels."""
    light, heavy = (
        sf.smallest_failing_push(
            sf.HybridController(robot.replace(mass=mass), (0.5, 0.0)),
            (0.0, -1.0),
            step=mass / 70.0,
        )
        for mass in (35.0, 140.0)
    )
    assert light.delta_v == pytest.approx(heavy.delta_v)


def test_left_is_right_in_the_mirror(robot: sf.Robot) -> None:
    controller = sf.HybridController(robot, (0.5, 0.0))
    here = sf.smallest_failing_push(controller, (0.0, 1.0), first_support=sf.Side.RIGHT)
    there = sf.smallest_failing_push(controller, (0.0, -1.0), first_support=sf.Side.LEFT)
    assert here.impulse == there.impulse


def test_the_limit_is_the_first_failure_not_any(robot: sf.Robot) -> None:
    controller = sf.HybridController(robot, (0.5, 0.0))
    limit = sf.smallest_failing_push(controller, (0.0, -1.0), step=5.0)
    for impulse in range(5, int(limit.impulse) + 1, 5):
        push = sf.Push(1.1, 0.2, (0.0, -impulse / 0.2))
        outcome = sf.simulate(controller, 9.3, [push]).outcome
        assert (outcome is sf.Outcome.RECOVERED) == (impulse < limit.impulse)


def test_a_gait_that_does_not_settle_unpushed_is_told_as_zero(robot: sf.Robot) -> None:
    # 0.44 m in 0.4 s are 2.1 m/s at their peak: this leg never gets there.
    crawling = robot.replace(swing=Swing(max_speed=0.3))
    limit = sf.smallest_failing_push(sf.HybridController(crawling, (0.5, 0.0)), (1.0, 0.0))
    assert limit.impulse == 0.0
    tiny = sf.smallest_failing_push(sf.DcmTracking(robot, (0.5, 0.0)), (1.0, 0.0), largest=0.5)
    assert tiny.impulse == math.inf


def test_a_scan_that_finds_no_failure_says_so(robot: sf.Robot) -> None:
    limit = sf.smallest_failing_push(sf.HybridController(robot, (0.5, 0.0)), (1.0, 0.0), largest=20)
    assert limit.impulse == math.inf
    assert limit.scanned == 20.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"direction": (0.0, 0.0)}, r"a direction \(x, y\) of some length"),
        ({"direction": (1.0, 0.0, 0.0)}, r"`direction` as a pair"),
        ({"direction": (math.nan, 0.0)}, "`direction`"),
        ({"direction": (1.0, 0.0), "step": 0.0}, r"`step` above 0 \[N s\]"),
        ({"direction": (1.0, 0.0), "duration": -1.0}, r"`duration` above 0 \[s\]"),
    ],
)
def test_a_scan_that_makes_no_sense(robot: sf.Robot, arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        sf.smallest_failing_push(sf.HybridController(robot, (0.5, 0.0)), **arguments)

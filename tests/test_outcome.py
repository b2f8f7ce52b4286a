"""The rules by which a walk has ended well, in the robot's own lengths and times."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec import structs

import surefoot as sf
from surefoot.robot.feet import Footstep
from surefoot.robot.gait import GaitLimits
from surefoot.rollout.outcome import (
    has_walked_on,
    recovery_time,
    settled_error,
    settled_rule,
)

ROBOT = sf.load_robot("paper-biped").replace(body=None)

WIDE = sf.Robot(
    name="wide",
    mass=24.0588,
    com_height=0.763652,
    hip=0.234147,
    foot=sf.Foot(length=0.228083, width=0.109355),
    gait=GaitLimits(
        step_duration=(0.125764, 0.834070),
        step_x=(-0.639605, 0.415233),
        step_y=(-0.227889, 0.464017),
        dcm_offset=(0.091469, 0.039874),
    ),
)
"""One of many random robots; its quick long steps save a DCM that is 1.7 m away."""


@pytest.mark.parametrize("share", [0.81, 0.9])
def test_a_walk_that_can_still_be_saved_has_not_fallen(share: float) -> None:
    """It was called a fall at 1.5 m, with more than half a metre to spare."""
    controller = sf.UnifiedController(WIDE, (0.0, 0.18))
    limit = sf.push_limit(
        WIDE, (-1.0, 0.0), velocity=(0.0, 0.18), elapsed=0.0, duration=0.005,
        support_side=sf.Side.LEFT, zmp_reach=WIDE.foot.half,
    ).impulse  # fmt: skip
    start = 2.0 * controller.gait.step_duration
    push = sf.Push(start, 0.005, (-share * limit / 0.005, 0.0))
    rollout = sf.simulate(controller, start + 3.0, [push], first_support=sf.Side.LEFT)
    away = np.hypot(*(rollout.dcm - rollout.support_foot).T)
    assert away.max() > 1.5
    assert rollout.outcome is not sf.Outcome.FELL


def test_the_rules_on_the_paper_biped_are_its_centimetres_and_seconds() -> None:
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    assert settled_error(controller) == pytest.approx(0.01, abs=1e-4)
    rule = settled_rule(ROBOT, (0.1, 0.0), 0.01)
    assert rule["deviation"][0] == pytest.approx(0.01, abs=1e-4)
    assert settled_rule(ROBOT, (0.6, 0.8), 0.01)["deviation"][0] == pytest.approx(0.02)
    assert recovery_time(controller) == pytest.approx(8.0, abs=1e-3)


def test_slow_steps_have_the_time_of_as_many_steps() -> None:
    slow = sf.UnifiedController(ROBOT, (0.3, 0.0), step_duration=0.8)
    assert recovery_time(slow) == pytest.approx(16.0 * 0.8)
    quick = sf.UnifiedController(ROBOT, (0.3, 0.0), step_duration=0.21)
    assert recovery_time(quick) == pytest.approx(28.0 / ROBOT.omega)


def test_a_gait_with_little_room_is_settled_within_little() -> None:
    usual, fast = (sf.HybridController(ROBOT, velocity) for velocity in ((0.5, 0.0), (2.4, 0.0)))
    assert settled_error(fast) < 0.6 * settled_error(usual)


def test_a_leg_that_cannot_step_has_the_room_of_one_without_limits() -> None:
    lopsided = ROBOT.replace(gait=structs.replace(ROBOT.gait, step_x=(-0.3, 0.5)))
    slow = sf.DcmTracking(lopsided.with_leg(max_speed=1e-3), (0.5, 0.0))
    assert settled_error(slow) == settled_error(sf.DcmTracking(lopsided, (0.5, 0.0)))


def steps(scale: float, late: float, away: float) -> list[Footstep]:
    """Ten steps of 0.5 s in the size 1; those after the fourth are late and away [s, m]."""
    made = []
    for index in range(10):
        pushed = index >= 4
        time = math.sqrt(scale)
        made.append(
            Footstep(
                index=index,
                side=sf.Side.RIGHT if index % 2 else sf.Side.LEFT,
                support_foot=(0.0, 0.0),
                start=time * 0.5 * index,
                duration=time * (0.5 + (late if pushed else 0.0)),
                landing=(0.0, 0.0),
                dcm_offset=(scale * (0.05 + (away if pushed else 0.0)), 0.0),
                adapted=False,
            )
        )
    return made


@pytest.mark.parametrize("scale", [1.0, 0.1, 4.0])
@pytest.mark.parametrize(
    ("late", "away", "back"),
    [(0.0, 0.0, True), (0.015, 0.025, True), (0.025, 0.0, False), (0.0, 0.035, False)],
)
def test_a_body_is_back_if_its_last_steps_are_as_before(
    scale: float, late: float, away: float, back: bool
) -> None:
    robot, time = ROBOT.scaled(length=scale), math.sqrt(scale)
    push = sf.Push(time * 1.9, time * 0.1, (10.0, 0.0))
    made = steps(scale, late, away)
    assert has_walked_on(robot, made, [push], time * 5.0) is back
    # After 16 / omega, 4.6 s of this robot, it has walked on in any case.
    assert has_walked_on(robot, made, [push], time * 6.6)

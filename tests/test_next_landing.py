"""Landings that can still be saved: the planned one is among them, and left mirrors right."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.dcm.frame_turn import turned
from surefoot.dcm.viability import viable_landings
from surefoot.interface import COMMAND, OBSERVATION
from surefoot.record import copy_array

ROBOTS = [sf.load_robot(name) for name in sf.preset_names()]
EVERY_ROBOT = pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)


def walk_of(robot: sf.Robot, first: sf.Side, push: tuple[float, float] = (0.0, 0.0)) -> sf.Rollout:
    controller = sf.UnifiedController(robot, (0.2, 0.0))
    pushes = [sf.Push(0.3, 0.1, push)] if any(push) else []
    return sf.simulate(controller, 1.5, pushes, first_support=first)


@pytest.fixture(scope="module")
def pushed(robot: sf.Robot) -> sf.Rollout:
    return walk_of(robot, sf.Side.LEFT, (150.0, 90.0))


def boxes(rollout: sf.Rollout) -> np.ndarray:
    rows = zip(rollout.observations, rollout.commands, strict=True)
    return np.array([viable_landings(rollout.robot, seen, answer) for seen, answer in rows])


@EVERY_ROBOT
def test_the_nominal_landing_can_always_be_saved(robot: sf.Robot) -> None:
    """At every cycle of a walk that nothing disturbs."""
    walk = walk_of(robot, sf.Side.LEFT)
    step = walk.commands["step_location"] - walk.support_foot
    box = boxes(walk)
    assert (box[:, 0] <= step + 1e-6).all()
    assert (step <= box[:, 1] + 1e-6).all()


@EVERY_ROBOT
def test_every_landing_is_one_the_gait_allows(robot: sf.Robot) -> None:
    walk = walk_of(robot, sf.Side.RIGHT, (0.0, 40.0))
    box, side = boxes(walk), walk.support_side
    gait = robot.gait
    assert (box[:, 0, 0] >= gait.step_x[0]).all()
    assert (box[:, 1, 0] <= gait.step_x[1]).all()
    width = np.sort(side[:, None] * box[:, :, 1], axis=1) - robot.hip
    there = (box[:, 1] > box[:, 0]).all(axis=1)
    assert (width[there, 0] >= gait.step_y[0] - 1e-12).all()
    assert (width[there, 1] <= gait.step_y[1] + 1e-12).all()


def test_the_box_shrinks_to_where_the_foot_is(robot: sf.Robot) -> None:
    """A leg of limited speed has fewer choices the later it is."""
    robot = robot.with_leg(max_speed=2.0)
    walk = walk_of(robot, sf.Side.LEFT)
    last = int(np.flatnonzero(np.diff(walk.support_side))[0])
    size = np.ptp(boxes(walk), axis=1)
    assert (size[last] < 0.02).all()
    assert (size[last // 2] > 0.1).all()


def test_left_mirrors_right(robot: sf.Robot, pushed: sf.Rollout) -> None:
    box, mirrored = boxes(pushed), boxes(walk_of(robot, sf.Side.RIGHT, (150.0, -90.0)))
    assert mirrored[:, :, 0] == pytest.approx(box[:, :, 0], abs=1e-9)
    assert mirrored[:, 0, 1] == pytest.approx(-box[:, 1, 1], abs=1e-9)
    assert mirrored[:, 1, 1] == pytest.approx(-box[:, 0, 1], abs=1e-9)


@pytest.mark.parametrize("angle", [0.3, -1.2, 0.5 * math.pi, 3.0])
def test_it_does_not_matter_where_north_is(pushed: sf.Rollout, angle: float) -> None:
    box = boxes(pushed)
    for row in range(0, len(box), 50):
        seen = turned(np.array([pushed.observations[row]], OBSERVATION), angle)[0]
        answer = turned(np.array([pushed.commands[row]], COMMAND), angle)[0]
        assert viable_landings(pushed.robot, seen, answer) == pytest.approx(box[row], abs=1e-9)


def test_a_shift_does_not_matter(pushed: sf.Rollout) -> None:
    box, row = boxes(pushed), 350
    seen = copy_array(np.array([pushed.observations[row]], OBSERVATION))
    answer = copy_array(np.array([pushed.commands[row]], COMMAND))
    for name in ("com", "dcm", "support_foot", "swing_foot"):
        seen[name][0, :2] += (3.0, -2.0)
    for name in ("zmp", "step_location"):
        answer[name][0] += (3.0, -2.0)
    assert viable_landings(pushed.robot, seen[0], answer[0]) == pytest.approx(box[row], abs=1e-9)


@pytest.mark.parametrize("away", [(2.0, 0.0), (-2.0, 0.0), (0.0, 2.0), (0.0, -2.0)])
def test_a_dcm_far_away_cannot_be_saved(pushed: sf.Rollout, away: tuple[float, float]) -> None:
    seen = copy_array(np.array([pushed.observations[100]], OBSERVATION))
    seen["dcm"][0] += away
    low, high = viable_landings(pushed.robot, seen[0], pushed.commands[100])
    assert not (high > low).all()

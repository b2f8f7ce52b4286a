"""Dynamic similarity of bodies: a robot of another size walks alike, in its own units."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from scaled_body import scaled_biped
from scales import UNITY, Scale
from surefoot.robot.own_units import OwnUnits

SIZES = [Scale(0.3, 0.027), Scale(2.0, 8.0), Scale(0.5, 1.5)]
DURATION, PUSHED_DURATION, SPEED = 6.0, 7.5, 0.3
"""Of the walks, in the time and length of the paper's biped [s, s, m/s]. One with a push ends later
than 16 / omega after it: before that, what 1 ms is of their time decides whether the last steps are
like those before the push."""


@dataclass(frozen=True)
class Walk:
    """What a walk was like, in the units of the paper's biped."""

    rollout: sf.Rollout
    outcome: sf.Outcome
    steps: int
    speed: float
    duration: float


def control_of(robot: sf.Robot, size: Scale) -> sf.BodyControl:
    multibody = sf.load_multibody(robot)
    believed = sf.walking_robot(multibody)
    controller = sf.body_controller("unified", believed, (SPEED * size.time, 0.0))
    return sf.body_control(controller, multibody)


def walk(
    folder: Path, size: Scale, impulse: tuple[float, float] | None = None, **senses: Any
) -> Walk:
    """Walk the paper's biped in another size; an impulse is in the paper's biped's [N s]."""
    control = control_of(scaled_biped(folder, size), size)
    pushes, duration = [], DURATION
    if impulse is not None:
        duration = PUSHED_DURATION
        force = (size.mass * impulse[0] / 0.2, size.mass * impulse[1] / 0.2)
        pushes = [sf.Push(2.5 * size.time, 0.2 * size.time, force)]
    rollout = sf.simulate_body(control, duration * size.time, pushes, **senses)
    assert rollout.body is not None
    way = float(rollout.body.com[-1, 0]) / size.length
    steps = rollout.footsteps
    mean = float(np.mean([step.duration for step in steps])) / size.time if steps else 0.0
    return Walk(rollout, rollout.outcome, len(steps), way / duration, mean)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("sizes")


@pytest.fixture(scope="module")
def usual(folder: Path) -> Walk:
    return walk(folder, UNITY, estimator="truth")


@pytest.fixture(scope="module")
def pushed(folder: Path) -> Walk:
    return walk(folder, UNITY, (50.0, 0.0), estimator="truth")


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_robots_of_all_sizes_walk_alike(folder: Path, usual: Walk, size: Scale) -> None:
    """To what 1 ms of control is of their time: 0.2 % of a step's duration for the smallest."""
    other = walk(folder, size, estimator="truth")
    assert (other.outcome, other.steps) == (usual.outcome, usual.steps)
    assert other.outcome is sf.Outcome.WALKED
    assert other.speed == pytest.approx(usual.speed, rel=0.01)
    assert other.duration == pytest.approx(usual.duration, rel=0.01)


@pytest.mark.parametrize("size", SIZES[:2], ids=str)
def test_robots_of_all_sizes_bear_the_same_push(folder: Path, pushed: Walk, size: Scale) -> None:
    other = walk(folder, size, (50.0, 0.0), estimator="truth")
    assert (other.outcome, other.steps) == (pushed.outcome, pushed.steps)
    assert other.outcome is not sf.Outcome.FELL
    assert other.speed == pytest.approx(pushed.speed, rel=0.02)


@pytest.mark.parametrize("size", SIZES[:2], ids=str)
def test_robots_of_all_sizes_walk_alike_on_their_sensors(
    folder: Path, usual: Walk, size: Scale
) -> None:
    """Encoders and inertial units are the same for all, load cells are chosen for the weight."""
    other = walk(folder, size)
    assert (other.outcome, other.steps) == (usual.outcome, usual.steps)
    assert other.speed == pytest.approx(usual.speed, rel=0.02)


def test_what_a_file_does_not_say_follows_from_the_robot(folder: Path) -> None:
    """As little as a robot's file has to say: a walk of the default speed limits of its leg."""
    size = Scale(0.3, 0.027)
    robot = scaled_biped(folder, size, own_gait=False)
    believed = sf.walking_robot(sf.load_multibody(robot))
    own, large = (
        OwnUnits.of(robot),
        sf.walking_robot(sf.load_multibody(sf.load_robot("paper-biped"))),
    )
    assert believed.swing.height / own.length == pytest.approx(large.swing.height / 0.8, rel=1e-3)
    assert believed.swing.max_speed == pytest.approx(4.0 * size.time, rel=0.01)
    assert believed.gait.step_duration[0] == pytest.approx(0.2 * size.time, rel=0.01)
    rollout = sf.simulate_body(control_of(robot, size), 6.0 * size.time)
    assert rollout.outcome is sf.Outcome.WALKED
    assert len(rollout.footsteps) >= 14


def test_own_units_are_those_of_a_pendulum() -> None:
    robot = sf.load_robot("paper-biped")
    own = OwnUnits.of(robot)
    assert own.acceleration == pytest.approx(robot.gravity, rel=1e-12)
    assert own.force == pytest.approx(robot.mass * robot.gravity, rel=1e-12)
    assert own.speed == pytest.approx((robot.gravity * robot.com_height) ** 0.5, rel=1e-12)
    assert own.one("rad/s^2") == pytest.approx(robot.omega**2, rel=1e-12)

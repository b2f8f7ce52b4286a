"""Dynamic similarity of every method but the unified one: a scaled robot decides alike."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

import surefoot as sf
from surefoot.control.registry import methods

BASE = sf.load_robot("paper-biped").with_leg(max_speed=4.0)
RIVALS = [one for one in methods() if one.key != "unified" and not one.leans]


def similar(robot: sf.Robot, scale: float, heavier: float) -> sf.Robot:
    """Lengths times scale, times by its root, masses times heavier."""
    slower = math.sqrt(scale)

    def times(pair: tuple[float, float], factor: float) -> tuple[float, float]:
        return pair[0] * factor, pair[1] * factor

    return robot.replace(
        mass=heavier * robot.mass,
        com_height=scale * robot.com_height,
        hip=scale * robot.hip,
        foot=sf.Foot(length=scale * robot.foot.length, width=scale * robot.foot.width),
        trunk=None,
        gait=msgspec.structs.replace(
            robot.gait,
            step_duration=times(robot.gait.step_duration, slower),
            step_x=times(robot.gait.step_x, scale),
            step_y=times(robot.gait.step_y, scale),
            dcm_offset=times(robot.gait.dcm_offset, scale),
        ),
        swing=msgspec.structs.replace(
            robot.swing,
            height=scale * robot.swing.height,
            max_speed=slower * robot.swing.max_speed,
        ),
    )


def walked(one, scale: float, heavier: float, impulse: float) -> sf.Rollout:
    slower, robot = math.sqrt(scale), similar(BASE, scale, heavier)
    period = slower * (0.005 if "mpc" in one.key else 0.001)
    controller = one.controller(robot, (0.4 * slower, 0.1 * slower), period=period)
    force = heavier * impulse / 0.2
    push = sf.Push(1.13 * slower, 0.2 * slower, (0.8 * force, 0.6 * force))
    return sf.simulate(controller, 2.2 * slower, [push])


@pytest.mark.parametrize("one", RIVALS, ids=lambda one: one.key)
def test_similar_robots_decide_alike(one) -> None:
    # What moves the ZMP alone stands no more than the smaller push.
    impulse = 15.0 if one.fixed_steps else 45.0
    own = walked(one, 1.0, 1.0, impulse)
    for scale, heavier in ((0.1, 100.0), (0.4, 0.5), (1.5, 0.01)):
        other, slower = walked(one, scale, heavier, impulse), math.sqrt(scale)
        # Rounding of the time decides about the last cycle.
        count = min(len(own.time), len(other.time))
        assert abs(len(own.time) - len(other.time)) <= 1
        for name, unit in (("zmp", scale), ("step_location", scale), ("step_duration", slower)):
            mine, theirs = own.commands[name][:count], other.commands[name][:count] / unit
            assert np.abs(mine - theirs).max() < 1e-9, (name, scale)


@pytest.mark.parametrize("make", [sf.HybridController, sf.StepTiming, sf.TimingNlp])
def test_what_is_left_out_follows_the_gait_and_what_is_given_stays(make) -> None:
    made = make(BASE, (0.5, 0.0))
    slow = made.with_velocity((0.2, 0.1))
    assert slow == make(BASE, (0.2, 0.1))
    assert slow.tau_weight != made.tau_weight
    given = make(BASE, (0.5, 0.0), tau_weight=3.0)
    assert given.with_velocity((0.2, 0.1)).tau_weight == 3.0


def test_the_defaults_are_those_of_the_papers_biped() -> None:
    hybrid = sf.HybridController(sf.load_robot("paper-biped"), (0.5, 0.0))
    assert hybrid.dcm_gain == pytest.approx(3.0, rel=1e-3)
    assert hybrid.threshold == pytest.approx(0.025, rel=0.01)
    assert hybrid.tau_weight == pytest.approx(1.0, rel=0.01)

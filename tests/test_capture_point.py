"""Stepping onto the capture point: dead beat, in time, with the ZMP under the sole."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.robot.robot import Swing

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)


def push(impulse_x: float, impulse_y: float) -> sf.Push:
    """For 0.2 s in the third step, like the paper's."""
    return sf.Push(1.1, 0.2, (impulse_x / 0.2, impulse_y / 0.2))


@pytest.fixture(params=[False, True], ids=["point-foot", "ankle"])
def controller(request) -> sf.CapturePointStepping:
    return sf.CapturePointStepping(ROBOT, (0.5, 0.0), ankle=request.param)


@pytest.mark.parametrize("impulse", [(15.0, 0.0), (-30.0, 0.0), (0.0, 15.0), (5.0, -10.0)])
def test_one_step_ends_an_error(controller: sf.CapturePointStepping, impulse) -> None:
    """Dead beat: pushed in the third step, it lands with the nominal offset and walks on."""
    rollout = sf.simulate(controller, 3.0, [push(*impulse)])
    error = np.abs(rollout.dcm_error).max(axis=1)
    assert error.max() > 0.01
    for step in rollout.footsteps:
        d_nom = controller.gait.dcm_offset(step.side)
        assert step.dcm_offset == pytest.approx(d_nom, abs=1e-9)
    assert error[rollout.time >= 1.5].max() < 1e-9


def test_the_sole_comes_first_and_the_step_does_the_rest() -> None:
    """What the ZMP can do alone moves no foot; a foot that moves had its ZMP at the edge."""
    controller = sf.CapturePointStepping(ROBOT, (0.5, 0.0))
    small = sf.simulate(controller, 3.0, [push(6.0, 3.0)])
    for step in small.footsteps:
        assert step.step == pytest.approx(controller.gait.step(step.side), abs=1e-9)
    large = sf.simulate(controller, 3.0, [push(40.0, 0.0)])
    third = (large.time >= 1.3) & (large.time < 1.5)
    assert large.footsteps[2].step[0] > controller.gait.step_length + 0.05
    edge = large.support_foot[third, 0] + ROBOT.foot.half[0]
    assert large.zmp[third, 0] == pytest.approx(edge, abs=1e-12)
    status = large.commands["status"][third]
    assert (status & int(sf.Status.ZMP_AT_EDGE) != 0).all()


def test_the_offset_that_is_announced_is_the_one_that_comes(
    controller: sf.CapturePointStepping,
) -> None:
    """From the end of the push on, also where the box clips the step."""
    rollout = sf.simulate(controller, 2.0, [push(50.0, 0.0)])
    third = (rollout.time >= 1.3 + 1e-9) & (rollout.time < 1.5 - 1e-9)
    announced = rollout.commands["dcm_offset"][third]
    found = rollout.footsteps[2].dcm_offset
    assert found[0] > controller.gait.dcm_offset(sf.Side.RIGHT)[0] + 0.02
    assert announced == pytest.approx(np.broadcast_to(found, announced.shape), abs=1e-9)


def test_a_leg_that_is_too_slow_is_flagged() -> None:
    slow = ROBOT.replace(swing=Swing(max_speed=1.2))
    rollout = sf.simulate(sf.CapturePointStepping(slow, (0.5, 0.0)), 3.0, [push(50.0, 0.0)])
    flagged = rollout.commands["status"] & int(sf.Status.UNREACHABLE) != 0
    assert flagged[(rollout.time > 1.1) & (rollout.time < 1.5)].any()
    assert not flagged[rollout.time < 1.1].any()


def test_a_foot_that_is_late_is_flagged() -> None:
    controller = sf.CapturePointStepping(ROBOT, (0.5, 0.0))
    late = controller.first_observation().replace(elapsed=0.6, time=0.6)
    command, _ = controller.step(controller.start(late), late)
    assert sf.Status.NO_TIME_LEFT in command.status
    assert command.step_duration == 0.6

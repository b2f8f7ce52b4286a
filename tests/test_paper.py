"""The situations that the paper reports, on its robot with the 70 kg of its abstract."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf

GAIT = sf.nominal_gait(sf.load_robot("paper-biped"), (0.5, 0.0))


def walk(robot: sf.Robot, *pushes: sf.Push, duration: float = 8.0, **parameters) -> sf.Rollout:
    return sf.simulate(sf.HybridController(robot, (0.5, 0.0), **parameters), duration, pushes)


def test_fig_9_the_third_step_takes_the_push(pushed_walk: sf.Rollout) -> None:
    """176 N for 0.2 s from 1.1 s: a short third step, and d is nominal again at its end."""
    first, second, third, fourth = pushed_walk.footsteps[:4]
    assert first.duration == pytest.approx(0.5)
    assert second.duration == pytest.approx(0.5)
    assert third.adapted
    assert third.duration < 0.45
    assert third.step[0] == pytest.approx(0.5)  # the longest step
    assert np.abs(np.subtract(third.dcm_offset, GAIT.dcm_offset(third.side))).max() < 1e-3
    assert not fourth.adapted
    assert fourth.duration == pytest.approx(0.5)
    assert pushed_walk.outcome is sf.Outcome.RECOVERED


def test_fig_9_with_small_constant_pushes_in_every_step(robot_70kg: sf.Robot) -> None:
    """Tracking takes care of the small forces, before and after the large one."""
    small = sf.Push(0.0, 7.0, (8.0, 5.0))
    rollout = walk(robot_70kg, small, sf.Push(1.1, 0.2, (176.0, 0.0)), duration=10.0)
    steps = rollout.footsteps
    assert [step.adapted for step in steps[:6]] == [False, False, True, False, False, False]
    assert steps[2].duration < 0.45
    d_error = np.subtract(steps[2].dcm_offset, GAIT.dcm_offset(steps[2].side))
    assert np.abs(d_error).max() < 1e-3
    tracking = rollout.dcm_error[(rollout.time > 3.0) & (rollout.time < 7.0)]
    assert np.hypot(*tracking.T).max() < 0.025
    assert rollout.zmp_excess.max() == 0.0
    assert rollout.outcome is sf.Outcome.RECOVERED


@pytest.mark.parametrize("offset_weight", [(20000.0, 1000.0), (100.0, 100.0), (10.0, 10.0)])
def test_fig_11_several_steps_bring_velocity_and_offset_back(robot_70kg, offset_weight) -> None:
    """411.6 N for 0.2 s: the longest step at the third, then several steps to recover."""
    push = sf.Push(1.1, 0.2, (411.6, 0.0))
    rollout = walk(robot_70kg, push, offset_weight=offset_weight)
    steps = rollout.footsteps
    lengths = [step.step[0] for step in steps]
    assert lengths[2] == max(lengths)
    assert sum(step.adapted for step in steps) >= 2
    assert rollout.outcome is sf.Outcome.RECOVERED
    assert steps[-1].dcm_offset == pytest.approx(GAIT.dcm_offset(steps[-1].side), abs=1e-3)
    assert rollout.final_velocity == pytest.approx((0.5, 0.0), abs=0.01)


@pytest.mark.parametrize(
    ("impulse", "along"),
    [(70.56, (1.0, 0.0)), (58.8, (0.0, 1.0)), (58.8, (0.0, -1.0)), (85.0, (1.0, 0.0))],
)
def test_the_impulses_that_the_paper_claims(robot_70kg: sf.Robot, impulse: float, along) -> None:
    """With the paper's unlimited leg speed."""
    push = sf.Push(1.1, 0.2, (impulse * along[0] / 0.2, impulse * along[1] / 0.2))
    assert walk(robot_70kg, push).outcome is sf.Outcome.RECOVERED


def test_small_weights_on_the_offset_end_in_a_limit_cycle(robot_70kg: sf.Robot) -> None:
    """Section IV-B: the offset must dominate; with equal weights even 1 N s is not forgotten."""
    push = sf.Push(1.1, 0.2, (5.0, 0.0))
    equal = walk(robot_70kg, push, threshold=0.0, offset_weight=(1.0, 1.0))
    heavy = walk(robot_70kg, push, threshold=0.0)
    assert equal.outcome is sf.Outcome.UNSETTLED
    assert heavy.outcome is sf.Outcome.RECOVERED

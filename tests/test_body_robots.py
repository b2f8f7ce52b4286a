"""The robots whose data come in packages walk, hold their course and are pushed."""

from __future__ import annotations

import math

import pytest

import surefoot as sf


@pytest.fixture(scope="module", params=["g1", "h1", "talos"])
def control(request: pytest.FixtureRequest) -> sf.BodyControl:
    multibody = sf.load_multibody(sf.load_robot(request.param))
    believed = sf.walking_robot(multibody)
    return sf.body_control(sf.body_controller("unified", believed, (0.3, 0.0)), multibody)


def test_it_holds_speed_course_and_heading(control: sf.BodyControl) -> None:
    """Told by noisy sensors, the gyroscope's offset of 0.24 deg/s included: 3.6 deg in the walk."""
    rollout = sf.simulate_body(control, duration=15.0)
    assert rollout.outcome is sf.Outcome.WALKED
    assert rollout.body is not None
    measures = sf.measure_body(rollout, rollout.body)
    assert measures.speed == pytest.approx((0.3, 0.0), abs=0.02)
    assert measures.lateral_drift == pytest.approx(0.0, abs=0.07)
    assert measures.heading_error == pytest.approx(0.0, abs=math.radians(1.2))
    assert measures.estimate["dcm"] < 0.004
    assert measures.knees is not None
    assert all(0.12 < low < high < 1.6 for low, high in measures.knees)
    assert measures.clearance is not None
    assert measures.clearance[0] > 0.01
    assert measures.scuffs == 0
    assert max(measures.torque_part.values()) < 1.0


@pytest.mark.parametrize("direction", [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_it_walks_on_after_a_push(control: sf.BodyControl, direction: tuple[float, float]) -> None:
    """Of 0.5 m/s, as much as most public stacks survive."""
    force = 0.5 * control.multibody.mass / 0.2
    push = sf.Push(3.0, 0.2, (force * direction[0], force * direction[1]))
    rollout = sf.simulate_body(control, 8.3, [push], estimator="truth")
    assert rollout.outcome is sf.Outcome.RECOVERED

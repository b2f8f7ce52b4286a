"""Inverse kinematics: a body that is shown walking is where the walk is."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.robot.multibody import Multibody
from surefoot.show.body_playback import play_back
from surefoot.worlds.body.interface import BODY_REFERENCE
from surefoot.worlds.body.inverse_kinematics import InverseKinematics
from surefoot.worlds.body.mechanics import Mechanics


@pytest.fixture(scope="module")
def multibody(robot: sf.Robot) -> Multibody:
    return sf.load_multibody(robot)


def test_playback_is_where_the_walk_is(multibody: Multibody) -> None:
    controller = sf.HybridController(sf.walking_robot(multibody), (0.3, 0.0))
    rollout = sf.simulate(controller, 2.0)
    positions, mechanics = play_back(rollout, multibody), Mechanics(multibody)
    still = np.zeros(multibody.model.nv)
    for cycle in range(0, len(positions), 40):
        mechanics.update(positions[cycle], still)
        stance = 0 if rollout.support_side[cycle] == sf.Side.LEFT else 1
        places = mechanics.sole_position
        assert places[stance, :2] == pytest.approx(rollout.support_foot[cycle], abs=1e-3)
        # One cycle late: the foot is at 1.2 m/s at most.
        assert places[1 - stance] == pytest.approx(rollout.swing_foot[cycle], abs=3e-3)
        assert mechanics.com[:2] == pytest.approx(rollout.com[cycle], abs=4e-3)
        assert mechanics.com[2] == pytest.approx(rollout.robot.com_height, abs=4e-3)
        assert mechanics.base_axes[2, 2] > 0.999


def test_a_body_in_place_stays(multibody: Multibody) -> None:
    mechanics, reference = Mechanics(multibody), np.zeros(1, BODY_REFERENCE)
    reference["stands"], reference["com"] = 1, mechanics.com
    command = InverseKinematics(multibody).joints(mechanics, reference)
    assert np.abs(command.velocity).max() < 1e-9
    assert command.position == pytest.approx(multibody.nominal[multibody.motor_positions])


def test_servos_stay_within_their_ranges(multibody: Multibody) -> None:
    mechanics, reference = Mechanics(multibody), np.zeros(1, BODY_REFERENCE)
    reference["stands"], reference["com"] = 1, mechanics.com
    reference["com"][0, 2] += 5.0
    command = InverseKinematics(multibody, period=1.0).joints(mechanics, reference)
    ranges = multibody.model.jnt_range[multibody.motors]
    assert np.all(command.position >= ranges[:, 0])
    assert np.all(command.position <= ranges[:, 1])


def test_a_rate_that_is_nothing_is_refused(multibody: Multibody) -> None:
    with pytest.raises(sf.ParameterError, match="rate"):
        InverseKinematics(multibody, rate=0.0)

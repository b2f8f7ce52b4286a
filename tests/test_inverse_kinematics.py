"""Inverse kinematics: a body that is shown walking is where the walk is."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

import surefoot as sf
from surefoot.record import new_array
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.interface import BODY_REFERENCE
from surefoot.worlds.body.inverse_kinematics import InverseKinematics
from surefoot.worlds.body.mechanics import Mechanics

SETTLING = 200
"""Cycles on the spot before the first, from the nominal pose."""


def play_back(rollout: sf.Rollout, multibody: Multibody) -> NDArray[np.float64]:
    """Generalised positions of a body that walks like the point mass.

    Args:
        rollout: of the point mass, at the period of 1 ms.
        multibody: the body; its hips should be as far apart as the robot's of the walk.

    Returns:
        Shape (n, nq), one row a cycle of the walk.
    """
    model, kinematics = multibody.model, InverseKinematics(multibody)
    mechanics, reference = Mechanics(multibody), new_array(BODY_REFERENCE)
    position = multibody.nominal.copy()
    stance = _stance(rollout.observations[0])
    position[:2] += rollout.support_foot[0] - mechanics.sole_position[stance, :2]
    positions = np.empty((len(rollout.time), model.nq))
    for cycle in range(-SETTLING, len(rollout.time)):
        _refer(rollout, max(cycle, 0), reference)
        mechanics.update(position, np.zeros(model.nv))
        velocity = kinematics.velocity(mechanics, reference)
        mujoco.mj_integratePos(model, position, velocity, kinematics.period)
        if cycle >= 0:
            positions[cycle] = position
    return positions


def _stance(seen: np.void) -> int:
    """The foot that carries, as a row of tables with a row for each foot."""
    return 0 if seen["support_side"] == sf.Side.LEFT else 1


def _refer(rollout: sf.Rollout, cycle: int, reference: NDArray[np.void]) -> None:
    seen, ref = rollout.observations[cycle], reference[0]
    ref["stands"] = 0
    ref["com"][:2], ref["com"][2] = seen["com"], rollout.robot.com_height
    ref["com_velocity"][:2] = seen["com_velocity"]
    ref["swing_foot"], ref["swing_yaw"] = seen["swing_foot"], seen["swing_yaw"]
    ref["swing_foot_velocity"] = seen["swing_foot_velocity"]
    ref["stands"][_stance(seen)] = 1
    ref["trunk"][2] = 0.5 * (seen["support_yaw"] + seen["swing_yaw"])


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

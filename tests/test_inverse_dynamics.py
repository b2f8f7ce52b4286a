"""Whole-body inverse dynamics: the motion is the mechanism's own, and no limit is passed."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

import surefoot as sf
from body_states import assert_within_limits, mirrored, random_reference, random_state
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.interface import BODY_REFERENCE
from surefoot.worlds.body.inverse_dynamics import InverseDynamics
from surefoot.worlds.body.mechanics import Mechanics

SEEDS = range(12)
UNUSED = np.zeros(2)
"""Forces on the soles, which inverse dynamics does not ask for."""


@pytest.mark.parametrize("stands", [(1, 0), (0, 1), (1, 1)])
@pytest.mark.parametrize("seed", SEEDS)
def test_the_motion_is_the_mechanisms_own(
    multibody: Multibody, seed: int, stands: tuple[int, int]
) -> None:
    mapping, mechanics = InverseDynamics(multibody), Mechanics(multibody)
    mechanics.update(*random_state(multibody, seed))
    command, _ = mapping.joints(mechanics, random_reference(seed, stands), UNUSED, {})
    answer = mapping.answer()
    force = np.zeros(multibody.model.nv)
    for wrench, side in zip(answer.wrenches, np.flatnonzero(stands), strict=True):
        axes, jacobian = mechanics.sole_axes[side], mechanics.sole_jacobian[side]
        force += jacobian[:3].T @ (axes @ wrench[:3]) + jacobian[3:].T @ (axes @ wrench[3:])
    residual = mechanics.inertia @ answer.acceleration + mechanics.bias - force
    residual[multibody.motor_dofs] -= command.torque
    assert command.status >= 1
    assert np.abs(residual[multibody.passive_dofs]).max() < 1e-9
    # A motor at its limit gives no more than that, where the solver is off by its tolerance.
    limited = np.abs(command.torque) > multibody.torque * (1.0 - 1e-6)
    assert np.abs(residual[multibody.motor_dofs][~limited]).max() < 1e-6
    assert np.abs(residual).max() < 1e-4


@pytest.mark.parametrize("stands", [(1, 0), (0, 1), (1, 1)])
@pytest.mark.parametrize("seed", SEEDS)
def test_friction_soles_and_torques_are_respected(
    multibody: Multibody, seed: int, stands: tuple[int, int]
) -> None:
    mapping, mechanics = InverseDynamics(multibody, friction=0.5), Mechanics(multibody)
    mechanics.update(*random_state(multibody, seed))
    command, _ = mapping.joints(mechanics, random_reference(seed, stands), UNUSED, {})
    assert_within_limits(multibody, mapping, mechanics, command.torque, 1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_left_and_right_are_the_same(multibody: Multibody, seed: int) -> None:
    mechanics, reference = Mechanics(multibody), random_reference(seed, (1, 0))
    position, velocity = random_state(multibody, seed)
    mechanics.update(position, velocity)
    torque = InverseDynamics(multibody).joints(mechanics, reference, UNUSED, {})[0].torque.copy()
    mirror = reference.copy()
    mirror["stands"] = (0, 1)
    for name in ("zmp", "com_acceleration", "swing_foot", "swing_foot_acceleration"):
        mirror[name][0, 1] *= -1.0
    mechanics.update(mirrored(multibody, position, False), mirrored(multibody, velocity, True))
    other = InverseDynamics(multibody).joints(mechanics, mirror, UNUSED, {})[0].torque
    names = multibody.joint_names
    for number, name in enumerate(names):
        side, partner = ("left", "right") if name.startswith("left") else ("right", "left")
        sign = -1.0 if "roll" in name or "yaw" in name else 1.0
        expected = sign * torque[names.index(name.replace(side, partner))]
        assert other[number] == pytest.approx(expected, abs=1e-6)


def test_the_soles_jacobian_is_the_derivative_of_their_place(multibody: Multibody) -> None:
    mechanics = Mechanics(multibody)
    position, velocity = random_state(multibody, 3)
    mechanics.update(position, velocity)
    speed, drift = mechanics.sole_velocity.copy(), mechanics.sole_drift.copy()
    com_velocity, step = mechanics.com_velocity.copy(), 1e-6
    places, speeds, coms = [], [], []
    for sign in (-1.0, 1.0):
        moved = position.copy()
        mujoco.mj_integratePos(multibody.model, moved, velocity, sign * step)
        mechanics.update(moved, velocity)
        places.append(mechanics.sole_position.copy())
        speeds.append(mechanics.sole_velocity.copy())
        coms.append(mechanics.com.copy())
    assert (places[1] - places[0]) / (2 * step) == pytest.approx(speed[:, :3], abs=1e-6)
    assert (speeds[1] - speeds[0]) / (2 * step) == pytest.approx(drift, abs=1e-5)
    assert (coms[1] - coms[0]) / (2 * step) == pytest.approx(com_velocity, abs=1e-6)


def test_a_standing_body_carries_its_weight(multibody: Multibody) -> None:
    mapping, reference = InverseDynamics(multibody), np.zeros(1, BODY_REFERENCE)
    reference["stands"] = 1
    mapping.joints(Mechanics(multibody), reference, UNUSED, {})
    weight = multibody.mass * 9.80665
    assert mapping.answer().wrenches[:, 2].sum() == pytest.approx(weight, rel=1e-3)


def test_a_weight_that_is_not_known_is_refused(multibody: Multibody) -> None:
    with pytest.raises(sf.ParameterError, match="swing_height"):
        InverseDynamics(multibody, weights={"swing_hight": 1.0})

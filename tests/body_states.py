"""States and references of a body that tests of its mappings share."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.robot.motors import torque_range
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.interface import BODY_REFERENCE
from surefoot.worlds.body.mechanics import Mechanics


def random_state(
    multibody: Multibody, seed: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rng, model = np.random.default_rng(seed), multibody.model
    position, velocity = multibody.nominal.copy(), rng.normal(0.0, 0.4, model.nv)
    mujoco.mj_integratePos(model, position, rng.normal(0.0, 0.15, model.nv), 1.0)
    return position, velocity


def random_reference(seed: int, stands: tuple[int, int]) -> NDArray[np.void]:
    rng, reference = np.random.default_rng(100 + seed), np.zeros(1, BODY_REFERENCE)
    reference["stands"] = stands
    reference["zmp"] = rng.uniform(-0.1, 0.1, 2)
    reference["com_acceleration"] = rng.uniform(-3.0, 3.0, 3)
    reference["swing_foot"] = rng.uniform((-0.3, -0.3, 0.0), (0.3, 0.3, 0.1))
    reference["swing_foot_acceleration"] = rng.uniform(-30.0, 30.0, 3)
    return reference


def assert_within_limits(
    multibody: Multibody, mapping: Any, mechanics: Mechanics, torques: Any, tolerance: float
) -> None:
    """Soles push, within friction and their size; motors are within torque and speed.

    Args:
        tolerance: of the wrenches [N, N m].
    """
    half = np.array(multibody.robot.foot.half) * mapping.sole_part
    for wrench in mapping.answer().wrenches:
        up = wrench[2]
        assert up > -tolerance
        assert np.abs(wrench[:2]).max() <= mapping.friction * up + tolerance
        assert abs(wrench[3]) <= half[1] * up + tolerance
        assert abs(wrench[4]) <= half[0] * up + tolerance
    for torque, most, dof, limit in zip(
        torques, multibody.torque, multibody.motor_dofs, multibody.speed, strict=True
    ):
        low, high = torque_range(most, mechanics.velocity[dof], limit)
        assert low - 1e-6 <= torque <= high + 1e-6


def mirrored(multibody: Multibody, vector: NDArray[np.float64], dofs: bool) -> NDArray[np.float64]:
    """A state or velocity with left and right exchanged."""
    out, model = vector.copy(), multibody.model
    first = 6 if dofs else 7
    if dofs:
        out[[1, 3, 5]] *= -1.0
    else:
        out[1] *= -1.0
        out[[4, 6]] *= -1.0
    for joint in range(1, model.njnt):
        name = model.joint(joint).name
        side, other = ("left", "right") if name.startswith("left") else ("right", "left")
        partner = model.joint(name.replace(side, other)).id
        turns = "roll" in name or "yaw" in name
        where = model.jnt_dofadr if dofs else model.jnt_qposadr
        assert where[joint] >= first
        out[where[partner]] = vector[where[joint]] * (-1.0 if turns else 1.0)
    return out

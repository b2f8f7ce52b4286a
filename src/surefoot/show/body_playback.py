"""A walk of the point mass, shown on a body: the joints follow by inverse kinematics.

No physics: soles are where the walk has them, and the CoM is where the pendulum is.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.multibody import Multibody
from surefoot.rollout.rollout import Rollout
from surefoot.worlds.body.interface import BODY_REFERENCE
from surefoot.worlds.body.inverse_kinematics import InverseKinematics
from surefoot.worlds.body.mechanics import Mechanics

SETTLING = 200
"""Cycles on the spot before the first, from the nominal pose."""


def play_back(rollout: Rollout, multibody: Multibody) -> NDArray[np.float64]:
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
    return 0 if seen["support_side"] == Side.LEFT else 1


def _refer(rollout: Rollout, cycle: int, reference: NDArray[np.void]) -> None:
    seen, ref = rollout.observations[cycle], reference[0]
    ref["stands"] = 0
    ref["com"][:2], ref["com"][2] = seen["com"], rollout.robot.com_height
    ref["com_velocity"][:2] = seen["com_velocity"]
    ref["swing_foot"], ref["swing_yaw"] = seen["swing_foot"], seen["swing_yaw"]
    ref["swing_foot_velocity"] = seen["swing_foot_velocity"]
    ref["stands"][_stance(seen)] = 1
    ref["trunk"][2] = 0.5 * (seen["support_yaw"] + seen["swing_yaw"])

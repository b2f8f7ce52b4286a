"""Geometry of a mechanism's legs, found in its model: hips, knees, ankles."""

from __future__ import annotations

import math
from typing import NamedTuple

import mujoco
import numpy as np

from surefoot.errors import RobotError
from surefoot.robot.multibody import Multibody

MOSTLY = 0.8
"""An axis with more than this part along y pitches."""

JOINTS_THAT_PITCH = 3


class Legs(NamedTuple):
    """Geometry of the legs.

    Attributes:
        hip: lateral distance of the hip joints [m].
        thigh, shank: lengths from joint to joint [m].
        ankle: height over the sole [m].
        over_com, ahead_of_com: where the middle of the hips is in the nominal pose, seen from the
            CoM [m].
    """

    hip: float
    thigh: float
    shank: float
    ankle: float
    over_com: float
    ahead_of_com: float

    def length(self, knee: float) -> float:
        """From hip to ankle with the knee bent by an angle [rad]."""
        product = 2.0 * self.thigh * self.shank * math.cos(knee)
        return math.sqrt(self.thigh**2 + self.shank**2 + product)


def find_knees(multibody: Multibody) -> tuple[int, int]:
    """The motors that bend the legs, left and right: of each leg the one that is bent most."""
    angles, found = multibody.nominal[multibody.motor_positions], []
    for foot in multibody.feet:
        legs = [multibody.motors.tolist().index(joint) for joint in leg_joints(multibody, foot)]
        found.append(max(legs, key=lambda i: abs(angles[i])))
    return found[0], found[1]


def find_legs(multibody: Multibody) -> Legs:
    """The legs' geometry in the nominal pose, from the pitch axes of hip, knee and ankle.

    Raises:
        RobotError: a leg has not these three.
    """
    data, legs = multibody.data(), []
    for side, foot in enumerate(multibody.feet):
        pitch = [
            joint for joint in leg_joints(multibody, foot) if abs(data.xaxis[joint][1]) > MOSTLY
        ]
        if len(pitch) != JOINTS_THAT_PITCH:
            raise RobotError(
                "legs whose hip, knee and ankle pitch",
                f"{len(pitch)} such joints down to {multibody.body.feet[side]!r}",
                "name another foot, or lock the joints that are not of the leg",
            )
        legs.append(data.xanchor[pitch])
    hips, knees, ankles = (np.array([leg[k] for leg in legs]) for k in range(JOINTS_THAT_PITCH))
    middle, com = hips.mean(axis=0), data.subtree_com[multibody.base]
    return Legs(
        hip=float(abs(hips[0, 1] - hips[1, 1])),
        thigh=float(np.hypot(*(hips[0] - knees[0])[[0, 2]])),
        shank=float(np.hypot(*(knees[0] - ankles[0])[[0, 2]])),
        ankle=float(ankles[0, 2]),
        over_com=float(middle[2] - com[2]),
        ahead_of_com=float(middle[0] - com[0]),
    )


def leg_limits(multibody: Multibody) -> tuple[float, float]:
    """How fast the hips can move a foot below them, and how hard they can accelerate it.

    Of a leg in its nominal pose, moved as a whole by its pitch or its roll, whichever is weaker:
    v = w d and a = d tau / I, with the inertia I of all that the joint carries and the height d of
    its axis over the ground.

    Args:
        multibody: the mechanism; a motor without a limit limits nothing.

    Returns:
        Speed [m/s] and acceleration [m/s^2].
    """
    model, data = multibody.model, multibody.data()
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    speeds, accelerations = [math.inf], [math.inf]
    order = {int(joint): row for row, joint in enumerate(multibody.motors)}
    for foot in multibody.feet:
        joints = leg_joints(multibody, foot)
        for axis in (0, 1):
            along = [joint for joint in joints if abs(data.xaxis[joint][axis]) > MOSTLY]
            if along:
                row, dof = order[along[0]], int(model.jnt_dofadr[along[0]])
                distance = float(data.xanchor[along[0]][2])
                speeds.append(distance * float(multibody.speed[row]))
                torque = float(multibody.torque[row])
                accelerations.append(distance * torque / float(inertia[dof, dof]))
    return min(speeds), min(accelerations)


def leg_joints(multibody: Multibody, foot: int) -> list[int]:
    """The joints with a motor from the base down to a foot."""
    chain, body, joints = [], foot, set(multibody.motors.tolist())
    while body not in (0, multibody.base):
        first = int(multibody.model.body_jntadr[body])
        count = int(multibody.model.body_jntnum[body])
        chain = [j for j in range(first, first + count) if j in joints] + chain
        body = int(multibody.model.body_parentid[body])
    return chain

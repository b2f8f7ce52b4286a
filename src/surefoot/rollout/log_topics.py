"""What viewers draw of a rollout: places, poses, joints and forces as topics of ROS 2.

Everything is in the frame `world`. None of it is read back: the exact numbers are elsewhere in
the log, see `rollout.mcap_log`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.pushes import Push
from surefoot.geometry import quaternions
from surefoot.robot.feet import Side
from surefoot.rollout.ros_messages import Topic, force, joints, point, pose
from surefoot.rollout.trace import FEET, BodyTrace

Array = NDArray[Any]

SIDES = (Side.LEFT, Side.RIGHT)
"""In the order of `FEET`."""


def drawn_topics(values: Mapping[str, Any]) -> list[Topic]:
    """Topics of a walk, a message a cycle.

    Args:
        values: fields of a `Rollout` by name.
    """
    observations, commands, body = values["observations"], values["commands"], values["body"]
    com, zmp = observations["com"], commands["zmp"]
    if body is None:
        height = np.full((len(com), 1), values["robot"].com_height)
        com = np.concatenate([com, height], axis=1)
    else:
        com, zmp = body.com, body.zmp
    topics = [
        point("/com", com),
        point("/dcm", observations["dcm"]),
        point("/dcm_plan", commands["dcm_plan"]),
        point("/zmp", zmp),
        point("/step_target", commands["step_location"]),
    ]
    if values["pushes"]:
        topics.append(force("/push", push_forces(values["pushes"], observations["time"])))
    return topics + (_feet(observations) if body is None else _body(body))


def push_forces(pushes: Sequence[Push], time: Array) -> Array:
    """The sum of the pushes that act, shape (n, 2) [N]."""
    forces = np.zeros((len(time), 2))
    for push in pushes:
        forces[(time >= push.start) & (time < push.end)] += push.force
    return forces


def _feet(observations: Array) -> list[Topic]:
    """Soles of a point mass: they stay level."""
    topics = []
    for name, side in zip(FEET, SIDES, strict=True):
        stands = observations["support_side"] == side
        place = observations["swing_foot"].copy()
        place[stands, :2], place[stands, 2] = observations["support_foot"][stands], 0.0
        turn = np.zeros((len(place), 3))
        turn[:, 2] = np.where(stands, observations["support_yaw"], observations["swing_yaw"])
        topics.append(pose(f"/{name}_foot/pose", place, quaternions(turn)))
    return topics


def _body(body: BodyTrace) -> list[Topic]:
    topics = [
        pose("/base/pose", body.position[:, :3], body.position[:, 3:7]),
        joints("/joint_states", body.joints, body.joint_angles, body.joint_velocities, body.torque),
    ]
    for foot, name in enumerate(FEET):
        turns = quaternions(body.sole_turn[:, foot])
        topics.append(pose(f"/{name}_foot/pose", body.sole_position[:, foot], turns))
        topics.append(force(f"/{name}_foot/floor_force", body.sole_force[:, foot]))
    return topics

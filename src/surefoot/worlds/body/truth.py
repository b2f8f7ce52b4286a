"""From the rows of a walk in physics to what a rollout holds: everything in the world's frame.

The walker's controller works in a frame that turns with its steps; what it was told and what it
answered are turned back. The DCM goes with the angular momentum L about the standing sole, as the
walker's does:

    xi = c + L x e_z / (m h omega).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.geometry import rotated_by, wrapped
from surefoot.interface import OBSERVATION
from surefoot.robot.robot import Robot
from surefoot.rollout.trace import WALKING
from surefoot.worlds.body.recorder import Record

Array = NDArray[Any]

LEAST_FORCE = 1.0
"""Of the floor, below which there is no ZMP [N]."""


def roll_pitch_yaw(axes: Array) -> Array:
    """Angles about x, y and z, shape (n, 3) [rad], of rotation matrices by rows, shape (n, 9)."""
    m = axes.reshape(-1, 3, 3)
    roll = np.arctan2(m[:, 2, 1], m[:, 2, 2])
    pitch = -np.arcsin(np.clip(m[:, 2, 0], -1.0, 1.0))
    return np.stack([roll, pitch, np.arctan2(m[:, 1, 0], m[:, 0, 0])], axis=-1)


def floor_zmp(com: Array, wrenches: Array) -> Array:
    """Where the floor's forces have no horizontal moment, NaN in the air, shape (n, 2) [m].

    Args:
        com: the point that the moments are about, shape (n, 3) [m].
        wrenches: moment and force on both feet, shape (n, 2, 6) [N m, N].
    """
    total = wrenches.sum(axis=1)
    moment, force = total[:, :3], total[:, 3:]
    up = np.where(force[:, 2] > LEAST_FORCE, force[:, 2], np.nan)
    height = com[:, 2]
    x = com[:, 0] - (moment[:, 1] + height * force[:, 0]) / up
    y = com[:, 1] + (moment[:, 0] - height * force[:, 1]) / up
    return np.stack([x, y], axis=-1)


def carrying_foot(walk: Array) -> tuple[Array, Array]:
    """Foot on the ground and time of its touchdown; while both stand, those of the next step.

    After the last step they stay.
    """
    walking = walk["phase"] == WALKING
    support, began = walk["support"].copy(), walk["began"].copy()
    if walking.any():
        first = int(np.argmax(walking))
        support[:first], began[:first] = support[first], began[first]
    return support, began


def true_observations(record: Record, time: Array, believed: Robot, mass: float) -> Array:
    """What an all-knowing observer of the walk sees, records of `OBSERVATION`, shape (n,)."""
    state, walk = record.state, record.told["walk"]
    support, began = carrying_foot(walk)
    rows = np.arange(len(time))
    soles = np.stack([state["left_sole"], state["right_sole"]], axis=1)
    yaws = np.stack([roll_pitch_yaw(state[f"{s}_axes"])[:, 2] for s in ("left", "right")], axis=1)
    seen = np.zeros(len(time), OBSERVATION)
    seen["time"], seen["elapsed"] = time, np.maximum(time - began, 0.0)
    com, velocity, spin = state["com"], state["com_velocity"], state["spin"]
    foot, swing = soles[rows, support], soles[rows, 1 - support]
    seen["com"], seen["com_velocity"] = com[:, :2], velocity[:, :2]
    away, height = com - foot, believed.com_height
    twist = np.stack([spin[:, 1], -spin[:, 0]], axis=1) / mass
    momentum = twist + away[:, 2:] * velocity[:, :2] - away[:, :2] * velocity[:, 2:]
    seen["dcm"] = com[:, :2] + momentum / (height * believed.omega)
    seen["support_foot"], seen["swing_foot"] = foot[:, :2], swing
    if len(time) > 1:
        speed = np.gradient(soles, time, axis=0)
        seen["swing_foot_velocity"] = speed[rows, 1 - support]
    seen["support_yaw"], seen["swing_yaw"] = yaws[rows, support], yaws[rows, 1 - support]
    base = roll_pitch_yaw(state["base_axes"])
    seen["trunk_lean"] = rotated_by(np.stack([base[:, 1], -base[:, 0]], axis=1), base[:, 2])
    seen["support_side"] = 2 * support - 1
    return seen


def told_observations(record: Record, truth: Array) -> Array:
    """What the controller was told, in the world; the truth while it was told nothing."""
    walk = record.told["walk"]
    walking, heading = walk["phase"] == WALKING, walk["heading"]
    told = truth.copy()
    inner = record.told["observation"]
    for name in ("elapsed", "swing_foot", "swing_foot_velocity"):
        told[name][walking] = inner[name][walking]
    for name in ("com", "com_velocity", "dcm", "support_foot", "swing_foot", "swing_foot_velocity"):
        turned = rotated_by(inner[name][..., :2], heading)
        told[name][walking, :2] = turned[walking]
    for name in ("support_yaw", "swing_yaw"):
        told[name][walking] = wrapped(inner[name] + heading)[walking]
    return told


def commands_in_world(record: Record, truth: Array) -> Array:
    """What the controller answered, in the world; while both feet stand, what there is of it."""
    walk = record.told["walk"]
    walking, heading = walk["phase"] == WALKING, walk["heading"]
    inner = record.told["command"]
    commands = inner.copy()
    for name in (
        "zmp", "dcm_plan", "step_location", "dcm_offset", "swing_foot", "swing_foot_velocity",
        "swing_foot_acceleration", "hip_torque",
    ):  # fmt: skip
        commands[name][..., :2] = rotated_by(inner[name][..., :2], heading)
    commands["swing_yaw"] = wrapped(inner["swing_yaw"] + heading)
    still = ~walking
    # A stand has no plan of its DCM, and no step; its ZMP is in the world's frame already.
    commands["zmp"][still] = inner["zmp"][still]
    commands["dcm_plan"][still] = truth["dcm"][still]
    commands["step_location"][still] = truth["swing_foot"][still, :2]
    commands["swing_foot"][still] = truth["swing_foot"][still]
    for name in ("step_duration", "swing_foot_velocity", "swing_foot_acceleration", "dcm_offset"):
        commands[name][still] = 0.0
    commands["double_support"][still] = 1
    commands["mode"][still] = commands["status"][still] = 0
    return commands

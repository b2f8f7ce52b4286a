"""A motion of the paper's biped as MuJoCo would integrate it, and what perfect sensors tell of it.

No dynamics: every joint moves as prescribed, and the sole that stands holds the base.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from surefoot.robot.multibody import Multibody
from surefoot.robot.robot import STANDARD_GRAVITY
from surefoot.worlds.body.estimator import BodyEstimator, BodyMemory, BodyReadings

PERIOD = 0.001
SWITCHES = (0.3, 0.7, 1.1)
"""When the left foot is left alone on the ground, then the right one, then the left one [s]."""


@dataclass(frozen=True)
class Motion:
    """Time first: positions, velocities, accelerations, standing feet, and the sensors' tale."""

    qpos: np.ndarray
    qvel: np.ndarray
    expected: np.ndarray
    feet: np.ndarray
    senses: list[BodyReadings]


@dataclass(frozen=True)
class Estimate:
    """What an estimator made of a motion; `memories` has one entry more than there are cycles."""

    qpos: np.ndarray
    qvel: np.ndarray
    memories: list[BodyMemory]


def matrix(quaternion: np.ndarray) -> np.ndarray:
    out = np.empty(9)
    mujoco.mju_quat2Mat(out, quaternion)
    return out.reshape(3, 3)


def joint_angles(multibody: Multibody, time: np.ndarray, seed: int) -> np.ndarray:
    """At rest until the first foot lifts, then every joint goes its own way."""
    rng = np.random.default_rng(seed)
    joints = multibody.model.nv - 6
    since = np.maximum(time - SWITCHES[0], 0.0)[:, None]
    rate = rng.uniform(2.0, 6.0, joints)
    wave = np.sin(rate * since) * (1.0 - np.exp(-((since / 0.1) ** 2)))
    return multibody.nominal[7:] + rng.uniform(-0.25, 0.25, joints) * wave


def prescribed(multibody: Multibody, duration: float = 1.5, seed: int = 0) -> Motion:
    """Both feet stand, then one after the other; a foot comes to stand where it is."""
    time = np.arange(round(duration / PERIOD)) * PERIOD
    angles = joint_angles(multibody, time, seed)
    stance = (np.searchsorted(SWITCHES, time + 1e-9) + 1) % 2
    feet = np.array([[1 - s, s] for s in stance])
    feet[time < SWITCHES[0]] = 1
    data = mujoco.MjData(multibody.model)
    qpos = np.tile(multibody.nominal, (len(time), 1))
    anchor, anchored = None, -1
    for k, now in enumerate(angles):
        side = int(stance[k])
        data.qpos[:] = qpos[max(k - 1, 0)]
        mujoco.mj_kinematics(multibody.model, data)
        if side != anchored:
            anchor, anchored = sole_pose(multibody, data, side), side
        data.qpos[:3], data.qpos[3:7], data.qpos[7:] = 0.0, (1.0, 0.0, 0.0, 0.0), now
        mujoco.mj_kinematics(multibody.model, data)
        position, rotation = sole_pose(multibody, data, side)
        turn = anchor[1] @ rotation.T
        qpos[k, :3], qpos[k, 7:] = anchor[0] - turn @ position, now
        mujoco.mju_mat2Quat(qpos[k, 3:7], turn.flatten())
    return sensed(qpos, feet)


def sole_pose(multibody: Multibody, data: mujoco.MjData, side: int) -> tuple:
    site = multibody.soles[side]
    return data.site_xpos[site].copy(), data.site_xmat[site].reshape(3, 3).copy()


def sensed(qpos: np.ndarray, feet: np.ndarray) -> Motion:
    """Velocities and accelerations that lead from pose to pose, the robot being at rest before."""
    count, size = qpos.shape[0], qpos.shape[1] - 1
    qvel, expected = np.zeros((count, size)), np.zeros((count, size))
    qvel[1:, :3] = np.diff(qpos[:, :3], axis=0) / PERIOD
    qvel[1:, 6:] = np.diff(qpos[:, 7:], axis=0) / PERIOD
    for k in range(1, count):
        turn = np.empty(4)
        mujoco.mju_mulQuat(turn, qpos[k - 1, 3:7] * (1, -1, -1, -1), qpos[k, 3:7])
        mujoco.mju_quat2Vel(qvel[k, 3:6], turn, PERIOD)
    expected[1:] = np.diff(qvel, axis=0) / PERIOD
    force = np.where(feet.sum(axis=1, keepdims=True) == 2, 334.0, 668.0) * feet
    senses = []
    for k in range(count):
        lift = expected[k, :3] + (0.0, 0.0, STANDARD_GRAVITY)
        felt = matrix(qpos[max(k - 1, 0), 3:7]).T @ lift
        senses.append(
            BodyReadings(
                k * PERIOD, qpos[k, 7:].copy(), qvel[k, 6:].copy(), qvel[k, 3:6].copy(), felt,
                force[k].astype(float),
            )
        )  # fmt: skip
    return Motion(qpos, qvel, expected, feet, senses)


def estimate(
    estimator: BodyEstimator, motion: Motion, memory: BodyMemory | None = None, first: int = 0
) -> Estimate:
    """Run an estimator beside a motion, from a cycle on."""
    if memory is None:
        memory = estimator.start(motion.senses[0])
    qpos, qvel, memories = [], [], [memory]
    for k in range(first, len(motion.senses)):
        q, v, memory = estimator.step(
            memory, motion.senses[k], motion.feet[k], motion.expected[k].copy()
        )
        qpos.append(q)
        qvel.append(v)
        memories.append(memory)
    return Estimate(np.array(qpos), np.array(qvel), memories)


def disturbed(motion: Motion, seed: int = 0, bias: tuple = (0.0, 0.0, 0.0)) -> Motion:
    """The same motion with white noise on every sensor, as `BodyEstimator` expects it."""
    rng = np.random.default_rng(seed)
    noisy = [
        senses._replace(
            joint_angles=senses.joint_angles + 0.001 * rng.standard_normal(12),
            joint_velocities=senses.joint_velocities + 0.1 * rng.standard_normal(12),
            gyro=senses.gyro + 0.005 * rng.standard_normal(3) + bias,
            accelerometer=senses.accelerometer + 0.1 * rng.standard_normal(3),
        )
        for senses in motion.senses
    ]
    return replace(motion, senses=noisy)

"""What a body's sensors tell in the simulator: noisy, offset and late."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_seed
from surefoot.compiled import entry_point, njit
from surefoot.control.estimator import whole_cycles
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.robot import Robot
from surefoot.rollout.noise import noise_key, normal_pair
from surefoot.worlds.body.estimator import FORCE_PART, BodySenses

_UNITS = {
    "encoder": "rad",
    "rate": "rad/s",
    "gyro": "rad/s",
    "accelerometer": "m/s^2",
    "force": "N",
    "gyro_bias": "rad/s",
}
"""The standard deviations, in the order in which the compiled code takes them."""

_OFFSET_CYCLE = -1
"""Stands for the cycle whose noise is the gyroscope's constant offset."""


class SensorMemory(NamedTuple):
    """What the sensors remember.

    Attributes:
        cycle: how many cycles there were.
        late: senses that were taken but not told yet, the oldest first.
    """

    cycle: int
    late: tuple[BodySenses, ...]


@njit
def _disturb(deviations, seed, cycle, angles, velocities, gyro, accelerometer, force):
    """Add noise to the senses of a cycle, and its offset to the gyroscope."""
    key = noise_key(seed[0], 0, cycle[0])
    channel, joints = 0, angles.shape[0]
    for k in range(joints):
        first, second = normal_pair(key, channel)
        angles[k] += deviations[0] * first
        velocities[k] += deviations[1] * second
        channel += 1
    offset = noise_key(seed[0], 0, _OFFSET_CYCLE)
    for i in range(3):
        first, second = normal_pair(key, channel)
        gyro[i] += deviations[2] * first + deviations[5] * normal_pair(offset, i)[0]
        accelerometer[i] += deviations[3] * second
        channel += 1
    first, second = normal_pair(key, channel)
    force[0] = max(force[0] + deviations[4] * first, 0.0)
    force[1] = max(force[1] + deviations[4] * second, 0.0)


@cache
def _compiled() -> Callable[..., None]:
    real, whole = np.dtype(np.float64), np.dtype(np.int64)
    return entry_point(_disturb, real, whole, whole, *[real] * 5)


@dataclass(frozen=True)
class BodyNoise:
    """Noise and delay of a body's sensors; white, and the same for the same seed.

    Encoders and inertial units are the same parts in robots of all sizes, so their noise is
    absolute. Load cells are chosen for the weight that they carry: `of` knows whose they are.

    Args:
        encoder: standard deviation of joint angles [rad].
        rate: likewise of joint velocities [rad/s].
        gyro: likewise of the angular velocity [rad/s].
        accelerometer: likewise of the acceleration [m/s^2].
        gyro_bias: likewise of each axis of the gyroscope's constant offset [rad/s].
        force: likewise of the forces on the soles, which are never below 0; 2 N are those of
            load cells for 700 N, as a robot of 70 kg has them [N].
        delay: from sensing to telling, a whole number of periods [s].
        seed: of the random numbers, at least 0.
        period: control period [s].

    Raises:
        ParameterError: a value is out of range, or the delay no whole number of periods.
    """

    encoder: float = 0.001
    rate: float = 0.1
    gyro: float = 0.005
    accelerometer: float = 0.1
    gyro_bias: float = 0.005
    force: float = 2.0
    delay: float = 0.0
    seed: int = 0
    period: float = TIME_STEP

    def __post_init__(self) -> None:
        for name, unit in _UNITS.items():
            check_number(name, getattr(self, name), 0.0, unit)
        check_seed(self.seed)
        whole_cycles(self.delay, self.period)

    @classmethod
    def of(cls, robot: Robot, **changes: Any) -> Self:
        """That of the sensors of a robot: with load cells for its own weight.

        Args:
            robot: whose they are.
            **changes: of the other parameters.
        """
        return cls(**{"force": FORCE_PART * robot.mass * robot.gravity, **changes})

    @cached_property
    def _deviations(self) -> NDArray[np.float64]:
        return np.array([getattr(self, name) for name in _UNITS])

    @cached_property
    def _cycles(self) -> int:
        return whole_cycles(self.delay, self.period)

    @cached_property
    def _seed(self) -> NDArray[np.int64]:
        return np.array([self.seed])

    def start(self) -> SensorMemory:
        """What the sensors remember before the first cycle: nothing."""
        return SensorMemory(0, ())

    def step(self, memory: SensorMemory, senses: BodySenses) -> tuple[BodySenses, SensorMemory]:
        """What is told in a cycle, and what to remember.

        Until the delay has passed, the first senses are told again and again.

        Args:
            memory: of the cycle before, or of `start`.
            senses: what perfect sensors tell.
        """
        noisy = BodySenses(
            senses.time,
            senses.joint_angles.copy(),
            senses.joint_velocities.copy(),
            senses.gyro.copy(),
            senses.accelerometer.copy(),
            senses.foot_force.copy(),
        )
        _compiled()(
            self._deviations, self._seed, np.array([memory.cycle]), noisy.joint_angles,
            noisy.joint_velocities, noisy.gyro, noisy.accelerometer, noisy.foot_force,
        )  # fmt: skip
        late = (*memory.late, noisy)
        told = late[0]
        if len(late) > self._cycles:
            late = late[1:]
        return told, SensorMemory(memory.cycle + 1, late)

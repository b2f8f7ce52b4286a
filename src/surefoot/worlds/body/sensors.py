"""What a body's sensors measure in the simulator, with noise, offset and delay."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, NamedTuple, Protocol, Self

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_seed
from surefoot.compiled import entry_point, njit
from surefoot.control.estimator import whole_cycles
from surefoot.control.fields import check_fields, documented, setting
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.multibody import Multibody
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import noise_key, normal_pair
from surefoot.rollout.trace import WALKING
from surefoot.worlds.body.estimator import (
    FORCE_PART,
    FREE,
    BodyEstimator,
    BodyMemory,
    BodyReadings,
)
from surefoot.worlds.body.interface import JointCommand
from surefoot.worlds.body.plant import BodyPlant

_OFFSET_CYCLE = -1
"""Stands for the cycle whose noise is the gyroscope's constant offset."""


KNOWN = ("encoder", "rate", "gyro", "accelerometer", "gyro_bias", "force")
"""Deviations of a `BodyNoise` that an estimator knows, in the order in which kernels take them."""


class SensorMemory(NamedTuple):
    """What the sensors remember.

    Attributes:
        cycle: how many cycles there were.
        late: readings that were taken but not passed on yet, the oldest first.
    """

    cycle: int
    late: tuple[BodyReadings, ...]


@njit
def _disturb(noise, seed, cycle, readings):
    """Add noise to the readings of a cycle, and its offset to the gyroscope."""
    key = noise_key(seed, 0, cycle)
    channel, joints = 0, readings.joint_angles.shape[0]
    for k in range(joints):
        first, second = normal_pair(key, channel)
        readings.joint_angles[k] += noise[0] * first
        readings.joint_velocities[k] += noise[1] * second
        channel += 1
    offset = noise_key(seed, 0, _OFFSET_CYCLE)
    for i in range(3):
        first, second = normal_pair(key, channel)
        readings.gyro[i] += noise[2] * first + noise[4] * normal_pair(offset, i)[0]
        readings.accelerometer[i] += noise[3] * second
        channel += 1
    force, deviation = readings.foot_force, noise[5]
    first, second = normal_pair(key, channel)
    force[0] = max(force[0] + deviation * first, 0.0)
    force[1] = max(force[1] + deviation * second, 0.0)


@cache
def _compiled() -> Callable[..., None]:
    vector = numba.float64[::1]
    readings = numba.types.NamedTuple((numba.float64, *[vector] * 5), BodyReadings)
    return entry_point(_disturb, vector, numba.int64, numba.int64, readings)


@documented
@dataclass(frozen=True)
class BodyNoise:
    """Noise and delay of a body's sensors; white, and the same for the same seed.

    Encoders and inertial units are the same parts in robots of all sizes, so their noise is
    absolute. Load cells are chosen for the weight that they carry: `of` knows whose they are.

    Raises:
        ParameterError: a value is out of range, or the delay no whole number of periods.
    """

    encoder: float = setting(0.001, "rad", "standard deviation of joint angles", least=0.0)
    rate: float = setting(0.1, "rad/s", "likewise of joint velocities", least=0.0)
    gyro: float = setting(0.005, "rad/s", "likewise of the angular velocity", least=0.0)
    accelerometer: float = setting(0.1, "m/s^2", "likewise of the acceleration", least=0.0)
    gyro_bias: float = setting(
        0.005, "rad/s", "likewise of each axis of the gyroscope's constant offset", least=0.0
    )
    force: float = setting(
        2.0, "N",
        "likewise of the forces on the soles, which are never below 0; 2 N are those of load cells "
        "for 700 N, as a robot of 70 kg has them", least=0.0,
    )  # fmt: skip
    delay: float = setting(0.0, "s", "age of the readings, a whole number of periods")
    seed: int = setting(0, "", "of the random numbers, at least 0")
    period: float = setting(TIME_STEP, "s", "control period")

    def __post_init__(self) -> None:
        check_fields(self)
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
        return np.array([getattr(self, name) for name in KNOWN])

    @cached_property
    def _cycles(self) -> int:
        return whole_cycles(self.delay, self.period)

    def start(self) -> SensorMemory:
        """What the sensors remember before the first cycle: nothing."""
        return SensorMemory(0, ())

    def step(
        self, memory: SensorMemory, readings: BodyReadings
    ) -> tuple[BodyReadings, SensorMemory]:
        """The readings of a cycle, and what to remember.

        Until the delay has passed, the first readings are repeated.

        Args:
            memory: of the cycle before, or of `start`.
            readings: of perfect sensors.
        """
        noisy = BodyReadings(readings.time, *(reading.copy() for reading in readings[1:]))
        _compiled()(self._deviations, self.seed, memory.cycle, noisy)
        late = (*memory.late, noisy)
        first = late[0]
        if len(late) > self._cycles:
            late = late[1:]
        return first, SensorMemory(memory.cycle + 1, late)


BOTH = np.array([1, 1])
"""Both feet stand."""

ONE = (np.array([1, 0]), np.array([0, 1]))
"""The left one does, the right one does."""

State = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""Generalised position and velocity, and the vertical force on each sole [N]."""


class SensorNoise(Protocol):
    """What comes between perfect sensors and those that a robot has."""

    def start(self) -> Any:
        """What the sensors remember before the first cycle."""
        ...

    def step(self, memory: Any, readings: BodyReadings) -> tuple[BodyReadings, Any]:
        """The readings of a cycle, and what to remember."""
        ...


def usual_estimator(multibody: Multibody, noise: SensorNoise | None) -> BodyEstimator:
    """The estimator of a robot, which knows how late and how noisy its sensors are.

    It trusts none of them more than a usual one: where there is no noise, there is still a model
    that is not exact.

    Args:
        multibody: the robot's mechanism.
        noise: of its sensors; what it says is known of a `BodyNoise` only.
    """
    usual = BodyEstimator(multibody)
    if not isinstance(noise, BodyNoise):
        return usual
    known = {name: max(getattr(usual, name), getattr(noise, name)) for name in KNOWN}
    return BodyEstimator(multibody, delay=noise.delay, period=noise.period, **known)


def measure(plant: BodyPlant) -> BodyReadings:
    """Readings of perfect sensors; inertial unit and soles, of the cycle that has just passed."""
    readings = plant.data.sensordata
    return BodyReadings(
        plant.time,
        plant.position[FREE + 1 :].copy(),
        plant.velocity[FREE:].copy(),
        readings[:3].copy(),
        readings[3:6].copy(),
        plant.foot_force,
    )


def measure_standing(plant: BodyPlant) -> BodyReadings:
    """Likewise of a robot at rest on both feet, before its first cycle."""
    multibody = plant.multibody
    gravity = -plant.model.opt.gravity[2]
    up = plant.data.xmat[multibody.base].reshape(3, 3)[2]
    return BodyReadings(
        plant.time,
        plant.position[FREE + 1 :].copy(),
        np.zeros(multibody.model.nv - FREE),
        np.zeros(3),
        gravity * up,
        np.full(2, 0.5 * multibody.mass * gravity),
    )


class BodySensors:
    """What stands between a body and what walks it: sensors, their noise, an estimator.

    Args:
        plant: what is measured.
        noise: of its sensors, none if None.
        estimator: makes a state of what they measure; with None the true state is given.

    Attributes:
        noise_memory: what the noise remembers.
        memory: what the estimator does; None before its first cycle.
    """

    def __init__(
        self, plant: BodyPlant, noise: SensorNoise | None, estimator: BodyEstimator | None
    ) -> None:
        self.plant, self.noise, self.estimator = plant, noise, estimator
        self.noise_memory = None if noise is None else noise.start()
        self.memory: BodyMemory | None = None

    def measure(self, first: bool = False) -> BodyReadings | None:
        """What the sensors measure in this cycle, or None if the true state is given.

        This is the simulator's work; what a robot computes of it is done by `estimate`.

        Args:
            first: whether no cycle has passed yet.
        """
        if self.estimator is None:
            return None
        readings = measure_standing(self.plant) if first else measure(self.plant)
        if self.noise is not None:
            readings, self.noise_memory = self.noise.step(self.noise_memory, readings)
        return readings

    def estimate(self, readings: BodyReadings | None, state: Any, command: JointCommand) -> State:
        """The state of the body in this cycle.

        Args:
            readings: as `measure` gives them.
            state: of the `BodyController`, after the last cycle.
            command: of the last cycle.
        """
        if self.estimator is None or readings is None:
            plant = self.plant
            return plant.position, plant.velocity, plant.foot_force
        if self.memory is None:
            self.memory = self.estimator.start(readings)
        walk, feet = state.walk, BOTH
        if walk["phase"][0] == WALKING:
            feet = ONE[walk["support"][0]]
        position, velocity, self.memory = self.estimator.step(
            self.memory, readings, feet, command.acceleration
        )
        return position, velocity, self.memory.base["load"][0]

    def fork(self, plant: BodyPlant) -> BodySensors:
        """The same on another plant: what is remembered is a value."""
        other = copy.copy(self)
        other.plant = plant
        return other

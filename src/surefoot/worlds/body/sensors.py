"""What a walker is told of its body: the truth, or an estimate from what its sensors tell."""

from __future__ import annotations

import copy
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from surefoot.robot.multibody import Multibody
from surefoot.rollout.trace import WALKING
from surefoot.worlds.body.estimator import FREE, BodyEstimator, BodyMemory, BodySenses
from surefoot.worlds.body.joint_command import JointCommand
from surefoot.worlds.body.noise import BodyNoise
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.walker import WalkerState

BOTH = np.array([1, 1])
"""Both feet stand."""

ONE = (np.array([1, 0]), np.array([0, 1]))
"""The left one does, the right one does."""

TOLD = ("encoder", "rate", "gyro", "accelerometer", "gyro_bias", "force")
"""Parameters of a `BodyNoise` that an estimator is told."""

State = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""Generalised position and velocity, and the vertical force on each sole [N]."""


class SenseNoise(Protocol):
    """What comes between perfect sensors and those that a robot has."""

    def start(self) -> Any:
        """What the sensors remember before the first cycle."""
        ...

    def step(self, memory: Any, senses: BodySenses) -> tuple[BodySenses, Any]:
        """What is told in a cycle, and what to remember."""
        ...


def usual_estimator(multibody: Multibody, noise: SenseNoise | None) -> BodyEstimator:
    """The estimator of a robot, told how late and how noisy its sensors are.

    It trusts none of them more than a usual one: where there is no noise, there is still a model
    that is not exact.

    Args:
        multibody: the robot's mechanism.
        noise: of its sensors; what it says is known of a `BodyNoise` only.
    """
    usual = BodyEstimator(multibody)
    if not isinstance(noise, BodyNoise):
        return usual
    told = {name: max(getattr(usual, name), getattr(noise, name)) for name in TOLD}
    return BodyEstimator(multibody, delay=noise.delay, period=noise.period, **told)


def sense(plant: BodyPlant) -> BodySenses:
    """What perfect sensors tell; inertial unit and soles, of the cycle that has just passed."""
    readings = plant.data.sensordata
    return BodySenses(
        plant.time,
        plant.position[FREE + 1 :].copy(),
        plant.velocity[FREE:].copy(),
        readings[:3].copy(),
        readings[3:6].copy(),
        plant.foot_force,
    )


def sense_standing(plant: BodyPlant) -> BodySenses:
    """Likewise of a robot at rest on both feet, before its first cycle."""
    multibody = plant.multibody
    gravity = -plant.model.opt.gravity[2]
    up = plant.data.xmat[multibody.base].reshape(3, 3)[2]
    return BodySenses(
        plant.time,
        plant.position[FREE + 1 :].copy(),
        np.zeros(multibody.model.nv - FREE),
        np.zeros(3),
        gravity * up,
        np.full(2, 0.5 * multibody.mass * gravity),
    )


class BodySight:
    """What a walker sees of a plant, cycle after cycle.

    Args:
        plant: what is seen.
        noise: of its sensors, none if None.
        estimator: makes a state of what they tell; None tells the truth.
    """

    def __init__(
        self, plant: BodyPlant, noise: SenseNoise | None, estimator: BodyEstimator | None
    ) -> None:
        self.plant, self.noise, self.estimator = plant, noise, estimator
        self._noise_memory = None if noise is None else noise.start()
        self._memory: BodyMemory | None = None
        self._unexpected = np.zeros(plant.multibody.model.nv)

    def read(self, first: bool = False) -> BodySenses | None:
        """What the sensors tell in this cycle, or None if the truth is told.

        This is the simulator's work; what a robot computes of it is done by `see`.

        Args:
            first: whether no cycle has passed yet.
        """
        if self.estimator is None:
            return None
        senses = sense_standing(self.plant) if first else sense(self.plant)
        if self.noise is not None:
            senses, self._noise_memory = self.noise.step(self._noise_memory, senses)
        return senses

    def see(
        self, senses: BodySenses | None, state: WalkerState, command: JointCommand | None
    ) -> State:
        """The state of the body in this cycle.

        Args:
            senses: as `read` gives them.
            state: of the walker, after the last cycle.
            command: of the last cycle, None in the first.
        """
        if self.estimator is None or senses is None:
            plant = self.plant
            return plant.position, plant.velocity, plant.foot_force
        if self._memory is None:
            self._memory = self.estimator.start(senses)
        walk, feet = state.walk, BOTH
        if walk["phase"][0] == WALKING:
            feet = ONE[walk["support"][0]]
        expected = self._unexpected if command is None else command.acceleration
        position, velocity, self._memory = self.estimator.step(self._memory, senses, feet, expected)
        return position, velocity, self._memory.base["load"][0]

    def fork(self, plant: BodyPlant) -> BodySight:
        """The same eyes on another plant: what they remember is a value."""
        other = copy.copy(self)
        other.plant = plant
        return other

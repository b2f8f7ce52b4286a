"""What a controller is told of the world: the truth, what disturbs it, and then an estimator.

One kernel for walks that are compiled and for those that are not. Where a controller is told the
truth nothing is computed and nothing is copied.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.control.estimator import ESTIMATE, ESTIMATOR, Estimator, estimate_cycle, whole_cycles
from surefoot.errors import ParameterError
from surefoot.interface import COMMAND, OBSERVATION, Command, Controller, Observation
from surefoot.record import copy_array, new_array
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import DELAY_LINE, SIGHT, Disturbance, look
from surefoot.worlds.point.plant import LIPM_WORLD

SENSES = np.dtype([("active", "?"), ("estimates", "?"), ("sight", SIGHT), ("estimator", ESTIMATOR)])
"""Parameters: whether the truth is not told, whether an estimator works, and those of both."""

SENSED = np.dtype([("seen", OBSERVATION), ("line", DELAY_LINE), ("estimate", ESTIMATE)])
"""What was seen last, what is still under way, and what the estimator remembers."""


@njit
def sense(senses, world, command, sensed):
    """What the controller is told in this cycle, into `sensed.seen`; only if `senses.active`.

    Args:
        senses: a `SENSES` record.
        world: a `LIPM_WORLD` record.
        command: the `COMMAND` record that led here.
        sensed: a `SENSED` record, changed.
    """
    sensed.seen = world.observation
    look(senses.sight, world, sensed.line, sensed.seen)
    if senses.estimates:
        estimate_cycle(senses.estimator, sensed.estimate, sensed.seen, command)


@njit
def _sense_step(senses, world, command, sensed):
    sense(senses[0], world[0], command[0], sensed[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_sense_step, SENSES, LIPM_WORLD, COMMAND, SENSED)


@dataclass(frozen=True)
class Senses:
    """What stands between a world and a controller.

    Args:
        controller: who is told.
        plant: the robot that is moved. A DCM is made of CoM and velocity with the natural
            frequency that the controller believes in.
        disturbance: of what is seen.
        estimator: between what is measured and the controller.

    Raises:
        ParameterError: the delay is no whole number of periods, or the estimator has another
            period than the controller.
    """

    controller: Controller
    plant: Robot
    disturbance: Disturbance | None = None
    estimator: Estimator | None = None
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        believed, disturbance = self.controller.robot.omega, self.disturbance or Disturbance()
        parameters = new_array(SENSES)
        sight = parameters["sight"]
        for name in ("dcm_noise", "velocity_noise", "com_offset", "seed"):
            sight[name] = getattr(disturbance, name)
        sight["delay"] = whole_cycles(disturbance.delay, self.controller.period)
        sight["omega"] = believed
        estimates = self.estimator is not None and self.estimator.works
        if self.estimator is not None:
            if self.estimator.period != self.controller.period:
                raise ParameterError(
                    f"an estimator with the controller's period, {self.controller.period:g} s",
                    f"{self.estimator.period:g} s",
                    "give it `period=controller.period`",
                )
            parameters["estimator"] = self.estimator.parameters
        parameters["estimates"] = estimates
        other = believed != self.plant.omega
        parameters["active"] = disturbance.blurs or estimates or other
        object.__setattr__(self, "parameters", parameters)

    @property
    def active(self) -> bool:
        """Whether the controller is told anything but the truth."""
        return bool(self.parameters["active"][0])

    def start(self) -> NDArray[np.void]:
        """What was sensed before the first cycle: nothing."""
        return new_array(SENSED)

    def step(
        self, sensed: NDArray[np.void], world: NDArray[np.void], command: Command
    ) -> tuple[Observation, NDArray[np.void]]:
        """One cycle: what the controller is told, and what was sensed by now.

        Args:
            sensed: of the cycle before, or of `start`.
            world: now.
            command: what led here; of no matter in the first cycle.
        """
        if not self.active:
            return Observation.of(world["observation"]), sensed
        sensed = copy_array(sensed)
        _compiled()(self.parameters, world, command.array, sensed)
        return Observation.of(sensed["seen"]), sensed

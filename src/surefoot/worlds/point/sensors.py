"""What a controller is given of a point mass: the truth, what disturbs it, and then an estimator.

One kernel for walks that are compiled and for those that are not. Where a controller is given the
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
from surefoot.dcm.three_mass import pendulum_omega
from surefoot.errors import ParameterError
from surefoot.interface import COMMAND, OBSERVATION, Command, Controller, Observation
from surefoot.record import copy_array, new_array
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import DELAY_LINE, SENSOR_ERRORS, Disturbance, disturb
from surefoot.worlds.point.plant import LIPM_WORLD

SENSORS = np.dtype(
    [("active", "?"), ("estimates", "?"), ("errors", SENSOR_ERRORS), ("estimator", ESTIMATOR)]
)
"""Parameters: whether anything but the truth is given, whether an estimator works, and those of
both."""

MEASURED = np.dtype([("observation", OBSERVATION), ("line", DELAY_LINE), ("estimate", ESTIMATE)])
"""What was measured last, what is still under way, and what the estimator remembers."""


@njit
def measure(sensors, world, command, measured):
    """What the controller is given in this cycle, into `measured.observation`; only if
    `sensors.active`.

    Args:
        sensors: a `SENSORS` record.
        world: a `LIPM_WORLD` record.
        command: the `COMMAND` record that led here.
        measured: a `MEASURED` record, changed.
    """
    measured.observation = world.observation
    disturb(sensors.errors, world, measured.line, measured.observation)
    if sensors.estimates:
        estimate_cycle(sensors.estimator, measured.estimate, measured.observation, command)


@njit
def _measure_step(sensors, world, command, measured):
    measure(sensors[0], world[0], command[0], measured[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_measure_step, SENSORS, LIPM_WORLD, COMMAND, MEASURED)


@dataclass(frozen=True)
class PointSensors:
    """What stands between a point mass and its controller: sensors, their errors, an estimator.

    Args:
        controller: what is given the observation.
        plant: the robot that is moved. A DCM is made of CoM and velocity with the natural
            frequency that the controller believes in.
        disturbance: of what is measured.
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
        parameters = new_array(SENSORS)
        errors = parameters["errors"]
        for name in ("dcm_noise", "velocity_noise", "com_offset", "seed"):
            errors[name] = getattr(disturbance, name)
        errors["delay"] = whole_cycles(disturbance.delay, self.controller.period)
        errors["omega"] = believed
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
        other = believed != pendulum_omega(self.plant)
        parameters["active"] = disturbance.blurs or estimates or other
        object.__setattr__(self, "parameters", parameters)

    @property
    def active(self) -> bool:
        """Whether the controller is given anything but the truth."""
        return bool(self.parameters["active"][0])

    def start(self) -> NDArray[np.void]:
        """What was measured before the first cycle: nothing."""
        return new_array(MEASURED)

    def step(
        self, measured: NDArray[np.void], world: NDArray[np.void], command: Command
    ) -> tuple[Observation, NDArray[np.void]]:
        """One cycle: what the controller is given, and what was measured by now.

        Args:
            measured: of the cycle before, or of `start`.
            world: now.
            command: what led here; of no matter in the first cycle.
        """
        if not self.active:
            return Observation.of(world["observation"]), measured
        measured = copy_array(measured)
        _compiled()(self.parameters, world, command.array, measured)
        return Observation.of(measured["observation"]), measured

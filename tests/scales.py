"""A change of size: what becomes of a robot, its walk and what disturbs it, all alike."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

import surefoot as sf
from surefoot.dcm.push_limit import PushCase

Case = TypeVar("Case", bound=PushCase)


@dataclass(frozen=True)
class Scale:
    """Lengths times `length`, masses times `mass`, under the same gravity.

    Attributes:
        length: lambda.
        mass: mu.
    """

    length: float
    mass: float

    @property
    def time(self) -> float:
        """Of times, speeds and what is between."""
        return math.sqrt(self.length)

    @property
    def torque(self) -> float:
        """Of torques, and of springs of joints."""
        return self.mass * self.length

    @property
    def inertia(self) -> float:
        """Of moments of inertia."""
        return self.mass * self.length**2

    @property
    def impulse(self) -> float:
        """Of impulses."""
        return self.mass * self.time

    def robot(self, robot: sf.Robot) -> sf.Robot:
        """The robot in this size."""
        return robot.scaled(length=self.length, mass=self.mass)

    def velocity(self, velocity: tuple[float, float]) -> tuple[float, float]:
        """A velocity, or a pair of anything that goes with the time."""
        return self.time * velocity[0], self.time * velocity[1]

    def case(self, case: Case) -> Case:
        """The same robot, gait and push."""
        reach, fixed = case.zmp_reach, case.step_duration
        return replace(
            case,
            robot=self.robot(case.robot),
            velocity=self.velocity(case.velocity),
            elapsed=self.time * case.elapsed,
            duration=self.time * case.duration,
            zmp_reach=(self.length * reach[0], self.length * reach[1]),
            step_duration=None if fixed is None else self.time * fixed,
        )

    def push(self, push: sf.Push) -> sf.Push:
        """Forces go with the mass alone."""
        force = (self.mass * push.force[0], self.mass * push.force[1])
        return sf.Push(self.time * push.start, self.time * push.duration, force)

    def disturbance(self, one: sf.Disturbance) -> sf.Disturbance:
        """Noise, offsets and delays to match."""
        return sf.Disturbance(
            dcm_noise=self.length * one.dcm_noise,
            velocity_noise=self.time * one.velocity_noise,
            delay=self.time * one.delay,
            com_offset=(self.length * one.com_offset[0], self.length * one.com_offset[1]),
            landing_error=self.length * one.landing_error,
            touchdown_shift=self.time * one.touchdown_shift,
            seed=one.seed,
        )

    def back(self, rollout: sf.Rollout) -> Mapping[str, NDArray[Any]]:
        """What was observed and decided in a walk of this size, as it would be in the size 1."""
        observed, decided = rollout.observations, rollout.commands
        length, time = 1.0 / self.length, 1.0 / self.time
        return {
            "time": time * observed["time"],
            "dcm": length * observed["dcm"],
            "support_foot": length * observed["support_foot"],
            "swing_foot": length * observed["swing_foot"],
            "step_location": length * decided["step_location"],
            "step_duration": time * decided["step_duration"],
            "zmp": length * decided["zmp"],
            "hip_torque": decided["hip_torque"] / self.torque,
            "mode": decided["mode"].astype(float),
            "status": decided["status"].astype(float),
        }


UNITY = Scale(1.0, 1.0)


def largest_difference(one: Mapping[str, NDArray[Any]], other: Mapping[str, NDArray[Any]]) -> str:
    """The field in which two walks differ most, and by how much; "" if below 1e-9.

    Lengths are of the order of a metre and times of a second, in the size 1.
    """
    if len(one["time"]) != len(other["time"]):
        return f"{len(one['time'])} and {len(other['time'])} cycles"
    worst = {
        name: float(np.abs(values - other[name]).max() / max(np.abs(values).max(), 1.0))
        for name, values in one.items()
    }
    name = max(worst, key=lambda key: worst[key])
    # A NaN is a difference too.
    return "" if worst[name] <= 1e-9 else f"{name} by {worst[name]:.1e}"

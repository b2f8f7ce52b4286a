"""The units of a robot's own: lengths in heights of its CoM, times in 1 / omega, masses in its own.

Two robots that are alike but for their size walk alike in these units (dynamic similarity, after
Froude), so what is much, near or soon is said in them rather than in metres and seconds. A speed
of 1 is sqrt(g h), an acceleration of 1 is g, a force of 1 the weight, a torque of 1 is m g h.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Self

from surefoot.checks import check_number
from surefoot.robot.robot import Robot


class OwnUnits(NamedTuple):
    """What is 1 in the units of a robot.

    Attributes:
        length: height of the CoM, h [m].
        time: 1 / omega [s].
        mass: of the robot, m [kg].
    """

    length: float
    time: float
    mass: float

    @classmethod
    def of(cls, robot: Robot) -> Self:
        """Those of a robot, as its file describes it."""
        return cls(robot.com_height, 1.0 / robot.omega, robot.mass)

    @property
    def rate(self) -> float:
        """omega [1/s], and of angles [rad/s]."""
        return 1.0 / self.time

    @property
    def speed(self) -> float:
        """sqrt(g h) [m/s]."""
        return self.length / self.time

    @property
    def acceleration(self) -> float:
        """g [m/s^2]."""
        return self.length / self.time**2

    @property
    def force(self) -> float:
        """The weight [N]."""
        return self.mass * self.acceleration

    @property
    def torque(self) -> float:
        """m g h [N m], and of a spring [N m/rad]."""
        return self.force * self.length

    @property
    def inertia(self) -> float:
        """m h^2 [kg m^2]."""
        return self.mass * self.length**2

    def fill(self, owner: Any, defaults: Mapping[str, tuple[str, float]]) -> dict[str, float]:
        """Give a frozen dataclass the values that follow from the robot where it has None.

        Args:
            owner: whose attributes are set.
            defaults: unit and value in own units, by name; 0 is allowed.

        Returns:
            All of them in SI, checked.

        Raises:
            ParameterError: one that was given is negative or not finite.
        """
        values = {}
        for name, (unit, share) in defaults.items():
            given = getattr(owner, name)
            value = share * self.one(unit) if given is None else given
            check_number(name, value, 0.0, unit)
            object.__setattr__(owner, name, value)
            values[name] = float(value)
        return values

    def one(self, unit: str) -> float:
        """What is 1 of a unit as they are written here, for example of "m/s".

        Args:
            unit: its name; angles have none of their own.
        """
        second, metre = self.time, self.length
        return {
            "-": 1.0,
            "s": second,
            "m": metre,
            "m/s": self.speed,
            "m/s^2": self.acceleration,
            "m/s^0.5": metre / second**0.5,
            "1/s": self.rate,
            "rad/s": self.rate,
            "1/s^2": self.rate**2,
            "rad/s^2": self.rate**2,
            "rad/s^0.5": self.rate**0.5,
            "N": self.force,
            "N m/rad": self.torque,
            "N m s/rad": self.torque * second,
            "kg m^2": self.inertia,
        }[unit]

"""The units of a robot's own: lengths in heights of its CoM, times in 1 / omega, masses in its own.

Two robots that are alike but for their size walk alike in these units (dynamic similarity, after
Froude), so what is much, near or soon is said in them rather than in metres and seconds. A speed
of 1 is sqrt(g h), an acceleration of 1 is g, a force of 1 the weight, a torque of 1 is m g h.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Self

if TYPE_CHECKING:
    from surefoot.robot.robot import Robot

WORDS = {
    "s": "/ omega", "m": "h", "m/s": "sqrt(g h)", "m/s^2": "g", "m/s^0.5": "h sqrt(omega)",
    "1/s": "omega", "1/s^2": "omega^2", "rad/s^2": "omega^2", "rad/s^0.5": "sqrt(omega)",
    "N": "m g", "N m": "m g h", "N m/rad": "m g h", "N m s/rad": "m g h / omega",
}  # fmt: skip
"""What a docstring writes behind a number in own units, by the unit in SI."""


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
            "N m": self.torque,
            "N m/rad": self.torque,
            "N m s/rad": self.torque * second,
            "kg m^2": self.inertia,
        }[unit]

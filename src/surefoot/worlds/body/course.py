"""Where a body is to go, and what keeps it there: speed, place and heading held from outside.

The controllers hold a velocity of the pendulum. A body's pendulum is not quite theirs, so a slow
loop over whole steps corrects the velocity that they are given, by how far the robot is from where
it should be by now.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from surefoot.geometry import rotated
from surefoot.worlds.steering import Steering


@dataclass(frozen=True)
class VelocityCorrection:
    """What is added to the velocity of the steering to hold the place, in the robot's heading.

    Attributes:
        drift: what has turned out to be needed at all times: the body's own way of stepping takes
            it off to a side, or slows it down (x, y) [m/s].
        back: what takes it back to its course, likewise.
    """

    drift: tuple[float, float] = (0.0, 0.0)
    back: tuple[float, float] = (0.0, 0.0)

    @property
    def total(self) -> tuple[float, float]:
        """All of it (x, y) [m/s]."""
        return self.drift[0] + self.back[0], self.drift[1] + self.back[1]

    def rotated(self, angle: float) -> VelocityCorrection:
        """The same for a robot that has turned: the drift is its own, the way back the world's."""
        return replace(self, back=rotated(self.back, -angle))


@dataclass(frozen=True)
class CourseController:
    """How a place is held: by a loop with an integral part that does not hurry.

    With a quarter of the square of the rate as its gain both poles are at half of the rate: the
    fastest loop that does not swing. It learns nothing while the robot is given something else than
    the loop wants, nor while it turns: it would learn what goes round. A robot that was pushed must
    not be pulled back while it still catches itself: that costs up to a quarter of the push to the
    sides. So the way back begins slowly.

    Attributes:
        rate: at which an error is removed [1/s].
        max_total: largest correction, to either side [m/s].
        max_change: of the correction [m/s^2].
    """

    rate: float
    max_total: float
    max_change: float

    def correction(
        self, before: VelocityCorrection, error: tuple[float, float], elapsed: float, turning: float
    ) -> VelocityCorrection:
        """The correction for the next step.

        Args:
            before: that of the last one.
            error: from the robot to where it should be, in its heading (x, y) [m].
            elapsed: how long that step took [s].
            turning: at which the robot does [rad/s].
        """
        before, learns = before.rotated(turning * elapsed), turning == 0.0
        first, second = (
            self._along(drift, back, off, elapsed, learns)
            for drift, back, off in zip(before.drift, before.back, error, strict=True)
        )
        return VelocityCorrection((first[0], second[0]), (first[1], second[1]))

    def _along(
        self, drift: float, back: float, off: float, elapsed: float, learns: bool
    ) -> tuple[float, float]:
        """Drift and way back along one axis."""
        wanted, change = self.rate * off, self.max_change * elapsed
        limited = min(max(wanted, -self.max_total - drift), self.max_total - drift)
        limited = min(max(limited, back - change), back + change)
        if learns and (limited == wanted or off * (wanted + drift) < 0.0):
            drift += 0.25 * self.rate * self.rate * off * elapsed
        return drift, limited


@dataclass(frozen=True)
class Course:
    """Where the robot should be: goes on with the steering, and waits for a robot that is late.

    Attributes:
        place: target of the point midway between the feet (x, y) [m].
        heading: target [rad].
        time: when that was [s].
    """

    place: tuple[float, float]
    heading: float
    time: float

    def moved(self, steering: Steering, time: float) -> Course:
        """The course at a later time: along an arc if the steering turns."""
        elapsed = max(time - self.time, 0.0)
        middle = self.heading + 0.5 * steering.turning * elapsed
        x, y = rotated(steering.velocity, middle)
        return Course(
            (self.place[0] + x * elapsed, self.place[1] + y * elapsed),
            self.heading + steering.turning * elapsed,
            time,
        )

    def waiting_for(self, place: tuple[float, float], max_lead: float) -> Course:
        """The course, no further ahead of the robot than that [m]: what a push took is lost."""
        away = (self.place[0] - place[0], self.place[1] - place[1])
        distance = math.hypot(*away)
        if distance <= max_lead:
            return self
        part = max_lead / distance
        return replace(self, place=(place[0] + part * away[0], place[1] + part * away[1]))

    def error(self, place: tuple[float, float], heading: float) -> tuple[float, float]:
        """From a robot to where it should be, in its heading (x, y) [m].

        Args:
            place: where it is (x, y) [m].
            heading: of the robot [rad].
        """
        return rotated((self.place[0] - place[0], self.place[1] - place[1]), -heading)

"""Where a body is to go, and what keeps it there: speed, place and heading held from outside.

The controllers hold a velocity of the pendulum. A body's pendulum is not quite theirs, so a slow
loop over whole steps corrects the velocity that they are told, by how far the robot is from where
it should be by now.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from surefoot.models.frame_turn import rotated
from surefoot.models.steering import Steering


@dataclass(frozen=True)
class Course:
    """Where the robot should be: goes on with the steering, and waits for a robot that is late.

    Attributes:
        place: target of the point midway between the feet (x, y) [m].
        heading: target [rad].
        time: when that was [s].
        drift: what the velocity has turned out to need at all times, in the heading of the course:
            the body's own way of stepping takes it off to a side, or slows it down [m/s].
    """

    place: tuple[float, float]
    heading: float
    time: float
    drift: tuple[float, float] = (0.0, 0.0)

    def moved(self, steering: Steering, time: float) -> Course:
        """The course at a later time: along an arc if the steering turns."""
        elapsed = max(time - self.time, 0.0)
        middle = self.heading + 0.5 * steering.turning * elapsed
        x, y = rotated(steering.velocity, middle)
        return replace(
            self,
            place=(self.place[0] + x * elapsed, self.place[1] + y * elapsed),
            heading=self.heading + steering.turning * elapsed,
            time=time,
        )

    def waiting_for(self, place: tuple[float, float], furthest: float) -> Course:
        """The course, no further than that from the robot [m]: what a push took is lost."""
        away = (self.place[0] - place[0], self.place[1] - place[1])
        distance = math.hypot(*away)
        if distance <= furthest:
            return self
        part = furthest / distance
        return replace(self, place=(place[0] + part * away[0], place[1] + part * away[1]))

    def learning(
        self, place: tuple[float, float], rate: float, most: float, elapsed: float
    ) -> Course:
        """The course with the `drift` after a step that ended at `place`.

        With a quarter of the square of the rate both poles of the loop are at half the rate: the
        fastest without overshoot. What is corrected as much as it may be teaches nothing.

        Args:
            place: where the robot is (x, y) [m].
            rate, most: as in `correction`.
            elapsed: how long the step took [s].
        """
        error, told = self._error(place), self.correction(place, rate, most)
        gain = 0.25 * rate * rate * elapsed
        first, second = (
            was + gain * off if abs(now) < most or off * now < 0.0 else was
            for was, off, now in zip(self.drift, error, told, strict=True)
        )
        return replace(self, drift=(first, second))

    def _error(self, place: tuple[float, float]) -> tuple[float, float]:
        """From the robot to where it should be, in the heading of the course [m]."""
        return rotated((self.place[0] - place[0], self.place[1] - place[1]), -self.heading)

    def correction(
        self, place: tuple[float, float], rate: float, most: float
    ) -> tuple[float, float]:
        """What to add to the velocity, in the heading of the course [m/s].

        Args:
            place: where the robot is (x, y) [m].
            rate: at which an error is to be removed [1/s].
            most: in x and in y [m/s].
        """
        x, y = self._error(place)
        x, y = rate * x + self.drift[0], rate * y + self.drift[1]
        return (min(max(x, -most), most), min(max(y, -most), most))

"""Where a body is to go, and what keeps it there: speed, place and heading held from outside.

The controllers hold a velocity of the pendulum. A body's pendulum is not quite theirs, so a slow
loop over whole steps corrects the velocity that they are told, by how far the robot is from where
it should be by now.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from surefoot.models.frame_turn import rotated
from surefoot.models.steering import Steering


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

    def waiting_for(self, place: tuple[float, float], furthest: float) -> Course:
        """The course, no further than that from the robot [m]: what a push took is lost."""
        away = (self.place[0] - place[0], self.place[1] - place[1])
        distance = math.hypot(*away)
        if distance <= furthest:
            return self
        part = furthest / distance
        return Course(
            (place[0] + part * away[0], place[1] + part * away[1]), self.heading, self.time
        )

    def correction(
        self, place: tuple[float, float], rate: float, most: float
    ) -> tuple[float, float]:
        """What to add to the velocity, in the heading of the course [m/s].

        Args:
            place: where the robot is (x, y) [m].
            rate: at which an error is to be removed [1/s].
            most: in x and in y [m/s].
        """
        away = (self.place[0] - place[0], self.place[1] - place[1])
        x, y = rotated(away, -self.heading)
        return (min(max(rate * x, -most), most), min(max(rate * y, -most), most))

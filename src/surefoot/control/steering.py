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
class Hold:
    """How a place is held: a loop with an integral part that does not hurry.

    What the integral has found is part of the answer. With a quarter of the square of the rate both
    poles are at half of it, the fastest without overshoot. An answer that is as large as it may be
    teaches nothing. A robot that was pushed must not be pulled back while it still catches itself:
    that costs a fifth of the push to the sides. So an answer changes slowly.

    Attributes:
        rate: at which an error is removed [1/s].
        most: largest answer, to either side [m/s].
        most_change: of the answer [m/s^2].
    """

    rate: float
    most: float
    most_change: float

    def answer(
        self, off: float, drift: float, before: float, elapsed: float
    ) -> tuple[float, float]:
        """The new integral part and the new answer, along one axis.

        Args:
            off: how far the target is ahead [m].
            drift: the integral part so far [m/s].
            before: the last answer [m/s].
            elapsed: since then [s].
        """
        wanted = self.rate * off + drift
        if abs(wanted) < self.most or off * wanted < 0.0:
            drift += 0.25 * self.rate * self.rate * off * elapsed
        wanted = min(max(wanted, -self.most), self.most)
        change = self.most_change * elapsed
        return drift, min(max(wanted, before - change), before + change)


@dataclass(frozen=True)
class Course:
    """Where the robot should be: goes on with the steering, and waits for a robot that is late.

    Attributes:
        place: target of the point midway between the feet (x, y) [m].
        heading: target [rad].
        time: when that was [s].
        drift: what the velocity has turned out to need at all times, in the heading of the course:
            the body's own way of stepping takes it off to a side, or slows it down [m/s].
        correction: what is added to the velocity now, `drift` included, likewise [m/s].
    """

    place: tuple[float, float]
    heading: float
    time: float
    drift: tuple[float, float] = (0.0, 0.0)
    correction: tuple[float, float] = (0.0, 0.0)

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

    def pulling(self, place: tuple[float, float], hold: Hold, elapsed: float) -> Course:
        """The course after a step that ended at `place`: its `drift` and `correction` are new.

        Args:
            place: where the robot is (x, y) [m].
            hold: how the place is held.
            elapsed: how long the step took [s].
        """
        first, second = (
            hold.answer(off, drift, now, elapsed)
            for off, drift, now in zip(self._error(place), self.drift, self.correction, strict=True)
        )
        return replace(self, drift=(first[0], second[0]), correction=(first[1], second[1]))

    def _error(self, place: tuple[float, float]) -> tuple[float, float]:
        """From the robot to where it should be, in the heading of the course [m]."""
        return rotated((self.place[0] - place[0], self.place[1] - place[1]), -self.heading)

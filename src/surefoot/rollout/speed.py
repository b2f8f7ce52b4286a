"""Whether a body makes the way that it is told to make: its speed, and how long its steps take.

A robot that steps but gets nowhere has not walked: one whose steps end on the noise of its soles,
say, or whose feet slide. Speeds are means over whole pairs of steps, since a body sways in each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.pushes import Push
from surefoot.geometry import rotated_by
from surefoot.robot.feet import Footstep
from surefoot.robot.own_units import OwnUnits
from surefoot.rollout.trace import BodyTrace

Array = NDArray[Any]

SETTLING = 14.0
"""Before the speed that is held is measured, from the first step, a command or a push on, in
1 / omega."""

SPEED_PART, SPEED_LEAST = 0.2, 0.01
"""How far the mean velocity may be from the command: a part of it, and at least so much of
sqrt(g h). Bodies hold 0.2 to 0.5 m/s to 5 % once they are on their course, and go up to 15 % faster
until they have made up for their first steps."""

CATCHING_UP = 0.0535
"""How much more after a push, in sqrt(g h): what `BodyControl` adds to take it back."""

STEP_PART = 0.75
"""Steps that on average are over before this part of what was planned at their beginnings were not
ended by the ground."""


@dataclass(frozen=True)
class HeldSpeed:
    """How a body walked under its last command to walk, after the time in which it settles.

    Attributes:
        velocity: mean over whole pairs of steps, in its own heading (forward, to the left) [m/s].
        commanded: what it should have been [m/s].
        allowed: how far it may be from that [m/s].
        duration: mean of its steps [s].
        planned: what that was to be at their beginnings [s].
    """

    velocity: tuple[float, float]
    commanded: tuple[float, float]
    allowed: float
    duration: float
    planned: float

    @property
    def is_held(self) -> bool:
        """Whether the robot went where it was told to, in steps that the ground ended."""
        away = math.dist(self.velocity, self.commanded)
        return away <= self.allowed and self.duration >= STEP_PART * self.planned


def last_command(trace: BodyTrace) -> tuple[float, tuple[float, float], float] | None:
    """When the last command to walk began [s], its velocity [m/s], and when it ended [s]."""
    index = max((i for i, command in enumerate(trace.steering) if not command[3]), default=None)
    if index is None or not trace.walking.any():
        return None
    begin, commanded = trace.steering[index][:2]
    end = trace.steering[index + 1][0] if index + 1 < len(trace.steering) else math.inf
    return begin, commanded, end


def held_speed(
    time: Array,
    steps: Sequence[Footstep],
    pushes: Sequence[Push],
    commands: Array,
    trace: BodyTrace,
) -> HeldSpeed | None:
    """The speed that a body held, None if it did not walk for long enough to tell.

    Args:
        time: of the cycles [s].
        steps: the finished ones.
        pushes: forces on it.
        commands: `COMMAND` records, one a cycle.
        trace: of the body.
    """
    last = last_command(trace)
    if last is None:
        return None
    begin, commanded, end = last
    own = OwnUnits.of(trace.robot)
    # What a push does to the speed is not what is held.
    pushed = [push.end for push in pushes if push.start < min(end, float(time[-1]))]
    first = float(time[np.argmax(trace.walking)])
    settled = max([begin, first, *pushed]) + SETTLING * own.time
    begins = [step.start for step in steps if settled <= step.start <= end]
    if len(begins) < 3:
        return None
    count = 2 * ((len(begins) - 1) // 2)
    starts = np.searchsorted(time, begins[: count + 1])
    rows = slice(int(starts[0]), int(starts[-1]))
    velocity = rotated_by(trace.com_velocity[rows, :2], -trace.base_turn[rows, 2]).mean(axis=0)
    slack = CATCHING_UP * own.speed if pushed else 0.0
    return HeldSpeed(
        velocity=(float(velocity[0]), float(velocity[1])),
        commanded=commanded,
        allowed=max(SPEED_PART * math.hypot(*commanded), SPEED_LEAST * own.speed) + slack,
        duration=(begins[count] - begins[0]) / count,
        planned=float(commands["step_duration"][starts[:-1]].mean()),
    )

"""How a walk ended, and the rule by which a robot counts as recovered.

Recovered: the DCM error over the last finished step is below 1 cm, and the mean velocity over the
last two is within 2 % of the command (or 0.01 m/s, where that is more). A body in physics, which
is never as exact, has recovered if it walks on for 5 s, or takes its last steps as before the push.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from surefoot.compiling import njit
from surefoot.models.footsteps import Footstep
from surefoot.models.plane import length
from surefoot.models.pushes import Push

SETTLED_ERROR = 0.01
"""Largest DCM error of a settled step [m]."""

SETTLED_VELOCITY = 0.02
"""Largest deviation of the mean velocity, as a fraction of the command."""

SETTLED_SLOWEST = 0.01
"""Deviation that is always allowed: 2 % of standing still is no yardstick [m/s]."""

WALKED_ON = 5.0
"""A body that walks for so long after a push has recovered [s]."""

BACK_STEPS, BACK_OFFSET, BACK_TIME = 4, (0.03, 0.015), 0.02
"""Likewise one whose last steps are like those before: how many, difference of the DCM offset in x
and y [m], and of the duration [s]. In x there is the speed that makes up for the lost way."""

MONITOR = np.dtype(
    [
        ("touchdown_time", "f8", (3,)),
        ("touchdown_com", "f8", (3, 2)),
        ("error", "f8"),
        ("last_error", "f8"),
        ("touchdowns", "i8"),
        ("support_side", "i8"),
    ],
)
"""What the rule remembers: time [s] and CoM [m] at the last touchdowns, the latest last; the
largest DCM error of the step under way and of the last finished one [m]."""


class Outcome(Enum):
    """How a walk ended."""

    WALKED = "walked"
    """Nothing pushed it, and it walks at the commanded velocity."""
    RECOVERED = "recovered"
    """It was pushed, and is back on the nominal gait."""
    UNSETTLED = "unsettled"
    """It walks, but was not back on the nominal gait when the run ended."""
    FELL = "fell"
    """The DCM ran away from the support foot."""
    CUT_SHORT = "cut short"
    """Nobody knows: the end is lost, see `Rollout.lost_cycles`."""


@dataclass(frozen=True)
class Fall:
    """The evidence of a fall.

    Attributes:
        time: when the DCM was out of all reach [s].
        distance: from the support foot to the DCM then [m].
        last_viable_time: last touchdown whose DCM offset could still be saved by stepping, or
            None if none could [s].
        last_margin: distance of that offset to the nearest bound of the viable set [m].
        lost_time: first touchdown whose offset could not be saved any more, or None if the
            robot fell before a touchdown showed it [s].
        lost_margin: how far that offset was outside, a negative number [m].
        limit: which bound was crossed: "forward", "backward", "left" or "right".
    """

    time: float
    distance: float
    last_viable_time: float | None
    last_margin: float | None
    lost_time: float | None
    lost_margin: float | None
    limit: str


@njit
def watch(monitor, observation, command):
    """Take one cycle, observation and the command that answered it, into the monitor."""
    if observation.support_side != monitor.support_side:
        monitor.support_side = observation.support_side
        monitor.touchdowns += 1
        for k in range(2):
            monitor.touchdown_time[k] = monitor.touchdown_time[k + 1]
            for i in range(2):
                monitor.touchdown_com[k, i] = monitor.touchdown_com[k + 1, i]
        monitor.touchdown_time[2] = observation.time
        for i in range(2):
            monitor.touchdown_com[2, i] = observation.com[i]
        monitor.last_error, monitor.error = monitor.error, 0.0
    error = length(
        observation.dcm[0] - command.dcm_plan[0], observation.dcm[1] - command.dcm_plan[1]
    )
    monitor.error = max(monitor.error, error)


@njit
def mean_velocity(monitor):
    """Mean velocity over the last two finished steps (x, y) [m/s]; NaN before there are two."""
    if monitor.touchdowns < 3:
        return math.nan, math.nan
    duration = monitor.touchdown_time[2] - monitor.touchdown_time[0]
    return (
        (monitor.touchdown_com[2, 0] - monitor.touchdown_com[0, 0]) / duration,
        (monitor.touchdown_com[2, 1] - monitor.touchdown_com[0, 1]) / duration,
    )


@njit
def is_settled(monitor, velocity_x: float, velocity_y: float) -> bool:
    """Whether the robot is on the nominal gait again; see the head of this file."""
    mean_x, mean_y = mean_velocity(monitor)
    allowed = max(SETTLED_VELOCITY * length(velocity_x, velocity_y), SETTLED_SLOWEST)
    # Comparisons with NaN are false: nobody is settled before two steps are finished.
    return (
        monitor.last_error < SETTLED_ERROR
        and length(mean_x - velocity_x, mean_y - velocity_y) <= allowed
    )


@njit
def watch_all(monitors, observations, commands):
    """Take a whole log into a monitor: arrays of records of the same length."""
    for i in range(observations.shape[0]):
        watch(monitors[0], observations[i], commands[i])


def has_walked_on(steps: Sequence[Footstep], pushes: Sequence[Push], end: float) -> bool:
    """Whether a body that did not fall has recovered from its pushes.

    Args:
        steps: the finished ones.
        pushes: those that have begun.
        end: of the run [s].
    """
    first, last = min(push.start for push in pushes), max(push.end for push in pushes)
    if end - last >= WALKED_ON:
        return True
    usual = {}
    for step in steps:
        if step.start + step.duration <= first:
            usual[step.side] = step
    since = [step for step in steps if step.start >= last][-BACK_STEPS:]
    if len(since) < BACK_STEPS or len(usual) < 2:
        return False
    return all(_is_like(step, usual[step.side]) for step in since)


def _is_like(step: Footstep, usual: Footstep) -> bool:
    away = np.abs(np.subtract(step.dcm_offset, usual.dcm_offset))
    return bool((away < BACK_OFFSET).all()) and abs(step.duration - usual.duration) < BACK_TIME

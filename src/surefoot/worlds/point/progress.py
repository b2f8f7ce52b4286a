"""When a walk of a batch ends, and how: one rule for compiled walks and for those in Python."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.dcm.viability import viable_offsets
from surefoot.interface import COMMAND, OBSERVATION, Command, Controller
from surefoot.record import copy_array, new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.outcome import (
    MONITOR,
    SETTLED,
    is_settled,
    settled_error,
    settled_rule,
    watch,
)
from surefoot.worlds.point.plant import LIPM_WORLD

PROGRESS = np.dtype(
    [
        ("quiet_time", "f8"),
        ("duration", "f8"),
        ("rule", SETTLED),
        ("viable_min", "f8", (2, 2)),
        ("viable_max", "f8", (2, 2)),
        ("ends_early", "?"),
        ("cycles", "i8"),
        ("steps", "i8"),
        ("steps_pushed", "i8"),
        ("recovery_time", "f8"),
        ("recovery_steps", "i8"),
        ("margin", "f8"),
        ("dcm_error", "f8"),
        ("ended", "?"),
        ("fallen", "?"),
        ("settled", "?"),
    ],
)
"""The question: when the last push is over and when the walk is [s], what is settled, the DCM
offsets at touchdown that can be saved, by the side that has landed [m], and whether the walk ends
once it is settled. And how it stands: cycles, finished steps, those of them that were finished
before the last push was over, what became of the push (see `WALK_RESULT`), and how it ended."""

WALK_RESULT = np.dtype(
    [
        ("end_time", "f8"),
        ("cycles", "i8"),
        ("steps", "i8"),
        ("fallen", "?"),
        ("settled", "?"),
        ("recovery_time", "f8"),
        ("recovery_steps", "i8"),
        ("margin", "f8"),
        ("dcm_error", "f8"),
        ("final", OBSERVATION),
    ],
)
"""One walk: when it ended [s], cycles, finished steps, whether it fell and whether it was settled
on its gait; from the end of the last push to the first touchdown at which it was settled, the time
[s] and the steps finished, NaN and -1 if there was none; of all touchdowns the least margin: how
far the DCM offset was inside of what stepping can save, with a whole sole and a leg without limits,
negative outside [m]; the largest DCM error [m]; and the last observation."""


@njit
def _margin(progress, observation) -> float:
    """How far the DCM offset is inside of what can be saved, negative outside [m]."""
    row = 0 if observation.support_side > 0 else 1
    least = math.inf
    for i in range(2):
        offset = observation.dcm[i] - observation.support_foot[i]
        least = min(least, offset - progress.viable_min[row, i])
        least = min(least, progress.viable_max[row, i] - offset)
    return least


@njit
def judge(monitor, world, command, progress):
    """Take a cycle into the monitor and judge whether the walk has ended, and how.

    It ends with a fall, when its time is over, or, if it ends early, at the first touchdown after
    `quiet_time` at which it is settled; see `rollout.outcome`.

    Args:
        monitor: a `MONITOR` record.
        world: a `LIPM_WORLD` record.
        command: the `COMMAND` record that answers it.
        progress: a `PROGRESS` record, written.
    """
    observation, quiet = world.observation, progress.quiet_time
    landed = observation.support_side != monitor.support_side
    watch(monitor, observation, command)
    progress.cycles += 1
    progress.dcm_error = max(progress.dcm_error, monitor.error)
    recovered = False
    if landed:
        progress.margin = min(progress.margin, _margin(progress, observation))
        # The first touchdown is where the walk begins.
        progress.steps = monitor.touchdowns - 1
        if observation.time <= quiet:
            progress.steps_pushed = progress.steps
        elif progress.recovery_steps < 0:
            recovered = is_settled(monitor, progress.rule)
    progress.fallen = world.fallen != 0
    if recovered and not progress.fallen:
        progress.recovery_time = observation.time - quiet
        progress.recovery_steps = progress.steps - progress.steps_pushed
    over = progress.fallen or observation.time >= progress.duration
    progress.ended = over or (progress.ends_early and progress.recovery_steps >= 0)
    if progress.ended:
        settled = is_settled(monitor, progress.rule)
        progress.settled = settled and not progress.fallen


@njit
def finish(progress, observation, result):
    """Write the `WALK_RESULT` of a walk whose last observation this is."""
    result.end_time, result.final = observation.time, observation
    result.cycles, result.steps = progress.cycles, progress.steps
    result.fallen, result.settled = progress.fallen, progress.settled
    result.recovery_time = progress.recovery_time
    result.recovery_steps = progress.recovery_steps
    result.margin, result.dcm_error = progress.margin, progress.dcm_error


def new_progress(
    robot: Robot,
    controller: Controller,
    duration: float,
    *,
    quiet_time: float = 0.0,
    ends_early: bool = False,
) -> NDArray[np.void]:
    """A walk that has not begun, shape (1,).

    Args:
        robot: that is moved; a whole sole counts for what it can save.
        controller: whose gait it is to walk.
        duration: how long to walk at most [s].
        quiet_time: when the last push is over [s].
        ends_early: whether the walk ends once it is settled after that.
    """
    progress = new_array(PROGRESS)
    progress["rule"] = settled_rule(robot, controller.gait.velocity, settled_error(controller))
    progress["quiet_time"], progress["duration"] = quiet_time, duration
    progress["ends_early"] = ends_early
    for row, side in enumerate((Side.RIGHT, Side.LEFT)):
        # The foot that has landed is not the one that stood during the step.
        bounds = viable_offsets(robot, Side(-side), robot.foot.half)
        progress["viable_min"][0, row], progress["viable_max"][0, row] = bounds.lower, bounds.upper
    progress["margin"], progress["recovery_time"] = math.inf, math.nan
    progress["recovery_steps"] = -1
    return progress


@njit
def _judge(monitor, world, command, progress):
    judge(monitor[0], world[0], command[0], progress[0])


@njit
def _finish(progress, observation, result):
    finish(progress[0], observation[0], result[0])


class Judge:
    """Judges a walk in Python, cycle by cycle; the same kernels as in a batch.

    Args:
        progress: a `PROGRESS` record of a walk that has not begun, shape (1,); not changed.
        monitor: of a walk that is under way, shape (1,); not changed.
    """

    def __init__(self, progress: NDArray[np.void], monitor: NDArray[np.void] | None = None) -> None:
        self._progress = copy_array(progress)
        self._monitor = new_array(MONITOR) if monitor is None else copy_array(monitor)

    def fork(self, quiet_time: float) -> Judge:
        """A copy that goes on by itself.

        Args:
            quiet_time: when its last push is over [s].
        """
        other = Judge(self._progress, self._monitor)
        other._progress["quiet_time"] = quiet_time
        return other

    @property
    def ended(self) -> bool:
        """Whether the walk has ended."""
        return bool(self._progress["ended"][0])

    def judge(self, world: NDArray[np.void], command: Command) -> bool:
        """Take in a cycle, and say whether the walk has ended."""
        _compiled()[0](self._monitor, world, command.array, self._progress)
        return self.ended

    def finish(self, observation: NDArray[np.void], result: NDArray[np.void]) -> None:
        """Write the `WALK_RESULT` of a walk whose last observation this is, shape (1,)."""
        _compiled()[1](self._progress, copy_array(observation), result)


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    return (
        entry_point(_judge, MONITOR, LIPM_WORLD, COMMAND, PROGRESS),
        entry_point(_finish, PROGRESS, OBSERVATION, WALK_RESULT),
    )

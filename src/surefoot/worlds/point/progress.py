"""When a walk of a batch ends, and how: one rule for compiled walks and for those in Python."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.dcm.viability import viable_offsets
from surefoot.interface import COMMAND, OBSERVATION, Command, Controller, Observation
from surefoot.record import Array, Record, copy_array, field, new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.outcome import (
    MONITOR,
    Settled,
    is_settled,
    settled_error,
    settled_rule,
    watch,
)
from surefoot.worlds.point.plant import LIPM_WORLD


class Progress(Record):
    """What is asked of a walk, and how it stands."""

    quiet_time: float = field("s", "when the last push is over")
    duration: float = field("s", "when the walk is over")
    rule: Settled = field("", "by which it is settled")
    viable_min: Array = field(
        "m",
        "least DCM offset at touchdown that can be saved, by the side that landed",
        shape=(2, 2),
    )
    viable_max: Array = field("m", "likewise the largest", shape=(2, 2))
    ends_early: bool = field("", "whether the walk ends once it is settled")
    cycles: int = field("-", "so far")
    steps: int = field("-", "finished")
    steps_pushed: int = field("-", "those that were finished before the last push was over")
    recovery_time: float = field("s", "as in `WalkResult`")
    recovery_steps: int = field("-", "likewise")
    margin: float = field("m", "likewise")
    dcm_error: float = field("m", "likewise")
    ended: bool = field("", "whether the walk is over")
    fallen: bool = field("", "whether it ended with a fall")
    settled: bool = field("", "whether it was settled when it ended")


class WalkResult(Record):
    """One walk of a batch."""

    end_time: float = field("s", "when it ended")
    cycles: int = field("-", "of control")
    steps: int = field("-", "finished")
    fallen: bool = field("", "whether it fell")
    settled: bool = field("", "whether it was settled on its gait")
    recovery_time: float = field(
        "s",
        "from the end of the last push to the first touchdown at which it was settled, else NaN",
    )
    recovery_steps: int = field("-", "the steps finished between these, -1 if there was none")
    margin: float = field(
        "m",
        "of all touchdowns the least: how far the DCM offset was inside of what stepping can save, "
        "with a whole sole and a leg without limits, negative outside",
    )
    dcm_error: float = field("m", "the largest one")
    final: Observation = field("", "the last one")


PROGRESS, WALK_RESULT = Progress.DTYPE, WalkResult.DTYPE


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
        monitor: a `Monitor`.
        world: a `LipmWorld`.
        command: the `Command` that answers it.
        progress: a `Progress`, written.
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
            late = observation.time - quiet >= progress.rule.time
            late = late and progress.steps - progress.steps_pushed >= progress.rule.steps
            recovered = late and is_settled(monitor, progress.rule)
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
    """Write the `WalkResult` of a walk whose last observation this is."""
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
        progress: a `Progress` of a walk that has not begun, shape (1,); not changed.
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
        """Write the `WalkResult` of a walk whose last observation this is, shape (1,)."""
        _compiled()[1](self._progress, copy_array(observation), result)


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    return (
        entry_point(_judge, MONITOR, LIPM_WORLD, COMMAND, PROGRESS),
        entry_point(_finish, PROGRESS, OBSERVATION, WALK_RESULT),
    )

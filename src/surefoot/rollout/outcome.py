"""How a walk ended, and the rule by which a robot counts as recovered.

Recovered: the DCM error over the last finished step is below 4 % of the room R of the gait, and the
mean velocity over the last two is within 2 % of the command (or 0.36 % of sqrt(g h), where that is
more): on the paper's biped 1 cm and 0.01 m/s. A body in physics, which is never as exact, has
recovered if it walks on for 16 / omega, or takes its last steps as before the push; so has a point
mass on heavy legs that walks on. All is said in
the robot's own lengths and times, so that robots that are alike but for their size end alike.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.dcm.nominal_gait import gait_room
from surefoot.dcm.pushes import Push
from surefoot.errors import RobotError
from surefoot.geometry import length
from surefoot.interface import Controller
from surefoot.record import Array, Record, Vector2, Vector3, field
from surefoot.robot.feet import Footstep
from surefoot.robot.robot import Robot

SETTLED_ROOM = 0.04
"""Largest DCM error of a settled step, as a fraction of how much the gait could bear."""

SETTLED_VELOCITY = 0.02
"""Largest deviation of the mean velocity, as a fraction of the command."""

SETTLED_SLOWEST = 0.0036
"""Deviation that is always allowed, as a fraction of sqrt(g h): the command may be 0."""

RECOVERY_TIME, RECOVERY_STEPS = 28.0, 16.0
"""A point mass that is not back on the nominal gait this long after a push has not recovered: in
1 / omega, and in T_nom where that is longer."""

BODY_RECOVERY_TIME, BODY_RECOVERY_STEPS = 16.0, 8.0
"""A body that walks for so long after a push has recovered, and a point mass on heavy legs:
likewise. It is never as exact, and need not be back on its gait."""

BACK_STEPS, BACK_OFFSET, BACK_TIME = 4, (0.0375, 0.01875), 0.04
"""Likewise one whose last steps are like those before: how many; difference of the DCM offset in x
and y, in heights of the CoM, and of the duration, as a fraction of it. In x there is the speed that
makes up for the lost way."""


class Settled(Record):
    """The rule by which a robot is settled on its gait."""

    velocity: Vector2 = field("m/s", "commanded")
    deviation: float = field("m/s", "how far the mean velocity may be from that")
    error: float = field("m", "largest DCM error")
    time: float = field("s", "from the last push on, not sooner", default=0.0)
    steps: int = field("-", "likewise", default=0)


class Monitor(Record):
    """What the rule remembers of a walk; of touchdowns the last three, the latest last."""

    touchdown_time: Vector3 = field("s", "of the touchdowns")
    touchdown_com: Array = field("m", "centre of mass at these", shape=(3, 2))
    error: float = field("m", "largest DCM error of the step under way")
    last_error: float = field("m", "likewise of the last finished one")
    touchdowns: int = field("-", "how many there were")
    support_side: int = field("", "the foot that stands, a `Side`")


SETTLED, MONITOR = Settled.DTYPE, Monitor.DTYPE


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
    """Not known: the end is lost, see `Rollout.lost_cycles`."""


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
def is_settled(monitor, rule) -> bool:
    """Whether the robot is on the nominal gait again; see the head of this file.

    Args:
        monitor: a `Monitor`.
        rule: a `Settled`.
    """
    mean_x, mean_y = mean_velocity(monitor)
    velocity = rule.velocity
    # Comparisons with NaN are false: no walk is settled before two steps are finished.
    return (
        monitor.last_error < rule.error
        and length(mean_x - velocity[0], mean_y - velocity[1]) <= rule.deviation
    )


def settled_error(controller: Controller) -> float:
    """The largest DCM error of a step that is settled, 4 % of the room of the gait [m].

    The room is what `dcm.nominal_gait.gait_room` says of a whole sole. A leg that cannot step
    at all has none: then it is that of one without limits.
    """
    robot, gait = controller.robot, controller.gait
    try:
        room = gait_room(robot, gait, robot.foot.half)
    except RobotError:
        free = robot.with_leg(max_speed=math.inf, max_acceleration=math.inf)
        room = gait_room(free, gait, robot.foot.half)
    return SETTLED_ROOM * room


def settled_rule(robot: Robot, velocity: tuple[float, float], error: float) -> NDArray[np.void]:
    """A `Settled` as an array, shape (1,).

    Args:
        robot: that is moved.
        velocity: commanded [m/s].
        error: of `settled_error` [m].
    """
    if robot.legs is not None and robot.legs.heavy:
        time, steps = BODY_RECOVERY_TIME / robot.omega, round(BODY_RECOVERY_STEPS)
        return Settled(
            velocity=velocity, deviation=math.inf, error=math.inf, time=time, steps=steps
        ).array
    slowest = SETTLED_SLOWEST * math.sqrt(robot.gravity * robot.com_height)
    deviation = max(SETTLED_VELOCITY * math.hypot(*velocity), slowest)
    return Settled(velocity=velocity, deviation=deviation, error=error).array


def recovery_time(controller: Controller) -> float:
    """How long after a push a robot must be back on its gait [s].

    From any state that can be saved a gait that is stepped by is back in a number of steps that
    does not depend on the state but by its logarithm: N <= ln(M / m0) / (omega T_min) + 1, as long
    as each of them takes T_min. That is a time in 1 / omega where steps are quick, and a number of
    steps where a robot takes its time: on the paper's biped 8 s are 16 steps of 0.5 s.
    """
    return max(
        RECOVERY_TIME / controller.robot.omega, RECOVERY_STEPS * controller.gait.step_duration
    )


@njit
def watch_all(monitors, observations, commands):
    """Take a whole log into a monitor: arrays of records of the same length."""
    for i in range(observations.shape[0]):
        watch(monitors[0], observations[i], commands[i])


def has_walked_on(
    robot: Robot, steps: Sequence[Footstep], pushes: Sequence[Push], end: float
) -> bool:
    """Whether a body that did not fall has recovered from its pushes.

    Args:
        robot: whose body it is.
        steps: the finished ones.
        pushes: those that have begun.
        end: of the run [s].
    """
    first, last = min(push.start for push in pushes), max(push.end for push in pushes)
    usual = {}
    for step in steps:
        if step.start + step.duration <= first:
            usual[step.side] = step
    longest = max((step.duration for step in usual.values()), default=0.0)
    if end - last >= max(BODY_RECOVERY_TIME / robot.omega, BODY_RECOVERY_STEPS * longest):
        return True
    since = [step for step in steps if step.start >= last][-BACK_STEPS:]
    if len(since) < BACK_STEPS or len(usual) < 2:
        return False
    return all(_is_like(robot, step, usual[step.side]) for step in since)


def _is_like(robot: Robot, step: Footstep, usual: Footstep) -> bool:
    away = np.abs(np.subtract(step.dcm_offset, usual.dcm_offset)) / robot.com_height
    late = abs(step.duration - usual.duration) / usual.duration
    return bool((away < BACK_OFFSET).all()) and late < BACK_TIME

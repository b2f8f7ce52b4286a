"""A walk in physics up to a push, and what comes of pushes from there.

The world is forked where the push begins, and every fork gets a control of its own: a solver that
starts from its last answer would make the outcome depend on what was asked before.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from surefoot.dcm.pushes import Push
from surefoot.interface import Controller
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.multibody import SIDES, Multibody, load_multibody
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import WALKING
from surefoot.studies.compare.body_protocol import (
    PUSH_DURATION,
    PUSHED_STEP,
    RECOVERY_TIME,
    BodyCell,
    BodyProtocol,
    body_method,
    push_of,
)
from surefoot.studies.compare.body_settling import BegunStep, Settling, Steps
from surefoot.worlds.body.controller import BodyControl
from surefoot.worlds.body.gait import body_control, walking_robot
from surefoot.worlds.body.plant import STANDS
from surefoot.worlds.body.sensors import usual_estimator
from surefoot.worlds.body.world import BodyWorld
from surefoot.worlds.steering import Steering
from surefoot.worlds.walk import Walk

LONGEST_APPROACH = 15.0
"""A robot that has not come to the step that is pushed by then never does [s]."""

STUCK = 2.0
"""A robot that stands on one foot for longer than this does not walk on [s]."""

BEFORE_PUSH = "before the push"
"""The cause of a fall that no push brought about."""

NO_STEP = "stopped stepping"
"""The cause if it stands, but does not walk."""


@lru_cache(maxsize=4)
def mechanism_of(robot: Robot) -> Multibody:
    """The mechanism of a robot, made once.

    Raises:
        RobotError: the robot has no `[body]`, or its model is not there.
    """
    return load_multibody(robot)


@lru_cache(maxsize=16)
def controller_of(protocol: BodyProtocol, key: str) -> Controller:
    """The controller of a method.

    Raises:
        SurefootError: the method cannot control this robot.
    """
    robot = walking_robot(mechanism_of(protocol.robot))
    return body_method(key).make(robot, protocol.velocity)


def control_of(protocol: BodyProtocol, key: str) -> BodyControl:
    """What walks the body with a method; new, with a solver that remembers nothing.

    Raises:
        SurefootError: the method cannot control this robot.
    """
    return body_control(controller_of(protocol, key), mechanism_of(protocol.robot))


@dataclass(frozen=True)
class Moment:
    """A walk at a moment, from which forks go on; a value, as long as it does not go on itself.

    Attributes:
        walk: up to now.
        cycles: how many there were since it was forked.
        settled: whether the robot is back in its gait.
        usual: the last steps of the walk so far, by side, if it was not pushed.
    """

    walk: Walk[BodyWorld]
    cycles: int
    settled: bool = False
    usual: Mapping[int, BegunStep] = field(default_factory=dict)

    @property
    def time(self) -> float:
        """Now [s]."""
        return self.walk.time

    @property
    def fate(self) -> int:
        """What has become of the robot, see `worlds.body.plant`."""
        return self.walk.world.fate


Watched = Callable[[BodyWorld], None]
"""Called after every decision, before physics goes on."""


def walk_to(protocol: BodyProtocol, key: str, foot: str, phase: float) -> Moment:
    """Walk from a stand to a phase of a step.

    Args:
        protocol: the questions.
        key: of the method.
        foot: that stands in that step, "left" or "right".
        phase: part of the step that is over.

    Returns:
        The moment; its fate tells whether the robot has come that far.
    """
    control, support = control_of(protocol, key), SIDES.index(foot)
    estimator = usual_estimator(control.multibody, protocol.noise) if protocol.estimate else None
    retained = LONGEST_APPROACH + PUSH_DURATION + RECOVERY_TIME
    world = BodyWorld(control, None, protocol.noise, estimator, retained=retained)
    walk = Walk(world, plan=[(0.0, Steering(protocol.velocity))])
    steps, usual = Steps(), {}

    def due(world: BodyWorld) -> bool:
        now, begun = world.state.walk[0], steps.begun(world.state)
        if begun is not None:
            usual[begun.side] = begun
        if now["phase"] != WALKING or now["steps"] < PUSHED_STEP or now["support"] != support:
            return False
        # The next cycle is the first of the push.
        elapsed = now["now"] + TIME_STEP - now["began"]
        return bool(elapsed >= phase * world.state.command.step_duration - 1e-9)

    walk.run(LONGEST_APPROACH, due)
    return Moment(walk, world.cycles, usual=usual)


@lru_cache(maxsize=2)
def moment_of(protocol: BodyProtocol, key: str, foot: str, phase: float) -> Moment:
    """`walk_to`, with the last ones kept: neighbouring cells begin alike."""
    return walk_to(protocol, key, foot, phase)


def push_from(
    moment: Moment, push: Push, recorded: bool = False, watch: Watched | None = None
) -> Moment:
    """What comes of a push: the moment 5 s after it, that of the fall, or that of the gait.

    Args:
        moment: where the push begins; it is not used up.
        push: the push.
        recorded: whether its record is kept; then it is walked to the end, also in the gait.
        watch: called in every cycle.
    """
    walk = moment.walk.fork(recorded, watch)
    walk.push(push)
    settling = Settling(moment.usual, push.end)

    def over(world: BodyWorld) -> bool:
        now = world.state.walk["now"][0] - world.state.walk["began"][0]
        return bool(now > STUCK or (not recorded and settling.done(world.state)))

    walk.run(moment.time + PUSH_DURATION + RECOVERY_TIME, over)
    cycles = walk.world.cycles - moment.walk.world.cycles
    settled = not walk.fallen and settling.done(walk.world.state)
    return Moment(walk, cycles, settled, moment.usual)


def survived(end: Moment) -> bool:
    """Whether the robot still walks."""
    whole = end.cycles == round((PUSH_DURATION + RECOVERY_TIME) / TIME_STEP)
    return end.fate == STANDS and (whole or end.settled)


def pushed_rollout(
    moment: Moment, push: Push, watch: Watched | None = None
) -> tuple[Rollout, Moment]:
    """A walk with a push from its beginning to its end, as `simulate_body` returns it.

    Args:
        moment: where the push begins.
        push: the push.
        watch: called in every cycle after the push has begun.

    Returns:
        The rollout and the last moment.
    """
    end = push_from(moment, push, True, watch)
    return end.walk.rollout(), end


def measure(protocol: BodyProtocol, cell: BodyCell) -> dict[str, Any]:
    """One row of the table: the smallest push of a cell that the robot does not survive.

    Args:
        protocol: the questions.
        cell: the one to answer.

    Returns:
        The cell, `impulse` (smallest failing, inf if none is), `scanned` and `step` [N s],
        `delta_v` [m/s], and of the fall `cause`, `words` and `fall_after` the push began [s].
    """
    before = time.perf_counter()
    mass = mechanism_of(protocol.robot).mass
    moment = moment_of(protocol, cell.method, cell.foot, cell.phase)
    impulse, scanned, cause, words, after = np.inf, 0.0, "", "", 0.0
    if moment.fate or moment.cycles == round(LONGEST_APPROACH / TIME_STEP):
        impulse, cause, words = 0.0, BEFORE_PUSH, "it does not walk that far without a push"
    else:
        for scanned in protocol.impulses(mass):
            push = push_of(cell, moment.time, scanned)
            end = push_from(moment, push)
            if not survived(end):
                impulse, after = scanned, end.time - moment.time
                cause, words = _cause(moment, push)
                break
    return {
        **asdict(cell),
        "impulse": float(impulse),
        "delta_v": float(impulse) / mass,
        "step": protocol.step,
        "scanned": scanned,
        "cause": cause,
        "words": words,
        "fall_after": after,
        "seconds": time.perf_counter() - before,
    }


def _cause(moment: Moment, push: Push) -> tuple[str, str]:
    """Why it fell: the same push once more, with everything taken down."""
    rollout, _ = pushed_rollout(moment, push)
    fall = rollout.body_fall
    if fall is None:
        return NO_STEP, f"it stood on one foot for {STUCK:g} s"
    return fall.cause.value, fall.sentence

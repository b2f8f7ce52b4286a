"""A walk in physics up to a push, and what comes of pushes from there.

The world is forked where the push begins, and every fork gets a control of its own: a solver that
starts from its last answer would make the outcome depend on what was asked before.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
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
from surefoot.worlds.body.controller import BodyControl, BodyState
from surefoot.worlds.body.gait import body_control, walking_robot
from surefoot.worlds.body.joint_command import JointCommand
from surefoot.worlds.body.plant import STANDS, BodyPlant
from surefoot.worlds.body.recorder import BodyRecorder, Record
from surefoot.worlds.body.recording import make_rollout, senses_words
from surefoot.worlds.body.sensors import BodySight, usual_estimator
from surefoot.worlds.steering import Steering

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
    """A walk at a moment, to be gone on with: a value, as long as nobody acts on its plant.

    Attributes:
        plant: the world.
        sight: what is seen of it.
        state: of the walker.
        command: of the last cycle.
        record: of the walk so far.
        fate: what has become of the robot, see `worlds.body.plant`.
        cycles: how many there were.
        settled: whether the robot is back in its gait.
        usual: the last steps of the walk so far, by side, if it was not pushed.
    """

    plant: BodyPlant
    sight: BodySight
    state: BodyState
    command: JointCommand | None
    record: Record
    fate: int
    cycles: int
    settled: bool = False
    usual: Mapping[int, BegunStep] = field(default_factory=dict)

    @property
    def time(self) -> float:
        """Now [s]."""
        return self.plant.time


Stop = Callable[[BodyState], bool]

Watch = Callable[[BodyControl, BodyState], None]
"""Called after every decision, before physics goes on."""


def unwatched(control: BodyControl, state: BodyState) -> None:
    """Look at nothing."""


def _walk(
    control: BodyControl,
    begin: Moment,
    steering: Steering,
    cycles: int,
    stop: Stop,
    recorded: bool,
    watch: Watch = unwatched,
) -> Moment:
    """Go on for some cycles, or until told to stop or down; `begin` is used up."""
    plant, sight, state, command = begin.plant, begin.sight, begin.state, begin.command
    told = sight.estimator is not None
    recorder = BodyRecorder(plant, state, told, cycles if recorded else 1)
    row, fate = 0, begin.fate
    while row < cycles and not fate:
        senses = sight.read(first=command is None)
        position, velocity, forces = sight.see(senses, state, command)
        command, state = control.step(state, plant.time, position, velocity, forces, steering)
        watch(control, state)
        if recorded:
            recorder.see(row, position, velocity)
            recorder.hear(row, state, command)
        plant.act(command)
        fate = plant.state()
        if recorded:
            recorder.feel(row, (0, 0, 0, 0))
        row += 1
        if stop(state):
            break
    record = recorder.record(row if recorded else 0)
    return Moment(plant, sight, state, command, record, fate, row)


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
    plant = BodyPlant(control.multibody)
    estimator = usual_estimator(control.multibody, protocol.noise) if protocol.estimate else None
    sight, state = BodySight(plant, protocol.noise, estimator), control.start()
    recorder = BodyRecorder(plant, state, protocol.estimate, 1)
    start = Moment(plant, sight, state, None, recorder.record(0), STANDS, 0)

    steps, usual = Steps(), {}

    def due(state: BodyState) -> bool:
        walk, begun = state.walk[0], steps.begun(state)
        if begun is not None:
            usual[begun.side] = begun
        if walk["phase"] != WALKING or walk["steps"] < PUSHED_STEP or walk["support"] != support:
            return False
        # The next cycle is the first of the push.
        elapsed = walk["now"] + TIME_STEP - walk["began"]
        return bool(elapsed >= phase * state.command.step_duration - 1e-9)

    cycles = round(LONGEST_APPROACH / TIME_STEP)
    end = _walk(control, start, Steering(protocol.velocity), cycles, due, True)
    return replace(end, usual=usual)


@lru_cache(maxsize=2)
def moment_of(protocol: BodyProtocol, key: str, foot: str, phase: float) -> Moment:
    """`walk_to`, with the last ones kept: neighbouring cells begin alike."""
    return walk_to(protocol, key, foot, phase)


def push_from(
    protocol: BodyProtocol,
    key: str,
    moment: Moment,
    push: Push,
    recorded: bool = False,
    watch: Watch = unwatched,
) -> Moment:
    """What comes of a push: the moment 5 s after it, that of the fall, or that of the gait.

    Args:
        protocol: the questions.
        key: of the method.
        moment: where the push begins; it is not used up.
        push: the push.
        recorded: whether its record is kept; then it is walked to the end, also in the gait.
        watch: called in every cycle.
    """
    plant = moment.plant.fork([push])
    sight = moment.sight.fork(plant)
    begin = Moment(plant, sight, moment.state, moment.command, moment.record, moment.fate, 0)
    cycles = round((PUSH_DURATION + RECOVERY_TIME) / TIME_STEP)

    settling = Settling(moment.usual, push.end)

    def over(state: BodyState) -> bool:
        stuck = state.walk["now"][0] - state.walk["began"][0] > STUCK
        return bool(stuck or (not recorded and settling.done(state)))

    steering = Steering(protocol.velocity)
    end = _walk(control_of(protocol, key), begin, steering, cycles, over, recorded, watch)
    return replace(end, settled=not end.fate and settling.done(end.state))


def survived(end: Moment) -> bool:
    """Whether the robot still walks."""
    whole = end.cycles == round((PUSH_DURATION + RECOVERY_TIME) / TIME_STEP)
    return end.fate == STANDS and (whole or end.settled)


def pushed_rollout(
    protocol: BodyProtocol, key: str, moment: Moment, push: Push, watch: Watch = unwatched
) -> tuple[Rollout, Moment]:
    """A walk with a push from its beginning to its end, as `simulate_body` returns it.

    Args:
        protocol: the questions.
        key: of the method.
        moment: where the push begins.
        push: the push.
        watch: called in every cycle after the push has begun.

    Returns:
        The rollout and the last moment.
    """
    end = push_from(protocol, key, moment, push, True, watch)
    control, steering = control_of(protocol, key), [(0.0, Steering(protocol.velocity))]
    senses = senses_words(end.sight.estimator, end.sight.noise)
    record = _joined(moment.record, end.record)
    return make_rollout(control, end.plant, record, end.fate, steering, senses), end


def _joined(first: Record, second: Record) -> Record:
    def both(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
        return {name: np.concatenate([one[name], other[name]]) for name in one}

    return Record(
        both(first.state, second.state),
        both(first.effect, second.effect),
        both(first.told, second.told),
        np.concatenate([first.clock, second.clock]),
    )


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
            end = push_from(protocol, cell.method, moment, push)
            if not survived(end):
                impulse, after = scanned, end.time - moment.time
                cause, words = _cause(protocol, cell.method, moment, push)
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


def _cause(protocol: BodyProtocol, key: str, moment: Moment, push: Push) -> tuple[str, str]:
    """Why it fell: the same push once more, with everything taken down."""
    rollout, _ = pushed_rollout(protocol, key, moment, push)
    fall = rollout.body_fall
    if fall is None:
        return NO_STEP, f"it stood on one foot for {STUCK:g} s"
    return fall.cause.value, fall.sentence

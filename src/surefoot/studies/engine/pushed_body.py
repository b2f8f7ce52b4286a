"""A walk in physics up to a push, and what comes of pushes from there.

The world is forked where the push begins, and every fork gets a control of its own: a solver that
starts from its last answer would make the outcome depend on what was asked before.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from surefoot.control.registry import find_method
from surefoot.control.unified.fixed_landing import fixed_place, fixed_timing
from surefoot.dcm.pushes import DIRECTIONS, Push, push_direction
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.multibody import SIDES, Multibody, load_multibody
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import WALKING
from surefoot.studies.engine.body_recovery import BegunStep, Settling, Steps
from surefoot.worlds.body.controller import BodyControl, BodyState
from surefoot.worlds.body.gait import body_control, body_controller, body_parameters, walking_robot
from surefoot.worlds.body.joint_command import JointCommand
from surefoot.worlds.body.noise import BodyNoise
from surefoot.worlds.body.plant import STANDS, BodyPlant
from surefoot.worlds.body.recorder import BodyRecorder, Record
from surefoot.worlds.body.recording import make_rollout, senses_words
from surefoot.worlds.body.sensors import BodySight, usual_estimator
from surefoot.worlds.steering import Steering

PUSH_DURATION = 0.2
"""How long every push lasts [s]."""

RECOVERY_TIME = 5.0
"""For so long a robot has to walk on after the push [s]."""

PUSHED_STEP = 8
"""No step before this one is pushed: two in place come first, then the gait settles."""

LONGEST_APPROACH = 15.0
"""A robot that has not come to the step that is pushed by then never does [s]."""

STUCK = 2.0
"""A robot that stands on one foot for longer than this does not walk on [s]."""

BEFORE_PUSH = "before the push"
"""The cause of a fall that no push brought about."""

NO_STEP = "stopped stepping"
"""The cause if it stands, but does not walk."""


@dataclass(frozen=True)
class BodyMethod:
    """A control method on a body.

    Attributes:
        key: its name on the command line.
        label: its name in tables.
        adapts: what it changes when the body is pushed.
        make: its controller, from robot and velocity.
    """

    key: str
    label: str
    adapts: str
    make: Callable[[Robot, tuple[float, float]], Controller]


def _published(key: str) -> BodyMethod:
    one = find_method(key)
    return BodyMethod(
        key, one.label, one.adapts, lambda robot, velocity: body_controller(key, robot, velocity)
    )


BODY_METHODS = (
    _published("tracking"),
    _published("capture-point"),
    _published("step-timing"),
    _published("hybrid"),
    BodyMethod(
        "unified-fixed-timing",
        "unified, timing fixed",
        "ZMP, step location",
        lambda robot, velocity: fixed_timing(robot, velocity, **body_parameters("unified", robot)),
    ),
    BodyMethod(
        "unified-fixed-place",
        "unified, place fixed",
        "ZMP, timing",
        lambda robot, velocity: fixed_place(robot, velocity, **body_parameters("unified", robot)),
    ),
    _published("unified"),
)
"""In the order in which they are shown."""


def body_method(key: str) -> BodyMethod:
    """A method by its name on the command line.

    Raises:
        ParameterError: there is none of that name for a body.
    """
    for one in BODY_METHODS:
        if one.key == key:
            return one
    names = ", ".join(one.key for one in BODY_METHODS)
    raise ParameterError(f"a method for a body ({names})", repr(key), "choose one of these")


@lru_cache(maxsize=4)
def mechanism_of(robot: Robot) -> Multibody:
    """The mechanism of a robot, made once.

    Raises:
        RobotError: the robot has no `[body]`, or its model is not there.
    """
    return load_multibody(robot)


@lru_cache(maxsize=16)
def controller_of(robot: Robot, key: str, velocity: tuple[float, float]) -> Controller:
    """The controller of a method on a body, made once.

    Args:
        robot: with a body.
        key: of the method.
        velocity: commanded [m/s].

    Raises:
        SurefootError: the method cannot control this robot.
    """
    return body_method(key).make(walking_robot(mechanism_of(robot)), velocity)


@dataclass(frozen=True)
class Checkpoint:
    """A walk at an instant, from which it can be continued: a value, as long as nobody acts on its
    plant.

    Attributes:
        plant: the world.
        sight: what is measured of it.
        state: of the control.
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

    @property
    def arrived(self) -> bool:
        """Whether the robot has come to the step that is pushed."""
        return not self.fate and self.cycles < round(LONGEST_APPROACH / TIME_STEP)

    @property
    def survived(self) -> bool:
        """Whether the robot still walks after its push."""
        whole = self.cycles == round((PUSH_DURATION + RECOVERY_TIME) / TIME_STEP)
        return self.fate == STANDS and (whole or self.settled)


Watch = Callable[[BodyControl, BodyState], None]
"""Called after every decision, before physics goes on."""


@dataclass(frozen=True)
class PushedBody:
    """A walk of a body that is pushed in a phase of a step.

    Args:
        robot: that is pushed; it has a `[body]`.
        method: key of `BODY_METHODS`.
        foot: that stands in the pushed step, "left" or "right".
        phase: part of the step that is over when the push begins.
        velocity: commanded [m/s].
        estimate: whether the control is given an estimate from sensors with the usual noise; else
            the truth.
    """

    robot: Robot
    method: str
    foot: str
    phase: float
    velocity: tuple[float, float] = (0.3, 0.0)
    estimate: bool = False

    def control(self) -> BodyControl:
        """What walks the body; new, with a solver that remembers nothing.

        Raises:
            SurefootError: the method cannot control this robot.
        """
        controller = controller_of(self.robot, self.method, self.velocity)
        return body_control(controller, mechanism_of(self.robot))

    @property
    def start(self) -> Checkpoint:
        """Where the push begins, with the last ones kept; it may be that the robot never arrives
        there."""
        return _approach(self)

    def push(self, direction: str, impulse: float) -> Push:
        """The push of this walk.

        Args:
            direction: one of `dcm.pushes.DIRECTIONS`.
            impulse: its strength [N s].
        """
        way = push_direction(DIRECTIONS[direction], Side[self.foot.upper()])
        return Push.of_impulse(impulse, way, self.start.time, PUSH_DURATION)

    def pushed(self, push: Push, recorded: bool = False, watch: Watch | None = None) -> Checkpoint:
        """What comes of a push: the walk 5 s after it, at its fall, or as soon as it is settled.

        Args:
            push: which begins where this walk is to be pushed.
            recorded: whether its record is kept; then it is walked to the end, also if settled.
            watch: called in every cycle.
        """
        start = self.start
        plant = start.plant.fork([push])
        begin = replace(start, plant=plant, sight=start.sight.fork(plant), cycles=0)
        settling = Settling(start.usual, push.end)

        def over(state: BodyState) -> bool:
            stuck = state.walk["now"][0] - state.walk["began"][0] > STUCK
            return bool(stuck or (not recorded and settling.done(state)))

        cycles = round((PUSH_DURATION + RECOVERY_TIME) / TIME_STEP)
        end = _walk(self, begin, cycles, over, recorded, watch)
        return replace(end, settled=not end.fate and settling.done(end.state))

    def rollout(self, push: Push, watch: Watch | None = None) -> tuple[Rollout, Checkpoint]:
        """The walk with a push from its beginning to its end, as `simulate_body` returns it.

        Args:
            push: which begins where this walk is to be pushed.
            watch: called in every cycle after the push has begun.

        Returns:
            The rollout and where it ends.
        """
        end = self.pushed(push, True, watch)
        record = _joined(self.start.record, end.record)
        senses = senses_words(end.sight.estimator, end.sight.noise)
        route = [(0.0, Steering(self.velocity))]
        return make_rollout(self.control(), end.plant, record, end.fate, route, senses), end


@lru_cache(maxsize=2)
def _approach(walk: PushedBody) -> Checkpoint:
    """Walk from a stand to where the push begins."""
    control, support = walk.control(), SIDES.index(walk.foot)
    plant, noise = BodyPlant(control.multibody), noise_of(walk.robot, walk.estimate)
    estimator = usual_estimator(control.multibody, noise) if walk.estimate else None
    sight, state = BodySight(plant, noise, estimator), control.start()
    recorder = BodyRecorder(plant, state, walk.estimate, 1)
    stand = Checkpoint(plant, sight, state, None, recorder.record(0), STANDS, 0)
    steps, usual = Steps(), {}

    def due(state: BodyState) -> bool:
        now, begun = state.walk[0], steps.begun(state)
        if begun is not None:
            usual[begun.side] = begun
        if now["phase"] != WALKING or now["steps"] < PUSHED_STEP or now["support"] != support:
            return False
        # The next cycle is the first of the push.
        elapsed = now["now"] + TIME_STEP - now["began"]
        return bool(elapsed >= walk.phase * state.command.step_duration - 1e-9)

    end = _walk(walk, stand, round(LONGEST_APPROACH / TIME_STEP), due, True)
    return replace(end, usual=usual)


def noise_of(robot: Robot, estimate: bool) -> BodyNoise | None:
    """The usual noise of the sensors of a robot, None if its control is given the truth."""
    return BodyNoise.of(robot) if estimate else None


def _walk(
    walk: PushedBody,
    begin: Checkpoint,
    cycles: int,
    stop: Callable[[BodyState], bool],
    recorded: bool,
    watch: Watch | None = None,
) -> Checkpoint:
    """Continue for some cycles, until `stop` or a fall; the plant of `begin` is used up."""
    control, steering = walk.control(), Steering(walk.velocity)
    plant, sight, state, command = begin.plant, begin.sight, begin.state, begin.command
    recorder = BodyRecorder(plant, state, walk.estimate, cycles if recorded else 1)
    row, fate = 0, begin.fate
    while row < cycles and not fate:
        senses = sight.read(first=command is None)
        position, velocity, forces = sight.see(senses, state, command)
        command, state = control.step(state, plant.time, position, velocity, forces, steering)
        if watch is not None:
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
    return Checkpoint(plant, sight, state, command, record, fate, row)


def _joined(first: Record, second: Record) -> Record:
    def both(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
        return {name: np.concatenate([one[name], other[name]]) for name in one}

    return Record(
        both(first.state, second.state),
        both(first.effect, second.effect),
        both(first.told, second.told),
        np.concatenate([first.clock, second.clock]),
    )

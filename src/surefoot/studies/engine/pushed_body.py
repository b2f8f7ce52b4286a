"""A walk in physics up to a push, and what comes of pushes from there.

The world is forked where the push begins, and every fork gets a control of its own: a solver that
starts from its last answer would make the outcome depend on what was asked before.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache, partial

from surefoot.control.registry import find_method
from surefoot.control.unified.controller import fixed_place, fixed_timing
from surefoot.dcm.pushes import DIRECTIONS, Push, push_direction
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import FEET, Side
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.multibody import Multibody, load_multibody
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import WALKING
from surefoot.studies.engine.body_recovery import BegunStep, Settling, Steps
from surefoot.worlds.body.controller import BodyControl
from surefoot.worlds.body.gait import body_control, body_controller, body_parameters, walking_robot
from surefoot.worlds.body.mapping import USUAL_MAPPING
from surefoot.worlds.body.sensors import BodyNoise, usual_estimator
from surefoot.worlds.body.world import BodyWorld
from surefoot.worlds.steering import Steering

PUSH_DURATION = 0.2
"""How long every push lasts [s]."""

TIME_AFTER_PUSH = 5.0
"""For so long a robot has to walk on after the push [s]."""

FIRST_PUSHED_STEP = 8
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
        sources: of the package that brings it, see `Method.sources`.
    """

    key: str
    label: str
    adapts: str
    make: Callable[[Robot, tuple[float, float]], Controller]
    sources: str = ""


def _published(key: str) -> BodyMethod:
    one = find_method(key)
    return BodyMethod(key, one.label, one.adapts, partial(body_controller, key), one.sources)


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
"""Those that are compared unless others are asked for, in the order in which they are shown; any
other of `control.registry` can be asked for."""


def body_method(key: str) -> BodyMethod:
    """A method by its name on the command line.

    Raises:
        ParameterError: there is none of that name for a body.
    """
    own = next((one for one in BODY_METHODS if one.key == key), None)
    if own is not None:
        return own
    try:
        return _published(key)
    except ParameterError as error:
        names = ", ".join(one.key for one in BODY_METHODS)
        expected = f"a method for a body ({names}, or any other that walks)"
        raise ParameterError(expected, error.got, "choose one of these") from error


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
    """A walk at an instant, from which forks continue; a value, as long as it does not itself.

    Attributes:
        walk: up to now.
        cycles: how many there were since it was forked.
        settled: whether the robot is back in its gait.
        usual: the last steps of the walk so far, by side, if it was not pushed.
    """

    walk: BodyWorld
    cycles: int
    settled: bool = False
    usual: Mapping[int, BegunStep] = field(default_factory=dict)

    @property
    def time(self) -> float:
        """Now [s]."""
        return self.walk.time

    @property
    def arrived(self) -> bool:
        """Whether the robot has come to the step that is pushed."""
        return not self.walk.fallen and self.cycles < round(LONGEST_APPROACH / TIME_STEP)

    @property
    def survived(self) -> bool:
        """Whether the robot still walks after its push."""
        whole = self.cycles == round((PUSH_DURATION + TIME_AFTER_PUSH) / TIME_STEP)
        return not self.walk.fallen and (whole or self.settled)


Watch = Callable[[BodyWorld], None]
"""Called after every decision, before physics continues."""


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
        mapping: what moves the joints, see `worlds.body.mapping`.
    """

    robot: Robot
    method: str
    foot: str
    phase: float
    velocity: tuple[float, float] = (0.3, 0.0)
    estimate: bool = False
    mapping: str = USUAL_MAPPING

    def control(self) -> BodyControl:
        """What walks the body; new, with a solver that remembers nothing.

        Raises:
            SurefootError: the method cannot control this robot.
        """
        controller = controller_of(self.robot, self.method, self.velocity)
        return body_control(controller, mechanism_of(self.robot), self.mapping)

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
        walk = start.walk.fork(recorded, watch)
        walk.push(push)
        settling = Settling(start.usual, push.end)

        def over(world: BodyWorld) -> bool:
            now = world.state.walk[0]
            stuck = now["now"] - now["began"] > STUCK
            return bool(stuck or (not recorded and settling.done(world.state)))

        walk.run(start.time + PUSH_DURATION + TIME_AFTER_PUSH, over)
        cycles = walk.cycles - start.walk.cycles
        return Checkpoint(walk, cycles, not walk.fallen and settling.done(walk.state))

    def rollout(self, push: Push, watch: Watch | None = None) -> tuple[Rollout, Checkpoint]:
        """The walk with a push from its beginning to its end, as `simulate_body` returns it.

        Args:
            push: which begins where this walk is to be pushed.
            watch: called in every cycle after the push has begun.

        Returns:
            The rollout and where it ends.
        """
        end = self.pushed(push, True, watch)
        return end.walk.rollout(), end


@lru_cache(maxsize=2)
def _approach(walk: PushedBody) -> Checkpoint:
    """Walk from a stand to where the push begins."""
    control, noise = walk.control(), noise_of(walk.robot, walk.estimate)
    estimator = usual_estimator(control.multibody, noise) if walk.estimate else None
    retained = LONGEST_APPROACH + PUSH_DURATION + TIME_AFTER_PUSH
    world = BodyWorld(control, None, noise, estimator, retained=retained)
    world.prepare(plan=[(0.0, Steering(walk.velocity))])
    support, steps, usual = FEET.index(walk.foot), Steps(), {}

    def due(world: BodyWorld) -> bool:
        now, begun = world.state.walk[0], steps.begun(world.state)
        if begun is not None:
            usual[begun.side] = begun
        if now["phase"] != WALKING or now["steps"] < FIRST_PUSHED_STEP or now["support"] != support:
            return False
        # The next cycle is the first of the push.
        elapsed = now["now"] + TIME_STEP - now["began"]
        return bool(elapsed >= walk.phase * world.state.command.step_duration - 1e-9)

    world.run(LONGEST_APPROACH, due)
    return Checkpoint(world, world.cycles, usual=usual)


def noise_of(robot: Robot, estimate: bool) -> BodyNoise | None:
    """The usual noise of the sensors of a robot, None if its control is given the truth."""
    return BodyNoise.of(robot) if estimate else None

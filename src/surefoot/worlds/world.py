"""What a walk happens in, and the one loop that walks a robot: steered, pushed, watched, forked.

A cycle has three parts. The world is observed: sensors measure it, and an estimator makes a state
of what they measure. The controller decides. Then the world acts: the robot moves under the command
and the pushes. What happened is recorded as far as it is retained.
`worlds.point.simulate.simulate` and `worlds.body.world.simulate_body` are the usual fronts.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Self

from surefoot.dcm.pushes import Push
from surefoot.interface import Controller
from surefoot.robot.robot import Robot
from surefoot.rollout.dump import Checkpoint
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot
from surefoot.worlds.steering import Steering

Route = tuple[tuple[float, Steering], ...]
"""Commands and when they begin to hold, in order of time [s]."""


class World(ABC):
    """A robot with its controller, between two cycles; a new one is at the start of its walk.

    Leaves: `worlds.point.world.PointWorld`, `worlds.body.world.BodyWorld`.

    Attributes:
        robot: the one that is moved.
        controller: what decides, for the velocity of now.
        state: after its last decision.
        steering: where the robot is to go.
        plan: the commands that are to hold later.
        watch: called with the world after every decision, before it acts.
    """

    robot: Robot
    controller: Controller
    state: Any
    steering: Steering
    plan: Route = ()
    watch: Callable[[Any], None] | None = None
    _pushes: tuple[Push, ...] = ()

    def prepare(
        self,
        pushes: Sequence[Push] = (),
        plan: Sequence[tuple[float, Steering]] = (),
        watch: Callable[[Any], None] | None = None,
    ) -> Self:
        """Set what is known before the walk.

        Args:
            pushes: that will act.
            plan: (time, command) in order of time; before the first one the robot walks as the
                world says [s].
            watch: see `World`.
        """
        self.pushes, self.plan, self.watch = tuple(pushes), tuple(plan), watch
        return self

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The forces that act on the robot, at their times."""
        return self._pushes

    @pushes.setter
    def pushes(self, pushes: tuple[Push, ...]) -> None:
        self._pushes = pushes
        self._set_pushes(pushes)

    def steer(self, steering: Steering) -> None:
        """Walk elsewhere from now on; what was planned for later is given up.

        Raises:
            VelocityError: the robot cannot walk so fast; it goes on as before.
        """
        self.follow(steering)
        self.plan = ()

    def push(self, push: Push) -> None:
        """Push the robot; what has begun in the past acts from now on."""
        first = self.first_time
        self.pushes = (*(one for one in self.pushes if one.end > first), push)

    def decide(self) -> None:
        """The first half of a cycle: the world is observed, and the controller decides."""
        while self.plan and self.time >= self.plan[0][0]:
            (since, steering), *later = self.plan
            self.follow(steering, since)
            self.plan = tuple(later)
        self.observe()
        self.answer()
        if self.watch is not None:
            self.watch(self)

    def step(self) -> None:
        """One cycle; nothing happens to a robot that has fallen."""
        if not self.fallen:
            self.decide()
            self.act()

    def run(self, until: float, stop: Callable[[Self], bool] | None = None) -> None:
        """All cycles up to a time or a fall.

        Args:
            until: when to end [s].
            stop: called after every cycle; the walk ends where it says so.
        """
        while not (self.fallen or self.has_reached(until)):
            self.decide()
            self.act()
            if stop is not None and stop(self):
                return

    def fork(self, recorded: bool = True, watch: Callable[[Any], None] | None = None) -> Self:
        """Another walk with the same past, which goes on by itself.

        Args:
            recorded: whether its cycles are retained, those so far among them.
            watch: called after each of its decisions.
        """
        other = copy.copy(self)
        other.watch = watch
        other._separate(recorded)
        return other

    def finish(self) -> None:
        """What is left to do at the end of a walk: a last cycle, as far as it is part of it."""
        self.step()

    @property
    @abstractmethod
    def time(self) -> float:
        """Now [s]."""

    @property
    @abstractmethod
    def first_time(self) -> float:
        """Of the first cycle that is retained [s]."""

    @property
    @abstractmethod
    def fallen(self) -> bool:
        """Whether the robot is down."""

    @property
    @abstractmethod
    def decision_time(self) -> float:
        """How long the last decision took, wall clock [s]."""

    @abstractmethod
    def has_reached(self, time: float) -> bool:
        """Whether it is this time, or later; compared as the world counts its cycles."""

    @abstractmethod
    def follow(self, steering: Steering, since: float | None = None) -> None:
        """Walk elsewhere; what is planned for later stays.

        Args:
            steering: where.
            since: when a planned command begins to hold; now if None [s].

        Raises:
            VelocityError: the robot cannot walk so fast; it goes on as before.
        """

    @abstractmethod
    def observe(self) -> None:
        """First part of a cycle: measure the world, and estimate its state."""

    @abstractmethod
    def answer(self) -> None:
        """Second part: what the controller decides."""

    @abstractmethod
    def act(self) -> None:
        """Third part: what the world does under the command and the pushes."""

    @abstractmethod
    def is_nan(self) -> bool:
        """Whether a number of the last command, or of what came of it, is NaN."""

    @abstractmethod
    def checkpoint(self) -> Checkpoint:
        """All that evolves, between two cycles, but for plan, pushes and what is retained."""

    @abstractmethod
    def resume(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint of such a walk, with nothing retained of what was before it."""

    @abstractmethod
    def snapshot(self) -> Snapshot:
        """What a picture of the last cycle needs; an IndexError if none is retained."""

    @abstractmethod
    def rollout(self) -> Rollout:
        """The walk so far, or as much of its end as is retained."""

    @abstractmethod
    def _set_pushes(self, pushes: tuple[Push, ...]) -> None:
        """Let these forces act from now on."""

    @abstractmethod
    def _separate(self, recorded: bool) -> None:
        """Share nothing that changes with the world that this is a copy of, nor what its solvers
        remember."""

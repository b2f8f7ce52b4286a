"""The one loop that walks a robot, in any world: steered, pushed, pictured and forked on its way.

`worlds.point.simulate.simulate` and `worlds.body.world.simulate_body` are its usual fronts.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Generic, Self, TypeVar

from surefoot.dcm.pushes import Push
from surefoot.interface import Controller
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot
from surefoot.worlds.steering import Steering
from surefoot.worlds.world import World

W = TypeVar("W", bound=World)


class Walk(Generic[W]):
    """A walk, cycle by cycle.

    Args:
        world: at the start of the walk.
        pushes: that are known beforehand.
        plan: (time, command) in order of time, that are known beforehand; before the first one the
            robot walks as its world says [s].
        watch: called after every decision, before the world acts.

    Attributes:
        world: what moves.
    """

    def __init__(
        self,
        world: W,
        pushes: Sequence[Push] = (),
        plan: Sequence[tuple[float, Steering]] = (),
        watch: Callable[[W], None] | None = None,
    ) -> None:
        self.world, self._watch = world, watch
        world.pushes, world.plan = tuple(pushes), tuple(plan)

    @property
    def robot(self) -> Robot:
        """The one that walks."""
        return self.world.robot

    @property
    def controller(self) -> Controller:
        """What decides, for the velocity of now."""
        return self.world.controller

    @property
    def steering(self) -> Steering:
        """Where it is to go."""
        return self.world.steering

    @property
    def time(self) -> float:
        """Now [s]."""
        return self.world.time

    @property
    def fallen(self) -> bool:
        """Whether the robot is down."""
        return self.world.fallen

    @property
    def decision_time(self) -> float:
        """How long the last decision took, wall clock [s]."""
        return self.world.decision_time

    def steer(self, steering: Steering) -> None:
        """Walk elsewhere from now on; what was planned for later is given up.

        Raises:
            VelocityError: the robot cannot walk so fast; it goes on as before.
        """
        self.world.steer(steering)
        self.world.plan = ()

    def push(self, push: Push) -> None:
        """Push the robot; what has begun in the past acts from now on."""
        first = self.world.first_time
        retained = (one for one in self.world.pushes if one.end > first)
        self.world.pushes = (*retained, push)

    def decide(self) -> None:
        """The first half of a cycle: the world is observed, and the controller decides."""
        world = self.world
        while world.plan and world.time >= world.plan[0][0]:
            (since, steering), *later = world.plan
            world.steer(steering, since)
            world.plan = tuple(later)
        world.observe()
        world.decide()
        if self._watch is not None:
            self._watch(world)

    def step(self) -> None:
        """One cycle; nothing happens to a robot that has fallen."""
        if not self.fallen:
            self.decide()
            self.world.act()

    def run(self, until: float, stop: Callable[[W], bool] | None = None) -> None:
        """All cycles up to a time or a fall.

        Args:
            until: when to end [s].
            stop: called after every cycle; the walk ends where it says so.
        """
        world = self.world
        while not (world.fallen or world.has_reached(until)):
            self.decide()
            world.act()
            if stop is not None and stop(world):
                return

    def fork(self, recorded: bool = True, watch: Callable[[W], None] | None = None) -> Self:
        """Another walk with the same past, which goes on by itself.

        Args:
            recorded: whether its cycles are retained, those so far among them.
            watch: called after each of its decisions.
        """
        other = copy.copy(self)
        other.world, other._watch = self.world.fork(recorded), watch
        return other

    def snapshot(self) -> Snapshot:
        """What a picture of the last cycle needs; an IndexError if none is retained."""
        return self.world.snapshot()

    def rollout(self) -> Rollout:
        """The walk so far, or as much of its end as is retained."""
        return self.world.rollout()

"""What a walk happens in: one protocol, with a point mass and a body in physics as its leaves.

A cycle has three parts. The world is observed: sensors measure it, and an estimator makes a state
of what they measure. The controller decides. Then the world acts: the robot moves under the command
and the pushes. What happened is recorded as far as it is retained.
"""

from __future__ import annotations

from typing import Any, Protocol, Self

from surefoot.dcm.pushes import Push
from surefoot.interface import Controller
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot
from surefoot.worlds.steering import Steering

Route = tuple[tuple[float, Steering], ...]
"""Commands and when they begin to hold, in order of time [s]."""


class World(Protocol):
    """A robot with its controller, between two cycles; a new one is at the start of its walk.

    Leaves: `worlds.point.world.PointWorld`, `worlds.body.world.BodyWorld`.

    Attributes:
        steering: where the robot is to go.
        plan: the commands that are to hold later.
    """

    steering: Steering
    plan: Route

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The forces that act on the robot, at their times."""
        ...

    @pushes.setter
    def pushes(self, pushes: tuple[Push, ...]) -> None: ...

    @property
    def robot(self) -> Robot:
        """The one that is moved."""
        ...

    @property
    def controller(self) -> Controller:
        """What decides, for the velocity of now."""
        ...

    @property
    def state(self) -> Any:
        """The controller's, after its last decision."""
        ...

    @property
    def time(self) -> float:
        """Now [s]."""
        ...

    @property
    def first_time(self) -> float:
        """Of the first cycle that is retained [s]."""
        ...

    @property
    def fallen(self) -> bool:
        """Whether the robot is down."""
        ...

    @property
    def decision_time(self) -> float:
        """How long the last decision took, wall clock [s]."""
        ...

    def has_reached(self, time: float) -> bool:
        """Whether it is this time, or later; compared as the world counts its cycles."""
        ...

    def steer(self, steering: Steering, since: float | None = None) -> None:
        """Walk elsewhere.

        Args:
            steering: where.
            since: when a planned command begins to hold; now if None [s].

        Raises:
            VelocityError: the robot cannot walk so fast; it goes on as before.
        """
        ...

    def observe(self) -> None:
        """First part of a cycle: measure the world, and estimate its state."""
        ...

    def decide(self) -> None:
        """Second part: what the controller answers."""
        ...

    def act(self) -> None:
        """Third part: what the world does under the command and the pushes."""
        ...

    def fork(self, recorded: bool = True) -> Self:
        """A copy that goes on by itself, with solvers that remember nothing of this one's.

        Args:
            recorded: whether its cycles are retained, those so far among them.
        """
        ...

    def snapshot(self) -> Snapshot:
        """What a picture of the last cycle needs.

        Raises:
            IndexError: no cycle is retained.
        """
        ...

    def rollout(self) -> Rollout:
        """The walk so far, or as much of its end as is retained."""
        ...

"""Where a simulator (or a robot) and what walks a body meet: its state in, motor commands out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from surefoot.interface import Command, Controller, Observation
from surefoot.worlds.body.joint_command import JointCommand
from surefoot.worlds.steering import Steering

if TYPE_CHECKING:
    # A trace of a walk is read without MuJoCo too.
    from surefoot.robot.multibody import Multibody


class WalkerState(Protocol):
    """What evolves in a `Walker`; a value."""

    @property
    def walk(self) -> NDArray[np.void]:
        """A record, shape (1,), with these fields among others.

        `phase`; `support`, 0 or 1 for the left or the right foot; `steps` done; `began`, when the
        step began [s]; `heading` of the frame that the controller walks in [rad]; `swing_foot`,
        reference of the swinging sole (x, y in the world, z over the standing one) [m].
        """
        ...

    @property
    def observation(self) -> Observation:
        """What the controller was told last, in its frame."""
        ...

    @property
    def command(self) -> Command:
        """What it answered, likewise."""
        ...

    @property
    def course(self) -> Any:
        """Where the robot should be: `place` (x, y) [m] and `heading` [rad]."""
        ...


class Walker(Protocol):
    """Anything that walks a body; `worlds.body.controller.BodyControl` does."""

    @property
    def controller(self) -> Controller:
        """What decides about steps, for the velocity that it was made for."""
        ...

    @property
    def multibody(self) -> Multibody:
        """The mechanism as it is believed to be."""
        ...

    def start(self) -> Any:
        """The state of a body that stands on both feet; a `WalkerState`."""
        ...

    def step(
        self,
        state: Any,
        time: float,
        position: NDArray[np.float64],
        velocity: NDArray[np.float64],
        forces: NDArray[np.float64],
        steering: Steering,
    ) -> tuple[JointCommand, Any]:
        """One cycle: what the motors are told, and the state for the next; never raises.

        Args:
            state: of the last cycle.
            time: now [s].
            position, velocity: generalised, as estimated; shapes (nq,), (nv,).
            forces: vertical, on left and right sole, shape (2,) [N].
            steering: where to go.
        """
        ...

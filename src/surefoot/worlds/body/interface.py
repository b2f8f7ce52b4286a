"""The seams of a body: state in and motor commands out, and the reference and the joints between.

A `BodyController` is given the state of a body and answers with a `JointCommand`, in a simulator or
on a robot. Inside, a `BODY_REFERENCE` says what the body is to do until the next cycle; it is made
from a `Command`, the same that drives the point mass, and a `JointMapping` carries it out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from surefoot.interface import Command, Controller, Observation
from surefoot.worlds.steering import Steering

if TYPE_CHECKING:
    # A trace of a walk is read without MuJoCo too.
    from surefoot.robot.multibody import Multibody
    from surefoot.worlds.body.mechanics import Mechanics


BODY_REFERENCE = np.dtype(
    [
        ("stands", "i8", (2,)),
        ("zmp", "f8", (2,)),
        ("com", "f8", (3,)),
        ("com_velocity", "f8", (3,)),
        ("com_acceleration", "f8", (3,)),
        ("swing_foot", "f8", (3,)),
        ("swing_foot_velocity", "f8", (3,)),
        ("swing_foot_acceleration", "f8", (3,)),
        ("swing_yaw", "f8"),
        ("swing_yaw_rate", "f8"),
        ("trunk", "f8", (3,)),
        ("trunk_yaw_rate", "f8"),
    ],
)
"""Which soles carry, left and right (1 or 0); where the ground should push [m]; CoM [m], velocity
and acceleration; centre of the swinging sole likewise; its heading [rad] and turning rate [rad/s];
roll, pitch and yaw of the trunk [rad] and its turning rate [rad/s].

With one foot on the ground it is the ZMP that counts for the CoM's horizontal motion, and with two
the acceleration; kinematic playback uses the CoM itself.
"""


class JointCommand:
    """What the motors of a body are to do in a cycle; its arrays are overwritten in every one.

    A motor gives torque + stiffness (position - angle) + damping (velocity - rate), within its
    limits.

    Attributes:
        torque: shape (n,), in the order of the motors [N m].
        position: shape (n,) [rad].
        velocity: shape (n,) [rad/s].
        stiffness: shape (n,), 0 for torque control [N m/rad].
        damping: likewise [N m s/rad].
        status: of the solver, 1 or more if it succeeded; the last torques are kept if not.
        acceleration: expected of all degrees of freedom, zero if unknown, shape (nv,) [rad/s^2].
    """

    __slots__ = ("acceleration", "damping", "position", "status", "stiffness", "torque", "velocity")

    def __init__(self, motors: int, dofs: int) -> None:
        self.torque, self.position = np.zeros(motors), np.zeros(motors)
        self.velocity, self.acceleration = np.zeros(motors), np.zeros(dofs)
        self.stiffness, self.damping = np.zeros(motors), np.zeros(motors)
        self.status = 1


@runtime_checkable
class JointMapping(Protocol):
    """Anything that turns a reference into motor commands.

    Leaves: `worlds.body.inverse_dynamics` for torque-controlled robots,
    `worlds.body.inverse_kinematics` for playback.
    """

    def start(self) -> Any:
        """What it remembers before the first cycle of a walk; None if it remembers nothing."""
        ...

    def joints(
        self,
        mechanics: Mechanics,
        reference: NDArray[np.void],
        forces: NDArray[np.float64],
        memory: Any,
    ) -> tuple[JointCommand, Any]:
        """The command for one cycle, and what to remember; never raises.

        Args:
            mechanics: at the state that was estimated.
            reference: a `BODY_REFERENCE` record, shape (1,).
            forces: vertical, on left and right sole, shape (2,) [N].
            memory: of the last cycle, or of `start`; a value.
        """
        ...

    def fresh(self) -> Self:
        """The same with a solver that remembers nothing."""
        ...


class BodyControllerState(Protocol):
    """What evolves in a `BodyController`; a value."""

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
        """What the controller was given last, in its frame."""
        ...

    @property
    def command(self) -> Command:
        """What it answered, likewise."""
        ...

    @property
    def controller(self) -> Controller:
        """What decides about steps, for the velocity of now."""
        ...

    @property
    def course(self) -> Any:
        """Where the robot should be: `place` (x, y) [m] and `heading` [rad]."""
        ...


class BodyController(Protocol):
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
        """The state of a body that stands on both feet; a `BodyControllerState`."""
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
        """One cycle: the command to the motors, and the state for the next; never raises.

        Args:
            state: of the last cycle.
            time: now [s].
            position, velocity: generalised, as estimated; shapes (nq,), (nv,).
            forces: vertical, on left and right sole, shape (2,) [N].
            steering: where to go.
        """
        ...

    def fresh(self) -> Self:
        """The same with solvers that remember nothing."""
        ...

"""The seams of a body: state in and motor commands out, and the reference and the joints between.

A `BodyController` is given the state of a body and answers with a `JointCommand`, in a simulator or
on a robot. Inside, a `BodyReference` says what the body is to do until the next cycle; it is made
from a `Command`, the same that drives the point mass, and a `JointMapping` carries it out.
"""

from __future__ import annotations

from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from surefoot.interface import Controller
from surefoot.record import Array, Record, Vector2, Vector3, field
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.mechanics import Mechanics
from surefoot.worlds.steering import Steering


class BodyReference(Record):
    """What a body is to do until the next cycle, in the world's frame.

    With one foot on the ground it is the ZMP that counts for the CoM's horizontal motion, and with
    two the acceleration; of the CoM itself only the height is wanted, the rest is where it is now.
    """

    stands: Array = field("", "which soles carry, left and right: 1 or 0", shape=2, kind=int)
    zmp: Vector2 = field("m", "where the ground should push (x, y)")
    com: Vector3 = field("m", "centre of mass")
    com_velocity: Vector3 = field("m/s", "its velocity")
    com_acceleration: Vector3 = field("m/s^2", "its acceleration")
    swing_foot: Vector3 = field("m", "centre of the swinging sole")
    swing_foot_velocity: Vector3 = field("m/s", "its velocity")
    swing_foot_acceleration: Vector3 = field("m/s^2", "its acceleration")
    swing_yaw: float = field("rad", "its heading")
    swing_yaw_rate: float = field("rad/s", "and how fast that changes")
    trunk: Vector3 = field("rad", "roll, pitch and yaw of the trunk")
    trunk_yaw_rate: float = field("rad/s", "of the trunk's heading")


BODY_REFERENCE = BodyReference.DTYPE


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


JointMemory = dict[str, NDArray[Any]]
"""What a mapping remembers from cycle to cycle, arrays by name, never changed in place; empty if
nothing."""


class JointMapping(Protocol):
    """Anything that turns a reference into motor commands.

    Leaves: `worlds.body.inverse_dynamics` and `worlds.body.balance_force` for torque-controlled
    robots, `worlds.body.com_jacobian` for robots with position servos; `worlds.body.mapping` finds
    them by name.
    """

    def start(self) -> JointMemory:
        """What it remembers before the first cycle of a walk."""
        ...

    def joints(
        self,
        mechanics: Mechanics,
        reference: NDArray[np.void],
        forces: NDArray[np.float64],
        memory: JointMemory,
    ) -> tuple[JointCommand, JointMemory]:
        """The command for one cycle, and what to remember; never raises.

        Args:
            mechanics: at the state that was estimated.
            reference: a `BodyReference` as an array, shape (1,).
            forces: vertical, on left and right sole, shape (2,) [N].
            memory: of the last cycle, or of `start`; a value.
        """
        ...

    def fresh(self) -> Self:
        """The same with a solver that remembers nothing."""
        ...


class BodyController(Protocol):
    """Anything that walks a body, such as `worlds.body.controller.BodyControl`.

    States have the attributes `walk` (with the fields of `BodyWalk` that are recorded),
    `controller` (for the velocity of now), `observation`, `command` and `course` of a `BodyState`.
    """

    @property
    def controller(self) -> Controller:
        """What decides about steps, for the velocity that it was made for."""
        ...

    @property
    def multibody(self) -> Multibody:
        """The mechanism as it is believed to be."""
        ...

    def start(self) -> Any:
        """The state of a body that stands on both feet."""
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

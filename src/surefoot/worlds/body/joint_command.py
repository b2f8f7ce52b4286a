"""What the motors of a body are told in a cycle: the seam between a mapping and a robot."""

from __future__ import annotations

import numpy as np


class JointCommand:
    """What the motors are told; arrays are overwritten in every cycle.

    A motor gives torque + stiffness (position - angle) + damping (velocity - rate), within its
    limits.

    Attributes:
        torque: shape (n,), in the order of the motors [N m].
        position: shape (n,) [rad].
        velocity: shape (n,) [rad/s].
        stiffness: 0 for torque control [N m/rad].
        damping: likewise [N m s/rad].
        status: of the solver, 1 or more if it succeeded; the last torques are kept if not.
        acceleration: expected of all degrees of freedom, zero if unknown, shape (nv,) [rad/s^2].
    """

    __slots__ = ("acceleration", "damping", "position", "status", "stiffness", "torque", "velocity")

    def __init__(self, motors: int, dofs: int) -> None:
        self.torque, self.position = np.zeros(motors), np.zeros(motors)
        self.velocity, self.acceleration = np.zeros(motors), np.zeros(dofs)
        self.stiffness = self.damping = 0.0
        self.status = 1

"""Ankle, hip and stepping strategies in one linear MPC at fixed timing ([Aftab2012]).

The program of `mpc.placement` with the hip torques of the horizon as further unknowns. They
turn the trunk, a flywheel, and act on the CoM like a ZMP that is moved by torque / (m g), which the
sole does not limit; but the trunk must not meet its stop, and has to come back upright.

    minimise  sum of  velocity_weight |com_velocity - nominal|^2 + zmp_weight |zmp - foot|^2
                    + step_weight |step - nominal|^2 + torque_weight |torque / (m g)|^2
                    + lean_weight |lean|^2 + lean_rate_weight |lean rate|^2
    subject to  |zmp - foot| <= half the sole,  steps in their boxes,  |torque| and |lean| limited
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from surefoot.control.fields import described, filled, weight
from surefoot.control.mpc.cycle import MpcParameters
from surefoot.control.mpc.horizon import (
    Horizon,
    lean_response,
    placed_feet,
    push_response,
    velocity_response,
)
from surefoot.control.mpc.placement import FootPlacementMpc
from surefoot.control.registry import method
from surefoot.errors import RobotError
from surefoot.robot.robot import Robot, Trunk

LEAN_WEIGHT, LEAN_RATE_WEIGHT = 0.0156, 0.0192
"""Default weights of the lean times the height of the CoM, and of its rate times that over omega,
beside a weight of 1 on a ZMP [1/m^2]."""


@method(
    "ankle-hip-step-mpc",
    label="MPC with ankle, hip and step",
    source="Aftab, Robert, Wieber 2012",
    adapts="ZMP, hip torque, step location",
    cannot="steps at fixed times; its trunk is a freedom that no other method and no limit has",
    cites=("Aftab2012", "Arnstrom2022"),
    order=60,
    leans=True,
)
@dataclass(frozen=True)
class AnkleHipStepMpc(FootPlacementMpc):
    """ZMP, hip torque and step locations, planned over several steps; the timing is as planned.

    As published, `push_horizon` is 0.

    Raises:
        RobotError: the robot has no trunk, or the leg is too slow to step at all.
        VelocityError: the velocity cannot be walked, or not on this leg.
        ParameterError: another argument is out of range.
        MissingExtraError: DAQP is not installed.
    """

    robot: Robot = field(metadata=described("whose gait it is; it must have a trunk"))
    torque_weight: float = weight(
        1.0, "1/m^2", "on the distance by which the hip torque moves the ZMP in effect", above=0.0
    )
    lean_weight: float | None = weight(
        None, "1/rad^2", "on the lean of the trunk; 0.0156 h^2 [1/m^2] if None, h the height of "
        "the CoM", own=lambda mpc: LEAN_WEIGHT * mpc.robot.com_height**2,
    )  # fmt: skip
    lean_rate_weight: float | None = weight(
        None, "s^2/rad^2", "on its rate; 0.0192 (h / omega)^2 [1/m^2] if None",
        own=lambda mpc: LEAN_RATE_WEIGHT * (mpc.robot.com_height / mpc.gait.omega) ** 2,
    )  # fmt: skip

    @property
    def trunk(self) -> Trunk:
        """The robot's.

        Raises:
            RobotError: it has none.
        """
        if self.robot.trunk is None:
            raise RobotError(
                "a robot with a trunk to lean",
                f"'{self.robot.name}' without one",
                "add a table [trunk] with inertia, max_torque and max_lean to its file",
            )
        return self.robot.trunk

    def check(self) -> None:
        """Refuse a robot without a trunk, and what no linear MPC can work with."""
        super().check()
        _ = self.trunk

    def make_parameters(self) -> MpcParameters:
        """Those of free steps and a trunk."""
        weight = self.robot.mass * self.robot.gravity
        return (
            super()
            .make_parameters()
            .replace(
                torque_per_shift=weight,
                max_shift=self.trunk.max_torque / weight,
                max_lean=self.trunk.max_lean,
            )
        )

    def make_program(self, ahead: Horizon) -> tuple[NDArray[np.float64], ...]:
        """Hessian, gain, rows and row_state of one control cycle.

        The unknown of a torque is the shift of the ZMP that has the same effect, torque / (m g), so
        all unknowns are lengths.
        """
        share = ahead.lengths * self.samples_per_step / self.gait.step_duration
        steps = self.steps_ahead
        weight = self.robot.mass * self.robot.gravity
        from_dcm, from_zmp = velocity_response(self.gait.omega, ahead.lengths)
        lean_state, lean_torque = lean_response(self.trunk.inertia, ahead.lengths)
        before = np.zeros((self.samples, self.samples + steps))
        response = np.hstack([from_zmp, from_zmp @ placed_feet(ahead.feet, steps), from_zmp])
        lean = np.hstack([before, weight * lean_torque[:, 0]])
        rate = np.hstack([before, weight * lean_torque[:, 1]])
        weighed = filled(self.velocity_weight) * share[:, None] * response
        weighed_lean = filled(self.lean_weight) * share[:, None] * lean
        weighed_rate = filled(self.lean_rate_weight) * share[:, None] * rate
        own = np.concatenate(
            [
                self.zmp_weight * share,
                np.full(steps, self.step_weight),
                self.torque_weight * share,
            ]
        )
        hessian = response.T @ weighed + lean.T @ weighed_lean + rate.T @ weighed_rate
        lasting = filled(self.push_horizon)
        from_push = push_response(from_zmp, ahead.lengths, lasting)
        gain = np.hstack(
            [
                weighed.T @ from_dcm[:, None],
                weighed_lean.T @ lean_state[:, 0] + weighed_rate.T @ lean_state[:, 1],
                weighed.T @ from_push[:, None],
            ]
        )
        none = np.zeros((self.samples, 1))
        row_state = np.hstack([none, lean_state[:, 0], none])
        return hessian + np.diag(own), gain, lean, row_state

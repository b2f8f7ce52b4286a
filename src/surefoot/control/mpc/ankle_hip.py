"""Ankle, hip and stepping strategies in one linear MPC at fixed timing ([Aftab2012]).

The program of `foot_placement_mpc` with the hip torques of the horizon as further unknowns. They
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

from surefoot.checks import check_number, check_weights
from surefoot.control.dcm_tracking import check_leg
from surefoot.control.defaults import fill_in, filled
from surefoot.control.mpc.lipm_horizon import (
    Horizon,
    lean_response,
    push_response,
    velocity_response,
)
from surefoot.control.mpc.placement import SAMPLES_PER_STEP, placed_feet
from surefoot.control.mpc.receding_horizon import (
    Programs,
    RecedingHorizon,
    check_optional,
    check_receding,
    default_push_horizon,
    free_steps,
    horizons,
    receding_defaults,
    receding_parameters,
    samples_in,
    steps_ahead,
)
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.errors import RobotError
from surefoot.robot.robot import Robot, Trunk

LEAN_WEIGHT, LEAN_RATE_WEIGHT = 0.0156, 0.0192
"""Default weights of the lean times the height of the CoM, and of its rate times that over omega,
beside a weight of 1 on a ZMP [1/m^2]."""


@dataclass(frozen=True)
class AnkleHipStepMpc(RecedingHorizon):
    """ZMP, hip torque and step locations, planned over several steps; the timing is as planned.

    Args:
        robot: whose gait it is; it must have a trunk.
        velocity: commanded (v_x, v_y) [m/s].
        samples: intervals of the horizon.
        sample: their length; a step is divided evenly, into intervals close to it; T_nom / 5 if
            None [s].
        velocity_weight: on the deviation of the CoM velocity from the nominal gait; 12.26 / omega^2
            if None [s^2/m^2].
        zmp_weight: on the distance of the ZMP from the centre of the foot [1/m^2].
        step_weight: on the deviation of a step vector from the nominal one [1/m^2].
        torque_weight: on the distance by which the hip torque moves the ZMP in effect [1/m^2].
        lean_weight: on the lean of the trunk; 0.0156 h^2 [1/m^2] if None, h the height of the CoM
            [1/rad^2].
        lean_rate_weight: on its rate; 0.0192 (h / omega)^2 [1/m^2] if None [s^2/rad^2].
        push_horizon: how much longer a push that is felt is expected to go on; T_nom if None, 0 as
            published [s].
        solve_period: how often the program is solved, and at every sample; in every cycle if None
            [s].
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        RobotError: the robot has no trunk.
        VelocityError: the velocity cannot be walked, or not on this leg.
        ParameterError: another argument is out of range.
        MissingExtraError: DAQP is not installed.
    """

    robot: Robot
    velocity: tuple[float, float]
    samples: int = 16
    sample: float | None = None
    velocity_weight: float | None = None
    zmp_weight: float = 1.0
    step_weight: float = 1e-3
    torque_weight: float = 1.0
    lean_weight: float | None = None
    lean_rate_weight: float | None = None
    push_horizon: float | None = None
    solve_period: float | None = None
    step_duration: float | None = None
    period: float = 0.005
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)
    programs: Programs = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_receding(self.robot, self.period, self.solve_period, self.sample, self.samples)
        for name, unit in (
            ("velocity_weight", "s^2/m^2"), ("lean_weight", "1/rad^2"),
            ("lean_rate_weight", "s^2/rad^2"),
        ):  # fmt: skip
            check_optional(getattr(self, name), name, unit)
        for name in ("zmp_weight", "step_weight", "torque_weight"):
            check_number(name, getattr(self, name), 0.0, "1/m^2", above=True)
        check_optional(self.push_horizon, "push_horizon", "s")
        weights = (name for name in self.__dataclass_fields__ if name.endswith("_weight"))
        check_weights(**{name: getattr(self, name) for name in weights})
        trunk = self.robot.trunk
        if trunk is None:
            raise RobotError(
                "a robot with a trunk to lean",
                f"'{self.robot.name}' without one",
                "add a table [trunk] with inertia, max_torque and max_lean to its file",
            )
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        check_leg(self.robot, gait)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        fill_in(
            self,
            push_horizon=default_push_horizon(gait, self.period, self.solve_period),
            lean_weight=LEAN_WEIGHT * self.robot.com_height**2,
            lean_rate_weight=LEAN_RATE_WEIGHT * (self.robot.com_height / gait.omega) ** 2,
            **receding_defaults(self.robot, gait, self.period, SAMPLES_PER_STEP),
        )
        parameters = receding_parameters(
            self.robot,
            gait,
            self.period,
            filled(self.solve_period),
            filled(self.sample),
            self.samples,
        )
        free_steps(parameters, self.robot, gait, filled(self.sample), self.samples)
        weight = self.robot.mass * self.robot.gravity
        parameters["torque_per_shift"] = weight
        parameters["max_shift"] = trunk.max_torque / weight
        parameters["max_lean"] = trunk.max_lean
        object.__setattr__(self, "parameters", parameters)
        rows = horizons(gait, self.period, filled(self.sample), self.samples)
        made = [self._program(seen, trunk) for seen in rows]
        programs = Programs(*(np.array(part) for part in zip(*made, strict=True)))
        object.__setattr__(self, "programs", programs)

    def _program(self, seen: Horizon, trunk: Trunk) -> tuple[NDArray[np.float64], ...]:
        """Hessian, gain, rows and row_state of one control cycle.

        The unknown of a torque is the shift of the ZMP that has the same effect, torque / (m g), so
        all unknowns are lengths.
        """
        share = seen.lengths * samples_in(self.gait, filled(self.sample)) / self.gait.step_duration
        steps = steps_ahead(self.gait, filled(self.sample), self.samples)
        weight = self.robot.mass * self.robot.gravity
        from_dcm, from_zmp = velocity_response(self.gait.omega, seen.lengths)
        lean_state, lean_torque = lean_response(trunk.inertia, seen.lengths)
        before = np.zeros((self.samples, self.samples + steps))
        response = np.hstack([from_zmp, from_zmp @ placed_feet(seen.feet, steps), from_zmp])
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
        from_push = push_response(from_zmp, seen.lengths, lasting)
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

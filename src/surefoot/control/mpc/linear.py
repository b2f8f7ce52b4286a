"""Linear MPC with given footsteps: the ZMP stays inside the foot, now and ahead ([Wieber2006]).

    minimise  sum of  velocity_weight |com_velocity - nominal|^2 + zmp_weight |zmp - foot|^2
    subject to  |zmp - foot| <= half the sole,  on every interval of the horizon

The paper has the CoM's jerk as the input, and as the only thing to minimise; then the ZMP rests at
the edges of the feet, and there is nothing left for a push. Here the input is the ZMP, constant on
each interval, and the nominal gait is the reference, which is what makes the method strong.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_weights
from surefoot.control.defaults import fill_in, filled
from surefoot.control.mpc.lipm_horizon import velocity_response
from surefoot.control.mpc.receding_horizon import (
    Programs,
    RecedingHorizon,
    check_optional,
    check_receding,
    horizons,
    receding_defaults,
    receding_parameters,
    samples_in,
)
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.robot.robot import Robot

SAMPLES_PER_STEP = 25
"""Intervals of the horizon in a nominal step, of 0.02 s for the paper's biped as published."""


@dataclass(frozen=True)
class LinearMpc(RecedingHorizon):
    """Footsteps as planned; the ZMP is planned ahead, inside every foot to come.

    Args:
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        samples: intervals of the horizon.
        sample: their length; a step is divided evenly, into intervals close to it; T_nom / 25 if
            None [s].
        velocity_weight: on the deviation of the CoM velocity from the nominal gait; 12.26 / omega^2
            if None [s^2/m^2].
        zmp_weight: on the distance of the ZMP from the centre of the foot [1/m^2].
        solve_period: how often the program is solved, and at every sample; in every cycle if None,
            0.02 as published [s].
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
        MissingExtraError: DAQP is not installed.
    """

    robot: Robot
    velocity: tuple[float, float]
    samples: int = 75
    sample: float | None = None
    velocity_weight: float | None = None
    zmp_weight: float = 1e-3
    solve_period: float | None = None
    step_duration: float | None = None
    period: float = 0.005
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)
    programs: Programs = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_receding(self.robot, self.period, self.solve_period, self.sample, self.samples)
        check_optional(self.velocity_weight, "velocity_weight", "s^2/m^2")
        check_number("zmp_weight", self.zmp_weight, 0.0, "1/m^2", above=True)
        check_weights(velocity_weight=self.velocity_weight, zmp_weight=self.zmp_weight)
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        fill_in(self, **receding_defaults(self.robot, gait, self.period, SAMPLES_PER_STEP))
        parameters = receding_parameters(
            self.robot,
            gait,
            self.period,
            filled(self.solve_period),
            filled(self.sample),
            self.samples,
        )
        object.__setattr__(self, "parameters", parameters)
        object.__setattr__(self, "programs", self._programs())

    def _programs(self) -> Programs:
        hessian, gain = [], []
        node = self.gait.step_duration / samples_in(self.gait, filled(self.sample))
        for seen in horizons(self.gait, self.period, filled(self.sample), self.samples):
            share = seen.lengths / node
            from_dcm, from_zmp = velocity_response(self.gait.omega, seen.lengths)
            weighed = filled(self.velocity_weight) * share[:, None] * from_zmp
            hessian.append(from_zmp.T @ weighed + self.zmp_weight * np.diag(share))
            gain.append(weighed.T @ from_dcm[:, None])
        none = np.zeros((len(gain), 0, self.samples))
        return Programs(np.array(hessian), np.array(gain), none, none[:, :, :1])

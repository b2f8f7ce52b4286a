"""Linear MPC with automatic foot placement at fixed timing ([Diedam2008], [Herdt2010]).

The program of `linear_mpc`, with the step vectors of the horizon as further unknowns:

    minimise  sum of  velocity_weight |com_velocity - nominal|^2 + zmp_weight |zmp - foot|^2
                    + step_weight |step - nominal|^2

The reference is the velocity of the nominal gait, with its sway from foot to foot: a reference of
constant lateral velocity would draw the feet together until their bounds hold them apart.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_weights
from surefoot.control.dcm_tracking import check_leg
from surefoot.control.receding_horizon import (
    Programs,
    RecedingHorizon,
    check_receding,
    horizons,
    receding_parameters,
    samples_in,
    steps_ahead,
)
from surefoot.models.robot import Robot
from surefoot.planning.lipm_horizon import velocity_response
from surefoot.planning.nominal_gait import NominalGait, nominal_gait


def placed_feet(feet: NDArray[np.int64], steps: int) -> NDArray[np.float64]:
    """Which step vectors the foot of each interval is the sum of, as zeros and ones (n, steps)."""
    return (feet[:, None] > np.arange(steps)).astype(np.float64)


@dataclass(frozen=True)
class FootPlacementMpc(RecedingHorizon):
    """ZMP and step locations, planned over several steps; the timing is as planned.

    Args:
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        samples: intervals of the horizon.
        sample: their length; a step is divided evenly, into intervals close to it [s].
        velocity_weight: on the deviation of the CoM velocity from the nominal gait [s^2/m^2].
        zmp_weight: on the distance of the ZMP from the centre of the foot [1/m^2].
        step_weight: on the deviation of a step vector from the nominal one [1/m^2].
        solve_period: how often the program is solved; 0.1 as published [s].
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        VelocityError: the velocity cannot be walked, or not on this leg.
        ParameterError: another argument is out of range.
        MissingExtraError: DAQP is not installed.
    """

    robot: Robot
    velocity: tuple[float, float]
    samples: int = 16
    sample: float = 0.1
    velocity_weight: float = 1.0
    zmp_weight: float = 1.0
    step_weight: float = 1e-3
    solve_period: float = 0.005
    step_duration: float | None = None
    period: float = 0.005
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)
    programs: Programs = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_receding(self.robot, self.period, self.solve_period, self.sample, self.samples)
        check_number("velocity_weight", self.velocity_weight, 0.0, "s^2/m^2")
        check_number("zmp_weight", self.zmp_weight, 0.0, "1/m^2", above=True)
        check_number("step_weight", self.step_weight, 0.0, "1/m^2", above=True)
        check_weights(
            velocity_weight=self.velocity_weight,
            zmp_weight=self.zmp_weight,
            step_weight=self.step_weight,
        )
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        check_leg(self.robot, gait)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        parameters = receding_parameters(
            self.robot, gait, self.period, self.solve_period, self.sample, self.samples
        )
        parameters["steps"] = steps_ahead(gait, self.sample, self.samples)
        object.__setattr__(self, "parameters", parameters)
        object.__setattr__(self, "programs", self._programs())

    def _programs(self) -> Programs:
        hessian, gain = [], []
        node = self.gait.step_duration / samples_in(self.gait, self.sample)
        steps = steps_ahead(self.gait, self.sample, self.samples)
        for seen in horizons(self.gait, self.period, self.sample, self.samples):
            share = seen.lengths / node
            from_dcm, from_zmp = velocity_response(self.gait.omega, seen.lengths)
            response = np.hstack([from_zmp, from_zmp @ placed_feet(seen.feet, steps)])
            weighed = self.velocity_weight * share[:, None] * response
            own = np.concatenate([self.zmp_weight * share, np.full(steps, self.step_weight)])
            hessian.append(response.T @ weighed + np.diag(own))
            gain.append(weighed.T @ from_dcm[:, None])
        none = np.zeros((len(gain), 0, self.samples + steps))
        return Programs(np.array(hessian), np.array(gain), none, none[:, :, :1])

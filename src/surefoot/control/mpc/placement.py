"""Linear MPC with automatic foot placement at fixed timing ([Diedam2008], [Herdt2010]).

The program of `linear_mpc`, with the step vectors of the horizon as further unknowns:

    minimise  sum of  velocity_weight |com_velocity - nominal|^2 + zmp_weight |zmp - foot|^2
                    + step_weight |step - nominal|^2

The reference is the velocity of the nominal gait, with its sway from foot to foot: a reference of
constant lateral velocity would draw the feet together until their bounds hold them apart.

A push that is felt, see `push_observer`, is expected to go on. Without that, a step that lands
while it does is too short by all that is still to come, and cannot be taken back: late in a step
that costs a third to half of what can be survived. But a step for a push that goes on must be one
that is saved if it ends now, see `receding_cycle`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_weights
from surefoot.control.dcm_tracking import check_leg
from surefoot.control.defaults import fill_in, filled
from surefoot.control.mpc.lipm_horizon import push_response, velocity_response
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
from surefoot.robot.robot import Robot

SAMPLES_PER_STEP = 5
"""Intervals of the horizon in a nominal step, of 0.1 s for the paper's biped as published."""


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
        sample: their length; a step is divided evenly, into intervals close to it; T_nom / 5 if
            None [s].
        velocity_weight: on the deviation of the CoM velocity from the nominal gait; 12.26 / omega^2
            if None [s^2/m^2].
        zmp_weight: on the distance of the ZMP from the centre of the foot [1/m^2].
        step_weight: on the deviation of a step vector from the nominal one [1/m^2].
        push_horizon: how much longer a push that is felt is expected to go on; T_nom if None, 0 as
            published [s].
        solve_period: how often the program is solved, and at every sample; in every cycle if None,
            inf as published [s].
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
    sample: float | None = None
    velocity_weight: float | None = None
    zmp_weight: float = 1.0
    step_weight: float = 1e-3
    push_horizon: float | None = None
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
        check_number("step_weight", self.step_weight, 0.0, "1/m^2", above=True)
        check_optional(self.push_horizon, "push_horizon", "s")
        check_weights(
            velocity_weight=self.velocity_weight,
            zmp_weight=self.zmp_weight,
            step_weight=self.step_weight,
        )
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        check_leg(self.robot, gait)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        fill_in(
            self,
            push_horizon=default_push_horizon(gait, self.period, self.solve_period),
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
        object.__setattr__(self, "parameters", parameters)
        object.__setattr__(self, "programs", self._programs())

    def _programs(self) -> Programs:
        hessian, gain = [], []
        node = self.gait.step_duration / samples_in(self.gait, filled(self.sample))
        steps = steps_ahead(self.gait, filled(self.sample), self.samples)
        lasting = filled(self.push_horizon)
        for seen in horizons(self.gait, self.period, filled(self.sample), self.samples):
            share = seen.lengths / node
            from_dcm, from_zmp = velocity_response(self.gait.omega, seen.lengths)
            response = np.hstack([from_zmp, from_zmp @ placed_feet(seen.feet, steps)])
            weighed = filled(self.velocity_weight) * share[:, None] * response
            own = np.concatenate([self.zmp_weight * share, np.full(steps, self.step_weight)])
            hessian.append(response.T @ weighed + np.diag(own))
            from_push = push_response(from_zmp, seen.lengths, lasting)
            gain.append(weighed.T @ np.stack([from_dcm, from_push], axis=1))
        none = np.zeros((len(gain), 0, self.samples + steps))
        return Programs(np.array(hessian), np.array(gain), none, none[:, :, :2])

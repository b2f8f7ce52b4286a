"""Linear MPC with automatic foot placement at fixed timing ([Diedam2008], [Herdt2010]).

The program of `mpc.linear`, with the step vectors of the horizon as further unknowns:

    minimise  sum of  velocity_weight |com_velocity - nominal|^2 + zmp_weight |zmp - foot|^2
                    + step_weight |step - nominal|^2

The reference is the velocity of the nominal gait, with its sway from foot to foot: a reference of
constant lateral velocity would draw the feet together until their bounds hold them apart.

A push that is observed, see `push_observer`, is expected to go on. Without that, a step that lands
while it does is too short by all that is still to come, and cannot be taken back: late in a step
that costs a third to half of what can be survived. But a step for a push that goes on must be one
that is saved if it ends now, see `mpc.cycle`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.control.fields import filled, setting, weight
from surefoot.control.mpc.cycle import MpcParameters
from surefoot.control.mpc.horizon import (
    Horizon,
    RecedingHorizon,
    com_response,
    placed_feet,
    push_response,
)
from surefoot.control.registry import method, variant
from surefoot.dcm.landing_schedule import evenly_timed
from surefoot.dcm.viable_displacement import viable_displacement


def _push_horizon(mpc: Any) -> float:
    """How much longer a push is expected to go on [s].

    A step as long as what was decided for it is taken back in the cycle in which it ends.
    """
    every_cycle = mpc.solve_period is None or mpc.solve_period <= mpc.period
    return mpc.gait.step_duration if every_cycle else 0.0


@method(
    "foot-placement-mpc",
    label="MPC with foot placement",
    source="Diedam et al. 2008; Herdt et al. 2010; solved every 5 ms",
    adapts="ZMP, step location",
    cannot="steps at fixed times",
    cites=("Diedam2008", "Herdt2010", "Arnstrom2022"),
    order=50,
)
@dataclass(frozen=True)
class FootPlacementMpc(RecedingHorizon):
    """ZMP and step locations, planned over several steps; the timing is as planned.

    As published, the program is solved at every sample (`solve_period` inf) and `push_horizon` is
    0.

    Raises:
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the leg is too slow to step at all.
        ParameterError: another argument is out of range.
        MissingExtraError: DAQP is not installed.
    """

    NEEDS_LEG = True
    step_weight: float = weight(
        1e-3, "1/m^2", "on the deviation of a step vector from the nominal one", above=0.0
    )
    push_horizon: float | None = setting(
        None, "s", "how much longer a push that is observed is expected to go on; T_nom if None, "
        "or 0 if not every cycle solves a program", least=0.0, own=_push_horizon,
    )  # fmt: skip

    def make_parameters(self) -> MpcParameters:
        """Those of free steps, at the times of the gait."""
        tables = viable_displacement(self.robot)
        return (
            super()
            .make_parameters()
            .replace(
                steps=self.steps_ahead,
                saved=evenly_timed(self.robot, (self.gait.step_duration,))[0],
                low=tables.low,
                spacing=tables.spacing,
            )
        )

    def responses(self, ahead: Horizon) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What the CoM and its velocity do until the end of each of n intervals.

        Returns:
            From the unknowns, ZMPs and steps, (2, n, n + steps), and from DCM and push, (2, n, 2)
            [-, 1/s]. The CoM counts from the foot that stands next.
        """
        steps = self.steps_ahead
        from_dcm, from_zmp = com_response(self.gait.omega, ahead.lengths)
        from_push = push_response(from_zmp, ahead.lengths, filled(self.push_horizon))
        from_steps = from_zmp @ placed_feet(ahead.feet, steps)
        from_steps[0] -= placed_feet(np.append(ahead.feet[1:], ahead.feet[-1]), steps)
        return (
            np.concatenate([from_zmp, from_steps], axis=2),
            np.stack([from_dcm, from_push], axis=2),
        )

    def make_program(self, ahead: Horizon) -> tuple[NDArray[np.float64], ...]:
        """Hessian, gain, rows and row_state of one control cycle."""
        share, steps = ahead.lengths / self.node, self.steps_ahead
        (_, response), (_, from_state) = self.responses(ahead)
        weighed = filled(self.velocity_weight) * share[:, None] * response
        own = np.concatenate([self.zmp_weight * share, np.full(steps, self.step_weight)])
        none = np.zeros((0, self.samples + steps))
        return response.T @ weighed + np.diag(own), weighed.T @ from_state, none, none[:, :2]


EVERY_SAMPLE = variant(
    FootPlacementMpc,
    "foot-placement-mpc-100ms",
    label="MPC with foot placement, 100 ms",
    source="Herdt et al. 2010; solved every 100 ms, as published",
    cannot="steps at fixed times, and learns of a push up to 100 ms late",
    order=51,
    parameters={"solve_period": math.inf},
)

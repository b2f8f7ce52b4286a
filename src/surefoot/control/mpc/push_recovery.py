"""Push recovery by stepping, two steps ahead, as a program of the LIPM ([StephensStepping2010]).

The horizon ends with the second step. CoM, its velocity, ZMPs and both landings are to be near
those of the gait, and bounded by soles, steps and the leg:

    minimise  sum of  com_weight |com - nominal|^2 + velocity_weight |com_velocity - nominal|^2
                    + zmp_weight |zmp - foot|^2 + step_weight |step - nominal|^2

The CoM counts from the foot that stands. In the source the goal is a stand over the middle of the
feet; here it is the nominal gait. That a push is expected to go on, as in `mpc.placement`, is a
choice of this implementation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.control.fields import filled, setting, weight
from surefoot.control.mpc.horizon import ON_ZMP, Horizon
from surefoot.control.mpc.placement import FootPlacementMpc
from surefoot.control.registry import method


@method(
    "push-recovery-mpc",
    label="stepping push recovery",
    source="Stephens, Atkeson 2010; solved every 5 ms",
    adapts="ZMP, step location",
    cannot="steps at fixed times; two steps ahead",
    cites=("StephensStepping2010", "Arnstrom2022"),
    order=54,
)
@dataclass(frozen=True)
class PushRecoveryMpc(FootPlacementMpc):
    """ZMP and the next two landings, back to the CoM of the gait.

    Raises:
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the leg is too slow to step at all.
        ParameterError: another argument is out of range.
        MissingExtraError: DAQP is not installed.
    """

    samples: int = setting(10, "", "intervals of the horizon, two steps")
    com_weight: float = weight(
        1.0, "1/m^2", "on the deviation of the CoM from the nominal gait, from foot to CoM"
    )
    velocity_weight: float | None = weight(
        None, "s^2/m^2", "on the deviation of its velocity; 1 / omega^2 if None",
        own=lambda mpc: 1.0 / mpc.robot.omega**2,
    )  # fmt: skip
    zmp_weight: float = weight(0.1, "1/m^2", ON_ZMP, above=0.0)
    step_weight: float = weight(
        1e-2, "1/m^2", "on the deviation of a step vector from the nominal one", above=0.0
    )

    def make_program(self, ahead: Horizon) -> tuple[NDArray[np.float64], ...]:
        """Hessian, gain, rows and row_state of one control cycle."""
        steps, share = self.steps_ahead, ahead.lengths / self.node
        weights = np.outer((self.com_weight, filled(self.velocity_weight)), share)
        from_unknown, from_state = self.responses(ahead)
        own = np.append(self.zmp_weight * share, np.full(steps, self.step_weight))
        hessian = np.einsum("ika,ik,ikb->ab", from_unknown, weights, from_unknown)
        gain = np.einsum("ika,ik,ikb->ab", from_unknown, weights, from_state)
        none = np.zeros((0, self.samples + steps))
        return hessian + np.diag(own), gain, none, none[:, :2]

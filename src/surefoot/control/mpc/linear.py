"""Linear MPC with given footsteps: the ZMP stays inside the foot, now and ahead ([Wieber2006]).

    minimise  sum of  velocity_weight |com_velocity - nominal|^2 + zmp_weight |zmp - foot|^2
    subject to  |zmp - foot| <= half the sole,  on every interval of the horizon

The paper has the CoM's jerk as the input, and as the only thing to minimise; then the ZMP rests at
the edges of the feet, and there is nothing left for a push. Here the input is the ZMP, constant on
each interval, and the nominal gait is the reference, which is what makes the method strong.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.control.fields import filled, setting, weight
from surefoot.control.mpc.horizon import ON_ZMP, Horizon, RecedingHorizon, velocity_response
from surefoot.control.registry import method


@method(
    "linear-mpc",
    label="linear MPC, fixed steps",
    source="Wieber 2006; solved every 5 ms",
    adapts="ZMP",
    cannot="steps as planned: neither where nor when it steps answers a push",
    cites=("Wieber2006", "Arnstrom2022"),
    order=30,
    fixed_steps=True,
)
@dataclass(frozen=True)
class LinearMpc(RecedingHorizon):
    """Footsteps as planned; the ZMP is planned ahead, inside every foot to come.

    As published, the program is solved every 0.02 s.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
        MissingExtraError: DAQP is not installed.
    """

    SAMPLES_PER_STEP = 25
    """Of 0.02 s for the paper's biped, as published."""

    samples: int = setting(75, "", "intervals of the horizon")
    zmp_weight: float = weight(1e-3, "1/m^2", ON_ZMP, above=0.0)

    def make_program(self, ahead: Horizon) -> tuple[NDArray[np.float64], ...]:
        """Hessian, gain, rows and row_state of one control cycle."""
        share = ahead.lengths / self.node
        from_dcm, from_zmp = velocity_response(self.gait.omega, ahead.lengths)
        weighed = filled(self.velocity_weight) * share[:, None] * from_zmp
        hessian = from_zmp.T @ weighed + self.zmp_weight * np.diag(share)
        none = np.zeros((0, self.samples))
        return hessian, weighed.T @ from_dcm[:, None], none, none[:, :1]

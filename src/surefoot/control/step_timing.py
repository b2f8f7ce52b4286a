"""Step location and timing, and nothing else: [Khadiv2016], [Khadiv2020].

The ZMP rests at the centre of the foot. Every cycle decides where and when the next foot lands, by

    minimise    a1, a2 |step - step_nom|^2 + a3 (tau - tau_nom)^2 + a4, a5 |d - d_nom|^2
    subject to  step + d = (dcm - p) e^(-omega t) tau,   step and tau in their limits,   d viable

with tau = e^(omega T) and dominant weights on the DCM offset d. The viable offsets are those from
which some sequence of steps still saves the robot, with the lateral pair corrected; a violation is
heavily penalised rather than forbidden, so that there always is a decision.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.control.base import CompiledController
from surefoot.control.defaults import default_tau_weight
from surefoot.control.fields import filled, setting
from surefoot.control.hybrid import (
    HYBRID,
    HYBRID_STATE,
    hybrid_cycle,
    hybrid_parameters,
    hybrid_step,
)
from surefoot.control.registry import method
from surefoot.control.tracking import NO_GAIN, tracking_parameters
from surefoot.dcm.step_problem import OFFSET_PENALTY, StepProblem, gait_problem
from surefoot.dcm.viability import viable_offsets
from surefoot.robot.feet import Side

DOMINANT_WEIGHT = (1e5, 1e5)
"""Default (a4, a5) [1/m^2]. The timing gives way before the offset does, in both directions: with a
hundredth of it, a leg of 3 m/s survives a fifth less of a push away from it."""


@method(
    "step-timing",
    label="step location and timing",
    source="Khadiv et al. 2016, 2020",
    adapts="step location, timing",
    cannot="leaves the ZMP at the centre of the foot; knows the leg, which as published it does "
    "not",
    cites=("Khadiv2016", "Khadiv2020"),
    order=70,
    compared={"knows_leg": True},
)
@dataclass(frozen=True)
class StepTiming(
    CompiledController,
    cycle=hybrid_cycle,
    arrays=hybrid_step,
    parameters=HYBRID,
    state=HYBRID_STATE,
):
    """Step location and timing decided anew in every cycle, with a ZMP that never moves.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    step_weight: tuple[float, float] = setting(
        (1.0, 1.0), "1/m^2", "(a1, a2) on the step vector",
        least=0.0, is_weight=True, search=(None, (0.01, 100.0)),
    )  # fmt: skip
    tau_weight: float | None = setting(
        None, "-", "a3 on tau; 540 (R / tau_nom)^2 if None, see `control.defaults`",
        least=0.0, is_weight=True, search=(0.001, 100.0),
    )  # fmt: skip
    offset_weight: tuple[float, float] = setting(
        DOMINANT_WEIGHT, "1/m^2", "(a4, a5) on the DCM offset; they must dominate",
        least=0.0, is_weight=True, search=((1.0, 1e6), (1.0, 1e6)),
    )  # fmt: skip
    offset_penalty: float = setting(
        OFFSET_PENALTY, "1/m^2", "on half the squared distance from the viable offsets",
        least=0.0, is_weight=True, search=(1e3, 1e9),
    )  # fmt: skip
    knows_leg: bool = setting(
        False,
        "",
        "whether a landing must be in reach of `robot.swing` when the foot lands; False is as "
        "published",
    )

    def defaults(self) -> dict[str, float]:
        """The weight of tau."""
        return {"tau_weight": default_tau_weight(self.robot, self.gait)}

    def make_parameters(self) -> NDArray[np.void]:
        """The `HYBRID` record of a cycle that decides from no error on, and never tracks."""
        tracking = tracking_parameters(self.robot, self.gait, NO_GAIN, True, 0.0, self.period)
        leg = self.robot if self.knows_leg else None
        problems = {side: self.step_problem(side) for side in Side}
        return hybrid_parameters(tracking, 0.0, leg, problems)

    def step_problem(
        self,
        support_side: Side,
        growth: tuple[float, float] | None = None,
        elapsed: float = 0.0,
    ) -> StepProblem:
        """The step problem that this controller solves; its offset bounds are the viable offsets.

        Args:
            support_side: foot on the ground.
            growth: (A, B), the nominal gait if None [m].
            elapsed: t, time since touchdown [s].
        """
        viable = viable_offsets(self.robot, support_side)
        return gait_problem(
            self.robot,
            self.gait,
            support_side,
            (viable.lower, viable.upper),
            growth,
            elapsed,
            step_weight=self.step_weight,
            tau_weight=filled(self.tau_weight),
            offset_weight=self.offset_weight,
            offset_penalty=self.offset_penalty,
        )

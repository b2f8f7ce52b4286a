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

from surefoot.control.defaults import tau_weight
from surefoot.control.hybrid import (
    A3,
    HybridParameters,
    StepDecider,
    knows_leg,
    offset_penalty,
    offset_weight,
    step_weight,
)
from surefoot.control.registry import method
from surefoot.control.tracking import tracking_parameters
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
class StepTiming(StepDecider):
    """Step location and timing decided anew in every cycle, with a ZMP that never moves.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    step_weight: tuple[float, float] = step_weight()
    tau_weight: float | None = tau_weight(*A3)
    offset_weight: tuple[float, float] = offset_weight(DOMINANT_WEIGHT)
    offset_penalty: float = offset_penalty("distance from the viable offsets")
    knows_leg: bool = knows_leg()

    def make_parameters(self) -> HybridParameters:
        """Those of a cycle that decides from no error on, and never tracks."""
        return self.hybrid_parameters(tracking_parameters(self), 0.0)

    def offset_bounds(self, support_side: Side) -> tuple[tuple[float, float], tuple[float, float]]:
        """The viable offsets."""
        viable = viable_offsets(self.robot, support_side)
        return viable.lower, viable.upper

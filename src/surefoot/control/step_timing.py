"""Step location and timing, and nothing else: [Khadiv2016], [Khadiv2020].

The ZMP rests at the centre of the foot. Every cycle decides where and when the next foot lands, by

    minimise    a1, a2 |step - step_nom|^2 + a3 (tau - tau_nom)^2 + a4, a5 |d - d_nom|^2
    subject to  step + d = (dcm - p) e^(-omega t) tau,   step and tau in their limits,   d viable

with tau = e^(omega T) and dominant weights on the DCM offset d. The viable offsets are those from
which some sequence of steps still saves the robot, with the lateral pair corrected; a violation is
heavily penalised rather than forbidden, so that there always is a decision.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_pair, check_weights
from surefoot.control.cycle import side_index
from surefoot.control.dcm_tracking import (
    NO_GAIN,
    check_tracking,
    first_plan,
    tracking_parameters,
)
from surefoot.control.defaults import default_tau_weight, fill_in, filled
from surefoot.control.hybrid import HYBRID, HYBRID_STATE, compiled_hybrid, hybrid_cycle
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.dcm.step_in_reach import saved_by
from surefoot.dcm.step_problem import OFFSET_PENALTY, StepProblem, gait_problem
from surefoot.dcm.viability import viable_offsets
from surefoot.interface import Command, Observation
from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

DOMINANT_WEIGHT = (1e5, 1e5)
"""Default (a4, a5) [1/m^2]. The timing gives way before the offset does, in both directions: with a
hundredth of it, a leg of 3 m/s survives a fifth less of a push away from it."""


@dataclass(frozen=True)
class StepTiming:
    """Step location and timing decided anew in every cycle, with a ZMP that never moves.

    Args:
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        step_weight: (a1, a2) on the step vector [1/m^2].
        tau_weight: a3 on tau; 540 (R / tau_nom)^2 if None, see `control.defaults` [-].
        offset_weight: (a4, a5) on the DCM offset; they must dominate [1/m^2].
        offset_penalty: on half the squared distance from the viable offsets [1/m^2].
        knows_leg: whether a landing must be in reach of `robot.swing` when the foot lands; False is
            as published.
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    robot: Robot
    velocity: tuple[float, float]
    step_weight: tuple[float, float] = (1.0, 1.0)
    tau_weight: float | None = None
    offset_weight: tuple[float, float] = DOMINANT_WEIGHT
    offset_penalty: float = OFFSET_PENALTY
    knows_leg: bool = False
    step_duration: float | None = None
    period: float = 0.001
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_tracking(self.robot, None, 0.0, self.period)
        check_pair("step_weight", self.step_weight, 0.0, "1/m^2")
        if self.tau_weight is not None:
            check_number("tau_weight", self.tau_weight, 0.0, "-")
        check_pair("offset_weight", self.offset_weight, 0.0, "1/m^2")
        check_number("offset_penalty", self.offset_penalty, 0.0, "1/m^2")
        check_weights(
            step_weight=self.step_weight,
            tau_weight=self.tau_weight,
            offset_weight=self.offset_weight,
            offset_penalty=self.offset_penalty,
        )
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        fill_in(self, tau_weight=default_tau_weight(self.robot, gait))
        parameters = new_array(HYBRID)
        parameters["tracking"] = tracking_parameters(
            self.robot, gait, NO_GAIN, True, 0.0, self.period
        )
        # The hybrid cycle that decides the step from no error on: its tracking never has its turn.
        parameters["threshold"] = 0.0
        # Of a leg without limits there is nothing to know.
        parameters["knows_leg"] = self.knows_leg and self.robot.swing.is_limited
        if parameters["knows_leg"][0]:
            parameters["saved"] = saved_by(self.robot).array
        for side in Side:
            parameters["problem"][0, side_index.py_func(side)] = self.step_problem(side).array[0]
        object.__setattr__(self, "parameters", parameters)
        compiled_hybrid()  # Now rather than in the first control cycle.

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

    @property
    def kernel(self) -> Callable[..., None]:
        """The compiled cycle over records."""
        return hybrid_cycle

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot on the nominal gait observes at a touchdown; right foot first by default."""
        return self.gait.observation(Side.RIGHT if support_side is None else support_side)

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = new_array(HYBRID_STATE)
        first_plan(self.gait, observation, state)
        return state

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        next_state = new_array(HYBRID_STATE)
        compiled_hybrid()(self.parameters, state, observation.array, next_state)
        return Command.of(next_state["command"]), next_state

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)

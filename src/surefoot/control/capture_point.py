"""Step onto the capture point at fixed times: [Pratt2006], with the finite foot of [Koolen2012].

With a constant ZMP, the DCM (which these papers call the instantaneous capture point) will be at

    dcm(T) = zmp + (dcm - zmp) e^(omega (T - t))

at touchdown. The ZMP is put where this is the planned place, as far as the sole reaches; then the
foot lands where the offset of what is left is nominal again: p_next = dcm(T) - d_nom. So the foot
steps only for what the sole cannot do, and one step ends an error, as long as its box allows it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.control.belief import hold, look, mark
from surefoot.control.cycle import command_swing, growth_since_touchdown, side_index
from surefoot.control.dcm_tracking import (
    NO_GAIN,
    TRACKING_STATE,
    check_tracking,
    first_plan,
    tracking_parameters,
)
from surefoot.control.tracking_law import (
    EDGE_TOLERANCE,
    TRACKING,
    begin_plan,
    follow_plan,
    plan_landing,
)
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.dcm.pendulum import dcm_flow
from surefoot.dcm.support import nearest_under_foot
from surefoot.geometry import length
from surefoot.interface import OBSERVATION, Command, Mode, Observation, Status
from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

_ADAPTING = int(Mode.ADAPTING)
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)
_ZMP_AT_EDGE = int(Status.ZMP_AT_EDGE)


@njit
def _zmp_for(away: float, planned: float, growth: float) -> float:
    """The constant ZMP that brings the DCM from `away` to `planned`, which grows by `growth`."""
    return (planned - away * growth) / (1.0 - growth)


@njit
def capture(parameters, observation, plan, command):
    """Write ZMP, landing and timing; `command` already has the planned DCM."""
    foot, half = observation.support_foot, parameters.half_foot
    away_x, away_y = observation.dcm[0] - foot[0], observation.dcm[1] - foot[1]
    left = plan.step_duration - observation.elapsed
    command.mode, command.status = _ADAPTING, 0 if left >= 0.0 else _NO_TIME_LEFT
    # The ZMP that is commanded now acts for a period, however little of the step is left.
    growth = math.exp(parameters.omega * max(left, parameters.swing.period))
    asked_x = _zmp_for(away_x, plan.start_offset[0] * plan.growth, growth)
    asked_y = _zmp_for(away_y, plan.start_offset[1] * plan.growth, growth)
    zmp_x, zmp_y = nearest_under_foot(asked_x, asked_y, half[0], half[1], observation.support_yaw)
    if length(zmp_x - asked_x, zmp_y - asked_y) > EDGE_TOLERANCE:
        command.status |= _ZMP_AT_EDGE
    command.step_duration = max(plan.step_duration, observation.elapsed)
    row = side_index(observation.support_side)
    for i in range(2):
        zmp, away = (zmp_x, away_x) if i == 0 else (zmp_y, away_y)
        dcm_at_end = dcm_flow(away, zmp, parameters.omega, max(left, 0.0))
        step = dcm_at_end - parameters.start_offset[1 - row, i]
        step = min(max(step, parameters.step_min[row, i]), parameters.step_max[row, i])
        command.zmp[i] = foot[i] + zmp
        command.step_location[i] = foot[i] + step
        command.dcm_offset[i] = dcm_at_end - step


@njit
def capture_cycle(parameters, state, observation, next_state):
    """One cycle of `CapturePointStepping` over records."""
    if look(parameters.gate, state, observation, next_state):
        hold(state, next_state)
        return
    next_state.plan = state.plan
    plan, command = next_state.plan, next_state.command
    observation = next_state.belief.seen
    new_step = observation.support_side != plan.support_side
    if new_step:
        begin_plan(parameters, observation, False, plan)
    plan_landing(parameters, observation, plan)
    growth = growth_since_touchdown(parameters.omega, observation.elapsed)
    follow_plan(parameters, observation, growth, plan, command)
    capture(parameters, observation, plan, command)
    command_swing(
        parameters.swing,
        observation,
        (0.0, command.step_duration),
        parameters.landing_yaw,
        state.command,
        plan.phase,
        new_step,
        command,
    )
    mark(next_state)


@njit
def _capture_step(parameters, state, observation, next_state):
    capture_cycle(parameters[0], state[0], observation[0], next_state[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_capture_step, TRACKING, TRACKING_STATE, OBSERVATION, TRACKING_STATE)


@dataclass(frozen=True)
class CapturePointStepping:
    """Steps at fixed times onto the capture point; the ZMP does what it can inside the sole.

    Args:
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        ankle: whether the ZMP moves inside the sole; False is the point foot of [Pratt2006].
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    robot: Robot
    velocity: tuple[float, float]
    ankle: bool = True
    step_duration: float | None = None
    period: float = 0.001
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_tracking(self.robot, None, 0.0, self.period)
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        # Records and plan are those of tracking, whose gain this law has no use for.
        parameters = tracking_parameters(self.robot, gait, NO_GAIN, self.ankle, 0.0, self.period)
        if not self.ankle:
            parameters["half_foot"] = 0.0
        object.__setattr__(self, "parameters", parameters)
        _compiled()  # Now rather than in the first control cycle.

    @property
    def kernel(self) -> Callable[..., None]:
        """The compiled cycle over records."""
        return capture_cycle

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot on the nominal gait observes at a touchdown; right foot first by default."""
        return self.gait.observation(Side.RIGHT if support_side is None else support_side)

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = new_array(TRACKING_STATE)
        first_plan(self.gait, observation, state)
        return state

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        next_state = new_array(TRACKING_STATE)
        _compiled()(self.parameters, state, observation.array, next_state)
        return Command.of(next_state["command"]), next_state

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)

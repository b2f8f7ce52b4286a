"""The unified controller: ZMP, landing place and landing time from one problem.

No switch between small pushes and large ones. Every cycle it observes the push, asks what it may
still do, and solves `control.unified.problem`: while the ZMP can make up for an error the landing
stays where it is; beyond that it moves, in place and time, as far as it has to and the leg can.
Own method; it replaces the hybrid of [OnlineGait], III-C.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_pair, check_weights
from surefoot.compiled import entry_point, njit
from surefoot.control.belief import PENDULUM, hold, look, mark
from surefoot.control.cycle import command_swing, growth_since_touchdown
from surefoot.control.dcm_tracking import (
    check_leg,
    check_tracking,
    first_plan,
    tracking_parameters,
)
from surefoot.control.defaults import DCM_GAIN, fill_in, filled
from surefoot.control.push_observer import observe_push, observing, remember
from surefoot.control.tracking_law import begin_plan, follow_plan, keep_box, plan_landing
from surefoot.control.unified.anticipation import keep_way_back, margin
from surefoot.control.unified.law import (
    UNIFIED,
    UNIFIED_STATE,
    assess,
    command_landing,
    place_zmp,
)
from surefoot.control.unified.problem import DECISION, Decision, landing_parameters
from surefoot.control.unified.solver import decide_landing, flag_limits
from surefoot.dcm.nominal_gait import NominalGait, gait_room, nominal_gait
from surefoot.interface import OBSERVATION, Command, Observation
from surefoot.record import copy_array, new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

RESERVE, COMFORT = 0.025, 0.03
"""Default reserve and comfort, as fractions of the height of the CoM."""

COMMITMENT = 2.0
"""How many control periods before a landing it cannot be brought forward any more: what a push does
shows after two."""


@njit
def unified_cycle(parameters, state, observation, next_state):
    """One cycle of `UnifiedController` over records."""
    if look(parameters.tracking.gate, state, observation, next_state):
        next_state.observer, next_state.decision = state.observer, state.decision
        next_state.situation, next_state.observer.seen = state.situation, 0
        hold(state, next_state)
        return
    observation = next_state.belief.seen
    next_state.plan = state.plan
    plan, command = next_state.plan, next_state.command
    tracking, landing = parameters.tracking, parameters.landing
    situation, decision, observer = next_state.situation, next_state.decision, next_state.observer
    new_step = observation.support_side != plan.support_side
    if new_step:
        begin_plan(tracking, observation, plan.adapting != 0, plan)
        plan.adapting = 0
    plan_landing(tracking, observation, plan)
    growth = growth_since_touchdown(landing.omega, observation.elapsed)
    follow_plan(tracking, observation, growth, plan, command)
    observe_push(parameters.observing, state.observer, observation, observer)
    last_duration = plan.step_duration if new_step else state.command.step_duration
    assess(parameters, observation, plan, last_duration, observer.force, situation, decision)
    guess = situation.tau_ref if new_step else state.decision.tau
    decide_landing(landing, situation, guess, decision)
    limited = landing.max_speed < math.inf or landing.max_acceleration < math.inf
    if limited and keep_way_back(landing, situation, decision):
        flag_limits(landing, situation, decision)
    command_landing(landing, observation, plan, decision, command)
    keep_box(tracking, observation, command)
    place_zmp(parameters, observation, situation, decision, command)
    remember(observation, command.zmp, observer)
    if next_state.belief.guessed & PENDULUM:
        # Nothing pushes a pendulum that is only predicted.
        observer.seen = 0
    command_swing(
        tracking.swing,
        observation,
        (0.0, command.step_duration),
        tracking.landing_yaw,
        state.command,
        plan.phase,
        new_step,
        command,
    )
    mark(next_state)


@njit
def _unified_step(parameters, state, observation, next_state):
    unified_cycle(parameters[0], state[0], observation[0], next_state[0])


@njit
def _margin(parameters, state, decision):
    decision[0].margin = margin(parameters[0].landing, state[0].situation)


@cache
def _compiled_margin() -> Callable[..., None]:
    return entry_point(_margin, UNIFIED, UNIFIED_STATE, DECISION)


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_unified_step, UNIFIED, UNIFIED_STATE, OBSERVATION, UNIFIED_STATE)


@dataclass(frozen=True)
class UnifiedController:
    """ZMP, landing place and landing time from one problem, up to the limit of physics.

    Args:
        robot: whose gait it is, and whose leg and sole it makes use of.
        velocity: commanded (v_x, v_y) [m/s].
        ankle: whether the ZMP moves inside the sole; False for a point foot.
        horizon: h, how much longer a push may go on that is observed; inf for one of which nothing
            is known, 0 for none [s].
        reserve: rho, distance kept from what cannot be saved, at most half the gait's room R;
            0.025 com_height if None [m].
        comfort: DCM error that the ZMP alone answers, while nothing is in danger; 0.03 com_height
            if None [m].
        dcm_gain: K_f, rate at which the ZMP removes an error; 0.857 omega if None [1/s].
        step_weight: (a1, a2) R^2 on the step vector, beside an offset weight of 1 [-].
        tau_weight: a3 tau_nom^2 on tau, beside the same; above 2 the robot may step for ever at
            the edge of its reserve instead of coming back [-].
        offset_weight: (a4, a5) R^2 on the error at landing that neither ZMP nor comfort takes [-].
        commitment: a landing that is nearer than this cannot be brought forward any more, since
            what a push does shows only after two cycles; two periods if None [s].
        step_duration: T_nom, chosen from the velocity if None [s].
        period: control period [s].

    Raises:
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the leg is too slow to step at all.
        ParameterError: another argument is out of range, or the gait asks more of the leg than it
            can do for ever.
    """

    robot: Robot
    velocity: tuple[float, float]
    ankle: bool = True
    horizon: float = math.inf
    reserve: float | None = None
    comfort: float | None = None
    dcm_gain: float | None = None
    step_weight: tuple[float, float] = (1e-3, 1e-3)
    tau_weight: float = 0.25
    offset_weight: tuple[float, float] = (1.0, 1.0)
    commitment: float | None = None
    step_duration: float | None = None
    period: float = 0.001
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_tracking(self.robot, self.dcm_gain, 0.0, self.period)
        fill_in(
            self,
            dcm_gain=DCM_GAIN * self.robot.omega,
            reserve=RESERVE * self.robot.com_height,
            comfort=COMFORT * self.robot.com_height,
            commitment=COMMITMENT * self.period,
        )
        check_number("horizon", self.horizon, 0.0, "s", endless=True)
        for name, unit in (("reserve", "m"), ("comfort", "m"), ("commitment", "s")):
            check_number(name, getattr(self, name), 0.0, unit)
        check_number("tau_weight", self.tau_weight, 0.0, "-", above=True)
        check_pair("step_weight", self.step_weight, 0.0, "-")
        check_pair("offset_weight", self.offset_weight, 0.0, "-")
        check_weights(
            step_weight=self.step_weight,
            tau_weight=self.tau_weight,
            offset_weight=self.offset_weight,
        )
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        object.__setattr__(self, "gait", gait)
        object.__setattr__(self, "velocity", gait.velocity)
        check_leg(self.robot, gait)
        reach = np.array(self.robot.foot.half) if self.ankle else np.zeros(2)
        room = gait_room(self.robot, gait, (reach[0], reach[1]))
        parameters = new_array(UNIFIED)
        parameters["tracking"] = tracking_parameters(
            self.robot, gait, filled(self.dcm_gain), self.ankle, 0.0, self.period
        )
        parameters["landing"] = self._landing(reach, room)
        parameters["anticipation"] = -math.expm1(-self.robot.omega * self.horizon)
        parameters["observing"] = observing(self.robot.omega, self.period, room)
        parameters["commitment"] = self.commitment
        object.__setattr__(self, "parameters", parameters)
        _compiled()  # Now rather than in the first control cycle.

    def _landing(self, reach: NDArray[np.float64], room: float) -> NDArray[np.void]:
        """The `LANDING` record.

        What comfort leaves to the next step is no more than the ZMP can take up in one.
        """
        gain, comfort = 1.0 + filled(self.dcm_gain) / self.robot.omega, filled(self.comfort)
        taken = -math.expm1(-self.robot.omega * self.gait.step_duration)
        return landing_parameters(
            self.robot,
            reach,
            np.minimum(reach, gain * comfort),
            np.minimum(comfort, taken * reach),
            room=room,
            tau_ref=self.gait.growth,
            step_weight=self.step_weight,
            tau_weight=self.tau_weight,
            offset_weight=self.offset_weight,
            reserve=filled(self.reserve),
            commitment=filled(self.commitment),
        )

    @property
    def kernel(self) -> Callable[..., None]:
        """The compiled cycle over records."""
        return unified_cycle

    def decision(self, state: NDArray[np.void]) -> Decision:
        """What was decided in the cycle that led to this state, with margin and active limits."""
        decision = copy_array(state["decision"])
        _compiled_margin()(self.parameters, state, decision)
        return Decision.of(decision)

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot on the nominal gait observes at a touchdown; right foot first by default."""
        return self.gait.observation(Side.RIGHT if support_side is None else support_side)

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = new_array(UNIFIED_STATE)
        first_plan(self.gait, observation, state)
        return state

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        next_state = new_array(UNIFIED_STATE)
        _compiled()(self.parameters, state, observation.array, next_state)
        return Command.of(next_state["command"]), next_state

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)

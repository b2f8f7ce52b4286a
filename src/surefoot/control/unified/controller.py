"""The unified controller: ZMP, landing place and landing time from one problem.

No switch between small pushes and large ones. Every cycle it observes the push, asks what it may
still do, and solves `control.unified.problem`: while the ZMP can make up for an error the landing
stays where it is; beyond that it moves, in place and time, as far as it has to and the leg can.
Own method; it replaces the hybrid of [OnlineGait], III-C.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.control.base import CompiledController
from surefoot.control.belief import BELIEF, PENDULUM, hold, look
from surefoot.control.defaults import DCM_GAIN
from surefoot.control.fields import described, filled, setting
from surefoot.control.push_observer import (
    OBSERVING,
    PUSH_OBSERVER,
    observe_push,
    observing,
    remember,
)
from surefoot.control.registry import method
from surefoot.control.tracking import (
    PLAN,
    TRACKING,
    check_gain,
    end_cycle,
    keep_box,
    plan_step,
    tracking_parameters,
)
from surefoot.control.unified.anticipation import keep_way_back, margin
from surefoot.control.unified.law import assess, command_landing, place_zmp
from surefoot.control.unified.problem import (
    DECISION,
    LANDING,
    SITUATION,
    Decision,
    landing_parameters,
)
from surefoot.control.unified.solver import decide_landing, flag_limits
from surefoot.dcm.nominal_gait import gait_room
from surefoot.interface import COMMAND
from surefoot.record import copy_array, new_array
from surefoot.robot.robot import Robot

UNIFIED = np.dtype(
    [
        ("tracking", TRACKING),
        ("landing", LANDING),
        ("anticipation", "f8"),
        ("observing", OBSERVING),
        ("commitment", "f8"),
    ],
)
"""Parameters: of tracking, of the landing problem and of the push observer; 1 - e^(-omega h); how
soon before a landing its time can still be brought forward [s]."""

UNIFIED_STATE = np.dtype(
    [
        ("plan", PLAN),
        ("belief", BELIEF),
        ("observer", PUSH_OBSERVER),
        ("situation", SITUATION),
        ("decision", DECISION),
        ("command", COMMAND),
    ],
)

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
    new_step, _ = plan_step(parameters.tracking, state, next_state)
    plan, command = next_state.plan, next_state.command
    tracking, landing = parameters.tracking, parameters.landing
    situation, decision, observer = next_state.situation, next_state.decision, next_state.observer
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
    end_cycle(tracking, (0.0, command.step_duration), new_step, state, next_state)


@njit
def _unified_step(parameters, state, observation, next_state):
    unified_cycle(parameters[0], state[0], observation[0], next_state[0])


@njit
def _margin(parameters, state, decision):
    decision[0].margin = margin(parameters[0].landing, state[0].situation)


@cache
def _compiled_margin() -> Callable[..., None]:
    return entry_point(_margin, UNIFIED, UNIFIED_STATE, DECISION)


@method(
    "unified",
    label="unified (ours)",
    source="Surefoot",
    adapts="ZMP, step location, timing",
    cannot="keeps its trunk upright",
    cites=("Surefoot",),
    order=100,
)
@dataclass(frozen=True)
class UnifiedController(
    CompiledController,
    cycle=unified_cycle,
    arrays=_unified_step,
    parameters=UNIFIED,
    state=UNIFIED_STATE,
):
    """ZMP, landing place and landing time from one problem, up to the limit of physics.

    Raises:
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the leg is too slow to step at all.
        ParameterError: another argument is out of range, or the gait asks more of the leg than it
            can do for ever.
    """

    NEEDS_LEG = True
    robot: Robot = field(metadata=described("whose gait it is, and whose leg and sole are used"))
    ankle: bool = setting(True, "", "whether the ZMP moves inside the sole; False for a point foot")
    horizon: float = setting(
        math.inf,
        "s",
        "h, how much longer a push may go on that is observed; inf for one of which nothing is "
        "known, 0 for none",
        least=0.0,
        endless=True,
    )
    reserve: float | None = setting(
        None,
        "m",
        "rho, distance kept from what cannot be saved, at most half the gait's room R; 0.025 "
        "com_height if None",
        least=0.0,
        search=(0.001, 0.06),
    )
    comfort: float | None = setting(
        None,
        "m",
        "DCM error that the ZMP alone answers, while nothing is in danger; 0.03 com_height if None",
        least=0.0,
        search=(0.001, 0.06),
    )
    dcm_gain: float | None = setting(
        None, "1/s", "K_f, rate at which the ZMP removes an error; 0.857 omega if None",
        above=0.0, search=(0.5, 30.0),
    )  # fmt: skip
    step_weight: tuple[float, float] = setting(
        (1e-3, 1e-3), "-", "(a1, a2) R^2 on the step vector, beside an offset weight of 1",
        least=0.0, is_weight=True, search=(None, (1e-5, 0.1)),
    )  # fmt: skip
    tau_weight: float = setting(
        0.25,
        "-",
        "a3 tau_nom^2 on tau, beside the same; above 2 the robot may step for ever at the edge of "
        "its reserve instead of coming back",
        above=0.0,
        is_weight=True,
        search=(1e-4, 10.0),
    )
    offset_weight: tuple[float, float] = setting(
        (1.0, 1.0),
        "-",
        "(a4, a5) R^2 on the error at landing that neither ZMP nor comfort takes",
        least=0.0,
        is_weight=True,
        search=((1e-3, 1e3), (1e-3, 1e3)),
    )
    commitment: float | None = setting(
        None,
        "s",
        "a landing that is nearer than this cannot be brought forward any more, since what a push "
        "does shows only after two cycles; two periods if None",
        least=0.0,
    )

    def check(self) -> None:
        """Refuse a gain that is too large."""
        check_gain(self.dcm_gain, self.period)

    def defaults(self) -> dict[str, float]:
        """Gain, reserve, comfort and commitment."""
        return {
            "dcm_gain": DCM_GAIN * self.robot.omega,
            "reserve": RESERVE * self.robot.com_height,
            "comfort": COMFORT * self.robot.com_height,
            "commitment": COMMITMENT * self.period,
        }

    def make_parameters(self) -> NDArray[np.void]:
        """The `UNIFIED` record."""
        reach = np.array(self.robot.foot.half) if self.ankle else np.zeros(2)
        room = gait_room(self.robot, self.gait, (reach[0], reach[1]))
        parameters = new_array(UNIFIED)
        parameters["tracking"] = tracking_parameters(
            self.robot, self.gait, self.dcm_gain, self.ankle, 0.0, self.period
        )
        parameters["landing"] = self._landing(reach, room)
        parameters["anticipation"] = -math.expm1(-self.robot.omega * self.horizon)
        parameters["observing"] = observing(self.robot.omega, self.period, room)
        parameters["commitment"] = self.commitment
        return parameters

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

    def decision(self, state: NDArray[np.void]) -> Decision:
        """What was decided in the cycle that led to this state, with margin and active limits."""
        decision = copy_array(state["decision"])
        _compiled_margin()(self.parameters, state, decision)
        return Decision.of(decision)

"""The unified controller: ZMP, landing place and landing time from one problem.

No switch between small pushes and large ones. Every cycle it observes the push, asks what it may
still do, and solves `control.unified.problem`: while the ZMP can make up for an error the landing
stays where it is; beyond that it moves, in place and time, as far as it has to and the leg can.
Own method; it replaces the hybrid of [OnlineGait], III-C.
"""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, Self

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit, record_entry_point
from surefoot.control.base import CompiledController
from surefoot.control.cycle import end_cycle, keep_box
from surefoot.control.defaults import dcm_gain
from surefoot.control.fields import described, filled, setting, weight
from surefoot.control.push_observer import (
    Observing,
    PushObserver,
    observe_push,
    observing,
    remember,
)
from surefoot.control.registry import method
from surefoot.control.tracking import Tracking, TrackingState, plan_step, tracking_parameters
from surefoot.control.unified.anticipation import keep_way_back, margin
from surefoot.control.unified.law import assess, command_landing, place_zmp
from surefoot.control.unified.problem import (
    Decision,
    LandingParameters,
    Situation,
    landing_parameters,
)
from surefoot.control.unified.solver import decide_landing, flag_limits
from surefoot.control.validation import validate
from surefoot.dcm.nominal_gait import NominalGait, gait_room, nominal_gait
from surefoot.record import Record, copy_array, field
from surefoot.robot.gait import GaitLimits
from surefoot.robot.robot import Robot


class UnifiedParameters(Record):
    """Of `UnifiedController`."""

    tracking: Tracking = field("", "of tracking")
    landing: LandingParameters = field("", "of the landing problem")
    anticipation: float = field("-", "1 - e^(-omega h)")
    observing: Observing = field("", "of the push observer")
    commitment: float = field("s", "how soon before a landing it can still be brought forward")


class UnifiedState(TrackingState):
    """What it remembers."""

    observer: PushObserver = field("", "of pushes")
    situation: Situation = field("", "of the last decision")
    decision: Decision = field("", "of the last cycle")


RESERVE, COMFORT = 0.025, 0.03
"""Default reserve and comfort, as fractions of the height of the CoM."""

COMMITMENT = 2.0
"""How many control periods before a landing it cannot be brought forward any more: what a push does
shows after two."""


@njit
def unified_cycle(parameters, state, observation, next_state):
    """One cycle of `UnifiedController` over records."""
    if not validate(parameters.tracking.gate, state, observation, next_state):
        next_state.observer, next_state.decision = state.observer, state.decision
        next_state.situation, next_state.observer.known = state.situation, 0
        return
    observation = next_state.validated.observation
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
    remember(observation, command.zmp, next_state.validated.predicted, observer)
    end_cycle(tracking, (0.0, command.step_duration), new_step, state, next_state)


@njit
def _margin(parameters, state, decision):
    decision.margin = margin(parameters.landing, state.situation)


@cache
def _compiled_margin() -> Callable[..., None]:
    return record_entry_point(_margin, UnifiedParameters, UnifiedState, Decision)


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
    CompiledController, cycle=unified_cycle, parameters=UnifiedParameters, state=UnifiedState
):
    """ZMP, landing place and landing time from one problem, up to the limit of physics.

    Raises:
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the leg is too slow to step at all.
        ParameterError: another argument is out of range, or the gait asks more of the leg than it
            can do for ever.
    """

    NEEDS_LEG = True
    robot: Robot = dataclasses.field(
        metadata=described("whose gait it is, and whose leg and sole are used")
    )
    ankle: bool = setting(True, "", "whether the ZMP moves inside the sole; False for a point foot")
    horizon: float = setting(
        math.inf, "s", "h, how much longer a push may go on that is observed; inf for one of which "
        "nothing is known, 0 for none", least=0.0, endless=True,
    )  # fmt: skip
    reserve: float | None = setting(
        None, "m", "rho, distance kept from what cannot be saved, at most half the gait's room R; "
        "0.025 com_height if None", least=0.0, search=(0.001, 0.06),
        own=lambda controller: RESERVE * controller.robot.com_height,
    )  # fmt: skip
    comfort: float | None = setting(
        None, "m", "DCM error that the ZMP alone answers, while nothing is in danger; 0.03 "
        "com_height if None", least=0.0, search=(0.001, 0.06),
        own=lambda controller: COMFORT * controller.robot.com_height,
    )  # fmt: skip
    dcm_gain: float | None = dcm_gain("the ZMP removes an error", search=(0.5, 30.0))
    step_weight: tuple[float, float] = weight(
        (1e-3, 1e-3), "-", "(a1, a2) R^2 on the step vector, beside an offset weight of 1",
        search=(None, (1e-5, 0.1)),
    )  # fmt: skip
    tau_weight: float = weight(
        0.25, "-", "a3 tau_nom^2 on tau, beside the same; above 2 the robot may step for ever at "
        "the edge of its reserve instead of coming back", above=0.0, search=(1e-4, 10.0),
    )  # fmt: skip
    offset_weight: tuple[float, float] = weight(
        (1.0, 1.0), "-", "(a4, a5) R^2 on the error at landing that neither ZMP nor comfort takes",
        search=((1e-3, 1e3), (1e-3, 1e3)),
    )  # fmt: skip
    commitment: float | None = setting(
        None, "s", "a landing that is nearer than this cannot be brought forward any more, since "
        "what a push does shows only after two cycles; two periods if None", least=0.0,
        own=lambda controller: COMMITMENT * controller.period,
    )  # fmt: skip

    def make_parameters(self) -> UnifiedParameters:
        """Those of tracking, of the landing problem and of the push observer."""
        reach = np.array(self.robot.foot.half) if self.ankle else np.zeros(2)
        room = gait_room(self.robot, self.gait, (reach[0], reach[1]))
        return UnifiedParameters(
            tracking=tracking_parameters(self, dcm_gain=self.dcm_gain, project_zmp=self.ankle),
            landing=self._landing(reach, room),
            anticipation=-math.expm1(-self.robot.omega * self.horizon),
            observing=observing(self.robot.omega, self.period, room),
            commitment=filled(self.commitment),
        )

    def _landing(self, reach: NDArray[np.float64], room: float) -> LandingParameters:
        # What comfort leaves to the next step is no more than the ZMP can take up in one.
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


TIME_ROOM, PLACE_ROOM = 0.005, 0.005
"""To either side of the nominal landing: a box has to have some room [s, m]."""


def with_fixed_timing(robot: Robot, gait: NominalGait) -> Robot:
    """The robot whose steps last as long as in a gait, and land where they like.

    Args:
        robot: whose other limits hold.
        gait: the nominal one.
    """
    nominal = gait.step_duration
    limits = msgspec.structs.replace(
        robot.gait, step_duration=(nominal - TIME_ROOM, nominal + TIME_ROOM)
    )
    return robot.replace(gait=limits)


def with_fixed_place(robot: Robot, gait: NominalGait) -> Robot:
    """The robot that steps where a gait does, whenever it likes.

    A step sideways is outward for one foot and inward for the other, so across the box has both.

    Args:
        robot: whose other limits hold.
        gait: the nominal one.
    """
    length, across = gait.step_length, abs(gait.lateral_step) + PLACE_ROOM
    limits: GaitLimits = copy.copy(robot.gait)
    # A file must have room for steps in place; this box is made anew for every velocity.
    msgspec.structs.force_setattr(limits, "step_x", (length - PLACE_ROOM, length + PLACE_ROOM))
    msgspec.structs.force_setattr(limits, "step_y", (-across, across))
    return robot.replace(gait=limits)


@dataclass(frozen=True)
class FixedPlace(UnifiedController):
    """The unified controller of a robot made by `with_fixed_place`: another velocity gets a box of
    its own.
    """

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity, with the box around the steps of that."""
        old = self.gait
        duration = old.step_duration
        gait = NominalGait(
            velocity, duration, velocity[0] * duration, velocity[1] * duration, old.hip, old.omega
        )
        return replace(self, robot=with_fixed_place(self.robot, gait), velocity=velocity)


def fixed_timing(
    robot: Robot, velocity: tuple[float, float], **parameters: Any
) -> UnifiedController:
    """The unified controller that cannot choose when it steps.

    Args:
        robot: with all its limits.
        velocity: commanded [m/s].
        **parameters: of `UnifiedController`.

    Raises:
        SurefootError: as `UnifiedController`.
    """
    gait = nominal_gait(robot, velocity)
    return UnifiedController(with_fixed_timing(robot, gait), velocity, **parameters)


def fixed_place(robot: Robot, velocity: tuple[float, float], **parameters: Any) -> FixedPlace:
    """The unified controller that cannot choose where it steps.

    Args:
        robot: with all its limits.
        velocity: commanded [m/s].
        **parameters: of `UnifiedController`.

    Raises:
        SurefootError: as `UnifiedController`.
    """
    gait = nominal_gait(robot, velocity)
    box = with_fixed_place(robot, gait)
    return FixedPlace(box, velocity, step_duration=gait.step_duration, **parameters)

"""ZMP preview control over given footsteps: [Kajita2003].

The reference of the ZMP is the centre of each planned foot while it is to stand, known 1.6 s ahead.
A linear quadratic regulator with an integrator drives the jerk of the CoM, see `preview_law`; the
state is measured in every cycle, and only the ZMP that this asks for is commanded:

    zmp = com(k+1) - com''(k+1) / omega^2.

The sole limits it. Where it is cut off, the integrator rests, and the acceleration of the next
cycle is that of the ZMP that really acted, com'' = omega^2 (com - zmp): nothing winds up.

The gait that this walks undisturbed is near the nominal one, but not it: its ZMP begins to move
before the foot does. The plan is therefore a twin that the same law walks undisturbed over the same
footsteps, from the periodic state that is found when the controller is made.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, check_weights
from surefoot.compiled import entry_point, njit
from surefoot.control.base import CompiledController, check_first
from surefoot.control.cycle import end_cycle, side_index
from surefoot.control.fields import filled, setting
from surefoot.control.preview_law import (
    MAX_SAMPLES,
    PreviewParameters,
    PreviewPlan,
    PreviewState,
    land_plan,
    preview_gains,
    regulate,
    regulate_plan,
    walk_plan,
)
from surefoot.control.registry import method
from surefoot.control.tracking import tracking_parameters
from surefoot.control.validation import accept_first, validate
from surefoot.dcm.nominal_gait import NominalGait
from surefoot.errors import ParameterError
from surefoot.interface import Mode, Observation, Status
from surefoot.record import new_array
from surefoot.robot.feet import Side

INPUT_WEIGHT = 1.844e-3
"""Default of R omega^6 [1/m^2]: 1e-6 s^6/m^2, as published, for the paper's biped."""

LOOK_AHEAD = 5.603
"""Default of the preview, in 1 / omega: 1.6 s, as published, for the paper's biped."""

LONGEST_SETTLING = 400
"""Steps in which a gait becomes periodic, or never does."""

SETTLED = 2e-13
"""Change of the touchdown of a periodic gait from one step pair to the next, as a fraction of its
longest step."""

_TRACKING_MODE = int(Mode.TRACKING)
_ZMP_AT_EDGE = int(Status.ZMP_AT_EDGE)


@njit
def preview_cycle(parameters, state, observation, next_state):
    """One cycle of `PreviewControl` over records."""
    if not validate(parameters.gate, state, observation, next_state):
        return
    next_state.plan = state.plan
    plan, command = next_state.plan, next_state.command
    observation = next_state.validated.observation
    yaw, foot = observation.support_yaw, observation.support_foot
    new_step = observation.support_side != plan.support_side
    if new_step:
        walk_plan(parameters, plan.step_duration, yaw, plan)
        land_plan(parameters, observation.support_side, plan)
        regulate_plan(parameters, yaw, plan)
    walk_plan(parameters, observation.elapsed, yaw, plan)
    for i in range(2):
        command.dcm_plan[i] = foot[i] + plan.com[i] + plan.com_velocity[i] / parameters.omega
        command.zmp[i] = state.command.zmp[i] - foot[i]
    at_edge = regulate(
        parameters,
        plan,
        yaw,
        observation.elapsed,
        (observation.com[0] - foot[0], observation.com[1] - foot[1]),
        (observation.com_velocity[0], observation.com_velocity[1]),
        command.zmp,
        plan.measured_sum,
    )
    command.mode, command.double_support = _TRACKING_MODE, 0
    command.status = _ZMP_AT_EDGE if at_edge else 0
    command.step_duration = plan.step_duration
    row = side_index(plan.support_side)
    for i in range(2):
        command.zmp[i] += foot[i]
        command.step_location[i] = foot[i] + plan.step[i]
        command.dcm_offset[i] = parameters.end_offset[row, i]
    in_the_air = 0.0, plan.step_duration
    end_cycle(parameters, in_the_air, new_step, state, next_state)


@njit
def _walk_step(parameters, begun, landed):
    """One step of the twin: from a touchdown to its first sample, and to the next touchdown."""
    begun[0].measured_sum = begun[0].zmp_sum
    regulate_plan(parameters[0], 0.0, begun[0])
    landed[0] = begun[0]
    walk_plan(parameters[0], begun[0].step_duration, 0.0, landed[0])
    land_plan(parameters[0], -begun[0].support_side, landed[0])


@cache
def _compiled_walk() -> Callable[..., None]:
    return entry_point(_walk_step, PreviewParameters, PreviewPlan, PreviewPlan)


def find_periodic_gait(parameters: NDArray[np.void], gait: NominalGait) -> None:
    """Walk undisturbed, from the nominal gait on, until the gait is periodic; write it down.

    Args:
        parameters: of `PreviewParameters`, shape (1,); `start`, `start_zmp` and `end_offset` are
            written.
        gait: where to begin.

    Raises:
        ParameterError: it never becomes periodic.
    """
    walk, omega = _compiled_walk(), gait.omega
    plan = new_array(PreviewPlan.DTYPE)
    begin = gait.observation(Side.RIGHT)
    plan["com"] = begin.com - begin.support_foot
    plan["com_velocity"], plan["support_side"] = begin.com_velocity, Side.RIGHT
    plan["step"], plan["step_duration"] = gait.step(Side.RIGHT), gait.step_duration
    change = np.inf
    last = [np.full(4, np.inf), np.full(4, np.inf)]
    for _ in range(LONGEST_SETTLING):
        row = side_index.py_func(plan["support_side"][0])
        dcm = plan["com"][0] + plan["com_velocity"][0] / omega
        # The integrator settles last; as a length it is the integral over a time constant.
        state = np.concatenate([dcm, omega * parameters["period"] * plan["zmp_sum"][0]])
        change, last[row] = np.abs(state - last[row]).max(), state
        half = parameters["half_foot"][0]
        parameters["start_zmp"][0, row] = np.clip(plan["zmp"][0], -half, half)
        parameters["end_offset"][0, 1 - row] = dcm
        landed = new_array(PreviewPlan.DTYPE)
        walk(parameters, plan, landed)
        parameters["start"][0, row] = plan[0]
        if change < SETTLED * np.abs(parameters["step"]).max():
            return
        plan = landed
    raise ParameterError(
        "a gait that becomes periodic",
        f"one that still changes by {change:.1e} m after {LONGEST_SETTLING} steps",
        "leave the weights out for the defaults, or walk slower",
    )


@method(
    "preview-control",
    label="preview control",
    source="Kajita et al. 2003",
    adapts="ZMP",
    cannot="steps as planned: neither where nor when it steps answers a push",
    cites=("Kajita2003",),
    order=20,
    fixed_steps=True,
    nearness=0.005,
    zmp_trace=0.002,
    given_footsteps=True,
)
@dataclass(frozen=True)
class PreviewControl(
    CompiledController, cycle=preview_cycle, parameters=PreviewParameters, state=PreviewState
):
    """Footsteps as given; the ZMP follows their centres by preview control, inside the sole.

    Of a new velocity, the step under way stays as it was given; the steps after it are new.
    `period` is the sample time of the regulator too.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range, or no gains or no gait come of it.
    """

    error_weight: float = setting(1.0, "1/m^2", "Q_e on the error of the ZMP", above=0.0)
    state_weight: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.0),
        "1/m^2, s^2/m^2, s^4/m^2",
        "the diagonal of Q_x, on the change in a sample of position, velocity and acceleration",
    )
    input_weight: float | None = setting(
        None, "s^6/m^2", "R, on the change of the jerk in a sample; 1.844e-3 / omega^6 if None",
        above=0.0, own=lambda controller: INPUT_WEIGHT / controller.robot.omega**6,
    )  # fmt: skip
    preview: float | None = setting(
        None, "s", "how far ahead the footsteps are known; 5.603 / omega if None",
        own=lambda controller: LOOK_AHEAD / controller.robot.omega,
    )  # fmt: skip

    def check(self) -> None:
        """Refuse weights that are none or too far from each other, and a preview that is none."""
        if not isinstance(self.state_weight, tuple) or len(self.state_weight) != 3:
            raise ParameterError(
                "`state_weight` as (position, velocity, acceleration)",
                repr(self.state_weight),
                "write for example (0.0, 0.0, 0.0)",
            )
        for weight, unit in zip(self.state_weight, ("1/m^2", "s^2/m^2", "s^4/m^2"), strict=True):
            check_number("state_weight", weight, 0.0, unit)
        if self.preview is not None:
            check_number("preview", self.preview, self.period, "s")
        self._check_ratios()

    def _check_ratios(self) -> None:
        # Units of time differ: in those of the pendulum, robots of all sizes have the same ratios.
        omega, (place, speed, change) = self.robot.omega, self.state_weight
        weights = {
            "error_weight": self.error_weight,
            "state_weight": (place, speed * omega**2, change * omega**4),
        }
        if self.input_weight is not None:
            weights["input_weight` * `omega^6"] = self.input_weight * omega**6
        check_weights(**weights)

    def make_parameters(self) -> NDArray[np.void]:
        """Those of its gains, and of the periodic gait that they walk."""
        samples = round(filled(self.preview) / self.period)
        if samples > MAX_SAMPLES:
            raise ParameterError(
                f"a preview of at most {MAX_SAMPLES} periods",
                f"{self.preview} s in periods of {self.period} s",
                "look less far ahead, or decide less often",
            )
        robot, gait = self.robot, self.gait
        gains = preview_gains(
            robot.omega,
            self.period,
            samples,
            self.error_weight,
            self.state_weight,
            filled(self.input_weight),
        )
        step_gain = np.zeros(MAX_SAMPLES + 1)
        step_gain[:samples] = np.cumsum(gains.preview[::-1])[::-1]
        tracking = tracking_parameters(self)
        parameters = PreviewParameters(
            omega=robot.omega,
            period=self.period,
            half_foot=robot.foot.half,
            integral_gain=gains.integral,
            state_gain=gains.state,
            step_gain=step_gain,
            samples=samples,
            step_duration=gait.step_duration,
            step=[gait.step(side) for side in (Side.RIGHT, Side.LEFT)],
            swing=tracking.swing,
            gate=tracking.gate,
        ).array
        find_periodic_gait(parameters, gait)
        return parameters

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot on this method's own gait observes at a touchdown; right foot first."""
        side = Side.RIGHT if support_side is None else support_side
        nominal = self.gait.observation(side)
        plan = self.parameters["start"][0, side_index.py_func(side)]
        com = nominal.support_foot + plan["com"]
        return nominal.replace(
            com=com,
            com_velocity=plan["com_velocity"],
            dcm=com + plan["com_velocity"] / self.robot.omega,
        )

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle, at a touchdown of this method's own gait."""
        check_first(observation)
        state = new_array(PreviewState.DTYPE)
        row = side_index.py_func(observation.support_side)
        parameters, command = self.parameters[0], state["command"][0]
        state["plan"][0] = parameters["start"][row]
        command["zmp"] = observation.support_foot + parameters["start_zmp"][row]
        command["dcm_plan"] = observation.dcm
        command["dcm_offset"] = parameters["end_offset"][row]
        command["step_location"] = observation.support_foot + parameters["step"][row]
        command["step_duration"] = parameters["step_duration"]
        command["swing_foot"] = observation.swing_foot
        accept_first(observation, state)
        return state

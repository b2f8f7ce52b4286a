"""Step onto the capture point at fixed times: [Pratt2006], with the finite foot of [Koolen2012].

With a constant ZMP, the DCM (which these papers call the instantaneous capture point) will be at

    dcm(T) = zmp + (dcm - zmp) e^(omega (T - t))

at touchdown. The ZMP is put where this is the planned place, as far as the sole reaches; then the
foot lands where the offset of what is left is nominal again: p_next = dcm(T) - d_nom. So the foot
steps only for what the sole cannot do, and one step ends an error, as long as its box allows it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from surefoot.compiled import njit
from surefoot.control.base import CompiledController
from surefoot.control.cycle import end_cycle, side_index
from surefoot.control.fields import setting
from surefoot.control.registry import method
from surefoot.control.tracking import (
    EDGE_TOLERANCE,
    Tracking,
    TrackingState,
    plan_step,
    tracking_parameters,
)
from surefoot.control.validation import validate
from surefoot.dcm.pendulum import dcm_flow
from surefoot.dcm.support import nearest_under_foot
from surefoot.geometry import length
from surefoot.interface import Mode, Status

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
    if length(zmp_x - asked_x, zmp_y - asked_y) > EDGE_TOLERANCE * parameters.swing.reach:
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
    if validate(parameters.gate, state, observation, next_state):
        new_step, _ = plan_step(parameters, state, next_state)
        command = next_state.command
        capture(parameters, next_state.validated.observation, next_state.plan, command)
        end_cycle(parameters, (0.0, command.step_duration), new_step, state, next_state)


@method(
    "capture-point",
    label="capture-point stepping",
    source="Pratt et al. 2006; Koolen et al. 2012",
    adapts="ZMP, step location",
    cannot="steps at fixed times; clips a landing to the step box only, and the leg may come short",
    cites=("Pratt2006", "Koolen2012"),
    order=40,
)
@dataclass(frozen=True)
class CapturePointStepping(
    CompiledController, cycle=capture_cycle, parameters=Tracking, state=TrackingState
):
    """Steps at fixed times onto the capture point; the ZMP does what it can inside the sole.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    ankle: bool = setting(
        True, "", "whether the ZMP moves inside the sole; False is the point foot of [Pratt2006]"
    )

    def make_parameters(self) -> Tracking:
        """Those of tracking, whose plan is used and whose gain is not."""
        parameters = tracking_parameters(self)
        return parameters if self.ankle else parameters.replace(half_foot=(0.0, 0.0))

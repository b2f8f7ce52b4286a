"""A control method as somebody else's package brings it: installed by `test_own_package.py`.

Tracking that also steps: the foot lands off its place by a share of the DCM error.
"""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.compiled import njit
from surefoot.control.base import CompiledController
from surefoot.control.cycle import end_cycle, keep_box
from surefoot.control.defaults import DCM_GAIN
from surefoot.control.fields import setting
from surefoot.control.registry import method
from surefoot.control.tracking import (
    Tracking,
    TrackingState,
    plan_step,
    track,
    tracking_parameters,
)
from surefoot.control.validation import validate

SHARE = 0.5


@njit
def leaning_cycle(parameters, state, observation, next_state):
    if not validate(parameters.gate, state, observation, next_state):
        return
    new_step, _ = plan_step(parameters, state, next_state)
    plan, command, now = next_state.plan, next_state.command, next_state.validated.observation
    track(parameters, now, plan, command)
    for i in range(2):
        command.step_location[i] += SHARE * (now.dcm[i] - command.dcm_plan[i])
    keep_box(parameters, now, command)
    end_cycle(parameters, (0.0, plan.step_duration), new_step, state, next_state)


@method(
    "leaning",
    label="tracking that steps",
    source="a test",
    adapts="ZMP, step location",
    cannot="steps at fixed times",
    cites=("Pratt2006",),
)
@dataclass(frozen=True)
class Leaning(CompiledController, cycle=leaning_cycle, parameters=Tracking, state=TrackingState):
    """Tracks, and lands off its place by half of the DCM error."""

    gain: float = setting(DCM_GAIN, "-", "K_f / omega", above=0.0, search=(0.2, 3.0))

    def make_parameters(self):
        return tracking_parameters(self, dcm_gain=self.gain * self.robot.omega)

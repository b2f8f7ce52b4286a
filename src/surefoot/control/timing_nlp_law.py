"""The compiled part of step decisions by nonlinear optimisation: what comes before and after one.

While the DCM error is below the threshold, the ZMP tracks the plan and there is nothing to decide.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit
from surefoot.control.belief import BELIEF, hold, look, mark
from surefoot.control.cycle import command_swing, growth_since_touchdown
from surefoot.control.step_sequence import LONGEST_HORIZON, PLANNED_STEPS
from surefoot.control.tracking_law import (
    PLAN,
    TRACKING,
    begin_plan,
    follow_plan,
    plan_landing,
    track,
)
from surefoot.dcm.support import nearest_under_foot
from surefoot.interface import COMMAND, Mode, Status

TIMING_NLP = np.dtype(
    [
        ("tracking", TRACKING),
        ("threshold", "f8"),
        ("solve_period", "f8"),
        ("longest", "f8"),
        ("zmp_reach", "f8", (2,)),
    ]
)
"""Parameters: of tracking, the threshold [m], how often the steps are decided and how long a step
may last [s], how far the ZMP moves in a decision [m]."""

TIMING_NLP_STATE = np.dtype(
    [
        ("plan", PLAN),
        ("belief", BELIEF),
        ("steps", PLANNED_STEPS),
        ("decided_at", "f8"),
        ("landing_time", "f8"),
        ("known", "i8"),
        ("status", "i8"),
        ("due", "i8"),
        ("command", COMMAND),
    ],
)
"""What is remembered: the plan that is tracked; the steps last decided, when that was and when the
first of them ends, since touchdown [s]; whether there are such steps; what that decision could not
keep; and, in the state that `step` is about to return, what of `DECIDE` and `CARRY_ON` is to do."""

CARRY_ON = 1
"""The steps last decided stand."""

DECIDE = 2
"""The steps are decided anew."""

_ADAPTING = int(Mode.ADAPTING)
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)


@njit
def _shift_steps(steps):
    """The second of the planned steps is the first one now; the last one is thought to repeat."""
    for k in range(LONGEST_HORIZON - 1):
        steps.duration[k] = steps.duration[k + 1]
        for i in range(2):
            steps.step[k, i] = steps.step[k + 1, i]
            steps.zmp[k, i] = steps.zmp[k + 1, i]
            steps.offset[k, i] = steps.offset[k + 1, i]


@njit
def _remember(state, next_state):
    """Take over what was known in the cycle before."""
    next_state.plan, next_state.steps = state.plan, state.steps
    next_state.decided_at, next_state.landing_time = state.decided_at, state.landing_time
    next_state.known, next_state.status, next_state.due = state.known, state.status, 0


@njit
def begin_cycle(parameters, state, observation, next_state):
    """All of a cycle that tracks or holds; of one that adapts, what comes before the decision."""
    _remember(state, next_state)
    if look(parameters.tracking.gate, state, observation, next_state):
        hold(state, next_state)
        return
    observation = next_state.belief.seen
    plan, command, tracking = next_state.plan, next_state.command, parameters.tracking
    new_step = observation.support_side != plan.support_side
    if new_step:
        begin_plan(tracking, observation, plan.adapting != 0, plan)
        plan.adapting = 0
        _shift_steps(next_state.steps)
        next_state.landing_time = next_state.steps.duration[0]
        next_state.decided_at = -math.inf
    if plan.adapting == 0:
        plan_landing(tracking, observation, plan)
    growth = growth_since_touchdown(tracking.omega, observation.elapsed)
    error = follow_plan(tracking, observation, growth, plan, command)
    # A foot that is on the ground already cannot be sent elsewhere.
    if error >= parameters.threshold and plan.closing == 0:
        plan.adapting = 1
    if plan.adapting != 0:
        waited = observation.elapsed - next_state.decided_at
        # Half a cycle early rather than one late.
        due = waited >= parameters.solve_period - 0.5 * tracking.swing.period or waited < 0.0
        next_state.due = DECIDE if due or next_state.known == 0 else CARRY_ON
        return
    next_state.known = 0
    next_state.decided_at = -math.inf
    track(tracking, observation, plan, command)
    command_swing(
        tracking.swing,
        observation,
        (plan.opening_after, plan.step_duration - plan.closing_before),
        tracking.landing_yaw,
        state.command,
        plan.phase,
        new_step,
        command,
    )
    mark(next_state)


@njit
def _keep_under_sole(parameters, observation, command):
    """Move the ZMP into the sole as it is turned, and the offset at landing along."""
    reach, foot = parameters.zmp_reach, observation.support_foot
    away_x, away_y = command.zmp[0] - foot[0], command.zmp[1] - foot[1]
    x, y = nearest_under_foot(away_x, away_y, reach[0], reach[1], observation.support_yaw)
    growth = math.exp(parameters.tracking.omega * (command.step_duration - observation.elapsed))
    command.zmp[0], command.zmp[1] = foot[0] + x, foot[1] + y
    command.dcm_offset[0] += (x - away_x) * (1.0 - growth)
    command.dcm_offset[1] += (y - away_y) * (1.0 - growth)


@njit
def end_cycle(parameters, state, next_state):
    """Command the first of the steps that were decided."""
    observation = next_state.belief.seen
    command, steps, elapsed = next_state.command, next_state.steps, observation.elapsed
    side = observation.support_side
    command.mode, command.status, command.double_support = _ADAPTING, next_state.status, 0
    if elapsed > parameters.longest:
        command.status |= _NO_TIME_LEFT
    command.step_duration = max(next_state.landing_time, elapsed)
    for i in range(2):
        # In a step's own frame y points to its swing side.
        sign = 1 if i == 0 else side
        command.zmp[i] = observation.support_foot[i] + sign * steps.zmp[0, i]
        command.step_location[i] = observation.support_foot[i] + sign * steps.step[0, i]
        command.dcm_offset[i] = sign * steps.offset[0, i]
    if observation.support_yaw != 0.0:
        _keep_under_sole(parameters, observation, command)
    command_swing(
        parameters.tracking.swing,
        observation,
        (0.0, command.step_duration),
        parameters.tracking.landing_yaw,
        state.command,
        next_state.plan.phase,
        side != state.plan.support_side,
        command,
    )
    mark(next_state)

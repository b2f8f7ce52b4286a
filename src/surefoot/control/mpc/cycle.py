"""The compiled part of linear MPC: observe, put the program together, act on the answer."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.control.cycle import end_cycle, keep_box, side_index
from surefoot.control.push_observer import Observing, PushObserver, observe_push, remember
from surefoot.control.tracking import Tracking, TrackingState, plan_step
from surefoot.control.validation import validate
from surefoot.dcm.leg import furthest
from surefoot.dcm.support import nearest_under_foot
from surefoot.dcm.viable_displacement import NODES
from surefoot.interface import Mode, Status
from surefoot.record import Array, Record, Vector2, field


class MpcParameters(Record):
    """Of a linear MPC; without free steps and without a trunk by default.

    A hip torque acts like a shift of the ZMP by torque / (m g), and that shift is the unknown.
    """

    tracking: Tracking = field("", "of tracking, whose plan is the reference")
    nominal_step: Array = field("m", "by support side", shape=(2, 2))
    solve_period: float = field("s", "from one program to the next")
    sample: float = field("s", "from node to node")
    samples_per_step: int = field("", "of a nominal step")
    samples: int = field("", "of the horizon")
    steps: int = field("", "that are free", default=0)
    torque_per_shift: float = field("N", "m g", default=0.0)
    max_shift: float = field("m", "of a hip torque", default=0.0)
    max_lean: float = field("rad", "of the trunk", default=0.0)
    unit: float = field("m", "in which programs are solved")
    moved: float = field("m", "a landing further from the planned one begins a new plan")
    observing: Observing = field("", "of the push observer")
    saved: Array = field(
        "m", "what steps at the times of the gait can save after a landing, on nodes; see "
        "`dcm.landing_schedule`", shape=(2, 2, NODES), default=0.0,
    )  # fmt: skip
    low: Vector2 = field("m", "the first node", default=(0.0, 0.0))
    spacing: Vector2 = field("m", "from node to node", default=(0.0, 0.0))


class MpcDecision(Record):
    """What the last program decided."""

    zmp: Vector2 = field("m", "relative to the foot")
    landing: Vector2 = field("m", "relative to the planned one")
    offset: Vector2 = field("m", "of the DCM there")
    torque: Vector2 = field("N m", "of the hip")
    until: float = field("s", "time since touchdown at which the next program is due")
    status: int = field("", "what the program could not keep")
    new_step: int = field("", "1 in the first cycle of a step")


class MpcState(TrackingState):
    """What it remembers."""

    decision: MpcDecision = field("", "of the last program")
    observer: PushObserver = field("", "of pushes")


class Work(NamedTuple):
    """What `prepare` writes, by axis, for the solver of the program."""

    deviation: NDArray[np.float64]
    """DCM (and lean of the trunk) against the plan, and the push, shape (2, m)."""
    gradient: NDArray[np.float64]
    """Shape (2, n)."""
    lower: NDArray[np.float64]
    """Bounds on the unknowns and on the rows, shape (2, n + r)."""
    upper: NDArray[np.float64]

    @classmethod
    def of(cls, programs: Any) -> Work:
        """Room for one of these `Programs`."""
        unknowns, parts = programs.gain.shape[1:]
        bounds = (2, unknowns + programs.rows.shape[1])
        return cls(
            np.empty((2, parts)), np.empty((2, unknowns)), np.empty(bounds), np.empty(bounds)
        )


KEPT = 0.02
"""Of the interval of landings that can be saved if the push ends now, what a landing for a push
that goes on keeps from either end."""

DUE = 1e-7
"""What is due within this part of a period or of a sample is due now."""

AT_EDGE = 1e-8
"""A ZMP this near to the edge of the sole, as a part of half the sole, is at the edge."""

HELD, KEEP, SOLVE = range(3)
"""What is to do in a cycle: nothing, what was decided, or to decide."""

_ADAPTING = int(Mode.ADAPTING)
_TRACKING_MODE = int(Mode.TRACKING)
_ZMP_AT_EDGE = int(Status.ZMP_AT_EDGE)
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)
_NOT_CONVERGED = int(Status.NOT_CONVERGED)


@njit
def _deviation(plan, observation, growth, force, deviation):
    """DCM (and lean of the trunk) against the plan, and the push, axis by axis; the lateral one
    counts towards the swing foot, so that left and right are the same program.

    The convergent part of the motion decays by itself. To chase it too would make a disturbance of
    every new velocity.
    """
    for i in range(2):
        sign = 1.0 if i == 0 else float(observation.support_side)
        error = observation.dcm[i] - observation.support_foot[i] - plan.start_offset[i] * growth
        deviation[i, 0] = sign * error
        if deviation.shape[1] == 4:
            deviation[i, 1] = sign * observation.trunk_lean[i]
            deviation[i, 2] = sign * observation.trunk_lean_velocity[i]
        if deviation.shape[1] > 1:
            deviation[i, deviation.shape[1] - 1] = sign * force[i]


@njit
def _saved_landings(parameters, axis, offset, growth):
    """Between which landings the step under way must end for later ones to save it, if nothing
    pushes from now on; the ZMP does what it can. In the axes of the program.

    With W(l) what is saved after a landing at l, ahead and behind, and c the reach of the ZMP,
    l + W(l) >= e_min - c and l - W(l) <= e_max + c: both sides grow with l.

    Args:
        parameters: an `MpcParameters` record.
        axis: 0 for x; 1 for y, towards the swing foot.
        offset: of the DCM from the support foot now [m].
        growth: of the DCM until the landing.

    Returns:
        The ends, the least one above the largest if nothing saves it [m].
    """
    reach = parameters.tracking.half_foot[axis]
    low, spacing = parameters.low[axis], parameters.spacing[axis]
    taken = reach * (growth - 1.0) + reach
    least, most = offset * growth - taken, offset * growth + taken
    # Across, ahead of this step is inward of the next one.
    ahead, behind = parameters.saved[axis, axis], parameters.saved[axis, 1 - axis]
    last = ahead.shape[0] - 1
    first, final = low + last * spacing, low
    for node in range(last, -1, -1):
        place = low + node * spacing
        if place + ahead[node] < least:
            if node < last:
                rise = spacing + ahead[node + 1] - ahead[node]
                first = place + spacing * (least - place - ahead[node]) / rise
            else:
                first = math.inf
            break
        first = place
    for node in range(last + 1):
        place = low + node * spacing
        if place - behind[node] > most:
            if node > 0:
                rise = spacing - behind[node] + behind[node - 1]
                before = place - spacing - behind[node - 1]
                final = place - spacing + spacing * (most - before) / rise
            else:
                final = -math.inf
            break
        final = place
    return first, final


@njit
def _bound_steps(parameters, plan, observation, force, lower, upper):
    """Bounds on the step vectors; the first one also within reach of the leg.

    A step for a push that may go on must also be one that is saved if the push ends now.
    """
    tracking, first = parameters.tracking, parameters.samples
    left = max(plan.step_duration - observation.elapsed, 0.0)
    growth = math.exp(tracking.omega * left)
    for j in range(parameters.steps):
        side = observation.support_side if j % 2 == 0 else -observation.support_side
        row = side_index(side)
        for i in range(2):
            planned = plan.step[i] if j == 0 else parameters.nominal_step[row, i]
            low, high = tracking.step_min[row, i] - planned, tracking.step_max[row, i] - planned
            if j == 0 and force[i] != 0.0:
                sign = 1.0 if i == 0 else float(side)
                offset = sign * (observation.dcm[i] - observation.support_foot[i])
                least, largest = _saved_landings(parameters, i, offset, growth)
                kept = KEPT * (largest - least)
                if kept > 0.0:
                    ends = sign * (least + kept) - planned, sign * (largest - kept) - planned
                    least, largest = min(ends[0], ends[1]), max(ends[0], ends[1])
                    low, high = min(max(low, least), high), max(min(high, largest), low)
            speed, acceleration = tracking.swing.max_speed, tracking.swing.max_acceleration
            if j == 0 and (speed < math.inf or acceleration < math.inf):
                away = observation.swing_foot[i] - observation.support_foot[i] - planned
                velocity = observation.swing_foot_velocity[i]
                ahead = away + furthest(velocity, left, speed, acceleration)
                behind = away - furthest(-velocity, left, speed, acceleration)
                low, high = min(max(low, behind), ahead), max(min(high, ahead), behind)
            if i == 1 and observation.support_side < 0:
                low, high = -high, -low
            lower[i, first + j], upper[i, first + j] = low, high


@njit
def prepare(parameters, programs, state, observation, next_state, work):
    """Everything before the program: observe, go on with the plan, put the program together.

    Args:
        parameters, state, observation, next_state: arrays of one record.
        programs: of every control cycle of a step.
        work: what is put together.

    Returns:
        what is to do, HELD, KEEP or SOLVE, and the control cycle of the step that it is.
    """
    parameters, state, observation = parameters[0], state[0], observation[0]
    following = next_state[0]
    following.decision, following.observer = state.decision, state.observer
    if not validate(parameters.tracking.gate, state, observation, following):
        following.observer.known = 0
        return HELD, 0
    observation = following.validated.observation
    new_step, growth = plan_step(parameters.tracking, state, following)
    plan, decision, observer = following.plan, following.decision, following.observer
    observe_push(parameters.observing, state.observer, observation, observer)
    decision.new_step = 1 if new_step else 0
    wait = decision.until - observation.elapsed
    # Also a program that was put together while the clock was ahead is due.
    due = DUE * parameters.tracking.swing.period
    if not new_step and due < wait <= parameters.solve_period + due:
        return KEEP, 0
    cycle = max(round(observation.elapsed / parameters.tracking.swing.period), 0)
    cycle = min(cycle, programs.gain.shape[0] - 1)
    _deviation(plan, observation, growth, observer.force, work.deviation)
    work.gradient[:] = 0.0
    for i in range(2):
        for a in range(work.gradient.shape[1]):
            for b in range(work.deviation.shape[1]):
                work.gradient[i, a] += programs.gain[cycle, a, b] * work.deviation[i, b]
    _bound(parameters, plan, observation, observer.force, programs.row_state[cycle], work)
    return SOLVE, cycle


@njit
def _bound(parameters, plan, observation, force, row_state, work):
    """Write the bounds on the unknowns, and on the lean of the trunk."""
    unknowns, half = work.gradient.shape[1], parameters.tracking.half_foot
    lower, upper = work.lower, work.upper
    for i in range(2):
        for a in range(parameters.samples):
            lower[i, a], upper[i, a] = -half[i], half[i]
    _bound_steps(parameters, plan, observation, force, lower, upper)
    for i in range(2):
        for a in range(parameters.samples + parameters.steps, unknowns):
            lower[i, a], upper[i, a] = -parameters.max_shift, parameters.max_shift
        for a in range(row_state.shape[0]):
            free = 0.0
            for b in range(work.deviation.shape[1]):
                free += row_state[a, b] * work.deviation[i, b]
            lower[i, unknowns + a] = -parameters.max_lean - free
            upper[i, unknowns + a] = parameters.max_lean - free


@njit
def _offset_at_landing(parameters, deviation, solution, axis, cycle):
    """Deviation of the DCM when the foot lands, in the axes of the program [m]."""
    omega, sample = parameters.tracking.omega, parameters.sample
    elapsed = cycle * parameters.tracking.swing.period
    node = math.floor(elapsed / sample + DUE)
    dcm = deviation[axis, 0]
    start, shifts = elapsed, parameters.samples + parameters.steps
    for a in range(min(parameters.samples_per_step - node, parameters.samples)):
        end = (node + 1 + a) * sample
        pivot = solution[axis, a]
        if parameters.max_shift > 0.0:
            pivot += solution[axis, shifts + a]
        dcm = pivot + (dcm - pivot) * math.exp(omega * (end - start))
        start = end
    return dcm


@njit
def _keep_under_sole(parameters, observation, cycle, solution):
    """Move the ZMPs of this step into the rotated sole; the program has it straight."""
    half, yaw = parameters.tracking.half_foot, observation.support_yaw
    if yaw == 0.0:
        return
    side = float(observation.support_side)
    node = math.floor(cycle * parameters.tracking.swing.period / parameters.sample + DUE)
    for a in range(min(max(parameters.samples_per_step - node, 1), parameters.samples)):
        x, y = nearest_under_foot(solution[0, a], side * solution[1, a], half[0], half[1], yaw)
        solution[0, a], solution[1, a] = x, side * y


@njit
def decide(parameters, deviation, solution, cycle, solved, next_state):
    """Take the solution of the program into the state."""
    parameters, observation = parameters[0], next_state[0].validated.observation
    _keep_under_sole(parameters, observation, cycle, solution)
    plan, decision = next_state[0].plan, next_state[0].decision
    node = math.floor(observation.elapsed / parameters.sample + DUE) + 1
    decision.until = min(observation.elapsed + parameters.solve_period, node * parameters.sample)
    decision.status = 0 if solved else _NOT_CONVERGED
    for i in range(2):
        sign = 1.0 if i == 0 else float(observation.support_side)
        decision.zmp[i] = sign * solution[i, 0]
        if abs(solution[i, 0]) >= (1.0 - AT_EDGE) * parameters.tracking.half_foot[i]:
            decision.status |= _ZMP_AT_EDGE
        landing = 0.0
        if parameters.steps > 0:
            landing = solution[i, parameters.samples]
        decision.torque[i] = 0.0
        if parameters.max_shift > 0.0:
            shift = solution[i, parameters.samples + parameters.steps]
            decision.torque[i] = sign * parameters.torque_per_shift * shift
        dcm = _offset_at_landing(parameters, deviation, solution, i, cycle)
        decision.landing[i] = sign * landing
        decision.offset[i] = plan.end_offset[i] + sign * (dcm - landing)


@njit
def act(parameters, state, next_state):
    """Write the command of what was decided."""
    parameters, observation = parameters[0], next_state[0].validated.observation
    plan, decision = next_state[0].plan, next_state[0].decision
    command = next_state[0].command
    adapted, acting = False, next_state[0].observer.zmp
    for i in range(2):
        adapted = adapted or abs(decision.landing[i]) > parameters.moved
        command.zmp[i] = observation.support_foot[i] + decision.zmp[i]
        landing = observation.support_foot[i] + plan.step[i] + decision.landing[i]
        command.step_location[i] = landing
        command.dcm_offset[i] = decision.offset[i]
        command.hip_torque[i] = decision.torque[i]
        # A hip torque moves the DCM as a ZMP further on does.
        acting[i] = command.zmp[i]
        if parameters.torque_per_shift > 0.0:
            acting[i] += decision.torque[i] / parameters.torque_per_shift
    keep_box(parameters.tracking, observation, command)
    plan.adapting = 1 if adapted else 0
    predicted = next_state[0].validated.predicted
    remember(observation, acting, predicted, next_state[0].observer)
    command.mode = _ADAPTING if adapted else _TRACKING_MODE
    command.status, command.double_support = decision.status, 0
    if observation.elapsed > plan.step_duration + DUE * parameters.tracking.swing.period:
        command.status |= _NO_TIME_LEFT
    command.step_duration = max(plan.step_duration, observation.elapsed)
    in_the_air = 0.0, plan.step_duration
    end_cycle(parameters.tracking, in_the_air, decision.new_step != 0, state[0], next_state[0])

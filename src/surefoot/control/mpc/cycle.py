"""The compiled part of linear MPC: see the robot, put its program together, act on the answer."""

from __future__ import annotations

import math

import numpy as np

from surefoot.compiled import njit
from surefoot.control.belief import BELIEF, PENDULUM, hold, look
from surefoot.control.cycle import side_index
from surefoot.control.push_observer import (
    OBSERVING,
    PUSH_OBSERVER,
    observe_push,
    remember,
)
from surefoot.control.tracking import (
    PLAN,
    TRACKING,
    end_cycle,
    keep_box,
    plan_step,
)
from surefoot.dcm.leg import furthest
from surefoot.dcm.support import nearest_under_foot
from surefoot.dcm.viable_displacement import NODES
from surefoot.interface import COMMAND, Mode, Status

MPC = np.dtype(
    [
        ("tracking", TRACKING),
        ("nominal_step", "f8", (2, 2)),
        ("solve_period", "f8"),
        ("sample", "f8"),
        ("samples_per_step", "i8"),
        ("samples", "i8"),
        ("steps", "i8"),
        ("torque_per_shift", "f8"),
        ("max_shift", "f8"),
        ("max_lean", "f8"),
        ("unit", "f8"),
        ("moved", "f8"),
        ("observing", OBSERVING),
        ("worth", "f8", (2, 2, NODES)),
        ("low", "f8", (2,)),
        ("spacing", "f8", (2,)),
    ],
)
"""Parameters; `steps` counts the free ones. A hip torque acts like a shift of the ZMP by
torque / (m g), and that shift is the unknown: `torque_per_shift` is m g [N]. Programs are solved in
lengths of `unit` [m]. A landing further than
`moved` from the planned one begins the next step on a new plan [m]. `worth` is what steps at the
times of the gait can still save after a landing, see `dcm.landing_schedule`, on nodes from
`low` at a `spacing` [m]."""

DECISION = np.dtype(
    [
        ("zmp", "f8", (2,)),
        ("landing", "f8", (2,)),
        ("offset", "f8", (2,)),
        ("torque", "f8", (2,)),
        ("until", "f8"),
        ("status", "i8"),
        ("new_step", "i8"),
    ],
)
"""What the last program decided: ZMP relative to the foot, landing relative to the planned one, DCM
offset there [m]; hip torque [N m]; time since touchdown at which the next program is due [s]."""

MPC_STATE = np.dtype(
    [
        ("plan", PLAN),
        ("belief", BELIEF),
        ("decision", DECISION),
        ("observer", PUSH_OBSERVER),
        ("command", COMMAND),
    ]
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
    """DCM (and lean of the trunk) against the plan, and the push, axis by axis; the lateral one is
    looked at towards the swing foot, so that left and right are the same program.

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
    l + W(l) >= e_least - c and l - W(l) <= e_most + c: both sides grow with l.

    Args:
        parameters: an `MPC` record.
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
    ahead, behind = parameters.worth[axis, axis], parameters.worth[axis, 1 - axis]
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
                least, most = _saved_landings(parameters, i, offset, growth)
                kept = KEPT * (most - least)
                if kept > 0.0:
                    ends = sign * (least + kept) - planned, sign * (most - kept) - planned
                    least, most = min(ends[0], ends[1]), max(ends[0], ends[1])
                    low, high = min(max(low, least), high), max(min(high, most), low)
            most, hardest = tracking.swing.max_speed, tracking.swing.max_acceleration
            if j == 0 and (most < math.inf or hardest < math.inf):
                away = observation.swing_foot[i] - observation.support_foot[i] - planned
                velocity = observation.swing_foot_velocity[i]
                ahead = away + furthest(velocity, left, most, hardest)
                behind = away - furthest(-velocity, left, most, hardest)
                low, high = min(max(low, behind), ahead), max(min(high, ahead), behind)
            if i == 1 and observation.support_side < 0:
                low, high = -high, -low
            lower[i, first + j], upper[i, first + j] = low, high


@njit
def prepare(
    parameters, gain, row_state, state, observation, next_state, deviation, gradient, lower, upper
):
    """Everything before the program: see the robot, go on with the plan, put the program together.

    Ten arguments: the tables of the program come from Python beside the record of parameters, and
    what is put together goes back to Python as four arrays, of sizes that only the method knows.

    Returns:
        what is to do, HELD, KEEP or SOLVE, and the control cycle of the step that it is.
    """
    parameters, state, observation = parameters[0], state[0], observation[0]
    following = next_state[0]
    following.decision = state.decision
    if look(parameters.tracking.gate, state, observation, following):
        following.observer = state.observer
        following.observer.seen = 0
        hold(state, following)
        return HELD, 0
    observation = following.belief.seen
    new_step, growth = plan_step(parameters.tracking, state, following)
    plan, decision, observer = following.plan, following.decision, following.observer
    observe_push(parameters.observing, state.observer, observation, observer)
    decision.new_step = 1 if new_step else 0
    wait = decision.until - observation.elapsed
    # Also a program that was put together while the clock was ahead is due.
    due = DUE * parameters.tracking.swing.period
    if not new_step and due < wait <= parameters.solve_period + due:
        return KEEP, 0
    cycle = min(
        max(round(observation.elapsed / parameters.tracking.swing.period), 0), gain.shape[0] - 1
    )
    _deviation(plan, observation, growth, observer.force, deviation)
    gradient[:] = 0.0
    for i in range(2):
        for a in range(gradient.shape[1]):
            for b in range(deviation.shape[1]):
                gradient[i, a] += gain[cycle, a, b] * deviation[i, b]
        for a in range(parameters.samples):
            lower[i, a] = -parameters.tracking.half_foot[i]
            upper[i, a] = parameters.tracking.half_foot[i]
    _bound_steps(parameters, plan, observation, observer.force, lower, upper)
    unknowns = gradient.shape[1]
    for i in range(2):
        for a in range(parameters.samples + parameters.steps, unknowns):
            lower[i, a], upper[i, a] = -parameters.max_shift, parameters.max_shift
        for a in range(row_state.shape[1]):
            free = 0.0
            for b in range(deviation.shape[1]):
                free += row_state[cycle, a, b] * deviation[i, b]
            lower[i, unknowns + a] = -parameters.max_lean - free
            upper[i, unknowns + a] = parameters.max_lean - free
    return SOLVE, cycle


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
    """Move the ZMPs of this step into the sole as it is turned; the program has it straight."""
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
    parameters, observation = parameters[0], next_state[0].belief.seen
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
    parameters, observation = parameters[0], next_state[0].belief.seen
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
    remember(observation, acting, next_state[0].observer)
    if next_state[0].belief.guessed & PENDULUM:
        # Nothing pushes a pendulum that is only predicted.
        next_state[0].observer.seen = 0
    command.mode = _ADAPTING if adapted else _TRACKING_MODE
    command.status, command.double_support = decision.status, 0
    if observation.elapsed > plan.step_duration + DUE * parameters.tracking.swing.period:
        command.status |= _NO_TIME_LEFT
    command.step_duration = max(plan.step_duration, observation.elapsed)
    in_the_air = 0.0, plan.step_duration
    end_cycle(parameters.tracking, in_the_air, decision.new_step != 0, state[0], next_state[0])

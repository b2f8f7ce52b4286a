"""What a controller believes of what it is shown, and what it goes by where it cannot.

An observation has four parts: clock, feet, pendulum and trunk. Each is compared with what was last
believed and with what the robot can do in between. A part that cannot be true is replaced by what
the model predicts from there, with the commands that were carried out; the command then says HELD.
In the first such cycle the last command simply stands; after that the method decides on the
prediction, so that a robot that nothing pushes walks on without any sensor.

A part that goes on to say the same is believed after a few cycles, since it may be true: a blow,
another origin of the world, a clock that was set. Only a robot that cannot exist is never believed.
All bounds are lengths and times of the robot.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.control.plausibility import (
    ALMOST,
    clock_fits,
    feet_fit,
    is_in_reach,
    is_near,
    is_up,
    pendulum_fits,
    trunk_fits,
)
from surefoot.dcm.pendulum import com_flow, trunk_flow
from surefoot.interface import OBSERVATION, Observation, Status

BELIEF = np.dtype(
    [
        ("seen", OBSERVATION),
        ("shown", OBSERVATION),
        ("time", "f8"),
        ("began", "f8"),
        ("streak", "i8", (3,)),
        ("guessed", "i8"),
        ("blind", "i8"),
    ],
)
"""What is believed: the observation that is decided on, whose `time` counts from the start of the
controller so that it is exact for any epoch; what was shown in the last cycle, if that was not
believed; time of the last believed cycle and of the touchdown before it, in the epoch of the
observations [s]; for how many cycles clock, feet and pendulum go on to say what is not believed;
which parts are guessed now; for how many cycles some part has been."""

CLOCK, FEET, PENDULUM, TRUNK = 1, 2, 4, 8
"""Parts of an observation, as bits of `BELIEF.guessed`."""

STRICT = 0.125
"""Part of that jump which is left to an observation of which some part cannot be true."""

TOGETHER, APART, STEPS_OF_DOUBT = 0.5, 0.25, 4.0
"""A DCM may differ from com + com_velocity / omega by this part of the latter, if it was made with
the natural frequency of another pendulum, and by this part of `jump`. One that differs more is
believed only if it has gone on for so many of the longest steps: then they never did fit."""

RESOLUTION = 1e-15
"""A double resolves a time to this part of it; within that, the clock of the step is the better."""

FURTHEST_PLACE = 1e9
"""A double resolves a place this many jumps from the origin to 1e-7 of one; no further one is
believed anew."""

_HELD, _ZMP_AT_EDGE = int(Status.HELD), int(Status.ZMP_AT_EDGE)


def first_belief(observation: Observation, state: NDArray[np.void]) -> None:
    """Believe the observation that a walk begins with; it has been checked."""
    belief = state["belief"]
    belief["seen"] = observation.array
    belief["seen"]["time"] = 0.0
    belief["seen"]["elapsed"] = max(observation.elapsed, 0.0)
    belief["time"] = observation.time
    belief["began"] = observation.time - observation.elapsed


@njit(forceinline=True)
def _believe(belief, observation, seen_time):
    """All of it."""
    belief.seen = observation
    belief.seen.time = seen_time
    belief.time = observation.time
    belief.guessed = belief.blind = 0


@njit(forceinline=True)
def _passed(known, command, observation, landed) -> float:
    """The time since the last cycle, as exact as it can be [s]."""
    passed = observation.time - known.time
    since = observation.elapsed - known.seen.elapsed
    if landed:
        since += command.step_duration
    exact = abs(since - passed) <= RESOLUTION * (abs(observation.time) + 1.0)
    return since if exact else passed


@njit
def look(gate, state, observation, next_state) -> bool:
    """Decide what to believe of an observation, into `next_state.belief`.

    Args:
        gate: a `GATE` record.
        state: of the last cycle, with its `belief` and `command`.
        observation: an `OBSERVATION` record, of whatever content.
        next_state: of this cycle; `belief.seen` is the observation to decide on.

    Returns:
        Whether the last command is to stand, see `hold`.
    """
    known, belief = state.belief, next_state.belief
    last = known.seen
    landed = observation.support_side != last.support_side
    passed = observation.time - known.time
    if (
        clock_fits(gate, known.time, known.began, observation, landed)
        and feet_fit(gate, gate.jump, last, state.command, observation)
        and pendulum_fits(gate, gate.jump, last, state.command.zmp, observation, passed)
        and is_up(gate, observation, observation.support_foot)
        and trunk_fits(gate, observation)
    ):
        _believe(
            belief, observation, last.time + _passed(known, state.command, observation, landed)
        )
        belief.began = known.began
        if landed:
            belief.began = observation.time - observation.elapsed
        return False
    _look_closely(gate, state, observation, belief)
    if known.blind != 0 or belief.guessed == 0 or belief.seen.support_side != last.support_side:
        return False
    # The last command stands where it was decided.
    for i in range(2):
        belief.seen.support_foot[i] = last.support_foot[i]
    belief.seen.support_yaw = last.support_yaw
    return True


@njit
def _is_possible(gate, observation) -> bool:
    """Whether there can be a robot like this, wherever it is; a DCM that is no number may be."""
    foot, dcm = observation.support_foot, observation.dcm
    for i in range(2):
        if not abs(foot[i]) <= FURTHEST_PLACE * gate.jump:
            return False
    if math.isfinite(dcm[0] + dcm[1]):
        return is_up(gate, observation, foot)
    return True


@njit
def _is_same_foot_renamed(gate, last, observation) -> bool:
    """Whether the foot that is believed to carry is said to be the other one, or none."""
    if observation.support_side == last.support_side:
        return False
    if observation.support_side != -last.support_side:
        return True
    near = True
    for i in range(2):
        near = near and is_near(observation.support_foot[i], last.support_foot[i], gate.jump)
    return near


@njit
def _goes_on(gate, known, command, observation, part) -> bool:
    """Whether a part that is not believed goes on from what was shown in the last cycle."""
    if known.blind == 0:
        return False
    before = known.shown
    passed = observation.time - before.time
    if part == CLOCK:
        since = observation.elapsed - before.elapsed
        return passed > 0.0 and passed <= gate.slack and abs(since - passed) <= 0.5 * gate.period
    # A sensor that has stopped shows the same value in every cycle.
    alive = passed > 0.0 or observation.elapsed > before.elapsed
    if not (alive and passed <= gate.slack and _is_possible(gate, observation)):
        return False
    jump = STRICT * gate.jump
    if part == FEET:
        if _is_same_foot_renamed(gate, known.seen, observation):
            return False
        same = observation.support_side == before.support_side
        fit = is_in_reach(gate, observation)
        return fit and same and feet_fit(gate, jump, before, command, observation)
    # Which ZMP acts there is not known; in one cycle it matters little.
    pivot, passed = before.support_foot, max(passed, 0.0)
    if not math.isfinite(pivot[0] + pivot[1]):
        pivot = before.dcm
    if not pendulum_fits(gate, jump, before, pivot, observation, passed):
        return False
    if known.blind * gate.period > STEPS_OF_DOUBT * gate.longest:
        return True
    for i in range(2):
        lead = observation.com_velocity[i] / gate.omega
        apart = observation.dcm[i] - observation.com[i] - lead
        if abs(apart) > APART * gate.jump + TOGETHER * abs(lead):
            return False
    return True


@njit
def _is_age_possible(gate, known, observation, feet) -> bool:
    """Whether the step under way can be as old as a clock says that has gone on for a while."""
    elapsed, expected = observation.elapsed, known.seen.elapsed + gate.period
    # A clock may have been set; a step that lasts too long has been seen to become so old.
    if is_near(elapsed, expected, gate.slack):
        return True
    if not 0.0 <= elapsed <= gate.longest:
        return False
    # Cycles may have been lost, or a touchdown not been seen. Else only feet that are seen know.
    same_step = is_near(observation.time - elapsed, known.began, gate.slack)
    unseen = elapsed < expected and is_near(observation.time, known.time, gate.slack)
    return feet or same_step or unseen


@njit
def _confirm(gate, state, observation, part, index, belief) -> bool:
    """Count for how long a part goes on; whether that is long enough."""
    known = state.belief
    goes_on = _goes_on(gate, known, state.command, observation, part)
    belief.streak[index] = known.streak[index] + 1 if goes_on else 0
    return belief.streak[index] >= gate.confirm


@njit
def _look_closely(gate, state, observation, belief):
    """Believe what can be believed, and predict the rest."""
    known = state.belief
    for k in range(3):
        belief.streak[k] = 0
    # Where one part cannot be true, the others are believed if they are what was to be expected.
    jump = STRICT * gate.jump
    clock, feet, passed = _look_at_step(gate, jump, state, observation, belief)
    pendulum, trunk = _look_at_motion(gate, jump, state, observation, passed, belief)
    guessed = (0 if clock else CLOCK) + (0 if feet else FEET)
    guessed += (0 if pendulum else PENDULUM) + (0 if trunk else TRUNK)
    belief.guessed = guessed
    belief.blind = known.blind + 1 if guessed != 0 else 0
    belief.shown = observation


@njit
def _look_at_step(gate, jump, state, observation, belief):
    """Clock and feet: they are judged together, since a touchdown changes both.

    Returns:
        Whether the clock is believed, whether the feet are, and the time since the last cycle [s].
    """
    known, command = state.belief, state.command
    last = known.seen
    feet = feet_fit(gate, jump, last, command, observation)
    landed = feet and observation.support_side != last.support_side
    clock = clock_fits(gate, known.time, known.began, observation, landed)
    if landed and not clock:
        # Only a touchdown that the clock knows of is believed at once.
        feet = landed = False
        clock = clock_fits(gate, known.time, known.began, observation, False)
    if not feet and _confirm(gate, state, observation, FEET, 1, belief):
        feet, landed = True, observation.support_side != last.support_side
        clock = clock_fits(gate, known.time, known.began, observation, landed)
    due = command.step_duration - last.elapsed
    if not feet and not clock and due <= 2.0 * gate.period:
        # The feet are not seen, but a landing was due and the clock has begun anew.
        clock = landed = clock_fits(gate, known.time, known.began, observation, True)
    confirmed = not clock and _confirm(gate, state, observation, CLOCK, 0, belief)
    confirmed = confirmed and _is_age_possible(gate, known, observation, feet)
    ends = due <= gate.period * (1.0 + ALMOST)
    if not clock and not confirmed and not feet:
        # Not while what is shown may turn out to be true: the next step's foot would land at once.
        landed = ends and known.guessed & FEET != 0 and belief.streak[1] == 0
    passed = gate.period
    if clock:
        passed = _passed(known, command, observation, landed)
    elif landed and ends:
        passed = max(due, 0.0)
    belief.seen = last
    _take_clock(known, observation, clock or confirmed, landed, passed, belief)
    if confirmed:
        belief.began = observation.time - observation.elapsed
    if feet:
        _take_feet(observation, belief.seen)
    else:
        _move_feet(command, landed, belief.seen)
    return clock or confirmed, feet, passed


@njit
def _look_at_motion(gate, jump, state, observation, passed, belief):
    """Pendulum and trunk, over the foot that is believed to carry.

    Returns:
        Whether the pendulum is believed, and whether the trunk is.
    """
    last, command, seen = state.belief.seen, state.command, belief.seen
    pendulum = pendulum_fits(gate, jump, last, command.zmp, observation, passed)
    pendulum = pendulum and is_up(gate, observation, seen.support_foot)
    pendulum = pendulum or _confirm(gate, state, observation, PENDULUM, 2, belief)
    pendulum = pendulum and is_up(gate, observation, seen.support_foot)
    trunk = trunk_fits(gate, observation)
    for i in range(2):
        if pendulum:
            seen.dcm[i], seen.com[i] = observation.dcm[i], observation.com[i]
            seen.com_velocity[i] = observation.com_velocity[i]
        else:
            _move_pendulum(gate, command, passed, i, seen)
        if trunk:
            seen.trunk_lean[i] = observation.trunk_lean[i]
            seen.trunk_lean_velocity[i] = observation.trunk_lean_velocity[i]
        elif gate.inertia > 0.0:
            seen.trunk_lean[i], seen.trunk_lean_velocity[i], _, _ = trunk_flow(
                seen.trunk_lean[i],
                seen.trunk_lean_velocity[i],
                command.hip_torque[i],
                gate.inertia,
                gate.max_lean,
                passed,
            )
    return pendulum, trunk


@njit
def _take_clock(known, observation, seen_clock, landed, passed, belief):
    """Write time, time since touchdown, and when that was."""
    last, seen = known.seen, belief.seen
    seen.time = last.time + passed
    belief.began = known.began
    if seen_clock:
        belief.time, seen.elapsed = observation.time, observation.elapsed
    else:
        belief.time = known.time + passed
        seen.elapsed = 0.0 if landed else last.elapsed + passed
    if landed:
        belief.began = belief.time - seen.elapsed


@njit
def _take_feet(observation, seen):
    for i in range(2):
        seen.support_foot[i] = observation.support_foot[i]
    for i in range(3):
        seen.swing_foot[i] = observation.swing_foot[i]
        seen.swing_foot_velocity[i] = observation.swing_foot_velocity[i]
    seen.support_yaw, seen.swing_yaw = observation.support_yaw, observation.swing_yaw
    seen.support_side = observation.support_side


@njit
def _move_feet(command, landed, seen):
    """The swing foot did as it was told; if it has landed, it carries."""
    if not landed:
        for i in range(3):
            seen.swing_foot[i] = command.swing_foot[i]
            seen.swing_foot_velocity[i] = command.swing_foot_velocity[i]
        seen.swing_yaw = command.swing_yaw
        return
    for i in range(2):
        seen.swing_foot[i] = seen.support_foot[i]
        seen.support_foot[i] = command.swing_foot[i]
    seen.swing_foot[2] = 0.0
    for i in range(3):
        seen.swing_foot_velocity[i] = 0.0
    seen.swing_yaw = seen.support_yaw
    seen.support_yaw = command.swing_yaw
    seen.support_side = -seen.support_side


@njit
def _move_pendulum(gate, command, passed, i, seen):
    """One axis of CoM and DCM, about the ZMP that was commanded; a hip torque moves that."""
    pivot = command.zmp[i] + command.hip_torque[i] / gate.weight
    seen.com[i], seen.com_velocity[i] = com_flow(
        seen.com[i], seen.com_velocity[i], pivot, gate.omega, passed
    )
    seen.dcm[i] = pivot + (seen.dcm[i] - pivot) * math.exp(gate.omega * passed)


@njit(forceinline=True)
def hold(state, next_state):
    """Repeat the last command, with the status HELD."""
    next_state.plan = state.plan
    next_state.command = state.command
    next_state.command.status = _HELD


@njit(forceinline=True)
def mark(next_state):
    """Say of a command that some of what it was decided on was guessed."""
    if next_state.belief.guessed != 0:
        # Nothing that was seen asks for a ZMP that the sole does not have.
        next_state.command.status = (next_state.command.status & ~_ZMP_AT_EDGE) | _HELD

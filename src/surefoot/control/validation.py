"""Validate an observation, and predict what cannot be true of it.

An observation has four parts: clock, feet, pendulum and trunk. Each is compared with the last state
that was validated and with what the robot can do in between. A part that cannot be true is replaced
by what the model predicts from there, with the commands that were carried out; the command then
says HELD. In the first such cycle the last command simply stands; after that the method decides on
the prediction, so that a robot that nothing pushes walks on without any sensor.

A part that was rejected and is consistent from cycle to cycle is accepted after a few of them,
since it may be true: a blow, another origin of the world, a clock that was set. Only a robot that
cannot exist is never accepted. All bounds are lengths and times of the robot.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.control.plausibility import (
    SAME_TIME,
    clock_fits,
    feet_fit,
    is_in_reach,
    is_near,
    is_upright,
    pendulum_fits,
    trunk_fits,
)
from surefoot.dcm.pendulum import com_flow, trunk_flow
from surefoot.interface import Observation, Status
from surefoot.record import Array, Record, field


class Validated(Record):
    """The observation that is decided on, and what was rejected of those that were measured."""

    observation: Observation = field(
        "", "decided on; its `time` counts from the start of the controller, exact for any epoch"
    )
    rejected: Observation = field("", "as measured in the last cycle, if a part was rejected")
    time: float = field("s", "of the last cycle with a valid clock, in the epoch of the sensors")
    touchdown: float = field("s", "when the last one was, likewise")
    consistent: Array = field(
        "", "cycles for which clock, feet and pendulum have been rejected and consistent",
        shape=3, kind=int,
    )  # fmt: skip
    predicted: int = field("", "the parts that are predicted now, as bits")
    cycles_predicted: int = field("", "for how many cycles some part has been predicted")


CLOCK, FEET, PENDULUM, TRUNK = 1, 2, 4, 8
"""Parts of an observation, as bits of `Validated.predicted`."""

STRICT = 0.125
"""Part of that jump which is left to an observation of which some part cannot be true."""

VELOCITY_MISMATCH, DCM_MISMATCH, STEPS_OF_MISMATCH = 0.5, 0.25, 4.0
"""A DCM may differ from com + com_velocity / omega by this part of the latter, if it was made with
the natural frequency of another pendulum, and by this part of `jump`. One that differs more is
accepted only if it has gone on for so many of the longest steps: then they never did fit."""

RESOLUTION = 1e-15
"""A double resolves a time to this part of it; within that, the clock of the step is the better."""

MAX_PLACE = 1e9
"""A double resolves a place this many jumps from the origin to 1e-7 of one; one further away that
was rejected stays so."""

_HELD, _ZMP_AT_EDGE = int(Status.HELD), int(Status.ZMP_AT_EDGE)


def accept_first(observation: Observation, state: NDArray[np.void]) -> None:
    """Accept the observation that a walk begins with; it has been checked."""
    validated = state["validated"]
    validated["observation"] = observation.array
    validated["observation"]["time"] = 0.0
    validated["observation"]["elapsed"] = max(observation.elapsed, 0.0)
    validated["time"] = observation.time
    validated["touchdown"] = observation.time - observation.elapsed


@njit(forceinline=True)
def _accept(validated, observation, own_time):
    """All of it."""
    validated.observation = observation
    validated.observation.time = own_time
    validated.time = observation.time
    validated.predicted = validated.cycles_predicted = 0


@njit(forceinline=True)
def _passed(known, command, observation, landed) -> float:
    """The time since the last cycle, as exact as it can be [s]."""
    passed = observation.time - known.time
    since = observation.elapsed - known.observation.elapsed
    if landed:
        since += command.step_duration
    exact = abs(since - passed) <= RESOLUTION * (abs(observation.time) + 1.0)
    return since if exact else passed


@njit
def validate(gate, state, observation, next_state) -> bool:
    """Decide what to accept of an observation, into `next_state.validated`.

    Args:
        gate: a `Gate` record.
        state: of the last cycle, with its `validated` and `command`.
        observation: an `Observation` record, of whatever content.
        next_state: of this cycle; `validated.observation` is the one to decide on.

    Returns:
        Whether there is something to decide; if not, plan and command are those of the last cycle,
        with the status HELD.
    """
    known, validated = state.validated, next_state.validated
    last = known.observation
    landed = observation.support_side != last.support_side
    passed = observation.time - known.time
    if (
        clock_fits(gate, known.time, known.touchdown, observation, landed)
        and feet_fit(gate, gate.jump, last, state.command, observation)
        and pendulum_fits(gate, gate.jump, last, state.command.zmp, observation, passed)
        and is_upright(gate, observation, observation.support_foot)
        and trunk_fits(gate, observation)
    ):
        _accept(
            validated, observation, last.time + _passed(known, state.command, observation, landed)
        )
        validated.touchdown = known.touchdown
        if landed:
            validated.touchdown = observation.time - observation.elapsed
        return True
    _validate_parts(gate, state, observation, validated)
    now = validated.observation
    first = known.cycles_predicted == 0 and validated.predicted != 0
    if not first or now.support_side != last.support_side:
        return True
    # The last command stands where it was decided.
    for i in range(2):
        now.support_foot[i] = last.support_foot[i]
    now.support_yaw = last.support_yaw
    next_state.plan = state.plan
    next_state.command = state.command
    next_state.command.status = _HELD
    return False


@njit
def _is_possible(gate, observation) -> bool:
    """Whether there can be a robot like this, wherever it is; a DCM that is no number may be."""
    foot, dcm = observation.support_foot, observation.dcm
    for i in range(2):
        if not abs(foot[i]) <= MAX_PLACE * gate.jump:
            return False
    if math.isfinite(dcm[0] + dcm[1]):
        return is_upright(gate, observation, foot)
    return True


@njit
def _is_same_foot_renamed(gate, last, observation) -> bool:
    """Whether the foot that carries is said to be the other one, or none."""
    if observation.support_side == last.support_side:
        return False
    if observation.support_side != -last.support_side:
        return True
    near = True
    for i in range(2):
        near = near and is_near(observation.support_foot[i], last.support_foot[i], gate.jump)
    return near


@njit
def _is_consistent(gate, known, command, observation, part) -> bool:
    """Whether a part that is rejected goes on from what was measured in the last cycle."""
    if known.cycles_predicted == 0:
        return False
    before = known.rejected
    passed = observation.time - before.time
    if part == CLOCK:
        since = observation.elapsed - before.elapsed
        return passed > 0.0 and passed <= gate.slack and abs(since - passed) <= 0.5 * gate.period
    # A sensor that has stopped gives the same value in every cycle.
    alive = passed > 0.0 or observation.elapsed > before.elapsed
    if not (alive and passed <= gate.slack and _is_possible(gate, observation)):
        return False
    jump = STRICT * gate.jump
    if part == FEET:
        if _is_same_foot_renamed(gate, known.observation, observation):
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
    if known.cycles_predicted * gate.period > STEPS_OF_MISMATCH * gate.longest:
        return True
    for i in range(2):
        lead = observation.com_velocity[i] / gate.omega
        mismatch = abs(observation.dcm[i] - observation.com[i] - lead)
        if mismatch > DCM_MISMATCH * gate.jump + VELOCITY_MISMATCH * abs(lead):
            return False
    return True


@njit
def _is_age_possible(gate, known, observation, feet) -> bool:
    """Whether the step under way can be as old as a clock says that has gone on for a while."""
    elapsed, expected = observation.elapsed, known.observation.elapsed + gate.period
    # A clock may have been set; a step that lasts too long was measured as it became so old.
    if is_near(elapsed, expected, gate.slack):
        return True
    if not 0.0 <= elapsed <= gate.longest:
        return False
    # Cycles may have been lost, or a touchdown not measured. Else only valid feet can tell.
    same_step = is_near(observation.time - elapsed, known.touchdown, gate.slack)
    unseen = elapsed < expected and is_near(observation.time, known.time, gate.slack)
    return feet or same_step or unseen


@njit
def _is_confirmed(gate, state, observation, part, index, validated) -> bool:
    """Count for how long a part is consistent; whether that is long enough."""
    known = state.validated
    consistent = _is_consistent(gate, known, state.command, observation, part)
    validated.consistent[index] = known.consistent[index] + 1 if consistent else 0
    return validated.consistent[index] >= gate.confirm


@njit
def _validate_parts(gate, state, observation, validated):
    """Accept the parts that can be true, and predict the rest."""
    known = state.validated
    for k in range(3):
        validated.consistent[k] = 0
    # Where one part cannot be true, the others are accepted if they are what was to be expected.
    jump = STRICT * gate.jump
    clock, feet, passed = _validate_step(gate, jump, state, observation, validated)
    pendulum, trunk = _validate_motion(gate, jump, state, observation, passed, validated)
    predicted = (0 if clock else CLOCK) + (0 if feet else FEET)
    predicted += (0 if pendulum else PENDULUM) + (0 if trunk else TRUNK)
    validated.predicted = predicted
    validated.cycles_predicted = known.cycles_predicted + 1 if predicted != 0 else 0
    validated.rejected = observation


@njit
def _validate_step(gate, jump, state, observation, validated):
    """Clock and feet: they are judged together, since a touchdown changes both.

    Returns:
        Whether the clock is accepted, whether the feet are, and the time since the last cycle [s].
    """
    known, command = state.validated, state.command
    last = known.observation
    feet = feet_fit(gate, jump, last, command, observation)
    landed = feet and observation.support_side != last.support_side
    clock = clock_fits(gate, known.time, known.touchdown, observation, landed)
    if landed and not clock:
        # Only a touchdown that the clock knows of is accepted at once.
        feet = landed = False
        clock = clock_fits(gate, known.time, known.touchdown, observation, False)
    if not feet and _is_confirmed(gate, state, observation, FEET, 1, validated):
        feet, landed = True, observation.support_side != last.support_side
        clock = clock_fits(gate, known.time, known.touchdown, observation, landed)
    due = command.step_duration - last.elapsed
    if not feet and not clock and due <= 2.0 * gate.period:
        # The feet are not measured, but a landing was due and the clock has begun anew.
        clock = landed = clock_fits(gate, known.time, known.touchdown, observation, True)
    confirmed = not clock and _is_confirmed(gate, state, observation, CLOCK, 0, validated)
    confirmed = confirmed and _is_age_possible(gate, known, observation, feet)
    ends = due <= gate.period * (1.0 + SAME_TIME)
    if not clock and not confirmed and not feet:
        # Not while what is rejected may turn out to be true: the next foot would land at once.
        landed = ends and known.predicted & FEET != 0 and validated.consistent[1] == 0
    passed = gate.period
    if clock:
        passed = _passed(known, command, observation, landed)
    elif landed and ends:
        passed = max(due, 0.0)
    validated.observation = last
    _set_clock(known, observation, clock or confirmed, landed, passed, validated)
    if confirmed:
        validated.touchdown = observation.time - observation.elapsed
    if feet:
        _accept_feet(observation, validated.observation)
    else:
        _predict_feet(command, landed, validated.observation)
    return clock or confirmed, feet, passed


@njit
def _validate_motion(gate, jump, state, observation, passed, validated):
    """Pendulum and trunk, over the foot that carries.

    Returns:
        Whether the pendulum is accepted, and whether the trunk is.
    """
    last, command, now = state.validated.observation, state.command, validated.observation
    pendulum = pendulum_fits(gate, jump, last, command.zmp, observation, passed)
    pendulum = pendulum and is_upright(gate, observation, now.support_foot)
    pendulum = pendulum or _is_confirmed(gate, state, observation, PENDULUM, 2, validated)
    pendulum = pendulum and is_upright(gate, observation, now.support_foot)
    trunk = trunk_fits(gate, observation)
    for i in range(2):
        if pendulum:
            now.dcm[i], now.com[i] = observation.dcm[i], observation.com[i]
            now.com_velocity[i] = observation.com_velocity[i]
        else:
            _predict_pendulum(gate, command, passed, i, now)
        if trunk:
            now.trunk_lean[i] = observation.trunk_lean[i]
            now.trunk_lean_velocity[i] = observation.trunk_lean_velocity[i]
        elif gate.inertia > 0.0:
            now.trunk_lean[i], now.trunk_lean_velocity[i], _, _ = trunk_flow(
                now.trunk_lean[i],
                now.trunk_lean_velocity[i],
                command.hip_torque[i],
                gate.inertia,
                gate.max_lean,
                passed,
            )
    return pendulum, trunk


@njit
def _set_clock(known, observation, valid, landed, passed, validated):
    """Write time, time since touchdown, and when that was."""
    last, now = known.observation, validated.observation
    now.time = last.time + passed
    validated.touchdown = known.touchdown
    if valid:
        validated.time, now.elapsed = observation.time, observation.elapsed
    else:
        validated.time = known.time + passed
        now.elapsed = 0.0 if landed else last.elapsed + passed
    if landed:
        validated.touchdown = validated.time - now.elapsed


@njit
def _accept_feet(observation, now):
    for i in range(2):
        now.support_foot[i] = observation.support_foot[i]
    for i in range(3):
        now.swing_foot[i] = observation.swing_foot[i]
        now.swing_foot_velocity[i] = observation.swing_foot_velocity[i]
    now.support_yaw, now.swing_yaw = observation.support_yaw, observation.swing_yaw
    now.support_side = observation.support_side


@njit
def _predict_feet(command, landed, now):
    """The swing foot did what was commanded; if it has landed, it carries."""
    if not landed:
        for i in range(3):
            now.swing_foot[i] = command.swing_foot[i]
            now.swing_foot_velocity[i] = command.swing_foot_velocity[i]
        now.swing_yaw = command.swing_yaw
        return
    for i in range(2):
        now.swing_foot[i] = now.support_foot[i]
        now.support_foot[i] = command.swing_foot[i]
    now.swing_foot[2] = 0.0
    for i in range(3):
        now.swing_foot_velocity[i] = 0.0
    now.swing_yaw = now.support_yaw
    now.support_yaw = command.swing_yaw
    now.support_side = -now.support_side


@njit
def _predict_pendulum(gate, command, passed, i, now):
    """One axis of CoM and DCM, about the ZMP that was commanded; a hip torque moves that."""
    pivot = command.zmp[i] + command.hip_torque[i] / gate.weight
    now.com[i], now.com_velocity[i] = com_flow(
        now.com[i], now.com_velocity[i], pivot, gate.omega, passed
    )
    now.dcm[i] = pivot + (now.dcm[i] - pivot) * math.exp(gate.omega * passed)


@njit(forceinline=True)
def flag_predicted(next_state):
    """Say of a command that some of what it was decided on was predicted."""
    if next_state.validated.predicted != 0:
        # No measurement asks for a ZMP outside the sole.
        next_state.command.status = (next_state.command.status & ~_ZMP_AT_EDGE) | _HELD

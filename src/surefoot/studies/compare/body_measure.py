"""What is measured on a body: the smallest push that it fails on, what binds in it, and a walk.

The multipliers of the quadratic program name the constraints that shape a cycle. One that is active
without a push too is usual, so every share is given beside that of the same walk unpushed.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.dcm.pushes import DIRECTIONS, Push
from surefoot.errors import StudyError
from surefoot.interface import Status
from surefoot.robot.feet import FEET
from surefoot.rollout.measures import measure_body
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.studies.engine.body_recovery import SPAN, used_after
from surefoot.studies.engine.pushed_body import (
    BEFORE_PUSH,
    NO_STEP,
    STUCK,
    PushedBody,
    mechanism_of,
)
from surefoot.studies.engine.table import Row, select
from surefoot.worlds.body.controller import BodyControl
from surefoot.worlds.body.inverse_dynamics import InverseDynamics
from surefoot.worlds.body.plant import Surroundings
from surefoot.worlds.body.sensors import BodyNoise
from surefoot.worlds.body.world import BodyWorld, simulate_body

if TYPE_CHECKING:
    from surefoot.studies.compare.body_question import BodyPushes

ACTIVE = 1e-6
"""A multiplier that is larger belongs to an active constraint, in the units of the program."""

GROUND_NAMES = (
    "friction", "friction", "friction", "friction", "sole's side", "sole's side",
    "sole's toe or heel", "sole's toe or heel", "yaw friction", "yaw friction",
)  # fmt: skip
"""Of the inequalities on a wrench, in the order of `worlds.body.tasks.ground_rows`."""

STATUS_WORDS = {
    Status.ZMP_AT_EDGE: "controller: ZMP at its edge",
    Status.UNREACHABLE: "controller: leg too slow",
    Status.OFFSET_VIOLATED: "controller: out of reach",
    Status.NO_TIME_LEFT: "controller: no time left",
}
"""Words for what a controller says of its own decision."""


def measure_push(walk: PushedBody, direction: str, impulses: Sequence[float]) -> Row:
    """The smallest push that the robot does not survive.

    Args:
        walk: that is pushed.
        direction: one of `dcm.pushes.DIRECTIONS`.
        impulses: tried in this order, from nothing upwards [N s].

    Returns:
        `impulse` (smallest failing, inf if none is) and `scanned` [N s], `delta_v` [m/s], of the
        fall `cause`, `words` and `fall_after` the push began [s], and `seconds` that it took.
    """
    before = time.perf_counter()
    start = walk.start
    impulse, scanned, cause, words, after = np.inf, 0.0, "", "", 0.0
    if not start.arrived:
        impulse, cause, words = 0.0, BEFORE_PUSH, "it does not walk that far without a push"
    else:
        for scanned in impulses:
            push = walk.push(direction, scanned)
            end = walk.pushed(push)
            if not end.survived:
                impulse, after = scanned, end.time - start.time
                cause, words = _cause_of_push(walk, push)
                break
    return {
        "impulse": float(impulse),
        "delta_v": float(impulse) / mechanism_of(walk.robot).mass,
        "scanned": scanned,
        "cause": cause,
        "words": words,
        "fall_after": after,
        "seconds": time.perf_counter() - before,
    }


def _cause_of_push(walk: PushedBody, push: Push) -> tuple[str, str]:
    """Why it fell: the same push once more, with everything recorded."""
    fall = walk.rollout(push)[0].body_fall
    if fall is None:
        return NO_STEP, f"it stood on one foot for {STUCK:g} s"
    return fall.cause.value, fall.sentence


def measure_walk(
    control: BodyControl,
    duration: float,
    surroundings: Surroundings,
    noise: BodyNoise,
) -> Row:
    """How well a body walks on what its sensors measure.

    Args:
        control: walks it.
        duration: of the walk [s].
        surroundings: floor, bumps, payload, masses.
        noise: of the sensors.

    Returns:
        Whether it `walked` to the end and for how long (`time` [s]), and of a fall `cause` and
        `words`; root mean squares while walking of `dcm_error`, DCM against its plan relative to
        the standing foot, and `estimate_error`, estimated DCM against the true one, likewise [m];
        `drift` of the feet to the left of the course [m] and `heading` of the base away from it
        [rad] in the end, `speed` held [m/s]; `seconds` that it took. NaN is what there is not.
    """
    before = time.perf_counter()
    rollout = simulate_body(control, duration, surroundings=surroundings, noise=noise)
    trace = rollout.body
    if trace is None:
        raise StudyError("a walk of a body", "one without a trace", "report this as a bug")
    measures, (cause, words) = measure_body(rollout, trace), _cause_of_walk(rollout, trace)
    return {
        "walked": not cause,
        "time": float(rollout.time[-1]),
        "cause": cause,
        "words": words,
        "dcm_error": tracking_error(rollout, trace),
        "estimate_error": measures.estimate.get("dcm", math.nan),
        "drift": math.nan if measures.lateral_drift is None else measures.lateral_drift,
        "heading": math.nan if measures.heading_error is None else measures.heading_error,
        "speed": math.nan if measures.speed is None else measures.speed[0],
        "seconds": time.perf_counter() - before,
    }


def tracking_error(rollout: Rollout, trace: BodyTrace) -> float:
    """Root mean square of the true DCM against its plan, both from the standing foot [m].

    The plan is relative to the estimated place of the foot: an error of that place, which no
    controller measures, is left out. NaN if it never walked.
    """
    walking = trace.walking
    if not walking.any():
        return math.nan
    away = rollout.dcm - rollout.support_foot
    planned = rollout.dcm_plan - rollout.seen["support_foot"]
    error = (away - planned)[walking]
    return float(np.sqrt((error**2).sum(axis=1).mean()))


def _cause_of_walk(rollout: Rollout, trace: BodyTrace) -> tuple[str, str]:
    """Why it did not walk to the end; empty if it did."""
    fall = rollout.body_fall
    if fall is not None:
        return fall.cause.value, fall.sentence
    if not trace.walking[-1] or rollout.observations["elapsed"][-1] > STUCK:
        return NO_STEP, "it stood instead of walking"
    return "", ""


def explain(walk: PushedBody, direction: str, impulse: float) -> Row:
    """Push, and see what binds.

    Args:
        walk: that is pushed; the robot has to arrive at the push.
        direction: one of `dcm.pushes.DIRECTIONS`.
        impulse: of the push [N s].

    Returns:
        Whether the robot `survived`, and the `cause` of its fall in a sentence, empty if there was
        none. `bindings`: limits that were active more often than without the push, most of all
        first, each with its `name` (legs are those of the step in which it was active), `share` of
        the cycles after the push began and `usual` share without it [-]. `used`: by name, how much
        was used after the push began, see `used_after`.
    """
    shares, rollout, survived = _watched(walk, direction, impulse)
    usual, _, _ = _watched(walk, direction, 0.0)
    bindings = [
        {"name": name, "share": share, "usual": usual.get(name, 0.0)}
        for name, share in shares.items()
        if share > usual.get(name, 0.0)
    ]
    bindings.sort(key=lambda one: (one["usual"] - one["share"], one["name"]))
    fall = rollout.body_fall
    return {
        "survived": survived,
        "cause": "" if fall is None else fall.sentence,
        "bindings": bindings,
        "used": used_after(rollout, walk.start.time),
    }


def _watched(
    walk: PushedBody, direction: str, impulse: float
) -> tuple[dict[str, float], Rollout, bool]:
    """Shares of the cycles in which each limit was active; the walk; whether it continued."""
    begin = walk.start.time
    counts: Counter[str] = Counter()
    cycles = 0

    def watch(world: BodyWorld) -> None:
        nonlocal cycles
        if world.time - begin < SPAN:
            cycles += 1
            counts.update(active_limits(world))

    rollout, end = walk.rollout(walk.push(direction, impulse), watch)
    return {name: n / max(cycles, 1) for name, n in counts.items()}, rollout, end.survived


def active_limits(world: BodyWorld) -> set[str]:
    """The limits that shaped this cycle, of the program and of the controller.

    Args:
        world: whose control has just decided.
    """
    support, status = int(world.state.walk["support"][0]), int(world.state.command.status)
    found = {words for flag, words in STATUS_WORDS.items() if status & flag}
    control = world.control
    if not isinstance(control, BodyControl) or not isinstance(control.mapping, InverseDynamics):
        return found
    multibody, mapping = control.multibody, control.mapping
    multipliers, joints = mapping.answer().multipliers, mapping.joint_limits
    if not len(multipliers):
        return found
    nv, motors = multibody.model.nv, len(joints)
    # Bounds of 6 unknowns and 10 rows more for each foot that stands.
    feet = (len(multipliers) - 2 * nv) // 16
    active = np.abs(multipliers) > ACTIVE
    unknowns = nv + 6 * feet
    torques = unknowns + nv - motors
    for number, name in enumerate(multibody.joint_names):
        leg = name.replace(FEET[support], "stance").replace(FEET[1 - support], "swing")
        if active[joints[number]["dof"]]:
            sign = math.copysign(1.0, multipliers[joints[number]["dof"]])
            found.add(f"{_stop(mapping, joints[number], control, sign)} of {leg}")
        if active[torques + number]:
            found.add(f"torque of {leg}")
    ground = active[torques + motors :]
    found.update(name for name, on in zip(GROUND_NAMES * feet, ground, strict=True) if on)
    if active[nv:unknowns].any():
        found.add("force on the sole")
    return found


def _stop(mapping: InverseDynamics, joint: Any, control: BodyControl, sign: float) -> str:
    """Whether a joint is held back by its speed or by the end of its range."""
    stiffness = mapping.stiffness[0]
    angle = control.mechanics.position[joint["position"]]
    rate = control.mechanics.velocity[joint["dof"]]
    end = joint["high"] if sign > 0.0 else joint["low"]
    stop = stiffness["joint_limit"] * (end - angle)
    stop -= 2.0 * math.sqrt(stiffness["joint_limit"]) * rate
    fast = stiffness["joint_speed"] * (sign * joint["speed"] - rate)
    return "end" if sign * stop < sign * fast else "speed"


def explain_worst(
    study: BodyPushes, rows: Sequence[Row], report: Callable[[int, int], None] | None = None
) -> list[dict[str, Any]]:
    """What bound in the push that each method fails on first, direction by direction.

    Args:
        study: what was asked.
        rows: of its table.
        report: called with the number of pushes that are explained, and that of all.

    Returns:
        For each method and direction that a push ended, its `cell` and `impulse` [N s], what
        `explain` returns, and the name of its `robot`.
    """
    explained, kinds = [], list(product(study.methods, DIRECTIONS))
    for done, (key, direction) in enumerate(kinds):
        if report is not None:
            report(done, len(kinds))
        own = select(rows, method=key, direction=direction)
        worst = min(own, key=lambda row: row["impulse"], default=None)
        if worst is None or worst["cause"] == BEFORE_PUSH or math.isinf(worst["impulse"]):
            continue
        cell, impulse = study.cell(worst), worst["impulse"]
        found = explain(study.walk(cell), direction, impulse)
        explained.append(
            {"cell": asdict(cell), "impulse": impulse, **found, "robot": study.robot.name}
        )
    if report is not None:
        report(len(kinds), len(kinds))
    return explained

"""What binds while a robot recovers from a push: which limits are active, and how much is used.

The multipliers of the quadratic program name the constraints that shape a cycle. One that is active
without a push too is a habit, so every share is told beside that of the same walk unpushed.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np

from surefoot.interface import Status
from surefoot.robot.multibody import SIDES
from surefoot.robot.own_units import OwnUnits
from surefoot.rollout.fall_signs import OFF_TARGET
from surefoot.rollout.rollout import Rollout
from surefoot.studies.compare.body_protocol import DIRECTIONS, BodyCell, BodyProtocol, push_of
from surefoot.studies.compare.body_push import BEFORE_PUSH, moment_of, pushed_rollout, survived
from surefoot.worlds.body.controller import BodyControl, BodyState
from surefoot.worlds.body.inverse_dynamics import InverseDynamics

SPAN = 1.0
"""After the push began, in which limits are looked for: what comes later are consequences [s]."""

ACTIVE = 1e-6
"""A multiplier that is larger belongs to an active constraint, in the units of the program."""

GROUND_NAMES = (
    "friction", "friction", "friction", "friction", "sole's side", "sole's side",
    "sole's toe or heel", "sole's toe or heel", "yaw friction", "yaw friction",
)  # fmt: skip
"""Of the inequalities on a wrench, in the order of `worlds.body.tasks.ground_rows`."""

TOLD = {
    Status.ZMP_AT_EDGE: "controller: ZMP at its edge",
    Status.UNREACHABLE: "controller: leg too slow",
    Status.OFFSET_VIOLATED: "controller: out of reach",
    Status.NO_TIME_LEFT: "controller: no time left",
}
"""Words for what a controller says of its own decision."""


@dataclass(frozen=True)
class Binding:
    """A limit that was active.

    Attributes:
        name: of the limit; legs are those of the step in which it was active.
        share: of the cycles after the push began [-].
        usual: the same of the walk without the push [-].
    """

    name: str
    share: float
    usual: float


@dataclass(frozen=True)
class Explanation:
    """What bound in one push.

    Attributes:
        cell: the situation.
        impulse: of the push [N s].
        survived: whether the robot walked on.
        cause: of the fall, in a sentence; empty if there was none.
        bindings: limits that were active more often than usual, most of all first.
        used: by name, how much was used after the push began: parts of limits [-], errors [m],
            times [s], angles [rad].
    """

    cell: BodyCell
    impulse: float
    survived: bool
    cause: str
    bindings: tuple[Binding, ...]
    used: dict[str, float]


def explain(protocol: BodyProtocol, cell: BodyCell, impulse: float) -> Explanation:
    """Push, and see what binds.

    Args:
        protocol: the questions.
        cell: the situation; the robot has to come to it without a push.
        impulse: of the push [N s].
    """
    shares, rollout, alive = _watched(protocol, cell, impulse)
    usual, _, _ = _watched(protocol, cell, 0.0)
    bindings = [
        Binding(name, share, usual.get(name, 0.0))
        for name, share in shares.items()
        if share > usual.get(name, 0.0)
    ]
    bindings.sort(key=lambda one: one.usual - one.share)
    start = moment_of(protocol, cell.method, cell.foot, cell.phase).time
    fall = rollout.body_fall
    return Explanation(
        cell, impulse, alive, "" if fall is None else fall.sentence, tuple(bindings),
        used_after(rollout, start),
    )  # fmt: skip


def _watched(
    protocol: BodyProtocol, cell: BodyCell, impulse: float
) -> tuple[dict[str, float], Rollout, bool]:
    """Shares of the cycles in which each limit was active; the walk; whether it went on."""
    moment = moment_of(protocol, cell.method, cell.foot, cell.phase)
    counts: Counter[str] = Counter()
    cycles = 0

    def watch(world: Any) -> None:
        nonlocal cycles
        if world.time - moment.time < SPAN:
            cycles += 1
            counts.update(active_limits(world.control, world.state))

    push = push_of(cell, moment.time, impulse)
    rollout, end = pushed_rollout(moment, push, watch)
    return {name: n / max(cycles, 1) for name, n in counts.items()}, rollout, survived(end)


def active_limits(control: BodyControl, state: BodyState) -> set[str]:
    """The limits that shaped this cycle, of the program and of the controller.

    Args:
        control: that has just decided.
        state: what it left.
    """
    support = int(state.walk["support"][0])
    told = int(state.command.status)
    found = {words for flag, words in TOLD.items() if told & flag}
    multibody, mapping = control.multibody, control.mapping
    if not isinstance(mapping, InverseDynamics):
        return found
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
        leg = name.replace(SIDES[support], "stance").replace(SIDES[1 - support], "swing")
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


def used_after(rollout: Rollout, start: float) -> dict[str, float]:
    """How much of what there is was used from a time on, for `SPAN`.

    Args:
        rollout: of a body.
        start: when the push began [s].
    """
    trace = rollout.body
    if trace is None:
        return {}
    time = rollout.time
    rows = (time >= start) & (time < start + SPAN)
    force = trace.sole_force[rows]
    loaded = force[..., 2] > 0.2 * trace.robot.mass * trace.robot.gravity
    side = np.hypot(force[..., 0], force[..., 1])
    grip = np.where(loaded, side / np.where(loaded, force[..., 2], 1.0), 0.0)
    speed = np.abs(trace.joint_velocities[rows]) / trace.speed_limit
    torque = trace.torque_part[rows]
    knees = np.abs(trace.joint_angles[rows][:, list(trace.knees)])
    errors, late = _landings(rollout, start)
    far = OFF_TARGET * OwnUnits.of(trace.robot).length
    return {
        "friction used": float(grip.max()),
        "largest torque over its limit": float(torque.max()),
        "largest joint speed over its limit": float(speed.max()),
        "least knee bend": float(knees.min()),
        "largest landing error": max(errors, default=0.0),
        "landings off target": float(sum(one > far for one in errors)),
        "latest landing": max(late, default=0.0),
        "largest tilt of the trunk": float(np.abs(trace.base_turn[rows, :2]).max()),
    }


def _landings(rollout: Rollout, start: float) -> tuple[list[float], list[float]]:
    """Distances from the target and delays of the landings from a time on [m, s]."""
    trace, time = rollout.body, rollout.time
    if trace is None:
        return [], []
    errors, late = [], []
    for row in np.flatnonzero(np.diff(trace.steps)) + 1:
        if not (start <= time[row] < start + SPAN and trace.walking[row - 1]):
            continue
        command, swing = rollout.commands[row - 1], 1 - int(trace.support[row - 1])
        away = trace.sole_position[row, swing, :2] - command["step_location"]
        errors.append(float(np.hypot(*away)))
        elapsed = float(rollout.observations["elapsed"][row - 1])
        late.append(elapsed - float(command["step_duration"]))
    return errors, late


def explain_worst(
    protocol: BodyProtocol,
    rows: Sequence[dict[str, Any]],
    report: Callable[[int, int], None] | None = None,
) -> list[dict[str, Any]]:
    """What bound in the push that each method fails on first, direction by direction.

    Args:
        protocol: the questions.
        rows: of its table.
        report: called with the number of pushes that are explained, and that of all.

    Returns:
        An `Explanation` as plain data for each method and direction that a push ended, with the
        name of its `robot`.
    """
    told, kinds = [], list(product(protocol.methods, DIRECTIONS))
    for done, (key, direction) in enumerate(kinds):
        if report is not None:
            report(done, len(kinds))
        own = [r for r in rows if r["method"] == key and r["direction"] == direction]
        worst = min(own, key=lambda row: row["impulse"], default=None)
        if worst is None or worst["cause"] == BEFORE_PUSH or math.isinf(worst["impulse"]):
            continue
        cell = BodyCell(key, direction, worst["phase"], worst["foot"])
        found = asdict(explain(protocol, cell, worst["impulse"]))
        told.append(found | {"robot": protocol.robot.name})
    if report is not None:
        report(len(kinds), len(kinds))
    return told

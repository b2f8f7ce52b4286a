"""How well a body walked, in numbers: speed and place held, knees, feet, motors, estimate, time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.geometry import rotated_by, wrapped
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace

Array = NDArray[Any]

WARM_UP = 50
"""Cycles whose time is not measured."""

MID_SWING = (0.3, 0.7)
"""Part of a step in which a foot is to be clear of the ground [-]."""

LANDING_FORCE = 0.03
"""On a sole that swings, above which it touches the ground, of the weight [-]."""


@dataclass(frozen=True)
class BodyMeasures:
    """How well a body walked.

    Attributes:
        speed: mean velocity in its own heading while the last walking command was held, from
            14 / omega after it, the first step and the last push on (forward, to the left); None if
            there was no time [m/s].
        commanded: what it should have been [m/s].
        lateral_drift: of the middle of the feet to the left of the course, when it last walked [m].
        heading_error: of the base, likewise; mean of the last second that it walked [rad].
        torque_part: largest part of its limit that each motor gave, by joint; those without a limit
            are left out [-].
        knees: least and largest bend of each knee while walking, left and right [rad].
        clearance: lowest corner of the sole in the middle of a swing: least, and median of all
            steps; None before a step is done [m].
        scuffs: steps in which the sole touched the ground in the middle of its swing.
        estimate: root mean squares of the errors of what the controller was given while walking, by
            name; empty if it was the truth [m, m/s, rad].
        cycle_time: median and 99 % of estimate and decision together, wall clock [s].
        real_time_factor: time walked over time computed, physics included [-].
    """

    speed: tuple[float, float] | None
    commanded: tuple[float, float]
    lateral_drift: float | None
    heading_error: float | None
    torque_part: dict[str, float]
    knees: tuple[tuple[float, float], tuple[float, float]] | None
    clearance: tuple[float, float] | None
    scuffs: int
    estimate: dict[str, float]
    cycle_time: tuple[float, float]
    real_time_factor: float


def measure_body(rollout: Rollout, trace: BodyTrace) -> BodyMeasures:
    """The measures of a walk.

    Args:
        rollout: the walk.
        trace: its `body`.
    """
    walking = trace.walking
    speed, commanded = _speed(rollout, trace)
    drift, heading = _off_course(rollout, trace)
    cycle = rollout.decision_time + trace.sense_time
    # The first cycles are slower: caches are cold, and kernels may not have been compiled yet.
    warm = slice(min(WARM_UP, len(cycle) - 1), None)
    busy = float((cycle + trace.physics_time)[warm].sum())
    limited = np.isfinite(trace.torque_limit)
    most = trace.torque_part.max(axis=0)
    knees = trace.joint_angles[walking][:, list(trace.knees)]
    clearance, scuffs = _swings(rollout, trace)
    return BodyMeasures(
        speed=speed,
        commanded=commanded,
        lateral_drift=drift,
        heading_error=heading,
        torque_part={
            name: float(part)
            for name, part, has in zip(trace.joints, most, limited, strict=True)
            if has
        },
        knees=(_range(knees[:, 0]), _range(knees[:, 1])) if walking.any() else None,
        clearance=clearance,
        scuffs=scuffs,
        estimate=_estimate(rollout, trace),
        cycle_time=(float(np.percentile(cycle[warm], 50)), float(np.percentile(cycle[warm], 99))),
        real_time_factor=len(cycle[warm]) * _period(rollout) / busy,
    )


def _period(rollout: Rollout) -> float:
    time = rollout.time
    return float(time[1] - time[0]) if len(time) > 1 else 0.001


def _range(values: Array) -> tuple[float, float]:
    """Least and largest bend, whichever way the joint counts."""
    bend = np.abs(values)
    return float(bend.min()), float(bend.max())


def _speed(
    rollout: Rollout, trace: BodyTrace
) -> tuple[tuple[float, float] | None, tuple[float, float]]:
    """Velocity held under the last command to walk, over whole pairs of steps, and that command."""
    held, last = rollout.held_speed, trace.last_command
    return None if held is None else held.velocity, (0.0, 0.0) if last is None else last[1]


def _off_course(rollout: Rollout, trace: BodyTrace) -> tuple[float | None, float | None]:
    """How far to the left of the course, and turned away from it, at the end of walking."""
    steps = rollout.footsteps
    if not steps:
        return None, None
    # The course is moved on at touchdowns; the middle of the feet is where it says just then.
    row = int(np.searchsorted(rollout.time, steps[-1].start))
    middle = trace.sole_position[row, :, :2].mean(axis=0)
    away = rotated_by((middle - trace.course[row, :2])[None], -trace.course[row : row + 1, 2])[0]
    rows = np.flatnonzero(trace.walking)[-round(1.0 / _period(rollout)) :]
    turn = wrapped(trace.base_turn[rows, 2] - trace.course[rows, 2])
    return float(away[1]), float(turn.mean())


def _swings(rollout: Rollout, trace: BodyTrace) -> tuple[tuple[float, float] | None, int]:
    low, scuffs, time = [], 0, rollout.time
    force = LANDING_FORCE * trace.robot.mass * trace.robot.gravity
    for step in rollout.footsteps:
        first, last = np.searchsorted(time, [step.start, step.start + step.duration])
        begin, end = (int(first + part * (last - first)) for part in MID_SWING)
        if end <= begin:
            continue
        swing = 1 - int(trace.support[begin])
        low.append(float(trace.clearance[begin:end, swing].min()))
        scuffs += bool((trace.sole_force[begin:end, swing, 2] > force).any())
    return ((min(low), float(np.median(low))) if low else None), scuffs


def _estimate(rollout: Rollout, trace: BodyTrace) -> dict[str, float]:
    """Errors of the DCM from the standing foot, of place, of the base's velocity and tilt."""
    rows = trace.walking
    if not len(trace.told_position) or not rows.any():
        return {}
    given, truth = rollout.seen[rows], rollout.observations[rows]
    dcm = (given["dcm"] - given["support_foot"]) - (truth["dcm"] - truth["support_foot"])
    place = trace.told_position[rows, :3] - trace.position[rows, :3]
    velocity = trace.told_velocity[rows, :3] - trace.velocity[rows, :3]
    # Twice the vector part of the quaternion that turns one base into the other.
    tilt = 2.0 * _apart(trace.told_position[rows, 3:7], trace.position[rows, 3:7])[:, :2]
    errors = {"dcm": dcm, "place": place, "velocity": velocity, "tilt": tilt}
    return {
        name: float(np.sqrt((error.astype(float) ** 2).sum(axis=1).mean()))
        for name, error in errors.items()
    }


def _apart(first: Array, second: Array) -> Array:
    """Vector part, in the world, of the rotation from the second quaternion to the first."""
    w, x, y, z = first.T
    a, b, c, d = second.T
    return np.stack(
        [
            -w * b + x * a - y * d + z * c,
            -w * c + x * d + y * a - z * b,
            -w * d - x * c + y * b + z * a,
        ],
        axis=1,
    )


def planned_com(rollout: Rollout, trace: BodyTrace) -> Array:
    """The CoM that goes with the planned DCM, c' = omega (xi - c), shape (n, 2) [m].

    It begins at the true CoM wherever a plan begins; NaN while both feet stand, without a plan.
    """
    plan, com = rollout.dcm_plan, np.full((len(trace.com), 2), np.nan)
    follow = 1.0 - math.exp(-trace.omega * _period(rollout))
    for row in np.flatnonzero(trace.walking):
        begins = row == 0 or not trace.walking[row - 1]
        last = trace.com[row, :2] if begins else com[row - 1]
        com[row] = last + follow * (plan[row] - last)
    return com

"""How a pushed body recovers: when it is back in a gait, and how much of its limits it used.

It is back when every step is like the last one on that foot. That need not be the gait that it was
pushed out of: the loop that holds place and speed commands another velocity afterwards, for as long
as it takes to make up for what the push took.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.robot.own_units import OwnUnits
from surefoot.rollout.fall_signs import OFF_TARGET
from surefoot.rollout.outcome import BACK_STEPS
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import WALKING
from surefoot.worlds.body.controller import BodyState

REPEATED_OFFSET, REPEATED_TIME = 0.005, 0.01
"""A push is over when `BACK_STEPS` in a row begin, each with the DCM that near to where it was in
the last step on that foot [m], and that much sooner or later after the one before it [s]."""

USUAL_OFFSET = 0.04
"""And no further than that from where it was before the push [m]: as far as speeds differ."""

SPAN = 1.0
"""For so long after the push began limits are looked at: later there are consequences [s]."""


@dataclass(frozen=True)
class BegunStep:
    """A step at its touchdown.

    Attributes:
        side: that stands in it, as in `FEET`.
        offset: of the DCM from its foot, shape (2,) [m].
        begin: when it began [s].
        before: how long the step before it has lasted, NaN for the first one [s].
    """

    side: int
    offset: NDArray[np.float64]
    begin: float
    before: float


class Steps:
    """The steps of a walk as they begin."""

    def __init__(self) -> None:
        self._count, self._began = -1, math.nan

    def begun(self, state: BodyState) -> BegunStep | None:
        """The step that has just begun, if one has; to be asked in every cycle."""
        walk = state.walk[0]
        if walk["phase"] != WALKING or walk["steps"] == self._count:
            return None
        before, self._began = float(walk["began"] - self._began), float(walk["began"])
        self._count = int(walk["steps"])
        seen = state.observation
        return BegunStep(int(walk["support"]), seen.dcm - seen.support_foot, self._began, before)


class Settling:
    """Watches whether a robot is back in a gait, one touchdown after another.

    Args:
        usual: a step on each foot as it is without a push, by its side.
        from_time: when the push is over [s].
    """

    def __init__(self, usual: Mapping[int, BegunStep], from_time: float) -> None:
        self._usual, self._from, self._steps, self._in_row = usual, from_time, Steps(), 0
        self._last: dict[int, BegunStep] = {}

    def done(self, state: BodyState) -> bool:
        """Whether enough steps in a row were alike; to be asked in every cycle."""
        step = self._steps.begun(state)
        if step is not None:
            alike = step.begin > self._from and self._is_alike(step)
            self._in_row = self._in_row + 1 if alike else 0
            self._last[step.side] = step
        return self._in_row >= BACK_STEPS

    def _is_alike(self, step: BegunStep) -> bool:
        usual, last = self._usual.get(step.side), self._last.get(step.side)
        if usual is None or last is None:
            return False
        # The first step of a fork has none before it: NaN, which is not less than anything.
        return (
            math.dist(step.offset, usual.offset) < USUAL_OFFSET
            and math.dist(step.offset, last.offset) < REPEATED_OFFSET
            and abs(step.before - last.before) < REPEATED_TIME
        )


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

"""When a body that was pushed is back in a gait: every step is like the last one on that foot.

Not necessarily in the one that it was pushed out of: what holds the place and the speed tells the
controller another velocity afterwards, for as long as it takes to make up for what the push took.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.rollout.outcome import BACK_STEPS
from surefoot.rollout.trace import WALKING
from surefoot.worlds.body.controller import BodyState

REPEATED_OFFSET, REPEATED_TIME = 0.005, 0.01
"""A push is over when `BACK_STEPS` in a row begin, each with the DCM that near to where it was in
the last step on that foot [m], and that much sooner or later after the one before it [s]."""

USUAL_OFFSET = 0.04
"""And no further than that from where it was before the push [m]: as far as speeds differ."""


@dataclass(frozen=True)
class BegunStep:
    """A step at its touchdown.

    Attributes:
        side: that stands in it, as in `SIDES`.
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

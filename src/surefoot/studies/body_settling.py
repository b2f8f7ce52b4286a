"""When a body that was pushed is back in its gait: what is left is a walk like the one before."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.control.body_control import BodyState
from surefoot.models.walker import WALKING
from surefoot.simulation.outcome import BACK_STEPS, is_in_gait

SETTLED_OFFSET = 0.015
"""A push is over when `BACK_STEPS` in a row begin that near to those before it [m], after steps
that last as long (`is_in_gait`)."""


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
    """Watches whether a robot is back in its gait, one touchdown after another.

    Args:
        usual: a step on each foot as it is without a push, by its side.
        from_time: when the push is over [s].
    """

    def __init__(self, usual: Mapping[int, BegunStep], from_time: float) -> None:
        self._usual, self._from, self._steps, self._in_row = usual, from_time, Steps(), 0

    def done(self, state: BodyState) -> bool:
        """Whether enough steps in a row were as usual; to be asked in every cycle."""
        step = self._steps.begun(state)
        if step is not None:
            usual = self._usual.get(step.side)
            near = usual is not None and is_in_gait(
                (float(np.hypot(*(step.offset - usual.offset))),),
                (SETTLED_OFFSET,),
                step.before - usual.before,
            )
            self._in_row = self._in_row + 1 if near and step.begin > self._from else 0
        return self._in_row >= BACK_STEPS

"""A push map as arrays, and what follows from it; for pictures and the page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.errors import ParameterError

RECOVERED, UNSETTLED, FELL, NOT_WALKED = 0, 1, 2, -1
"""What becomes of a walk, as in the table; NOT_WALKED for an impulse that the scan passed over."""

FATES = ("recovered", "not settled", "fell")
"""In words."""


@dataclass(frozen=True)
class PushCube:
    """A push map; made by `push_cube`, which checks it. P phases, D directions, N impulses.

    Attributes:
        phases: fractions of the step, shape (P,).
        angles: of the pushes, from forward towards the swing foot, shape (D,) [deg].
        step: distance between neighbouring impulses [N s].
        coarse: distance between those that were walked everywhere [N s].
        push_duration: [s].
        impulse: the smallest that fails, inf if none does, shape (P, D) [N s].
        survived: the largest below which all are survived, shape (P, D) [N s].
        limit: the largest that any policy could survive, shape (P, D) [N s].
        limit_causal: the same if nobody knows when the push ends, shape (P, D) [N s].
        limit_fixed: the same without moving a landing, shape (P, D) [N s].
        holes: how many walked impulses above the smallest failing one are survived, shape (P, D).
        fate: RECOVERED, UNSETTLED, FELL or NOT_WALKED, shape (P, D, N).
        recovery_steps: steps from the end of the push until it is settled, -1 if it is not, shape
            (P, D, N).
        margin: how far the DCM offset stays inside of what stepping can save, NaN where nothing was
            walked, shape (P, D, N) [m].
        provenance: how and where it was measured, in words.
    """

    phases: NDArray[np.float64]
    angles: NDArray[np.float64]
    step: float
    coarse: float
    push_duration: float
    impulse: NDArray[np.float64]
    survived: NDArray[np.float64]
    limit: NDArray[np.float64]
    limit_causal: NDArray[np.float64]
    limit_fixed: NDArray[np.float64]
    holes: NDArray[np.int64]
    fate: NDArray[np.int8]
    recovery_steps: NDArray[np.int16]
    margin: NDArray[np.float32]
    provenance: Mapping[str, str]

    @cached_property
    def share(self) -> NDArray[np.float64]:
        """What is survived as a fraction of the limit, at most 1; NaN where there is no limit."""
        none = np.where(self.limit > 0.0, self.limit, math.nan)
        return np.minimum(self.survived / none, 1.0)

    @cached_property
    def share_causal(self) -> NDArray[np.float64]:
        """The same of what can be survived by those who do not know when the push ends."""
        none = np.where(self.limit_causal > 0.0, self.limit_causal, math.nan)
        return np.minimum(self.survived / none, 1.0)

    @cached_property
    def walks(self) -> int:
        """How many there were."""
        return int(np.sum(self.fate != NOT_WALKED))

    @property
    def whole(self) -> bool:
        """Whether every impulse was walked."""
        return math.isclose(self.coarse, self.step)

    @property
    def everywhere(self) -> float:
        """The largest impulse that was walked, and is survived, in every cell [N s]."""
        return self.coarse * math.floor(float(self.survived.min()) / self.coarse + 1e-9)

    def at(self, values: NDArray[Any], impulse: float) -> NDArray[np.float64]:
        """Of a value for each walk that under one impulse [N s], shape (P, D); NaN where the robot
        does not recover, or was not pushed so hard."""
        number = round(impulse / self.step)
        recovered = self.fate[..., number] == RECOVERED
        return np.where(recovered, values[..., number].astype(float), math.nan)


def push_cube(
    rows: Sequence[Mapping[str, Any]], grid: Mapping[str, Any], provenance: Mapping[str, str]
) -> PushCube:
    """Check what was measured, and arrange it.

    Args:
        rows: one for each cell, with the columns of the table.
        grid: with `step`, `coarse` and `push_duration`.
        provenance: how and where it was measured, in words.

    Raises:
        ParameterError: there is nothing, or not one row for each phase and direction.
    """
    phases = sorted({float(row["phase"]) for row in rows})
    angles = sorted({float(row["angle"]) for row in rows})
    if not rows or len(rows) != len(phases) * len(angles):
        raise ParameterError(
            "one row for each phase and direction",
            f"{len(rows)} rows of {len(phases)} phases and {len(angles)} directions",
            "give the whole table of one map",
        )
    step, shape = float(grid["step"]), (len(phases), len(angles))
    count = 1 + max(round(max(row["impulses"]) / step) for row in rows)
    fate = np.full((*shape, count), NOT_WALKED, np.int8)
    steps = np.full((*shape, count), -1, np.int16)
    margin = np.full((*shape, count), math.nan, np.float32)
    names = ("impulse", "survived", "limit", "limit_causal", "limit_fixed", "holes")
    single = {name: np.zeros(shape) for name in names}
    for row in rows:
        place = phases.index(row["phase"]), angles.index(row["angle"])
        numbers = np.round(np.array(row["impulses"]) / step).astype(int)
        fate[place][numbers] = row["fate"]
        steps[place][numbers] = row["recovery_steps"]
        margin[place][numbers] = row["margin"]
        for name in names:
            single[name][place] = row[name]
    return PushCube(
        np.array(phases), np.array(angles), step, float(grid["coarse"]),
        float(grid["push_duration"]), single["impulse"], single["survived"], single["limit"],
        single["limit_causal"], single["limit_fixed"], single["holes"].astype(int), fate, steps,
        margin, dict(provenance),
    )  # fmt: skip

"""A push map as arrays, in a few numbers, and in words."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.errors import ParameterError
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.words import RECOVERED_WORDS, angle_words, percent
from surefoot.studies.push_map.measure import NOT_WALKED, RECOVERED
from surefoot.studies.push_map.question import PushMap


@dataclass(frozen=True)
class Quantity:
    """What may colour a cell.

    Attributes:
        key: its name.
        words: its name in words.
        unit: in which it is shown.
        factor: from the unit of the table to that one.
        per_walk: whether it is one of each walk, and so depends on the impulse.
        whole: whether it is a whole number.
    """

    key: str
    words: str
    unit: str
    factor: float = 1.0
    per_walk: bool = False
    whole: bool = False


QUANTITIES = (
    Quantity("survived", "Largest survived impulse", "N s"),
    Quantity("share", "Share of the theoretical limit", "%", 100.0),
    Quantity("steps", "Steps to recover", "steps", per_walk=True, whole=True),
    Quantity("margin", "Margin", "cm", 100.0, per_walk=True),
)
"""In the order in which they are shown."""

SHARE = 90.0
"""Colours of shares begin here, or lower [%]: of less than a tenth of the limit, the steps of the
scan are a good part."""


@dataclass(frozen=True)
class MapNumbers:
    """The rows of a push map as arrays: P phases, D directions, N impulses.

    Args:
        measured: the map.

    Attributes:
        impulse, survived, limit, limit_causal, limit_fixed: columns of the table, shape (P, D)
            [N s].
        share: column `fraction`, what is survived of the limit, NaN where there is none, (P, D).
        share_causal: column `fraction_causal`, shape (P, D).
        holes: how many walked impulses above the smallest failing one are survived, shape (P, D).
        fate: of every walk, `NOT_WALKED` where the scan passed over, shape (P, D, N).
        recovery_steps: -1 if it does not recover, shape (P, D, N).
        margin: NaN where nothing was walked, shape (P, D, N) [m].

    Raises:
        ParameterError: there is not one row for each phase and direction.
    """

    measured: Measured[PushMap]
    impulse: NDArray[np.float64] = field(init=False)
    survived: NDArray[np.float64] = field(init=False)
    limit: NDArray[np.float64] = field(init=False)
    limit_causal: NDArray[np.float64] = field(init=False)
    limit_fixed: NDArray[np.float64] = field(init=False)
    share: NDArray[np.float64] = field(init=False)
    share_causal: NDArray[np.float64] = field(init=False)
    holes: NDArray[np.int64] = field(init=False)
    fate: NDArray[np.int8] = field(init=False)
    recovery_steps: NDArray[np.int16] = field(init=False)
    margin: NDArray[np.float32] = field(init=False)

    def __post_init__(self) -> None:
        rows, study = self.measured.rows, self.study
        shape = study.phases, study.directions
        if len(rows) != math.prod(shape):
            raise ParameterError(
                "one row for each phase and direction",
                f"{len(rows)} rows of {shape[0]} phases and {shape[1]} directions",
                "give the whole table of one map",
            )
        columns = ("impulse", "survived", "limit", "limit_causal", "limit_fixed", "holes")
        shares = {"share": "fraction", "share_causal": "fraction_causal"}
        for name, of in ({one: one for one in columns} | shares).items():
            values = np.array([row[of] for row in rows]).reshape(shape)
            object.__setattr__(self, name, values)
        numbers = [np.round(np.array(row["impulses"]) / study.step).astype(int) for row in rows]
        count = 1 + max(int(one.max()) for one in numbers)
        for name, empty in (
            ("fate", np.int8(NOT_WALKED)), ("recovery_steps", np.int16(-1)),
            ("margin", np.float32(math.nan)),
        ):  # fmt: skip
            values = np.full((len(rows), count), empty)
            for own, places, row in zip(values, numbers, rows, strict=True):
                own[places] = row[name]
            object.__setattr__(self, name, values.reshape(*shape, count))

    @property
    def study(self) -> PushMap:
        """The question."""
        return self.measured.study

    @property
    def angles(self) -> NDArray[np.float64]:
        """The directions, shape (D,) [deg]."""
        return np.array(self.study.angles)

    @property
    def phases(self) -> NDArray[np.float64]:
        """The phases, as fractions of the step, shape (P,)."""
        return np.array(self.study.fractions)

    @property
    def walks(self) -> int:
        """How many there were."""
        return int(np.sum(self.fate != NOT_WALKED))

    @property
    def coarse(self) -> float:
        """Distance between the impulses that were walked everywhere [N s]."""
        return self.study.coarse or self.study.step

    @property
    def everywhere(self) -> float:
        """The largest impulse that was walked, and is survived, in every cell [N s]."""
        return self.coarse * math.floor(float(self.survived.min()) / self.coarse + 1e-9)

    def at(self, values: NDArray[Any], impulse: float) -> NDArray[np.float64]:
        """Of a value for each walk that under one impulse [N s], shape (P, D); NaN where the robot
        does not recover, or was not pushed so hard."""
        number = round(impulse / self.study.step)
        recovered = self.fate[..., number] == RECOVERED
        return np.where(recovered, values[..., number].astype(float), math.nan)

    def shown(self, quantity: Quantity, impulse: float) -> NDArray[np.float64]:
        """A quantity in its unit, under an impulse [N s] if it is one of walks, shape (P, D)."""
        values = self._of(quantity)
        return quantity.factor * (self.at(values, impulse) if quantity.per_walk else values)

    def colour_range(self, quantity: Quantity) -> tuple[float, float]:
        """Between which values of a quantity colours are, over all impulses."""
        values = quantity.factor * self._of(quantity).astype(float)
        if quantity.per_walk:
            values = values[self.fate == RECOVERED]
        known = values[np.isfinite(values)]
        low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
        if quantity.key == "share":
            return min(low, SHARE), 100.0
        return (low - 1.0, high + 1.0) if low == high else (low, high)

    def _of(self, quantity: Quantity) -> NDArray[Any]:
        return getattr(self, "recovery_steps" if quantity.key == "steps" else quantity.key)


def origin(numbers: MapNumbers) -> list[str]:
    """Whose map it is, in a few words each."""
    known = numbers.measured.provenance
    return [
        known["controller"],
        known["robot"],
        known["velocity"],
        f"leg {known['leg speed']}",
        f"pushes of {numbers.study.push_duration:g} s",
    ]


def summary(numbers: MapNumbers) -> dict[str, Any]:
    """The map in a few numbers; SI, JSON has no word for what is not there but None."""
    share, survived = numbers.share, numbers.survived
    worst = np.unravel_index(np.argmin(np.nan_to_num(share, nan=2.0)), share.shape)
    known = bool(np.isfinite(share).any())
    return {
        "cells": int(share.size),
        "walks": numbers.walks,
        "survived_least": float(survived.min()),
        "survived_mean": float(survived.mean()),
        "survived_most": float(survived.max()),
        "fraction_mean": float(np.nanmean(share)) if known else None,
        "fraction_worst": float(share[worst]) if known else None,
        "fraction_causal_mean": float(np.nanmean(numbers.share_causal)) if known else None,
        "fraction_causal_worst": float(np.nanmin(numbers.share_causal)) if known else None,
        "worst_phase": float(numbers.phases[worst[0]]),
        "worst_angle": float(numbers.angles[worst[1]]),
        "cells_with_holes": int((numbers.holes > 0).sum()),
        "cells_without_failure": int(np.isinf(numbers.impulse).sum()),
    }


def finding(numbers: MapNumbers) -> str:
    """The map in a few sentences."""
    found = summary(numbers)
    words = (
        f"Survives {found['survived_least']:g} to {found['survived_most']:g} N s, on average "
        f"{found['survived_mean']:.0f}"
    )
    if found["fraction_mean"] is not None:
        words += (
            f": {percent(found['fraction_mean'])} of the limit, and "
            f"{percent(found['fraction_worst'])} where it is weakest, "
            f"{angle_words(found['worst_angle'])} at {found['worst_phase']:.3g} of the step. Of "
            "what can be survived without knowing when the push ends it is "
            f"{percent(found['fraction_causal_mean'])}, at least "
            f"{percent(found['fraction_causal_worst'])}"
        )
    holes = found["cells_with_holes"]
    words += f". In {holes} of {found['cells']} cells " if holes else ". In no cell "
    return words + "a push is survived that is harder than one that fails."


def protocol(study: PushMap) -> list[str]:
    """What is measured and how, a paragraph each."""
    scan = (
        f"Every impulse was walked, in steps of {study.step:g} N s."
        if study.stride == 1
        else f"Walked was every impulse that is a multiple of {study.coarse:g} N s, and between "
        "two of which one is survived and the other not every one in steps of "
        f"{study.step:g} N s. A failure between two survived neighbours, a hole narrower than "
        f"{study.coarse:g} N s, may have been missed: then the smallest failing impulse is lower "
        "than it says here."
    )
    return [
        f"The robot walks steadily and is pushed once, for {study.push_duration:g} s, in one of "
        f"{study.directions} directions and at one of {study.phases} phases of the step, by "
        "impulses from zero to the first above the limit. " + scan,
        f"{RECOVERED_WORDS} What is survived is the largest impulse below which every push is. "
        "Survival is not monotone: where a harder push than the smallest failing one is survived, "
        "the cell is marked.",
        "Directions are from forward (0°) to outward, towards the swing foot (90°), back (180°) "
        "and inward, over the standing foot to the other side (270°). The phase is the fraction of "
        "the nominal step at which the push begins; 0 is the touchdown.",
        "The theoretical limit is the largest impulse that a robot with the same sole, steps, "
        "times and leg could survive if its controller learned of the push when it starts. A "
        "controller that does not know when the push ends has to be viable at every instant of "
        "it; that limit is the thin line. That of fixed steps is by the ZMP alone.",
        "Steps to recover are those finished from the end of the push to the first touchdown at "
        "which the robot is back. The margin is the least, over all touchdowns, of how far the DCM "
        "offset was inside of what stepping can save with a whole sole and a leg without limits; "
        "a slow leg falls with a margin that is still positive.",
    ]

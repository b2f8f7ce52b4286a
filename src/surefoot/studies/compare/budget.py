"""What each method loses to each disturbance, as checked values: the noise-and-delay budget."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from surefoot.errors import ParameterError

UNDISTURBED = "none"
"""Key of the walks that the others are compared with."""

_SITUATION = ("angle", "phase", "push_duration", "leg_speed")


@dataclass(frozen=True)
class Wrong:
    """One disturbance.

    Attributes:
        key: its name in the rows.
        label: its name in words.
        walks: how many walks a scan of it takes, with one seed or offset each.
    """

    key: str
    label: str
    walks: int


@dataclass(frozen=True)
class Kept:
    """What is left of the margin of one method under one disturbance; means over `cells` pushes.

    Attributes:
        share: what is survived as a share of the limit, in the worst walk.
        lost: what is survived less than undisturbed, in the worst walk; nan without those [N s].
        mean_share: like `share`, over all walks.
        mean_lost: like `lost`, over all walks [N s].
        before: the share without any disturbance, of the same pushes.
        cells: how many pushes.
    """

    share: float
    lost: float
    mean_share: float
    mean_lost: float
    before: float
    cells: int

    @property
    def change(self) -> float:
        """Of the share, as a fraction of what it was; nan if that is not known, or was 0."""
        return (self.share - self.before) / self.before if self.before > 0.0 else math.nan


@dataclass(frozen=True)
class Budget:
    """The whole budget; made by `budget`.

    Attributes:
        methods: key and label of each method, in order of display.
        wrongs: disturbances, in order of display.
        kept: by the keys of method and disturbance; what was not measured is missing.
        situations: how many pushes were asked for.
        provenance: how and where it was measured, in words.
    """

    methods: tuple[tuple[str, str], ...]
    wrongs: tuple[Wrong, ...]
    kept: Mapping[tuple[str, str], Kept]
    situations: int
    provenance: Mapping[str, str]

    @property
    def complete(self) -> bool:
        """Whether everything was measured on every push."""
        return len(self.kept) == len(self.methods) * len(self.wrongs) and all(
            one.cells == self.situations for one in self.kept.values()
        )


def budget(
    rows: Sequence[Mapping[str, Any]],
    methods: Sequence[Mapping[str, Any]],
    disturbances: Sequence[Mapping[str, Any]],
    provenance: Mapping[str, str],
) -> Budget:
    """What the rows of a comparison with disturbances come to.

    Args:
        rows: with the cell, `impulse`, `step`, `scanned`, `survived_mean` and `limit_finite` [N s].
        methods: with `key` and `label`, in order of display.
        disturbances: with `key`, `label` and `walks`, in order of display.
        provenance: how and where it was measured, in words.

    Raises:
        ParameterError: there are no rows.
    """
    if not rows:
        raise ParameterError("rows of a comparison", "none", "measure something")
    named = tuple((one["key"], one["label"]) for one in methods)
    wrongs = tuple(Wrong(one["key"], one["label"], one["walks"]) for one in disturbances)
    at = {(row["method"], row["disturbance"], _situation(row)): row for row in rows}
    situations = sorted({_situation(row) for row in rows})
    kept = {}
    for method, _ in named:
        for wrong in wrongs:
            pairs = [
                (at[method, wrong.key, here], at.get((method, UNDISTURBED, here)))
                for here in situations
                if (method, wrong.key, here) in at
            ]
            if pairs:
                kept[method, wrong.key] = _kept(pairs)
    return Budget(named, wrongs, kept, len(situations), dict(provenance))


def _kept(pairs: Sequence[tuple[Mapping[str, Any], Mapping[str, Any] | None]]) -> Kept:
    both = [(row, before) for row, before in pairs if before is not None]
    return Kept(
        share=_mean(_share(_survived(row), row) for row, _ in pairs),
        lost=_mean(_survived(before) - _survived(row) for row, before in both),
        mean_share=_mean(_share(row["survived_mean"], row) for row, _ in pairs),
        mean_lost=_mean(before["survived_mean"] - row["survived_mean"] for row, before in both),
        before=_mean(_share(_survived(before), before) for _, before in both),
        cells=len(pairs),
    )


def _situation(row: Mapping[str, Any]) -> tuple[float, ...]:
    return tuple(row[name] for name in _SITUATION)


def _survived(row: Mapping[str, Any]) -> float:
    return min(max(row["impulse"] - row["step"], 0.0), row["scanned"])


def _share(survived: float, row: Mapping[str, Any]) -> float:
    limit = row["limit_finite"]
    return min(survived / limit, 1.0) if limit > 0.0 else math.nan


def _mean(values: Any) -> float:
    finite = [value for value in values if not math.isnan(value)]
    return math.fsum(finite) / len(finite) if finite else math.nan

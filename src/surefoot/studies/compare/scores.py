"""What follows from the rows of a comparison: what is survived, shares of the limit, and means.

A row is a dictionary with the columns that `Comparison` and `studies.compare.measure` document.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from surefoot.errors import ParameterError
from surefoot.studies.engine.table import Row, select, values

USUAL = {"leg_speed": 3.0, "push_duration": 0.2, "phase": 0.5}
"""What single numbers are of, unless somebody chooses: m/s, s, and the middle of a step."""


def survived(row: Row) -> float:
    """The largest impulse that was tried below which every push was survived [N s]."""
    return row["scanned"] if unbroken(row) else max(row["impulse"] - row["step"], 0.0)


def share(row: Row, limit: str = "limit_finite", survives: str = "") -> float:
    """What is survived as a share of a limit, at most 1.

    Args:
        row: of a comparison.
        limit: the column of the limit.
        survives: the column of what is survived; that of `survived` if empty.

    Returns:
        The share; nan where there is nothing to be survived, or no limit is known.
    """
    most = row.get(limit, math.nan)
    if most == 0.0:
        return math.nan
    return min((row[survives] if survives else survived(row)) / most, 1.0)


def unbroken(row: Row) -> bool:
    """Whether nothing that was tried failed: what it survives is at least `survived`."""
    return math.isinf(row["impulse"])


def impulse_words(row: Row | None) -> str:
    """The smallest failing impulse, or what it lies above [N s]; – if it was not measured."""
    if row is None:
        return "–"
    return f"> {row['scanned']:g}" if unbroken(row) else f"{row['impulse']:g}"


def situation(row: Row) -> tuple[float, float, float, float]:
    """Leg speed, push duration, phase and angle."""
    return (row["leg_speed"], row["push_duration"], row["phase"], row["angle"])


@dataclass(frozen=True)
class Score:
    """What some rows of one method come to.

    Attributes:
        mean: mean share of the limit, nan without cells.
        worst: smallest share, nan without cells.
        causal: mean share of the limit of those who do not know when the push ends, or nan.
        at_least: whether a scan ended before anything failed, so that the mean is a lower bound.
        cells: how many were measured.
        possible: how many were measured by any method.
        fell: in how many the smallest failing push made it fall.
        unsettled: in how many it kept walking, but did not settle.
    """

    mean: float
    worst: float
    causal: float
    at_least: bool
    cells: int
    possible: int
    fell: int
    unsettled: int

    @property
    def complete(self) -> bool:
        """Whether the mean stands on every cell that any method was measured on."""
        return self.cells == self.possible


def score(key: str, rows: Sequence[Row]) -> Score:
    """What some rows come to for one method.

    Args:
        key: of the method.
        rows: of any methods, among them those that it is measured against.
    """
    own = select(rows, method=key)
    shares = [share(row) for row in own if row["limit_finite"] > 0.0]
    causal = [share(row, "limit_causal") for row in own if row.get("limit_causal") != 0.0]
    return Score(
        mean=math.fsum(shares) / len(shares) if shares else math.nan,
        worst=min(shares, default=math.nan),
        causal=math.fsum(causal) / len(causal) if causal else math.nan,
        at_least=any(unbroken(row) and share(row) < 1.0 for row in own),
        cells=len(own),
        possible=len({situation(row) for row in rows}),
        fell=sum(row["failure"] == "fell" for row in own),
        unsettled=sum(row["failure"] == "unsettled" for row in own),
    )


@dataclass(frozen=True)
class Choice:
    """The push that a table or a picture shows in single numbers.

    Attributes:
        leg_speed: largest speed of the swing foot [m/s].
        push_duration: how long the push lasts [s].
        phase: fraction of the step at which it starts.
    """

    leg_speed: float
    push_duration: float
    phase: float


def choose(rows: Sequence[Row], **choice: float | None) -> Choice:
    """A choice among what was measured; what is left out is the value closest to the usual one.

    Args:
        rows: of a comparison.
        **choice: `leg_speed`, `push_duration` and `phase`.

    Raises:
        ParameterError: nothing was measured there.
    """
    found = {
        name: _pick(name, choice.get(name), values(rows, name), usual)
        for name, usual in USUAL.items()
    }
    return Choice(**found)


def _pick(name: str, value: float | None, measured: Sequence[float], usual: float) -> float:
    if value is None:
        finite = [candidate for candidate in measured if math.isfinite(candidate)]
        return min(finite or measured, key=lambda candidate: abs(candidate - usual))
    if value not in measured:
        raise ParameterError(
            f"`{name}` that was measured: {', '.join(f'{known:g}' for known in measured)}",
            repr(value),
            "choose one of these",
        )
    return value

"""What a comparison says about the paper's own one: 85 against 20 N s."""

from __future__ import annotations

import math
from collections.abc import Iterable

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.studies.engine.cells import Row

PAPER_HYBRID, PAPER_MPC = 85.0, 20.0
"""What the abstract of [OnlineGait] reports: its method, and MPC with foot placement [N s]."""

HYBRID, PLACEMENT = "hybrid", "foot-placement-mpc"


def remarks(rows: Iterable[Row]) -> list[str]:
    """Paragraphs on the paper's claim, from what was measured; none if a side of it is missing.

    Args:
        rows: of a comparison, see `studies.compare.measure`.
    """
    rows = list(rows)
    said = [_on_leg(rows, speed) for speed in sorted({row["leg_speed"] for row in rows})]
    said = [text for text in said if text]
    if not said:
        return []
    opening = (
        f"The paper reports that its hybrid survives {PAPER_HYBRID:g} N s where MPC with foot "
        f"placement alone survives {PAPER_MPC:g} N s, a ratio of {PAPER_HYBRID / PAPER_MPC:.1f}: "
        "one direction, one moment, a leg of unlimited speed, and a rival that is not described. "
        "Under one protocol, with the rival at its best, it becomes:"
    )
    return [opening, *said]


def _on_leg(rows: list[Row], leg_speed: float) -> str:
    parts = []
    for name, angle in DIRECTIONS.items():
        pairs = _pairs(rows, leg_speed, angle)
        if not pairs:
            continue
        ours, theirs = zip(*pairs, strict=True)
        wins = sum(a > b for a, b in pairs)
        parts.append(
            f"{name} {_range(ours)} against {_range(theirs)} N s ({_ratio(pairs)}the hybrid "
            f"is ahead in {wins} of {len(pairs)} cells)"
        )
    if not parts:
        return ""
    leg = "a leg of unlimited speed" if math.isinf(leg_speed) else f"a leg of {leg_speed:g} m/s"
    return f"With {leg}: {'; '.join(parts)}."


def _pairs(rows: list[Row], leg_speed: float, angle: float) -> list[tuple[float, float]]:
    """Smallest failing impulses of both methods, cell by cell where both were measured [N s]."""
    found: dict[tuple[float, float], dict[str, float]] = {}
    for row in rows:
        here = row["leg_speed"] == leg_speed and row["angle"] == angle
        if here and row["method"] in (HYBRID, PLACEMENT):
            cell = (row["phase"], row["push_duration"])
            found.setdefault(cell, {})[row["method"]] = row["impulse"]
    return [(both[HYBRID], both[PLACEMENT]) for both in found.values() if len(both) == 2]


def _ratio(pairs: list[tuple[float, float]]) -> str:
    """The geometric mean of the ratios, where all of them are numbers."""
    if any(not 0.0 < value < math.inf for pair in pairs for value in pair):
        return ""
    mean = math.exp(sum(math.log(a / b) for a, b in pairs) / len(pairs))
    return f"ratio {mean:.2f}; "


def _range(values: Iterable[float]) -> str:
    values = list(values)
    low, high = (f"{value:g}" if value < math.inf else "no" for value in (min(values), max(values)))
    return low if low == high else f"{low}–{high}"

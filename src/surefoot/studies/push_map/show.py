"""What a push map shows: a page on which a reader chooses a cell, a table and two pictures."""

from __future__ import annotations

import base64
from dataclasses import asdict
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.studies.engine.report import (
    Details,
    Figure,
    Interactive,
    Report,
    Table,
    Text,
    choice,
    provenance,
)
from surefoot.studies.engine.table import without_infinity
from surefoot.studies.engine.words import angle_words, percent
from surefoot.studies.push_map.map_numbers import (
    QUANTITIES,
    MapNumbers,
    finding,
    origin,
    protocol,
    summary,
)
from surefoot.studies.push_map.measure import PER_WALK, RECOVERED
from surefoot.studies.push_map.pictures import COLOURS, HEADING, heat_figure, polar_figure

NO_STEPS, MAX_STEPS = 63, 62
"""How a walk's steps to recover are packed into six bits: none, and so many or more."""

NO_MARGIN = -32768
"""How a margin is packed that there is none of."""

MARGIN_UNIT = 1e-4
"""Of a packed margin [m]."""


def report(numbers: MapNumbers) -> Report:
    """All of a map.

    On its page a choice can be put behind the address: `#show=share&phase=0.5&angle=90&impulse=60`.
    """
    study = numbers.study
    return Report(
        name=study.NAME,
        heading=HEADING,
        origin=origin(numbers),
        parts=[
            Text(finding(numbers)),
            Interactive.of("surefoot.studies.push_map", page_data(numbers)),
            _axes_table(numbers),
            Figure(
                f"{study.NAME}.png", "All directions and phases in colours",
                lambda: heat_figure(numbers), page="none",
            ),
            Figure(
                f"{study.NAME}-polar.png", "Polar maps of all phases",
                lambda: polar_figure(numbers), page="none",
            ),
            Details("By phase", [_phase_table(numbers)], folded=True),
            Details("What was measured, and how", [*map(Text, protocol(study))]),
            provenance(numbers.measured.provenance),
        ],
    )  # fmt: skip


def as_numbers(numbers: MapNumbers) -> dict[str, Any]:
    """For JSON, without the single walks; infinity and NaN are null."""
    cells = [{k: v for k, v in row.items() if k not in PER_WALK} for row in numbers.measured.rows]
    return {
        "grid": numbers.study.grid(),
        "cells": without_infinity(cells),
        "walks": numbers.walks,
        "provenance": numbers.measured.provenance,
        "summary": summary(numbers),
    }


def _axes_table(numbers: MapNumbers) -> Table:
    """What is survived along the axes, over all phases."""
    rows = []
    for angle in DIRECTIONS.values():
        for column in np.flatnonzero(numbers.angles == angle):
            survived, limit, share = (
                values[:, column] for values in (numbers.survived, numbers.limit, numbers.share)
            )
            rows.append((
                angle_words(angle),
                f"{survived.min():g} to {survived.max():g}",
                f"{limit.min():.0f} to {limit.max():.0f}",
                percent(float(share.mean())),
                percent(float(share.min())),
            ))  # fmt: skip
    columns = ("direction", "survived [N s]", "limit [N s]", "mean share", "worst")
    return Table("Along the axes", "", columns, rows)


def _phase_table(numbers: MapNumbers) -> Table:
    """What is survived along the axes at each phase, for a reader who runs no script."""
    ways = [int(np.argmin(np.abs(numbers.angles - angle))) for angle in DIRECTIONS.values()]
    head = ("phase", *(f"{angle_words(float(numbers.angles[way]))} [N s]" for way in ways),
            "mean of the limit", "worst")  # fmt: skip
    rows = [
        (
            f"{phase:.3g}",
            *(f"{numbers.survived[row, way]:g} of {numbers.limit[row, way]:.1f}" for way in ways),
            percent(float(np.mean(numbers.share[row]))),
            percent(float(np.min(numbers.share[row]))),
        )
        for row, phase in enumerate(numbers.phases)
    ]
    return Table("", "", head, rows)


def page_data(numbers: MapNumbers) -> dict[str, Any]:
    """What the script draws from.

    Cells stand phase after phase. `count` has the number of walks of each; `gap`, `code` and
    `margin` have, walk after walk, how many steps of the scan it lies above the one before; its
    fate times 64, and its steps to recover; and its margin in tenths of a millimetre. They are
    base64 of little-endian u2, u1, u1 and i2.
    """
    rows, step = numbers.measured.rows, numbers.study.step
    places = [np.round(np.array(row["impulses"]) / step).astype(int) for row in rows]
    fate, steps, margin = (
        np.concatenate([row[name] for row in rows]) for name in ("fate", "recovery_steps", "margin")
    )
    back = (fate == RECOVERED) & (steps >= 0)
    steps = np.where(back, np.minimum(steps, MAX_STEPS), NO_STEPS)
    lost = ~(np.abs(margin) < MARGIN_UNIT * (-NO_MARGIN - 1))
    margin = np.where(lost, NO_MARGIN, np.round(np.where(lost, 0.0, margin) / MARGIN_UNIT))
    phases, angles, limit = numbers.phases.tolist(), numbers.angles.tolist(), numbers.limit
    top = max(float(limit.max()), max(row["impulses"][-1] for row in rows))
    impulses = numbers.coarse * np.arange(int(top / numbers.coarse + 1e-9) + 1)
    weakest = np.unravel_index(np.argmin(np.nan_to_num(numbers.share, nan=2.0)), limit.shape)
    tried = int(numbers.survived[weakest] / numbers.coarse + 1e-9)
    columns = ("limit", "limit_causal", "limit_fixed", "survived", "share", "holes")
    return {
        "choices": {
            "show": choice([one.key for one in QUANTITIES], [one.words for one in QUANTITIES], 0),
            "impulse": choice(
                impulses.tolist(), [f"{one:.4g}\u00a0N\u00a0s" for one in impulses], tried
            ),
            "phase": choice(phases, [f"{one:.3g}" for one in phases], int(weakest[0])),
            "angle": choice(angles, [_angle_words(one) for one in angles], int(weakest[1])),
        },
        "angles": angles,
        "directions": DIRECTIONS,
        "step": step,
        "top": top,
        "shows": [
            {
                **asdict(one), "range": numbers.colour_range(one),
                "heading": one.words.lower() + ("" if one.whole else f" [{one.unit}]"),
            }
            for one in QUANTITIES
        ],
        "colours": [to_hex(colour) for colour in colormaps[COLOURS](np.linspace(0.0, 1.0, 17))],
        **{name: getattr(numbers, name).round(5).ravel().tolist() for name in columns},
        "count": _packed(np.array([len(one) for one in places]), "<u2"),
        "gap": _packed(np.concatenate([np.diff(one, prepend=0) for one in places]), "<u1"),
        "code": _packed(64 * fate + steps, "<u1"),
        "margin": _packed(margin, "<i2"),
    }  # fmt: skip


def _angle_words(angle: float) -> str:
    words = angle_words(angle)
    return f"{words} ({angle:.4g}°)" if words in DIRECTIONS else f"{angle:.4g}°"


def _packed(values: NDArray[Any], kind: str) -> str:
    return base64.b64encode(values.astype(kind).tobytes()).decode()

"""How gently pushes are answered, as plain numbers and as a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np

from surefoot.studies.engine.report import Report, Table, Text, provenance
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import Row, select
from surefoot.studies.engine.words import speed_words
from surefoot.studies.gentleness.question import Gentleness

QUANTITIES = {
    "zmp_peak": "ZMP peak [mm]",
    "zmp_rms": "ZMP RMS [mm]",
    "landing": "landing [mm]",
    "timing": "timing [ms]",
}
"""What is compared, as headings: each in thousandths."""

NOTICEABLE = 1e-6
"""An answer is larger if it is by more than this [m, s]."""


def larger(rows: Sequence[Row], key: str, other: str, quantity: str) -> int:
    """In how many cells the answer of a method is larger than that of another.

    Args:
        rows: of one leg speed and impulse; those of both methods stand in the same order.
        key, other: of the methods.
        quantity: one of `QUANTITIES`.
    """
    mine, theirs = ([row[quantity] for row in select(rows, method=one)] for one in (key, other))
    return sum(a > b + NOTICEABLE for a, b in zip(mine, theirs, strict=True))


def numbers(measured: Measured[Gentleness]) -> list[dict[str, Any]]:
    """Mean and largest of every quantity, for each leg speed and impulse; an unlimited leg is None.

    Cells of which one of the two answers could not be measured are left out.
    """
    study, first = measured.study, measured.study.methods[0]
    found = []
    for leg_speed, impulse in product(study.leg_speeds, study.impulses):
        rows = _pairs(select(measured.rows, leg_speed=leg_speed, impulse=impulse))
        if not rows:
            continue
        methods = {}
        for key in study.methods:
            own = select(rows, method=key)
            methods[key] = {name: _summary([row[name] for row in own]) for name in QUANTITIES}
        found.append(
            {
                "leg_speed": leg_speed if math.isfinite(leg_speed) else None,
                "impulse": impulse,
                "cells": len(rows) // len(study.methods),
                "methods": methods,
                f"{first}_larger": {
                    name: larger(rows, *study.methods, name) for name in QUANTITIES
                },
            }
        )
    return found


def _summary(values: Sequence[float]) -> dict[str, float]:
    return {"mean": float(np.mean(values)), "largest": max(values)}


def _pairs(rows: Sequence[Row]) -> list[Row]:
    """The rows of pushes that both methods have answered."""
    pushes = [(row["angle"], row["phase"]) for row in rows]
    return [row for row, push in zip(rows, pushes, strict=True) if pushes.count(push) == 2]


def gentleness_report(measured: Measured[Gentleness]) -> Report:
    """Mean and largest answer of both methods, and in how many cells the first one's is larger."""
    entries = numbers(measured)
    tables = []
    for leg_speed in dict.fromkeys(entry["leg_speed"] for entry in entries):
        lines = []
        for entry in (one for one in entries if one["leg_speed"] == leg_speed):
            lines += _lines(entry, measured.study.methods[0])
        speed = math.inf if leg_speed is None else leg_speed
        title = f"{speed_words(speed).capitalize()}: mean, largest"
        tables.append(Table(title, "", ("push", "method", *QUANTITIES.values()), lines))
    return Report(
        "gentleness",
        "How gently small pushes are answered",
        (measured.study.robot.name, f"{len(measured.rows)} pushes"),
        (
            Text(
                "How far the ZMP leaves the centre of the foot, and by how much landings change in "
                "place and time, after pushes in four directions at four phases of a step."
            ),
            *tables,
            provenance(measured.provenance),
        ),
    )


def _lines(entry: dict[str, Any], first: str) -> list[tuple[str, ...]]:
    """The rows of one impulse."""
    lines = []
    for key, values in entry["methods"].items():
        cells = [
            f"{1e3 * values[name]['mean']:.1f} {1e3 * values[name]['largest']:6.1f}"
            for name in QUANTITIES
        ]
        lines.append((f"{entry['impulse']:g} N s" if key == first else "", key, *cells))
    counts = [f"{entry[f'{first}_larger'][name]} of {entry['cells']}" for name in QUANTITIES]
    return [*lines, ("", f"{first} larger in", *counts)]

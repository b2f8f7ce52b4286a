"""The part of a comparison's page that draws itself: the reader chooses leg, push and methods.

A choice can be put behind the address of the page: `#speed=3&duration=0.2&phase=worst&methods=a,b`.
"""

from __future__ import annotations

import math
from importlib.resources import files
from typing import Any

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.show.palette import mark
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import Choice, situation, values
from surefoot.studies.engine.report import Interactive
from surefoot.studies.engine.scan import FAILURES
from surefoot.studies.engine.study import Measured

SCRIPTS = ("page_numbers.js", "page.js")
"""In the order in which they run."""

LIMITS = ("limit_point", "limit_finite", "limit_fixed", "limit_causal")
"""In the order in which the script takes them."""


def interactive(measured: Measured[Comparison], choice: Choice) -> Interactive:
    """The map and the table that follow the reader.

    Args:
        measured: what was measured.
        choice: with what the page opens.
    """
    markup, *scripts = (
        (files("surefoot.studies.compare") / name).read_text("utf-8")
        for name in ("page.html", *SCRIPTS)
    )
    return Interactive(markup, page_data(measured, choice), scripts, _colours(measured))


def page_data(measured: Measured[Comparison], choice: Choice) -> dict[str, Any]:
    """What the script draws from: lists of values, and indices into them.

    `pushes` are (leg speed, duration, phase, angle, four limits), the first four as indices;
    `cells` are (method, push, impulse, delta_v, step, scanned, failure), the first two and the
    last as indices.
    """
    rows, methods = measured.rows, measured.notes["methods"]
    axes = [values(rows, name) for name in ("leg_speed", "push_duration", "phase", "angle")]
    speeds, durations, phases, angles = axes
    rank = {method["key"]: index for index, method in enumerate(methods)}
    places: dict[tuple[float, ...], int] = {}
    pushes, cells = [], []
    for row in rows:
        here = situation(row)
        if here not in places:
            places[here] = len(pushes)
            pushes.append(
                [
                    *(axis.index(value) for axis, value in zip(axes, here, strict=True)),
                    *(row.get(name, math.nan) for name in LIMITS),
                ]
            )
        cells.append(
            [
                rank[row["method"]], places[here], row["impulse"], row["delta_v"], row["step"],
                row["scanned"], FAILURES.index(row["failure"]),
            ]
        )  # fmt: skip
    return {
        "choice": {
            "speed": speeds.index(choice.leg_speed),
            "duration": durations.index(choice.push_duration),
            "phase": phases.index(choice.phase),
        },
        "directions": DIRECTIONS,
        "failures": FAILURES,
        "speeds": speeds,
        "durations": durations,
        "phases": phases,
        "angles": angles,
        "methods": [
            {
                "key": method["key"], "label": method["label"], "adapts": method["adapts"],
                "p50": method["decision_p50"], "tail": method["decision_p99_9"],
                "dashed": mark(index).dashed, "outline": mark(index).outline,
            }
            for index, method in enumerate(methods)
        ],
        "pushes": pushes,
        "cells": cells,
    }  # fmt: skip


def _colours(measured: Measured[Comparison]) -> str:
    marks = [mark(index) for index in range(len(measured.notes["methods"]))]
    light = " ".join(f"--m{index}: {how.colour};" for index, how in enumerate(marks))
    dark = " ".join(f"--m{index}: {how.dark};" for index, how in enumerate(marks))
    return (
        f":root {{ {light} }}\n"
        f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"
    )

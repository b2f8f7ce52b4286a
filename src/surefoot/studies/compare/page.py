"""The part of a comparison's page that draws itself: the reader chooses leg, push and methods.

A choice can be put behind the address of the page: `#speed=3&duration=0.2&phase=worst&methods=a,b`.
"""

from __future__ import annotations

import math
from typing import Any

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.show.palette import mark
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import Choice, situation, survived
from surefoot.studies.engine.report import choice as choice_of
from surefoot.studies.engine.scan import FAILURES
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import values
from surefoot.studies.engine.words import angle_words, time_words

LIMITS = ("limit_point", "limit_finite", "limit_fixed", "limit_causal")
"""In the order in which the script takes them."""


def page_data(measured: Measured[Comparison], choice: Choice) -> dict[str, Any]:
    """What the script draws from: lists of values, and indices into them.

    `pushes` are (leg speed, duration, phase, angle, four limits), the first four as indices;
    `cells` are (method, push, impulse, survived, delta_v, failure), the first two and the last as
    indices.

    Args:
        measured: what was measured.
        choice: with what the page opens.
    """
    rows, methods = measured.rows, measured.notes["methods"]
    axes = [values(rows, name) for name in ("leg_speed", "push_duration", "phase", "angle")]
    speeds, durations, phases, angles = axes
    rank = {method["key"]: index for index, method in enumerate(methods)}
    limits = {situation(row): [row.get(name, math.nan) for name in LIMITS] for row in rows}
    places = {here: index for index, here in enumerate(limits)}
    over_phases = ["worst", "mean"] if len(phases) > 1 else []
    return {
        "choices": {
            "speed": choice_of(
                speeds, [f"{one:.3g} m/s" if one < math.inf else "unlimited" for one in speeds],
                speeds.index(choice.leg_speed),
            ),
            "duration": choice_of(
                durations, [f"{one:.3g} s" for one in durations],
                durations.index(choice.push_duration),
            ),
            "phase": choice_of(
                [*phases, *over_phases], [*(f"{one:.3g}" for one in phases), *over_phases],
                phases.index(choice.phase),
            ),
        },
        "directions": DIRECTIONS,
        "failures": FAILURES,
        "angles": angles,
        "angleWords": [_angle_words(angle) for angle in angles],
        "methods": [_method(index, method) for index, method in enumerate(methods)],
        "pushes": [
            [*(axis.index(value) for axis, value in zip(axes, here, strict=True)), *own]
            for here, own in limits.items()
        ],
        "cells": [
            [
                rank[row["method"]], places[situation(row)], row["impulse"], survived(row),
                row["delta_v"], FAILURES.index(row["failure"]),
            ]
            for row in rows
        ],
    }  # fmt: skip


def _angle_words(angle: float) -> str:
    """A direction by its name, or those that it lies between."""
    if angle in DIRECTIONS.values():
        return angle_words(angle)
    names = [*DIRECTIONS, *DIRECTIONS]
    first = int(angle // 90.0)
    return f"{angle:.4g}°, between {names[first]} and {names[first + 1]}"


def _method(index: int, method: dict[str, Any]) -> dict[str, Any]:
    how = mark(index)
    return {
        **{name: method[name] for name in ("key", "label", "adapts")},
        "p50": time_words(method["decision_p50"]),
        "tail": time_words(method["decision_p99_9"]),
        "colours": f"{how.colour}, {how.dark}",
        "dashed": how.dashed,
        "outline": how.outline,
    }

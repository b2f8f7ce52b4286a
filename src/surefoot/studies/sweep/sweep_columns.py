"""The columns of a sweep's table as a picture needs them: positions, words, units, what is missing.

Values are numbers, or categories in the order in which they come: words, pairs, infinities.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import closest
from surefoot.errors import ParameterError

Row = Mapping[str, Any]

UNITS = {
    "mass": "kg", "com_height": "m", "hip": "m", "gravity": "m/s²", "foot.length": "m",
    "foot.width": "m", "swing.height": "m", "swing.landing_velocity": "m/s",
    "swing.max_speed": "m/s", "swing.max_acceleration": "m/s²", "trunk.inertia": "kg m²",
    "trunk.max_torque": "N m", "trunk.max_lean": "rad",
    "step_duration": "s", "step_x": "m", "step_y": "m", "dcm_offset": "m", "velocity": "m/s",
    "impulse": "N s", "angle": "°", "phase": "of the step", "duration": "s", "step": "",
    "dcm_noise": "m", "velocity_noise": "m/s", "delay": "s", "com_offset": "m",
    "landing_error": "m", "touchdown_shift": "s", "seed": "",
    "ankle": "", "comfort": "m", "commitment": "s", "dcm_gain": "1/s",
    "double_support": "of the step",
    "error_weight": "1/m²", "horizon": "s", "input_weight": "s⁶/m²", "lean_rate_weight": "s²/rad²",
    "knows_leg": "", "lean_weight": "1/rad²", "max_iterations": "", "offset_penalty": "1/m²",
    "offset_weight": "1/m²", "path_weight": "1/m²", "period": "s", "preview": "s",
    "project_zmp": "", "push_horizon": "s", "reserve": "m", "sample": "s", "samples": "",
    "solve_period": "s",
    "state_weight": "1/m², s²/m², s⁴/m²", "step_weight": "1/m²", "tau_weight": "–",
    "threshold": "m", "torque_weight": "1/m²", "velocity_weight": "s²/m²", "zmp_share": "–",
    "zmp_weight": "1/m²",
}  # fmt: skip
"""Unit of every parameter that a study can set, by its name without what it belongs to."""

OWN_UNITS = {
    ("unified", "step_weight"): "–",
    ("unified", "offset_weight"): "–",
}
"""Where a method has a unit of its own for a parameter that others have too."""

QUANTITIES = {
    "impulse": ("smallest push that fails", "N s"),
    "delta_v": ("smallest change of velocity that fails", "m/s"),
    "limit": ("limit for anybody", "N s"),
    "share": ("survived, as a share of the limit", "–"),
    "survived": ("survived", ""),
    "end_time": ("end of the walk", "s"),
    "steps": ("steps of the walk", ""),
    "recovery_time": ("time until settled", "s"),
    "recovery_steps": ("steps until settled", ""),
    "margin": ("least margin at a touchdown", "m"),
    "dcm_error": ("largest DCM error", "m"),
}
"""What the columns of results are called, and their units."""

NO_NUMBERS = ("outcome", "failure", "error")
"""Columns of results that hold words, or nothing."""

DIRECTIONS = {0.0: "forward", 90.0: "outward", 180.0: "back", 270.0: "inward"}
"""Of a push, as in `push.angle`."""

GEOMETRIC = 8.0
"""The largest positive value is this many times the least one if an axis may be logarithmic."""


@dataclass(frozen=True)
class Column:
    """A varied parameter.

    Attributes:
        name: in the study.
        label: with its unit.
        places: of every row on an axis; the number of its category if there are any.
        values: those that differ, in order.
        words: of these.
        numeric: whether places are the numbers themselves.
        geometric: whether an axis of them is better logarithmic.
    """

    name: str
    label: str
    places: NDArray[np.float64]
    values: NDArray[np.float64]
    words: tuple[str, ...]
    numeric: bool
    geometric: bool


def column(rows: Sequence[Row], name: str, method: str | None = None) -> Column:
    """A varied parameter of a table, in the units of this method.

    Raises:
        ParameterError: the table has no such column.
    """
    known = list(dict.fromkeys(key for row in rows for key in row))
    if name not in known:
        raise ParameterError(
            f"a column of the table for each varied parameter ({', '.join(known)})",
            f"`{name}`",
            closest(name, known, "name those of the study's [vary]"),
        )
    given = [row.get(name) for row in rows]
    both = any(isinstance(value, (list, tuple)) for value in given)
    numbers = [_number(value) for value in given]
    if not all(math.isfinite(number) for number in numbers):
        words = list(dict.fromkeys(_word(value) for value in given))
        places = np.array([words.index(_word(value)) for value in given], float)
        label = with_unit(name, _unit(name, method))
        return Column(
            name, label, places, np.arange(len(words), dtype=float), tuple(words), False, False
        )
    places = np.array(numbers)
    values = np.unique(places)
    words = tuple(number_word(value) for value in values)
    if name == "push.angle" and all(value in DIRECTIONS for value in values):
        words = tuple(DIRECTIONS[value] for value in values)
        return Column(name, name, places, values, words, True, False)
    label = with_unit(f"{name} (x and y)" if both else name, _unit(name, method))
    return Column(name, label, places, values, words, True, _is_geometric(values))


def _number(value: Any) -> float:
    """A number, also for a pair of equal ones; NaN for all else."""
    if isinstance(value, (list, tuple)) and len(value) == 2 and value[0] == value[1]:
        value = value[0]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    return math.nan


def _word(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (list, tuple)):
        return ", ".join(_word(one) for one in value)
    if isinstance(value, float):
        return number_word(value)
    return str(value)


def number_word(value: float) -> str:
    """A number as a tick says it: short, and 10000 rather than 1e+04."""
    if math.isinf(value):
        return "∞" if value > 0.0 else "-∞"
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e6 else f"{value:.4g}"


def _unit(name: str, method: str | None) -> str:
    """Of a parameter; halves of a pair have that of the whole."""
    rest = name.partition(".")[2]
    own = OWN_UNITS.get((method or "", rest.partition(".")[0]))
    if own is not None:
        return own
    while rest not in UNITS and "." in rest:
        rest = rest.rpartition(".")[0]
    return UNITS.get(rest, "")


def with_unit(words: str, unit: str) -> str:
    """A label of an axis."""
    return f"{words} [{unit}]" if unit else words


def _is_geometric(values: NDArray[np.float64]) -> bool:
    """Whether factors between the values are more even than differences; a 0 may precede them."""
    positive = values[values > 0.0]
    if len(positive) < 3 or values[0] < 0.0 or positive[-1] < GEOMETRIC * positive[0]:
        return False
    factors, differences = np.diff(np.log(positive)), np.diff(positive)
    return bool(np.std(factors) / np.mean(factors) < np.std(differences) / np.mean(differences))


@dataclass(frozen=True)
class Quantity:
    """What is drawn over the parameters.

    Attributes:
        name: of its column.
        label: with its unit.
        values: of every row; NaN where there is none, inf where nothing failed.
        whether: yes or no rather than a number.
        missing: why a row has no number, empty if it has one.
        limits: for anybody, of every row; NaN where there is none.
    """

    name: str
    label: str
    values: NDArray[np.float64]
    whether: bool
    missing: tuple[str, ...]
    limits: NDArray[np.float64]


def quantity(rows: Sequence[Row], varied: Sequence[str], name: str | None) -> Quantity:
    """What is to be drawn.

    Args:
        rows: of the table.
        varied: names of the parameters, which are no results.
        name: of a column; None for the smallest failing impulse, or for who survived.

    Raises:
        ParameterError: no rows, or no such column of numbers.
    """
    if not rows:
        raise ParameterError("a table with at least one row", "none", "measure a study first")
    keys = [key for key in dict.fromkeys(key for row in rows for key in row) if key not in varied]
    known = [key for key in keys if _has_numbers(rows, key)]
    name = name or ("impulse" if "impulse" in keys else "survived")
    if name not in known:
        raise ParameterError(
            f"a quantity of this table ({', '.join(known)})",
            f"`{name}`",
            closest(name, known, "choose one of these"),
        )
    given = [row.get(name) for row in rows]
    whether = name == "survived" or any(isinstance(value, bool) for value in given)
    bad = {"refused", "failed"}
    values = np.array(
        [
            math.nan if value is None or row.get("outcome") in bad
            or (isinstance(value, int) and not isinstance(value, bool) and value < 0)
            else float(value)
            for value, row in zip(given, rows, strict=True)
        ]
    )  # fmt: skip
    missing = tuple(
        str(row.get("outcome") or "no number") if math.isnan(value) else ""
        for value, row in zip(values, rows, strict=True)
    )
    limits = np.full(len(rows), math.nan)
    if name in ("impulse", "share"):
        one = 1.0 if name == "share" else None
        found = [_number(one if one and row.get("limit") else row.get("limit")) for row in rows]
        limits = np.where(np.isfinite(found), found, math.nan)
    words, unit = QUANTITIES.get(name, (name.replace("_", " "), ""))
    return Quantity(name, with_unit(words, unit), values, whether, missing, limits)


def _has_numbers(rows: Sequence[Row], key: str) -> bool:
    if key in NO_NUMBERS:
        return False
    values = [row.get(key) for row in rows]
    return all(value is None or isinstance(value, (bool, int, float)) for value in values)

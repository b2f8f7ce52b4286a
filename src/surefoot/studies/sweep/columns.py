"""The columns of a sweep's table as a picture needs them: positions, words, units, what is missing.

Values are numbers, or categories in the order in which they come: words, pairs, infinities.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import closest
from surefoot.dcm.pushes import DIRECTIONS
from surefoot.errors import ParameterError
from surefoot.studies.engine.cells import Row
from surefoot.studies.sweep.measure import FAILED, REFUSED, RESULTS, Result
from surefoot.studies.sweep.parameters import parameter

TYPE = {"^2": "²", "^4": "⁴", "^6": "⁶", "deg": "°", "-": "–"}
"""How a unit is written in a picture."""

GEOMETRIC = 8.0
"""The largest positive value is this many times the least one if an axis may be logarithmic."""


CONFIDENCE = 1.959964
"""Standard deviations on each side of a 95 % interval."""

MOST_VALUES = 8
"""A parameter with no more values than these has a bin for each."""

MOST_BINS, IN_A_BIN = 10, 8
"""There are no more bins than the first, and no more than give each so many cells."""


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


def column(rows: Sequence[Row], name: str, controller: str) -> Column:
    """A varied parameter of a table, in the unit that it has for this method."""
    given = [row[name] for row in rows]
    both = any(isinstance(value, (list, tuple)) for value in given)
    declared = parameter(controller, name)
    unit = declared.unit if declared is not None else ""
    numbers = [_number(value) for value in given]
    if not all(math.isfinite(number) for number in numbers):
        words = list(dict.fromkeys(_word(value) for value in given))
        places = np.array([words.index(_word(value)) for value in given], float)
        values = np.arange(len(words), dtype=float)
        return Column(name, with_unit(name, unit), places, values, tuple(words), False, False)
    places = np.array(numbers)
    values = np.unique(places)
    words = tuple(number_word(value) for value in values)
    names = {angle: way for way, angle in DIRECTIONS.items()}
    if name == "push.angle" and all(value in names for value in values):
        return Column(
            name, name, places, values, tuple(names[value] for value in values), True, False
        )
    label = with_unit(f"{name} (x and y)" if both else name, unit)
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


def with_unit(words: str, unit: str) -> str:
    """A label of an axis."""
    for written, drawn in TYPE.items():
        unit = unit.replace(written, drawn)
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
        limits: the theoretical limit of every row; NaN where there is none.
    """

    name: str
    label: str
    values: NDArray[np.float64]
    whether: bool
    missing: tuple[str, ...]
    limits: NDArray[np.float64]


def quantity_name(measure: str, asked: str | None) -> str:
    """The column that is drawn.

    Args:
        measure: of the study.
        asked: the name of a column; None for the smallest failing impulse, or for who survived.

    Raises:
        ParameterError: no such column of numbers.
    """
    known = [name for name, one in RESULTS[measure].items() if one.words]
    name = asked or known[0]
    if name not in known:
        raise ParameterError(
            f"a quantity of this table ({', '.join(known)})",
            f"`{name}`",
            closest(name, known, "choose one of these"),
        )
    return name


def quantity(rows: Sequence[Row], name: str, declared: Result) -> Quantity:
    """What is to be drawn: a column of the table, see `quantity_name`."""
    values = np.array([_result(row.get(name), row) for row in rows])
    missing = tuple(
        str(row["outcome"] or "no number") if math.isnan(value) else ""
        for value, row in zip(values, rows, strict=True)
    )
    limits = np.full(len(rows), math.nan)
    if name in ("impulse", "share"):
        known = [row.get("limit") for row in rows]
        found = [1.0 if name == "share" and one else _number(one) for one in known]
        limits = np.where(np.isfinite(found), found, math.nan)
    label = with_unit(declared.words, declared.unit)
    return Quantity(name, label, values, isinstance(declared.usual, bool), missing, limits)


def _result(value: Any, row: Row) -> float:
    """A result as a number, NaN for a cell that has none."""
    if value is None or row["outcome"] in (REFUSED, FAILED):
        return math.nan
    none = not isinstance(value, bool) and isinstance(value, int) and value < 0
    return math.nan if none else float(value)


@dataclass(frozen=True)
class Bin:
    """The cells of a range of values.

    Attributes:
        place: where it is drawn.
        members: which cells are in it.
    """

    place: float
    members: NDArray[np.bool_]


def bins(one: Column, usable: NDArray[np.bool_]) -> list[Bin]:
    """The bins of a parameter: equally many cells in each, or one for each of few values.

    Args:
        one: the parameter.
        usable: which cells have a number; at least one.
    """
    if not one.numeric or len(one.values) <= MOST_VALUES:
        made = [Bin(float(value), usable & (one.places == value)) for value in one.values]
        return [each for each in made if each.members.any()]
    order = np.flatnonzero(usable)[np.argsort(one.places[usable], kind="stable")]
    count = min(MOST_BINS, max(3, len(order) // IN_A_BIN))
    made = []
    for part in np.array_split(order, count):
        if len(part):
            members = np.zeros(len(usable), bool)
            members[part] = True
            made.append(Bin(float(np.median(one.places[part])), members))
    return made


def wilson(successes: int, count: int) -> tuple[float, float]:
    """The 95 % interval of a share after Wilson: sound for few trials, and near 0 and 1.

    Args:
        successes: of `count` trials.
        count: at least 1.
    """
    z2 = CONFIDENCE**2 / count
    share = successes / count
    middle = (share + 0.5 * z2) / (1.0 + z2)
    half = math.sqrt(z2 * share * (1.0 - share) + 0.25 * z2**2) / (1.0 + z2)
    return max(0.0, middle - half), min(1.0, middle + half)

"""The columns of a sweep's table on the axes of a picture: places, words, units, marks.

Values are numbers, or categories in the order in which they come: words, pairs, infinities. A cell
that has no number has a mark that says why.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullLocator
from numpy.typing import NDArray

from surefoot.checks import closest
from surefoot.dcm.pushes import DIRECTIONS
from surefoot.errors import ParameterError
from surefoot.show import palette
from surefoot.studies.engine.table import Row
from surefoot.studies.sweep.measure import FAILED, REFUSED, RESULTS, Result
from surefoot.studies.sweep.parameters import parameter

TYPE = {"^2": "²", "^4": "⁴", "^6": "⁶", "deg": "°", "-": "–"}
"""How a unit is written in a picture."""

GEOMETRIC = 8.0
"""The largest positive value is this many times the least one if an axis may be logarithmic."""


CONFIDENCE = 1.959964
"""Standard deviations on each side of a 95 % interval."""

MAX_VALUES = 8
"""A parameter with no more values than these has a bin for each."""

MAX_BINS, IN_A_BIN = 10, 8
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
    """The column that is drawn: the one that is `asked` for; if None, the smallest failing impulse
    or who survived.

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

    Cells that are not `usable` are in none; at least one is.
    """
    if not one.numeric or len(one.values) <= MAX_VALUES:
        made = [Bin(float(value), usable & (one.places == value)) for value in one.values]
        return [each for each in made if each.members.any()]
    order = np.flatnonzero(usable)[np.argsort(one.places[usable], kind="stable")]
    count = min(MAX_BINS, max(3, len(order) // IN_A_BIN))
    made = []
    for part in np.array_split(order, count):
        if len(part):
            members = np.zeros(len(usable), bool)
            members[part] = True
            made.append(Bin(float(np.median(one.places[part])), members))
    return made


def wilson(successes: int, count: int) -> tuple[float, float]:
    """The 95 % interval of a share after Wilson: sound for few trials, and near 0 and 1."""
    z2 = CONFIDENCE**2 / count
    share = successes / count
    middle = (share + 0.5 * z2) / (1.0 + z2)
    half = math.sqrt(z2 * share * (1.0 - share) + 0.25 * z2**2) / (1.0 + z2)
    return max(0.0, middle - half), min(1.0, middle + half)


Which = Literal["x", "y"]
Places = Sequence[float] | NDArray[np.float64]

MAX_TICKS = 8
"""With no more values than these, each has a tick of its own."""

_SIGNS = {"refused": "x", "failed": "P", "fell": "v"}
_OTHER, _ABOVE = "D", "^"
_LETTER = 0.075
"""Width of a letter of a tick [in]."""
NOTHING_FAILED = "nothing failed"


def place_axis(ax: Axes, which: Which, one: Column, length: float) -> None:
    """Scale, ticks and label of a parameter on an axis of this length [in]."""
    ax.set(**{f"{which}label": one.label})
    if not one.numeric:
        name_places(ax, which, one.values, one.words, length)
        return
    scale = getattr(ax, f"set_{which}scale")
    if one.geometric and one.values[0] > 0.0:
        scale("log")
    elif one.geometric:
        scale("symlog", linthresh=float(one.values[one.values > 0.0][0]), linscale=0.6)
    axis = getattr(ax, f"{which}axis")
    axis.set_minor_locator(NullLocator())
    if len(one.values) <= MAX_TICKS:
        _set_ticks(ax, which, one.values, one.words, length)
    elif one.geometric:
        values = _round_values(one)
        _set_ticks(ax, which, values, [number_word(value) for value in values], length)
    else:
        axis.set_major_locator(MaxNLocator(6))


def _round_values(one: Column) -> NDArray[np.float64]:
    """1, 2, 5 of every decade that a geometric parameter covers."""
    positive = one.values[one.values > 0.0]
    low, high = math.floor(math.log10(positive[0])), math.ceil(math.log10(positive[-1]))
    found = [m * 10.0**e for e in range(low, high + 1) for m in (1.0, 2.0, 5.0)]
    inside = [value for value in found if positive[0] <= value <= positive[-1]]
    return np.array(([0.0] if one.values[0] == 0.0 else []) + (inside or list(positive)))


def name_places(
    ax: Axes, which: Which, values: Places, words: Sequence[str], length: float
) -> None:
    """Ticks with words on an axis of categories, half a place of room on both sides."""
    getattr(ax, f"{which}axis").set_minor_locator(NullLocator())
    ax.set(**{f"{which}lim": (float(min(values)) - 0.5, float(max(values)) + 0.5)})
    _set_ticks(ax, which, values, words, length)


def _set_ticks(ax: Axes, which: Which, values: Places, words: Sequence[str], length: float) -> None:
    """Ticks where there is room for their words; those of categories along x are slanted first."""
    axis = getattr(ax, f"{which}axis")
    at = axis.get_transform().transform(np.asarray(values, float))
    step = length * 0.9 / (float(at.max() - at.min()) or 1.0)
    longest = max(len(word) for word in words)
    slanted = which == "x" and longest > 6 and (len(words) - 1) * (_LETTER * longest) > length
    kept: list[int] = []
    for index, place in enumerate(at):
        wide = _LETTER * max(len(words[index]), 2) if which == "x" and not slanted else 0.1
        if not kept or step * abs(place - at[kept[-1]]) >= wide + 0.06:
            kept.append(index)
    axis.set_ticks([float(values[index]) for index in kept], [words[index] for index in kept])
    if slanted:
        for label in axis.get_ticklabels():
            label.set(rotation=25, ha="right", rotation_mode="anchor")


def mark_missing(
    ax: Axes, places: NDArray[np.float64], missing: Sequence[str], colour: str, row: int, name: str
) -> None:
    """Marks above the axis for cells without a number, one row of them for each line.

    Args:
        ax: with its limits set.
        places: of the cells.
        missing: why, empty for a cell that has a number.
        colour: of the line.
        row: number of the line, from the axis upwards.
        name: of the line, for its gid.
    """
    for reason in sorted({word for word in missing if word}):
        where = [place for place, word in zip(places, missing, strict=True) if word == reason]
        _mark(
            ax, where, 0.025 + 0.04 * row, color=colour, marker=_SIGNS.get(reason, _OTHER),
            markersize=5.0, markeredgewidth=1.3, gid=f"missing-{reason}-{name}",
        )  # fmt: skip


def mark_endless(
    ax: Axes, places: NDArray[np.float64], values: NDArray[np.float64], colour: str, row: int,
    name: str,
) -> None:  # fmt: skip
    """Marks on top for cells in which nothing failed; see `mark_missing`."""
    where = places[np.isinf(values)]
    if len(where):
        _mark(
            ax, where, 0.975 - 0.04 * row, color=colour, marker=_ABOVE, markersize=6.0,
            gid=f"endless-{name}",
        )  # fmt: skip


def _mark(ax: Axes, where: Places, height: float, **look: Any) -> None:
    ax.plot(
        where, [height] * len(where), linestyle="none", clip_on=False, zorder=5.0,
        transform=ax.get_xaxis_transform(), **look,
    )  # fmt: skip


def missing_handles(missing: Sequence[str], values: NDArray[np.float64]) -> list[Line2D]:
    """What explains these marks, in grey; empty if there are none."""
    signs = {word: _SIGNS.get(word, _OTHER) for word in sorted({one for one in missing if one})}
    if np.isinf(values).any():
        signs[NOTHING_FAILED] = _ABOVE
    return [
        Line2D([], [], marker=sign, color=palette.QUIET, linestyle="none", markersize=5.5,
               markeredgewidth=1.3, label=word)
        for word, sign in signs.items()
    ]  # fmt: skip


def even_grid(ax: Axes) -> None:
    """Faint lines behind everything."""
    ax.grid(visible=True, which="major", color="#e6e6e6", linewidth=0.6, zorder=0.0)
    ax.set_axisbelow(True)


def limit_values(ax: Axes, what: Quantity, room: float, *, share: bool = False) -> None:
    """Limits along y that hold all values, from 0 on if none is below.

    Args:
        ax: whose limits are set.
        what: the quantity.
        room: beside the values, a part of what they span.
        share: whether shares are drawn of a quantity that is yes or no, and no limits.
    """
    every = what.values if share else np.concatenate([what.values, what.limits])
    every = every[np.isfinite(every)]
    if share and (what.whether or not len(every)):
        ax.set_ylim(-0.04, 1.04)
        return
    if what.whether:
        ax.set_ylim(-0.15, 1.15)
        ax.set_yticks([0.0, 1.0], ["no", "yes"])
        return
    if not share and np.isnan(what.values).all():
        ax.text(
            0.5, 0.5, "no cell has a number", transform=ax.transAxes, ha="center", va="center",
            color=palette.QUIET, gid="empty",
        )  # fmt: skip
    if not len(every):
        ax.set_yticks([])
        return
    low, high = float(every.min()), float(every.max())
    beside = room * ((high - min(low, 0.0)) or 1.0)
    ax.set_ylim(0.0 if low >= 0.0 else low - beside, high + beside)

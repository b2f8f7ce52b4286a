"""Axes of sweeps: how a parameter lies on one, and marks for the cells that have no number."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullLocator
from numpy.typing import NDArray

from surefoot.show import palette
from surefoot.studies.sweep.columns import Column, Quantity, number_word

Which = Literal["x", "y"]
Places = Sequence[float] | NDArray[np.float64]

MOST_TICKS = 8
"""With no more values than these, each has a tick of its own."""

_SIGNS = {"refused": "x", "failed": "P", "fell": "v"}
_OTHER, _ABOVE = "D", "^"
_LETTER = 0.075
"""Width of a letter of a tick [in]."""
NOTHING_FAILED = "nothing failed"


def place_axis(ax: Axes, which: Which, one: Column, length: float) -> None:
    """Scale, ticks and label of a parameter.

    Args:
        ax: whose axis it is.
        which: of its axes.
        one: the parameter.
        length: of the axis [in].
    """
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
    if len(one.values) <= MOST_TICKS:
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
    """Marks on the axis for cells without a number, one row of them for each line.

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
        ax.plot(
            where, [0.025 + 0.04 * row] * len(where), marker=_SIGNS.get(reason, _OTHER),
            markersize=5.0, linestyle="none", color=colour, markeredgewidth=1.3, clip_on=False,
            transform=ax.get_xaxis_transform(), zorder=5.0, gid=f"missing-{reason}-{name}",
        )  # fmt: skip


def mark_endless(
    ax: Axes, places: NDArray[np.float64], values: NDArray[np.float64], colour: str, row: int,
    name: str,
) -> None:  # fmt: skip
    """Marks on top for cells in which nothing failed."""
    where = places[np.isinf(values)]
    if len(where):
        ax.plot(
            where, [0.975 - 0.04 * row] * len(where), marker=_ABOVE, markersize=6.0,
            linestyle="none", color=colour, clip_on=False, transform=ax.get_xaxis_transform(),
            zorder=5.0, gid=f"endless-{name}",
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

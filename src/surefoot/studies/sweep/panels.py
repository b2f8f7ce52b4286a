"""A sweep over many parameters, or of drawn values: a panel for each parameter."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from surefoot.show import palette
from surefoot.studies.sweep.axes import (
    even_grid,
    mark_endless,
    mark_missing,
    missing_handles,
    place_axis,
    span_values,
)
from surefoot.studies.sweep.columns import Column, Quantity

CONFIDENCE = 1.959964
"""Standard deviations on each side of a 95 % interval."""

MOST_VALUES = 8
"""A parameter with no more values than these has a bin for each."""

MOST_BINS, IN_A_BIN = 10, 8
"""There are no more bins than the first, and no more than give each so many cells."""

_ACROSS, _PANEL, _TALL, _LEFT, _RIGHT, _GAP, _BELOW, _HEAD, _ROW_HEAD = (
    3, 2.45, 1.9, 0.72, 0.2, 0.3, 0.62, 0.78, 0.24,
)  # fmt: skip


def panels_size(count: int) -> tuple[float, float]:
    """Width and height of a figure of so many panels [in]."""
    across = min(count, _ACROSS)
    rows = math.ceil(count / across)
    width = _LEFT + across * _PANEL + (across - 1) * _GAP + _RIGHT
    return max(width, 5.0), _HEAD + rows * (_ROW_HEAD + _TALL + _BELOW)


def draw_panels(figure: Figure, columns: Sequence[Column], what: Quantity) -> None:
    """Draw all panels into an empty figure of `panels_size`.

    Args:
        figure: with room for a title.
        columns: the parameters.
        what: the quantity.
    """
    width, height = figure.get_size_inches()
    across = min(len(columns), _ACROSS)
    room = (width - _LEFT - _RIGHT - (across - 1) * _GAP) / across
    for number, one in enumerate(columns):
        row, place = divmod(number, across)
        left = _LEFT + place * (room + _GAP)
        bottom = height - _HEAD - (row + 1) * (_ROW_HEAD + _TALL) - row * _BELOW
        ax = figure.add_axes((left / width, bottom / height, room / width, _TALL / height))
        place_axis(ax, "x", one, room)
        even_grid(ax)
        _limit_values(ax, what)
        usable = np.isfinite(what.values)
        found = bins(one, usable) if usable.any() else []
        levels = _draw_shares(ax, one, what, found) if what.whether else _draw_numbers(
            ax, one, what, found
        )  # fmt: skip
        _name_effect(ax, one, what, levels)
        mark_missing(ax, one.places, what.missing, palette.QUIET, 0, one.name)
        mark_endless(ax, one.places, what.values, palette.QUIET, 0, one.name)
        ax.tick_params(labelleft=place == 0)
        if place == 0:
            ax.set_ylabel(f"share that {what.label}" if what.whether else what.label)
    _explain(figure, what)


def _limit_values(ax: Axes, what: Quantity) -> None:
    """The same scale in all panels."""
    finite = what.values[np.isfinite(what.values)]
    if what.whether or not len(finite):
        ax.set_ylim(-0.04, 1.04)
        return
    span_values(ax, finite, 0.08)


def _draw_shares(ax: Axes, one: Column, what: Quantity, found: Sequence[Bin]) -> list[float]:
    """How many of each bin survived, with the interval of that share."""
    shares = []
    for each in found:
        values = what.values[each.members]
        share = float(values.mean())
        low, high = wilson(int(values.sum()), len(values))
        ax.plot(
            [each.place] * 2, [low, high], color=palette.DCM, linewidth=1.3, zorder=2.0,
            gid=f"interval-{one.name}-{each.place:.6g}",
        )  # fmt: skip
        shares.append(share)
    ax.plot(
        [each.place for each in found], shares, color=palette.DCM, marker="o", markersize=5.0,
        linewidth=0.8, linestyle="solid" if one.numeric else "none", zorder=3.0,
        gid=f"share-{one.name}",
    )  # fmt: skip
    return shares


def _draw_numbers(ax: Axes, one: Column, what: Quantity, found: Sequence[Bin]) -> list[float]:
    """Every cell as a point, and the median of each bin."""
    ax.plot(
        one.places, np.where(np.isfinite(what.values), what.values, np.nan), marker="o",
        markersize=3.2, markeredgewidth=0.0, alpha=0.35, color="#777777", linestyle="none",
        zorder=2.0, gid=f"points-{one.name}",
    )  # fmt: skip
    medians = [float(np.median(what.values[each.members])) for each in found]
    ax.plot(
        [each.place for each in found], medians, color=palette.DCM, marker="D", markersize=4.5,
        linewidth=1.6, linestyle="solid" if one.numeric else "none", zorder=3.0,
        gid=f"median-{one.name}",
    )  # fmt: skip
    return medians


def _name_effect(ax: Axes, one: Column, what: Quantity, levels: Sequence[float]) -> None:
    """From where to where share or median go: how much the parameter matters."""
    if not levels:
        return
    low, high = min(levels), max(levels)
    words = f"{low:.0%} – {high:.0%}" if what.whether else f"{low:.3g} – {high:.3g}"
    ax.set_title(words, loc="right", fontsize=8.0, color=palette.DCM, pad=3.0, gid=one.name)


def _explain(figure: Figure, what: Quantity) -> None:
    handles = []
    if what.whether:
        handles.append(
            Line2D([], [], color=palette.DCM, marker="o", markersize=5.0, linewidth=1.3,
                   label="share of a bin, 95 % interval; its range over the bins on top")
        )  # fmt: skip
    else:
        handles.append(
            Line2D([], [], color="#777777", marker="o", markersize=3.5, alpha=0.6,
                   linestyle="none", label="a cell")
        )  # fmt: skip
        handles.append(
            Line2D([], [], color=palette.DCM, marker="D", markersize=4.5, linewidth=1.6,
                   label="median of a bin; its range on top")
        )  # fmt: skip
    handles += missing_handles(what.missing, what.values)
    width, height = figure.get_size_inches()
    figure.legend(
        handles=handles, loc="upper left", frameon=False, ncols=len(handles), fontsize=8.0,
        bbox_to_anchor=(0.1 / width, 1.0 - 0.48 / height), columnspacing=1.4, borderaxespad=0.0,
    )  # fmt: skip


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

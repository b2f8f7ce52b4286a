"""A sweep over many parameters, or of drawn values: a panel for each parameter."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from surefoot.show import palette
from surefoot.studies.sweep.sweep_axes import (
    even_grid,
    mark_endless,
    mark_missing,
    missing_handles,
    place_axis,
)
from surefoot.studies.sweep.sweep_bins import Bin, bins, wilson
from surefoot.studies.sweep.sweep_columns import Column, Quantity

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
    low, high = float(finite.min()), float(finite.max())
    room = 0.08 * ((high - min(low, 0.0)) or 1.0)
    ax.set_ylim(0.0 if low >= 0.0 else low - room, high + room)


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

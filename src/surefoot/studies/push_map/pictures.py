"""Pictures of a push map: direction by phase in colours, and a polar map for each phase."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.show import palette
from surefoot.show.picture_file import HALO
from surefoot.studies.engine.pictures import (
    FIXED,
    FOOT_BAND,
    LIMIT,
    MapGrid,
    add_legend,
    closed,
    headline,
)
from surefoot.studies.push_map.map_numbers import (
    QUANTITIES,
    SHARE,
    MapNumbers,
    Quantity,
    finding,
    origin,
)

HEADING = "How hard a push is survived, from any side at any time"
"""Of page and pictures."""

COLOURS = "viridis"
"""Even steps in lightness, distinct for every colour vision."""

SURVIVED = "#0072b2"

_WIDTH, _COLUMNS, _SIZE, _GAP = 12.5, 5, 2.04, 0.44

_LETTERS = 150
"""What fits into a line under the heading."""


def heat_figure(numbers: MapNumbers) -> Figure:
    """Four heat maps: what is survived, its share of the limit, and, under the hardest push that
    is survived in every cell, the steps to recover and the margin.
    """
    impulse = numbers.everywhere
    heats = [(one, numbers.shown(one, impulse)) for one in QUANTITIES]
    figure = Figure(figsize=(_WIDTH, 8.3), facecolor="white")
    _headline(figure, numbers)
    axes = figure.subplots(
        2, 2, gridspec_kw={"left": 0.055, "right": 0.975, "bottom": 0.1, "top": 0.84,
                           "hspace": 0.34, "wspace": 0.12},
    )  # fmt: skip
    for ax, (quantity, values) in zip(axes.flat, heats, strict=True):
        under = f" under {impulse:g} N s" if quantity.per_walk else ""
        title = f"{quantity.words}{under} [{quantity.unit}]"
        ax.set_title(title, loc="left", fontsize=9.5, fontweight="bold")
        _draw_heat(figure, ax, numbers, quantity, values)
    handles: list[Any] = []
    if (numbers.holes > 0).any():
        handles.append(
            Line2D([], [], linestyle="none", marker="x", color="black", markersize=5.0,
                   label="a harder push than the smallest failing one is survived")
        )  # fmt: skip
    if any(np.isnan(values).any() for _, values in heats):
        handles.append(Patch(facecolor="#d9d9d9", hatch="////", edgecolor="white",
                             label="not even the gait without a push"))  # fmt: skip
    if handles:
        add_legend(figure, handles, 2, 0.0)
    return figure


def _headline(figure: Figure, numbers: MapNumbers) -> None:
    up = 1.0 / figure.get_figheight()
    headline(figure, HEADING, size=12.5)
    for line, text in enumerate(
        ("  ·  ".join(origin(numbers)), *textwrap.wrap(finding(numbers), _LETTERS))
    ):
        figure.text(
            0.25 / _WIDTH, 1.0 - (0.42 + 0.2 * line) * up, text, fontsize=9.0, va="top",
            color=palette.QUIET,
        )  # fmt: skip


def _edges(values: NDArray[np.float64], whole: float) -> NDArray[np.float64]:
    """Half way between evenly spaced values that fill `whole`."""
    half = 0.5 * whole / len(values)
    return np.append(values - half, values[-1] + half)


def _draw_heat(
    figure: Figure, ax: Axes, numbers: MapNumbers, heat: Quantity, values: NDArray[np.float64]
) -> None:
    ax.set_facecolor("#d9d9d9")
    known = values[np.isfinite(values)]
    options: dict[str, Any] = {"cmap": COLOURS}
    if heat.whole and len(known) and np.ptp(known) <= 20:
        bounds = np.arange(known.min() - 0.5, known.max() + 1.0)
        if len(bounds) > 2:
            options["norm"] = BoundaryNorm(bounds, 256)
    elif heat.key == "share" and len(known):
        options |= {"vmin": min(SHARE, known.min()), "vmax": 100.0}
    elif len(known) and np.ptp(known) < 1e-9:
        options |= {"vmin": known[0] - 1.0, "vmax": known[0] + 1.0}
    edges = _edges(numbers.angles, 360.0), _edges(numbers.phases, 1.0)
    mesh = ax.pcolormesh(
        *edges, np.ma.masked_invalid(values),
        gid=f"heat-{heat.key}", rasterized=True, **options,
    )  # fmt: skip
    unknown = np.ma.masked_where(np.isfinite(values), np.zeros_like(values))
    if not unknown.mask.all():
        ax.pcolor(
            *edges, unknown, hatch="////", cmap="Greys", vmin=-1.0, vmax=9.0, edgecolor="white",
            linewidth=0.0,
        )  # fmt: skip
    rows, columns = np.nonzero(numbers.holes)
    ax.plot(
        numbers.angles[columns], numbers.phases[rows], "x", color="black", markersize=3.2,
        markeredgewidth=0.9, path_effects=HALO, gid=f"holes-{heat.key}",
    )  # fmt: skip
    ax.set_xticks(
        list(DIRECTIONS.values()), [f"{name}\n{angle:g}°" for name, angle in DIRECTIONS.items()]
    )
    ax.set_ylabel("phase of the step")
    bar = figure.colorbar(mesh, ax=ax, pad=0.015, fraction=0.05, aspect=26)
    bar.outline.set_visible(False)  # type: ignore[operator]
    whole = MaxNLocator(8, integer=True) if heat.whole else MaxNLocator(6)
    bar.locator = whole
    bar.update_ticks()
    bar.minorticks_off()


def polar_figure(numbers: MapNumbers) -> Figure:
    """A polar map for each phase, all to the same scale, seen from above with forward up."""
    count = len(numbers.phases)
    grid = MapGrid(_WIDTH, min(_COLUMNS, count), count, _SIZE, _GAP, 0.42, 1.3, 0.45)
    figure = grid.figure()
    _headline(figure, numbers)
    outer = max(float(numbers.limit.max()), float(numbers.survived.max()), 1.0)
    for index in range(count):
        limit = dict(zip(numbers.angles, numbers.limit[index], strict=True))
        ax = grid.add(
            figure, index, outer,
            lambda angle, limit=limit: limit[min(limit, key=lambda one: abs(one - angle))],
        )  # fmt: skip
        _draw_polar(ax, numbers, index)
    add_legend(figure, _polar_legend(numbers), 4, 0.04, handlelength=2.6)
    return figure


def _draw_polar(ax: PolarAxes, numbers: MapNumbers, index: int) -> None:
    phase = numbers.phases[index]
    ax.set_title(f"phase {phase:.3g}", loc="left", fontsize=8.5, fontweight="bold", pad=6.0)
    limit = numbers.limit[index]

    def around(values: NDArray[np.float64]) -> tuple[Any, Any]:
        return closed(numbers.angles.tolist(), values.tolist())

    survived = numbers.survived[index]
    ax.fill(*around(limit), color=FOOT_BAND, linewidth=0.0, zorder=0.9)
    ax.plot(*around(limit), color=LIMIT, linewidth=2.6, zorder=2.5, gid=f"limit-{phase:g}")
    fixed = numbers.limit_fixed[index]
    ax.plot(*around(fixed), zorder=2.3, gid=f"fixed-{phase:g}", **FIXED)
    ax.plot(
        *around(survived), color=SURVIVED, linewidth=1.3, zorder=4.0, gid=f"survived-{phase:g}",
    )  # fmt: skip
    holed = numbers.holes[index] > 0
    ax.plot(
        np.radians(numbers.angles[holed]), survived[holed], "x", color="black", markersize=3.4,
        markeredgewidth=0.9, zorder=4.5, gid=f"holes-{phase:g}",
    )  # fmt: skip


def _polar_legend(numbers: MapNumbers) -> list[Any]:
    handles: list[Any] = [
        Line2D([], [], color=SURVIVED, linewidth=1.3, label="largest survived impulse [N s]"),
        Line2D([], [], color=LIMIT, linewidth=2.6, label="theoretical limit"),
        Line2D([], [], label="limit of fixed steps", **FIXED),
    ]  # fmt: skip
    if (numbers.holes > 0).any():
        handles.append(
            Line2D([], [], color="black", linestyle="none", marker="x", markersize=4.0,
                   label="a harder push is survived again")
        )  # fmt: skip
    return handles

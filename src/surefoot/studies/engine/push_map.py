"""Push maps: how strong a push each method survives in every direction, and the limit around."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import style
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path as Outline
from matplotlib.projections.polar import PolarAxes

from surefoot.checks import check_writable
from surefoot.errors import ParameterError
from surefoot.show import palette
from surefoot.show.method_marks import Mark, mark
from surefoot.show.picture_file import marker_path, write_picture
from surefoot.studies.compare.comparison import Cell, Comparison, choose
from surefoot.studies.engine.polar_rings import draw_rings
from surefoot.studies.engine.words import speed_words

FORMATS = (".png", ".pdf", ".svg")
"""The endings that a picture's file may have."""

COARSE = 8
"""With fewer directions than these, nothing is drawn between them but a thin guide."""

FOOT_BAND = "#d7e3ea"
REACH = "#f1f5f7"
LIMIT = "#222222"

_WIDTH, _LARGEST, _GAP, _BELOW, _HEAD = 12.5, 5.4, 0.4, 0.7, 1.05
_FIXED_DASH, _LONG_DASHES = (0, (1, 1.6)), (0, (4, 1.6))
_WEDGE = math.radians(14.0)


_LOLLIPOP = Outline(
    [
        (0.0, 0.09),
        *((0.4 * math.cos(a) - 0.4, 0.4 * math.sin(a)) for a in np.linspace(0.2, 6.08, 24)),
        (0.0, -0.09),
        (1.0, -0.09),
        (1.0, 0.09),
        (0.0, 0.09),
    ],
    closed=True,
)


@dataclass(frozen=True)
class _Map:
    """One polar map.

    Attributes:
        phase: fraction of the step at which the pushes start.
        cells: what was measured there.
        angles: directions of the whole picture [deg].
        large: whether there is room for larger markers.
    """

    phase: float
    cells: Sequence[Cell]
    angles: Sequence[float]
    large: bool

    @property
    def coarse(self) -> bool:
        return len(self.angles) < COARSE

    def limits(self, name: str) -> list[float]:
        """A limit in every direction, nan where nothing was measured [N s]."""
        found = {cell.angle: getattr(cell, name) for cell in self.cells}
        return [found.get(angle, math.nan) for angle in self.angles]

    def limit_near(self, angle: float) -> float:
        """The finite-foot limit in the measured direction closest to one [N s]."""
        return min(self.cells, key=lambda cell: abs(cell.angle - angle)).limit_finite


def draw_push_map(
    measured: Comparison,
    path: Path,
    leg_speed: float | None = None,
    push_duration: float | None = None,
) -> None:
    """Draw the push maps of one leg speed and push duration into a file.

    Args:
        measured: the comparison.
        path: file to write; its ending names the format (.png, .pdf, .svg).
        leg_speed: one that was measured; 3 m/s or the closest if None [m/s].
        push_duration: one that was measured; 0.2 s or the closest if None [s].

    Raises:
        FileError: another ending, or the file cannot be written.
        ParameterError: nothing was measured there.
    """
    path = Path(path)
    check_writable(path, FORMATS)
    with style.context(["default", palette.STYLE]):
        figure = push_map_figure(measured, leg_speed, push_duration)
    write_picture(figure, path, figure.get_suptitle())


def push_map_figure(
    measured: Comparison, leg_speed: float | None = None, push_duration: float | None = None
) -> Figure:
    """One map for each phase, all to the same scale, seen from above with forward up.

    Args:
        measured: the comparison.
        leg_speed: as for `draw_push_map` [m/s].
        push_duration: as for `draw_push_map` [s].

    Returns:
        A figure of its own, not known to pyplot.

    Raises:
        ParameterError: nothing was measured there.
    """
    choice = choose(measured, leg_speed=leg_speed, push_duration=push_duration)
    cells = measured.select(leg_speed=choice.leg_speed, push_duration=choice.push_duration)
    if not cells:
        raise ParameterError(
            "a leg speed and a push duration that were measured together",
            f"{choice.leg_speed:g} m/s and {choice.push_duration:g} s",
            "choose another pair",
        )
    phases = [phase for phase in measured.phases if any(cell.phase == phase for cell in cells)]
    columns = min(len(phases), 4)
    rows = math.ceil(len(phases) / columns)
    size = min(_LARGEST, (_WIDTH - _GAP * (columns + 1)) / columns)
    handles = _legend(measured, cells)
    legend_lines = math.ceil(len(handles) / 4)
    foot = 0.12 + 0.21 * legend_lines
    height = _HEAD + rows * (size + _BELOW) + foot
    figure = Figure(figsize=(_WIDTH, height), facecolor="white")
    left = 0.5 * (_WIDTH - columns * size - (columns - 1) * _GAP)
    outer = max(max(cell.limit_finite, cell.survived) for cell in cells)
    for index, phase in enumerate(phases):
        row, column = divmod(index, columns)
        bottom = height - _HEAD - row * (size + _BELOW) - size
        place = (
            (left + column * (size + _GAP)) / _WIDTH, bottom / height,
            size / _WIDTH, size / height,
        )  # fmt: skip
        ax: PolarAxes = figure.add_axes(place, projection="polar")  # type: ignore[assignment]
        here = [cell for cell in cells if cell.phase == phase]
        _draw_map(ax, measured, _Map(phase, here, measured.angles, columns < 3), outer)
    _headline(figure, measured, choice.leg_speed, choice.push_duration)
    figure.legend(
        handles=handles, loc="lower center", ncols=4, frameon=False, handlelength=2.6,
        columnspacing=1.6, bbox_to_anchor=(0.5, 0.08 / height), borderaxespad=0.0,
    )  # fmt: skip
    return figure


def _headline(figure: Figure, measured: Comparison, leg_speed: float, push_duration: float) -> None:
    up = 1.0 / figure.get_figheight()
    robot = measured.provenance.get("robot", "")
    parts = [robot, speed_words(leg_speed), f"pushes of {push_duration:g} s"]
    figure.suptitle(
        "  ·  ".join(part for part in parts if part), x=0.25 / _WIDTH, y=1.0 - 0.14 * up,
        ha="left", va="top", fontsize=12.0, fontweight="bold",
    )  # fmt: skip
    figure.text(
        0.25 / _WIDTH, 1.0 - 0.4 * up,
        "Largest survived impulse [N s] by the direction of the push and the phase of the step at "
        "which it starts; seen from above, outward is towards the swing foot.",
        fontsize=9.0, va="top", color=palette.QUIET,
    )  # fmt: skip


def _draw_map(ax: PolarAxes, measured: Comparison, at: _Map, outer: float) -> None:
    ax.set_theta_zero_location("N")
    ax.set_rlim(0.0, 1.06 * outer)
    ax.set_title(f"phase {at.phase:.3g}", loc="left", fontsize=9.0, fontweight="bold", pad=13.0)
    draw_rings(ax, at.limit_near)
    _draw_limits(ax, at)
    # The first method lies on top.
    for index, method in reversed(list(enumerate(measured.methods))):
        cells = {cell.angle: cell for cell in at.cells if cell.method == method.key}
        if cells:
            _draw_method(ax, at, method.key, cells, mark(index), 4.0 - 0.1 * index)
    there = {cell.method for cell in at.cells}
    absent = [method.label for method in measured.methods if method.key not in there]
    if absent:
        who = absent[0] if len(absent) == 1 else f"{len(absent)} methods"
        ax.text(
            0.5, -0.1, f"not measured: {who}", transform=ax.transAxes, ha="center",
            va="top", fontsize=7.0, color=palette.QUIET, gid=f"absent-{at.phase:g}",
        )  # fmt: skip


def _closed(angles: Sequence[float], radii: Sequence[float]) -> tuple[Any, Any]:
    theta = np.radians([*angles, angles[0]])
    return theta, np.asarray([*radii, radii[0]])


def _draw_limits(ax: PolarAxes, at: _Map) -> None:
    finite, point = at.limits("limit_finite"), at.limits("limit_point")
    fixed = at.limits("limit_fixed")
    if at.coarse:
        for name, radii, options in (
            ("finite", finite, {"color": LIMIT, "linewidth": 1.6}),
            ("point", point, {"color": LIMIT, "linewidth": 0.9, "linestyle": palette.DASHES}),
            ("fixed", fixed, {"color": palette.QUIET, "linewidth": 0.9, "linestyle": _FIXED_DASH}),
        ):
            for angle, radius in zip(np.radians(at.angles), radii, strict=True):
                arc = np.linspace(angle - _WEDGE, angle + _WEDGE, 15)
                ax.plot(
                    arc, np.full(15, radius), zorder=2.5, solid_capstyle="butt",
                    gid=f"limit-{name}-{at.phase:g}-{math.degrees(angle):.4g}", **options,
                )  # fmt: skip
                if name == "finite":
                    ax.fill_between(arc, 0.0, radius, color=REACH, linewidth=0.0, zorder=1.0)
        return
    theta, outer = _closed(at.angles, finite)
    _, inner = _closed(at.angles, point)
    ax.fill(theta, outer, color=FOOT_BAND, linewidth=0.0, zorder=0.9)
    ax.fill(theta, inner, color=REACH, linewidth=0.0, zorder=1.0)
    ax.plot(theta, outer, color=LIMIT, linewidth=1.4, zorder=2.5, gid=f"limit-finite-{at.phase:g}")
    ax.plot(
        theta, inner, color=LIMIT, linewidth=0.8, linestyle=palette.DASHES, zorder=2.4,
        gid=f"limit-point-{at.phase:g}",
    )  # fmt: skip
    ax.plot(
        *_closed(at.angles, fixed), color=palette.QUIET, linewidth=0.9, linestyle=_FIXED_DASH,
        zorder=2.3, gid=f"limit-fixed-{at.phase:g}",
    )  # fmt: skip


def _draw_method(
    ax: PolarAxes, at: _Map, key: str, cells: dict[float, Cell], how: Mark, order: float
) -> None:
    """A line through the measured directions; it has a gap where one was not measured."""
    radii = [cells[angle].survived if angle in cells else math.nan for angle in at.angles]
    theta, closed = _closed(at.angles, radii)
    width = 0.6 if at.coarse else 1.1
    ax.plot(
        theta, closed, color=how.colour, linewidth=width, zorder=order,
        linestyle=palette.DOTS if at.coarse else _LONG_DASHES if how.dashed else "solid",
        gid=f"{key}-{at.phase:g}",
    )  # fmt: skip
    size = 5.0 if at.large or at.coarse else 3.6
    every = max(1, len(at.angles) // 16)
    for index, angle in enumerate(at.angles):
        if angle not in cells or index % every:
            continue
        cell = cells[angle]
        ax.plot(
            math.radians(angle), cell.survived, marker=marker_path(how),
            markersize=size, color=how.colour, markeredgewidth=0.8, zorder=order + 0.05,
            markerfacecolor="white" if cell.failure == "unsettled" else how.colour, clip_on=False,
            linestyle="none", gid=f"{key}-{at.phase:g}-{angle:g}",
        )  # fmt: skip
        if cell.unbroken:
            tip = cell.survived + 0.07 * ax.get_rmax()
            ax.plot(
                [math.radians(angle)] * 2, [cell.survived, tip], color=how.colour, zorder=order,
                linewidth=1.3, clip_on=False, gid=f"{key}-{at.phase:g}-{angle:g}-open",
            )  # fmt: skip


def _legend(measured: Comparison, cells: Sequence[Cell]) -> list[Artist]:
    coarse = len(measured.angles) < COARSE
    shown = {cell.method for cell in cells}
    handles: list[Artist] = [
        Line2D(
            [], [], color=mark(index).colour, marker=marker_path(mark(index)),
            markersize=5.0, linewidth=0.6 if coarse else 1.1, label=method.label,
            linestyle=palette.DOTS if coarse else _LONG_DASHES if mark(index).dashed else "-",
        )
        for index, method in enumerate(measured.methods)
        if method.key in shown
    ]  # fmt: skip
    handles += [
        Line2D([], [], color=LIMIT, linewidth=1.4, label="limit of any policy"),
        Line2D([], [], color=LIMIT, linewidth=0.8, linestyle=palette.DASHES,
               label="limit on a point foot"),
        Line2D([], [], color=palette.QUIET, linewidth=0.9, linestyle=_FIXED_DASH,
               label="limit of fixed steps"),
    ]  # fmt: skip
    if not coarse:
        handles.append(Patch(facecolor=FOOT_BAND, linewidth=0.0, label="what the sole adds"))
    quiet: dict[str, Any] = {"color": palette.QUIET, "linestyle": "none"}
    if any(cell.failure == "unsettled" for cell in cells):
        handles.append(
            Line2D([], [], marker="o", markersize=5.0, markerfacecolor="white",
                   label="did not settle", **quiet)
        )  # fmt: skip
    if any(cell.unbroken for cell in cells):
        handles.append(
            Line2D([], [], marker=_LOLLIPOP, markersize=12.0, label="nothing failed so far",
                   **quiet)
        )  # fmt: skip
    return handles

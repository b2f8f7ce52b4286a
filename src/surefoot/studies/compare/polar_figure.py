"""Polar maps: how strong a push each method survives in every direction, and the limit around."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path as Outline
from matplotlib.projections.polar import PolarAxes

from surefoot.errors import ParameterError
from surefoot.show import palette
from surefoot.show.palette import Mark, mark
from surefoot.show.picture_file import marker_path
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import choose, select, survived, unbroken, values
from surefoot.studies.engine.cells import Row
from surefoot.studies.engine.pictures import FIXED, FOOT_BAND, LIMIT, add_map, closed, headline
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.words import speed_words

COARSE = 8
"""With fewer directions than these, nothing is drawn between them but a thin guide."""

REACH = "#f1f5f7"

_WIDTH, _LARGEST, _GAP, _BELOW, _HEAD = 12.5, 5.4, 0.4, 0.7, 1.05
_LONG_DASHES = (0, (4, 1.6))
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
        rows: what was measured there.
        angles: directions of the whole picture [deg].
        large: whether there is room for larger markers.
    """

    phase: float
    rows: Sequence[Row]
    angles: Sequence[float]
    large: bool

    @property
    def coarse(self) -> bool:
        return len(self.angles) < COARSE

    def limits(self, name: str) -> list[float]:
        """A limit in every direction, nan where nothing was measured [N s]."""
        found = {row["angle"]: row[name] for row in self.rows}
        return [found.get(angle, math.nan) for angle in self.angles]

    def limit_near(self, angle: float) -> float:
        """The finite-foot limit in the measured direction closest to one [N s]."""
        return min(self.rows, key=lambda row: abs(row["angle"] - angle))["limit_finite"]


def polar_figure(
    measured: Measured[Comparison],
    leg_speed: float | None = None,
    push_duration: float | None = None,
) -> Figure:
    """One map for each phase, all to the same scale, seen from above with forward up.

    Args:
        measured: what was measured.
        leg_speed: one that was measured; 3 m/s or the closest if None [m/s].
        push_duration: one that was measured; 0.2 s or the closest if None [s].

    Returns:
        A figure of its own, not known to pyplot.

    Raises:
        ParameterError: nothing was measured there.
    """
    choice = choose(measured.rows, leg_speed=leg_speed, push_duration=push_duration)
    rows = select(measured.rows, leg_speed=choice.leg_speed, push_duration=choice.push_duration)
    if not rows:
        raise ParameterError(
            "a leg speed and a push duration that were measured together",
            f"{choice.leg_speed:g} m/s and {choice.push_duration:g} s",
            "choose another pair",
        )
    phases, angles = values(rows, "phase"), values(measured.rows, "angle")
    columns = min(len(phases), 4)
    lines = math.ceil(len(phases) / columns)
    size = min(_LARGEST, (_WIDTH - _GAP * (columns + 1)) / columns)
    handles = _legend(measured, rows)
    legend_lines = math.ceil(len(handles) / 4)
    foot = 0.12 + 0.21 * legend_lines
    height = _HEAD + lines * (size + _BELOW) + foot
    figure = Figure(figsize=(_WIDTH, height), facecolor="white")
    outer = max(max(row["limit_finite"], survived(row)) for row in rows)
    for index, phase in enumerate(phases):
        here = _Map(phase, select(rows, phase=phase), angles, columns < 3)
        ax = add_map(
            figure, index, columns, size=size, gap=_GAP, below=_BELOW, head=_HEAD, outer=outer,
            near=here.limit_near,
        )  # fmt: skip
        _draw_map(ax, measured, here)
    _headline(figure, measured, choice.leg_speed, choice.push_duration)
    figure.legend(
        handles=handles, loc="lower center", ncols=4, frameon=False, handlelength=2.6,
        columnspacing=1.6, bbox_to_anchor=(0.5, 0.08 / height), borderaxespad=0.0,
    )  # fmt: skip
    return figure


def _headline(
    figure: Figure, measured: Measured[Comparison], leg_speed: float, push_duration: float
) -> None:
    robot = measured.provenance.get("robot", "")
    headline(figure, robot, speed_words(leg_speed), f"pushes of {push_duration:g} s")
    figure.text(
        0.25 / _WIDTH, 1.0 - 0.4 / figure.get_figheight(),
        "Largest survived impulse [N s] by the direction of the push and the phase of the step at "
        "which it starts; seen from above, outward is towards the swing foot.",
        fontsize=9.0, va="top", color=palette.QUIET,
    )  # fmt: skip


def _draw_map(ax: PolarAxes, measured: Measured[Comparison], at: _Map) -> None:
    ax.set_title(f"phase {at.phase:.3g}", loc="left", fontsize=9.0, fontweight="bold", pad=13.0)
    _draw_limits(ax, at)
    # The first method lies on top.
    methods = measured.notes["methods"]
    for index, method in reversed(list(enumerate(methods))):
        own = {row["angle"]: row for row in select(at.rows, method=method["key"])}
        if own:
            _draw_method(ax, at, method["key"], own, mark(index), 4.0 - 0.1 * index)
    there = {row["method"] for row in at.rows}
    absent = [method["label"] for method in methods if method["key"] not in there]
    if absent:
        who = absent[0] if len(absent) == 1 else f"{len(absent)} methods"
        ax.text(
            0.5, -0.1, f"not measured: {who}", transform=ax.transAxes, ha="center",
            va="top", fontsize=7.0, color=palette.QUIET, gid=f"absent-{at.phase:g}",
        )  # fmt: skip


def _draw_limits(ax: PolarAxes, at: _Map) -> None:
    finite, point = at.limits("limit_finite"), at.limits("limit_point")
    fixed = at.limits("limit_fixed")
    if at.coarse:
        for name, radii, options in (
            ("finite", finite, {"color": LIMIT, "linewidth": 1.6}),
            ("point", point, {"color": LIMIT, "linewidth": 0.9, "linestyle": palette.DASHES}),
            ("fixed", fixed, FIXED),
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
    theta, outer = closed(at.angles, finite)
    _, inner = closed(at.angles, point)
    ax.fill(theta, outer, color=FOOT_BAND, linewidth=0.0, zorder=0.9)
    ax.fill(theta, inner, color=REACH, linewidth=0.0, zorder=1.0)
    ax.plot(theta, outer, color=LIMIT, linewidth=1.4, zorder=2.5, gid=f"limit-finite-{at.phase:g}")
    ax.plot(
        theta, inner, color=LIMIT, linewidth=0.8, linestyle=palette.DASHES, zorder=2.4,
        gid=f"limit-point-{at.phase:g}",
    )  # fmt: skip
    ax.plot(*closed(at.angles, fixed), zorder=2.3, gid=f"limit-fixed-{at.phase:g}", **FIXED)


def _draw_method(
    ax: PolarAxes, at: _Map, key: str, rows: dict[float, Row], how: Mark, order: float
) -> None:
    """A line through the measured directions; it has a gap where one was not measured."""
    radii = [survived(rows[angle]) if angle in rows else math.nan for angle in at.angles]
    around = closed(at.angles, radii)
    width = 0.6 if at.coarse else 1.1
    ax.plot(
        *around, color=how.colour, linewidth=width, zorder=order,
        linestyle=palette.DOTS if at.coarse else _LONG_DASHES if how.dashed else "solid",
        gid=f"{key}-{at.phase:g}",
    )  # fmt: skip
    size = 5.0 if at.large or at.coarse else 3.6
    every = max(1, len(at.angles) // 16)
    for index, angle in enumerate(at.angles):
        if angle not in rows or index % every:
            continue
        row, radius = rows[angle], survived(rows[angle])
        ax.plot(
            math.radians(angle), radius, marker=marker_path(how),
            markersize=size, color=how.colour, markeredgewidth=0.8, zorder=order + 0.05,
            markerfacecolor="white" if row["failure"] == "unsettled" else how.colour, clip_on=False,
            linestyle="none", gid=f"{key}-{at.phase:g}-{angle:g}",
        )  # fmt: skip
        if unbroken(row):
            tip = radius + 0.07 * ax.get_rmax()
            ax.plot(
                [math.radians(angle)] * 2, [radius, tip], color=how.colour, zorder=order,
                linewidth=1.3, clip_on=False, gid=f"{key}-{at.phase:g}-{angle:g}-open",
            )  # fmt: skip


def _legend(measured: Measured[Comparison], rows: Sequence[Row]) -> list[Artist]:
    coarse = len(values(measured.rows, "angle")) < COARSE
    shown = {row["method"] for row in rows}
    handles: list[Artist] = [
        Line2D(
            [], [], color=mark(index).colour, marker=marker_path(mark(index)),
            markersize=5.0, linewidth=0.6 if coarse else 1.1, label=method["label"],
            linestyle=palette.DOTS if coarse else _LONG_DASHES if mark(index).dashed else "-",
        )
        for index, method in enumerate(measured.notes["methods"])
        if method["key"] in shown
    ]  # fmt: skip
    handles += [
        Line2D([], [], color=LIMIT, linewidth=1.4, label="theoretical limit"),
        Line2D([], [], color=LIMIT, linewidth=0.8, linestyle=palette.DASHES,
               label="limit on a point foot"),
        Line2D([], [], label="limit of fixed steps", **FIXED),
    ]  # fmt: skip
    if not coarse:
        handles.append(Patch(facecolor=FOOT_BAND, linewidth=0.0, label="what the sole adds"))
    quiet: dict[str, Any] = {"color": palette.QUIET, "linestyle": "none"}
    if any(row["failure"] == "unsettled" for row in rows):
        handles.append(
            Line2D([], [], marker="o", markersize=5.0, markerfacecolor="white",
                   label="did not settle", **quiet)
        )  # fmt: skip
    if any(map(unbroken, rows)):
        handles.append(
            Line2D([], [], marker=_LOLLIPOP, markersize=12.0, label="nothing failed so far",
                   **quiet)
        )  # fmt: skip
    return handles

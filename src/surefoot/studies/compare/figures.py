"""Pictures of a comparison: polar maps of what is survived, shares of the limit, and times."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path as Outline
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from surefoot.errors import ParameterError
from surefoot.show import palette
from surefoot.show.palette import Mark, mark
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import choose, score, survived, unbroken
from surefoot.studies.engine.pictures import (
    FIXED,
    FOOT_BAND,
    LIMIT,
    MapGrid,
    add_legend,
    closed,
    headline,
    marked,
    panel,
)
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import Row, select, values
from surefoot.studies.engine.words import speed_words, time_words

COARSE = 8
"""With fewer directions than these, nothing is drawn between them but a thin guide."""

REACH = "#f1f5f7"

_LABELS, _ROW = 2.6, 0.34
_SHARES_WIDTH, _SHARES_HEAD, _SHARES_FOOT, _SHARES_GAP = 11.0, 0.82, 0.95, 0.2
_TICK = {"marker": "|", "markersize": 9.0, "markeredgewidth": 1.8, "zorder": 3.0}
_TIME_SHARE = 1.7
"""How much wider the plot of times is than one of fractions."""

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
    size = min(_LARGEST, (_WIDTH - _GAP * (columns + 1)) / columns)
    handles = _legend(measured, rows)
    foot = 0.12 + 0.21 * math.ceil(len(handles) / 4)
    grid = MapGrid(_WIDTH, columns, len(phases), size, _GAP, _BELOW, _HEAD, foot)
    figure = grid.figure()
    outer = max(max(row["limit_finite"], survived(row)) for row in rows)
    for index, phase in enumerate(phases):
        here = _Map(phase, select(rows, phase=phase), angles, columns < 3)
        _draw_map(grid.add(figure, index, outer, here.limit_near), measured, here)
    _headline(figure, measured, choice.leg_speed, choice.push_duration)
    add_legend(
        figure, handles, 4, 0.08, handlelength=2.6, columnspacing=1.6, borderaxespad=0.0
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
    limits = {
        "finite": {"color": LIMIT, "linewidth": 1.6 if at.coarse else 1.4, "zorder": 2.5},
        "point": {"color": LIMIT, "linewidth": 0.9 if at.coarse else 0.8, "zorder": 2.4,
                  "linestyle": palette.DASHES},
        "fixed": {"zorder": 2.3, **FIXED},
    }  # fmt: skip
    for name, options in limits.items():
        radii, gid = at.limits(f"limit_{name}"), f"limit-{name}-{at.phase:g}"
        if not at.coarse:
            around = closed(at.angles, radii)
            ax.plot(*around, gid=gid, **options)
            if name != "fixed":
                ground = (FOOT_BAND, 0.9) if name == "finite" else (REACH, 1.0)
                ax.fill(*around, color=ground[0], linewidth=0.0, zorder=ground[1])
            continue
        for angle, radius in zip(np.radians(at.angles), radii, strict=True):
            arc = np.linspace(angle - _WEDGE, angle + _WEDGE, 15)
            own = f"{gid}-{math.degrees(angle):.4g}"
            ax.plot(arc, np.full(15, radius), solid_capstyle="butt", gid=own, **options)
            if name == "finite":
                ax.fill_between(arc, 0.0, radius, color=REACH, linewidth=0.0, zorder=1.0)


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
        face = "white" if row["failure"] == "unsettled" else how.colour
        ax.plot(
            math.radians(angle), radius, linestyle="none", clip_on=False, zorder=order + 0.05,
            gid=f"{key}-{at.phase:g}-{angle:g}",
            **marked(how, markersize=size, markeredgewidth=0.8, markerfacecolor=face),
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
            [], [], linewidth=0.6 if coarse else 1.1, label=method["label"],
            linestyle=palette.DOTS if coarse else _LONG_DASHES if mark(index).dashed else "-",
            **marked(mark(index), markersize=5.0),
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


def fraction_figure(measured: Measured[Comparison]) -> Figure:
    """Mean and worst share of the limit for every leg speed; decision times beside."""
    speeds = values(measured.rows, "leg_speed")
    height = _SHARES_HEAD + _ROW * len(measured.notes["methods"]) + _SHARES_FOOT
    figure = Figure(figsize=(_SHARES_WIDTH, height), facecolor="white")
    room = _SHARES_WIDTH - _LABELS - 0.2 - _SHARES_GAP * len(speeds)
    unit = room / (len(speeds) + _TIME_SHARE)
    left = _LABELS
    for index, leg_speed in enumerate([*speeds, math.nan]):
        width = unit * (_TIME_SHARE if math.isnan(leg_speed) else 1.0)
        ax = panel(figure, left, _SHARES_FOOT, width, height - _SHARES_HEAD - _SHARES_FOOT)
        _rows(ax, measured, named=index == 0)
        if math.isnan(leg_speed):
            _draw_times(ax, measured)
        else:
            _draw_fractions(ax, measured, leg_speed)
        left += width + _SHARES_GAP
    robot = measured.provenance.get("robot", "")
    headline(figure, robot, "share of the limit, and the price")
    _add_share_legend(figure, measured)
    return figure


def _rows(ax: Axes, measured: Measured[Comparison], *, named: bool) -> None:
    methods = measured.notes["methods"]
    count = len(methods)
    ax.set_ylim(count - 0.5, -0.5)
    ax.set_yticks(range(count))
    ax.tick_params(axis="y", length=0.0, labelleft=named)
    ax.set_yticklabels([method["label"] for method in methods], fontsize=8.5)
    ax.spines["left"].set_visible(False)
    ax.set_axisbelow(True)
    for row in range(0, count, 2):
        ax.axhspan(row - 0.5, row + 0.5, color="#f4f6f7", linewidth=0.0, zorder=0.0)
    ax.grid(axis="x", color="#dedede", linewidth=0.5)


def _draw_fractions(ax: Axes, measured: Measured[Comparison], leg_speed: float) -> None:
    ax.set_title(
        speed_words(leg_speed).replace("leg speed", "leg").replace("unlimited leg", "any speed"),
        fontsize=9.0, fontweight="bold",
    )  # fmt: skip
    ax.set_xlim(0.0, 104.0)
    ax.set_xticks([0, 50, 100])
    ax.set_xticks([25, 75], minor=True)
    ax.set_xticklabels(["0", "50", "100"])
    ax.set_xlabel("% of the limit", fontsize=8.0)
    ax.axvline(100.0, color="#222222", linewidth=1.2, zorder=1.0)
    rows = select(measured.rows, leg_speed=leg_speed)
    for row, method in enumerate(measured.notes["methods"]):
        key, how = method["key"], mark(row)
        found = score(key, rows)
        if not found.cells:
            ax.text(
                50.0, row, "not measured", ha="center", va="center", fontsize=7.0,
                color=palette.QUIET, gid=f"absent-{key}-{leg_speed:g}",
            )  # fmt: skip
            continue
        mean, worst = 100.0 * found.mean, 100.0 * found.worst
        ax.plot(
            [worst, mean], [row, row], color=how.colour, linewidth=2.2, zorder=2.0,
            linestyle="solid" if found.complete else palette.DOTS, solid_capstyle="butt",
        )  # fmt: skip
        ax.plot(worst, row, color=how.colour, gid=f"worst-{key}-{leg_speed:g}", **_TICK)
        face = how.colour if found.complete else "white"
        ax.plot(
            mean, row, zorder=3.0, gid=f"mean-{key}-{leg_speed:g}", clip_on=False,
            **marked(how, markersize=7.5, markerfacecolor=face),
        )  # fmt: skip
        if not found.complete:
            ax.text(
                min(mean + 7.0, 90.0) if mean < 75.0 else worst - 7.0, row,
                f"{found.cells} of {found.possible}", fontsize=6.5, va="center",
                ha="left" if mean < 75.0 else "right", color=palette.QUIET,
                gid=f"partial-{key}-{leg_speed:g}",
            )  # fmt: skip


def _draw_times(ax: Axes, measured: Measured[Comparison]) -> None:
    ax.set_title("time per control cycle", fontsize=9.0, fontweight="bold")
    times = [
        value
        for method in measured.notes["methods"]
        for value in (method["decision_p50"], method["decision_p99_9"], method["period"])
        if math.isfinite(value) and value > 0.0
    ]
    ax.set_xscale("log")
    if times:
        ax.set_xlim(
            10.0 ** math.floor(math.log10(min(times)) - 0.1),
            10.0 ** math.ceil(math.log10(max(times)) + 0.1),
        )
    ax.xaxis.set_major_locator(LogLocator(base=10.0, numticks=12))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: _decade(value)))
    for row, method in enumerate(measured.notes["methods"]):
        how, key = mark(row), method["key"]
        p50, tail = method["decision_p50"], method["decision_p99_9"]
        ax.plot([method["period"]] * 2, [row - 0.5, row + 0.5], color="#222222", linewidth=1.2)
        if math.isnan(p50):
            ax.text(
                0.4, row, "not measured", ha="center", va="center", fontsize=7.0,
                color=palette.QUIET, transform=ax.get_yaxis_transform(),
            )  # fmt: skip
            continue
        ax.plot([p50, tail], [row, row], color=how.colour, linewidth=2.2, zorder=2.0)
        ax.plot(p50, row, zorder=3.0, gid=f"p50-{key}", **marked(how, markersize=7.5))
        ax.plot(tail, row, color=how.colour, gid=f"p99.9-{key}", **_TICK)


def _decade(value: float) -> str:
    """The name of 1 ns, 1 µs, 1 ms, 1 s; the decades between have none."""
    exponent = round(math.log10(value))
    return time_words(10.0**exponent * (1.0 + 1e-9)) if exponent % 3 == 0 else ""


def _add_share_legend(figure: Figure, measured: Measured[Comparison]) -> None:
    quiet = palette.QUIET
    shape = {"color": quiet, "markersize": 7.0, "linestyle": "none"}
    handles = [
        Line2D([], [], marker="o", label="mean share of the limit; median time", **shape),
        Line2D([], [], marker="|", markeredgewidth=1.8, label="worst cell; p99.9", **shape),
        Line2D([], [], color="#222222", linewidth=1.2, label="the limit; the control period"),
    ]
    partial = any(
        not score(method["key"], select(measured.rows, leg_speed=speed)).complete
        for method in measured.notes["methods"]
        for speed in values(measured.rows, "leg_speed")
    )
    if partial:
        handles.append(
            Line2D([], [], marker="o", markerfacecolor="white",
                   label="measured on fewer cells: means do not compare directly", **shape)
        )  # fmt: skip
    add_legend(figure, handles, len(handles), 0.12, columnspacing=1.6)

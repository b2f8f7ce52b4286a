"""How much of the limit each method reaches, and what a decision costs."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from surefoot.show import palette
from surefoot.show.palette import mark
from surefoot.show.picture_file import marker_path
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import score, select, values
from surefoot.studies.engine.pictures import headline
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.words import speed_words, time_words

_WIDTH, _LABELS, _ROW, _HEAD, _FOOT, _GAP = 11.0, 2.6, 0.34, 0.82, 0.95, 0.2
_TIME_SHARE = 1.7
"""How much wider the plot of times is than one of fractions."""


def fraction_figure(measured: Measured[Comparison]) -> Figure:
    """Mean and worst share of the limit for every leg speed; decision times beside.

    Args:
        measured: what was measured.

    Returns:
        A figure of its own, not known to pyplot.
    """
    speeds = values(measured.rows, "leg_speed")
    height = _HEAD + _ROW * len(measured.notes["methods"]) + _FOOT
    figure = Figure(figsize=(_WIDTH, height), facecolor="white")
    room = _WIDTH - _LABELS - 0.2 - _GAP * len(speeds)
    unit = room / (len(speeds) + _TIME_SHARE)
    left = _LABELS
    for index, leg_speed in enumerate([*speeds, math.nan]):
        width = unit * (_TIME_SHARE if math.isnan(leg_speed) else 1.0)
        box = (left / _WIDTH, _FOOT / height, width / _WIDTH, 1.0 - (_HEAD + _FOOT) / height)
        ax = figure.add_axes(box)
        _rows(ax, measured, named=index == 0)
        if math.isnan(leg_speed):
            _draw_times(ax, measured)
        else:
            _draw_fractions(ax, measured, leg_speed)
        left += width + _GAP
    robot = measured.provenance.get("robot", "")
    headline(figure, robot, "share of the limit, and the price")
    _explain(figure, measured)
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
        ax.plot(
            worst, row, marker="|", color=how.colour, markersize=9.0, markeredgewidth=1.8,
            zorder=3.0, gid=f"worst-{key}-{leg_speed:g}",
        )  # fmt: skip
        ax.plot(
            mean, row, marker=marker_path(how), color=how.colour,
            markersize=7.5, zorder=3.0, gid=f"mean-{key}-{leg_speed:g}",
            markerfacecolor=how.colour if found.complete else "white", clip_on=False,
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
        ax.plot(
            p50, row, marker=marker_path(how), color=how.colour,
            markersize=7.5, zorder=3.0, gid=f"p50-{key}",
        )  # fmt: skip
        ax.plot(
            tail, row, marker="|", color=how.colour, markersize=9.0, markeredgewidth=1.8,
            zorder=3.0, gid=f"p99.9-{key}",
        )  # fmt: skip


def _decade(value: float) -> str:
    """The name of 1 ns, 1 µs, 1 ms, 1 s; the decades between have none."""
    exponent = round(math.log10(value))
    return time_words(10.0**exponent * (1.0 + 1e-9)) if exponent % 3 == 0 else ""


def _explain(figure: Figure, measured: Measured[Comparison]) -> None:
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
    figure.legend(
        handles=handles, loc="lower center", ncols=len(handles), frameon=False,
        columnspacing=1.6, bbox_to_anchor=(0.5, 0.12 / figure.get_figheight()),
    )  # fmt: skip

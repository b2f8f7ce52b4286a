"""The figures of [OnlineGait], drawn from our own walks to be laid beside the printed ones."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch, Rectangle

from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.page import LINE, Extent
from surefoot.show.plotted_walk import PlottedWalk
from surefoot.show.stances import Stance, broken
from surefoot.show.time_plots import Panel, draw_time_plots, panels
from surefoot.show.top_view import draw_top_view, extent
from surefoot.show.walk_events import label_places
from surefoot.show.walk_figure import legend_entries
from surefoot.studies.engine.pictures import add_box, headline
from surefoot.studies.reproduce.walks import paper_walk

_WIDTH, _LEFT, _RIGHT, _HEAD, _FOOT, _GAP, _NUMBERS = 9.0, 0.78, 0.15, 0.4, 0.5, 0.14, 0.2
"""Of a picture, and the free space around its parts [in]."""

_ROOM, _ROW, _COLUMNS = _WIDTH - _LEFT - _RIGHT, 0.21, 4
"""Width of a plot, height of a row of the legend [in], and its columns."""

_IN_TIME = ("both soles", "deciding online", "limits; settled")
_FROM_ABOVE = ("landing decided", "nominal landing", "limits; settled")
_NOT_DECIDED = (*_FROM_ABOVE, "CoM", "DCM", "ZMP", "planned DCM", "left sole", "right sole")
_NOT_VELOCITY = (*_FROM_ABOVE, "DCM", "ZMP", "planned DCM", "left sole", "right sole")
"""Entries of a walk's legend that stand for nothing in a top view, and in plots over time."""

BOUNDS, PLAN = "#e4efe9", "#d6749b"
"""Colours of what a decision is free to be, and of the planned ZMP."""

CLOCK_WORDS = (
    "How long a decision takes is measured on the clock of the machine and differs from run to "
    "run, so that picture lies beside this page and is no part of it"
)


View = tuple[str, Rollout, Extent | None]
"""A title, a walk, and the part of the ground that is enlarged, None for all of it."""


def _top_views(views: Sequence[View], extra: Sequence[Artist] = ()) -> tuple[Figure, list[Axes]]:
    """Walks from above, below each other; `extra` entries of the legend."""
    boxes, down = [], 0.0
    for _, walk, part in views:
        shown = part or extent(PlottedWalk(walk))
        height = _ROOM * shown.size[1] / shown.size[0]
        lines = [] if part else [line for *_, line in label_places(walk, shown, _ROOM)]
        words = LINE * (max(lines, default=-1) + 1)
        boxes.append((shown, down + _HEAD + words, height, words))
        down += _HEAD + words + height + _FOOT
    figure, axes = _with_legend(down, [*_entries(views[0][1], _IN_TIME), *extra]), []
    for (title, walk, part), (shown, top, height, words) in zip(views, boxes, strict=True):
        ax = add_box(figure, _LEFT, top, _ROOM, height)
        draw_top_view(ax, PlottedWalk(walk), shown, labelled=part is None)
        ax.set_title(title, loc="left", fontsize=9.5, fontweight="bold", pad=6.0 + 72.0 * words)
        axes.append(ax)
    return figure, axes


def _time_plots(
    title: str, walks: Sequence[tuple[Rollout, Sequence[Panel]]], legend: Sequence[Artist]
) -> Figure:
    """Plots of walks over time, below each other."""
    heights = [sum(panel.height + _GAP for panel in some) + _FOOT for _, some in walks]
    figure, top = _with_legend(_HEAD + _NUMBERS + sum(heights), legend), _HEAD + _NUMBERS
    for walk, some in walks:
        axes = []
        for panel in some:
            axes.append(add_box(figure, _LEFT, top, _ROOM, panel.height))
            top += panel.height + _GAP
        draw_time_plots(axes, PlottedWalk(walk), some)
        top += _FOOT
    headline(figure, title, left=_LEFT, down=0.12, size=9.5)
    return figure


def _with_legend(height: float, entries: Sequence[Artist]) -> Figure:
    """A picture with a legend below the given height [in]."""
    total = height + _ROW * math.ceil(len(entries) / _COLUMNS) + 0.1
    figure = Figure(figsize=(_WIDTH, total), facecolor="white")
    figure.legend(
        handles=[*entries], loc="upper left", ncols=_COLUMNS, frameon=False, handlelength=2.0,
        bbox_to_anchor=(_LEFT / _WIDTH, 1.0 - height / total), borderaxespad=0.0,
    )  # fmt: skip
    return figure


def _entries(walk: Rollout, without: tuple[str, ...]) -> list[Artist]:
    """The legend of a walk, without entries that begin so."""
    found = legend_entries(PlottedWalk(walk))
    return [one for one in found if not str(one.get_label()).startswith(without)]


def _line(label: str, colour: str, **look: Any) -> Line2D:
    return Line2D([], [], label=label, color=colour, **look)


def draw_fig_4(robot: Robot) -> Figure:
    """Plan and footholds for two velocities; undisturbed, DCM and ZMP are those of the plan."""
    views: list[View] = []
    for walk in (paper_walk(robot, "fig-4a"), paper_walk(robot, "fig-4b")):
        length = np.mean([step.step[0] for step in walk.footsteps])
        words = f"T = {walk.footsteps[-1].duration:.3f} s, X = {length:.3f} m"
        x, y = walk.velocity
        views.append((f"v = ({x:g}, {y:g}) m/s:  {words}", walk, None))
    return _top_views(views)[0]


def draw_fig_5(robot: Robot) -> Figure:
    """Tracking under a small push, with a part of it enlarged; the plan is the walk of Fig. 4."""
    walk, plan = paper_walk(robot, "fig-5"), paper_walk(robot, "fig-4a")
    part = Extent((0.3, -0.17), (1.0, -0.02))
    title = "DCM tracking with continuous double support, 40 N in +x from 0.5 s for 0.8 s"
    rings: dict[str, Any] = {
        "marker": "o",
        "linestyle": "none",
        "markeredgecolor": palette.DCM_PLAN,
    }
    figure, axes = _top_views(
        [(title, walk, None), ("enlarged: the rectangle above", walk, part)],
        [
            _line(r"$p^{plan}$", PLAN, linewidth=2.6),
            _line(r"$\xi_{ini}$, $\xi_{end}$ of double support", "white", markersize=4.5, **rings),
        ],
    )
    edges = np.flatnonzero(np.diff(walk.commands["double_support"])) + 1
    for ax in axes:
        ax.plot(*plan.zmp.T, color=PLAN, linewidth=2.6, zorder=2.5)
        ax.plot(*walk.dcm_plan[edges].T, color="white", markersize=3.6, zorder=5.0, **rings)
    frame = Rectangle(part.low, *part.size, fill=False, linewidth=0.9, zorder=6.0)
    axes[0].add_patch(frame)
    return figure


def draw_fig_8(robot: Robot) -> Figure:
    """Tracking under a large push: the ZMP leaves the support polygon."""
    walk = paper_walk(robot, "fig-8")
    out = np.flatnonzero(walk.zmp_excess > 0.0)
    title = "DCM tracking alone, 142 N in +x from 1.0 s for 0.2 s"
    if len(out):
        title += (
            f": $p_c$ outside from {walk.time[out[0]]:.3f} s to {walk.time[out[-1]]:.3f} s, "
            f"by up to {1e3 * walk.zmp_excess.max():.0f} mm"
        )
    return _top_views([(title, walk, None)])[0]


def draw_fig_9(robot: Robot) -> Figure:
    """The hybrid controller takes the push with one step."""
    walk = paper_walk(robot, "fig-9")
    third = walk.footsteps[2]
    title = (
        "hybrid, 176 N in +x at 1.1 s for 0.2 s: the third step is "
        f"{third.step[0]:.2f} m long and takes {third.duration:.3f} s"
    )
    return _top_views([(title, walk, None)])[0]


def draw_fig_10(robot: Robot) -> Figure:
    """The DCM over time."""
    walk = paper_walk(robot, "fig-9")
    title = "DCM of the hybrid controller, 176 N in +x at 1.1 s for 0.2 s"
    return _time_plots(title, [(walk, panels(walk)[:2])], _entries(walk, _FROM_ABOVE))


def draw_fig_11(robot: Robot) -> Figure:
    """Several steps bring the offset back; circles cover the offset at the end of each step."""
    walk, dashes = paper_walk(robot, "fig-11"), (0, (2.5, 2))
    figure, (ax,) = _top_views(
        [
            (
                "hybrid with a small weight on d, 411.6 N in +x at 1.1 s for 0.2 s: "
                "d returns over several steps",
                walk,
                None,
            )
        ],
        [_line("offset d at touchdown", palette.ALARM, linestyle=dashes, linewidth=1.2)],
    )
    for step in walk.footsteps[1:9]:
        offset, end = np.array(step.dcm_offset), np.add(step.landing, step.dcm_offset)
        x, y = np.add(step.landing, 0.5 * offset).tolist()
        ax.add_patch(
            Ellipse(
                (x, y), float(np.hypot(*offset)) + 0.05, 0.075, fill=False, zorder=5.0,
                angle=float(np.degrees(np.arctan2(offset[1], offset[0]))),
                edgecolor=palette.ALARM, linewidth=1.2, linestyle=dashes,
            )
        )  # fmt: skip
        ax.plot(
            *np.array([step.landing, end]).T, color=palette.ALARM, linewidth=1.0, marker=".",
            markersize=3.5, zorder=5.1,
        )  # fmt: skip
    return figure


def draw_fig_12(robot: Robot) -> Figure:
    """The CoM velocity over time, and the command."""
    walk = paper_walk(robot, "fig-11")
    dots = {"linewidth": 0.9, "linestyle": palette.DOTS}

    def draw(ax: Axes, plotted: PlottedWalk) -> None:
        rollout = plotted.rollout
        axis = "xy".index(str(ax.get_gid()))
        ax.axhline(rollout.velocity[axis], color=palette.QUIET, **dots)
        ax.plot(rollout.time, rollout.com_velocity[:, axis], color=palette.COM, linewidth=1.3)
        ax.set_ylabel(rf"$\dot{{{ax.get_gid()}}}$ [m/s]")

    some = [Panel(name, 1.7, draw) for name in "xy"]
    entries = [_line("commanded velocity", palette.QUIET, **dots), *_entries(walk, _NOT_VELOCITY)]
    return _time_plots("CoM velocity, 411.6 N in +x at 1.1 s for 0.2 s", [(walk, some)], entries)


_LABELS = ("T [s]", "X [m]", "Y + s hip [m]", r"$\tau$ [-]", r"$d_x$ [m]", r"$d_y$ [m]")


def draw_adaptation(name: str, figure: str, robot: Robot) -> Figure:
    """Step duration, step vector, tau and DCM offset as decided in every cycle of a walk."""
    walk = paper_walk(robot, name)
    some = [
        Panel(label, 1.05, partial(_draw_decided, index)) for index, label in enumerate(_LABELS)
    ]
    entries = [
        _line("planned", palette.COM, linewidth=1.4),
        _line("decided online", palette.ADAPTED, linewidth=2.4),
        _line("nominal", palette.DCM_PLAN, linewidth=1.0, linestyle="dashed"),
        Patch(facecolor=BOUNDS, edgecolor=palette.ZMP, linewidth=0.7, label="within bounds"),
        *_entries(walk, _NOT_DECIDED),
    ]
    title = f"{figure}: what is decided in every cycle, within its bounds"
    return _time_plots(title, [(walk, some)], entries)


def _draw_decided(index: int, ax: Axes, walk: PlottedWalk) -> None:
    """One of the decisions: T, X, Y + s hip, tau, d_x, d_y."""
    rollout, parts = walk.rollout, walk.parts
    commands, time = rollout.commands, broken(rollout.time, parts)
    duration, step = commands["step_duration"], commands["step_location"] - rollout.support_foot
    tau = np.exp(rollout.robot.omega * duration)
    decided = np.column_stack([duration, step, tau, commands["dcm_offset"]])[:, index]
    for part in parts:
        _draw_bounds(ax, rollout, part, index)
    look = {"color": palette.COM, "linewidth": 1.4, "zorder": 3.0}
    ax.plot(time, broken(decided, parts), **look)
    online = np.where(rollout.adapting, decided, np.nan)
    look = {"color": palette.ADAPTED, "linewidth": 2.4, "zorder": 3.1}
    ax.plot(time, broken(online, parts), **look)
    ax.set_ylabel(_LABELS[index])


def _draw_bounds(ax: Axes, rollout: Rollout, part: Stance, index: int) -> None:
    robot = rollout.robot
    low, high = robot.gait.step_box(part.side, robot.hip)
    shortest, longest = robot.gait.step_duration
    tau = np.exp(robot.omega * np.array([shortest, longest]))
    d_x, d_y = robot.gait.dcm_offset
    bounds = [
        (shortest, longest), (low[0], high[0]), (low[1], high[1]), (tau[0], tau[1]),
        (-d_x, d_x), (-d_y, d_y),
    ]  # fmt: skip
    edge, nominal = bounds[index], None
    if part.gait is not None:
        gait = part.gait
        step, offset = gait.step(part.side), gait.dcm_offset(part.side)
        nominal = (gait.step_duration, *step, gait.growth, *offset)[index]
        if index >= 4:
            # The controller widens its bounds so that they hold the nominal offset.
            edge = (min(edge[0], nominal), max(edge[1], nominal))
    time = np.linspace(part.start, part.end, 40)
    least = np.full_like(time, edge[0])
    if index in (0, 3):
        # A step cannot have ended before now, T > t.
        elapsed = time - part.start
        least = np.maximum(least, elapsed if index == 0 else np.exp(robot.omega * elapsed))
    ax.fill_between(time, least, edge[1], facecolor=BOUNDS, edgecolor=palette.ZMP,
                    linewidth=0.7, zorder=0.3)  # fmt: skip
    if nominal is not None:
        ax.hlines(nominal, part.start, part.end, color=palette.DCM_PLAN, linewidth=1.0,
                  linestyle="dashed", zorder=2.5)  # fmt: skip


def draw_decision_time(robot: Robot) -> Figure:
    """How long every decision took on this machine; wall clock, different in every run."""
    entries = [
        _line(label, colour, marker=".", linestyle="none")
        for colour, label in ((palette.COM, "tracking"), (palette.ADAPTED, "deciding the step"))
    ]
    entries.append(_line("period", palette.ALARM, linewidth=0.9, linestyle=palette.DASHES))
    walks = [
        (paper_walk(robot, name), [Panel(words, 1.7, _draw_decision_time)])
        for name, words in (("fig-9", "Fig. 9"), ("fig-11", "Fig. 11"))
    ]
    title = "decision time per cycle (the control period is 1000 µs)"
    return _time_plots(title, walks, entries)


def _draw_decision_time(ax: Axes, walk: PlottedWalk) -> None:
    rollout = walk.rollout
    micros, deciding = 1e6 * rollout.decision_time, rollout.adapting
    for chosen, colour in ((~deciding, palette.COM), (deciding, palette.ADAPTED)):
        ax.semilogy(rollout.time[chosen], micros[chosen], ".", color=colour, markersize=2.0)
    ax.set_ylim(1.0, 3000.0)
    ax.set_yticks([1.0, 10.0, 100.0, 1000.0], ["1", "10", "100", "1000"])
    ax.minorticks_off()
    ax.axhline(1000.0, color=palette.ALARM, linewidth=0.9, linestyle=palette.DASHES)
    ax.set_ylabel(f"{ax.get_gid()} [µs]")
    middle, slow = np.percentile(micros, (50, 99))
    ax.text(
        0.99, 0.66, f"median {middle:.0f} µs, 99 % below {slow:.0f} µs", ha="right", va="top",
        transform=ax.transAxes, fontsize=8.5,
    )  # fmt: skip


PICTURES: dict[str, tuple[str, Callable[[Robot], Figure]]] = {
    "fig-4": (
        "Fig. 4: DCM plan and footholds at two walking velocities.",
        draw_fig_4,
    ),
    "fig-5": (
        "Fig. 5: the plan modified by feedback; 40 N in +x from 0.5 s for 0.8 s.",
        draw_fig_5,
    ),
    "fig-8": (
        "Fig. 8: DCM feedback alone under a large push; 142 N in +x from 1.0 s for 0.2 s.",
        draw_fig_8,
    ),
    "fig-9": (
        "Fig. 9: the hybrid controller; 176 N in +x at 1.1 s for 0.2 s, and small pushes.",
        draw_fig_9,
    ),
    "fig-10": (
        "Fig. 10: the DCM of Fig. 9 in x and y; yellow: the push.",
        draw_fig_10,
    ),
    "fig-9-adaptation": (
        "Beside Figs. 9 and 10: what the step decides, against its bounds.",
        partial(draw_adaptation, "fig-9", "Fig. 9"),
    ),
    "fig-11": (
        "Fig. 11: 411.6 N in +x at 1.1 s for 0.2 s; dashed circles: the DCM offset d.",
        draw_fig_11,
    ),
    "fig-12": (
        "Fig. 12: the CoM velocity of Fig. 11 in x and y.",
        draw_fig_12,
    ),
    "fig-11-adaptation": (
        "Beside Figs. 11 and 12: what the step decides, against its bounds.",
        partial(draw_adaptation, "fig-11", "Fig. 11"),
    ),
    "decision-time": (
        CLOCK_WORDS,
        draw_decision_time,
    ),
}
"""What each picture shows, in the order of the paper, and how it is drawn; the same walks make the
same pictures, but for the decision time."""

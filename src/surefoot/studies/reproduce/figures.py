"""The figures of [OnlineGait], drawn from our own walks to be laid beside the printed ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch, Rectangle
from numpy.typing import NDArray

from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.stances import broken, stances
from surefoot.show.walk_events import shade_push_in_time
from surefoot.studies.reproduce.adaptation import adaptation_figure, decision_time_figure
from surefoot.studies.reproduce.axes import (
    add_legend,
    draw_curve,
    draw_soles,
    ground_figure,
    line_style,
    number_steps,
    paths,
    push_patch,
    shade_push_in_space,
    sole_patches,
    time_figure,
)

Walks = Mapping[str, Rollout]
"""The walks of `question.paper_rollouts`, by the name of their figure."""

CLOCK_WORDS = (
    "How long a decision takes is measured on the clock of the machine and differs from run to "
    "run, so that picture lies beside this page and is no part of it"
)


def draw_fig_4(first: Rollout, second: Rollout) -> Figure:
    """Plan and footholds for two velocities."""
    walks = (first, second)
    titles = []
    for walk in walks:
        step = walk.footsteps[-1]
        length = np.mean([step.step[0] for step in walk.footsteps])
        titles.append(
            f"v = ({walk.velocity[0]:g}, {walk.velocity[1]:g}) m/s:  T = {step.duration:.3f} s, "
            f"X = {length:.3f} m"
        )
    figure, axes = ground_figure(titles, (-0.35, -0.22), (2.25, 0.4))
    for ax, walk in zip(axes, walks, strict=True):
        parts = draw_soles(ax, walk)
        # Undisturbed, DCM and ZMP are those of the plan.
        draw_curve(ax, "zmp_plan", walk.zmp)
        draw_curve(ax, "dcm_plan", walk.dcm_plan, linestyle="solid")
        landed = [part.samples.start for part in parts]
        ax.plot(*walk.dcm_plan[landed].T, "o", color="white", markersize=3.8,
                markeredgecolor=palette.DCM_PLAN, zorder=5.0)  # fmt: skip
    ring = Line2D([], [], marker="o", color="white", markeredgecolor=palette.DCM_PLAN,
                  linestyle="none", label="at touchdown", markersize=4.5)  # fmt: skip
    add_legend(figure, ("zmp_plan",), [_plan_line(), ring, *sole_patches()])
    return figure


def _plan_line() -> Line2D:
    return Line2D([], [], color=palette.DCM_PLAN, linewidth=1.3, label=r"$\xi^{plan}$")


def draw_fig_5(walk: Rollout, plan: Rollout) -> Figure:
    """Tracking under a small push, with a part of it enlarged."""
    figure, (top, inset) = ground_figure(
        ["", "enlarged: the rectangle above"], (-0.35, -0.2), (1.75, 0.2)
    )
    top.set_title(
        "DCM tracking with continuous double support, 40 N in +x from 0.5 s for 0.8 s",
        loc="left", fontsize=9.5, fontweight="bold",
    )  # fmt: skip
    box = ((0.3, -0.165), (1.0, -0.03))
    for ax in (top, inset):
        parts = draw_soles(ax, walk, numbered=ax is top)
        shade_push_in_space(ax, walk)
        draw_curve(ax, "zmp_plan", plan.zmp)
        draw_curve(ax, "dcm_plan", plan.dcm_plan)
        curves = paths(walk, parts)
        draw_curve(ax, "zmp", walk.zmp)
        draw_curve(ax, "dcm", curves["dcm"])
        _mark_transitions(ax, walk)
    (low, high) = box
    inset.set_xlim(low[0], high[0])
    inset.set_ylim(low[1], high[1])
    inset.set_aspect("equal", adjustable="box")
    top.add_patch(
        Rectangle(low, high[0] - low[0], high[1] - low[1], fill=False, edgecolor="black",
                  linewidth=0.9, zorder=6.0)
    )  # fmt: skip
    add_legend(
        figure, ("dcm", "dcm_plan", "zmp", "zmp_plan"), [_transition_mark(), push_patch(walk)]
    )
    return figure


def _mark_transitions(ax: Axes, walk: Rollout) -> None:
    """Where double support begins and ends on the planned DCM, the paper's ini and end."""
    shared = walk.commands["double_support"]
    edges = np.flatnonzero(np.diff(shared)) + 1
    ax.plot(*walk.dcm_plan[edges].T, "o", color="white", markersize=3.6, zorder=5.0,
            markeredgecolor=palette.DCM_PLAN, markeredgewidth=1.0)  # fmt: skip


def _transition_mark() -> Line2D:
    return Line2D(
        [], [], marker="o", color="white", markeredgecolor=palette.DCM_PLAN, linestyle="none",
        markersize=4.5, label=r"$\xi_{ini}$, $\xi_{end}$ of double support",
    )  # fmt: skip


def draw_fig_8(walk: Rollout) -> Figure:
    """Tracking under a large push: the ZMP leaves the support polygon."""
    out = np.flatnonzero(walk.zmp_excess > 0.0)
    title = "DCM tracking alone, 142 N in +x from 1.0 s for 0.2 s"
    if len(out):
        title += (
            f": $p_c$ outside from {walk.time[out[0]]:.3f} s to {walk.time[out[-1]]:.3f} s, "
            f"by up to {1e3 * walk.zmp_excess.max():.0f} mm"
        )
    figure, (ax,) = ground_figure([title], (-0.35, -0.25), (1.95, 0.25))
    parts = draw_soles(ax, walk)
    shade_push_in_space(ax, walk)
    draw_curve(ax, "dcm", walk.dcm)
    draw_curve(ax, "dcm_plan", walk.dcm_plan)
    draw_curve(ax, "zmp", walk.zmp)
    outside = np.where(walk.zmp_excess[:, None] > 0.0, walk.zmp, np.nan)
    ax.plot(*broken(outside, parts).T, color=palette.ALARM, linewidth=3.0, zorder=4.6)
    alarm = Line2D([], [], color=palette.ALARM, linewidth=3.0, label=r"$p_c$ outside the support")
    add_legend(figure, ("dcm", "dcm_plan", "zmp"), [alarm, push_patch(walk), *sole_patches()])
    return figure


def _last_time(walk: Rollout, until: float) -> slice:
    return slice(0, int(np.searchsorted(walk.time, until)))


def draw_fig_9(walk: Rollout) -> Figure:
    """The hybrid controller takes the push with one step."""
    third = walk.footsteps[2]
    figure, (ax,) = ground_figure(
        [
            "hybrid, 176 N in +x at 1.1 s for 0.2 s: the third step is "
            f"{third.step[0]:.2f} m long and takes {third.duration:.3f} s"
        ],
        (-0.4, -0.25),
        (2.0, 0.25),
    )
    parts = draw_soles(ax, walk)
    shade_push_in_space(ax, walk)
    _draw_nominal_landings(ax, walk)
    curves = paths(walk, parts)
    for name in ("zmp", "dcm", "dcm_plan"):
        draw_curve(ax, name, curves[name])
    extra = [_adapted_patch(), _nominal_patch(), push_patch(walk)]
    add_legend(figure, ("dcm", "dcm_plan", "zmp"), extra)
    return figure


def _draw_nominal_landings(ax: Axes, walk: Rollout) -> None:
    """Dashed, where an adapted step would have landed."""
    half = walk.robot.foot.half
    for part in stances(walk):
        nominal = part.nominal_landing
        if part.adapted and nominal is not None and part.landing is not None:
            ax.add_patch(
                Rectangle(
                    (nominal[0] - half[0], nominal[1] - half[1]), 2 * half[0], 2 * half[1],
                    fill=False, edgecolor=palette.ADAPTED, linewidth=0.9, linestyle=(0, (3.5, 2.5)),
                    zorder=1.6,
                )
            )  # fmt: skip


def _adapted_patch() -> Patch:
    return Patch(facecolor="none", edgecolor=palette.ADAPTED, linewidth=1.8,
                 label="landing decided online")  # fmt: skip


def _nominal_patch() -> Patch:
    return Patch(facecolor="none", edgecolor=palette.ADAPTED, linewidth=0.9,
                 linestyle=(0, (3.5, 2.5)), label="nominal landing")  # fmt: skip


def draw_fig_10(walk: Rollout) -> Figure:
    """The DCM over time."""
    figure, axes = time_figure(
        "DCM of the hybrid controller, 176 N in +x at 1.1 s for 0.2 s", ["x [m]", "y [m]"], 3.0
    )
    parts = stances(walk)
    for index, ax in enumerate(axes):
        shade_push_in_time(ax, walk)
        shown = _last_time(walk, 3.0)
        ax.plot(walk.time[shown], walk.dcm[shown, index], **line_style("dcm"))  # type: ignore[arg-type]
        ax.plot(
            broken(walk.time, parts), broken(walk.dcm_plan[:, index], parts),
            **line_style("dcm_plan"),  # type: ignore[arg-type]
        )  # fmt: skip
        values = np.concatenate([walk.dcm[shown, index], walk.dcm_plan[shown, index]])
        _fit(ax, values)
    number_steps(axes[0], walk)
    add_legend(figure, ("dcm", "dcm_plan"), [push_patch(walk), _touchdown_line()])
    return figure


def _touchdown_line() -> Line2D:
    return Line2D([], [], color="#b5b5b5", linewidth=0.8, label="touchdown")


def _fit(ax: Axes, values: NDArray[np.float64]) -> None:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.08 * (high - low)
    ax.set_ylim(low - margin, high + margin)


def draw_fig_11(walk: Rollout) -> Figure:
    """Several steps bring the offset back; circles cover the offset at the end of each step."""
    steps = walk.footsteps
    figure, (ax,) = ground_figure(
        [
            "hybrid with a small weight on d, 411.6 N in +x at 1.1 s for 0.2 s: "
            "d returns over several steps"
        ],
        (-0.4, -0.32),
        (3.1, 0.24),
    )
    parts = draw_soles(ax, walk)
    shade_push_in_space(ax, walk)
    curves = paths(walk, parts)
    for name in ("zmp", "dcm", "dcm_plan"):
        draw_curve(ax, name, curves[name])
    for step in steps[1:9]:
        _circle_offset(ax, step.landing, step.dcm_offset)
    circle = Line2D([], [], color=palette.ALARM, linestyle=(0, (2.5, 2)), linewidth=1.2,
                    label="offset d at touchdown")  # fmt: skip
    add_legend(figure, ("dcm", "dcm_plan", "zmp"), [circle, _adapted_patch(), push_patch(walk)])
    return figure


def _circle_offset(ax: Axes, landing: tuple[float, float], offset: tuple[float, float]) -> None:
    """A dashed ellipse around the arrow from the centre of the sole to the DCM."""
    centre = np.add(landing, np.multiply(0.5, offset))
    length = float(np.hypot(*offset))
    ax.add_patch(
        Ellipse(
            (float(centre[0]), float(centre[1])), length + 0.05, 0.075,
            angle=float(np.degrees(np.arctan2(offset[1], offset[0]))), fill=False,
            edgecolor=palette.ALARM, linewidth=1.2, linestyle=(0, (2.5, 2)), zorder=5.0,
        )
    )  # fmt: skip
    ax.plot(
        *np.array([landing, np.add(landing, offset)]).T, color=palette.ALARM, linewidth=1.0,
        marker=".", markersize=3.5, zorder=5.1,
    )  # fmt: skip


def draw_fig_12(walk: Rollout) -> Figure:
    """The CoM velocity over time, and its mean over two steps against the command."""
    figure, axes = time_figure(
        "CoM velocity, 411.6 N in +x at 1.1 s for 0.2 s",
        [r"$\dot{x}$ [m/s]", r"$\dot{y}$ [m/s]"],
        4.5,
    )
    shown = _last_time(walk, 4.5)
    for index, ax in enumerate(axes):
        shade_push_in_time(ax, walk)
        ax.axhline(walk.velocity[index], color=palette.QUIET, linewidth=0.9,
                   linestyle=(0, (1, 2)))  # fmt: skip
        ax.plot(walk.time[shown], walk.com_velocity[shown, index], **line_style("com"))  # type: ignore[arg-type]
        _fit(ax, walk.com_velocity[shown, index])
    number_steps(axes[0], walk)
    commanded = Line2D([], [], color=palette.QUIET, linewidth=0.9, linestyle=(0, (1, 2)),
                       label="commanded velocity")  # fmt: skip
    add_legend(figure, ("com",), [commanded, push_patch(walk), _touchdown_line()])
    return figure


PICTURES: dict[str, tuple[str, Callable[[Walks], Figure]]] = {
    "fig-4": (
        "Fig. 4: DCM plan and footholds at two walking velocities.",
        lambda walks: draw_fig_4(walks["fig-4a"], walks["fig-4b"]),
    ),
    "fig-5": (
        "Fig. 5: the plan modified by feedback; 40 N in +x from 0.5 s for 0.8 s.",
        lambda walks: draw_fig_5(walks["fig-5"], walks["fig-4a"]),
    ),
    "fig-8": (
        "Fig. 8: DCM feedback alone under a large push; 142 N in +x from 1.0 s for 0.2 s.",
        lambda walks: draw_fig_8(walks["fig-8"]),
    ),
    "fig-9": (
        "Fig. 9: the hybrid controller; 176 N in +x at 1.1 s for 0.2 s, and small pushes.",
        lambda walks: draw_fig_9(walks["fig-9"]),
    ),
    "fig-10": (
        "Fig. 10: the DCM of Fig. 9 in x and y; yellow: the push.",
        lambda walks: draw_fig_10(walks["fig-9"]),
    ),
    "fig-9-adaptation": (
        "Beside Figs. 9 and 10: what the step decides, against its bounds.",
        lambda walks: adaptation_figure(walks["fig-9"], 3.0, "Fig. 9"),
    ),
    "fig-11": (
        "Fig. 11: 411.6 N in +x at 1.1 s for 0.2 s; dashed circles: the DCM offset d.",
        lambda walks: draw_fig_11(walks["fig-11"]),
    ),
    "fig-12": (
        "Fig. 12: the CoM velocity of Fig. 11 in x and y.",
        lambda walks: draw_fig_12(walks["fig-11"]),
    ),
    "fig-11-adaptation": (
        "Beside Figs. 11 and 12: what the step decides, against its bounds.",
        lambda walks: adaptation_figure(walks["fig-11"], 4.5, "Fig. 11"),
    ),
    "decision-time": (
        CLOCK_WORDS,
        lambda walks: decision_time_figure({"Fig. 9": walks["fig-9"], "Fig. 11": walks["fig-11"]}),
    ),
}
"""What each picture shows, in the order of the paper, and how it is drawn; the same walks make the
same pictures, but for the decision time. The plan of Fig. 5 is the undisturbed walk of Fig. 4."""

"""Draw the pictures of the page on the unified controller.

Run: python docs/pictures/unified_pictures.py docs/pictures
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from msgspec import structs

import surefoot as sf
from surefoot.show import palette
from surefoot.show.decisions import DecidedWalk, draw_decisions
from surefoot.show.picture_file import write_picture
from surefoot.studies.engine.pushed_walk import answer

START, DURATION, PHASE, LEG_SPEED = 1.1, 0.2, 0.1, 3.0
FORWARD = (1.0, 0.0)
PUSHES = {"below comfort": 10.0, "in the middle": 60.0, "near the limit": 113.0}
"""Impulses, forward [N s]."""

PLOTS = {
    "zmp_peak": ("ZMP from the centre\nof the foot, largest [mm]", 122.0),
    "landing": ("change of a landing,\nlargest [mm]", 320.0),
    "timing": ("change of a landing\ntime, largest [ms]", 350.0),
}
"""Quantities drawn over the impulse: label and upper end, in thousandths."""


def main(folder: Path) -> None:
    """Walk, push, decide again, draw."""
    robot = sf.load_robot("paper-biped")
    robot = robot.replace(swing=structs.replace(robot.swing, max_speed=LEG_SPEED))
    controller = sf.UnifiedController(robot, (0.5, 0.0))
    limit = sf.push_limit(robot, FORWARD, elapsed=PHASE, zmp_reach=robot.foot.half).impulse
    walks = []
    for name, impulse in PUSHES.items():
        rollout = sf.simulate(controller, 3.0, [forward(impulse)])
        share = f"{impulse:g} N s, {impulse / limit:.0%} of the limit"
        walks.append(DecidedWalk(rollout, sf.decisions(controller, rollout), f"{name}: {share}"))
    draw_decisions(walks, folder / "unified-decisions.png")
    hybrid = sf.HybridController(robot, (0.5, 0.0))
    with style.context(["default", palette.STYLE]):
        figure = answers_figure(controller, hybrid, limit)
    write_picture(figure, folder / "unified-answers.png", "answers to pushes of all sizes")


def forward(impulse: float) -> sf.Push:
    """The push of this page."""
    return sf.Push(START, DURATION, (impulse / DURATION, 0.0))


def answers_figure(unified: sf.Controller, hybrid: sf.Controller, limit: float) -> Figure:
    """The quantities of `PLOTS` from no push to the largest that can be survived."""
    figure = Figure(figsize=(11.0, 3.6), facecolor="white")
    axes = figure.subplots(1, len(PLOTS))
    figure.subplots_adjust(left=0.075, right=0.99, top=0.86, bottom=0.15, wspace=0.33)
    for ax, (label, highest) in zip(axes, PLOTS.values(), strict=True):
        ax.set_xlim(0.0, 122.0)
        ax.set_ylim(-0.02 * highest, highest)
        ax.set_xlabel("impulse, forward [N s]")
        ax.set_ylabel(label)
        ax.grid(axis="y", color="#e8e8e8", linewidth=0.5)
        ax.axvline(limit, color=palette.ALARM, linewidth=1.2)
        ax.text(limit - 1.0, 0.03, "limit", color=palette.ALARM, rotation=90.0, ha="right",
                va="bottom", fontsize=8.0, transform=ax.get_xaxis_transform())  # fmt: skip
    draw_answers(axes, unified, limit, "unified", color=palette.ADAPTED, linewidth=2.2)
    draw_answers(axes, hybrid, limit, "hybrid", color=palette.COM, linewidth=1.3,
                 linestyle=palette.DASHES)  # fmt: skip
    axes[0].legend(loc="lower center", bbox_to_anchor=(0.55, 0.04), frameon=False)
    figure.suptitle(
        f"one push of {DURATION:g} s, {PHASE:g} s into a step, leg of {LEG_SPEED:g} m/s",
        x=0.01, y=0.98, ha="left", va="top", fontsize=10.5, fontweight="bold",
    )  # fmt: skip
    return figure


def draw_answers(
    axes: list[Axes], controller: sf.Controller, limit: float, label: str, **style_of_line: Any
) -> None:
    """Draw a line up to the first fall, which is marked."""
    impulses = np.append(np.arange(0.0, limit - 0.5, 2.0), 0.99 * limit)
    answers = [(impulse, answer(controller, forward(impulse))) for impulse in impulses]
    lost = [n for n, (_, one) in enumerate(answers) if not one.survived]
    kept = answers[: lost[0]] if lost else answers
    for ax, quantity in zip(axes, PLOTS, strict=True):
        values = [1e3 * getattr(one, quantity) for _, one in kept]
        (line,) = ax.plot([impulse for impulse, _ in kept], values, label=label, **style_of_line)
        ax.plot(
            kept[-1][0], values[-1], "x" if lost else "o", color=line.get_color(), markersize=7.0,
            markeredgewidth=2.0, clip_on=False, zorder=4.0,
        )  # fmt: skip


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""Draw the moving picture of the README: a walk, a push in the third step, the recovery.

Run: python docs/pictures/moving_picture.py docs/pictures/walk.gif
"""

from __future__ import annotations

import sys
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Rectangle
from PIL import Image

import surefoot as sf

FRAMES_PER_SECOND = 20
SLOWER = 2.0
"""How many seconds the picture takes for one second of the walk."""

RIGHT, LEFT, DCM, PLAN, PUSH, INK = "#0072b2", "#d55e00", "#009e73", "#999999", "#cc3311", "#222222"
FROM, TO = 0.6, 3.1
"""What is shown [s]."""


def main(path: str) -> None:
    """Simulate, draw every frame, write the GIF."""
    robot = sf.load_robot("paper-biped")
    push = sf.Push(1.1, 0.2, (176.0, 0.0))
    rollout = sf.simulate(sf.HybridController(robot, (0.5, 0.0)), TO + 0.2, [push])
    times = np.arange(FROM, TO, 1.0 / (FRAMES_PER_SECOND * SLOWER))
    frames = [draw_frame(rollout, push, time) for time in times]
    palette = colours_of(frames[:: len(frames) // 5])
    small = [frame.quantize(64, palette=palette, dither=Image.Dither.NONE) for frame in frames]
    small[0].save(
        path, save_all=True, append_images=small[1:], duration=1000 // FRAMES_PER_SECOND, loop=0
    )


def colours_of(frames: list[Image.Image]) -> Image.Image:
    """One palette for all frames, so that no colour flickers."""
    width, height = frames[0].size
    sheet = Image.new("RGB", (width, height * len(frames)))
    for row, frame in enumerate(frames):
        sheet.paste(frame, (0, row * height))
    return sheet.quantize(64)


def draw_frame(rollout: sf.Rollout, push: sf.Push, time: float) -> Image.Image:
    """The robot from the side and from above at one instant."""
    figure = Figure(figsize=(7.2, 4.3), dpi=100)
    FigureCanvasAgg(figure)
    side, top = figure.subplots(2, 1, sharex=True, height_ratios=(1.25, 1.0))
    figure.subplots_adjust(left=0.02, right=0.98, top=0.93, bottom=0.02, hspace=0.03)
    now = int(np.searchsorted(rollout.time, time))
    pushed = push.start <= time < push.end
    draw_side(side, rollout, now)
    draw_top(top, rollout, now)
    com_x = rollout.com[now, 0]
    if pushed:
        for axes, y in ((side, 0.8), (top, rollout.com[now, 1])):
            arrow = FancyArrowPatch(
                (com_x - 0.42, y), (com_x - 0.04, y), color=PUSH, mutation_scale=22, lw=3, zorder=9
            )
            axes.add_patch(arrow)
        side.text(com_x - 0.44, 0.8, "176 N", color=PUSH, ha="right", va="center", weight="bold")
    for axes in (side, top):
        axes.set_xlim(-0.15, 1.95)
        axes.set_axis_off()
    side.set_ylim(-0.05, 1.12)
    top.set_ylim(-0.42, 0.42)
    command = rollout.commands[now]
    deciding = "step decided online: " if rollout.adapting[now] else "step as planned: "
    side.set_title(
        f"{time:4.2f} s    {deciding}{command['step_duration']:.2f} s", loc="left",
        color=PUSH if rollout.adapting[now] else INK, family="monospace", fontsize=11,
    )  # fmt: skip
    stream = BytesIO()
    figure.savefig(stream, format="png")
    return Image.open(stream).convert("RGB")


def draw_side(axes: Axes, rollout: sf.Rollout, now: int) -> None:
    """Trunk, legs and feet, seen from the right."""
    com_x = rollout.com[now, 0]
    support_x = rollout.support_foot[now, 0]
    swing_x, _, swing_z = rollout.swing_foot[now]
    right_stands = rollout.support_side[now] == sf.Side.RIGHT
    axes.axhline(0.0, color=PLAN, lw=1)
    for foot_x, foot_z, stands in ((swing_x, swing_z, False), (support_x, 0.0, True)):
        color = RIGHT if stands == right_stands else LEFT
        axes.plot((com_x, foot_x), (0.8, foot_z + 0.03), color=color, lw=4, solid_capstyle="round")
        axes.add_patch(Rectangle((foot_x - 0.1, foot_z), 0.2, 0.03, color=color))
    axes.plot((com_x, com_x), (0.8, 1.05), color=INK, lw=8, solid_capstyle="round")
    axes.plot(com_x, 0.8, "o", color=INK, ms=9)
    axes.plot(rollout.dcm[now, 0], 0.0, "D", color=DCM, ms=8, zorder=8)
    axes.text(rollout.dcm[now, 0], 0.05, "DCM", color=DCM, ha="center", fontsize=8)


def draw_top(axes: Axes, rollout: sf.Rollout, now: int) -> None:
    """Feet, the landing that is decided now, CoM and DCM, seen from above."""
    for step in rollout.footsteps:
        if step.start > rollout.time[now]:
            break
        sole(axes, step.support_foot, step.side, filled=False)
    side = sf.Side(int(rollout.support_side[now]))
    sole(axes, rollout.support_foot[now], side, filled=True)
    sole(axes, rollout.commands["step_location"][now], side.other, filled=False, dashed=True)
    sole(axes, rollout.swing_foot[now, :2], side.other, filled=True, faint=True)
    axes.plot(*rollout.com[: now + 1].T, color=INK, lw=1.5)
    axes.plot(*rollout.dcm[: now + 1].T, color=DCM, lw=1.2)
    axes.plot(*rollout.com[now], "o", color=INK, ms=6)
    axes.plot(*rollout.dcm[now], "D", color=DCM, ms=7)


def sole(
    axes: Axes, centre, side: sf.Side, *, filled: bool, dashed: bool = False, faint: bool = False
) -> None:
    """One foot in its true size."""
    color = RIGHT if side is sf.Side.RIGHT else LEFT
    axes.add_patch(
        Rectangle(
            (centre[0] - 0.1, centre[1] - 0.055), 0.2, 0.11, edgecolor=color,
            facecolor=color if filled else "none", alpha=0.35 if faint else 0.9,
            ls="--" if dashed else "-", lw=1.4,
        )
    )  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "docs/pictures/walk.gif")

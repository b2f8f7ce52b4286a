"""Rings and directions of a polar push map: seen from above, forward up."""

from __future__ import annotations

import math
from collections.abc import Callable

from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import MaxNLocator

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.show import palette
from surefoot.show.picture_file import HALO

LIMIT, FOOT_BAND = "#222222", "#d7e3ea"
"""Colours of the theoretical limit, and of what the sole adds to it."""

FIXED_DASH = (0, (1, 1.6))
"""Dashes of the limit of fixed steps."""


def draw_rings(ax: PolarAxes, near: Callable[[float], float]) -> None:
    """Draw rings with their impulses, and the names of the directions around.

    Args:
        ax: whose radius is set already, with forward up.
        near: how far out something is drawn near an angle [deg].
    """
    ax.spines["polar"].set_visible(False)
    ax.set_axisbelow(True)
    ax.grid(color="#dcdcdc", linewidth=0.5)
    ax.set_thetagrids(list(DIRECTIONS.values()), labels=[""] * len(DIRECTIONS))
    for (name, angle), turn, place in zip(
        DIRECTIONS.items(), (0.0, 90.0, 0.0, -90.0), ("bottom", "center", "top", "center"),
        strict=True,
    ):  # fmt: skip
        across = {"outward": "right", "inward": "left"}.get(name, "center")
        ax.text(
            math.radians(angle), 1.01 * ax.get_rmax(), name, rotation=turn, va=place, ha=across,
            fontsize=7.5, color=palette.QUIET, gid=f"direction-{name}",
        )  # fmt: skip
    ticks = [tick for tick in MaxNLocator(4).tick_values(0.0, ax.get_rmax()) if tick > 0.0]
    ticks = [tick for tick in ticks if tick < 0.98 * ax.get_rmax()]
    ax.set_rgrids(ticks, labels=[""] * len(ticks))
    # Where there is least to write over.
    radii = {angle: near(angle) for angle in (225.0, 315.0, 135.0, 45.0)}
    free = math.radians(min(radii, key=radii.__getitem__))
    for tick in ticks:
        ax.text(
            free, tick, f"{tick:g}", fontsize=6.5, color=palette.QUIET,
            ha="center", va="center", path_effects=HALO, zorder=5.0,
        )  # fmt: skip

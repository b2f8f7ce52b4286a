"""What the colours of a walk's picture mean; only what occurs in it is listed."""

from __future__ import annotations

from typing import Literal

from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.stances import Stance, acting_pushes

Dash = Literal["solid", "dashed", "dashdot", "dotted"]


def legend_entries(rollout: Rollout, parts: list[Stance]) -> list[Artist]:
    """One labelled artist for each thing that is drawn."""
    sides = {parts[0].side.other, *(part.side for part in parts)}
    entries: list[Artist] = [
        _line("CoM", palette.COM, 1.4),
        _line("DCM (ring: at touchdown)", palette.DCM, 2.0),
        _line("planned DCM, duration", palette.DCM_PLAN, 1.1, "dashed"),
        _line("ZMP", palette.ZMP, 1.3, marker="."),
    ]
    if rollout.zmp_excess.any():
        entries.append(_line("ZMP outside the sole", palette.ALARM, 2.6))
    for side in (Side.LEFT, Side.RIGHT):
        if side in sides:
            name = f"{side.name.lower()} sole"
            entries.append(
                Patch(
                    facecolor=palette.SOLE[side],
                    edgecolor=palette.SOLE_EDGE[side],
                    linewidth=0.8,
                    label=name,
                )
            )
    if rollout.commands["double_support"].any():
        entries.append(Patch(facecolor=palette.BOTH_SOLES, linewidth=0.0, label="both soles"))
    return entries + _events(rollout, parts)


def _events(rollout: Rollout, parts: list[Stance]) -> list[Artist]:
    entries: list[Artist] = []
    online = [part for part in parts if part.adapted]
    if any(part.landing is not None for part in online):
        entries.append(_outline("landing decided online", 1.8, "solid"))
    if any(part.moved_from is not None for part in online):
        entries.append(_outline("nominal landing", 1.0, "dashed"))
    if online:
        entries.append(
            Patch(
                facecolor="none",
                edgecolor=palette.ADAPTED,
                hatch="////",
                linewidth=0.0,
                alpha=0.5,
                label="deciding online",
            )
        )
    if acting_pushes(rollout):
        entries.append(Patch(facecolor=palette.PUSH, alpha=0.6, linewidth=0.0, label="push"))
    if len(rollout.velocities) > 1:
        entries.append(_line("new velocity", palette.COM, 0.9, "dashdot"))
    settled = f"limits; settled ({1e3 * rollout.settled_error:.2g} mm)"
    entries.append(_line(settled, palette.QUIET, 0.8, "dotted"))
    return entries


def _line(label: str, color: str, width: float, dash: Dash = "solid", marker: str = "") -> Line2D:
    return Line2D(
        [],
        [],
        color=color,
        linewidth=width,
        linestyle=dash,
        marker=marker,
        markersize=6.0,
        markeredgewidth=0.0,
        label=label,
    )


def _outline(label: str, width: float, dash: Dash) -> Patch:
    return Patch(
        facecolor="none", edgecolor=palette.ADAPTED, linewidth=width, linestyle=dash, label=label
    )

"""Where the feet stood, from above: soles in true size, where they were to land, step numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.dcm.frame_turn import rotated
from surefoot.dcm.viability import fall_distance
from surefoot.robot.feet import Side
from surefoot.robot.robot import Foot
from surefoot.rollout.rollout import Rollout
from surefoot.show import palette
from surefoot.show.curves import sole_reach
from surefoot.show.page import units_per_inch
from surefoot.show.picture_file import HALO
from surefoot.show.stances import Stance, pair, runs

SAME_PLACE = 0.05
"""Footprints of one foot that are closer than this share a number [m]."""

MISSED = 0.01
"""A foot of a body that landed this far from its target has the target drawn too [m]."""

NEARBY = 0.45
"""CoM and DCM of a body are shown as far as this from the standing foot: those of a fall run
away [m]."""

AROUND = 0.2
"""ZMP and plan are shown as far as this from all else: they may run away [m]."""


@dataclass(frozen=True)
class Sole:
    """A place where a foot stood, or was to stand.

    Attributes:
        centre: of the sole (x, y) [m].
        yaw: its heading [rad].
        side: which foot.
        samples: the cycles in which it carried.
        name: of the patch in the picture.
        numbers: of the steps that brought it there; empty for a foot that stood at the start, and
            on a body, whose steps are not numbered.
        online: whether one of these was decided online.
    """

    centre: tuple[float, float]
    yaw: float
    side: Side
    samples: slice
    name: str
    numbers: tuple[int, ...] = ()
    online: bool = False

    def rectangle(self, foot: Foot, **look: Any) -> Rectangle:
        """Its outline in true size."""
        half_x, half_y = foot.half
        return Rectangle(
            (self.centre[0] - half_x, self.centre[1] - half_y), foot.length, foot.width,
            angle=math.degrees(self.yaw), rotation_point="center", gid=self.name, **look,
        )  # fmt: skip


def soles(rollout: Rollout, parts: list[Stance]) -> list[Sole]:
    """Every place where a foot stood: on a point mass the swing foot's first, then as they landed.

    Args:
        rollout: the walk.
        parts: its stances; of a body none are needed.
    """
    body = rollout.body
    if body is None:
        # The swing foot's first place belongs to no step of the run.
        start, yaw = pair(rollout.swing_foot[0]), float(rollout.observations["swing_yaw"][0])
        first = Sole(start, yaw, parts[0].side.other, slice(0, 0), "footprint-start")
        online = (False, *(part.adapted for part in parts))
        landed = (
            Sole(
                part.support_foot, part.yaw, part.side, part.samples,
                f"footprint-{part.number - 1}", (part.number - 1,), adapted,
            )
            for part, adapted in zip(parts, online, strict=False)
        )  # fmt: skip
        return [first, *landed]
    found = []
    for foot, side in enumerate((Side.LEFT, Side.RIGHT)):
        for samples in runs(~body.walking | (body.support == foot)):
            # A foot that lands still settles: its place is that in the middle of the stance.
            middle = (samples.start + samples.stop) // 2
            place, yaw = body.sole_position[middle, foot], float(body.sole_turn[middle, foot, 2])
            name = f"sole-{side.name.lower()}-{samples.start}"
            found.append(Sole(pair(place), yaw, side, samples, name))
    return sorted(found, key=lambda sole: sole.samples.start)


def missed_soles(rollout: Rollout, parts: list[Stance]) -> list[Sole]:
    """Where feet were to land that landed elsewhere.

    On a point mass the landings of the nominal gait, for steps that were decided online; on a body
    the targets that the foot did not meet.
    """
    if rollout.body is None:
        return [
            Sole(
                part.moved_from, part.yaw, part.side.other, part.samples,
                f"nominal-landing-{part.number}",
            )
            for part in parts
            if part.moved_from is not None
        ]  # fmt: skip
    found = []
    for sole in soles(rollout, parts):
        before = sole.samples.start - 1
        if before >= 0 and rollout.body.walking[before]:
            target = pair(rollout.commands["step_location"][before])
            if math.dist(target, sole.centre) > MISSED:
                found.append(replace(sole, centre=target, name=f"target-of-{sole.name}"))
    return found


def nearby(rollout: Rollout, path: NDArray[np.float64]) -> NDArray[np.float64]:
    """A path, no further from the standing foot than what is shown of one that runs away [m]."""
    far = fall_distance(rollout.robot) if rollout.body is None else NEARBY
    return rollout.support_foot + np.clip(path - rollout.support_foot, -far, far)


def walked_extent(
    rollout: Rollout, places: list[Sole], com: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What a walk needs of the ground: its soles, CoM and DCM, and ZMP and plan around these.

    Args:
        rollout: the walk.
        places: its soles.
        com: what is shown of its CoM, shape (n, 2) [m].

    Returns:
        Least and largest (x, y) [m].
    """
    centres = np.array([sole.centre for sole in places])
    reach = sole_reach(rollout.robot.foot, np.array([sole.yaw for sole in places]))
    core = np.vstack([centres - reach, centres + reach, com, nearby(rollout, rollout.dcm)])
    low, high = core.min(axis=0), core.max(axis=0)
    jumping = np.vstack([rollout.zmp, rollout.dcm_plan])
    return (
        np.maximum(np.fmin(low, np.nanmin(jumping, axis=0)), low - AROUND),
        np.minimum(np.fmax(high, np.nanmax(jumping, axis=0)), high + AROUND),
    )


def draw_footprints(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Draw the soles, and the outlines of those that were to land elsewhere."""
    foot = rollout.robot.foot
    for sole in soles(rollout, parts):
        edge = palette.ADAPTED if sole.online else palette.SOLE_EDGE[sole.side]
        width, zorder = (1.8, 1.5) if sole.online else (0.8, 1.0)
        colour = palette.SOLE[sole.side]
        ax.add_patch(
            sole.rectangle(foot, facecolor=colour, edgecolor=edge, linewidth=width, zorder=zorder)
        )
    for sole in missed_soles(rollout, parts):
        ax.add_patch(sole.rectangle(foot, **palette.MISSED, zorder=1.6))


def number_footprints(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Write the number of its step at the outer side of every sole; sideways, at its ends."""
    ahead = np.array([1.0, 0.0] if _walks_sideways(rollout, parts) else [0.0, 1.0])
    taken: list[NDArray[np.float64]] = []
    # Where steps crowd, those that were decided online are the ones to name.
    for place in sorted(_places(rollout, parts), key=lambda place: not place.online):
        outward = ahead if place.side is Side.LEFT else -ahead
        spot = place.centre + np.array(rotated(outward * rollout.robot.foot.half, place.yaw))
        spacing = np.array([0.23, 0.15]) * units_per_inch(ax)
        if any(np.all(np.abs(spot - other) < spacing) for other in taken):
            continue
        taken.append(spot)
        x, y = rotated(outward, place.yaw)
        ax.annotate(
            _listed(place.numbers), pair(spot), xytext=(3.0 * x, 3.0 * y),
            textcoords="offset points", ha=("right", "center", "left")[1 + round(x)],
            va=("top", "center", "bottom")[1 + round(y)], **palette.step_number(place.online),
            path_effects=HALO, gid=f"number-{place.numbers[0]}", zorder=6.0,
        )  # fmt: skip


def _walks_sideways(rollout: Rollout, parts: list[Stance]) -> bool:
    """Whether the feet, in their own directions, moved to the side more than ahead."""
    moved = np.zeros(2)
    for before, after in pairwise(parts):
        moved += rotated(np.subtract(after.support_foot, before.support_foot), -before.yaw)
    ahead, aside = np.abs(moved)
    return bool(aside > max(ahead, rollout.robot.hip))


def _places(rollout: Rollout, parts: list[Stance]) -> list[Sole]:
    """Where feet stood in the run; in place, several steps lead to the same."""
    places: list[Sole] = []
    for sole in soles(rollout, parts)[1:]:
        for index, place in enumerate(places):
            if sole.side is place.side and math.dist(sole.centre, place.centre) < SAME_PLACE:
                numbers, online = place.numbers + sole.numbers, place.online or sole.online
                places[index] = replace(place, numbers=numbers, online=online)
                break
        else:
            places.append(sole)
    return places


def _listed(numbers: tuple[int, ...]) -> str:
    if len(numbers) > 4:
        return f"{numbers[0]}, {numbers[1]} … {numbers[-1]}"
    return ", ".join(map(str, numbers))

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

from surefoot.robot.feet import Side
from surefoot.robot.robot import Foot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.ground import metres_per_inch
from surefoot.show.picture_file import HALO
from surefoot.show.stances import Stance, pair

SAME_PLACE = 0.05
"""Footprints of one foot that are closer than this share a number [m]."""

MISSED = 0.01
"""A foot of a body that landed this far from its target has the target drawn too [m]."""


@dataclass(frozen=True)
class Sole:
    """A place where a foot stood, or was to stand.

    Attributes:
        centre: of the sole (x, y) [m].
        yaw: its heading [rad].
        side: which foot.
        name: of the patch in the picture.
        numbers: of the steps that brought it there; empty for a foot that stood at the start, and
            on a body, whose steps are not numbered.
    """

    centre: tuple[float, float]
    yaw: float
    side: Side
    name: str
    numbers: tuple[int, ...] = ()

    def rectangle(self, foot: Foot, **look: Any) -> Rectangle:
        """Its outline in true size."""
        return Rectangle(
            (self.centre[0] - foot.half[0], self.centre[1] - foot.half[1]),
            foot.length,
            foot.width,
            angle=math.degrees(self.yaw),
            rotation_point="center",
            gid=self.name,
            **look,
        )


def standing_places(trace: BodyTrace) -> list[tuple[int, int, NDArray[np.float64], float]]:
    """Where the feet of a body stood: the cycle in which one began to, foot, place and heading.

    A place is that of the middle of the stance: a foot that lands still settles.

    Returns:
        (cycle, foot, (x, y) [m], yaw [rad]) in order of time.
    """
    found = []
    for foot in (0, 1):
        carries = (~trace.walking) | (trace.support == foot)
        edges = np.flatnonzero(np.diff(np.concatenate(([0], carries.astype(int), [0]))))
        for first, last in edges.reshape(-1, 2).tolist():
            middle = (first + last) // 2
            place = trace.sole_position[middle, foot, :2]
            found.append((first, foot, place, float(trace.sole_turn[middle, foot, 2])))
    return sorted(found, key=lambda item: item[:2])


def soles(rollout: Rollout, parts: list[Stance]) -> list[Sole]:
    """Every place where a foot stood: on a point mass the swing foot's first, then as they landed.

    Args:
        rollout: the walk.
        parts: its stances; of a body none are needed.
    """
    if rollout.body is not None:
        return [
            Sole(pair(place), yaw, Side(2 * foot - 1), f"sole-{index}")
            for index, (_, foot, place, yaw) in enumerate(standing_places(rollout.body))
        ]
    start, yaw = pair(rollout.swing_foot[0][:2]), float(rollout.observations["swing_yaw"][0])
    # The swing foot's first place belongs to no step of the run.
    first = Sole(start, yaw, parts[0].side.other, "footprint-start")
    return [
        first,
        *(
            Sole(
                part.support_foot, part.yaw, part.side, f"footprint-{part.number - 1}",
                (part.number - 1,),
            )
            for part in parts
        ),
    ]  # fmt: skip


def missed_soles(rollout: Rollout, parts: list[Stance]) -> list[Sole]:
    """Where feet were to land that landed elsewhere.

    On a point mass the landings of the nominal gait, for steps that were decided online; on a body
    the targets that the foot did not meet.
    """
    if rollout.body is None:
        return [
            Sole(part.moved_from, part.yaw, part.side.other, f"nominal-landing-{part.number}")
            for part in parts
            if part.moved_from is not None
        ]
    found = []
    for index, (row, foot, place, yaw) in enumerate(standing_places(rollout.body)):
        if row == 0 or not rollout.body.walking[row - 1]:
            continue
        target = rollout.commands["step_location"][row - 1]
        if math.dist(target, place) > MISSED:
            found.append(Sole(pair(target), yaw, Side(2 * foot - 1), f"target-{index}"))
    return found


def draw_footprints(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Draw the soles, and the outlines of those that were to land elsewhere."""
    body = rollout.body
    foot = rollout.robot.foot if body is None else body.robot.foot
    adapted = _adapted(parts)
    for sole in soles(rollout, parts):
        online = not adapted.isdisjoint(sole.numbers)
        ax.add_patch(
            sole.rectangle(
                foot,
                facecolor=palette.SOLE[sole.side],
                edgecolor=palette.ADAPTED if online else palette.SOLE_EDGE[sole.side],
                linewidth=1.8 if online else 0.8,
                zorder=1.5 if online else 1.0,
            )
        )
    width, dashes = (1.0, (0, (3.5, 2.5))) if body is None else (0.8, palette.DASHES)
    for sole in missed_soles(rollout, parts):
        ax.add_patch(
            sole.rectangle(
                foot, fill=False, edgecolor=palette.ADAPTED, linewidth=width, linestyle=dashes,
                zorder=1.6,
            )
        )  # fmt: skip


def number_footprints(ax: Axes, rollout: Rollout, parts: list[Stance]) -> None:
    """Write the number of its step at the outer side of every sole; sideways, at its ends."""
    adapted = _adapted(parts)
    ahead = np.array([1.0, 0.0] if _walks_sideways(rollout, parts) else [0.0, 1.0])
    # Where steps crowd, those that were decided online are the ones to name.
    places = sorted(_places(rollout, parts), key=lambda place: adapted.isdisjoint(place.numbers))
    taken: list[NDArray[np.float64]] = []
    for place in places:
        outward = ahead if place.side is Side.LEFT else -ahead
        spot = place.centre + _rotated(outward * rollout.robot.foot.half, place.yaw)
        way = _rotated(outward, place.yaw)
        spacing = np.array([0.23, 0.15]) * metres_per_inch(ax)
        if any(np.all(np.abs(spot - other) < spacing) for other in taken):
            continue
        taken.append(spot)
        online = not adapted.isdisjoint(place.numbers)
        ax.annotate(
            _listed(place.numbers),
            pair(spot),
            xytext=pair(3.0 * way),
            textcoords="offset points",
            ha=("right", "center", "left")[1 + round(way[0])],
            va=("top", "center", "bottom")[1 + round(way[1])],
            fontsize=8.5 if online else 7.5,
            fontweight="bold" if online else "normal",
            color=palette.ADAPTED if online else palette.QUIET,
            path_effects=HALO,
            gid=f"number-{place.numbers[0]}",
            zorder=6.0,
        )


def _adapted(parts: list[Stance]) -> set[int]:
    """Numbers of the steps that were decided online."""
    return {part.number for part in parts if part.adapted}


def _walks_sideways(rollout: Rollout, parts: list[Stance]) -> bool:
    """Whether the feet, in their own directions, moved to the side more than ahead."""
    moved = sum(
        _rotated(np.subtract(after.support_foot, before.support_foot), -before.yaw)
        for before, after in pairwise(parts)
    )
    ahead, aside = np.abs(moved) * np.ones(2)
    return bool(aside > max(ahead, rollout.robot.hip))


def _rotated(vector: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """A vector rotated counter-clockwise by an angle [rad]."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]])


def _places(rollout: Rollout, parts: list[Stance]) -> list[Sole]:
    """Where feet stood in the run; in place, several steps lead to the same."""
    places: list[Sole] = []
    for sole in soles(rollout, parts)[1:]:
        for index, place in enumerate(places):
            if sole.side is place.side and math.dist(sole.centre, place.centre) < SAME_PLACE:
                places[index] = replace(place, numbers=place.numbers + sole.numbers)
                break
        else:
            places.append(sole)
    return places


def _listed(numbers: tuple[int, ...]) -> str:
    if len(numbers) > 4:
        return f"{numbers[0]}, {numbers[1]} … {numbers[-1]}"
    return ", ".join(map(str, numbers))

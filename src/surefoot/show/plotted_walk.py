"""What the pictures of a walk are made of: its stances, its soles, its lines."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from surefoot.dcm.viability import fall_distance
from surefoot.robot.feet import Side
from surefoot.robot.robot import Foot
from surefoot.rollout.measures import planned_com
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.palette import DASHES
from surefoot.show.stances import Stance, broken, pair, runs, stances

MISSED = 0.01
"""A foot of a body that landed this far from its target has the target drawn too [m]."""

NEARBY = 0.45
"""CoM and DCM of a body are shown as far as this from the standing foot: those of a fall run
away [m]."""

AROUND = 0.2
"""ZMP and plan are shown as far as this from all else: they may run away [m]."""

PLAN: dict[str, Any] = {"linewidth": 1.1, "linestyle": DASHES, "zorder": 4.2}
"""How a line is drawn that was planned."""


class Curve(NamedTuple):
    """A line of a walk, from above and over time.

    Attributes:
        name: part of the names of what is drawn.
        label: in the legend.
        time: its instants, shape (n,) [s].
        points: (x, y), NaN where the line is interrupted, shape (n, 2) [m].
        look: how it is drawn.
    """

    name: str
    label: str
    time: NDArray[np.float64]
    points: NDArray[np.float64]
    look: dict[str, Any]


@dataclass(frozen=True)
class Sole:
    """A place where a foot stood, or was to stand.

    Attributes:
        centre: of the sole (x, y) [m].
        yaw: its heading [rad].
        side: which foot.
        samples: the cycles in which it carried; none of the swing foot's first place.
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


@dataclass(frozen=True)
class PlottedWalk:
    """A walk of a point mass or a body, with what its plots need.

    Args:
        rollout: the walk.
    """

    rollout: Rollout

    @cached_property
    def parts(self) -> list[Stance]:
        """The stances of a point mass, in order; none of a body, whose steps are not numbered."""
        return stances(self.rollout) if self.rollout.body is None else []

    @cached_property
    def soles(self) -> list[Sole]:
        """Every place where a foot stood, in order of time; a point mass's swing foot first."""
        rollout, body = self.rollout, self.rollout.body
        if body is not None:
            return _soles_of_body(body)
        # The swing foot's first place belongs to no step of the run.
        start, yaw = pair(rollout.swing_foot[0]), float(rollout.observations["swing_yaw"][0])
        first = Sole(start, yaw, self.parts[0].side.other, slice(0, 0), "footprint-start")
        online = (False, *(part.adapted for part in self.parts))
        landed = (
            Sole(
                part.support_foot, part.yaw, part.side, part.samples,
                f"footprint-{part.number - 1}", (part.number - 1,), adapted,
            )
            for part, adapted in zip(self.parts, online, strict=False)
        )  # fmt: skip
        return [first, *landed]

    @cached_property
    def missed_soles(self) -> list[Sole]:
        """Where feet were to land that landed elsewhere.

        On a point mass the landings of the nominal gait, for steps that were decided online; on a
        body the targets that the foot did not meet.
        """
        rollout, body = self.rollout, self.rollout.body
        if body is None:
            return [
                Sole(
                    part.moved_from, part.yaw, part.side.other, part.samples,
                    f"nominal-landing-{part.number}",
                )
                for part in self.parts
                if part.moved_from is not None
            ]  # fmt: skip
        found = []
        for sole in self.soles:
            before = sole.samples.start - 1
            if before >= 0 and body.walking[before]:
                target = pair(rollout.commands["step_location"][before])
                if math.dist(target, sole.centre) > MISSED:
                    found.append(replace(sole, centre=target, name=f"target-of-{sole.name}"))
        return found

    @cached_property
    def curves(self) -> list[Curve]:
        """Its lines, in the order of the legend; those that were planned are dashed.

        CoM and DCM go on smoothly at a touchdown, ZMP and plan may jump.
        """
        rollout, parts, body = self.rollout, self.parts, self.rollout.body
        time, dcm_plan = rollout.time, {"color": palette.DCM_PLAN, **PLAN}
        zmp = {"color": palette.ZMP, "linewidth": 1.2, "zorder": 3.0}
        com = {"color": palette.COM, "linewidth": 1.3, "zorder": 4.15}
        dcm = {"color": palette.DCM, "linewidth": 1.9, "zorder": 4.1}
        found = [
            Curve("com", "CoM", time, rollout.com, com),
            Curve("dcm", "DCM (ring: at touchdown)", time, rollout.dcm, dcm),
        ]
        if body is not None:
            com_plan = {"color": palette.COM_PLAN, **PLAN}
            zmp_plan = {"color": palette.ZMP_PLAN, **PLAN}
            return [
                *found,
                Curve("zmp", "ZMP of the floor's forces", time, rollout.zmp, zmp),
                Curve("com-plan", "planned CoM", time, planned_com(rollout, body), com_plan),
                Curve("dcm-plan", "planned DCM", time, _plan_of_body(rollout, body), dcm_plan),
                Curve("zmp-plan", "commanded ZMP", time, rollout.commands["zmp"], zmp_plan),
            ]
        cut, plan = broken(time, parts), broken(rollout.dcm_plan, parts)
        found += [
            Curve("dcm-plan", "planned DCM, duration", cut, plan, dcm_plan),
            Curve("zmp", "ZMP", cut, broken(rollout.zmp, parts), zmp),
        ]
        if rollout.zmp_excess.any():
            points = np.where(rollout.zmp_excess[:, None] > 0.0, rollout.zmp, np.nan)
            alarm: dict[str, Any] = {"color": palette.ALARM, "linewidth": 2.6, "zorder": 3.2}
            look = {"solid_capstyle": "round", **alarm}
            label = "ZMP outside the sole"
            found.append(Curve("zmp-outside", label, cut, broken(points, parts), look))
        return found

    def nearby(self, path: NDArray[np.float64]) -> NDArray[np.float64]:
        """A path, no further from the standing foot than one that runs away is shown [m]."""
        foot = self.rollout.support_foot
        far = fall_distance(self.rollout.robot) if self.rollout.body is None else NEARBY
        return foot + np.clip(path - foot, -far, far)

    def extent(
        self, places: list[Sole], com: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What a plot needs of the ground: soles, CoM and DCM, and ZMP and plan around these.

        Args:
            places: the soles that are shown.
            com: what is shown of the CoM, shape (n, 2) [m].

        Returns:
            Least and largest (x, y) [m].
        """
        rollout = self.rollout
        centres = np.array([sole.centre for sole in places])
        reach = sole_reach(rollout.robot.foot, np.array([sole.yaw for sole in places]))
        core = np.vstack([centres - reach, centres + reach, com, self.nearby(rollout.dcm)])
        low, high = core.min(axis=0), core.max(axis=0)
        jumping = np.vstack([rollout.zmp, rollout.dcm_plan])
        return (
            np.maximum(np.fmin(low, np.nanmin(jumping, axis=0)), low - AROUND),
            np.minimum(np.fmax(high, np.nanmax(jumping, axis=0)), high + AROUND),
        )


def _soles_of_body(trace: BodyTrace) -> list[Sole]:
    found = []
    for foot, side in enumerate((Side.LEFT, Side.RIGHT)):
        for samples in runs(~trace.walking | (trace.support == foot)):
            # A foot that lands still settles: its place is that in the middle of the stance.
            middle = (samples.start + samples.stop) // 2
            place, yaw = trace.sole_position[middle, foot], float(trace.sole_turn[middle, foot, 2])
            name = f"sole-{side.name.lower()}-{samples.start}"
            found.append(Sole(pair(place), yaw, side, samples, name))
    return sorted(found, key=lambda sole: sole.samples.start)


def _plan_of_body(rollout: Rollout, trace: BodyTrace) -> NDArray[np.float64]:
    """The planned DCM, NaN where it jumps at a touchdown, and while the body stands."""
    plan = np.where(trace.walking[:, None], rollout.dcm_plan, np.nan)
    plan[1:][np.diff(trace.steps) != 0] = np.nan
    return plan


def support_bounds(
    rollout: Rollout,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The extent of the ground that carries: one sole, or both and what lies between them.

    Returns:
        Least and largest x and y, each of shape (n, 2) [m].
    """
    foot, observed = rollout.support_foot, rollout.observations
    shared = (rollout.commands["double_support"] != 0)[:, None]
    reach = sole_reach(rollout.robot.foot, observed["support_yaw"])
    other_reach = sole_reach(rollout.robot.foot, observed["swing_yaw"])
    other = rollout.swing_foot[:, :2]
    low, high = foot - reach, foot + reach
    return (
        np.where(shared, np.minimum(low, other - other_reach), low),
        np.where(shared, np.maximum(high, other + other_reach), high),
    )


def sole_reach(foot: Foot, yaw: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """How far a sole reaches from its centre along the axes of the world (x, y) [m].

    Args:
        foot: the sole.
        yaw: its heading, of any shape [rad].

    Returns:
        Shape (..., 2).
    """
    (half_x, half_y), cos, sin = foot.half, np.abs(np.cos(yaw)), np.abs(np.sin(yaw))
    return np.stack([cos * half_x + sin * half_y, sin * half_x + cos * half_y], axis=-1)


def zmp_outside(rollout: Rollout) -> NDArray[np.bool_]:
    """Where the ZMP is outside the soles on the ground, by axis, shape (n, 2).

    Between two soles it can be outside though each coordinate is within bounds: then both count.
    """
    outside = rollout.zmp_excess > 0.0
    low, high = support_bounds(rollout)
    beyond = outside[:, None] & ((rollout.zmp < low) | (rollout.zmp > high))
    return beyond | (outside & ~beyond.any(axis=1))[:, None]

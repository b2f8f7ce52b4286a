"""The lines of a walk in every picture: CoM, DCM and ZMP, their plans, and what bounds the ZMP."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.robot.robot import Foot
from surefoot.rollout.measures import planned_com
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.palette import DASHES
from surefoot.show.stances import Stance, broken


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


def curves(rollout: Rollout, parts: list[Stance], by_axis: bool = False) -> list[Curve]:
    """The lines of a walk, in the order of the legend; those that were planned are dashed.

    CoM and DCM go on smoothly at a touchdown, ZMP and plan may jump.

    Args:
        rollout: the walk.
        parts: its stances; of a body none are needed.
        by_axis: whether of a ZMP outside the soles only the coordinate that is outside is marked.
    """
    time, body = rollout.time, rollout.body
    plan = {"linewidth": 1.1, "linestyle": DASHES, "zorder": 4.2}
    dcm_plan = {"color": palette.DCM_PLAN, **plan}
    zmp = {"color": palette.ZMP, "linewidth": 1.2, "zorder": 3.0}
    look_com = {"color": palette.COM, "linewidth": 1.3, "zorder": 4.15}
    look_dcm = {"color": palette.DCM, "linewidth": 1.9, "zorder": 4.1}
    found = [
        Curve("com", "CoM", time, rollout.com, look_com),
        Curve("dcm", "DCM (ring: at touchdown)", time, rollout.dcm, look_dcm),
    ]
    if body is not None:
        com_plan = {"color": palette.COM_PLAN, **plan}
        commanded = {"color": palette.ZMP_PLAN, **plan}
        return [
            *found,
            Curve("zmp", "ZMP of the floor's forces", time, rollout.zmp, zmp),
            Curve("com-plan", "planned CoM", time, planned_com(rollout, body), com_plan),
            Curve("dcm-plan", "planned DCM", time, _plan_of_body(rollout, body), dcm_plan),
            Curve("zmp-plan", "commanded ZMP", time, rollout.commands["zmp"], commanded),
        ]
    cut = broken(time, parts)
    found += [
        Curve("dcm-plan", "planned DCM, duration", cut, broken(rollout.dcm_plan, parts), dcm_plan),
        Curve("zmp", "ZMP", cut, broken(rollout.zmp, parts), zmp),
    ]
    if rollout.zmp_excess.any():
        where = zmp_outside(rollout) if by_axis else rollout.zmp_excess[:, None] > 0.0
        outside = broken(np.where(where, rollout.zmp, np.nan), parts)
        look = {"color": palette.ALARM, "linewidth": 2.6, "solid_capstyle": "round", "zorder": 3.2}
        found.append(Curve("zmp-outside", "ZMP outside the sole", cut, outside, look))
    return found


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

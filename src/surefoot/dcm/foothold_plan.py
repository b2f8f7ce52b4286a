"""The DCM plan over given footholds, backwards from the last one: [Englsberger2015], Section V.

    dcm_end,k = dcm_start,k+1,     dcm_start,k = p_k + (dcm_end,k - p_k) e^(-omega T_k)

Behind the last foothold the robot steps in place, in the heading of that foothold, so the
recursion begins with the start offset of that gait.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.footholds import Foothold
from surefoot.dcm.nominal_gait import NominalGait
from surefoot.robot.feet import Side


@dataclass(frozen=True)
class PlannedStep:
    """One step over given footholds.

    Attributes:
        side: foot that stands.
        duration: T [s].
        start_offset: planned DCM at touchdown, relative to the foot that stands (x, y) [m].
        end_offset: planned DCM at the end, relative to the landing (x, y) [m].
        landing_yaw: heading of the landing foot [rad].
    """

    side: Side
    duration: float
    start_offset: tuple[float, float]
    end_offset: tuple[float, float]
    landing_yaw: float


def plan_footholds(footholds: Sequence[Foothold], in_place: NominalGait) -> list[PlannedStep]:
    """The steps over the footholds, and two more in place, one for each foot.

    Args:
        footholds: checked ones; the first two are the feet that stand at the start.
        in_place: the nominal gait for no velocity.

    Returns:
        A step for every foothold from the second on, then the two that repeat for ever.
    """
    last = footholds[-1]
    ends = {side: _turned(in_place.start_offset(side), last.yaw) for side in Side}
    feet = [np.array((foothold.x, foothold.y)) for foothold in footholds[1:]]
    starts = [ends[last.side]]
    for k in range(len(feet) - 2, -1, -1):
        duration = footholds[k + 2].time - footholds[k + 1].time
        dcm_end = feet[k + 1] + starts[0]
        starts.insert(0, (dcm_end - feet[k]) * math.exp(-in_place.omega * duration))
    steps = [
        PlannedStep(
            standing.side,
            landing.time - standing.time,
            _pair(starts[k]),
            _pair(starts[k + 1]),
            landing.yaw,
        )
        for k, (standing, landing) in enumerate(pairwise(footholds[1:]))
    ]
    side = last.side
    for _ in range(2):
        steps.append(
            PlannedStep(
                side, in_place.step_duration, _pair(ends[side]), _pair(ends[side.other]), last.yaw
            )
        )
        side = side.other
    return steps


def _turned(vector: tuple[float, float], yaw: float) -> NDArray[np.float64]:
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array((cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]))


def _pair(vector: NDArray[np.float64]) -> tuple[float, float]:
    return float(vector[0]), float(vector[1])

"""How large a push one step can absorb, under every set of assumptions the paper leaves open.

The paper states 70.56 N s along x and 58.8 N s along y "in one step" and does not say how fast the
leg may move, whether the foot may land while the push still acts, which weights and bounds the DCM
offset has, nor which hip (Table 2 prints 0.01 m). Here they are all tried, none is chosen.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.control.hybrid import HybridController
from surefoot.models.footsteps import Side
from surefoot.models.pushes import Push
from surefoot.models.robot import Robot, Swing
from surefoot.planning.step_problem import OFFSET_PENALTY, OFFSET_WEIGHT
from surefoot.simulation.landings import pushed_landings

VELOCITY = (0.5, 0.0)
"""Of the walk that is pushed [m/s]."""

PUSH_DELAY, PUSH_DURATION = 0.1, 0.2
"""From the touchdown to the push, and its length [s]: the paper's push in the third step."""

NOMINAL = 1e-3
"""An offset that is no further than this from d_nom, in x and in y, is nominal again [m]."""

IMPULSE_STEP = 0.98
"""Between neighbouring impulses of a scan; the paper's own are multiples of it [N s]."""

LARGEST_IMPULSE = 147.0
"""Where a scan ends [N s]."""

LEG_SPEEDS = (math.inf, 3.0)
HIPS = (0.2, 0.01)
OFFSET_WEIGHTS = ((1e3, 1e3), OFFSET_WEIGHT, (2e4, 2e4))
PENALTIES = (OFFSET_PENALTY, 0.0)
DIRECTIONS = ((1.0, 0.0), (0.0, 1.0), (0.0, -1.0))


@dataclass(frozen=True)
class OneStepLimit:
    """One set of assumptions and the largest impulse that one step absorbs under it.

    Attributes:
        direction: of the push (x, y).
        leg_speed: largest speed of the swing foot [m/s].
        hip: lateral distance of the sole centres [m].
        offset_weight: (a4, a5) [1/m^2].
        offset_penalty: on a violation of the offset bounds; 0 for no bounds [1/m^2].
        lands_during_push: whether a step may end while the push still acts.
        nominal: what counts as absorbed: d nominal again within `NOMINAL`, or else |d| inside the
            printed bounds, as a program with hard bounds needs.
        impulse: the largest of the scan up to which every adapted step absorbs its push; 0 if
            none does, inf if all do [N s].
    """

    direction: tuple[float, float]
    leg_speed: float
    hip: float
    offset_weight: tuple[float, float]
    offset_penalty: float
    lands_during_push: bool
    nominal: bool
    impulse: float

    @property
    def assumptions(self) -> str:
        """All but direction and impulse, in words."""
        return ", ".join(
            (
                "leg unlimited" if math.isinf(self.leg_speed) else f"leg {self.leg_speed:g} m/s",
                f"hip {self.hip:g} m",
                f"weights ({self.offset_weight[0]:g}, {self.offset_weight[1]:g})",
                "soft bounds on d" if self.offset_penalty > 0.0 else "no bounds on d",
                f"landing during the push {'allowed' if self.lands_during_push else 'excluded'}",
                "d within 1 mm of d_nom" if self.nominal else "|d| within its bounds",
            )
        )


def one_step_limits(robot: Robot) -> list[OneStepLimit]:
    """The whole table: every direction under every set of assumptions.

    Args:
        robot: mass, height, limits and foot; hip and leg speed are varied.
    """
    rows = []
    for hip, speed, weight, penalty, direction in itertools.product(
        HIPS, LEG_SPEEDS, OFFSET_WEIGHTS, PENALTIES, DIRECTIONS
    ):
        controller = _controller(robot, hip, speed, weight, penalty)
        landings = pushed_landings(controller, _scan(direction))
        for lands_during_push, nominal in itertools.product((True, False), (True, False)):
            absorbed = _absorbed(controller, landings, nominal)
            if not lands_during_push:
                absorbed &= landings["time"] >= PUSH_DELAY + PUSH_DURATION - 1e-9
            rows.append(
                OneStepLimit(
                    direction, speed, hip, weight, penalty, lands_during_push, nominal,
                    _largest(absorbed, landings["adapted"]),
                )
            )  # fmt: skip
    return rows


def nearest_limits(
    rows: Sequence[OneStepLimit], target: float, *, along_x: bool
) -> list[OneStepLimit]:
    """The rows that come closest to an impulse [N s], all of them if several are equally close."""
    chosen = [row for row in rows if (row.direction[0] != 0.0) == along_x]
    closest = min(abs(row.impulse - target) for row in chosen)
    return [row for row in chosen if abs(row.impulse - target) <= closest + 1e-9]


@cache
def _scan(direction: tuple[float, float]) -> tuple[Push, ...]:
    count = math.floor(LARGEST_IMPULSE / IMPULSE_STEP) + 1
    forces = IMPULSE_STEP * np.arange(count) / PUSH_DURATION
    return tuple(
        Push(PUSH_DELAY, PUSH_DURATION, (direction[0] * force, direction[1] * force))
        for force in forces.tolist()
    )


def _controller(
    robot: Robot, hip: float, speed: float, weight: tuple[float, float], penalty: float
) -> HybridController:
    swing = Swing(
        height=robot.swing.height,
        landing_velocity=robot.swing.landing_velocity,
        max_speed=speed,
    )
    varied = robot.replace(hip=hip, swing=swing)
    return HybridController(varied, VELOCITY, offset_weight=weight, offset_penalty=penalty)


def _largest(absorbed: NDArray[np.bool_], adapted: NDArray[np.bool_]) -> float:
    """The last impulse before the first failure [N s].

    A push too small to re-plan the step is left to tracking, which needs more than the rest of
    the step to bring d back: that is no failure of stepping.
    """
    failed = np.flatnonzero(adapted & ~absorbed)
    if not len(failed):
        return math.inf
    passed = np.flatnonzero((adapted & absorbed)[: failed[0]])
    return float(passed[-1] * IMPULSE_STEP) if len(passed) else 0.0


def _absorbed(
    controller: HybridController, landings: NDArray[np.void], nominal: bool
) -> NDArray[np.bool_]:
    d_nom = np.array(controller.gait.dcm_offset(Side.RIGHT))
    offset = landings["offset"]
    if nominal:
        return (np.abs(offset - d_nom) <= NOMINAL).all(axis=1)
    bound = np.maximum(controller.robot.gait.dcm_offset, np.abs(d_nom))
    return (np.abs(offset) <= bound + NOMINAL).all(axis=1)

"""How large a push one step can absorb, under every set of assumptions the paper leaves open.

The paper states 70.56 N s along x and 58.8 N s along y "in one step" and does not say how fast the
leg may move, whether the foot may land while the push still acts, which weights and bounds the DCM
offset has, nor which hip (Table 2 prints 0.01 m). Here they are all tried, none is chosen.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from surefoot.control.hybrid import HybridController
from surefoot.dcm.pushes import Push
from surefoot.dcm.step_problem import OFFSET_PENALTY, OFFSET_WEIGHT
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.studies.engine.report import Table
from surefoot.studies.engine.table import Row
from surefoot.studies.reproduce.walks import (
    AXES,
    NOT_REPRODUCED,
    UNDER_ASSUMPTIONS,
    VELOCITY,
    Claim,
)
from surefoot.worlds.point.batch import pushed_landings

PUSH_DELAY, PUSH_DURATION = 0.1, 0.2
"""From the touchdown to the push, and its length [s]: the paper's push in the third step."""

PAPER_X, PAPER_Y = 70.56, 58.8
"""What the paper reports for one step, along x and along y [N s]."""

NOMINAL = 1e-3
"""An offset that is no further than this from d_nom, in x and in y, is nominal again [m]."""

IMPULSE_STEP = 0.98
"""Between neighbouring impulses of a scan; the paper's own are multiples of it [N s]."""

LARGEST_IMPULSE = 117.6
"""Where a scan ends [N s]."""

LEG_SPEEDS = (math.inf, 9.0, 8.0, 6.0, 4.0, 3.0)
"""Largest speeds of the swing foot; a search, since the paper names none [m/s]."""

HIPS = (0.2, 0.01)
OFFSET_WEIGHTS = (OFFSET_WEIGHT, (1e3, 1e3), (2e4, 2e4))
PENALTIES = (OFFSET_PENALTY, 0.0)
DIRECTIONS = ("+x", "+y", "-y")
"""Of the pushes, keys of `AXES`; the paper's limits are along x and along y."""

NEAR = 0.03
"""A limit this close to the paper's, as a fraction, counts as the same [-]."""


@dataclass(frozen=True)
class Assumptions:
    """What the paper leaves open, and where the push goes.

    Attributes:
        direction: of the push, one of `DIRECTIONS`.
        leg_speed: largest speed of the swing foot [m/s].
        hip: lateral distance of the sole centres [m].
        offset_weight: (a4, a5) [1/m^2].
        offset_penalty: on a violation of the offset bounds; 0 for no bounds [1/m^2].
        lands_during_push: whether a step may end while the push still acts.
        nominal: what counts as absorbed: d nominal again within `NOMINAL`, or else |d| inside the
            printed bounds, as a program with hard bounds needs.
    """

    direction: str
    leg_speed: float
    hip: float
    offset_weight: tuple[float, float]
    offset_penalty: float
    lands_during_push: bool
    nominal: bool

    @property
    def words(self) -> str:
        """All but the direction."""
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


@dataclass(frozen=True)
class OneStepLimit(Assumptions):
    """Assumptions, and the largest impulse that one step absorbs under them.

    Attributes:
        impulse: the largest of the scan up to which every adapted step absorbs its push; 0 if
            none does, inf if all do [N s].
    """

    impulse: float

    @classmethod
    def of(cls, row: Row) -> OneStepLimit:
        """The limit that a row of a study holds."""
        values: Row = {**row, "offset_weight": tuple(row["offset_weight"])}
        return cls(**values)


def every_assumption() -> Iterator[Assumptions]:
    """Every direction under every set of assumptions; those of the same landings in succession."""
    for hip, speed, weight, penalty, direction, lands, nominal in itertools.product(
        HIPS, LEG_SPEEDS, OFFSET_WEIGHTS, PENALTIES, DIRECTIONS, (True, False), (True, False)
    ):
        yield Assumptions(direction, speed, hip, weight, penalty, lands, nominal)


def one_step_impulse(robot: Robot, given: Assumptions) -> float:
    """The impulse of a `OneStepLimit` [N s].

    Args:
        robot: mass, height, limits and foot; hip and leg speed are those that are given.
        given: the assumptions.
    """
    varied = robot.replace(hip=given.hip).with_leg(max_speed=given.leg_speed)
    controller = HybridController(
        varied, VELOCITY, tau_weight=1.0, offset_weight=given.offset_weight,
        offset_penalty=given.offset_penalty,
    )  # fmt: skip
    landings = _landings(controller, given.direction)
    absorbed = _absorbed(controller, landings, given.nominal)
    if not given.lands_during_push:
        absorbed &= landings["time"] >= PUSH_DELAY + PUSH_DURATION - 1e-9
    return _largest(absorbed, landings["adapted"])


@lru_cache(maxsize=1)
def _landings(controller: HybridController, direction: str) -> NDArray[np.void]:
    """Where and when the pushed step lands, for every impulse of the scan."""
    count = math.floor(LARGEST_IMPULSE / IMPULSE_STEP) + 1
    pushes = [
        Push.of_impulse(impulse, AXES[direction], PUSH_DELAY, PUSH_DURATION)
        for impulse in (IMPULSE_STEP * np.arange(count)).tolist()
    ]
    return pushed_landings(controller, pushes)


def nearest_limits(
    rows: Sequence[OneStepLimit], target: float, *, along_x: bool
) -> list[OneStepLimit]:
    """The rows that come closest to an impulse [N s], all of them if several are equally close."""
    chosen = [row for row in rows if row.direction.endswith("x") == along_x]
    closest = min(abs(row.impulse - target) for row in chosen)
    return [row for row in chosen if abs(row.impulse - target) <= closest + 1e-9]


def limits_by_assumptions(
    rows: Sequence[OneStepLimit],
) -> list[tuple[str, tuple[float, float, float]]]:
    """The same table with one row for each set of assumptions.

    Returns:
        Assumptions in words with the impulses towards +x, +y and -y [N s]; the set that comes
        nearest to both of the paper's limits at once is the first.
    """
    sets: dict[str, dict[str, float]] = {}
    for row in rows:
        sets.setdefault(row.words, {})[row.direction] = row.impulse

    def miss(impulses: tuple[float, float, float]) -> float:
        sideways = min(abs(impulse - PAPER_Y) for impulse in impulses[1:])
        return abs(impulses[0] - PAPER_X) / PAPER_X + sideways / PAPER_Y

    table = [(words, (one["+x"], one["+y"], one["-y"])) for words, one in sets.items()]
    return sorted(table, key=lambda entry: miss(entry[1]))


def claim_one_step(limits: Sequence[OneStepLimit], target: float, *, along_x: bool) -> Claim:
    """The largest impulse that one step absorbs, under the assumptions that come nearest.

    With the step at its longest, T shrinks as the impulse grows, until the foot lands before the
    push ends: whether it may decides more than all else.
    """
    nearest = nearest_limits(limits, target, along_x=along_x)
    strict = nearest_limits([row for row in limits if row.nominal], target, along_x=along_x)
    near = abs(nearest[0].impulse - target) <= NEAR * target
    axis = "x" if along_x else "y"
    both, (x, y, minus_y) = limits_by_assumptions(limits)[0]
    return Claim(
        "IV-B, one step",
        f"largest impulse in {axis} that one step absorbs",
        f"{target:g} N s",
        f"nearest: {nearest[0].direction} {nearest[0].impulse:.2f} N s ({nearest[0].words}); "
        f"with d = d_nom required: {strict[0].direction} {strict[0].impulse:.2f} N s "
        f"({strict[0].words})",
        UNDER_ASSUMPTIONS if near else NOT_REPRODUCED,
        f"the paper states no assumptions, so all {len(limits)} limits of the table were searched. "
        f"One set comes nearest to both numbers at once: {both}: +x {x:.2f}, +y {y:.2f}, "
        f"-y {minus_y:.2f} N s. A leg speed found by a search is an explanation, no proof",
    )


def limits_table(rows: Sequence[OneStepLimit]) -> Table:
    """The table of assumptions in words."""
    return Table(
        "One-step limits under every set of assumptions",
        f"The largest impulse that one step absorbs, scanned upwards by {IMPULSE_STEP:g} N s to "
        f"{LARGEST_IMPULSE:g} N s from the smallest that is answered by a step. The paper reports "
        f"{PAPER_X:g} N s along x and {PAPER_Y:g} N s along y; the set nearest to both is first. "
        "A step that lands during the push is only counted as a failure where that is excluded, "
        "the controller is not told.",
        ("assumptions", "+x [N s]", "+y [N s]", "-y [N s]"),
        [
            (words, *(_impulse_words(impulse) for impulse in impulses))
            for words, impulses in limits_by_assumptions(rows)
        ],
    )


def _impulse_words(impulse: float) -> str:
    return f"over {LARGEST_IMPULSE:g}" if math.isinf(impulse) else f"{impulse:.2f}"


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
        return np.asarray((np.abs(offset - d_nom) <= NOMINAL).all(axis=1))
    bound = np.maximum(controller.robot.gait.dcm_offset, np.abs(d_nom))
    return np.asarray((np.abs(offset) <= bound + NOMINAL).all(axis=1))

"""Two numbers for a controller: what pushes it survives, and how gently it answers small ones.

Survival is the mean, over directions and phases of a step, of

    survived impulse / theoretical limit.

Effort is the mean, over the same small pushes, of three shares of what the robot has, with weights:

     1   distance of the ZMP from the centre   over  half the diagonal of the sole
    10   largest change of a step vector       over  that to the farthest corner of the step box
    10   largest change of a step's duration   over  the most that it can change

The distance of the ZMP is the mean of its peak and its root mean square: a controller that never
moves an error away has small peaks for ever. Shares, since the ratio of a quantity that the default
does not move is none. Gentleness is the effort over that of the default: below 1 is gentler.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from surefoot.dcm.nominal_gait import NominalGait
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.studies.engine.pushed_walk import PUSHED_SIDE, Answer, PushCell, PushedWalk, answer
from surefoot.studies.engine.scan import LARGEST_SHARE, smallest_failing_push

STEP_WEIGHT = 10.0
"""Of the shares of landing and timing against that of the ZMP [-]. A ZMP that stays under the sole
costs little; if all counted alike, the gentlest would step aside at every touch."""


@dataclass(frozen=True)
class Pushed:
    """A cell with its theoretical limit [N s]."""

    cell: PushCell
    limit: float


@dataclass(frozen=True)
class Score:
    """How a controller does.

    Attributes:
        survival: mean share of the limit that is survived [-].
        worst: the smallest share [-].
        worst_angle: where [deg].
        worst_phase: where, as a fraction of the step.
        effort: see the top of this file [-].
        zmp: the share that is the ZMP's [-].
        landing: likewise of the landing place [-].
        timing: likewise of the landing time [-].
    """

    survival: float
    worst: float
    worst_angle: float
    worst_phase: float
    effort: float
    zmp: float
    landing: float
    timing: float

    def gentleness(self, default: Score) -> float:
        """How much a small push moves, over how much it moves with the default [-]."""
        return self.effort / default.effort


def score(
    controller: Controller,
    walk: PushedWalk,
    cells: Sequence[Pushed],
    impulse: float,
    step: float,
    *,
    workers: int | None = None,
) -> Score:
    """Push a controller in every cell: up to where it fails, and once a little.

    Args:
        controller: what decides.
        walk: says when and where to.
        cells: the pushes, at least one.
        impulse: of the small ones [N s].
        step: of the scan over the impulse [N s].
        workers: threads, all cores if None; their number changes nothing.
    """
    shares = [survived(controller, walk, one, step, workers) / one.limit for one in cells]
    efforts = [
        effort_of(answer(controller, walk.push(one.cell, impulse)), controller) for one in cells
    ]
    zmp, landing, timing = (math.fsum(part) / len(cells) for part in zip(*efforts, strict=True))
    worst = int(np.argmin(shares))
    return Score(
        survival=math.fsum(shares) / len(shares),
        worst=shares[worst],
        worst_angle=cells[worst].cell.angle,
        worst_phase=cells[worst].cell.phase,
        effort=zmp + STEP_WEIGHT * (landing + timing),
        zmp=zmp,
        landing=landing,
        timing=timing,
    )


def survived(
    controller: Controller,
    walk: PushedWalk,
    pushed: Pushed,
    step: float,
    workers: int | None = None,
) -> float:
    """The largest impulse below which all are survived [N s]."""
    cell = pushed.cell
    return smallest_failing_push(
        controller,
        walk.direction(cell.angle),
        start=walk.start(cell.phase),
        duration=cell.push_duration,
        step=step,
        largest=LARGEST_SHARE * pushed.limit,
        first_support=PUSHED_SIDE,
        workers=workers,
    ).survived


def effort_of(answered: Answer, controller: Controller) -> tuple[float, float, float]:
    """Shares of what the robot has that ZMP, landing and timing took; all of it if it fell."""
    if not answered.survived:
        return (1.0, 1.0, 1.0)
    robot, gait = controller.robot, controller.gait
    zmp = 0.5 * (answered.zmp_peak + answered.zmp_rms) / math.hypot(*robot.foot.half)
    return (
        zmp,
        answered.landing / farthest_landing(robot, gait),
        answered.timing / largest_delay(robot, gait),
    )


def farthest_landing(robot: Robot, gait: NominalGait) -> float:
    """From a nominal step to the farthest corner of its box [m]."""
    return max(
        math.hypot(x - gait.step(side)[0], y - gait.step(side)[1])
        for side in Side
        for low, high in [robot.gait.step_box(side, robot.hip)]
        for x in (low[0], high[0])
        for y in (low[1], high[1])
    )


def largest_delay(robot: Robot, gait: NominalGait) -> float:
    """The most by which a step can be shorter or longer than nominally [s]."""
    low, high = robot.gait.step_duration
    return max(gait.step_duration - low, high - gait.step_duration)

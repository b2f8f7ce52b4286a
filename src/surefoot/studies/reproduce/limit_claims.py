"""What [OnlineGait] claims about the largest pushes, beside what is measured here."""

from __future__ import annotations

from surefoot.control.hybrid import HybridController
from surefoot.control.tracking import DcmTracking
from surefoot.robot.robot import Robot
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout
from surefoot.studies.engine.scan import PushLimit, smallest_failing_push
from surefoot.studies.reproduce.claim import NOT_REPRODUCED, UNDER_ASSUMPTIONS, Claim
from surefoot.studies.reproduce.one_step import OneStepLimit, limits_by_assumptions, nearest_limits
from surefoot.studies.reproduce.paper_scenarios import (
    DOUBLE_SUPPORT,
    FIG_8_PUSH,
    HEADLINE_PUSH,
    VELOCITY,
)

NEAR = 0.03
"""A limit this close to the paper's, as a fraction, counts as the same [-]."""

LEG_SPEED = 3.0
"""Of a leg that is not ideal, for the headline [m/s]."""

DIRECTIONS = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0), "+y": (0.0, 1.0), "-y": (0.0, -1.0)}


def claim_one_step(limits: list[OneStepLimit], target: float, *, along_x: bool) -> Claim:
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
        f"nearest: {_way(nearest[0])} {nearest[0].impulse:.2f} N s ({nearest[0].assumptions}); "
        f"with d = d_nom required: {_way(strict[0])} {strict[0].impulse:.2f} N s "
        f"({strict[0].assumptions})",
        UNDER_ASSUMPTIONS if near else NOT_REPRODUCED,
        f"the paper states no assumptions, so all {len(limits)} limits of the table were searched. "
        f"One set comes nearest to both numbers at once: {both}: +x {x:.2f}, +y {y:.2f}, "
        f"-y {minus_y:.2f} N s. A leg speed found by a search is an explanation, no proof",
    )


def claim_headline(walk: Rollout, failing: dict[str, dict[str, float]]) -> Claim:
    """85 N s is survived; `failing` is the smallest impulse that is not, by leg and direction."""
    limits = "; ".join(
        f"{leg}: " + ", ".join(f"{name} {impulse:g}" for name, impulse in ways.items())
        for leg, ways in failing.items()
    )
    return Claim(
        "abstract",
        f"hybrid, {HEADLINE_PUSH.impulse[0]:g} N s on {walk.robot.mass:g} kg",
        "withstands 85 N s, against 20 N s of foot placement alone",
        f"{ending(walk)} in +x; smallest failing impulses in N s, {limits}",
        UNDER_ASSUMPTIONS if walk.outcome is Outcome.RECOVERED else NOT_REPRODUCED,
        "unlimited leg, as in the paper, +x from 1.1 s for 0.2 s; a leg of 3 m/s fails "
        "earlier, as the numbers show. Foot placement alone (20 N s) is not run here",
    )


def smallest_failing(robot: Robot) -> dict[str, float]:
    """The smallest impulse that fails in each direction [N s]."""
    controller = HybridController(robot, VELOCITY)
    return {
        name: smallest_failing_push(controller, way).impulse for name, way in DIRECTIONS.items()
    }


def tracking_limit(robot: Robot) -> PushLimit:
    """The smallest push like that of Fig. 8 that tracking with a finite foot does not survive."""
    controller = DcmTracking(robot, VELOCITY, double_support=DOUBLE_SUPPORT)
    start, duration = FIG_8_PUSH.start, FIG_8_PUSH.duration
    return smallest_failing_push(
        controller, (1.0, 0.0), start=start, duration=duration, step=0.2, largest=80.0
    )


def _way(limit: OneStepLimit) -> str:
    return next(name for name, way in DIRECTIONS.items() if way == limit.direction)


def ending(walk: Rollout) -> str:
    """Survived or fell."""
    return "survived" if walk.outcome is not Outcome.FELL else "fell"

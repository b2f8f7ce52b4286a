"""The limit of a push whose end nobody knows once more, from a grid: a check of
`dcm.causal_limit`.

Backward value iteration as in `dcm.limit_grid`, but through the push with both bounds of every
state at once, each cut off at what is viable unpushed: `Sweep.causal_push`. No schedule of landings
and no discounted sum occurs in it, and where the ZMP and the foot are at best comes out by itself.
What a force does is not linear here, so the largest force is found by bisection. Axes are apart.

The next landing waits for a time step too long on average half of the time: with time steps of 4 ms
that is up to 1 % of the limit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.causal_limit import causal_push_limit
from surefoot.dcm.limit_grid import (
    INTERVALS,
    LEVELS,
    SHORTEST_PUSH,
    TIME_STEP,
    Disagreement,
    between_nodes,
)
from surefoot.dcm.limit_sweep import Sweep
from surefoot.dcm.nominal_gait import nominal_gait
from surefoot.dcm.push_limit import axis_directions, check_leg, gait_in_step, push_limit
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

PRECISION = 1e-3
"""The bisection ends at this part of the limit of a push that is known [-]."""

BEYOND = 1.05
"""It begins this far above that [-]."""


def causal_grid_limit(
    robot: Robot,
    direction: tuple[float, float],
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    elapsed: float = 0.1,
    duration: float = 0.2,
    support_side: Side = Side.RIGHT,
    zmp_reach: tuple[float, float] = (0.0, 0.0),
    time_step: float = TIME_STEP,
    intervals: int = INTERVALS,
    levels: int = LEVELS,
) -> float:
    """The impulse of `causal_push_limit` along an axis, from the grid [N s].

    Args:
        robot: whose limits hold.
        direction: of the push (x, y), along an axis.
        velocity, elapsed, duration, support_side, zmp_reach: as in `push_limit`.
        time_step, intervals, levels: as in `limit_grid`.
    """
    check_number("duration", duration, SHORTEST_PUSH, "s")
    gait = nominal_gait(robot, velocity)
    check_leg(robot, gait)
    axis = 0 if direction[1] == 0.0 else 1
    along = direction[axis] * (1 if axis == 0 else support_side)
    row = 0 if along > 0.0 else 1
    offset, foot, foot_velocity = (pair[axis] for pair in gait_in_step(gait, support_side, elapsed))
    offset = offset if row == 0 else -offset
    sweep = Sweep.of(robot, axis, duration, zmp_reach[axis], time_step, intervals, levels)
    settled, nodes = sweep.settle(), (sweep.times, sweep.speeds, sweep.feet)

    def survives(force: float) -> bool:
        table = sweep.causal_push(settled, force)[row]
        with np.errstate(invalid="ignore"):
            ahead, behind = (
                between_nodes(table[side], nodes, elapsed, foot_velocity, foot)
                for side in (row, 1 - row)
            )
        return ahead >= offset and behind >= -offset

    known = push_limit(
        robot, direction, velocity=velocity, elapsed=elapsed, duration=duration,
        support_side=support_side, zmp_reach=zmp_reach, together=False,
    ).impulse  # fmt: skip
    scale = robot.mass * robot.omega**2 * duration
    least, most = 0.0, BEYOND * known / scale
    while most - least > PRECISION * known / scale:
        middle = 0.5 * (least + most)
        least, most = (middle, most) if survives(middle) else (least, middle)
    return 0.5 * (least + most) * scale


def largest_causal_disagreement(
    robots: Sequence[Robot],
    phases: Sequence[float],
    *,
    velocity: tuple[float, float] = (0.5, 0.0),
    duration: float = 0.2,
) -> Disagreement:
    """Compare `causal_push_limit` with the grid where not to know the end costs most.

    That is one direction and phase for each robot, for a point foot and for the whole sole.

    Args:
        robots: the same one with several legs, for example.
        phases: times from the touchdown of the right foot to the push [s].
        velocity, duration: as in `push_limit`.

    Returns:
        Where they differ most.
    """
    found = []
    for robot in robots:
        for reach in ((0.0, 0.0), robot.foot.half):
            cells = []
            for name, direction in axis_directions(Side.RIGHT).items():
                for elapsed in phases:
                    known, causal = (
                        limit(
                            robot, direction, velocity=velocity, elapsed=elapsed,
                            duration=duration, zmp_reach=reach, together=False,
                        ).impulse
                        for limit in (push_limit, causal_push_limit)
                    )  # fmt: skip
                    if known > 0.0:
                        cells.append((causal / known, elapsed, name, direction, causal))
            if not cells:
                continue
            _, elapsed, name, direction, impulse = min(cells)
            other = causal_grid_limit(
                robot, direction, velocity=velocity, elapsed=elapsed, duration=duration,
                zmp_reach=reach,
            )  # fmt: skip
            found.append(
                Disagreement(
                    abs(impulse - other) / max(impulse, other), name, elapsed,
                    robot.swing.max_speed, robot.swing.max_acceleration, reach[0] > 0.0,
                    impulse, other,
                )
            )  # fmt: skip
    return max(found, key=lambda one: one.fraction)

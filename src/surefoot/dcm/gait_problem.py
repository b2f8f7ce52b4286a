"""The step problem of a gait: its nominal values, the robot's limits, and weights."""

from __future__ import annotations

import math

from surefoot.dcm.nominal_gait import NominalGait
from surefoot.dcm.step_problem import StepProblem
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot


def gait_problem(
    robot: Robot,
    gait: NominalGait,
    support_side: Side,
    offset_bounds: tuple[tuple[float, float], tuple[float, float]],
    growth: tuple[float, float] | None = None,
    elapsed: float = 0.0,
    *,
    step_weight: tuple[float, float],
    tau_weight: float,
    offset_weight: tuple[float, float],
    offset_penalty: float,
) -> StepProblem:
    """The step problem of a step in a gait.

    The offset bounds are widened where needed so that they hold the nominal offset: a fast gait
    must not be pulled away from itself.

    Args:
        robot: whose limits hold.
        gait: what is nominal.
        support_side: foot on the ground.
        offset_bounds: least and largest d (x, y) [m].
        growth: (A, B), the nominal gait if None [m].
        elapsed: t, time since touchdown [s].
        step_weight: (a1, a2) [1/m^2].
        tau_weight: a3 [-].
        offset_weight: (a4, a5) [1/m^2].
        offset_penalty: rho, on half the squared violation [1/m^2].
    """
    d_nom, (lower, upper) = gait.dcm_offset(support_side), offset_bounds
    step_min, step_max = robot.gait.step_box(support_side, robot.hip)
    shortest, longest = robot.gait.step_duration
    shortest = max(shortest, elapsed)
    return StepProblem(
        growth=gait.start_offset(support_side) if growth is None else growth,
        nominal_step=gait.step(support_side),
        nominal_tau=gait.growth,
        nominal_offset=d_nom,
        step_min=step_min,
        step_max=step_max,
        tau_min=math.exp(robot.omega * shortest),
        tau_max=math.exp(robot.omega * longest),
        offset_min=(min(lower[0], d_nom[0]), min(lower[1], d_nom[1])),
        offset_max=(max(upper[0], d_nom[0]), max(upper[1], d_nom[1])),
        step_weight=step_weight,
        tau_weight=tau_weight,
        offset_weight=offset_weight,
        offset_penalty=offset_penalty,
    )

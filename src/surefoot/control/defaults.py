"""Defaults that follow from the robot and its gait, so that similar robots decide alike.

What a controller leaves out is given here in the robot's own units: lengths as parts of R, see
`dcm.nominal_gait.gait_room`, rates as multiples of omega. For the paper's biped at 0.5 m/s R
is 0.248 m, tau_nom 5.76 and omega 3.50 1/s, and the values are those of [OnlineGait].
"""

from __future__ import annotations

import math

from surefoot.dcm.nominal_gait import NominalGait, gait_room
from surefoot.robot.robot import STANDARD_GRAVITY, Robot

DCM_GAIN = 3.0 / math.sqrt(STANDARD_GRAVITY / 0.8)
"""K_f / omega, 0.857: the paper's 3 1/s on its own biped, whose CoM is at 0.8 m."""

THRESHOLD = 0.1
"""The DCM error at which steps are decided anew, as a part of R: 0.025 m for the paper's biped."""

TAU_WEIGHT = 540.0
"""Weight of (tau - tau_nom)^2 per (R / tau_nom)^2, beside a step weight of 1 [1/m^2]: so the whole
of tau costs as much as 23 R of the step. It is 1 for the paper's biped."""

LEAST_ROOM = 0.01
"""R is taken as no less than this part of the CoM's height; a gait at its limits has none left."""


def natural_length(robot: Robot, gait: NominalGait) -> float:
    """R with the whole sole, the length by which a robot measures what is much and little [m].

    Raises:
        RobotError: the leg is too slow to step at all.
    """
    return max(gait_room(robot, gait, robot.foot.half), LEAST_ROOM * robot.com_height)


def default_tau_weight(robot: Robot, gait: NominalGait, share: float = TAU_WEIGHT) -> float:
    """a3 that weighs a deviation of tau by what it is of tau_nom, and a length by what it is of R.

    Args:
        robot: whose limits hold.
        gait: what is nominal.
        share: a3 tau_nom^2 / R^2 [1/m^2].
    """
    return share * (natural_length(robot, gait) / gait.growth) ** 2


def default_threshold(robot: Robot, gait: NominalGait) -> float:
    """The DCM error at which steps are decided anew [m]."""
    return THRESHOLD * natural_length(robot, gait)

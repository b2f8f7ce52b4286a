"""The three-mass pendulum: a trunk and two legs with mass, all at constant heights ([Kim2019]).

The CoM of a leg lies at the fraction `com` of the line from its hip to its foot, and the leg turns
about it. With x_b of the trunk, which stays upright over the hips, and f_1, f_2 of the feet,

    sum m_i g (x_i - zmp) = sum m_i z_i x_i'' + sum (I / l) (x_b - f_i)'' - z_c F

is linear. Written for the CoM c of all three, with one foot at rest and the other at f,

    c'' = omega'^2 (c - zmp + F z_c / (m g) + kappa f''),      omega'^2 = g / z',

    z' = H / mu,   mu = m_b + 2 (1 - com) m_l,   H = m_b z_b + 2 (1 - com) m_l z_l + 2 I / l,
    kappa = (com m_l (z' - z_l) + I / l) / (m g).

So heavy legs make the pendulum longer, and a foot that is accelerated pushes the CoM along.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from surefoot.robot.robot import Robot


class ThreeMass(NamedTuple):
    """What the legs' masses do to the pendulum.

    Attributes:
        height: z', of the pendulum that moves like the CoM [m].
        foot_gain: kappa, shift of the ZMP that acts like an acceleration of the foot [s^2].
    """

    height: float
    foot_gain: float


def three_mass(robot: Robot, *, compensated: bool = False) -> ThreeMass:
    """The pendulum of a robot; that of a point mass unless its legs are `heavy`.

    Args:
        robot: with its legs.
        compensated: whether legs that are `known` count as massless, since the ZMP is moved by what
            they need: so the pendulum is for a controller, as far as the soles reach.
    """
    legs, gravity = robot.legs, robot.gravity
    if legs is None or not legs.heavy or (compensated and legs.known):
        return ThreeMass(robot.com_height, 0.0)
    trunk_mass = robot.mass - 2.0 * legs.mass
    leg_height = (1.0 - legs.com) * legs.length
    trunk_moment = robot.mass * robot.com_height - 2.0 * legs.mass * leg_height
    turning = legs.inertia / legs.length
    hanging = 2.0 * (1.0 - legs.com) * legs.mass
    height = (trunk_moment + hanging * leg_height + 2.0 * turning) / (trunk_mass + hanging)
    gain = legs.com * legs.mass * (height - leg_height) + turning
    return ThreeMass(height, gain / (robot.mass * gravity))


def pendulum_omega(robot: Robot) -> float:
    """Natural frequency of the pendulum as it is moved [1/s]."""
    return math.sqrt(robot.gravity / three_mass(robot).height)

"""Which DCM offsets can still be saved by stepping: the viable set of the LIPM.

An offset d at touchdown is viable if some sequence of steps inside the gait limits keeps the DCM
bounded. With the fastest steps, E = e^(omega T_min), the extreme steady gaits bound the set
(Section III of [Khadiv2016], lateral pair corrected).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from surefoot.models.footsteps import Side
from surefoot.models.robot import Robot


@dataclass(frozen=True)
class ViableOffsets:
    """Bounds on the DCM offset d = dcm - p_next at touchdown, in the signs of the world.

    Attributes:
        lower: least viable (x, y) [m].
        upper: largest viable (x, y) [m].
    """

    lower: tuple[float, float]
    upper: tuple[float, float]

    def margin(self, offset: tuple[float, float]) -> float:
        """Distance to the nearest bound, negative outside [m]."""
        return min(
            *(value - low for value, low in zip(offset, self.lower, strict=True)),
            *(high - value for value, high in zip(offset, self.upper, strict=True)),
        )


def lateral_offsets(robot: Robot) -> tuple[float, float]:
    """The lateral bounds for a point foot, measured towards the swing side of the landed foot.

    The widest step after the shortest time holds the largest offset, e_max = (w_out - e_min) / E,
    and the narrowest one the least, e_min = (w_in - e_max) / E', each handing the other's bound to
    the next foot:

        e_min = (E w_in - w_out) / (E E' - 1),   e_max = (w_out - e_min) / E.

    E' = E as long as e_min is negative. Where the lateral range is narrow it is positive: then the
    DCM must not come too close to the foot, and waiting helps, E' = e^(omega T_max).

    Returns:
        e_min, e_max [m].
    """
    shortest, longest = (math.exp(robot.omega * time) for time in robot.gait.step_duration)
    inner, outer = robot.hip + robot.gait.step_y[0], robot.hip + robot.gait.step_y[1]
    least = shortest * inner - outer
    least /= shortest * (shortest if least < 0.0 else longest) - 1.0
    return least, (outer - least) / shortest


def viable_offsets(
    robot: Robot, support_side: Side, zmp_reach: tuple[float, float] = (0.0, 0.0)
) -> ViableOffsets:
    """The viable offsets at the end of a step in the given support.

    Args:
        robot: whose gait limits count; its swing speed is taken as unlimited.
        support_side: foot on the ground DURING the step; d belongs to the other one.
        zmp_reach: how far the ZMP can move from the centre of the foot: (0, 0) for a point foot,
            `robot.foot.half` for the whole sole (x, y) [m].

    Returns:
        The bounds.
    """
    support_side = Side(support_side)
    growth = math.exp(robot.omega * robot.gait.step_duration[0])
    low_x, high_x = (step / (growth - 1.0) for step in robot.gait.step_x)
    low_e, high_e = lateral_offsets(robot)
    low_y, high_y = (-high_e, -low_e) if support_side is Side.RIGHT else (low_e, high_e)
    return ViableOffsets(
        (low_x - zmp_reach[0], low_y - zmp_reach[1]),
        (high_x + zmp_reach[0], high_y + zmp_reach[1]),
    )

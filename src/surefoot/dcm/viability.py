"""Which DCM offsets can still be saved by stepping: the viable set of the LIPM.

An offset d at touchdown is viable if some sequence of steps inside the gait limits keeps the DCM
bounded. With the fastest steps, E = e^(omega T_min), the extreme steady gaits bound the set
(Section III of [Khadiv2016], lateral pair corrected).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.leg import reach
from surefoot.geometry import rotated
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot


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


def viable_landings(robot: Robot, observation: Any, command: Any) -> NDArray[np.float64]:
    """The box of landings that can still be saved, at the planned end of the step.

    The step under way ends at time T; with the ZMP where it is, the DCM is then

        xi(T) = zmp + (xi - zmp) e^(omega (T - t)),

    and a landing u can be saved if xi(T) - u is a viable offset, u is in the box of steps, and the
    leg gets there in time. All three are boxes along the axes of the standing foot.

    Args:
        robot: whose limits hold.
        observation: an `Observation` record.
        command: the `Command` record that answers it; its duration and ZMP count.

    Returns:
        Least and largest (x, y) from the standing sole, along its own heading, shape (2, 2) [m];
        where a least value is above a largest one nothing can be saved.
    """
    side = Side(int(observation["support_side"]))
    left = max(float(command["step_duration"] - observation["elapsed"]), 0.0)
    yaw = float(observation["support_yaw"])
    foot = observation["support_foot"]
    zmp = np.array(rotated(command["zmp"] - foot, -yaw))
    dcm = np.array(rotated(observation["dcm"] - foot, -yaw))
    swing = np.array(rotated(observation["swing_foot"][:2] - foot, -yaw))
    velocity = np.array(rotated(observation["swing_foot_velocity"][:2], -yaw))
    end = zmp + (dcm - zmp) * math.exp(min(robot.omega * left, 20.0))
    offsets = viable_offsets(robot, side, robot.foot.half)
    low, high = end - offsets.upper, end - offsets.lower
    box = np.array(robot.gait.step_box(side, robot.hip))
    limits = robot.swing.max_speed, robot.swing.max_acceleration
    for axis in range(2):
        least, most = reach(swing[axis], velocity[axis], left, *limits)
        low[axis] = max(low[axis], box[0, axis], least)
        high[axis] = min(high[axis], box[1, axis], most)
    return np.array([low, high])


def fall_distance(robot: Robot, known: Robot | None = None) -> float:
    """How far the DCM can be from the support foot at most, if it can still be saved [m].

    With the DCM e from the foot that stands, a step s after a time T leaves
    e' = p + (e - p) e^(omega T) - s for a ZMP p. Where e' stays bounded for ever, e is the sum of
    all steps to come and of what the ZMP does meanwhile, each discounted by e^(-omega t). No step
    is longer than L, and all but the first, which may land at once, take T_min at least. So, with
    E = e^(omega T_min),

        |e| <= L (1 + 1/E + 1/E^2 + ...) + |c| = L E / (E - 1) + |c|,
        L = hypot(the largest |X|, the largest |width|),

    for whatever leg, in the middle of a step too, on soles that turn, and while both feet share the
    load, since no foot is further away than L. A foot that comes short is between two such places.
    A trunk of inertia J adds what its lean a, |a| <= a_max, can discounted do to the DCM, twice by
    parts: |integral of e^(-omega t) J da'| / (m h omega) <= J (v + 2 omega a_max) / (m h omega), at
    most v = 2 sqrt(a_max torque / J) fast. Conversely an offset that cannot be saved, by m0, is
    beyond any distance d after ln((d + |e|) / m0) / omega at the latest. Own derivation.

    Args:
        robot: that is moved, whatever its leg can do.
        known: the one that its controller knows, if that is another: its steps count too.
    """
    own = _farthest(robot)
    if known is None:
        return own
    # What the controller steps like, with the pendulum and the trunk that are there.
    moved = {name: getattr(robot, name) for name in ("mass", "com_height", "gravity", "trunk")}
    return max(own, _farthest(known.replace(**moved)))


def _farthest(robot: Robot) -> float:
    gait, omega = robot.gait, robot.omega
    length = max(abs(bound) for bound in gait.step_x)
    width = max(abs(robot.hip + bound) for bound in gait.step_y)
    reach, trunk, help_of_trunk = robot.foot.half, robot.trunk, 0.0
    if trunk is not None:
        speed = 2.0 * math.sqrt(trunk.max_lean * trunk.max_torque / trunk.inertia)
        most = trunk.inertia * (speed + 2.0 * omega * trunk.max_lean)
        help_of_trunk = most / (robot.mass * robot.com_height * omega)
    # E / (E - 1), for an E close to 1 too.
    steps = math.hypot(length, width) / -math.expm1(-omega * gait.step_duration[0])
    return steps + math.hypot(reach[0] + help_of_trunk, reach[1] + help_of_trunk)

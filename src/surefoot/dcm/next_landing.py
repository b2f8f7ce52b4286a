"""Where the next foot may land so that further steps can still save the robot.

The step under way ends at time T; with the ZMP where it is, the DCM is then

    xi(T) = zmp + (xi - zmp) e^(omega (T - t)),

and a landing u can be saved if xi(T) - u is a viable offset, u is in the box of steps, and the leg
gets there in time. All three are boxes along the axes of the standing foot.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.frame_turn import rotated
from surefoot.dcm.leg import furthest
from surefoot.dcm.viability import viable_offsets
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot


def viable_landings(robot: Robot, observation: Any, command: Any) -> NDArray[np.float64]:
    """The box of landings that can still be saved, at the planned end of the step.

    Args:
        robot: whose limits hold.
        observation: an `OBSERVATION` record.
        command: the `COMMAND` record that answers it; its duration and ZMP count.

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
    speed, most = robot.swing.max_speed, robot.swing.max_acceleration
    for axis in range(2):
        ahead = furthest(velocity[axis], left, speed, most)
        behind = furthest(-velocity[axis], left, speed, most)
        low[axis] = max(low[axis], box[0, axis], swing[axis] - behind)
        high[axis] = min(high[axis], box[1, axis], swing[axis] + ahead)
    return np.array([low, high])

"""What walks, drawn: a point mass on two legs; the shapes of a body are in `body_figure`."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.snapshot import Snapshot
from surefoot.show import palette
from surefoot.show.palette import rgb

BONE, JOINT = 0.022, 0.032
"""Radius of bones and joints [m]."""

THICK = 0.03
"""A sole [m]."""

LINK = 0.62
"""Length of thigh and shank, of the height of the CoM [-]: long enough for the longest steps."""

SIDES = (Side.LEFT, Side.RIGHT)
"""In the order of `Snapshot.soles`."""

GHOST = "#8a8f98"
"""Colour of the second walk."""

Quaternion = tuple[float, float, float, float]
"""A rotation (w, x, y, z)."""

UP = np.array([0.0, 0.0, 1.0])


class Figure(Protocol):
    """Anything that walks in a scene."""

    def show(self, snapshot: Snapshot) -> None:
        """Take the pose of an instant."""
        ...

    def remove(self) -> None:
        """Leave the scene."""
        ...


class PointFigure:
    """Pelvis, legs with knees, and soles.

    The pendulum itself has only soles: the rest is drawn to show the robot that it stands for.

    Args:
        scene: of viser.
        name: where in the tree of the scene.
        robot: whose sizes count.
        opacity: 1 or less of a ghost.
    """

    def __init__(self, scene: Any, name: str, robot: Robot, opacity: float = 1.0) -> None:
        self._height, self._hip = robot.com_height, robot.hip
        self._root = scene.add_frame(name, show_axes=False)
        self._link = LINK * robot.com_height
        see = {"opacity": None if opacity == 1.0 else opacity}
        dark = rgb("#3b4350" if opacity == 1.0 else GHOST)
        self._pelvis = scene.add_box(f"{name}/pelvis", dark, (0.07, robot.hip, 0.05), **see)
        self._soles, self._bones, self._joints = [], [], []
        for side in SIDES:
            tag, size = side.name.lower(), (robot.foot.length, robot.foot.width, THICK)
            colour = rgb(palette.SOLE_EDGE[side]) if opacity == 1.0 else dark
            self._soles.append(scene.add_box(f"{name}/{tag}_sole", colour, size, **see))
            for part in ("thigh", "shank"):
                bone = scene.add_cylinder(
                    f"{name}/{tag}_{part}", BONE, self._link, colour, radial_segments=16, **see
                )
                self._bones.append(bone)
            for part in ("hip", "knee"):
                ball = scene.add_icosphere(f"{name}/{tag}_{part}", JOINT, colour, **see)
                self._joints.append(ball)

    def show(self, snapshot: Snapshot) -> None:
        """Take the pose of an instant."""
        x, y = snapshot.observation["com"]
        soles = snapshot.soles()
        yaw = math.atan2(np.sin(soles[:, 3]).mean(), np.cos(soles[:, 3]).mean())
        ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        aside = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
        middle = np.array([x, y, self._height])
        self._pelvis.position, self._pelvis.wxyz = middle, about_z(yaw)
        for row, side in enumerate(SIDES):
            place, heading = soles[row, :3], float(soles[row, 3])
            sole = self._soles[row]
            sole.position = place + 0.5 * THICK * UP
            sole.wxyz = about_z(heading)
            hip = middle - 0.5 * self._hip * side * aside
            self._bend(2 * row, hip, place + THICK * UP, ahead)

    def _bend(
        self, first: int, hip: NDArray[Any], ankle: NDArray[Any], ahead: NDArray[Any]
    ) -> None:
        """A leg with its knee ahead of the line from hip to ankle."""
        way = ankle - hip
        length = float(np.linalg.norm(way))
        half = min(0.5 * length, self._link)
        out = ahead - way * float(ahead @ way) / length**2
        out /= max(float(np.linalg.norm(out)), 1e-9)
        knee = hip + 0.5 * way + math.sqrt(self._link**2 - half**2) * out
        for index, (top, bottom) in enumerate(((hip, knee), (knee, ankle))):
            bone = self._bones[first + index]
            bone.position, bone.wxyz = 0.5 * (top + bottom), z_towards(top - bottom)
        self._joints[first].position, self._joints[first + 1].position = hip, knee

    def remove(self) -> None:
        """Leave the scene."""
        self._root.remove()


def about_z(yaw: float) -> Quaternion:
    """A heading [rad]."""
    return (math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw))


def z_towards(direction: ArrayLike) -> Quaternion:
    """The shortest rotation of the z axis into a direction that is not zero, shape (3,)."""
    x, y, z = np.asarray(direction, float) / np.linalg.norm(direction)
    if z < -1.0 + 1e-9:
        return (0.0, 1.0, 0.0, 0.0)
    w = math.sqrt(0.5 * (1.0 + z))
    return (w, -y / (2.0 * w), x / (2.0 * w), 0.0)

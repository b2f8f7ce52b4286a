"""What is drawn in the scene: who walks, and what a walk is about: points, soles, the push."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.dcm.viability import viable_landings
from surefoot.geometry import rotated
from surefoot.live.figure import SIDES, Figure, about_z, z_towards
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.snapshot import Snapshot
from surefoot.show import palette
from surefoot.show.palette import rgb

ASIDE = 1.4
"""How far to the left of the walk its ghost walks: behind it in the first view of a tab [m]."""

TRANSPARENT = 0.35
"""A ghost."""

FOLLOWING = 0.12
"""Part of the distance to the robot that the view moves in a frame [-]."""

ROOT = "/world"

MakeFigure = Callable[[Any, str, float], Figure]
"""A figure from the scene, its name in it, and its opacity."""

REGION = palette.ADAPTED
"""Colour of the landings that can still be saved."""

PRINTS = 14
"""Footprints that are left behind."""

FLAT = 0.004
"""Thickness of what lies on the floor [m]."""

HEIGHTS = {"region": 0.010, "prints": 0.013, "next": 0.018, "support": 0.034}
"""Of what lies on the floor, over it [m]: a browser without much depth mixes up what is nearer to
each other, and the support polygon lies on the sole."""

BALL = 0.034
"""Radius of the points [m]."""

FORCE = 0.0035
"""Length of a push's arrow for its force [m/N], at most `LONGEST`."""

LONGEST = 1.0

SHORTEST = 0.25
"""Of the arrow [m]."""

COARSE = 0.01
"""Sizes are rounded to it: to change a size costs a browser more than to move a shape [m]."""


@dataclass(frozen=True)
class Layer:
    """What can be switched on and off.

    Attributes:
        key: its name in the scene.
        label: its name on the page.
        colour: of its dot in the legend.
        meaning: what it is, in a few words.
    """

    key: str
    label: str
    colour: str
    meaning: str


LAYERS = (
    Layer("com", "CoM", palette.COM, "centre of mass, on its pendulum"),
    Layer("dcm", "DCM", palette.DCM, "where the CoM is falling to: it runs away from the ZMP"),
    Layer("zmp", "ZMP", palette.ZMP, "where the ground pushes; it stays inside the sole"),
    Layer("support", "support polygon", palette.ZMP, "the soles that carry: room for the ZMP"),
    Layer("next", "next footstep", palette.DCM_PLAN, "where the foot in the air is to land"),
    Layer("region", "viable region", REGION, "landings from which more steps can still save it"),
    Layer("prints", "footprints", palette.SOLE_EDGE[Side.LEFT], "where it has stood"),
    Layer("push", "push", palette.PUSH, "the force on it"),
)


class Marks:
    """The marks of one walk.

    Args:
        scene: of viser.
        name: where in the tree of the scene.
        robot: the point mass that the controller plans for: its limits and soles are drawn.
        shown: asked for each layer by its key.
    """

    def __init__(self, scene: Any, name: str, robot: Robot, shown: Callable[[str], bool]) -> None:
        self._robot, self._shown = robot, shown
        self._root = scene.add_frame(name, show_axes=False)
        self._last: tuple[float, float] | None = None
        self._count = 0
        length, width = robot.foot.length, robot.foot.width
        self._com = scene.add_icosphere(f"{name}/com", 0.055, rgb(palette.COM))
        self._pendulum = scene.add_cylinder(
            f"{name}/pendulum", 0.007, 1.0, rgb(palette.COM), radial_segments=8, opacity=0.5
        )
        self._dcm = scene.add_icosphere(f"{name}/dcm", BALL, rgb(palette.DCM))
        self._zmp = scene.add_icosphere(f"{name}/zmp", BALL, rgb(palette.ZMP))
        self._next = self._plate(scene, f"{name}/next", palette.DCM_PLAN, (length, width), 0.85)
        self._region = self._plate(scene, f"{name}/region", REGION, (1.0, 1.0), 0.25)
        self._support = [
            self._plate(scene, f"{name}/support_{i}", palette.ZMP, (length, width), 0.45)
            for i in range(2)
        ]
        self._prints = [
            self._plate(
                scene, f"{name}/print_{i}", palette.SOLE_EDGE[SIDES[i % 2]], (length, width), 0.55
            )
            for i in range(PRINTS)
        ]
        self._used, self._time = [False] * PRINTS, -math.inf
        self._shaft = scene.add_cylinder(f"{name}/shaft", 0.018, 1.0, rgb(palette.PUSH))
        self._head = scene.add_icosphere(f"{name}/head", 0.045, rgb(palette.PUSH))

    def _plate(
        self, scene: Any, name: str, colour: str, size: tuple[float, float], opacity: float
    ) -> Any:
        return scene.add_box(
            name, rgb(colour), (*size, FLAT), opacity=opacity, visible=False, cast_shadow=False
        )

    def show(self, snapshot: Snapshot) -> None:
        """Draw an instant."""
        shown, observed = self._shown, snapshot.observation
        if snapshot.time < self._time:
            # The walk begins again: it has left no footprints yet.
            self._used, self._last = [False] * PRINTS, None
        self._time = snapshot.time
        x, y = snapshot.floor_zmp
        com = np.array([*observed["com"], snapshot.com_height])
        self._com.visible = self._pendulum.visible = shown("com")
        self._com.position = com
        there = math.isfinite(x)
        self._zmp.visible, self._pendulum.visible = there and shown("zmp"), there and shown("com")
        if there:
            foot = np.array([x, y, 0.0])
            self._zmp.position = foot
            self._pendulum.position, self._pendulum.wxyz = 0.5 * (com + foot), z_towards(com - foot)
            self._pendulum.scale = (1.0, 1.0, _coarse(float(np.linalg.norm(com - foot))))
        self._dcm.visible = shown("dcm")
        self._dcm.position = np.array([*observed["dcm"], 0.0])
        self._show_soles(snapshot)
        self._show_landing(snapshot)
        self._show_push(snapshot, com)

    def _show_soles(self, snapshot: Snapshot) -> None:
        soles, carrying = snapshot.soles(), 0 if snapshot.support is Side.LEFT else 1
        for row, plate in enumerate(self._support):
            plate.visible = self._shown("support") and (snapshot.both_feet or row == carrying)
            plate.position = (*soles[row, :2], HEIGHTS["support"])
            plate.wxyz = about_z(float(soles[row, 3]))
        foot = (float(soles[carrying, 0]), float(soles[carrying, 1]))
        if self._last is None or math.dist(foot, self._last) > 0.02:
            # Left and right take turns, so that every shape keeps the colour of its side.
            if self._count % 2 != carrying:
                self._count += 1
            slot, self._last = self._count % PRINTS, foot
            self._count += 1
            self._used[slot], one = True, self._prints[slot]
            one.position, one.wxyz = (*foot, HEIGHTS["prints"]), about_z(float(soles[carrying, 3]))
        for used, one in zip(self._used, self._prints, strict=True):
            one.visible = used and self._shown("prints")

    def _show_landing(self, snapshot: Snapshot) -> None:
        observed, command = snapshot.observation, snapshot.command
        walking = not snapshot.both_feet
        self._next.visible = walking and self._shown("next")
        self._next.position = (*command["step_location"], HEIGHTS["next"])
        yaw = float(observed["support_yaw"])
        self._next.wxyz = about_z(float(command["swing_yaw"]))
        low, high = viable_landings(self._robot, observed, command)
        there = walking and bool((high - low > 0.0).all())
        self._region.visible = there and self._shown("region")
        if there:
            middle = observed["support_foot"] + np.array(rotated(0.5 * (low + high), yaw))
            self._region.position, self._region.wxyz = (*middle, HEIGHTS["region"]), about_z(yaw)
            self._region.scale = (_coarse(high[0] - low[0]), _coarse(high[1] - low[1]), 1.0)

    def _show_push(self, snapshot: Snapshot, com: Any) -> None:
        force = np.array([*snapshot.force, 0.0])
        strength = float(np.linalg.norm(force))
        self._shaft.visible = self._head.visible = strength > 0.0 and self._shown("push")
        if strength == 0.0:
            return
        way, length = force / strength, min(max(FORCE * strength, SHORTEST), LONGEST)
        tip = com - 0.1 * way
        self._head.position = tip
        self._shaft.position, self._shaft.wxyz = tip - 0.5 * length * way, z_towards(way)
        self._shaft.scale = (1.0, 1.0, _coarse(length))

    def remove(self) -> None:
        """Leave the scene."""
        self._root.remove()


def _coarse(length: float) -> float:
    return max(round(float(length) / COARSE), 1) * COARSE


class Stage:
    """What is drawn of a walk, and of a second one beside it.

    Args:
        scene: of viser.
        shown: asked for each layer by its key, see `marks.LAYERS`.
    """

    def __init__(self, scene: Any, shown: Callable[[str], bool]) -> None:
        self._scene, self._shown = scene, shown
        self._world = scene.add_frame(ROOT, show_axes=False)
        self._floor = scene.add_grid(
            f"{ROOT}/floor", infinite_grid=True, cell_size=0.25, section_size=1.0,
            cell_color=(222, 225, 229), section_color=(190, 196, 203), cell_thickness=0.6,
            section_thickness=1.0, fade_distance=18.0, fade_from="origin",
            plane_color=(246, 247, 249), plane_opacity=1.0, shadow_opacity=0.12,
        )  # fmt: skip
        self._figures: list[tuple[Figure, Marks | None]] = []
        self._view: np.ndarray | None = None

    def put(self, robot: Robot, figure: MakeFigure, ghost: MakeFigure | None) -> None:
        """Who walks from now on; the ones before leave.

        Args:
            robot: the point mass that the controller plans for.
            figure: the one that walks.
            ghost: the second one, if there is one.
        """
        for one, marks in self._figures:
            one.remove()
            if marks is not None:
                marks.remove()
        self._view = None
        marks = Marks(self._scene, f"{ROOT}/marks", robot, self._shown)
        self._figures = [(figure(self._scene, f"{ROOT}/walk", 1.0), marks)]
        if ghost is not None:
            aside = f"{ROOT}/aside"
            self._scene.add_frame(aside, show_axes=False, position=(0.0, ASIDE, 0.0))
            self._figures.append((ghost(self._scene, f"{aside}/ghost", TRANSPARENT), None))

    def show(self, snapshot: Snapshot, ghost: Snapshot | None) -> None:
        """Draw an instant of both walks."""
        for (figure, marks), one in zip(self._figures, (snapshot, ghost), strict=False):
            if one is None:
                continue
            figure.show(one)
            if marks is not None:
                marks.show(one)
        place = np.asarray(snapshot.observation["com"], float)
        if self._view is None or np.abs(place - self._view).max() > 2.0:
            self._view = place.copy()
        self._view = self._view + FOLLOWING * (place - self._view)
        self._world.position = (-self._view[0], -self._view[1], 0.0)

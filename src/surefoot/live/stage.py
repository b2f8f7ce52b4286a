"""The scene: a floor that runs under the robot, so that the camera can stay where it is put."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.live.figure import Figure
from surefoot.live.marks import Marks
from surefoot.robot.robot import Robot
from surefoot.rollout.snapshot import Snapshot

ASIDE = 1.4
"""How far to the left of the walk its ghost walks: behind it, as a tab begins to look [m]."""

TRANSPARENT = 0.35
"""A ghost."""

FOLLOWING = 0.12
"""How much of its lead the view makes up for in a frame [-]."""

ROOT = "/world"

MakeFigure = Callable[[Any, str, float], Figure]
"""A figure from the scene, its name in it, and its opacity."""


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

    def cast(self, robot: Robot, figure: MakeFigure, ghost: MakeFigure | None) -> None:
        """Who walks from now on; the ones before leave.

        Args:
            robot: the point mass that is believed in.
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

"""Pictures of a mechanism without a screen, by MuJoCo: its shapes, the scene around it, and what
there is to see of its control."""

from __future__ import annotations

import copy
import math
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from surefoot.errors import DisplayError
from surefoot.robot.multibody import Multibody
from surefoot.show import palette

MAX_SHAPES = 4000
"""In a scene."""

_VISUAL, _CONTACTS = (0, 1, 2), 3
"""Groups of shapes, as MuJoCo's models use them; the legs' capsules are in the latter."""

SKY, FLOOR, TILE = (0.90, 0.93, 0.96, 1.0), (0.83, 0.85, 0.87, 1.0), (0.74, 0.77, 0.80, 1.0)
"""Colours."""

BOARD = (0.70, 0.66, 0.56, 1.0)
"""Of what lies on the floor."""

TILE_SIZE, TILES = 0.5, 8
"""Of the dark squares of the floor [m], and how far it has some, to every side."""

FOG = (5.0, 10.0)
"""Where the floor begins to fade into the sky, and where it is gone [m]."""

WALL = 20.0
"""Behind the fog; without it the sky would be black [m]."""

LIGHT, LIGHT_WAY = np.array([1.5, -2.5, 5.0]), np.array([-0.25, 0.4, -0.9])
"""Where the light is, seen from the body [m], and where it shines."""

AZIMUTH, ELEVATION, DISTANCE = 130.0, -11.0, 3.25
"""Of the camera: a view from ahead and from the right, a little from above [deg], and how far it is
away, in heights of the CoM [-]."""

DARKEST = 0.22
"""Mean of red, green and blue of a robot's shapes, so that a black one shows its joints [-]."""

MARK, STRIPE, RAISED = 0.024, 0.001, 0.004
"""Radius of the marks, thickness of what lies on the floor, and how far it lies above it [m]."""

ARROW, ARROW_WIDTH, TRUNK = (0.3, 0.7), 0.022, 0.14
"""Length of a push's arrow: of the weakest, and what is added for the body's weight; its width;
and how far from the trunk's middle it ends [m]."""

FORCE, THIN = 0.6, 0.008
"""Length of the arrow for a floor's force that is the body's weight, and its width [m]."""


def shown_groups(mechanism: Multibody) -> tuple[int, ...]:
    """Groups of shapes to draw: the visual ones, and the legs' capsules where these are missing."""
    model = mechanism.model
    visual = np.isin(model.geom_group, _VISUAL) & (model.geom_bodyid > 0)
    return _VISUAL if visual.any() and not mechanism.unseen else (*_VISUAL, _CONTACTS)


def shown_shapes(mechanism: Multibody) -> Any:
    """Options of MuJoCo to draw the `shown_groups`."""
    options, groups = mujoco.MjvOption(), shown_groups(mechanism)
    options.geomgroup[:] = [group in groups for group in range(len(options.geomgroup))]
    return options


def lighten(scene: mujoco.MjvScene, darkest: float) -> None:
    """Make no shape darker than this mean of red, green and blue, from 0 to 1."""
    for shape in scene.geoms[: scene.ngeom]:
        shape.rgba[:3] += max(darkest - shape.rgba[:3].mean(), 0.0)


class OffScreen:
    """Draws scenes of one model; close it, or use it in a `with`.

    Args:
        model: of the mechanism; the size of its off-screen buffer is set.
        width, height: of the pictures [pixel].

    Attributes:
        scene: what is drawn: filled by `mujoco.mjv_updateScene`, then added to.

    Raises:
        DisplayError: there is no OpenGL without a screen.
    """

    def __init__(self, model: Any, width: int, height: int) -> None:
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        self._size = mujoco.MjrRect(0, 0, width, height)
        self._pixels = np.empty((height, width, 3), np.uint8)
        try:
            self._gl = _gl_context()(width, height)
            self._gl.make_current()
            self.scene = mujoco.MjvScene(model, MAX_SHAPES)
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_150.value)
        except (ImportError, AttributeError, OSError, RuntimeError, mujoco.FatalError) as error:
            raise DisplayError(error) from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)

    def picture(self) -> NDArray[np.uint8]:
        """The scene as it is now, shape (height, width, 3)."""
        self._gl.make_current()
        mujoco.mjr_render(self._size, self.scene, self._context)
        mujoco.mjr_readPixels(self._pixels, None, self._size, self._context)
        return np.flipud(self._pixels).copy()

    def close(self) -> None:
        """Give back what OpenGL holds."""
        self._gl.make_current()
        self._context.free()
        self._gl.free()

    def __enter__(self) -> OffScreen:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _gl_context() -> Any:
    """EGL on Linux, which needs no screen, unless MUJOCO_GL names another."""
    chosen = os.environ.get("MUJOCO_GL", "").lower().strip()
    if sys.platform == "linux" and chosen in ("", "egl"):
        # MuJoCo reads MUJOCO_GL when it is first imported, which may be long ago.
        return import_module("mujoco.egl").GLContext
    return mujoco.GLContext


def filmed_model(multibody: Multibody) -> Any:
    """A copy of the model with light, fog and a floor to look at."""
    model = copy.copy(multibody.model)
    look, extent = model.vis, model.stat.extent
    look.rgba.fog[:] = SKY
    look.map.fogstart, look.map.fogend = FOG[0] / extent, FOG[1] / extent
    look.map.znear, look.map.zfar = 0.02 / extent, 3.0 * WALL / extent
    look.headlight.ambient[:], look.headlight.diffuse[:] = 0.42, 0.25
    look.headlight.specular[:] = 0.0
    # Smoother edges would take twice the time.
    look.quality.shadowsize, look.quality.offsamples = 2048, 0
    model.geom_rgba[model.geom_bodyid == 0] = BOARD
    model.geom("floor").rgba[:] = FLOOR
    return model


def camera_at(place: Sequence[float]) -> Any:
    """That looks at a CoM from ahead and from the right (x, y, z) [m]."""
    camera = mujoco.MjvCamera()
    camera.azimuth, camera.elevation = AZIMUTH, ELEVATION
    camera.distance = DISTANCE * place[2]
    camera.lookat[:] = place
    return camera


def set_stage(scene: Any, place: NDArray[np.float64]) -> None:
    """Sky, floor and light around a place (x, y) [m]."""
    scene.flags[mujoco.mjtRndFlag.mjRND_FOG] = 1
    scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 1
    sight = math.radians(AZIMUTH)
    ahead = np.array([math.cos(sight), math.sin(sight), 0.0])
    middle = np.array([place[0], place[1], 0.0])
    box = mujoco.mjtGeom.mjGEOM_BOX
    add_shape(scene, box, (0.1, 2.0 * WALL, WALL), middle + WALL * ahead, (1, 1, 1, 1), yaw=sight)
    first = np.floor(middle[:2] / TILE_SIZE).astype(int) - TILES
    half = 0.5 * TILE_SIZE
    for i in range(2 * TILES):
        for j in range(2 * TILES):
            x, y = first[0] + i, first[1] + j
            if (x + y) % 2 == 0:
                # Its upper side is just above the floor.
                at = (x * TILE_SIZE + half, y * TILE_SIZE + half, -0.4 * STRIPE)
                add_shape(scene, box, (half, half, 0.5 * STRIPE), at, TILE)
    light = scene.lights[scene.nlight]
    light.pos[:], light.dir[:] = middle + LIGHT, LIGHT_WAY / np.linalg.norm(LIGHT_WAY)
    light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    light.castshadow, light.headlight, light.cutoff, light.exponent = 1, 0, 45.0, 0.0
    light.diffuse[:], light.ambient[:], light.specular[:] = 0.55, 0.0, 0.2
    light.attenuation[:] = (1.0, 0.0, 0.0)
    scene.nlight += 1


def draw_floor_force(
    scene: Any, zmp: ArrayLike, force: NDArray[np.float64], weight: float, colour: str
) -> None:
    """The force of the floor as an arrow from the ZMP.

    Args:
        scene: to draw in.
        zmp: (x, y) [m].
        force: shape (3,) [N].
        weight: of the robot, the yardstick of its length [N].
        colour: of the arrow.
    """
    x, y = np.asarray(zmp)
    foot = np.array([x, y, 0.0])
    _arrow(scene, foot, foot + FORCE * force / weight, THIN, colour)


def mark_point(scene: Any, place: ArrayLike, colour: str) -> None:
    """A ball on the floor, as of the DCM (x, y) [m]."""
    x, y = np.asarray(place)
    add_shape(scene, mujoco.mjtGeom.mjGEOM_SPHERE, (MARK, 0.0, 0.0), (x, y, MARK), _rgba(colour))


def mark_sole(
    scene: Any, half: tuple[float, float], place: ArrayLike, yaw: float, colour: str, alpha: float
) -> None:
    """A sole on the floor: where a foot stood, or where it is to land."""
    x, y = np.asarray(place)
    size = (half[0], half[1], STRIPE)
    add_shape(scene, mujoco.mjtGeom.mjGEOM_BOX, size, (x, y, RAISED), _rgba(colour, alpha), yaw=yaw)


def draw_push(scene: Any, at: ArrayLike, force: tuple[float, float], weight: float) -> None:
    """An arrow that pushes the trunk.

    Args:
        scene: to draw in.
        at: where it pushes, shape (3,) [m].
        force: (x, y) [N].
        weight: of the robot, the yardstick of its length [N].
    """
    strength = math.hypot(*force)
    way = np.array([force[0], force[1], 0.0]) / max(strength, 1e-9)
    length = ARROW[0] + ARROW[1] * min(strength / weight, 1.0)
    tip = np.asarray(at) - TRUNK * way
    _arrow(scene, tip - length * way, tip, ARROW_WIDTH, palette.PUSH)


def _rgba(colour: str, alpha: float = 1.0) -> tuple[float, ...]:
    return (*(part / 255.0 for part in palette.rgb(colour)), alpha)


def _arrow(
    scene: Any, tail: NDArray[np.float64], tip: NDArray[np.float64], width: float, colour: str
) -> None:
    kind = mujoco.mjtGeom.mjGEOM_ARROW
    arrow = add_shape(scene, kind, (1.0, 1.0, 1.0), tail, _rgba(colour))
    # MuJoCo draws an arrow half as long as its arguments say.
    mujoco.mjv_connector(arrow, kind, width, tail, 2.0 * tip - tail)


def add_shape(
    scene: Any, kind: Any, size: Sequence[float], place: ArrayLike, colours: Sequence[float], *,
    yaw: float = 0.0,
) -> Any:  # fmt: skip
    """One more shape, if there is room."""
    shape = scene.geoms[min(scene.ngeom, scene.maxgeom - 1)]
    cos, sin = math.cos(yaw), math.sin(yaw)
    axes = np.array([cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0])
    mujoco.mjv_initGeom(
        shape, kind, np.array(size, float), np.asarray(place, float), axes,
        np.array(colours, np.float32),
    )  # fmt: skip
    shape.specular = 0.1
    scene.ngeom = min(scene.ngeom + 1, scene.maxgeom)
    return shape

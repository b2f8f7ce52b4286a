"""A mechanism seen straight from one side, to scale: the picture that MuJoCo draws off screen."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.errors import DisplayError
from surefoot.robot.multibody import Multibody

_LOOKS, _CONTACTS = (0, 1, 2), 3
"""Groups of shapes, as MuJoCo's models use them; the legs' capsules are in the latter."""

_DARKEST = 0.4
"""Mean of red, green and blue, from 0 to 1."""

_FAR = 50.0
"""Between camera and robot, and from there to the white wall behind it [m]."""


@dataclass(frozen=True)
class Elevation:
    """What is seen from one side.

    Attributes:
        azimuth: direction of sight, 90 from the right side, 180 from the front [deg].
        across: range of what is horizontal in the picture [m].
        up: range of z [m].
        resolution: of the picture [1/m].
    """

    azimuth: float
    across: tuple[float, float]
    up: tuple[float, float]
    resolution: float = 800.0

    @property
    def size(self) -> tuple[int, int]:
        """Of the picture, height and width."""
        height, width = (span[1] - span[0] for span in (self.up, self.across))
        return round(height * self.resolution), round(width * self.resolution)

    def camera(self) -> mujoco.MjvCamera:
        """That looks at its middle."""
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.azimuth, camera.elevation, camera.distance = self.azimuth, 0.0, _FAR
        sight = np.radians(self.azimuth)
        rightwards = np.array([np.sin(sight), -np.cos(sight), 0.0])
        camera.lookat[:] = 0.5 * sum(self.across) * rightwards
        camera.lookat[2] = 0.5 * sum(self.up)
        return camera


def shown_groups(mechanism: Multibody) -> tuple[int, ...]:
    """Groups of shapes to draw: the looks, and the legs' capsules where looks are missing."""
    model = mechanism.model
    looks = np.isin(model.geom_group, _LOOKS) & (model.geom_bodyid > 0)
    return _LOOKS if looks.any() and not mechanism.unseen else (*_LOOKS, _CONTACTS)


def draw_elevations(mechanism: Multibody, views: list[Elevation]) -> list[NDArray[np.uint8]]:
    """Pictures of a mechanism in its nominal pose, on white.

    Args:
        mechanism: to be seen.
        views: from where.

    Returns:
        For each view an array (height, width, 3).

    Raises:
        DisplayError: there is no OpenGL without a screen.
    """
    data, model = mechanism.data(), mechanism.model
    height, width = (max(view.size[side] for view in views) for side in (0, 1))
    model.vis.global_.offheight, model.vis.global_.offwidth = height, width
    options, groups = mujoco.MjvOption(), shown_groups(mechanism)
    options.geomgroup[:] = [group in groups for group in range(len(options.geomgroup))]
    return [_draw(model, data, options, view) for view in views]


def _draw(
    model: mujoco.MjModel, data: mujoco.MjData, options: mujoco.MjvOption, view: Elevation
) -> NDArray[np.uint8]:
    model.vis.map.zfar = 4.0 * _FAR / model.stat.extent
    model.vis.headlight.ambient[:] = 0.45
    model.vis.headlight.diffuse[:] = 0.55
    model.vis.headlight.specular[:] = 0.1
    with _renderer(model, *view.size) as renderer:
        renderer.update_scene(data, view.camera(), options)
        _fit(renderer.scene, view)
        _lighten(renderer.scene, model.geom("floor").id)
        _hang_wall(renderer.scene, view)
        return renderer.render()


def _renderer(model: mujoco.MjModel, height: int, width: int) -> mujoco.Renderer:
    try:
        return mujoco.Renderer(model, height, width)
    except (ImportError, RuntimeError, AttributeError, mujoco.FatalError) as error:
        raise DisplayError(error) from error


def _fit(scene: mujoco.MjvScene, view: Elevation) -> None:
    """Look in parallel rays at just the view; MuJoCo's versions have other settings for it."""
    for camera in scene.camera:
        camera.orthographic = 1
        camera.frustum_top = 0.5 * (view.up[1] - view.up[0])
        camera.frustum_bottom = -camera.frustum_top
        camera.frustum_center = 0.0


def _lighten(scene: mujoco.MjvScene, floor: int) -> None:
    """Nothing so dark that what is drawn over it cannot be read, and no floor."""
    for shape in scene.geoms[: scene.ngeom]:
        is_floor = shape.objtype == mujoco.mjtObj.mjOBJ_GEOM and shape.objid == floor
        shape.rgba[:3] += max(_DARKEST - shape.rgba[:3].mean(), 0.0)
        shape.rgba[3] *= not is_floor


def _hang_wall(scene: mujoco.MjvScene, view: Elevation) -> None:
    """Behind the robot, white: an empty background would be black."""
    sight = np.radians(view.azimuth)
    wall = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(
        wall,
        mujoco.mjtGeom.mjGEOM_BOX,
        np.array([0.1, 20.0, 20.0]),
        0.5 * _FAR * np.array([np.cos(sight), np.sin(sight), 0.0]),
        np.array([np.cos(sight), -np.sin(sight), 0, np.sin(sight), np.cos(sight), 0, 0, 0, 1.0]),
        np.ones(4, np.float32),
    )
    scene.ngeom += 1

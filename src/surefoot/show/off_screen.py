"""Pictures of a mechanism without a screen, by MuJoCo: which shapes of it are drawn, and how."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.errors import DisplayError
from surefoot.robot.multibody import Multibody

MAX_SHAPES = 4000
"""In a scene."""

_LOOKS, _CONTACTS = (0, 1, 2), 3
"""Groups of shapes, as MuJoCo's models use them; the legs' capsules are in the latter."""


def shown_groups(mechanism: Multibody) -> tuple[int, ...]:
    """Groups of shapes to draw: the looks, and the legs' capsules where looks are missing."""
    model = mechanism.model
    looks = np.isin(model.geom_group, _LOOKS) & (model.geom_bodyid > 0)
    return _LOOKS if looks.any() and not mechanism.unseen else (*_LOOKS, _CONTACTS)


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
        # MuJoCo looks at MUJOCO_GL when it is first imported, which may be long ago.
        return import_module("mujoco.egl").GLContext
    return mujoco.GLContext

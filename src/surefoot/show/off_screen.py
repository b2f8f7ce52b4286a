"""Pictures of a mechanism without a screen, by MuJoCo's own renderer."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.errors import DisplayError

MOST_SHAPES = 4000
"""In a scene."""


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
            self.scene = mujoco.MjvScene(model, MOST_SHAPES)
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

"""A body in physics, drawn: the shapes of its mechanism, moved link by link."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

from surefoot.live.figure import GHOST
from surefoot.robot.multibody import Multibody
from surefoot.rollout.snapshot import Snapshot
from surefoot.show.palette import rgb
from surefoot.show.scene import shown_groups

DARKEST = 60
"""Mean of red, green and blue of a shape, so that a black robot shows its joints."""

_KINDS = mujoco.mjtGeom


class BodyFigure:
    """The visual shapes of a mechanism, and its legs and soles where these are missing.

    Args:
        scene: of viser.
        name: where in the tree of the scene.
        multibody: what is drawn.
        opacity: 1 or less of a ghost.
    """

    def __init__(self, scene: Any, name: str, multibody: Multibody, opacity: float = 1.0) -> None:
        self._model, self._data = multibody.model, multibody.data()
        self._root = scene.add_frame(name, show_axes=False)
        self._links: dict[int, Any] = {}
        groups, model = shown_groups(multibody), self._model
        for geom in range(model.ngeom):
            body = int(model.geom_bodyid[geom])
            if body == 0 or int(model.geom_group[geom]) not in groups:
                continue
            if body not in self._links:
                self._links[body] = scene.add_frame(f"{name}/link_{body}", show_axes=False)
            shape = _shape(model, geom)
            if shape is None:
                continue
            vertices, faces = shape
            scene.add_mesh_simple(
                f"{name}/link_{body}/shape_{geom}", vertices, faces,
                color=_colour(model, geom) if opacity == 1.0 else rgb(GHOST),
                opacity=None if opacity == 1.0 else opacity,
                position=model.geom_pos[geom], wxyz=model.geom_quat[geom],
            )  # fmt: skip

    def show(self, snapshot: Snapshot) -> None:
        """Take the pose of an instant."""
        if snapshot.position is None:
            return
        self._data.qpos[:] = snapshot.position
        mujoco.mj_kinematics(self._model, self._data)
        for body, frame in self._links.items():
            frame.position, frame.wxyz = self._data.xpos[body], self._data.xquat[body]

    def remove(self) -> None:
        """Leave the scene."""
        self._root.remove()


def _colour(model: Any, geom: int) -> tuple[int, int, int]:
    material = int(model.geom_matid[geom])
    rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
    values = 255.0 * np.asarray(rgba[:3], float)
    red, green, blue = np.clip(values + max(DARKEST - values.mean(), 0.0), 0, 255).astype(int)
    return int(red), int(green), int(blue)


def _shape(model: Any, geom: int) -> tuple[NDArray[Any], NDArray[Any]] | None:
    """Vertices and faces of a shape, in its own frame; None of a kind that no robot is made of."""
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == _KINDS.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        begin, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        return (
            model.mesh_vert[first : first + count].copy(),
            model.mesh_face[begin : begin + faces].copy(),
        )
    if kind == _KINDS.mjGEOM_BOX:
        shape = trimesh.creation.box(extents=2.0 * size)
    elif kind == _KINDS.mjGEOM_SPHERE:
        shape = trimesh.creation.icosphere(radius=size[0], subdivisions=3)
    elif kind == _KINDS.mjGEOM_CAPSULE:
        shape = trimesh.creation.capsule(height=2.0 * size[1], radius=size[0])
        shape.apply_translation(-shape.bounds.mean(axis=0))
    elif kind == _KINDS.mjGEOM_CYLINDER:
        shape = trimesh.creation.cylinder(height=2.0 * size[1], radius=size[0])
    elif kind == _KINDS.mjGEOM_ELLIPSOID:
        shape = trimesh.creation.icosphere(subdivisions=3)
        shape.apply_scale(size)
    else:
        return None
    return np.asarray(shape.vertices), np.asarray(shape.faces)

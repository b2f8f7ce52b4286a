"""A robot in its nominal pose: from the front, from the side, and its soles from above."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Wedge
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from surefoot.robot.feet import FEET, Side
from surefoot.robot.legs import NominalPose
from surefoot.robot.multibody import Multibody
from surefoot.show import palette
from surefoot.show.page import add_axes
from surefoot.show.picture_file import HALO, draw_picture
from surefoot.show.scene import OffScreen, add_shape, lighten, shown_groups, shown_shapes

AXIS_COLOURS = ("#d55e00", "#009e73", "#0072b2")
"""Of x, y and z."""

FRONT, RIGHT, ABOVE = (1, 2), (0, 2), (0, 1)
"""Which two axes a view shows, across and up."""

_HEIGHT, _VIEW = 7.0, 5.6
_LEFT, _BOTTOM, _GAP, _LAST = 0.65, 0.6, 1.6, 3.3
_SOLE = "#e66100"
_BASE_ARROW, _SOLE_ARROW = 0.14, 0.09


_DARKEST = 0.4
"""Mean of red, green and blue, so that what is drawn over it can be read, from 0 to 1."""

_FAR = 50.0
"""Between camera and robot, and from there to the white wall behind it [m]."""


def draw_robot(mechanism: Multibody, pose: NominalPose, path: Path) -> None:
    """Draw a robot and the pose of its mechanism into a file; see `draw_picture`.

    Raises:
        DisplayError: there is no OpenGL without a screen.
    """
    title = f"{mechanism.robot.name} in its nominal pose"
    draw_picture(lambda: robot_figure(mechanism, pose), path, title)


def robot_figure(mechanism: Multibody, pose: NominalPose) -> Figure:
    """The picture of a robot, not known to pyplot; raises as `draw_robot`."""
    views = _views(mechanism)
    scale = _VIEW / (views[0].up[1] - views[0].up[0])
    widths = [scale * (view.across[1] - view.across[0]) for view in views]
    page = (_LEFT + sum(widths) + 2 * _GAP + _LAST + 0.2, _HEIGHT)
    figure = Figure(figsize=page)
    axes, left = [], _LEFT
    for width, height in zip((*widths, _LAST), (_VIEW, _VIEW, 0.62 * _VIEW), strict=True):
        axes.append(add_axes(figure, (left, _HEIGHT - _BOTTOM - _VIEW, width, height)))
        left += width + _GAP
    pictures = draw_elevations(mechanism, views)
    for axis, picture, view, plane in zip(axes, pictures, views, (FRONT, RIGHT), strict=False):
        axis.imshow(picture, extent=(*view.across, *view.up), interpolation="antialiased")
        _draw_elevation(axis, mechanism, pose, plane)
    _draw_from_above(axes[2], mechanism, pose)
    robot = mechanism.robot
    start = (left - _GAP - _LAST) / page[0]
    figure.text(start, 0.31 * _VIEW / page[1], _facts(mechanism, pose), va="top", linespacing=1.7)
    figure.text(
        0.02, 0.965, f"{robot.name} in its nominal pose", fontsize=12.0, fontweight="bold", va="top"
    )
    return figure


def _views(mechanism: Multibody) -> list[Elevation]:
    low, high = _extent(mechanism)
    up = (-0.1, high[2] + 0.08)
    front = max(-low[1], high[1], 0.25) + 0.12
    side = max(-low[0], high[0], 0.25) + 0.12
    return [Elevation(180.0, (-front, front), up), Elevation(90.0, (-side, side), up)]


def _extent(mechanism: Multibody) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of the box around all that is drawn, or around the links if nothing is."""
    model, data = mechanism.model, mechanism.data()
    corners = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, 8).T
    points, groups = [data.xpos[1:]], shown_groups(mechanism)
    for geom in range(model.ngeom):
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
            continue
        if model.geom_group[geom] in groups:
            box = model.geom_aabb[geom, :3] + corners * model.geom_aabb[geom, 3:]
            points.append(data.geom_xpos[geom] + box @ data.geom_xmat[geom].reshape(3, 3).T)
    cloud = np.vstack(points)
    return cloud.min(axis=0), cloud.max(axis=0)


def _draw_elevation(
    axis: Axes, mechanism: Multibody, pose: NominalPose, plane: tuple[int, int]
) -> None:
    across, _ = plane
    axis.axhline(0.0, color=palette.QUIET, linewidth=0.8)
    axis.set_title("from the front" if plane == FRONT else "from the right", loc="left")
    axis.set_xlabel(f"{'xyz'[across]} [m]")
    axis.set_ylabel("z [m]")
    half = mechanism.robot.foot.half[across]
    for sole, axes in zip(pose.soles, pose.axes, strict=True):
        ends = [(sole + end * axes[:, across])[list(plane)] for end in (-half, half)]
        axis.plot(*np.transpose(ends), color=_SOLE, linewidth=4.0, solid_capstyle="butt")
    data = mechanism.data()
    base = data.xpos[mechanism.base]
    _draw_frame(axis, base, data.xmat[mechanism.base].reshape(3, 3), _BASE_ARROW, plane)
    feet = zip(FEET, pose.soles, pose.axes, strict=True)
    for side, sole, axes in feet if plane == FRONT else [tuple(feet)[1]]:
        _draw_frame(axis, sole, axes, _SOLE_ARROW, plane)
        _label(
            axis, sole[list(plane)], side if plane == FRONT else f"{side} sole", (0, -11), "center"
        )
    axis.plot([pose.com[across]] * 2, [0.0, pose.com[2]], color=palette.COM, lw=0.9, ls=":")
    _mark_com(axis, (pose.com[across], pose.com[2]), 0.022)
    name = mechanism.model.body(mechanism.base).name
    names = {f"CoM {pose.com[2]:.3f} m": pose.com, f"base {base[2]:.3f} m\n({name})": base}
    _point_out(axis, {words: point[list(plane)] for words, point in names.items()})


def _point_out(axis: Axes, points: dict[str, NDArray[np.float64]]) -> None:
    """Name points at the right edge, the lower one's words below its line."""
    edge = axis.get_xlim()[1]
    for place, (words, point) in enumerate(sorted(points.items(), key=lambda item: item[1][1])):
        axis.plot([point[0], edge], [point[1]] * 2, color=palette.QUIET, lw=0.7, zorder=4)
        axis.annotate(
            words, (edge, point[1]), (4, 3 if place else -3), textcoords="offset points",
            va="bottom" if place else "top", fontsize=8.5, annotation_clip=False,
        )  # fmt: skip


def _label(
    axis: Axes, place: tuple[float, float], text: str, offset: tuple[float, float], align: str
) -> None:
    axis.annotate(
        text, place, offset, textcoords="offset points", ha=align, va="center",
        fontsize=8.0, path_effects=HALO,
    )  # fmt: skip


def _draw_frame(
    axis: Axes,
    origin: NDArray[np.float64],
    axes: NDArray[np.float64],
    length: float,
    plane: tuple[int, int],
) -> None:
    """Arrows along the axes of a frame; one that points at the viewer is a dot."""
    across, up = plane
    x, y = float(origin[across]), float(origin[up])
    for place, colour in enumerate(AXIS_COLOURS):
        dx, dy = length * float(axes[across, place]), length * float(axes[up, place])
        if math.hypot(dx, dy) < 0.2 * length:
            axis.plot(x, y, marker="o", markersize=4.5, color=colour, zorder=6)
            continue
        axis.annotate(
            "", (x + dx, y + dy), (x, y), zorder=5,
            arrowprops={
                "arrowstyle": "-|>", "color": colour, "lw": 1.8, "shrinkA": 0, "shrinkB": 0
            },
        )  # fmt: skip
        axis.text(
            x + 1.18 * dx, y + 1.18 * dy, "xyz"[place], color=colour, ha="center", va="center",
            fontsize=8.0, fontweight="bold", path_effects=HALO,
        )  # fmt: skip


def _mark_com(axis: Axes, place: tuple[float, float], radius: float) -> None:
    axis.add_patch(Circle(place, radius, facecolor="white", edgecolor=palette.COM, zorder=7))
    for start in (0.0, 180.0):
        axis.add_patch(Wedge(place, radius, start, start + 90.0, color=palette.COM, zorder=8))


def _draw_from_above(axis: Axes, mechanism: Multibody, pose: NominalPose) -> None:
    axis.set_title("soles from above, outline of the feet", loc="left")
    axis.set_xlabel("x [m]")
    axis.set_ylabel("y [m]")
    axis.set_aspect("equal")
    half = np.array(mechanism.robot.foot.half)
    for side, sole, axes, shape in zip(FEET, pose.soles, pose.axes, pose.foot_shapes, strict=True):
        colour = Side[side.upper()]
        turn = axes[:2, :2]
        if len(shape):
            corners = shape[ConvexHull(shape[:, :2]).vertices, :2]
            outline = sole[:2] + corners @ turn.T
            axis.add_patch(Polygon(outline, facecolor=palette.BOTH_SOLES, edgecolor=palette.QUIET))
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
        axis.add_patch(
            Polygon(
                sole[:2] + corners @ turn.T, facecolor=palette.SOLE[colour], edgecolor=_SOLE, lw=1.8
            )
        )
        _draw_frame(axis, sole, axes, min(_SOLE_ARROW, 0.33 * pose.spacing), ABOVE)
        _label(axis, sole[:2] + turn @ (-half), side, (5, 8), "left")
    _mark_com(axis, (pose.com[0], pose.com[1]), 0.012)
    _label(axis, (pose.com[0], pose.com[1]), "CoM", (9, 0), "left")
    reach = pose.spacing / 2 + half[1] + 0.1
    axis.set_ylim(-reach, reach)
    axis.set_xlim(*(np.array([-1.0, 1.0]) * reach * _LAST / (0.62 * _VIEW)))


def _facts(mechanism: Multibody, pose: NominalPose) -> str:
    robot, left = mechanism.robot, pose.legs[0]
    worst = int((pose.load / mechanism.torque).argmax())
    return "\n".join(
        (
            f"{mechanism.mass:.1f} kg, {len(mechanism.motors)} motors, ankle roll "
            f"{mechanism.body.ankle_roll}",
            f"soles {robot.foot.length:g} m × {robot.foot.width:g} m, {pose.spacing:.3f} m apart",
            f"hip to ankle {100 * left.length / left.straight:.1f} % of the straight leg",
            f"on one foot {mechanism.joint_names[worst]} bears {pose.load[worst]:.0f} N m,",
            f"    {100 * pose.load[worst] / mechanism.torque[worst]:.0f} % of what it can",
        )
    )


@dataclass(frozen=True)
class Elevation:
    """A view from one side.

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


def draw_elevations(mechanism: Multibody, views: list[Elevation]) -> list[NDArray[np.uint8]]:
    """Pictures of a mechanism in its nominal pose, on white: of each view (height, width, 3)."""
    data, model, options = mechanism.data(), mechanism.model, shown_shapes(mechanism)
    model.vis.map.zfar = 4.0 * _FAR / model.stat.extent
    model.vis.headlight.ambient[:] = 0.45
    model.vis.headlight.diffuse[:] = 0.55
    model.vis.headlight.specular[:] = 0.1
    everything, floor = mujoco.mjtCatBit.mjCAT_ALL.value, model.geom("floor").id
    pictures = []
    for view in views:
        height, width = view.size
        with OffScreen(model, width, height) as screen:
            scene = screen.scene
            mujoco.mjv_updateScene(model, data, options, None, view.camera(), everything, scene)
            _fit(scene, view)
            lighten(scene, _DARKEST)
            _hide(scene, floor)
            _hang_wall(scene, view)
            pictures.append(screen.picture())
    return pictures


def _fit(scene: mujoco.MjvScene, view: Elevation) -> None:
    """Look in parallel rays at just the view; MuJoCo's versions have other settings for it."""
    for camera in scene.camera:
        camera.orthographic = 1
        camera.frustum_top = 0.5 * (view.up[1] - view.up[0])
        camera.frustum_bottom = -camera.frustum_top
        camera.frustum_center = 0.0


def _hide(scene: mujoco.MjvScene, geom: int) -> None:
    """Make a shape of the model transparent."""
    for shape in scene.geoms[: scene.ngeom]:
        if shape.objtype == mujoco.mjtObj.mjOBJ_GEOM and shape.objid == geom:
            shape.rgba[3] = 0.0


def _hang_wall(scene: mujoco.MjvScene, view: Elevation) -> None:
    """Behind the robot, white: an empty background would be black."""
    yaw = math.radians(view.azimuth)
    place = 0.5 * _FAR * np.array([math.cos(yaw), math.sin(yaw), 0.0])
    kind = mujoco.mjtGeom.mjGEOM_BOX
    add_shape(scene, kind, (0.1, 20.0, 20.0), place, (1.0, 1.0, 1.0, 1.0), yaw=yaw)

"""A film of a walk in physics: the body, its DCM and ZMP, where it is to step, and the pushes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import imageio_ffmpeg
import mujoco
import numpy as np
from matplotlib import font_manager
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from surefoot.checks import check_writable
from surefoot.errors import ParameterError
from surefoot.robot.floor import laid_boards
from surefoot.robot.multibody import Multibody, load_multibody
from surefoot.robot.robot import STANDARD_GRAVITY
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.show import palette
from surefoot.show.plotted_walk import PlottedWalk, Sole
from surefoot.show.scene import (
    DARKEST,
    OffScreen,
    camera_at,
    draw_floor_force,
    draw_push,
    filmed_model,
    lighten,
    mark_point,
    mark_sole,
    set_stage,
    shown_shapes,
)
from surefoot.show.stances import command_at, commanded
from surefoot.show.words import command_words, push_label

FORMATS = (".mp4", ".gif")
"""The endings that a film's file may have."""

SIZE, RATE, QUALITY = (960, 540), 30, 7
"""Of a film [pixel], [1/s], from 0 to 10."""

GIF_SIZE, GIF_RATE, GIF_COLOURS = (480, 270), 20, 128
"""Of an animated picture, which is much larger for its size."""

STILL = 1.2
"""For so long the last picture of a fall is shown [s]."""

PUSH_SHOWN = 0.5
"""A push is shown for at least so long, or nobody would see it [s]."""

FOOTPRINTS = 12
"""Places of feet that are shown behind the robot."""

MIDDLE = np.array([0.0, 0.0, 0.25])
"""Of the trunk, where a push is drawn, seen from the base [m]."""

SMOOTHING = 0.6
"""Of the camera's way [s]."""

Picture = NDArray[np.uint8]


@dataclass(frozen=True)
class Film:
    """The pictures of a walk.

    Args:
        rollout: the walk of a body.
        rate: pictures a second [1/s].
    """

    rollout: Rollout
    rate: int = RATE

    @property
    def trace(self) -> BodyTrace:
        """What the body did.

        Raises:
            ParameterError: it is the walk of a point mass.
        """
        if self.rollout.body is None:
            raise ParameterError(
                "the walk of a body in physics to film",
                "the walk of a point mass",
                "walk with simulate_body (--simulator mujoco)",
            )
        return self.rollout.body

    def __len__(self) -> int:
        """How many pictures it has."""
        return len(self.rows)

    @cached_property
    def rows(self) -> list[int]:
        """The cycle that each picture shows."""
        time = self.rollout.time
        count = int(float(time[-1]) * self.rate) + 1
        rows = np.searchsorted(time, np.arange(count) / self.rate - 1e-9).tolist()
        still = round(STILL * self.rate) if self.rollout.fallen else 0
        return rows + [len(time) - 1] * still

    @cached_property
    def multibody(self) -> Multibody:
        """The mechanism, and what lies on its floor."""
        return load_multibody(self.trace.robot, laid_boards(self.trace.boards))

    @property
    def _weight(self) -> float:
        return self.trace.robot.mass * STANDARD_GRAVITY

    @cached_property
    def _way(self) -> NDArray[np.float64]:
        """Of the camera, shape (n, 2): the CoM's, without its sway."""
        com, period = self.trace.com[:, :2], float(np.diff(self.rollout.time[:2], append=1.0)[0])
        half = max(round(SMOOTHING / period), 1)
        padded = np.concatenate([com[:1].repeat(half, 0), com, com[-1:].repeat(half, 0)])
        sums = np.cumsum(np.concatenate([np.zeros((1, 2)), padded]), axis=0)
        return (sums[2 * half :] - sums[: -2 * half])[: len(com)] / (2 * half)

    def pictures(self, size: tuple[int, int] = SIZE) -> Iterator[Picture]:
        """Every picture in turn, shape (height, width, 3).

        Args:
            size: width and height [pixel].

        Raises:
            DisplayError: there is no OpenGL without a screen.
            RobotError: the robot's model is not there any more.
        """
        model = filmed_model(self.multibody)
        data, options = mujoco.MjData(model), shown_shapes(self.multibody)
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        captions = Captions(self.rollout, size)
        with OffScreen(model, *size) as screen:
            for row in self.rows:
                data.qpos[:] = self.trace.position[row]
                mujoco.mj_kinematics(model, data)
                mujoco.mj_camlight(model, data)
                look_at = (*self._way[row], self.trace.robot.com_height)
                mujoco.mjv_updateScene(
                    model, data, options, None, camera_at(look_at), everything, screen.scene
                )
                lighten(screen.scene, DARKEST)
                set_stage(screen.scene, self._way[row])
                self._draw_control(screen, row)
                yield captions.written(screen.picture(), row)

    def _draw_control(self, screen: OffScreen, row: int) -> None:
        scene, trace, rollout = screen.scene, self.trace, self.rollout
        half, now = trace.robot.foot.half, float(rollout.time[row])
        left = [sole for sole in self._soles if sole.samples.stop <= row]
        for sole in left[-FOOTPRINTS:]:
            mark_sole(scene, half, sole.centre, sole.yaw, palette.SOLE_EDGE[sole.side], 0.35)
        if trace.walking[row]:
            command = rollout.commands[row]
            yaw = float(trace.course[row, 2])
            mark_sole(scene, half, command["step_location"], yaw, palette.ADAPTED, 0.6)
        zmp = rollout.zmp[row]
        if np.isfinite(zmp).all():
            force = trace.sole_force[row].sum(axis=0)
            draw_floor_force(scene, zmp, force, self._weight, palette.ZMP)
        mark_point(scene, rollout.dcm[row], palette.DCM)
        for push in rollout.pushes:
            if push.start <= now < max(push.end, push.start + PUSH_SHOWN):
                trunk = trace.position[row, :3].astype(float) + MIDDLE
                draw_push(scene, trunk, push.force, self._weight)

    @cached_property
    def _soles(self) -> list[Sole]:
        """Where the feet stood, in the order in which they left the ground."""
        return sorted(PlottedWalk(self.rollout).soles, key=lambda sole: sole.samples.stop)


class Captions:
    """What is written into the pictures of a walk.

    Args:
        rollout: the walk.
        size: of the pictures [pixel].
    """

    def __init__(self, rollout: Rollout, size: tuple[int, int]) -> None:
        self.rollout = rollout
        self._unit = size[1] / 540.0
        path = font_manager.findfont("DejaVu Sans")
        bold = font_manager.findfont("DejaVu Sans:bold")
        self._font = ImageFont.truetype(path, round(17 * self._unit))
        self._bold = ImageFont.truetype(bold, round(22 * self._unit))

    def written(self, picture: Picture, row: int) -> Picture:
        """The picture with its captions."""
        image, u = Image.fromarray(picture), self._unit
        draw, now = ImageDraw.Draw(image), float(self.rollout.time[row])
        title = f"{self.rollout.robot.name}  ·  {self.rollout.controller}"
        draw.text((18 * u, 14 * u), title, "#333333", self._bold)
        command = command_words(command_at(commanded(self.rollout), now))
        draw.text((18 * u, 44 * u), command, "#333333", self._font)
        draw.text((18 * u, image.height - 36 * u), f"{now:.2f} s", "#333333", self._bold)
        event = self._event(now)
        if event:
            words, colour = event
            draw.text((18 * u, image.height - 68 * u), words, colour, self._bold)
        marks = (
            ("DCM", palette.DCM),
            ("floor's force at the ZMP", palette.ZMP),
            ("next step", palette.ADAPTED),
        )
        x, y = image.width - 18 * u, image.height - 30 * u
        for words, colour in reversed(marks):
            x -= draw.textlength(words, self._font)
            draw.text((x, y), words, "#333333", self._font)
            draw.ellipse((x - 18 * u, y + 4 * u, x - 6 * u, y + 16 * u), colour)
            x -= 36 * u
        return np.asarray(image)

    def _event(self, now: float) -> tuple[str, str] | None:
        fall = self.rollout.body_fall
        if fall is not None and now >= fall.time:
            return f"{fall.cause.value}: {fall.words}", palette.ALARM
        for push in self.rollout.pushes:
            if push.start <= now < max(push.end, push.start + 2.0 * PUSH_SHOWN):
                return f"push {push_label(push)}", palette.PUSH_EDGE
        return None


def film_walk(
    rollout: Rollout, path: Path, progress: Callable[[int, int], None] | None = None
) -> None:
    """Film a walk in physics into a file.

    Args:
        rollout: the walk.
        path: file to write; its ending names the format (.mp4, .gif).
        progress: called after every picture with how many there are by now, and will be.

    Raises:
        ParameterError: it is the walk of a point mass.
        DisplayError: there is no OpenGL without a screen.
        FileError: the file cannot be written.
    """
    check_writable(path, FORMATS)
    animated = path.suffix.lower() == ".gif"
    film = Film(rollout, GIF_RATE if animated else RATE)
    pictures = _counted(film, GIF_SIZE if animated else SIZE, progress)
    if animated:
        _write_gif(pictures, path)
    else:
        _write_mp4(pictures, path)


def _counted(
    film: Film, size: tuple[int, int], progress: Callable[[int, int], None] | None
) -> Iterator[Picture]:
    for index, picture in enumerate(film.pictures(size)):
        if progress is not None:
            progress(index + 1, len(film))
        yield picture


def _write_mp4(pictures: Iterator[Picture], path: Path) -> None:
    writer = imageio_ffmpeg.write_frames(
        str(path), SIZE, fps=RATE, codec="libx264", quality=QUALITY, macro_block_size=2
    )
    writer.send(None)
    try:
        for picture in pictures:
            writer.send(np.ascontiguousarray(picture))
    finally:
        writer.close()


def _write_gif(pictures: Iterator[Picture], path: Path) -> None:
    """All pictures in the same colours, so that they do not flicker."""
    images = [Image.fromarray(picture) for picture in pictures]
    colours = _common_colours(images)
    flat = [image.quantize(palette=colours, dither=Image.Dither.NONE) for image in images]
    flat[0].save(
        path, save_all=True, append_images=flat[1:], loop=0, optimize=True,
        duration=round(1000.0 / GIF_RATE),
    )  # fmt: skip


def _common_colours(images: list[Image.Image]) -> Image.Image:
    """A palette of some pictures, and of the marks, which are too small to get their own."""
    sample = images[:: max(len(images) // 4, 1)]
    width, height = images[0].size
    marks = [palette.DCM, palette.ZMP, palette.ADAPTED, palette.PUSH, palette.ALARM]
    shades = [
        tuple(round(part * shade) for part in palette.rgb(colour))
        for colour in marks
        for shade in (1.0, 0.75, 0.5)
    ]
    strip = height // 10
    sheet = Image.new("RGB", (width, height * len(sample) + strip * len(shades)))
    for index, image in enumerate(sample):
        sheet.paste(image, (0, index * height))
    for index, shade in enumerate(shades):
        top = height * len(sample) + index * strip
        sheet.paste(shade, (0, top, width, top + strip))
    return sheet.quantize(GIF_COLOURS, Image.Quantize.MEDIANCUT)

"""A walk in physics is filmed and drawn; what is in the pictures is what happened."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

import surefoot as sf
from surefoot.show import palette
from surefoot.show.film import GIF_SIZE, RATE, SIZE, STILL, Film
from surefoot.show.page import units_per_inch
from surefoot.show.plotted_walk import PlottedWalk
from surefoot.show.time_plots import motors_of, panels
from surefoot.show.walk_figure import walk_figure

PUSH = sf.Push(1.2, 0.1, (200.0, 0.0))


@pytest.fixture(scope="module")
def walk(body_control: sf.BodyControl) -> sf.Rollout:
    return sf.simulate_body(body_control, 2.2, [PUSH])


@pytest.fixture(scope="module")
def fallen(body_control: sf.BodyControl) -> sf.Rollout:
    push = sf.Push(1.5, 0.1, (0.0, 1500.0))
    rollout = sf.simulate_body(body_control, 4.0, [push])
    assert rollout.fallen
    return rollout


def film_of(rollout: sf.Rollout, rows: list[int]) -> Film:
    """A film of a few cycles only."""
    film = Film(rollout)
    film.__dict__["rows"] = rows
    return film


def middle_of_a_step(rollout: sf.Rollout) -> int:
    """A row some time after the push, when the next landing is ahead of the feet."""
    step = rollout.footsteps[-1]
    return round(1000.0 * (step.start + 0.4 * step.duration))


@pytest.fixture(scope="module")
def pictures(walk: sf.Rollout) -> list[np.ndarray]:
    """Standing, walking some time after the push, and while it is pushed."""
    try:
        return list(film_of(walk, [0, middle_of_a_step(walk), 1250]).pictures())
    except sf.SurefootError as error:
        if "OpenGL" in str(error):
            pytest.skip(str(error))
        raise


def has_colour(picture: np.ndarray, colour: str, *, near: int = 45) -> bool:
    """Whether enough of a picture is about that colour, lit or in the shade."""
    wanted = np.array(to_rgb(colour))
    pixels = picture.reshape(-1, 3) / 255.0
    length = np.linalg.norm(pixels, axis=1)
    hue = pixels @ wanted / np.maximum(length * np.linalg.norm(wanted), 1e-9)
    return int(((hue > 0.985) & (length > 0.25)).sum()) > near


def test_pictures_have_sky_floor_and_robot(pictures: list[np.ndarray]) -> None:
    for picture in pictures:
        assert picture.shape == (SIZE[1], SIZE[0], 3)
        assert picture[40, -20].min() > 200
        assert 120 < picture[-120, 20].mean() < 240
        middle = picture[150:450, 330:630]
        assert middle.std() > 25.0


def test_the_push_is_shown_while_it_acts(pictures: list[np.ndarray]) -> None:
    # Not in the words about it, which are below.
    shown = [has_colour(picture[100:430], palette.PUSH) for picture in pictures]
    assert shown == [False, False, True]


def test_the_next_step_is_shown_in_a_step(pictures: list[np.ndarray]) -> None:
    # The legend has a dot of the same colour, below.
    shown = [has_colour(picture[:490], palette.ADAPTED) for picture in pictures]
    assert shown[:2] == [False, True]


def test_pictures_do_not_depend_on_the_past(walk: sf.Rollout, pictures: list[np.ndarray]) -> None:
    (again,) = film_of(walk, [middle_of_a_step(walk)]).pictures()
    assert np.abs(again.astype(int) - pictures[1].astype(int)).mean() < 0.05


def test_a_film_lasts_as_long_as_the_walk(walk: sf.Rollout, fallen: sf.Rollout) -> None:
    film = Film(walk)
    assert len(film) == int(2.2 * RATE) + 1
    assert walk.time[film.rows[RATE]] == pytest.approx(1.0, abs=2e-3)
    longer = Film(fallen)
    assert len(longer) == int(fallen.time[-1] * RATE) + 1 + round(STILL * RATE)


def test_films_are_written(walk: sf.Rollout, pictures: list[np.ndarray], tmp_path: Path) -> None:
    short = sf.load_rollout(_saved(walk, tmp_path))
    told = []
    mp4, gif = tmp_path / "walk.mp4", tmp_path / "walk.gif"
    sf.film_walk(short, mp4, lambda done, total: told.append((done, total)))
    assert told[-1][0] == told[-1][1] == len(told)
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(mp4))
    assert frames == len(told)
    assert seconds == pytest.approx(len(told) / RATE, abs=0.05)
    sf.film_walk(short, gif)
    with Image.open(gif) as image:
        assert image.size == GIF_SIZE
        assert image.n_frames > 2  # type: ignore[attr-defined]
        image.seek(4)
        shown = np.asarray(image.convert("RGB"))
    # Few pixels have them, and yet they keep their colours.
    assert has_colour(shown, palette.PUSH, near=8)
    assert has_colour(shown[:245], palette.ADAPTED, near=8)


def _saved(walk: sf.Rollout, folder: Path) -> Path:
    """A few cycles of a walk, as a file."""
    assert walk.body is not None
    rows = slice(1050, 1300)
    arrays = {
        item.name: value[rows]
        for item in fields(walk.body)
        if isinstance(value := getattr(walk.body, item.name), np.ndarray)
        and len(value) == len(walk.time)
    }
    seen = walk.observations[rows].copy()
    seen["time"] -= seen["time"][0]
    push = replace(PUSH, start=PUSH.start - 1.05)
    part = replace(
        walk,
        pushes=(push,),
        observations=seen,
        commands=walk.commands[rows],
        decision_time=walk.decision_time[rows],
        seen=walk.seen[rows],
        body=replace(walk.body, **arrays),
    )
    part.save(folder / "part.npz")
    return folder / "part.npz"


def test_only_bodies_are_filmed(robot: sf.Robot, tmp_path: Path) -> None:
    rollout = sf.simulate(sf.HybridController(robot, (0.3, 0.0)), 0.2)
    with pytest.raises(sf.ParameterError, match="the walk of a body in physics to film"):
        sf.film_walk(rollout, tmp_path / "walk.mp4")


@pytest.mark.parametrize("name", ["walk.avi", "no/such/walk.mp4"])
def test_a_path_that_cannot_be_written_is_told(walk: sf.Rollout, tmp_path: Path, name) -> None:
    with pytest.raises(sf.FileError):
        sf.film_walk(walk, tmp_path / name)


def test_without_opengl_the_remedy_is_told(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['mujoco.egl'] = None\n"
        "import surefoot as sf\n"
        "from surefoot.show.scene import OffScreen\n"
        "model = sf.load_multibody(sf.load_robot('paper-biped')).model\n"
        "try: OffScreen(model, 64, 64)\n"
        "except sf.SurefootError as error: print(type(error).__name__, error)"
    )
    environment = {**os.environ, "MUJOCO_GL": "egl"} if sys.platform == "linux" else None
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment
    )
    assert "DisplayError expected OpenGL that draws without a screen" in done.stdout + done.stderr


def test_the_page_shows_every_part(walk: sf.Rollout) -> None:
    assert walk.body is not None
    figure = walk_figure(walk)
    axes = {str(ax.get_gid()): ax for ax in figure.axes}
    assert {panel.name for panel in panels(walk)} <= set(axes)
    drawn = {str(line.get_gid()) for ax in figure.axes for line in ax.lines}
    for axis in "xy":
        for name in ("zmp", "zmp-plan", "dcm", "dcm-plan", "com", "com-plan"):
            assert f"{name}-{axis}" in drawn
    for joint in walk.body.joints:
        assert f"torque-{joint}" in drawn
    assert {"knee-left", "knee-right", "height-left", "height-right"} <= drawn
    (line,) = [one for one in axes["y"].lines if one.get_gid() == "dcm-y"]
    assert np.array_equal(line.get_ydata(), walk.dcm[:, 1])
    (knee,) = [one for one in axes["knees"].lines if one.get_gid() == "knee-right"]
    bend = np.degrees(np.abs(walk.body.joint_angles[:, walk.body.knees[1]]))
    assert knee.get_ydata() == pytest.approx(bend)
    legend = " ".join(text.get_text() for text in axes["left motors"].get_legend().get_texts())
    assert "knee, ±350 N m" in legend


def test_soles_are_drawn_where_they_stood(walk: sf.Rollout) -> None:
    places = PlottedWalk(walk).soles
    assert [sole.side for sole in places[:2]] == [sf.Side.LEFT, sf.Side.RIGHT]
    assert places[0].centre == pytest.approx([0.0, 0.1], abs=0.02)
    for step in walk.footsteps:
        assert any(math.dist(sole.centre, step.landing) < 0.02 for sole in places)


def test_a_fall_is_named_on_the_page(fallen: sf.Rollout) -> None:
    assert fallen.body is not None
    assert fallen.body_fall is not None
    figure = walk_figure(fallen)
    texts = [text.get_text() for text in figure.texts]
    assert any(fallen.body_fall.cause.value in text for text in texts)
    assert any(text.startswith("fell: ") for text in texts)


def test_a_fall_to_the_side_does_not_shrink_the_page(body_control: sf.BodyControl) -> None:
    push = sf.Push(2.0, 0.2, (0.0, 700.0))
    rollout = sf.simulate_body(body_control, 4.0, [push], estimator="truth")
    assert rollout.fallen
    assert rollout.body is not None
    assert rollout.dcm[-1, 1] > 1.0
    figure = walk_figure(rollout)
    top = next(ax for ax in figure.axes if ax.get_xlabel() == "x [m]")
    low, high = top.get_ylim()
    assert units_per_inch(top) == pytest.approx(0.25, rel=0.2)
    for sole in PlottedWalk(rollout).soles:
        assert low < sole.centre[1] < high
    (mark,) = [line for line in top.lines if line.get_gid() == "fall"]
    assert low + 0.01 < mark.get_ydata()[0] < high - 0.01  # type: ignore[index, operator]


def test_motors_are_of_their_side(walk: sf.Rollout) -> None:
    assert walk.body is not None
    names = [walk.body.joints[index] for index in motors_of(walk.body, "left")]
    assert len(names) == 5
    assert all("left" in name for name in names)


def test_the_same_walk_gives_the_same_picture(walk: sf.Rollout, tmp_path: Path) -> None:
    first, second = tmp_path / "a.png", tmp_path / "b.png"
    walk.plot(first)
    walk.plot(second)
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith(b"\x89PNG")

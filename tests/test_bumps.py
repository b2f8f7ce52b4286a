"""A floor with boards on it: where they lie, what stands on them, and what is seen of them."""

from __future__ import annotations

import math

import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.robot.floor import (
    MAX_HEIGHT,
    REGION,
    START,
    FloorHeight,
    board_numbers,
    check_course,
    laid_boards,
    scattered_boards,
)
from surefoot.show.walk_figure import walk_figure
from surefoot.worlds.body.plant import STANDS, TOUCHED, BodyPlant
from surefoot.worlds.body.step import SOON_DOWN
from surefoot.worlds.steering import course_of

ROUGH = sf.Surroundings(bumps=0.01, friction=0.7, seed=7)


@pytest.fixture(scope="module")
def rough(body_control: sf.BodyControl) -> sf.Rollout:
    return sf.simulate_body(body_control, 4.0, surroundings=ROUGH)


def test_the_same_seed_lays_the_same_boards() -> None:
    boards, again, other = (scattered_boards(0.01, seed) for seed in (1, 1, 2))
    assert boards.tobytes() == again.tobytes()
    assert boards.tobytes() != other.tobytes()
    low = scattered_boards(0.002, 1)
    assert np.array_equal(low["place"], boards["place"])
    assert low["height"] == pytest.approx(0.2 * boards["height"])


def test_boards_are_as_high_and_as_many_as_is_said() -> None:
    boards = scattered_boards(0.01)
    assert 0.003 <= boards["height"].min() < 0.0035
    assert 0.0095 < boards["height"].max() <= 0.01
    (x, X), (y, Y) = REGION
    area = 4.0 * boards["half"].prod(axis=1).sum() / ((X - x) * (Y - y))
    assert 0.25 < area < 0.45
    assert len(scattered_boards(0.0)) == 0


def test_there_is_none_where_a_robot_starts() -> None:
    grid = np.linspace(-START, START, 71)
    places = np.stack(np.meshgrid(grid, grid), axis=-1)
    for seed in range(5):
        assert not FloorHeight(scattered_boards(0.01, seed)).at(places).any()


def test_the_height_of_the_floor_is_that_of_the_highest_board() -> None:
    boards = scattered_boards(0.01)
    floor = FloorHeight(boards)
    assert (floor.at(boards["place"]) >= boards["height"] - 1e-12)[2:-2].mean() > 0.95
    assert (floor.at(np.array([[50.0, 0.0], [0.0, 0.0], [-3.5, 0.0]])) == 0.0).all()
    alone = boards[:1].copy()
    alone["place"], alone["heading"], alone["half"] = (1.0, 1.0), math.pi / 2.0, (0.12, 0.05)
    places = np.array([[1.0, 1.11], [1.04, 1.0], [1.0, 1.13], [1.06, 1.0]])
    found = FloorHeight(alone).at(places)
    assert found == pytest.approx([*[alone["height"][0]] * 2, 0.0, 0.0])


def test_numbers_and_boards_are_the_same() -> None:
    boards = scattered_boards(0.01)
    assert laid_boards(board_numbers(boards)).tobytes() == boards.tobytes()
    assert board_numbers(boards[:0]).shape == (0, 6)


def test_the_highest_board_is_the_highest_that_a_landing_is_believed_on() -> None:
    robot = sf.walking_robot(sf.load_multibody(sf.load_robot("paper-biped")))
    assert pytest.approx(SOON_DOWN * robot.swing.height) == MAX_HEIGHT
    assert sf.Surroundings(bumps=MAX_HEIGHT).boards["height"].max() <= MAX_HEIGHT


@pytest.mark.parametrize(
    ("velocity", "turning", "duration", "where"),
    [
        ((0.3, 0.0), 0.0, 31.0, ""),
        ((0.3, 0.0), 0.0, 32.0, r"\(9\.5, 0\.0\)"),
        ((-0.3, 0.0), 0.0, 9.0, r"\(-2\.5, 0\.0\)"),
        ((0.0, 0.2), 0.0, 14.0, r"\(0\.0, 2\.5\)"),
        ((0.3, 0.0), 0.2, 100.0, r"2\.5\)"),  # a circle of 1.5 m, to its left
        ((0.3, 0.0), 0.3, 100.0, ""),  # a circle of 1 m
    ],
)
def test_a_course_that_leaves_the_boards_is_refused(
    velocity: tuple[float, float], turning: float, duration: float, where: str
) -> None:
    places = course_of([(0.0, sf.Steering(velocity, turning))], duration)
    if not where:
        check_course(places)
        return
    with pytest.raises(sf.ParameterError, match=f"on the boards.*{where} m; walk more slowly"):
        check_course(places)


def test_a_course_goes_on_and_stands_as_it_is_told() -> None:
    route = [
        (0.0, sf.Steering((0.3, 0.0))),
        (2.0, sf.Steering((0.0, 0.1), 0.5 * math.pi)),
        (3.0, sf.Steering((0.2, 0.0))),
        (4.0, sf.Steering((0.2, 0.0), standing=True)),
    ]
    places = course_of(route, 5.0)
    assert places[99] == pytest.approx([0.6, 0.0], abs=0.01)
    # A quarter of a turn to the left, sideways: backwards and to the left.
    assert places[149] == pytest.approx([0.6 - 0.2 / math.pi, 0.2 / math.pi], abs=0.01)
    assert places[-1] == pytest.approx(places[149] + (0.0, 0.2), abs=0.01)
    assert places[-1] == pytest.approx(places[205], abs=1e-9)


@pytest.mark.parametrize(
    ("height", "seed"), [(-0.01, 0), (math.nan, 0), (0.04, 0), (math.inf, 0), (0.01, -1)]
)
def test_wrong_bumps_are_refused(height: float, seed: int) -> None:
    with pytest.raises(sf.ParameterError, match=r"`(height|seed)`"):
        scattered_boards(height, seed)
    with pytest.raises(sf.ParameterError, match=r"`(bumps|seed)`"):
        sf.Surroundings(bumps=height, seed=seed)


def test_a_sole_may_stand_on_a_board_and_a_knee_may_not(body_control: sf.BodyControl) -> None:
    plant = BodyPlant(body_control.multibody, ROUGH)
    assert plant.state() == STANDS
    flat = BodyPlant(body_control.multibody, sf.Surroundings(friction=0.7))
    boards = plant.model.ngeom - flat.model.ngeom
    assert boards == len(ROUGH.boards)
    on_floor = plant.model.geom_bodyid == 0
    assert on_floor.sum() == boards + 1
    assert (plant.model.geom_friction[on_floor, 0] == 0.7).all()
    plant.position[:2] = ROUGH.boards["place"][400]
    plant.position[2] += 0.5 * ROUGH.boards["height"][400]
    mujoco.mj_forward(plant.model, plant.data)
    touched = set(plant.data.contact.geom.ravel().tolist())
    names = {plant.model.geom(index).name for index in touched}
    assert any(name.startswith("board_") for name in names), names
    assert plant.state() == STANDS
    plant.position[2] -= 0.45
    mujoco.mj_forward(plant.model, plant.data)
    assert plant.state() == TOUCHED


def test_a_fork_stands_on_the_same_boards(body_control: sf.BodyControl) -> None:
    plant = BodyPlant(body_control.multibody, ROUGH)
    fork = plant.fork()
    fork.pushes = (sf.Push(0.0, 0.1, (10.0, 0.0)),)
    assert fork.model is plant.model
    assert fork.surroundings == ROUGH
    assert fork.pushes != plant.pushes


def test_it_walks_over_bumps_and_its_feet_are_clear_of_them(rough: sf.Rollout) -> None:
    trace = rough.body
    assert trace is not None
    assert not rough.fallen
    assert len(trace.boards) == len(ROUGH.boards)
    on = trace.sole_force[:, :, 2] > 100.0
    assert np.abs(np.median(trace.clearance[on])) < 0.002
    # Where a sole stands on a board it is as much higher as that.
    height = FloorHeight(laid_boards(trace.boards)).at(trace.sole_position[..., :2])
    assert (on & (height > 0.004)).any()
    assert trace.sole_position[..., 2][on & (height > 0.004)].min() > 0.002
    assert "bumps=0.01" in trace.surroundings


def test_the_picture_shows_the_boards(rough: sf.Rollout) -> None:
    assert rough.body is not None
    figure = walk_figure(rough)
    top = next(ax for ax in figure.axes if ax.get_xlabel() == "x [m]")
    drawn = [patch for patch in top.patches if str(patch.get_gid()).startswith("board-")]
    assert 0 < len(drawn) < len(ROUGH.boards)
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "board on the floor" in words
    plt.close("all")

"""The floor of a body: flat, or with boards that lie about on it, and how high it is at a place.

Boards, not hills: a sole that lands on the edge of one tilts, which is what makes bumps hard for
feet, and box against box is contact that physics computes exactly.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_most, check_number, check_seed
from surefoot.errors import ParameterError
from surefoot.record import Record, Vector2, field

TIME_STEP = 0.001
"""Of the physics, and of control [s]. It is that of the loops of robots, whatever their size, and
does not follow from the robot: omega times it is 0.0035 for the paper's biped."""

REGION = ((-3.0, 10.0), (-3.0, 3.0))
"""Where there are boards, x and y [m]; the floor around is flat."""

VERGE = 0.5
"""Of the boards, for a robot that is beside its course [m]."""

PITCH = 0.3
"""Of the grid whose cells have a board each [m]."""

SIDES = (0.1, 0.25)
"""Shortest and longest side of a board, about as large as a foot [m]."""

THINNEST = 0.3
"""Height of the lowest board, of the highest one's [-]."""

START = 0.35
"""Around the origin, along x and y, there is no board [m]."""

MAX_HEIGHT = 0.03
"""Of boards [m]: how much higher than its fellow a foot may be that is believed to have landed."""

RASTER = 0.01
"""Of the grid on which heights are looked up [m]."""


class Board(Record):
    """A board that lies on the floor."""

    place: Vector2 = field("m", "its middle")
    half: Vector2 = field("m", "half its sides")
    heading: float = field("rad", "of its first side, counter-clockwise from x")
    height: float = field("m", "of its upper side over the floor")


NO_BOARDS = np.zeros(0, Board.DTYPE)
"""A flat floor."""


def scattered_boards(height: float, seed: int = 0) -> NDArray[np.void]:
    """Boards as large as feet, at random places and headings, a third of the floor.

    The same seed puts them at the same places at every height. They are 0.3 to 1 times as high as
    is asked for, and there is none where a robot starts.

    Args:
        height: of the highest that there may be [m], up to `MAX_HEIGHT`; 0 is a flat floor.
        seed: of the random numbers, at least 0.

    Returns:
        Records of `Board`, shape (n,).

    Raises:
        ParameterError: an argument is out of range.
    """
    check_height("height", height)
    check_seed(seed)
    if height == 0.0:
        return NO_BOARDS
    cells = [np.arange(low, high - 0.5 * PITCH, PITCH) for low, high in REGION]
    corners = np.stack(np.meshgrid(*cells, indexing="ij"), axis=-1).reshape(-1, 2)
    draw = np.random.default_rng(seed)
    boards = np.zeros(len(corners), Board.DTYPE)
    boards["place"] = corners + PITCH * draw.random((len(corners), 2))
    boards["half"] = 0.5 * draw.uniform(*SIDES, (len(corners), 2))
    boards["heading"] = draw.uniform(-math.pi, math.pi, len(corners))
    boards["height"] = height * draw.uniform(THINNEST, 1.0, len(corners))
    reach = np.hypot(*boards["half"].T)
    near = (np.abs(boards["place"]) < START + reach[:, None]).all(axis=1)
    return boards[~near]


def check_height(name: str, height: float) -> None:
    """Refuse boards that no robot can walk over.

    Raises:
        ParameterError: the height is negative, not finite, or above `MAX_HEIGHT`.
    """
    check_number(name, height, 0.0, "m")
    why = "a foot that touches so much higher than its fellow is not believed to have landed"
    check_most(name, height, MAX_HEIGHT, "m", why)


def check_course(places: NDArray[np.float64]) -> None:
    """Refuse a course that leaves the boards: the floor beyond is flat, which no walk would show.

    Args:
        places: on the course, shape (n, 2) [m].

    Raises:
        ParameterError: a place is nearer than `VERGE` to the edge of `REGION`, or beyond it.
    """
    low, high = np.transpose(REGION)
    beyond = np.flatnonzero(((places < low + VERGE) | (places > high - VERGE)).any(axis=1))
    if len(beyond):
        (x, y), ((left, right), (back, front)) = places[beyond[0]], REGION
        raise ParameterError(
            f"with bumps, a course on the boards, {VERGE:g} m within x from {left:g} to {right:g} "
            f"and y from {back:g} to {front:g} m",
            f"one that comes to ({x:.1f}, {y:.1f}) m",
            "walk more slowly or not as long, or turn back earlier",
        )


def board_numbers(boards: NDArray[np.void]) -> NDArray[np.float64]:
    """Boards as plain numbers, shape (n, 6), in the order of `Board`."""
    return boards.view(np.float64).reshape(-1, Board.DTYPE.itemsize // 8)


def laid_boards(numbers: NDArray[np.float64]) -> NDArray[np.void]:
    """The boards that `board_numbers` made numbers of."""
    return np.ascontiguousarray(numbers, np.float64).reshape(-1).view(Board.DTYPE)


class FloorHeight:
    """Height of the floor at many places, looked up on a grid of 1 cm.

    Args:
        boards: records of `Board`.
    """

    def __init__(self, boards: NDArray[np.void]) -> None:
        shape = [round((high - low) / RASTER) + 1 for low, high in REGION]
        self._heights = np.zeros(shape if len(boards) else (1, 1))
        for index in range(len(boards)):
            self._lay(boards[index])

    def _lay(self, board: Any) -> None:
        reach = float(np.hypot(*board["half"]))
        spans = []
        for place, (low, _), size in zip(board["place"], REGION, self._heights.shape, strict=True):
            first = max(math.floor((place - reach - low) / RASTER), 0)
            last = min(math.ceil((place + reach - low) / RASTER) + 1, size)
            spans.append(slice(first, max(last, first)))
        x, y = (
            low + RASTER * np.arange(span.start, span.stop) - place
            for place, (low, _), span in zip(board["place"], REGION, spans, strict=True)
        )
        cosine, sine = math.cos(board["heading"]), math.sin(board["heading"])
        along = cosine * x[:, None] + sine * y[None]
        across = cosine * y[None] - sine * x[:, None]
        on = (np.abs(along) <= board["half"][0]) & (np.abs(across) <= board["half"][1])
        part = self._heights[spans[0], spans[1]]
        part[on] = np.maximum(part[on], board["height"])

    def at(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Height at places, shape (..., 2) to shape (...) [m]."""
        if self._heights.size == 1:
            return np.zeros(np.shape(places)[:-1])
        low = np.array([first for first, _ in REGION])
        cells = np.rint((np.asarray(places) - low) / RASTER).astype(int)
        inside = np.all((cells >= 0) & (cells < self._heights.shape), axis=-1)
        cells = np.where(np.expand_dims(inside, -1), cells, 0)
        return np.where(inside, self._heights[cells[..., 0], cells[..., 1]], 0.0)

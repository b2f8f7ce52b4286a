"""A record is declared once: its dtype, keywords, types and docstring; and it can be rotated."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import surefoot as sf
from surefoot.interface import (
    COMMAND,
    OBSERVATION,
    Command,
    Mode,
    Observation,
    Status,
    rotate_record,
)
from surefoot.record import Array, Record, Vector2, field, new_array


class Colour(IntEnum):
    """Something to choose from."""

    RED = 1
    BLUE = 2


class Landing(Record):
    """A step that has ended."""

    time: float = field("s", "time of the touchdown")
    offset: Vector2 = field("m", "DCM relative to the foot (x, y)", default=(0.0, 0.1))
    adapted: bool = field("", "whether the step was adapted", default=False)


class Walk(Record):
    """Landings one after the other."""

    first: Landing = field("", "where the walk began")
    colour: Colour = field("", "of the shoes", default=Colour.BLUE)
    counts: Array = field("", "of steps", shape=3, kind=int, default=(0, 0, 0))
    landings: Array = field("", "the last ones", shape=2, kind=Landing)
    table: Array = field("m", "heights", shape=(2, 3), default=0.0)


class Marked(Landing):
    """One with a mark."""

    mark: int = field("", "which it is", default=3)


LANDING = [("time", "f8"), ("offset", "f8", (2,)), ("adapted", "?")]


def walk() -> Walk:
    return Walk(first=Landing(time=1.0), landings=np.zeros(2, Landing.DTYPE))


def test_the_lines_make_the_dtype_that_kernels_see() -> None:
    assert np.dtype(LANDING) == Landing.DTYPE
    # Its own fields first: Numba takes a record that another one begins with for the same.
    assert np.dtype([("mark", "i8"), *LANDING]) == Marked.DTYPE
    assert Marked(time=1.0).mark == 3
    assert (
        np.dtype(
            [
                ("first", LANDING),
                ("colour", "i8"),
                ("counts", "i8", (3,)),
                ("landings", LANDING, (2,)),
                ("table", "f8", (2, 3)),
            ]
        )
        == Walk.DTYPE
    )


def test_every_kind_of_value_is_read_as_it_was_given() -> None:
    made = walk().replace(counts=(1, 2, 3), first=Landing(time=2.0, offset=(3.0, 4.0)))
    assert made.first == Landing(time=2.0, offset=(3.0, 4.0), adapted=False)
    assert made.first.time == 2.0
    assert made.first.adapted is False
    assert made.first.offset.tolist() == [3.0, 4.0]
    assert made.colour is Colour.BLUE
    assert made.counts.tolist() == [1, 2, 3]
    assert made.landings["offset"].shape == (2, 2)
    assert made.table.shape == (2, 3)
    assert walk() == walk() != made
    assert repr(Landing(time=1.0)) == "Landing(time=1.0, offset=array([0. , 0.1]), adapted=False)"


def test_a_record_is_a_value() -> None:
    made = walk()
    with pytest.raises(AttributeError, match=r"make another one with replace\(colour=...\)"):
        made.colour = Colour.RED  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        made.table[0, 0] = 1.0
    changed = made.replace(colour=Colour.RED)
    assert (made.colour, changed.colour) == (Colour.BLUE, Colour.RED)


def test_a_keyword_that_is_missing_or_unknown_is_named() -> None:
    with pytest.raises(TypeError, match="missing a required argument: 'time'"):
        Landing(offset=(0.0, 0.0))  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="unexpected keyword argument 'tim'"):
        Landing(time=1.0, tim=2.0)  # type: ignore[call-arg]
    with pytest.raises(ValueError, match="shape"):
        Landing(time=1.0, offset=(1.0, 2.0, 3.0))


def test_a_field_without_an_annotation_is_refused() -> None:
    with pytest.raises(sf.ParameterError, match="expected an annotation of the field `time`"):
        type("Bare", (Record,), {"time": field("s", "now")})


@pytest.mark.parametrize("kind", [Observation, Command, sf.StepProblem, Landing, Walk])
def test_the_docstring_has_a_line_with_the_unit_of_every_field(kind: type[Record]) -> None:
    text = " ".join((kind.__doc__ or "").split())
    for name, its in kind.FIELDS.items():
        assert f"{name}: {its.words}" + (f" [{its.unit}]." if its.unit else ".") in text


def test_a_command_can_be_made_by_keyword() -> None:
    command = Command(
        zmp=(0.1, 0.0),
        dcm_plan=(0.0, 0.0),
        step_location=(0.2, 0.1),
        step_duration=0.4,
        swing_foot=(0.1, 0.1, 0.02),
        status=Status.ZMP_AT_EDGE,
    )
    assert command.zmp.tolist() == [0.1, 0.0]
    assert command.mode is Mode.TRACKING
    assert command.status is Status.ZMP_AT_EDGE
    assert command.swing_foot_velocity.tolist() == [0.0, 0.0, 0.0]
    assert Command.of(new_array(Command.DTYPE)).step_duration == 0.0


ANGLE = st.floats(-math.pi, math.pi)
SEED = st.integers(0, 2**32 - 1)
KINDS = pytest.mark.parametrize("kind", [OBSERVATION, COMMAND], ids=["observation", "command"])
YAWS = {"support_yaw", "swing_yaw"}


def any_record(kind: np.dtype[np.void], seed: int) -> NDArray[np.void]:
    """All numbers between -1 and 1."""
    rng, record = np.random.default_rng(seed), new_array(kind)
    for name in kind.names or ():
        record[name] = rng.uniform(-1.0, 1.0, record[name].shape)
    return record


def numbers(record: NDArray[np.void]) -> dict[str, NDArray[np.float64]]:
    return {name: np.atleast_1d(record[name][0]) for name in record.dtype.names or ()}


@KINDS
@given(seed=SEED, angle=ANGLE)
def test_there_and_back(kind: np.dtype[np.void], seed: int, angle: float) -> None:
    record = any_record(kind, seed)
    back = numbers(rotate_record(rotate_record(record, angle), -angle))
    for name, value in numbers(record).items():
        assert back[name] == pytest.approx(value, abs=2e-15), name


@KINDS
@given(seed=SEED, first=ANGLE, second=ANGLE)
def test_two_turns_are_their_sum(
    kind: np.dtype[np.void], seed: int, first: float, second: float
) -> None:
    record = any_record(kind, seed)
    once = numbers(rotate_record(record, first + second))
    for name, value in numbers(rotate_record(rotate_record(record, first), second)).items():
        assert value == pytest.approx(once[name], abs=5e-15), name


@KINDS
def test_no_turn_leaves_every_bit(kind: np.dtype[np.void]) -> None:
    record = any_record(kind, 1)
    assert rotate_record(record, 0.0).tobytes() == record.tobytes()


@KINDS
def test_what_is_turned_is_not_changed(kind: np.dtype[np.void]) -> None:
    record = any_record(kind, 1)
    before = record.tobytes()
    rotate_record(record, 0.3)
    assert record.tobytes() == before


@KINDS
def test_a_quarter_turn_brings_x_to_y(kind: np.dtype[np.void]) -> None:
    """Every field with an x and a y is a vector; of the others only headings turn."""
    record = any_record(kind, 2)
    after = numbers(rotate_record(record, 0.5 * math.pi))
    for name, value in numbers(record).items():
        expected = value.copy()
        if len(value) > 1:
            expected[:2] = -value[1], value[0]
        elif name in YAWS:
            expected = value + 0.5 * math.pi
        assert after[name] == pytest.approx(expected, abs=1e-15), name

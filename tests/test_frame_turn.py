"""Records in a turned frame: what is a vector turns, what is not stays, and back is back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from surefoot.dcm.frame_turn import turned
from surefoot.interface import COMMAND, OBSERVATION
from surefoot.record import new_array

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


def fields(record: NDArray[np.void]) -> dict[str, NDArray[np.float64]]:
    return {name: np.atleast_1d(record[name][0]) for name in record.dtype.names or ()}


@KINDS
@given(seed=SEED, angle=ANGLE)
def test_there_and_back(kind: np.dtype[np.void], seed: int, angle: float) -> None:
    record = any_record(kind, seed)
    back = fields(turned(turned(record, angle), -angle))
    for name, value in fields(record).items():
        assert back[name] == pytest.approx(value, abs=2e-15), name


@KINDS
@given(seed=SEED, first=ANGLE, second=ANGLE)
def test_two_turns_are_their_sum(
    kind: np.dtype[np.void], seed: int, first: float, second: float
) -> None:
    record = any_record(kind, seed)
    once = fields(turned(record, first + second))
    for name, value in fields(turned(turned(record, first), second)).items():
        assert value == pytest.approx(once[name], abs=5e-15), name


@KINDS
def test_no_turn_leaves_every_bit(kind: np.dtype[np.void]) -> None:
    record = any_record(kind, 1)
    assert turned(record, 0.0).tobytes() == record.tobytes()


@KINDS
def test_what_is_turned_is_not_changed(kind: np.dtype[np.void]) -> None:
    record = any_record(kind, 1)
    before = record.tobytes()
    turned(record, 0.3)
    assert record.tobytes() == before


@KINDS
def test_a_quarter_turn_brings_x_to_y(kind: np.dtype[np.void]) -> None:
    """Every field with an x and a y is a vector; of the others only headings turn."""
    record = any_record(kind, 2)
    after = fields(turned(record, 0.5 * math.pi))
    for name, value in fields(record).items():
        expected = value.copy()
        if len(value) > 1:
            expected[:2] = -value[1], value[0]
        elif name in YAWS:
            expected = value + 0.5 * math.pi
        assert after[name] == pytest.approx(expected, abs=1e-15), name

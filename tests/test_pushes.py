from __future__ import annotations

import math

import pytest

import surefoot as sf
from surefoot.dcm.pushes import force_until_change, push_records


def test_impulse_and_delta_v() -> None:
    push = sf.Push(1.1, 0.2, (176.0, -10.0))
    assert push.end == pytest.approx(1.3)
    assert push.impulse == pytest.approx((35.2, -2.0))
    assert push.delta_v(70.0) == pytest.approx((35.2 / 70.0, -2.0 / 70.0))


def test_overlapping_pushes_add_up_and_their_edges_are_found() -> None:
    pushes = push_records([sf.Push(1.0, 1.0, (10.0, 1.0)), sf.Push(1.5, math.inf, (5.0, 2.0))])
    assert force_until_change(pushes, 0.0, 9.0) == (0.0, 0.0, 1.0)
    assert force_until_change(pushes, 1.0, 9.0) == (10.0, 1.0, 1.5)
    assert force_until_change(pushes, 1.5, 9.0) == (15.0, 3.0, 2.0)
    assert force_until_change(pushes, 2.0, 9.0) == (5.0, 2.0, 9.0)
    assert force_until_change(pushes, 1.2, 1.3) == (10.0, 1.0, 1.3)


def test_what_is_no_push() -> None:
    with pytest.raises(sf.ParameterError, match=r"a Push; got \(1, 2\)"):
        push_records([(1, 2)])  # type: ignore[list-item]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 0.0, (1.0, 0.0)), "positive duration"),
        ((0.0, -0.1, (1.0, 0.0)), "positive duration"),
        ((math.nan, 0.1, (1.0, 0.0)), "finite start"),
        ((0.0, math.nan, (1.0, 0.0)), "positive duration"),
        ((0.0, 0.1, (math.inf, 0.0)), "finite start and force"),
        ((0.0, 0.1, 176.0), r"a pair \(x, y\) for force"),
        ((0.0, 0.1, (1.0, 2.0, 3.0)), r"a pair \(x, y\) for force"),
        (("soon", 0.1, (1.0, 2.0)), "numbers for start and duration"),
    ],
)
def test_a_push_that_makes_no_sense(arguments, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        sf.Push(*arguments)

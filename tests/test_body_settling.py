"""When a pushed body counts as back in a gait."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from surefoot.record import new_array
from surefoot.rollout.trace import WALKING
from surefoot.studies.engine.body_recovery import BegunStep, Settling
from surefoot.worlds.body.controller import BodyState
from surefoot.worlds.body.step import BODY_WALK

STEP, OFFSET = 0.3, (0.02, 0.06)
USUAL = {
    side: BegunStep(side, np.array([OFFSET[0], sign * OFFSET[1]]), 0.0, STEP)
    for side, sign in enumerate((-1.0, 1.0))
}


def steps_until_done(
    settling: Settling, offsets: list[tuple[float, float]], durations: list[float], start: float
) -> int | None:
    """After how many steps it is done, None if after none; a step is looked at three times."""
    time = start
    for n, (offset, duration) in enumerate(zip(offsets, durations, strict=True)):
        walk = new_array(BODY_WALK)
        side, sign = n % 2, -1.0 if n % 2 == 0 else 1.0
        walk["phase"], walk["steps"], walk["support"], walk["began"] = WALKING, n, side, time
        foot = np.array([0.5 * n, 0.1 * n])
        dcm = foot + np.array([offset[0], sign * offset[1]])
        seen: Any = SimpleNamespace(dcm=dcm, support_foot=foot)
        state = cast(BodyState, SimpleNamespace(walk=walk, observation=seen))
        if any(settling.done(state) for _ in range(3)):
            return n + 1
        time += duration
    return None


def test_four_steps_like_the_last_one_on_that_foot_are_a_gait() -> None:
    """The first two have none to be like; a step lasts until the next one begins."""
    found = steps_until_done(Settling(USUAL, 0.0), [OFFSET] * 12, [STEP] * 12, 1.0)
    # The duration before the first step is not known, so the third compares with nothing.
    assert found == 7
    other = (OFFSET[0] + 0.03, OFFSET[1] - 0.01)
    assert steps_until_done(Settling(USUAL, 0.0), [other] * 12, [0.27] * 12, 1.0) == 7


def test_steps_within_the_push_do_not_count() -> None:
    assert steps_until_done(Settling(USUAL, 2.0), [OFFSET] * 12, [STEP] * 12, 1.0) == 8


@pytest.mark.parametrize(
    ("offsets", "durations"),
    [
        # It runs away, slowly; slower, but from too far; it has gone too far from where it was; its
        # steps last in turn longer and less long on the same foot.
        ([(OFFSET[0] + 0.003 * n, OFFSET[1]) for n in range(12)], [STEP] * 12),
        ([(OFFSET[0] + 0.032 + 0.002 * n, OFFSET[1]) for n in range(12)], [STEP] * 12),
        ([(OFFSET[0] + 0.06, OFFSET[1])] * 12, [STEP] * 12),
        ([OFFSET] * 12, [STEP, STEP, STEP + 0.03, STEP + 0.03] * 3),
    ],
)
def test_what_is_no_gait_is_walked_to_the_end(
    offsets: list[tuple[float, float]], durations: list[float]
) -> None:
    assert steps_until_done(Settling(USUAL, 0.0), offsets, durations, 1.0) is None

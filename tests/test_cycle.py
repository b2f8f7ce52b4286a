"""What every controller does in a cycle: the swing foot within the limits of its leg."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from surefoot.control.cycle import LIMIT_TOLERANCE, SwingParameters, is_surely_slow, is_too_fast
from surefoot.dcm.swing_foot import quintic

SPEED, ACCELERATION = 3.0, 40.0


def leg() -> np.record:
    swing = np.zeros(1, SwingParameters.DTYPE)
    swing["max_speed"], swing["max_acceleration"] = SPEED, ACCELERATION
    return swing.view(np.recarray)[0]


@given(
    velocity=st.floats(-3.5, 3.5),
    acceleration=st.floats(-50.0, 50.0),
    landing=st.floats(-1.0, 1.0),
    left=st.floats(0.002, 0.8),
)
def test_control_points_within_the_limits_leave_no_sample_outside(
    velocity: float, acceleration: float, landing: float, left: float
) -> None:
    """The short answer never contradicts the long one."""
    way = (0.0, velocity, acceleration, landing, left)
    slow = is_surely_slow.py_func(leg(), *way)
    times = np.linspace(0.0, left, 200)
    samples = [quintic.py_func(*way[:4], 0.0, left, time) for time in times]
    fastest = max(abs(speed) for _, speed, _ in samples)
    hardest = max(abs(change) for *_, change in samples)
    if slow:
        assert fastest <= SPEED * (1.0 + 1e-9)
        assert hardest <= ACCELERATION * (1.0 + 1e-9)
        assert not is_too_fast.py_func(leg(), *way)
    if fastest > SPEED * (1.0 + LIMIT_TOLERANCE) or hardest > ACCELERATION * (
        1.0 + LIMIT_TOLERANCE
    ):
        assert not slow


def test_most_ways_are_decided_at_once() -> None:
    """From rest to a usual landing in a usual time."""
    swing = leg()
    assert is_surely_slow.py_func(swing, 0.0, 0.0, 0.0, 0.25, 0.5)
    assert not is_surely_slow.py_func(swing, 0.0, 0.0, 0.0, 0.9, 0.3)

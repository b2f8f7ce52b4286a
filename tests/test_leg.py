"""The leg against brute force: a double integrator, integrated exactly, under any control."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from surefoot.dcm.leg import (
    arrival,
    cruise_velocity,
    follow,
    furthest,
    hurry,
    is_reachable,
)

SPEEDS = st.sampled_from([1.0, 2.0, 3.0, 6.0, math.inf])
ACCELERATIONS = st.sampled_from([10.0, 30.0, 60.0, 120.0, math.inf])
FINITE = st.sampled_from([10.0, 30.0, 60.0, 120.0])
velocities = st.floats(-3.0, 3.0)
places = st.floats(-0.6, 0.6)
times = st.floats(0.002, 0.6)
PERIOD = 0.001


def within(velocity: float, speed: float) -> float:
    return min(max(velocity, -speed), speed)


def integrate(velocity: float, accelerations, durations) -> tuple[float, float]:
    """Displacement and velocity after pieces of constant acceleration, exactly."""
    place = 0.0
    for acceleration, duration in zip(accelerations, durations, strict=True):
        place += velocity * duration + 0.5 * acceleration * duration**2
        velocity += acceleration * duration
    return place, velocity


@given(velocities, times, SPEEDS, FINITE, st.integers(0, 2**31), st.booleans())
def test_no_control_gets_further(velocity, time, speed, acceleration, seed, bang) -> None:
    velocity, rng = within(velocity, speed), np.random.default_rng(seed)
    durations = rng.dirichlet(np.ones(8)) * time
    wanted = acceleration * rng.uniform(-1.0, 1.0, 8)
    if bang:
        wanted = acceleration * rng.choice([-1.0, 1.0], 8, p=[0.1, 0.9])
    used, now = [], velocity
    for pull, duration in zip(wanted, durations, strict=True):
        then = within(now + pull * duration, speed)
        used.append((then - now) / duration)
        now = then
    place, _ = integrate(velocity, used, durations)
    assert place <= furthest(velocity, time, speed, acceleration) + 1e-12
    assert -place <= furthest(-velocity, time, speed, acceleration) + 1e-12


@given(velocities, times, SPEEDS, FINITE)
def test_full_acceleration_and_then_the_top_speed_get_there(
    velocity, time, speed, acceleration
) -> None:
    velocity = within(velocity, speed)
    ramp = min(time, (speed - velocity) / acceleration)
    place, _ = integrate(velocity, (acceleration, 0.0), (ramp, time - ramp))
    assert furthest(velocity, time, speed, acceleration) == pytest.approx(place, abs=1e-12)


@given(velocities, times, SPEEDS)
def test_a_large_acceleration_is_nearly_an_unlimited_one(velocity, time, speed) -> None:
    velocity = within(velocity, speed)
    near = furthest(velocity, time, min(speed, 10.0), 1e9)
    assert near == pytest.approx(furthest(velocity, time, min(speed, 10.0), math.inf), abs=1e-6)


# Near the foot too, where a fast one runs past and comes back.
@given(
    st.one_of(places, st.floats(-0.05, 0.05)), velocities, st.floats(0.0, 0.3), SPEEDS,
    ACCELERATIONS,
)  # fmt: skip
@example(0.01, 2.0, 0.02, 3.0, 60.0)
@example(-0.01, -2.0, 0.05, math.inf, 60.0)
def test_the_arrival_is_the_first_time_at_which_a_place_is_reachable(
    away, velocity, earliest, speed, acceleration
) -> None:
    velocity = within(velocity, speed)
    time = arrival(away, velocity, earliest, speed, acceleration)
    assert time >= earliest
    assert is_reachable(away, velocity, time * (1.0 + 1e-9), speed, acceleration)
    for before in np.linspace(earliest, time, 40)[:-1]:
        if before < time - 1e-4:
            assert not is_reachable(away, velocity, before, speed, acceleration)


@given(places, velocities, velocities, times, SPEEDS, FINITE)
def test_a_foot_that_follows_obeys_its_acceleration(
    away, wanted, velocity, time, speed, acceleration
) -> None:
    """What it gets to lies between the two ways that switch once, from -A to A and back."""
    velocity = within(velocity, speed)
    place, then = follow(away, wanted, velocity, time, speed, acceleration)
    assert abs(then) <= speed
    assert abs(then - velocity) <= acceleration * time * (1.0 + 1e-9)
    early = 0.5 * (time + (then - velocity) / acceleration)
    early = min(max(early, 0.0), time)
    most, _ = integrate(velocity, (acceleration, -acceleration), (early, time - early))
    least, _ = integrate(velocity, (-acceleration, acceleration), (time - early, early))
    assert least - 1e-9 <= place <= most + 1e-9
    if is_reachable(away, velocity, time, speed, acceleration):
        assert place == pytest.approx(away, abs=2e-9)


@given(places, velocities, st.integers(2, 500), SPEEDS, ACCELERATIONS)
def test_a_foot_that_hurries_arrives_whenever_it_can(
    away, velocity, cycles, speed, acceleration
) -> None:
    velocity = within(velocity, speed) if acceleration < math.inf else 0.0
    assume(is_reachable(away, velocity, cycles * PERIOD, speed, acceleration))
    for left in range(cycles, 0, -1):
        moved, then, _ = hurry(away, velocity, left * PERIOD, PERIOD, speed, acceleration)
        assert abs(then) <= speed * (1.0 + 1e-9)
        if acceleration < math.inf:
            assert abs(then - velocity) <= acceleration * PERIOD * (1.0 + 1e-6)
        away, velocity = away - moved, then
    assert abs(away) < 1e-6


@given(places, velocities, velocities, times, SPEEDS, ACCELERATIONS)
def test_both_ways_along_an_axis_are_alike(
    away, wanted, velocity, time, speed, acceleration
) -> None:
    velocity, limits = within(velocity, speed), (speed, acceleration)
    assume(away != 0.0)
    place, then = follow(away, wanted, velocity, time, *limits)
    assert follow(-away, -wanted, -velocity, time, *limits) == (-place, -then)
    hurried = hurry(away, velocity, time, PERIOD, *limits)
    assert hurry(-away, -velocity, time, PERIOD, *limits) == tuple(-value for value in hurried)
    assert arrival(-away, -velocity, time, *limits) == arrival(away, velocity, time, *limits)
    cruise = cruise_velocity(away, velocity, time, acceleration)
    assert cruise_velocity(-away, -velocity, time, acceleration) == -cruise

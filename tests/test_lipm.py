from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import surefoot as sf
from surefoot.dcm.pendulum import com_flow, dcm_flow, pushed_pivot

positions = st.floats(-2.0, 2.0)
durations = st.floats(0.0, 0.8)
omegas = st.floats(2.0, 6.0)


def test_natural_frequency_of_table_2(robot: sf.Robot) -> None:
    # sqrt(9.81 / 0.8) = 3.5018
    assert robot.replace(com_height=0.8).omega == pytest.approx(3.5018, abs=5e-5)
    assert robot.replace(com_height=0.8, gravity=1.62).omega == pytest.approx(math.sqrt(1.62 / 0.8))


@given(positions, positions, omegas, durations, durations)
def test_dcm_flow_is_a_semigroup(dcm, pivot, omega, a, b) -> None:
    together = dcm_flow(dcm, pivot, omega, a + b)
    in_turn = dcm_flow(dcm_flow(dcm, pivot, omega, a), pivot, omega, b)
    assert in_turn == pytest.approx(together, rel=1e-12, abs=1e-9)


@given(positions, positions, positions, omegas, durations, durations)
def test_com_flow_is_a_semigroup(com, velocity, pivot, omega, a, b) -> None:
    together = com_flow(com, velocity, pivot, omega, a + b)
    in_turn = com_flow(*com_flow(com, velocity, pivot, omega, a), pivot, omega, b)
    assert in_turn == pytest.approx(together, rel=1e-12, abs=1e-9)


@given(positions, positions, positions, omegas, durations)
def test_the_flow_can_be_run_backwards(com, velocity, pivot, omega, duration) -> None:
    there = com_flow(com, velocity, pivot, omega, duration)
    assert com_flow(*there, pivot, omega, -duration) == pytest.approx((com, velocity), abs=1e-9)


@given(positions, positions, positions, omegas, durations)
def test_the_dcm_of_the_com_flow_is_the_dcm_flow(com, velocity, pivot, omega, duration) -> None:
    com_then, velocity_then = com_flow(com, velocity, pivot, omega, duration)
    dcm_then = dcm_flow(com + velocity / omega, pivot, omega, duration)
    assert com_then + velocity_then / omega == pytest.approx(dcm_then, abs=1e-9)


def test_com_flow_solves_the_pushed_pendulum() -> None:
    """Two implementations: the closed form, and Runge-Kutta on x'' = w^2 (x - p) + F/m."""
    omega, mass, force, zmp = 3.5, 70.0, 50.0, 0.1
    x, v, dt = 0.05, 0.3, 1e-4

    def slope(x: float, v: float) -> tuple[float, float]:
        return v, omega**2 * (x - zmp) + force / mass

    pivot = pushed_pivot(zmp, force, mass, omega)
    expected = com_flow(x, v, pivot, omega, 0.5)
    for _ in range(5000):
        k1 = slope(x, v)
        k2 = slope(x + 0.5 * dt * k1[0], v + 0.5 * dt * k1[1])
        k3 = slope(x + 0.5 * dt * k2[0], v + 0.5 * dt * k2[1])
        k4 = slope(x + dt * k3[0], v + dt * k3[1])
        x += dt / 6.0 * (k1[0] + 2.0 * k2[0] + 2.0 * k3[0] + k4[0])
        v += dt / 6.0 * (k1[1] + 2.0 * k2[1] + 2.0 * k3[1] + k4[1])
    assert (x, v) == pytest.approx(expected, abs=1e-10)


@given(positions, positions, positions, omegas, durations)
def test_compiled_and_interpreted_agree(com, velocity, pivot, omega, duration) -> None:
    compiled = com_flow(com, velocity, pivot, omega, duration)
    assert com_flow.py_func(com, velocity, pivot, omega, duration) == pytest.approx(
        compiled, rel=1e-13, abs=1e-13
    )

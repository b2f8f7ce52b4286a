"""The pendulum and the flywheel at its hip: exact flow, its stop, and what it does to the CoM."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import surefoot as sf
from surefoot.dcm.pendulum import com_flow, dcm_flow, pushed_pivot, trunk_flow
from surefoot.robot.robot import Trunk, preset_text

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


ROBOT = sf.load_robot("paper-biped")
TRUNK = Trunk(inertia=4.4, max_torque=100.0, max_lean=0.5)

leans = st.floats(-0.5, 0.5)
speeds = st.floats(-4.0, 4.0)
torques = st.floats(-100.0, 100.0)
moments = st.floats(1e-4, 0.4)


@given(lean=leans, speed=speeds, torque=torques, duration=moments, share=st.floats(0.05, 0.95))
def test_two_flows_are_one(lean, speed, torque, duration, share) -> None:
    """The semigroup, also through the stop; the blow is taken once."""
    whole = trunk_flow(lean, speed, torque, 4.4, 0.5, duration)
    first = trunk_flow(lean, speed, torque, 4.4, 0.5, share * duration)
    rest = trunk_flow(first[0], first[1], torque, 4.4, 0.5, (1.0 - share) * duration)
    assert rest[0] == pytest.approx(whole[0], abs=1e-9)
    if abs(abs(whole[0]) - 0.5) > 1e-9:  # at the stop, it matters when it was met
        assert rest[1] == pytest.approx(whole[1], abs=1e-9)
    assert first[3] + rest[3] == pytest.approx(whole[3], abs=1e-3)


@given(lean=leans, speed=speeds, torque=torques, duration=moments)
def test_its_mirror_image_is_the_mirror_image(lean, speed, torque, duration) -> None:
    here = trunk_flow(lean, speed, torque, 4.4, 0.5, duration)
    there = trunk_flow(-lean, -speed, -torque, 4.4, 0.5, duration)
    assert (there[0], there[1], there[2], there[3]) == (-here[0], -here[1], here[2], -here[3])


@given(lean=leans, speed=speeds, torque=torques, duration=moments)
def test_the_stop_is_never_passed(lean, speed, torque, duration) -> None:
    at, _, acted, momentum = trunk_flow(lean, speed, torque, 4.4, 0.5, duration)
    assert abs(at) <= 0.5 + 1e-12
    assert 0.0 <= acted <= duration
    assert momentum == 0.0 or acted < duration


def test_it_meets_its_stop_when_it_should() -> None:
    """From rest: a = T t^2 / (2 J), so the stop is met after sqrt(2 J a / T)."""
    lean, speed, acted, momentum = trunk_flow(0.0, 0.0, 100.0, 4.4, 0.5, 1.0)
    assert lean == 0.5
    assert speed == 0.0
    assert acted == pytest.approx(math.sqrt(2.0 * 4.4 * 0.5 / 100.0))
    assert momentum == pytest.approx(100.0 * acted)


def test_angular_momentum_is_borrowed_and_given_back() -> None:
    """About the ZMP, gravity alone changes m z com' + J lean'; the blow at the stop does not."""
    robot = ROBOT.replace(trunk=TRUNK)
    simulator = sf.LipmSimulator(robot)
    observation = sf.nominal_gait(robot, (0.0, 0.0)).observation(sf.Side.RIGHT)
    observation = observation.replace(com=observation.support_foot, com_velocity=(0.0, 0.0))
    world = simulator.start(observation)
    controller = sf.DcmTracking(robot, (0.0, 0.0))
    command, _ = controller.step(controller.start(observation), observation)
    command = command.replace(
        zmp=observation.support_foot, hip_torque=(100.0, -60.0), step_duration=9.0
    )
    weight, gained, met = robot.mass * robot.gravity, np.zeros(2), False
    for _ in range(400):
        before = observation
        observation, world = simulator.step(world, command)
        away = 0.5 * (before.com + observation.com) - observation.support_foot
        gained += weight * away * 0.001
        met = met or observation.trunk_lean[0] == TRUNK.max_lean
        momentum = robot.mass * robot.com_height * observation.com_velocity
        momentum = momentum + TRUNK.inertia * observation.trunk_lean_velocity
        # The trapezoidal sum of gravity's torque is good to its own error.
        assert momentum == pytest.approx(gained, abs=2e-3 * max(1.0, np.abs(gained).max()))
    assert met


def test_a_torque_pushes_the_com_the_other_way() -> None:
    """A lean forward pushes the CoM back, like a force of -torque / z."""
    simulator = sf.LipmSimulator(ROBOT)
    pushed = sf.LipmSimulator(ROBOT, pushes=[sf.Push(0.0, 1.0, (-40.0 / 0.8, 0.0))])
    controller = sf.DcmTracking(ROBOT, (0.5, 0.0))
    observation = controller.first_observation()
    command, _ = controller.step(controller.start(observation), observation)
    turned, _ = simulator.step(
        simulator.start(observation), command.replace(hip_torque=(40.0, 0.0))
    )
    forced, _ = pushed.step(pushed.start(observation), command)
    assert turned.com_velocity == pytest.approx(forced.com_velocity, abs=1e-12)
    assert turned.dcm == pytest.approx(forced.dcm, abs=1e-12)
    assert turned.trunk_lean[0] > 0.0 == turned.trunk_lean[1]


def test_no_more_torque_than_the_hip_has() -> None:
    simulator = sf.LipmSimulator(ROBOT)
    controller = sf.DcmTracking(ROBOT, (0.5, 0.0))
    observation = controller.first_observation()
    command, _ = controller.step(controller.start(observation), observation)
    ends = [
        simulator.step(simulator.start(observation), command.replace(hip_torque=(t, 0.0)))[0]
        for t in (100.0, 1e6)
    ]
    assert ends[0] == ends[1]


def test_a_robot_without_a_trunk_does_not_lean() -> None:
    robot = ROBOT.replace(trunk=None)
    simulator = sf.LipmSimulator(robot)
    controller = sf.DcmTracking(robot, (0.5, 0.0))
    observation = controller.first_observation()
    command, _ = controller.step(controller.start(observation), observation)
    still, _ = simulator.step(simulator.start(observation), command)
    turned, _ = simulator.step(
        simulator.start(observation), command.replace(hip_torque=(90.0, 9.0))
    )
    assert turned == still


@pytest.mark.parametrize("name", ["inertia", "max_torque", "max_lean"])
def test_a_trunk_of_nothing_is_refused(name: str) -> None:
    good = {"inertia": 4.4, "max_torque": 100.0, "max_lean": 0.5}
    with pytest.raises(sf.RobotError, match=f"`{name}` of the trunk to be positive and finite"):
        Trunk(**(good | {name: 0.0}))


def test_a_wrong_key_of_the_trunk_is_named(tmp_path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text(preset_text("paper-biped").replace("max_lean", "max_leen"))
    with pytest.raises(sf.RobotError, match=r"did you mean `trunk.max_lean`"):
        sf.load_robot(path)

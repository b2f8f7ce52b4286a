"""The estimator: each part does what its equation says, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
HYBRID = sf.HybridController(ROBOT, (0.5, 0.0))
TRACKING = sf.DcmTracking(ROBOT, (0.5, 0.0))
OMEGA, PERIOD = ROBOT.omega, 0.001


def away(walk: sf.Rollout, name: str = "dcm") -> np.ndarray:
    """What the controller was told, less the truth."""
    return walk.seen[name] - walk.observations[name]


def errors(estimator: sf.Estimator, measured_off: np.ndarray) -> np.ndarray:
    """Errors of the DCM's estimate, shape (n, 2), in a walk that nothing disturbs but this [m].

    The estimator does not act on the walk.
    """
    walk, memory, found = sf.simulate(TRACKING, 2.0), estimator.start(), []
    for k in range(len(walk.time)):
        truth = sf.Observation.of(walk.observations[k : k + 1])
        seen = truth.replace(com=truth.com + measured_off[k], dcm=truth.dcm + measured_off[k])
        before = sf.Command.of(walk.commands[max(k - 1, 0) : max(k - 1, 0) + 1])
        estimate, memory = estimator.step(memory, seen, before)
        found.append(estimate.dcm - truth.dcm)
    return np.array(found)


@pytest.mark.parametrize("cycles", [1, 5, 20, 127])
def test_a_predicted_delay_is_none(cycles: int) -> None:
    delay = cycles * PERIOD
    walk = sf.simulate(
        TRACKING, 2.0, disturbance=sf.Disturbance(delay=delay),
        estimator=sf.Estimator(ROBOT, delay=delay),
    )  # fmt: skip
    for name in ("com", "com_velocity", "dcm"):
        assert np.abs(away(walk, name)).max() < 1e-12, name
    assert len(walk.footsteps) == 4


def test_a_push_is_predicted_once_it_is_measured() -> None:
    """The error is what the push did within the delay, and gone a delay after it."""
    push = sf.Push(0.6, 0.1, (100.0, 0.0))
    walk = sf.simulate(
        TRACKING, 1.0, [push], disturbance=sf.Disturbance(delay=0.02),
        estimator=sf.Estimator(ROBOT, delay=0.02),
    )  # fmt: skip
    error, time = np.abs(away(walk)[:, 0]), walk.time
    assert error[(time < 0.6) | (time > 0.7 + 0.021)].max() < 1e-12
    expected = 100.0 / (70.0 * OMEGA**2) * (math.exp(OMEGA * 0.02) - 1.0)
    assert error.max() == pytest.approx(expected, rel=1e-6)


def test_a_torque_on_the_trunk_is_predicted() -> None:
    robot = sf.load_robot("paper-biped")
    assert robot.trunk is not None
    simulator, estimator = sf.LipmSimulator(robot), sf.Estimator(robot, delay=0.01)
    controller = sf.DcmTracking(robot, (0.5, 0.0))
    observation = controller.first_observation()
    command, _ = controller.step(controller.start(observation), observation)
    command = command.replace(hip_torque=(50.0, -30.0))
    world, memory, past = simulator.start(observation), estimator.start(), [observation]
    for _ in range(40):
        late = observation.replace(
            com=past[max(len(past) - 11, 0)].com,
            com_velocity=past[max(len(past) - 11, 0)].com_velocity,
        )
        estimate, memory = estimator.step(memory, late, command)
        assert estimate.dcm == pytest.approx(observation.dcm, abs=1e-12)
        observation, world = simulator.step(world, command)
        past.append(observation)
    assert observation.trunk_lean[0] > 0.0


@pytest.mark.parametrize("filter_time", [0.01, 0.05, 0.4])
def test_an_error_of_the_filter_decays_with_its_time(filter_time: float) -> None:
    first = np.zeros((3000, 2))
    first[0] = (0.02, -0.01)
    found = errors(sf.Estimator(ROBOT, filter_time=filter_time), first)
    time = sf.simulate(TRACKING, 2.0).time
    expected = np.outer(np.exp(-time / filter_time), (0.02, -0.01))
    assert found == pytest.approx(expected, abs=1e-9)


def test_a_filter_takes_out_noise_and_sees_a_push_late() -> None:
    noise = sf.Disturbance(dcm_noise=0.005)
    spread = [
        away(sf.simulate(TRACKING, 6.0, disturbance=noise, estimator=estimator))[200:].std()
        for estimator in (None, sf.Estimator(ROBOT, filter_time=0.02))
    ]
    assert spread[0] == pytest.approx(0.005, rel=0.03)
    z = math.exp(-PERIOD / 0.02)
    gain = 1.0 - z / math.exp(OMEGA * PERIOD)
    assert spread[1] == pytest.approx(0.005 * gain / math.sqrt(1.0 - z * z), rel=0.1)
    push = [sf.Push(0.6, 0.1, (100.0, 0.0))]
    walk = sf.simulate(TRACKING, 0.8, push, estimator=sf.Estimator(ROBOT, filter_time=0.02))
    steady = 0.02 * 100.0 / (70.0 * OMEGA)
    assert -away(walk)[:, 0].min() == pytest.approx(steady, rel=0.06)


@pytest.mark.parametrize("bias_time", [0.2, 0.3, 0.6])
def test_the_observer_of_the_offset_has_a_double_pole(bias_time: float) -> None:
    """error(k+2) = 2 z error(k+1) - z^2 error(k), with z = e^(-dt / bias_time)."""
    off = np.tile([0.008, -0.004], (3000, 1))
    error = errors(sf.Estimator(ROBOT, bias_time=bias_time), off)
    z = math.exp(-PERIOD / bias_time)
    inside = slice(3, 480)  # one step: cycles that a touchdown cuts have another z
    now, later, latest = error[inside], error[4:481], error[5:482]
    assert latest == pytest.approx(2.0 * z * later - z * z * now, abs=1e-12)
    assert error[0] == pytest.approx(off[0])
    # The wrong way first, then right, within the time that is promised.
    assert np.abs(error).max() > 0.008
    after = round(5.0 * bias_time / PERIOD)
    if after < len(error):
        assert np.abs(error[after:]).max() < 0.1 * 0.008 + 1e-9


def test_an_offset_is_found_in_closed_loop() -> None:
    off = sf.Disturbance(com_offset=(0.02, -0.015))
    walk = sf.simulate(HYBRID, 6.0, disturbance=off, estimator=sf.Estimator(ROBOT, bias_time=0.3))
    assert np.abs(away(walk)[-1000:]).max() < 1e-4
    assert walk.outcome is sf.Outcome.WALKED
    assert sf.simulate(HYBRID, 6.0, disturbance=off).outcome is sf.Outcome.UNSETTLED


def test_a_constant_force_looks_like_an_offset() -> None:
    """b = -F / (m omega^2), and no observer can tell."""
    force = [sf.Push(0.0, math.inf, (8.0, 0.0))]
    walk = sf.simulate(TRACKING, 5.0, force, estimator=sf.Estimator(ROBOT, bias_time=0.3))
    assert away(walk)[-1, 0] == pytest.approx(8.0 / (70.0 * OMEGA**2), rel=1e-3)


def test_a_push_is_not_taken_for_an_offset() -> None:
    walk = sf.simulate(
        HYBRID, 4.0, [sf.Push(1.1, 0.2, (400.0, 0.0))],
        estimator=sf.Estimator(ROBOT, bias_time=0.3),
    )  # fmt: skip
    assert walk.outcome is sf.Outcome.RECOVERED
    assert 1e-5 < np.abs(away(walk)).max() < 0.001


def test_a_step_is_a_value_and_no_number_teaches_nothing() -> None:
    estimator = sf.Estimator(ROBOT, delay=0.002, filter_time=0.01, bias_time=0.3)
    observation = TRACKING.first_observation()
    command, _ = TRACKING.step(TRACKING.start(observation), observation)
    start = estimator.start()
    _, memory = estimator.step(start, observation, command)
    assert start.tobytes() == estimator.start().tobytes()
    kept = memory.tobytes()
    broken = observation.replace(time=0.001, com=(math.nan, 0.0))
    told, after = estimator.step(memory, broken, command)
    assert told.array.tobytes() == broken.array.tobytes()
    assert after.tobytes() == kept == memory.tobytes()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"delay": 0.0004}, r"whole number of periods of 0\.001 s, below 128; .* example 0\.001"),
        ({"delay": 0.5}, r"below 128; got 0\.5 s; write for example 0\.127"),
        ({"delay": -0.001}, r"`delay` of at least 0 \[s\]"),
        ({"filter_time": math.nan}, r"`filter_time` of at least 0 \[s\]"),
        ({"bias_time": math.inf}, r"`bias_time` of at least 0 \[s\] and finite"),
        ({"bias_limit": 0.0}, r"`bias_limit` above 0 \[m\]"),
        ({"period": 0.0}, r"`period` above 0 \[s\]"),
    ],
)
def test_what_is_no_estimator(wrong: dict, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        sf.Estimator(ROBOT, **wrong)


def test_an_estimator_of_another_period_is_refused() -> None:
    with pytest.raises(sf.ParameterError, match=r"controller's period, 0\.001 s; got 0\.002 s"):
        sf.simulate(HYBRID, 1.0, estimator=sf.Estimator(ROBOT, period=0.002))

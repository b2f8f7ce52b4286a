"""What disturbs a walk: it is what it says, and the same in every loop."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from conftest import InPython
from surefoot.rollout.disturbance import mixed, noise_key, normal_pair, uniform
from surefoot.worlds.point.batch import simulate_batch

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
HYBRID = sf.HybridController(ROBOT, (0.5, 0.0))
TRACKING = sf.DcmTracking(ROBOT, (0.5, 0.0))
PUSH = sf.Push(1.1, 0.2, (176.0, 20.0))
EVERYTHING = sf.Disturbance(
    dcm_noise=0.002, velocity_noise=0.01, delay=0.004, com_offset=(0.003, -0.002),
    landing_error=0.004, touchdown_shift=-0.01, seed=7,
)  # fmt: skip
KINDS = {
    "noise": sf.Disturbance(dcm_noise=0.005, velocity_noise=0.03, seed=3),
    "delay": sf.Disturbance(delay=0.02),
    "late": sf.Disturbance(touchdown_shift=0.03, landing_error=0.01),
    "everything": EVERYTHING,
}
HELP = sf.Estimator(ROBOT, delay=0.004, filter_time=0.01, bias_time=0.3)


def test_the_hash_is_splitmix64() -> None:
    """The first outputs of splitmix64.c by Sebastiano Vigna, from the state 0."""
    expected = [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]
    states = [np.uint64(n * 0x9E3779B97F4A7C15 % 2**64) for n in range(3)]
    assert [int(mixed(state)) for state in states] == expected


def key(seed: int, steps: int, cycle: int) -> np.uint64:
    return np.uint64(noise_key(seed, steps, cycle))


def draws(seed: int, count: int, channel: int = 0) -> np.ndarray:
    """Shape (count, 2), over cycles of many steps."""
    pairs = [normal_pair(key(seed, n // 500, n % 500), channel) for n in range(count)]
    return np.array(pairs)


def test_the_noise_is_normal_white_and_independent() -> None:
    count = 40_000
    first, second, other = draws(0, count), draws(0, count, 1), draws(1, count)
    series = np.column_stack([first, second, other])
    sigma = 1.0 / math.sqrt(count)  # of the mean, and of a correlation
    assert np.abs(series.mean(axis=0)).max() < 4.5 * sigma
    assert np.abs(series.var(axis=0) - 1.0).max() < 4.5 * math.sqrt(2.0) * sigma
    assert np.abs((series**4).mean(axis=0) - 3.0).max() < 4.5 * math.sqrt(96.0) * sigma
    across = np.corrcoef(series.T) - np.eye(6)
    assert np.abs(across).max() < 4.5 * sigma
    for lag in (1, 2, 500):
        lagged = (series[lag:] * series[:-lag]).mean(axis=0)
        assert np.abs(lagged).max() < 4.5 * sigma
    flat = np.array([uniform(key(0, 0, n), 5) for n in range(count)])
    counts = np.histogram(flat, 64, (0.0, 1.0))[0]
    chi_squared = ((counts - count / 64) ** 2 / (count / 64)).sum()
    assert chi_squared < 63.0 + 4.5 * math.sqrt(126.0)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("helped", [False, True])
def test_all_loops_walk_alike_to_the_bit(kind: str, helped: bool) -> None:
    how = {"disturbance": KINDS[kind], "estimator": HELP if helped else None}
    walk = sf.simulate(HYBRID, 2.5, [PUSH], **how)
    for controller in (HYBRID, InPython(HYBRID)):
        pushes = [[replace(PUSH, force=(0.0, 0.0))], [PUSH], [PUSH]]
        results = simulate_batch(controller, pushes, 2.5, **how)
        assert results["final"][1].tobytes() == walk.observations[-1].tobytes()
        assert results[2].tobytes() == results[1].tobytes()
        assert results["final"][0].tobytes() != results["final"][1].tobytes()
    assert sf.simulate(HYBRID, 2.5, [PUSH], **how) is not walk
    assert sf.simulate(HYBRID, 2.5, [PUSH], **how).seen.tobytes() == walk.seen.tobytes()


def test_threads_change_nothing_and_seeds_do() -> None:
    pushes = [[sf.Push(1.1, 0.2, (force, 0.0))] for force in np.linspace(-300.0, 300.0, 11)]
    how = {"disturbance": EVERYTHING}
    one = simulate_batch(HYBRID, pushes, 2.0, workers=1, **how)
    assert simulate_batch(HYBRID, pushes, 2.0, workers=3, **how).tobytes() == one.tobytes()
    how["disturbance"] = replace(EVERYTHING, seed=8)
    assert simulate_batch(HYBRID, pushes, 2.0, **how).tobytes() != one.tobytes()


def test_nothing_wrong_is_the_truth_to_the_bit() -> None:
    plain = sf.simulate(HYBRID, 2.0, [PUSH])
    for how in ({"disturbance": sf.Disturbance()}, {"estimator": sf.Estimator(ROBOT)}):
        walk = sf.simulate(HYBRID, 2.0, [PUSH], **how)
        assert walk.observations.tobytes() == plain.observations.tobytes()
        assert walk.seen is walk.observations


def test_noise_is_as_large_as_it_says_and_the_rest_is_true() -> None:
    walk = sf.simulate(TRACKING, 4.0, disturbance=KINDS["noise"])
    away = {
        name: walk.seen[name] - walk.observations[name] for name in ("com", "com_velocity", "dcm")
    }
    assert away["com"].std() == pytest.approx(0.005, rel=0.03)
    assert away["com_velocity"].std() == pytest.approx(0.03, rel=0.03)
    alike = away["com"] + away["com_velocity"] / ROBOT.omega
    assert away["dcm"] == pytest.approx(alike, abs=1e-12)
    # Between these two there is nothing in common.
    assert abs(np.corrcoef(away["com"].ravel(), away["com_velocity"].ravel())[0, 1]) < 0.05
    for name in set(walk.seen.dtype.names) - {"com", "com_velocity", "dcm"}:
        assert (walk.seen[name] == walk.observations[name]).all(), name


def test_a_delay_is_so_many_cycles_of_the_pendulum_only() -> None:
    walk = sf.simulate(TRACKING, 2.0, disturbance=sf.Disturbance(delay=0.005))
    for name in ("com", "com_velocity"):
        assert (walk.seen[name][5:] == walk.observations[name][:-5]).all()
        assert (walk.seen[name][:6] == walk.observations[name][0]).all()
    assert (walk.seen["support_side"] == walk.observations["support_side"]).all()
    assert (walk.seen["time"] == walk.observations["time"]).all()


def test_an_offset_is_one_of_com_and_dcm() -> None:
    walk = sf.simulate(TRACKING, 1.0, disturbance=sf.Disturbance(com_offset=(0.02, -0.01)))
    for name in ("com", "dcm"):
        away = walk.seen[name] - walk.observations[name]
        assert away == pytest.approx(np.tile([0.02, -0.01], (len(away), 1)), abs=1e-12)
    assert (walk.seen["com_velocity"] == walk.observations["com_velocity"]).all()


def test_a_mirrored_disturbance_mirrors_the_walk() -> None:
    walks = [
        sf.simulate(
            HYBRID, 3.0, [sf.Push(1.1, 0.2, (100.0, 80.0 * y))], first_support=sf.Side(side),
            disturbance=sf.Disturbance(com_offset=(0.01, 0.015 * y), touchdown_shift=0.02),
        )
        for side, y in ((1, 1.0), (-1, -1.0))
    ]  # fmt: skip
    right, left = (walk.com for walk in walks)
    assert left * [1.0, -1.0] == pytest.approx(right, abs=1e-9)


def test_every_foot_lands_this_far_off_and_elsewhere() -> None:
    walk = sf.simulate(TRACKING, 4.0, disturbance=sf.Disturbance(landing_error=0.01))
    touchdowns = np.flatnonzero(np.diff(walk.support_side)) + 1
    off = walk.support_foot[touchdowns] - walk.commands["swing_foot"][touchdowns - 1, :2]
    assert np.hypot(*off.T) == pytest.approx(np.full(len(off), 0.01), abs=1e-9)
    angles = np.arctan2(off[:, 1], off[:, 0])
    assert len(set(np.round(angles, 6))) == len(angles) == 8
    assert not walk.fallen


@pytest.mark.parametrize("shift", [-0.03, -0.0155, 0.0155, 0.03])
def test_the_ground_comes_early_or_late(shift: float) -> None:
    walk = sf.simulate(TRACKING, 3.2, disturbance=sf.Disturbance(touchdown_shift=shift))
    nominal = TRACKING.gait.step_duration
    first = walk.footsteps[0]
    assert first.duration == pytest.approx(nominal + shift, abs=1e-9)
    assert len(walk.footsteps) >= 5
    foot = walk.swing_foot[walk.time < first.duration]
    elapsed = walk.time[walk.time < first.duration]
    if shift < 0.0:
        assert first.landing[0] < 0.25  # it stands where it was on its way
        assert first.landing[0] == pytest.approx(0.25, abs=0.005)
    else:
        waiting = foot[elapsed >= nominal + 0.0011]
        assert len(waiting) > 10
        assert (waiting == waiting[0]).all()
        assert first.landing == pytest.approx(tuple(waiting[0][:2]))


def test_a_late_ground_is_not_put_off_by_a_new_plan() -> None:
    """Controllers command "now" again and again once the step is over."""
    walk = sf.simulate(HYBRID, 4.0, [PUSH], disturbance=sf.Disturbance(touchdown_shift=0.03))
    assert max(step.duration for step in walk.footsteps) <= ROBOT.gait.step_duration[1] + 0.0311


def test_a_wrong_height_makes_a_wrong_dcm() -> None:
    plant = ROBOT.replace(com_height=0.9 * ROBOT.com_height)
    walk = sf.simulate(HYBRID, 2.0, [PUSH], plant=plant)
    for records, omega in ((walk.observations, plant.omega), (walk.seen, ROBOT.omega)):
        made = records["com"] + records["com_velocity"] / omega
        assert records["dcm"] == pytest.approx(made, abs=1e-12)
    (result,) = simulate_batch(HYBRID, [[PUSH]], 2.0, plant=plant)
    assert result["final"].tobytes() == walk.observations[-1].tobytes()


def test_a_heavier_plant_takes_a_push_of_as_much_more() -> None:
    """Mass enters the pendulum through the push alone."""
    scan = {"direction": (1.0, 0.0), "must_settle": False, "largest": 400.0}
    heavy = sf.smallest_failing_push(
        HYBRID, **scan, step=1.1, plant=ROBOT.replace(mass=1.1 * ROBOT.mass)
    )
    own = sf.smallest_failing_push(HYBRID, **scan, step=1.0)
    assert heavy.impulse == pytest.approx(1.1 * own.impulse)
    assert heavy.delta_v == pytest.approx(own.delta_v)


def test_under_an_offset_nobody_settles_and_some_walk_on() -> None:
    off = {"disturbance": sf.Disturbance(com_offset=(0.02, 0.0)), "step": 10.0}
    strict = sf.smallest_failing_push(HYBRID, (1.0, 0.0), **off)
    assert (strict.impulse, strict.fell) == (0.0, False)
    walks_on = sf.smallest_failing_push(HYBRID, (1.0, 0.0), **off, must_settle=False)
    assert walks_on.impulse > 100.0
    assert walks_on.fell


def test_a_file_of_a_version_without_disturbances_is_read(tmp_path: Path) -> None:
    walk = sf.simulate(HYBRID, 1.5, [PUSH])
    walk.save(tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as archive:
        arrays = {name: archive[name] for name in archive}
    about = json.loads(str(arrays["about"]))
    assert about["format"] == 1  # older versions can read it, too
    del about["disturbance"], about["estimator"]
    assert set(arrays) == {"about", "observations", "commands", "decision_time"}
    arrays["about"] = np.array(json.dumps(about))
    np.savez(tmp_path / "old.npz", **arrays)
    old = sf.load_rollout(tmp_path / "old.npz")
    assert old.seen is old.observations
    assert (old.disturbance, old.estimator) == (None, "")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"dcm_noise": -0.001}, r"`dcm_noise` of at least 0 \[m\]"),
        ({"velocity_noise": math.nan}, r"`velocity_noise` of at least 0 \[m/s\]"),
        ({"delay": math.inf}, r"`delay` of at least 0 \[s\] and finite; got inf"),
        ({"com_offset": 0.02}, r"`com_offset` as a pair \(x, y\) \[m\]; got 0.02"),
        ({"landing_error": "1 cm"}, r"`landing_error` .*; got '1 cm'"),
        ({"touchdown_shift": math.inf}, r"`touchdown_shift` .*finite"),
        ({"seed": -1}, r"`seed` as a whole number from 0 .*; got -1"),
        ({"seed": 0.5}, r"`seed` as a whole number"),
    ],
)
def test_what_is_no_disturbance(wrong: dict, message: str) -> None:
    with pytest.raises(sf.ParameterError, match=message):
        sf.Disturbance(**wrong)


@pytest.mark.parametrize("delay", [0.0005, 0.2])
def test_a_delay_that_is_no_number_of_cycles(delay: float) -> None:
    with pytest.raises(sf.ParameterError, match=r"whole number of periods of 0\.001 s, below 128"):
        sf.simulate(HYBRID, 1.0, disturbance=sf.Disturbance(delay=delay))

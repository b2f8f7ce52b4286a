"""Dumps of the last states of a walk: written at a fall or a NaN, and walked again to the bit."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import surefoot as sf
from surefoot.cli import main
from surefoot.rollout.dump import load_dump
from surefoot.worlds.body.world import replay_body
from surefoot.worlds.point.simulate import replay

PUSH = sf.Push(2.1, 0.2, (1500.0, 100.0))
NOISE = sf.Disturbance(dcm_noise=0.002, delay=0.004, landing_error=0.005, seed=7)


@pytest.fixture(scope="module")
def controller(robot: sf.Robot) -> sf.UnifiedController:
    return sf.UnifiedController(robot, (0.5, 0.0))


def assert_is_the_end_of(part: sf.Rollout, whole: sf.Rollout) -> None:
    rows = slice(-len(part.time), None)
    for name in ("observations", "commands", "seen"):
        assert getattr(part, name).tobytes() == getattr(whole, name)[rows].tobytes()


@pytest.mark.parametrize("disturbance", [None, NOISE], ids=["undisturbed", "disturbed"])
def test_a_fall_is_walked_again_to_the_bit(
    controller: sf.UnifiedController, disturbance: sf.Disturbance | None, tmp_path: Path
) -> None:
    path = tmp_path / "fall.npz"
    changes = [(0.7, (0.3, 0.0)), (2.2, (0.4, 0.0))]
    whole = sf.simulate(
        controller, 6.0, [PUSH], velocity_changes=changes, disturbance=disturbance, dump=path
    )
    assert whole.fallen
    dump = load_dump(path)
    assert_is_the_end_of(dump.rollout, whole)
    assert dump.rollout.velocities[0] == (dump.rollout.time[0], (0.3, 0.0))
    step = controller.gait.step_duration
    assert 1.0 <= (whole.time[-1] - dump.rollout.time[0]) / step < 2.1
    assert path.stat().st_size < 300_000
    assert replay(dump, controller) == dump.rollout
    # It is a rollout too.
    assert sf.load_rollout(path) == dump.rollout
    assert dump.rollout.outcome is sf.Outcome.FELL


def test_an_estimator_is_walked_again(robot: sf.Robot, tmp_path: Path) -> None:
    controller, path = sf.HybridController(robot, (0.4, 0.0)), tmp_path / "fall.npz"
    estimator = sf.Estimator(robot, delay=0.004)
    sf.simulate(controller, 6.0, [PUSH], disturbance=NOISE, estimator=estimator, dump=path)
    dump = load_dump(path)
    assert replay(dump, controller, estimator) == dump.rollout
    with pytest.raises(sf.ParameterError, match="decides otherwise"):
        replay(dump, controller)


def test_a_walk_that_stays_up_leaves_no_dump(
    controller: sf.UnifiedController, tmp_path: Path
) -> None:
    path = tmp_path / "walk.npz"
    walk = sf.simulate(controller, 1.0, dump=path)
    assert not path.exists()
    assert walk == sf.simulate(controller, 1.0)


def test_the_walk_ends_at_the_first_nan(
    controller: sf.UnifiedController, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    step = sf.UnifiedController.step

    def poisoned(self: Any, state: Any, observation: sf.Observation) -> tuple[sf.Command, Any]:
        command, state = step(self, state, observation)
        if observation.time > 1.2:
            command = command.replace(dcm_offset=(math.nan, 0.0))
        return command, state

    monkeypatch.setattr(sf.UnifiedController, "step", poisoned)
    path = tmp_path / "nan.npz"
    walk = sf.simulate(controller, 3.0, dump=path)
    bad = np.flatnonzero(np.isnan(walk.commands["dcm_offset"][:, 0]))
    assert bad[0] == len(walk.time) - 2
    assert not walk.fallen
    dump = load_dump(path)
    assert_is_the_end_of(dump.rollout, walk)
    assert replay(dump, controller) == dump.rollout


def test_another_controller_is_refused(controller: sf.UnifiedController, tmp_path: Path) -> None:
    path = tmp_path / "fall.npz"
    sf.simulate(controller, 6.0, [PUSH], dump=path)
    with pytest.raises(sf.ParameterError, match="make it with the same robot, parameters"):
        replay(load_dump(path), replace(controller, dcm_gain=5.0))
    with pytest.raises(sf.ParameterError, match=r"got.*HybridController"):
        replay(load_dump(path), sf.HybridController(controller.robot, (0.5, 0.0)))


def test_a_file_that_is_no_dump_says_so(controller: sf.UnifiedController, tmp_path: Path) -> None:
    path = tmp_path / "walk.npz"
    sf.simulate(controller, 0.2).save(path)
    with pytest.raises(sf.FileError, match="read a rollout with load_rollout"):
        load_dump(path)
    with pytest.raises(sf.FileError, match=r"ending in \.npz"):
        sf.simulate(controller, 0.2, dump=tmp_path / "walk.mcap")


def test_the_command_line_dumps_a_fall(tmp_path: Path, robot: sf.Robot) -> None:
    path = tmp_path / "fall.npz"
    push = "1500,100@1.1+0.2"
    done = CliRunner().invoke(main, ["walk", "--push", push, "--dump", str(path)])
    assert done.exit_code == 1
    dump = load_dump(path)
    assert replay(dump, sf.UnifiedController(robot, (0.5, 0.0))) == dump.rollout


def test_the_command_line_dumps_the_fall_of_a_body(
    body_control: sf.BodyControl, tmp_path: Path
) -> None:
    path = tmp_path / "fall.npz"
    wanted = ["walk", "--simulator", "mujoco", "--truth", "--push", "1500,0@0.5+0.2"]
    done = CliRunner().invoke(main, [*wanted, "--duration", "3", "--dump", str(path)])
    assert done.exit_code == 1
    dump = load_dump(path)
    again = replay_body(dump, body_control.fresh(), noise=None, estimator="truth")
    assert again == dump.rollout


def test_a_body_that_cannot_be_dumped_is_refused(
    body_control: sf.BodyControl, tmp_path: Path
) -> None:
    class Silent:
        def start(self) -> None: ...

        def step(self, memory: None, readings: Any) -> tuple[Any, None]:
            return readings, memory

    with pytest.raises(sf.ParameterError, match="a BodyNoise, to be dumped"):
        sf.simulate_body(body_control, 1.0, noise=Silent(), dump=tmp_path / "fall.npz")


@pytest.mark.parametrize("noisy", [True, False], ids=["estimate", "truth"])
def test_the_fall_of_a_body_is_walked_again_to_the_bit(
    body_control: sf.BodyControl, noisy: bool, tmp_path: Path
) -> None:
    path, push = tmp_path / "fall.npz", sf.Push(2.6, 0.2, (900.0, 60.0))
    sensors: dict[str, Any] = {"noise": None, "estimator": "truth"}
    if noisy:
        sensors = {"noise": sf.BodyNoise(delay=0.002, seed=3)}
    route = [(0.0, sf.Steering((0.3, 0.0), turning=0.1)), (2.5, sf.Steering((0.2, 0.0)))]
    whole = sf.simulate_body(body_control, 6.0, [push], steering=route, dump=path, **sensors)
    assert whole.fallen
    dump = load_dump(path)
    assert dump.rollout.time[-1] == pytest.approx(whole.time[-1], abs=0.01)
    assert dump.rollout.fallen
    assert dump.rollout.body_fall is not None
    again = replay_body(dump, body_control.fresh(), **sensors)
    assert again == dump.rollout
    assert np.abs(again.com[-1] - whole.com[-1]).max() < 0.01
    with pytest.raises(sf.ParameterError, match="decides otherwise"):
        replay_body(dump, replace(body_control, knee_bend=0.4), **sensors)

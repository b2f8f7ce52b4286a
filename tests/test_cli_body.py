"""`surefoot walk --simulator mujoco`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import surefoot as sf
from invoked import numbers, refused, run
from surefoot.cli.walk import OF_BODY, OF_POINT_MASS, walk
from surefoot.show.words import title
from surefoot.worlds.body import world as body_world

PHYSICS = ("walk", "--simulator", "mujoco")


def told(*arguments: str) -> dict:
    return numbers(*PHYSICS, *arguments)


def test_it_tells_what_happened() -> None:
    result = run(*PHYSICS, "--duration", "3")
    assert result.exit_code == 0
    words = " ".join(result.output.split())
    assert "paper-biped (68 kg) in physics with UnifiedController" in words
    assert "given an estimate from its sensors" in words
    assert "from 0 s: walk at (0.3, 0) m/s" in words
    for name in ("steps", "knees", "clearance", "largest torques", "estimate off by"):
        assert name in words
    assert "walked for 3 s" in words


def test_json_has_what_the_point_mass_has_and_the_body() -> None:
    point = numbers("walk", "--duration", "2")
    physics = told("--duration", "5.5", "--truth", "--push", "10,0@2.5+0.1")
    assert set(point) < set(physics)
    assert physics["outcome"] == "recovered"
    assert physics["fall"] is None
    body = physics["body"]
    assert body["senses"] == "truth"
    for name in (
        "speed_held", "lateral_drift", "heading_error", "torque_part", "knees", "clearance",
        "estimate", "cycle_time", "real_time_factor", "fall_cause",
    ):  # fmt: skip
        assert name in body
    assert body["fall_cause"] is None
    assert body["commanded"] == [0.3, 0.0]
    assert body["estimate"] == {}
    assert 0.0 < body["cycle_time"]["p50"] <= body["cycle_time"]["p99"]
    assert body["real_time_factor"] > 0.0
    for step in physics["steps"]:
        assert 0.1 < step["duration"] < 1.0


def test_a_fall_exits_with_1_and_names_its_cause() -> None:
    arguments = ("--duration", "4", "--truth", "--push", "0,1500@1.5+0.1")
    result = run(*PHYSICS, *arguments)
    assert result.exit_code == 1
    physics = told(*arguments)
    cause = physics["body"]["fall_cause"]
    assert cause in {one.value for one in sf.FallCause}
    assert f"fell: {cause} at" in result.output
    assert physics["body"]["fall"]["end"] == pytest.approx(physics["duration"] + 0.001)


def test_commands_change_on_the_way(tmp_path: Path) -> None:
    path = tmp_path / "walk.npz"
    result = run(
        *PHYSICS, "--truth", "--velocity", "0.2", "0", "--turning", "0.2", "--then", "0.1,0@2",
        "--stand-at", "3", "--duration", "5", "--friction", "0.7", "--payload", "2",
        "--leg-speed", "3.5", "--save", str(path),
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    rollout = sf.load_rollout(path)
    assert rollout.body is not None
    assert rollout.body.steering == (
        (0.0, (0.2, 0.0), 0.2, False),
        (2.0, (0.1, 0.0), 0.2, False),
        (3.0, (0.0, 0.0), 0.0, True),
    )
    assert rollout.body.surroundings == (
        "Surroundings(friction=0.7, payload=2.0, mass_factor=1.0, bumps=0.0, seed=0)"
    )
    assert rollout.body.believed.swing.max_speed == 3.5
    assert not rollout.body.walking[-1]
    assert title(rollout)[0] == "paper-biped, 2 commanded velocities, then stand"


def test_another_method_and_a_picture(tmp_path: Path) -> None:
    path = tmp_path / "walk.png"
    result = run(
        *PHYSICS, "--truth", "--controller", "hybrid", "--duration", "2", "--plot", str(path)
    )
    assert result.exit_code == 0, result.output
    assert "HybridController" in result.output
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_film(tmp_path: Path) -> None:
    path = tmp_path / "walk.gif"
    result = run(*PHYSICS, "--truth", "--duration", "0.3", "--video", str(path))
    if "OpenGL" in result.output:
        pytest.skip(result.output)
    assert result.exit_code == 0, result.output
    assert path.read_bytes().startswith(b"GIF89a")


def test_a_push_is_over_the_mass_that_it_moves() -> None:
    asked = ("--truth", "--duration", "0.5", "--push", "100,0@0.1+0.1", "--payload", "12")
    (push,) = told(*asked, "--mass-error", "0.25")["pushes"]
    assert push["delta_v"][0] == pytest.approx(10.0 / (1.25 * 68.0 + 12.0))
    assert "10 N s, 0.125 m/s" in run(*PHYSICS, *asked).output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--bumps", "-0.01"], "`bumps` of at least 0 [m]"),
        (["--mass-error", "-1"], "`mass_error` above -1 [-]"),
        (["--mapping", "none"], "a mapping (inverse-dynamics, balance-force, com-jacobian)"),
        (["--delay", "0.0005"], "whole number of periods"),
        (["--delay", "0.005", "--truth"], "--delay without --truth"),
        (["--seed", "-1"], "`seed` as a whole number"),
        (["--seed", "1", "--truth"], "--seed where something is drawn"),
        (["--bumps", "0.031"], "`bumps` of at most 0.03 [m]: a foot that touches so"),
        (["--bumps", "0.01"], "with bumps, a course on the boards"),
        (["--payload", "68.1"], "`payload` of at most 68 [kg]"),
        (["--turning", "-2.6"], "`turning` of at most 2.5 [rad/s]: in faster turns"),
        (["--robot", "paper-table2"], "a robot with a [body] table"),
        (["--friction", "0"], "`friction` above 0 [-]"),
        (["--payload", "-1"], "`payload` of at least 0 [kg]"),
        (["--controller", "ankle-hip-step-mpc"], "leaves the trunk upright"),
        (["--stand-at", "-1"], "--stand-at at 0 s or later"),
        (["--turning", "nan"], "`turning` [rad/s], finite"),
        (["--velocity", "9", "0"], "expected at most"),
        (["--then", "9,0@1"], "expected at most"),
        (["--then", "0.1,0@2", "--then", "0.1,0@1"], "--then in order of time"),
        (["--then", "0.1,0@2", "--stand-at", "1"], "--stand-at after every --then"),
        (["--duration", "0"], "`duration` above 0 [s]"),
        (["--video", "walk.avi"], "a path ending in .mp4, .gif"),
        (["--video", "no/such/walk.mp4"], "a directory that exists"),
        (["--save", "walk.xyz"], "a path ending in .npz"),
    ],
)
def test_misuse_exits_with_2_and_says_what_to_do(arguments: list[str], message: str) -> None:
    if "--duration" not in arguments:
        # Had the walk begun before the mistake was told, this would not end.
        arguments = [*arguments, "--duration", "1e6"]
    assert message in refused(*PHYSICS, *arguments)


@pytest.mark.parametrize(
    ("simulator", "other", "name"),
    [*(("lipm", "mujoco", name) for name in OF_BODY),
     *(("mujoco", "lipm", name) for name in OF_POINT_MASS)],
)  # fmt: skip
def test_an_option_of_the_other_world_is_named(simulator: str, other: str, name: str) -> None:
    (option,) = [one for one in walk.params if one.name == name]
    given = [option.opts[0], *([] if getattr(option, "is_flag", False) else ["1"])]
    said = refused("walk", "--simulator", simulator, *given)
    assert f"expected {given[0]} with --simulator {other}; got --simulator {simulator}" in said


@pytest.mark.parametrize(
    ("module", "option", "extra"),
    [
        ("mujoco", [], "mujoco"),
        ("daqp", [], "mujoco"),
        ("imageio_ffmpeg", ["--video", "a.mp4"], "video"),
        ("PIL", ["--video", "a.mp4"], "video"),
        ("matplotlib", ["--plot", "a.png"], "plot"),
    ],
)
def test_a_missing_extra_is_named(
    module: str, option: list[str], extra: str, tmp_path: Path
) -> None:
    code = (
        f"import sys; sys.modules['{module}'] = None\n"
        f"from surefoot.cli import main; main({[*PHYSICS, *option]!r})"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, env=environment
    )
    assert done.returncode == 2, done.stderr
    assert f'run: pip install "surefoot[{extra}]"' in done.stderr


def test_a_body_that_gets_nowhere_has_not_walked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its steps end on the noise of soles whose filter is told of less."""
    usual = body_world.simulate_body

    def on_noise(control: sf.BodyControl, duration: float, *rest: Any, **others: Any) -> sf.Rollout:
        mechanism = control.multibody
        others["noise"] = sf.BodyNoise(force=0.1 * mechanism.mass * mechanism.robot.gravity)
        others["estimator"] = sf.BodyEstimator(mechanism)
        return usual(control, duration, *rest, **others)

    monkeypatch.setattr(body_world, "simulate_body", on_noise)
    result = run(*PHYSICS, "--duration", "7")
    assert result.exit_code == 1
    words = " ".join(result.output.split())
    assert "unsettled: it steps, but goes at" in words
    assert "where (0.3, 0) was commanded" in words
    assert "walked for" not in words
    result = run(*PHYSICS, "--duration", "7", "--json")
    assert result.exit_code == 1
    summary = json.loads(result.stdout)
    assert summary["outcome"] == "unsettled"
    assert summary["body"]["makes_way"] is False

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import surefoot as sf
from surefoot.cli import main
from surefoot.control.registry import methods
from surefoot.control.settings import (
    Settings,
    checked_settings,
    load_settings,
    settings,
    settings_text,
    with_settings,
)

COMPILED = ("tracking", "tracking-stiff", "step-timing", "hybrid", "unified")


@pytest.fixture(scope="module")
def robot() -> sf.Robot:
    return sf.load_robot("paper-biped")


@pytest.mark.parametrize("one", methods(), ids=lambda one: one.key)
def test_the_defaults_of_every_method_are_settings_of_it(one) -> None:
    defaults = settings(one.key)
    assert not {"robot", "velocity", "gait", "parameters"} & set(defaults)
    assert checked_settings(one.key, defaults) == defaults
    assert {name: defaults[name] for name in one.parameters} == dict(one.parameters)


@pytest.mark.parametrize("key", COMPILED)
def test_with_its_defaults_it_is_the_controller_of_the_method(key: str, robot: sf.Robot) -> None:
    (one,) = [one for one in methods() if one.key == key]
    made = with_settings(key, robot, (0.5, 0.0), settings(key))
    assert made == one.controller(robot, (0.5, 0.0))
    assert np.array_equal(made.parameters, one.controller(robot, (0.5, 0.0)).parameters)
    assert with_settings(key, robot, (0.5, 0.0), {}) == made


def test_a_pair_may_be_a_list_and_a_float_a_whole_number(robot: sf.Robot) -> None:
    made = with_settings("unified", robot, (0.5, 0.0), {"step_weight": [1, 2], "dcm_gain": 4})
    assert made == sf.UnifiedController(robot, (0.5, 0.0), step_weight=(1.0, 2.0), dcm_gain=4.0)
    assert isinstance(made.dcm_gain, float)


def test_none_only_where_the_class_chooses() -> None:
    assert checked_settings("unified", {"step_duration": None}) == {"step_duration": None}
    with pytest.raises(sf.ParameterError, match="`tau_weight` as a number; got None"):
        checked_settings("unified", {"tau_weight": None})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"dcm_gian": 3.0}, "`dcm_gian`; did you mean `dcm_gain`?"),
        ({"xyz": 3.0}, "`xyz`; leave it out"),
        ({"robot": 3.0}, "a parameter of unified"),
        ({"gait": 3.0}, "a parameter of unified"),
        ({"dcm_gain": "3"}, "`dcm_gain` as a number; got '3'"),
        ({"dcm_gain": True}, "`dcm_gain` as a number; got True"),
        ({"dcm_gain": float("nan")}, "`dcm_gain` as a number; got nan"),
        ({"dcm_gain": [1.0, 2.0]}, "`dcm_gain` as a number"),
        ({"ankle": 1}, "`ankle` as true or false; got 1"),
        ({"step_weight": 1.0}, "`step_weight` as a list of 2 numbers; got 1.0; write [1.0, 1.0]"),
        ({"step_weight": [1.0]}, "`step_weight` as a list of 2 numbers"),
        ({"step_weight": [1.0, float("nan")]}, "`step_weight[1]` as a number; got nan"),
        ({"dcm_gain": -1.0}, "`dcm_gain` above 0 [1/s]"),
    ],
)
def test_a_wrong_setting_is_named(values: dict, words: str, robot: sf.Robot) -> None:
    with pytest.raises(sf.ParameterError) as caught:
        with_settings("unified", robot, (0.5, 0.0), values)
    assert words in str(caught.value)


def test_a_count_takes_whole_numbers_only() -> None:
    assert checked_settings("linear-mpc", {"samples": 60}) == {"samples": 60}
    with pytest.raises(sf.ParameterError, match="`samples` as a whole number; got 60"):
        checked_settings("linear-mpc", {"samples": 60.0})


@pytest.mark.parametrize("one", methods(), ids=lambda one: one.key)
def test_a_file_gives_back_what_was_written(one, tmp_path: Path) -> None:
    values = {name: value for name, value in settings(one.key).items() if value is not None}
    chosen = Settings(one.key, values)
    path = tmp_path / "own.toml"
    path.write_text(settings_text(chosen, ["why", ""]))
    assert load_settings(path) == chosen


def test_an_infinite_threshold_survives_its_file(tmp_path: Path, robot: sf.Robot) -> None:
    path = tmp_path / "own.toml"
    path.write_text(settings_text(Settings("hybrid", {"threshold": float("inf")})))
    assert load_settings(path).make(robot, (0.5, 0.0)) == sf.HybridController(
        robot, (0.5, 0.0), threshold=float("inf")
    )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("controller = ", "a TOML document"),
        ("[parameters]\n", 'write controller = "unified"'),
        ("controller = 3\n", "got 3 in "),
        ('controller = "united"\n', "a method (tracking"),
        ('controller = "unified"\nparameters = 3\n', "`parameters` as a table"),
        ('controler = "unified"\n', "did you mean `controller`?"),
        ('controller = "unified"\ndcm_gain = 3.0\n', "put it below [parameters]"),
        ('controller = "unified"\n[parameters]\ndcm_gain = nan\n', "`dcm_gain` as a number"),
        ('controller = "unified"\n[parameters]\nthreshold = 0.1\n', "a parameter of unified"),
    ],
)
def test_a_wrong_file_says_what_is_wrong(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(text)
    with pytest.raises(sf.SurefootError) as caught:
        load_settings(path)
    assert words in str(caught.value)
    assert "own.toml" in str(caught.value)


def test_a_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(sf.FileError, match="a readable file of settings"):
        load_settings(tmp_path / "none.toml")
    with pytest.raises(sf.FileError, match="a readable file of settings"):
        load_settings(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(sf.FileError, match="a readable file of settings"):
        load_settings(binary)


def walk(*words: str) -> dict:
    result = CliRunner().invoke(main, ["walk", "--push", "176,0@1.1+0.2", "--json", *words])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


@pytest.fixture
def own(tmp_path: Path) -> str:
    path = tmp_path / "own.toml"
    path.write_text('controller = "hybrid"\n[parameters]\nthreshold = 0.3\ndcm_gain = 9.0\n')
    return str(path)


def test_a_walk_with_settings_is_that_of_the_library(own: str, robot: sf.Robot) -> None:
    told = walk("--settings", own)
    assert told["controller"] == "HybridController"
    brain = sf.HybridController(robot, (0.5, 0.0), threshold=0.3, dcm_gain=9.0)
    rollout = sf.simulate(brain, 6.0, [sf.Push(1.1, 0.2, (176.0, 0.0))])
    assert told["largest_dcm_error"] == pytest.approx(float(np.max(rollout.dcm_error)))
    assert told["largest_dcm_error"] != walk("--controller", "hybrid")["largest_dcm_error"]


def test_an_option_goes_over_the_file(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('controller = "hybrid"\n[parameters]\ndouble_support = 0.3\n')
    same = walk("--controller", "hybrid", "--double-support", "0.1")
    told = walk("--settings", str(path), "--double-support", "0.1")
    assert told["steps"] == same["steps"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--controller", "hybrid"], "--settings alone: it names the controller"),
        (["--footholds", "steps.csv"], "--footholds alone"),
        (["--simulator", "mujoco", "--controller", "hybrid"], "--settings alone"),
    ],
)
def test_settings_with_what_contradicts_them(own: str, words: list[str], told: str) -> None:
    result = CliRunner().invoke(main, ["walk", "--settings", own, *words])
    assert result.exit_code == 2
    assert told in result.output


def test_a_body_walks_with_settings(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text('controller = "unified"\n[parameters]\ndcm_gain = -3.0\n')
    result = CliRunner().invoke(main, ["walk", "--simulator", "mujoco", "--settings", str(path)])
    assert result.exit_code == 2
    assert "`dcm_gain` above 0 [1/s]" in result.output

"""Tuning: what is measured, that a search goes on as if it had not been killed, what is taken."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import surefoot as sf
from killed_studies import kill_when_kept, shards
from surefoot.cli import main
from surefoot.control.settings import load_settings, settings, with_settings
from surefoot.studies.engine.parameters import component
from surefoot.studies.engine.pushed_walk import Answer
from surefoot.studies.tune.choice import (
    PREFERENCES,
    Tried,
    choose,
    pareto_front,
    reasons,
    simplest,
)
from surefoot.studies.tune.measure import STEP_WEIGHT, Score, effort_of, score, survived
from surefoot.studies.tune.question import (
    REFUSED,
    Tuning,
    changed_settings,
    chosen_parameters,
    default_settings,
    usual_parameters,
)
from surefoot.studies.tune.search import Tuned, search, tune
from surefoot.studies.tune.show import report, verdict

TRIALS, VELOCITY = 12, (0.5, 0.0)
TUNED = ("unified", "hybrid", "step-timing", "tracking", "tracking-stiff")


@pytest.fixture(scope="module")
def robot() -> sf.Robot:
    return sf.load_robot("paper-biped").with_leg(max_speed=3.0)


@pytest.fixture(scope="module")
def question(robot: sf.Robot) -> Tuning:
    return Tuning(
        robot, method="tracking-stiff", asked=("dcm_gain",), directions=2, phases=1, step=0.1,
        trials=TRIALS, threads=1,
    )  # fmt: skip


@pytest.fixture(scope="module")
def tuned(question: Tuning, tmp_path_factory: pytest.TempPathFactory) -> tuple[Tuned, Path]:
    folder = tmp_path_factory.mktemp("tune")
    return tune(question, folder), folder


# What is searched


@pytest.mark.parametrize("key", TUNED)
def test_every_usual_parameter_has_its_default_in_range(key: str, robot: sf.Robot) -> None:
    defaults = default_settings(key, robot, VELOCITY)
    for one in usual_parameters(key):
        assert one.low <= component(defaults, one.name) <= one.high
        # And the class takes both ends of the range.
        for end in (one.low, one.high):
            values = changed_settings(key, {one.name: end}, defaults)
            with_settings(key, robot, VELOCITY, values)


def test_settings_are_those_that_are_not_as_by_default(robot: sf.Robot) -> None:
    asked = ("offset_weight.x", "offset_weight.y", "dcm_gain")
    chosen = chosen_parameters("hybrid", asked, robot, VELOCITY)
    defaults = default_settings("hybrid", robot, VELOCITY)
    values = {one.name: component(defaults, one.name) for one in chosen}
    assert changed_settings("hybrid", values, defaults) == {}
    given = changed_settings("hybrid", {**values, "offset_weight.y": 7.0}, defaults)
    assert given == {"offset_weight": (settings("hybrid")["offset_weight"][0], 7.0)}
    both = {**values, "offset_weight.x": 5.0, "offset_weight.y": 7.0}
    assert changed_settings("hybrid", both, defaults) == {"offset_weight": (5.0, 7.0)}


def test_a_range_of_ones_own_goes_over_the_usual_one(robot: sf.Robot) -> None:
    usual = {one.name: one for one in usual_parameters("unified")}
    gain, reserve = chosen_parameters("unified", ("dcm_gain=2:4", "reserve"), robot, VELOCITY)
    assert gain == replace(usual["dcm_gain"], low=2.0, high=4.0)
    assert (gain.unit, gain.log, reserve) == ("1/s", True, usual["reserve"])
    (linear,) = chosen_parameters("tracking", ("double_support=0:0.3",), robot, VELOCITY)
    assert not linear.log


@pytest.mark.parametrize(
    ("key", "asked", "words"),
    [
        ("linear-mpc", (), "a compiled method with gains (tracking"),
        ("unified", ("dcm_gian",), "did you mean `dcm_gain`?"),
        ("unified", ("period=0.001:0.01",), "a knob (reserve"),
        ("unified", ("step_duration=0.3:0.6",), "a knob (reserve"),
        ("unified", ("ankle=0:1",), "a knob (reserve"),
        ("tracking", ("double_support",), "write --knob double_support=LOW:HIGH"),
        ("unified", ("dcm_gain=5:10",), "with its default 3 in it"),
        ("unified", ("dcm_gain=5",), "NAME=LOW:HIGH"),
        ("unified", ("dcm_gain=10:1",), "0 <= LOW < HIGH"),
        ("unified", ("dcm_gain=1:nan",), "NAME=LOW:HIGH"),
        ("unified", ("dcm_gain", "dcm_gain=1:9"), "every --knob once"),
    ],
)
def test_a_wrong_parameter_is_refused(
    key: str, asked: tuple[str, ...], words: str, robot: sf.Robot
) -> None:
    with pytest.raises(sf.ParameterError) as caught:
        chosen_parameters(key, asked, robot, VELOCITY)
    assert words in str(caught.value)


# What is measured


def test_a_stronger_push_takes_more_effort_and_a_fall_all_of_it(robot: sf.Robot) -> None:
    controller = sf.HybridController(robot, (0.5, 0.0))
    none = Answer(0.0, 0.0, 0.0, 0.0, True)
    assert effort_of(none, controller) == (0.0, 0.0, 0.0)
    small, large = (Answer(x, x, x, x, True) for x in (0.01, 0.02))
    assert [2.0 * part for part in effort_of(small, controller)] == pytest.approx(
        effort_of(large, controller)
    )
    assert effort_of(replace(small, survived=False), controller) == (1.0, 1.0, 1.0)


def test_an_effort_is_a_share_of_what_the_robot_has(robot: sf.Robot) -> None:
    controller = sf.UnifiedController(robot, (0.5, 0.0))
    low, high = robot.gait.step_duration
    gait, sole = controller.gait, robot.foot.half
    corner = (sole[0] ** 2 + sole[1] ** 2) ** 0.5
    most = max(gait.step_duration - low, high - gait.step_duration)
    assert effort_of(Answer(corner, corner, 0.0, most, True), controller) == pytest.approx(
        (1, 0, 1)
    )


def test_what_is_survived_is_one_step_below_what_fails(question: Tuning) -> None:
    controller = sf.HybridController(question.robot, (0.5, 0.0))
    pushed = question.pushes["seen"][0]
    found = sf.smallest_failing_push(
        controller, (1.0, 0.0), start=question.walk.start(0.0), step=question.scan_step
    )
    reached = survived(controller, question.walk, pushed, question.scan_step)
    assert reached == found.impulse - found.step
    assert 0.0 < reached <= pushed.limit


def effort_with(controller, **moved: float) -> float:
    """The effort of a push that moves a ZMP by a millimetre, and what else is named."""
    zmp, landing, timing = effort_of(Answer(**{**QUIET, **moved}), controller)
    return zmp + STEP_WEIGHT * (landing + timing)


QUIET: Any = {"zmp_peak": 1e-3, "zmp_rms": 1e-3, "landing": 0.0, "timing": 0.0, "survived": True}


def test_a_landing_that_moves_is_less_gentle_than_a_zmp_that_does(robot: sf.Robot) -> None:
    controller = sf.HybridController(robot, (0.5, 0.0))
    far = 0.5 * robot.foot.width
    assert effort_with(controller, landing=far) > effort_with(controller, zmp_peak=far, zmp_rms=far)


@pytest.mark.parametrize("quantity", ["zmp_peak", "zmp_rms", "landing", "timing"])
def test_effort_grows_with_everything_that_moves(quantity: str, robot: sf.Robot) -> None:
    controller = sf.HybridController(robot, (0.5, 0.0))
    efforts = [effort_with(controller, **{quantity: size}) for size in (0.002, 0.01, 0.02)]
    assert efforts == sorted(set(efforts))


def test_a_score_does_not_depend_on_the_threads(question: Tuning) -> None:
    controller = sf.HybridController(question.robot, (0.5, 0.0))
    one, two = (
        score(
            controller,
            question.walk,
            question.pushes["seen"],
            question.impulse,
            question.scan_step,
            workers=workers,
        )
        for workers in (1, 3)
    )
    assert one == two
    assert one.worst <= one.survival
    assert one.effort == one.zmp + STEP_WEIGHT * (one.landing + one.timing)
    assert one.gentleness(one) == 1.0


def test_pushes_that_the_search_does_not_see_are_others(question: Tuning) -> None:
    seen, unseen = ([one.cell for one in some] for some in question.pushes.values())
    assert len(seen) == len(unseen) == 2
    assert not {one.angle for one in seen} & {one.angle for one in unseen}
    assert not {one.phase for one in seen} & {one.phase for one in unseen}


def test_pushes_scale_with_the_robot(robot: sf.Robot) -> None:
    light = Tuning(robot.replace(mass=6.8), method="tracking", directions=2, phases=1)
    heavy = Tuning(robot.replace(mass=68.0), method="tracking", directions=2, phases=1)
    assert heavy.impulse == pytest.approx(10.0 * light.impulse, rel=0.05)
    assert heavy.scan_step == pytest.approx(10.0 * light.scan_step, rel=0.05)


# What is taken


def tried(number: int, survival: float, gentleness: float, **values: float) -> Tried:
    return Tried(number, values, (survival, gentleness), {})


DEFAULT = tried(0, 0.6, 1.0)
BETTER = [tried(1, 0.8, 0.99), tried(2, 0.7, 0.4), tried(3, 0.62, 0.39)]
NERVOUS, WEAK = tried(4, 0.9, 1.01), tried(5, 0.59, 0.1)
BROKEN = Tried(6, {}, None, {REFUSED: "no"})


def test_the_front_is_what_no_other_beats() -> None:
    trials = [DEFAULT, *BETTER, NERVOUS, WEAK, BROKEN, tried(7, 0.7, 0.5)]
    assert [one.number for one in pareto_front(trials)] == [1, 2, 3, 4, 5]
    equals = [DEFAULT, tried(1, 0.6, 1.0)]
    assert pareto_front(equals) == equals


@pytest.mark.parametrize(("prefer", "number"), [("survival", 1), ("gentleness", 3), ("balance", 2)])
def test_what_is_preferred_is_taken(prefer: str, number: int) -> None:
    assert choose([DEFAULT, *BETTER, NERVOUS, WEAK, BROKEN], prefer).number == number


@pytest.mark.parametrize("prefer", PREFERENCES)
def test_nothing_worse_than_the_default_is_taken(prefer: str) -> None:
    assert choose([DEFAULT, NERVOUS, WEAK, BROKEN, tried(7, 0.6, 1.0)], prefer) is DEFAULT


@pytest.mark.parametrize(
    ("attempt", "kept"),
    [
        # `b` does nothing, `c` as good as nothing, `d` only while `b` is changed.
        (
            lambda v: 0.2 * v["a"] - 0.002 * (not v["c"]) - 0.1 * (not v["d"] and v["b"] != 0.0),
            {"a"},
        ),
        # Small losses do not add up.
        (lambda v: 0.004 * sum(v.values()), {"b", "c", "d"}),
    ],
)
def test_a_parameter_that_changes_nothing_is_set_back(attempt: Any, kept: set[str]) -> None:
    def tried_with(values) -> tuple[float, float]:
        return (0.6 + attempt(values), 0.9)

    ones, zeros = dict.fromkeys("abcd", 1.0), dict.fromkeys("abcd", 0.0)
    values = simplest(Tried(3, ones, tried_with(ones), {}), zeros, (0.6, 1.0), tried_with)
    assert {name for name, value in values.items() if value} == kept
    for why in reasons(values, zeros, tried_with):
        assert (why.default, why.value) == (0.0, 1.0)
        assert why.without == tried_with({**values, why.parameter: 0.0})
    assert {why.parameter for why in reasons(values, zeros, tried_with)} == kept


def test_nothing_is_set_back_below_the_default() -> None:
    def attempt(values) -> tuple[float, float]:
        return (0.6, 1.002 - 0.003 * values["a"])

    values = simplest(Tried(1, {"a": 1.0}, (0.6, 0.999), {}), {"a": 0.0}, (0.6, 1.0), attempt)
    assert values == {"a": 1.0}


# The search


def test_a_default_is_as_gentle_as_itself_and_nothing_is_worse(
    tuned: tuple[Tuned, Path], question: Tuning
) -> None:
    result, _ = tuned
    assert len(result.trials) == TRIALS
    assert result.trials[0].values == question.start
    assert result.trials[0].objectives is not None
    assert result.trials[0].objectives[1] == 1.0
    assert result.objectives("default", "seen") == result.trials[0].objectives
    assert result.objectives("default", "unseen")[1] == 1.0
    before, after = (result.objectives(which, "seen") for which in ("default", "tuned"))
    assert after[0] >= before[0]
    assert after[1] <= before[1]
    assert result.changed
    # Ten times the paper's gain is nervous.
    assert after[1] < 0.95
    assert set(result.settings.parameters) == {one.parameter for one in result.reasons}


def test_a_search_that_goes_on_is_the_search_that_was_not_stopped(
    tuned: tuple[Tuned, Path], question: Tuning, tmp_path: Path
) -> None:
    for trials in (1, 7, TRIALS):
        result = tune(replace(question, trials=trials, threads=2), tmp_path)
    assert result.as_numbers() == tuned[0].as_numbers()


def row_of(**known: Any) -> dict[str, Any]:
    """A row of a search in which all numbers are 1 that are not given."""
    return {**dict.fromkeys((one.name for one in fields(Score)), 1.0), REFUSED: None, **known}


def test_another_seed_searches_elsewhere(question: Tuning, tuned: tuple[Tuned, Path]) -> None:
    some = replace(question, trials=5)
    first, again, other = (
        [one.values for one in search(replace(some, seed=seed), lambda _: row_of())]
        for seed in (0, 0, 1)
    )
    assert first == again == [one.values for one in tuned[0].trials[:5]]
    assert first[0] == other[0] == question.start
    # What is tried can be read.
    assert all(one == float(f"{one:.3g}") for values in first[1:] for one in values.values())
    assert not set(map(str, first[1:])) & set(map(str, other[1:]))


@pytest.mark.parametrize(
    "change",
    [
        lambda question: {"seed": 5},
        lambda question: {"velocity": (0.4, 0.0)},
        lambda question: {"method": "tracking", "asked": ()},
        lambda question: {"phases": 2},
        lambda question: {"asked": ("dcm_gain=1:50",)},
        lambda question: {"robot": question.robot.replace(mass=60.0)},
    ],
    ids=["seed", "velocity", "method", "phases", "range", "robot"],
)
def test_another_question_is_refused_in_the_same_folder(
    tuned: tuple[Tuned, Path], question: Tuning, change: Callable[[Tuning], dict]
) -> None:
    with pytest.raises(sf.FileError, match="a folder of the same study"):
        tune(replace(question, **change(question)), tuned[1])


def test_values_that_the_controller_refuses_are_a_trial_that_is_not_taken(
    question: Tuning,
) -> None:
    def ask(values: Mapping[str, float]) -> dict[str, Any]:
        refused = values["dcm_gain"] > 20.0 and values != question.start
        return row_of(**{REFUSED: "too large"} if refused else {})

    found = search(replace(question, trials=20), ask)
    assert len(found) == 20
    told = [one.told for one in found if one.objectives is None]
    assert told
    assert all(one == {REFUSED: "too large"} for one in told)
    assert choose(found).number == 0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"prefer": "speed"}, r"a preference \(survival, gentleness, balance\)"),
        ({"trials": 0}, "`trials` of at least 1"),
        ({"trials": True}, "`trials` of at least 1"),
        ({"trials": 2.5}, "`trials` of at least 1"),
        ({"threads": 0}, "`threads` of at least 1"),
        ({"threads": -1}, "`threads` of at least 1"),
    ],
)
def test_a_wrong_question_is_refused(change: dict, words: str, question: Tuning) -> None:
    with pytest.raises(sf.ParameterError, match=words):
        replace(question, **change)


def test_what_the_controller_refuses_is_a_row(question: Tuning) -> None:
    row = question.measure(question.cell({"dcm_gain": -1.0}))
    assert "dcm_gain" in row[REFUSED]
    assert row["survival"] is None


KILLED = f"""
import sys
from pathlib import Path
import surefoot as sf
from surefoot.studies.tune.question import Tuning
from surefoot.studies.tune.search import tune
robot = sf.load_robot("paper-biped").with_leg(max_speed=3.0)
tune(Tuning(robot, method="tracking-stiff", asked=("dcm_gain",), directions=2, phases=1, step=0.1,
            trials={TRIALS}, threads=1), Path(sys.argv[1]))
"""


def test_a_search_that_was_killed_repeats_nothing(
    tuned: tuple[Tuned, Path], question: Tuning, tmp_path: Path
) -> None:
    kept = kill_when_kept(KILLED, tmp_path, count=4)
    assert 4 <= kept < len(shards(tuned[1]))
    assert tune(question, tmp_path).as_numbers() == tuned[0].as_numbers()
    # Nothing that was kept is measured again.
    assert len(shards(tmp_path)) == len(shards(tuned[1]))


# The command


def test_a_report_says_when_something_does_not_hold(tuned: tuple[Tuned, Path]) -> None:
    found, _ = tuned
    before, after = (found.scores[which]["unseen"] for which in ("default", "tuned"))
    worse_than = after.survival < before.survival - 0.005 or after.gentleness(before) > 1.01
    assert verdict(found).startswith("It does NOT hold" if worse_than else "It holds")
    weak = {**found.scores["tuned"], "unseen": replace(after, survival=after.survival - 0.05)}
    worse = replace(found, scores={**found.scores, "tuned": weak})
    assert "of the limit less is survived than with the defaults" in verdict(worse)
    assert "It does NOT hold" in report(worse, "surefoot walk").markdown()


COMMAND = [
    "tune", "--controller", "tracking-stiff", "--knob", "dcm_gain", "--directions", "2",
    "--quick", "--leg-speed", "3", "--workers", "1", "--trials", str(TRIALS),
]  # fmt: skip


def test_the_command_writes_settings_that_walk(tuned: tuple[Tuned, Path]) -> None:
    result, folder = tuned
    done = CliRunner().invoke(main, [*COMMAND, "--out", str(folder)])
    assert done.exit_code == 0, done.output
    assert "of the search" in done.output
    for one in result.reasons:
        assert f"{one.parameter} {one.default:g} → {one.value:g}: without it" in done.output
    path = folder / "tuned.toml"
    assert load_settings(path) == result.settings
    walk = CliRunner().invoke(main, ["walk", "--settings", str(path), "--leg-speed", "3", "--json"])
    assert walk.exit_code == 0
    assert json.loads(walk.stdout)["controller"] == "DcmTracking"
    report = (folder / "tune.md").read_text()
    assert f"--settings {path}" in report
    # Whether it holds stands where it is used, too.
    assert f"# {verdict(result)}" in path.read_text()
    assert (folder / "tune.png").read_bytes().startswith(b"\x89PNG")


def test_json_holds_what_was_measured(tuned: tuple[Tuned, Path]) -> None:
    done = CliRunner().invoke(main, [*COMMAND, "--out", str(tuned[1]), "--json"])
    told = json.loads(done.stdout)
    assert told == json.loads(json.dumps(tuned[0].as_numbers()))
    assert len(told["trials"]) == TRIALS


def test_a_search_that_is_stopped_keeps_what_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    measure, calls = Tuning.measure, []

    def stop(*arguments):
        calls.append(arguments)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return measure(*arguments)

    monkeypatch.setattr(Tuning, "measure", stop)
    done = CliRunner().invoke(main, [*COMMAND, "--out", str(tmp_path / "out")])
    assert done.exit_code == 130
    assert "the same command goes on there" in done.output
    assert len(shards(tmp_path / "out")) == 2


def test_without_optuna_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "optuna", None)
    done = CliRunner().invoke(main, [*COMMAND, "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert 'run: pip install "surefoot[tune]"' in done.output
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--controller", "linear-mpc"], "a compiled method with gains"),
        (["--controller", "nobody"], "a method (tracking"),
        (["--trials", "0"], "`trials` of at least 1"),
        (["--workers", "0"], "`threads` of at least 1"),
        (["--seed", "-1"], "`seed`"),
        (["--step", "0"], "`step`"),
        (["--velocity", "9", "0"], "slow down"),
        (["--out", "no/such/folder"], "a directory"),
    ],
)
def test_a_wrong_command_is_refused(words: list[str], told: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["tune", "--out", str(tmp_path / "out"), *words])
    assert done.exit_code == 2, done.output
    assert told in done.output
    assert not (tmp_path / "out").exists()

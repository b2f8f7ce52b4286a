"""Pushes on a body: forks that do not disturb each other, rows that depend on nobody's order."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np
import pytest

import surefoot as sf
from killed_studies import without_time
from surefoot.control.unified.controller import fixed_place, fixed_timing, with_fixed_place
from surefoot.dcm.nominal_gait import nominal_gait
from surefoot.dcm.pushes import DIRECTIONS
from surefoot.robot.feet import Side
from surefoot.studies.compare import body_measure
from surefoot.studies.compare.body_figures import AIM
from surefoot.studies.compare.body_measure import explain, explain_worst
from surefoot.studies.compare.body_question import BodyPush, BodyPushes
from surefoot.studies.compare.body_show import LATEST, push_report, push_table, used_words
from surefoot.studies.engine.pushed_body import (
    BODY_METHODS,
    PushedBody,
    body_method,
    mechanism_of,
)
from surefoot.studies.engine.study import Measured, run
from surefoot.worlds.body.gait import walking_robot

ROBOT = sf.load_robot("paper-biped")
SMALL = BodyPushes(ROBOT, methods=("unified",), phases=1, step=160.0, largest=2.5)
CELL = BodyPush("unified", "forward", 0.5, "left")
WALK = PushedBody(ROBOT, "unified", "left", 0.5)


@pytest.fixture(scope="module")
def believed() -> sf.Robot:
    return walking_robot(mechanism_of(ROBOT))


def test_the_cells_are_the_whole_grid() -> None:
    study = BodyPushes(ROBOT)
    cells = list(study.cells())
    assert len(cells) == len(set(cells)) == len(BODY_METHODS) * 8 * 2 * 4
    assert study.impulses()[:3] == [0.0, 2.0, 4.0]
    assert study.walk(CELL) == WALK


def test_pushes_of_both_feet_are_mirror_images() -> None:
    for direction in DIRECTIONS:
        (x, y), (u, v) = (
            PushedBody(ROBOT, "unified", foot, 0.5).push(direction, 10.0).force
            for foot in ("left", "right")
        )
        assert (x, y) == (u, -v)
    # The left foot stands to the left.
    assert WALK.push("inward", 10.0).force == (0.0, 50.0)


def test_fixed_timing_leaves_the_place_free(believed) -> None:
    free = nominal_gait(believed, (0.3, 0.0))
    fixed = fixed_timing(believed, (0.3, 0.0))
    assert fixed.gait == free
    shortest, longest = fixed.robot.gait.step_duration
    assert shortest < free.step_duration < longest
    assert longest - shortest == pytest.approx(0.01)
    assert fixed.robot.gait.step_x == believed.gait.step_x
    assert fixed.with_velocity((0.2, 0.05)).gait.step_duration == free.step_duration


@pytest.mark.parametrize("velocity", [(0.3, 0.0), (0.0, 0.0), (-0.2, 0.1)])
def test_fixed_place_is_around_the_step_of_every_velocity(believed, velocity) -> None:
    free = nominal_gait(believed, (0.3, 0.0))
    fixed = fixed_place(believed, (0.3, 0.0)).with_velocity(velocity)
    assert fixed.gait.step_duration == free.step_duration
    assert fixed.robot.gait.step_duration == believed.gait.step_duration
    for side in Side:
        low, high = fixed.robot.gait.step_box(side, believed.hip)
        step = fixed.gait.step(side)
        assert all(a < s < b for a, s, b in zip(low, step, high, strict=True))
        assert high[0] - low[0] == pytest.approx(0.01)
        assert high[1] - low[1] == pytest.approx(0.01 + 2.0 * abs(fixed.gait.lateral_step))


def test_fixed_place_does_not_touch_the_robot(believed) -> None:
    before = believed.gait
    with_fixed_place(believed, nominal_gait(believed, (0.3, 0.0)))
    assert believed.gait == before


@pytest.mark.parametrize("estimate", [False, True])
def test_a_fork_depends_on_nothing_that_was_asked_before(estimate: bool) -> None:
    walk = PushedBody(ROBOT, "unified", "left", 0.5, estimate=estimate)
    assert walk.start.arrived
    weak, strong = (walk.push("forward", impulse) for impulse in (20.0, 200.0))
    controls = []
    first = walk.pushed(weak, True, watch=lambda world: controls.append(world.control))
    assert first.survived
    fallen = walk.pushed(strong, watch=lambda world: controls.append(world.control))
    assert not fallen.survived
    # A solver that is shared starts from what it solved last, which need not show in every walk.
    assert controls[0].mapping is not controls[-1].mapping
    assert controls[0].mechanics is not controls[-1].mechanics
    rollout, _ = walk.rollout(weak)
    body, again = first.walk.rollout().body, rollout.body
    assert body is not None
    assert again is not None
    assert np.array_equal(body.position, again.position)
    assert rollout.time[-1] == pytest.approx(walk.start.time + 5.2, abs=0.002)
    assert rollout.pushes == (weak,)


@pytest.mark.parametrize("estimate", [False, True])
def test_a_study_walks_on_what_a_walk_is_told(estimate: bool) -> None:
    study = BodyPushes(ROBOT, estimate=estimate)
    pushed = study.walk(CELL)
    walk = sf.simulate_body(
        pushed.control(),
        pushed.start.time - 0.001,
        steering=[(0.0, sf.Steering(study.velocity))],
        estimator=None if estimate else "truth",
    )
    assert walk.body is not None
    approach = pushed.start.walk.rollout().body
    assert approach is not None
    assert np.array_equal(walk.body.position, approach.position)
    rollout, _ = pushed.rollout(pushed.push("forward", 0.0))
    assert rollout.body is not None
    assert rollout.body.senses == walk.body.senses
    state = study.provenance()["state"]
    assert state == (f"estimated from {sf.BodyNoise.of(ROBOT)}" if estimate else "the truth")
    assert study.common()["noise"] == repr(sf.BodyNoise.of(ROBOT) if estimate else None)


@pytest.mark.parametrize("impulse", [30.0, 400.0])
def test_a_robot_that_is_back_in_its_gait_would_have_walked_on(impulse: float) -> None:
    push = WALK.push("forward", impulse)
    brief, whole = (WALK.pushed(push, recorded) for recorded in (False, True))
    assert brief.survived == whole.survived == (impulse < 100.0)
    assert brief.settled == (impulse < 100.0)
    assert brief.cycles < 0.75 * 5200
    assert whole.cycles == 5200 or whole.cycles == brief.cycles


def test_the_push_comes_in_its_phase_of_its_step() -> None:
    start = PushedBody(ROBOT, "unified", "right", 0.25).start
    state = start.walk.state
    assert state.walk["support"][0] == 1
    elapsed = start.time - state.walk["began"][0]
    assert elapsed == pytest.approx(0.25 * state.command.step_duration, abs=0.0015)


def test_rows_do_not_depend_on_workers_or_order(tmp_path, monkeypatch) -> None:
    few = [cell for cell in SMALL.cells() if cell.direction in ("forward", "outward")]
    monkeypatch.setattr(BodyPushes, "cells", lambda _: iter(few))
    result = run(SMALL, tmp_path / "two", workers=2)
    assert not result.failures
    assert [row["impulse"] for row in result.rows] == [160.0] * 4
    for row in result.rows:
        assert row["cause"]
        assert row["delta_v"] == pytest.approx(160.0 / 68.0, rel=1e-3)
    own = [asdict(cell) | SMALL.measure(cell) for cell in (few[2], few[0])]
    assert without_time(own) == without_time([result.rows[2], result.rows[0]])
    assert [SMALL.cell(row) for row in result.rows] == few
    assert (tmp_path / "two" / "pushes.parquet").stat().st_size > 0
    assert len(result.provenance["robot file"]) == 16


@pytest.mark.parametrize("key", ["linear-mpc", "surefoot.control.mpc.linear:LinearMpc"])
def test_any_method_can_be_asked_for(key: str) -> None:
    study = BodyPushes(ROBOT, methods=(key,), phases=1)
    study.check()
    assert {cell.method for cell in study.cells()} == {key}
    assert isinstance(PushedBody(ROBOT, key, "left", 0.5).control().controller, sf.LinearMpc)


def test_a_method_that_cannot_walk_says_so() -> None:
    row = SMALL.measure(BodyPush("tracking", "forward", 0.0, "left"))
    assert (row["impulse"], row["cause"]) == (0.0, "before the push")


def test_what_binds_is_named_beside_the_usual() -> None:
    strong = explain(WALK, "forward", 200.0)
    assert not strong["survived"]
    assert strong["cause"]
    assert strong["bindings"]
    assert all(one["usual"] < one["share"] <= 1.0 for one in strong["bindings"])
    names = {one["name"] for one in strong["bindings"]}
    assert names & {"friction", "yaw friction", "sole's toe or heel"}
    nothing = explain(WALK, "forward", 0.0)
    assert nothing["survived"]
    assert nothing["bindings"] == []
    assert nothing["used"]["friction used"] < strong["used"]["friction used"] + 1e-9
    assert nothing["used"]["largest landing error"] < 0.05


def test_an_early_landing_is_not_late_by_less_than_nothing() -> None:
    assert used_words(LATEST, -0.015) == "landing 15 ms early"
    assert used_words(LATEST, 0.02) == "landing 20 ms late"
    assert used_words("largest landing error", 0.05) == "landing off by 5 cm"


def test_what_is_explained_is_told_as_it_goes_on(monkeypatch) -> None:
    monkeypatch.setattr(body_measure, "explain", lambda *_: {"bindings": []})
    rows = [row("unified", direction, 0.0, "left", 50.0) for direction in DIRECTIONS]
    told = []
    found = explain_worst(SMALL, rows, lambda done, total: told.append((done, total)))
    assert [one["cell"]["direction"] for one in found] == list(DIRECTIONS)
    assert [one["impulse"] for one in found] == [50.0] * 4
    assert told == [(done, 4) for done in range(5)]


def row(key: str, direction: str, phase: float, foot: str, impulse: float) -> dict:
    return {
        "method": key, "direction": direction, "phase": phase, "foot": foot, "impulse": impulse,
        "delta_v": impulse / 68.0, "scanned": min(impulse, 200.0), "cause": "slip", "words": "it",
    }  # fmt: skip


def test_the_report_has_the_worst_of_all_phases_and_feet(tmp_path) -> None:
    rows = [
        row("unified", direction, phase, foot, 80.0 + 20.0 * phase + (2.0 if foot == "left" else 0))
        for direction in DIRECTIONS
        for phase in (0.0, 0.5)
        for foot in ("left", "right")
    ]
    rows[0] |= {"impulse": math.inf, "delta_v": math.inf, "scanned": 96.0, "cause": ""}
    methods = [{"key": "unified", "label": body_method("unified").label, "adapts": "all"}]
    study = BodyPushes(ROBOT, methods=("unified",), phases=2)
    about = {"velocity": "<b>0.3, 0 m/s", "state": "the truth"}
    measured = Measured(study, rows, [], about, {"methods": methods})
    (line,) = push_table(measured).rows
    assert line[1:5] == ("80 (1.18)",) * 4
    assert line[-1] == "15 slip"
    assert pytest.approx(1.21, abs=0.005) == AIM
    files = push_report([measured]).write(tmp_path)
    page, text = files[0].read_text("utf-8"), files[1].read_text("utf-8")
    assert "<b>" not in page
    assert "http" not in page.replace("http-equiv", "")
    for shown in (page, text):
        assert shown.count("> 96" if shown is text else "&gt; 96") == 1
    assert push_report([measured]).write(tmp_path / ".")[0].read_bytes() == page.encode()

"""Pushes on a body: forks that do not disturb each other, rows that depend on nobody's order."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass

import numpy as np
import pytest
from click.testing import CliRunner
from surefoot.studies.compare.body_compare import compare_on_body
from surefoot.studies.compare.body_limits import explain, explain_worst
from surefoot.studies.compare.body_protocol import (
    BODY_METHODS,
    DIRECTIONS,
    BodyCell,
    BodyProtocol,
    body_method,
    push_of,
)
from surefoot.studies.compare.body_push import (
    control_of,
    measure,
    mechanism_of,
    moment_of,
    push_from,
    pushed_rollout,
    survived,
)
from surefoot.studies.compare.body_push_report import write_body_report
from surefoot.studies.compare.body_pushes import AIM, LATEST, body_pushes, body_table, used_words
from surefoot.studies.compare.body_pushes import DIRECTIONS as SHOWN

import surefoot as sf
from surefoot.cli import main
from surefoot.control.unified.fixed_landing import fixed_place, fixed_timing, with_fixed_place
from surefoot.dcm.nominal_gait import nominal_gait
from surefoot.robot.feet import Side
from surefoot.studies.compare import body_compare, body_limits
from surefoot.studies.engine.cells import run_cells
from surefoot.studies.engine.table import Shards
from surefoot.worlds.body.gait import walking_robot

ROBOT = sf.load_robot("paper-biped")
SMALL = BodyProtocol(ROBOT, methods=("unified",), phases=1, step=160.0, largest=2.5)
CELL = BodyCell("unified", "forward", 0.5, "left")


@pytest.fixture(scope="module")
def believed() -> sf.Robot:
    return walking_robot(mechanism_of(ROBOT))


def without_time(rows: list[dict]) -> list[dict]:
    return [{name: value for name, value in row.items() if name != "seconds"} for row in rows]


def test_the_cells_are_the_whole_grid() -> None:
    protocol = BodyProtocol(ROBOT)
    cells = list(protocol.cells())
    assert len(cells) == len(set(cells)) == len(BODY_METHODS) * 8 * 2 * 4
    assert protocol.impulses(68.0)[:3] == [0.0, 2.0, 4.0]
    assert SHOWN == DIRECTIONS


def test_pushes_of_both_feet_are_mirror_images() -> None:
    for direction in DIRECTIONS:
        (x, y), (u, v) = (
            push_of(BodyCell("unified", direction, 0.0, foot), 4.0, 10.0).force
            for foot in ("left", "right")
        )
        assert (x, y) == (u, -v)
    stance = push_of(BodyCell("unified", "stance side", 0.0, "left"), 4.0, 10.0)
    assert stance.force == (0.0, 50.0)  # the left foot stands to the left


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
    protocol = BodyProtocol(ROBOT, estimate=estimate)
    moment = moment_of(protocol, CELL.method, CELL.foot, CELL.phase)
    assert moment.fate == 0
    weak, strong = (push_of(CELL, moment.time, impulse) for impulse in (20.0, 200.0))
    minds = []
    first = push_from(
        protocol, CELL.method, moment, weak, True, watch=lambda mind, _: minds.append(mind)
    )
    assert survived(first)
    fallen = push_from(
        protocol, CELL.method, moment, strong, watch=lambda mind, _: minds.append(mind)
    )
    assert not survived(fallen)
    # A solver that is shared starts from what it solved last, which need not show in every walk.
    assert minds[0].mapping is not minds[-1].mapping
    assert minds[0].mechanics is not minds[-1].mechanics
    rollout, again = pushed_rollout(protocol, CELL.method, moment, weak)
    assert np.array_equal(first.plant.data.qpos, again.plant.data.qpos)
    assert rollout.time[-1] == pytest.approx(moment.time + 5.2, abs=0.002)
    assert rollout.pushes == (weak,)


@pytest.mark.parametrize("estimate", [False, True])
def test_a_study_walks_on_what_a_walk_is_told(estimate: bool) -> None:
    protocol = BodyProtocol(ROBOT, estimate=estimate)
    moment = moment_of(protocol, CELL.method, CELL.foot, CELL.phase)
    walk = sf.simulate_body(
        control_of(protocol, CELL.method),
        moment.time - 0.001,
        steering=[(0.0, sf.Steering(protocol.velocity))],
        estimator=None if estimate else "truth",
    )
    assert walk.body is not None
    assert np.array_equal(walk.body.position, moment.record.state["position"])
    rollout, _ = pushed_rollout(protocol, CELL.method, moment, push_of(CELL, moment.time, 0.0))
    assert rollout.body is not None
    assert rollout.body.senses == walk.body.senses
    told = body_compare.provenance(protocol)["state"]
    assert told == (f"estimated from {sf.BodyNoise.of(ROBOT)}" if estimate else "the truth")
    assert protocol.same_for_all()["noise"] == repr(sf.BodyNoise.of(ROBOT) if estimate else None)


@pytest.mark.parametrize("impulse", [30.0, 400.0])
def test_a_robot_that_is_back_in_its_gait_would_have_walked_on(impulse: float) -> None:
    moment = moment_of(SMALL, "unified", "left", 0.5)
    push = push_of(CELL, moment.time, impulse)
    brief, whole = (push_from(SMALL, "unified", moment, push, kept) for kept in (False, True))
    assert survived(brief) == survived(whole) == (impulse < 100.0)
    assert brief.settled == (impulse < 100.0)
    assert brief.cycles < 0.75 * 5200
    assert whole.cycles == 5200 or whole.cycles == brief.cycles


def test_the_push_comes_in_its_phase_of_its_step() -> None:
    moment = moment_of(BodyProtocol(ROBOT), "unified", "right", 0.25)
    walk = moment.state.walk[0]
    assert walk["support"] == 1
    elapsed = moment.time - walk["began"]
    assert elapsed == pytest.approx(0.25 * moment.state.command.step_duration, abs=0.0015)


def test_rows_do_not_depend_on_workers_or_order(tmp_path, monkeypatch) -> None:
    few = [cell for cell in SMALL.cells() if cell.direction in ("forward", "swing side")]
    monkeypatch.setattr(BodyProtocol, "cells", lambda _: iter(few))
    result = compare_on_body(SMALL, tmp_path / "two", workers=2)
    assert not result.failures
    assert [row["impulse"] for row in result.rows] == [160.0] * 4
    for row in result.rows:
        assert row["cause"]
        assert row["delta_v"] == pytest.approx(160.0 / 68.0, rel=1e-3)
    cells = [BodyCell(r["method"], r["direction"], r["phase"], r["foot"]) for r in result.rows]
    own = [measure(SMALL, cell) for cell in (cells[2], cells[0])]
    assert without_time(own) == without_time([result.rows[2], result.rows[0]])
    assert (tmp_path / "two" / "pushes.parquet").stat().st_size > 0
    assert len(result.provenance["robot file"]) == 16


def test_a_method_that_cannot_walk_says_so() -> None:
    row = measure(SMALL, BodyCell("tracking", "forward", 0.0, "left"))
    assert (row["impulse"], row["cause"]) == (0.0, "before the push")


KILLED = """
import sys, time
from pathlib import Path
import surefoot as sf
from surefoot.studies.compare.body_protocol import BodyCell, BodyProtocol
from surefoot.studies.engine.cells import run_cells
from surefoot.studies.engine.table import Shards
from dataclasses import asdict
def measure(p, c): return (time.sleep(0.1), asdict(c) | {"impulse": 1.0})[1]
protocol = BodyProtocol(sf.load_robot("paper-biped"), methods=("unified",), phases=4)
shards = Shards(Path(sys.argv[1]), protocol.same_for_all())
run_cells(measure, BodyCell, protocol, shards, workers=1)
"""


def test_a_killed_study_goes_on_and_repeats_nothing(tmp_path) -> None:
    script, folder = tmp_path / "killed.py", tmp_path / "table"
    script.write_text(KILLED)
    study = subprocess.Popen([sys.executable, str(script), str(folder)])
    deadline = time.monotonic() + 60.0
    while time.monotonic() < deadline and study.poll() is None:
        if len(list((folder / "shards").glob("*.parquet"))) >= 3:
            break
        time.sleep(0.02)
    os.kill(study.pid, signal.SIGKILL)
    study.wait()
    protocol = BodyProtocol(ROBOT, methods=("unified",), phases=4)
    shards = Shards(folder, protocol.same_for_all())
    kept, again = len(shards.rows), []
    assert 3 <= kept < 32

    def ask(protocol: BodyProtocol, cell: BodyCell) -> dict:
        again.append(cell)
        return vars(cell) | {"impulse": 1.0}

    rows, failures = run_cells(ask, BodyCell, protocol, shards, workers=1)
    assert not failures
    assert len(rows) == 32
    assert len(again) == 32 - kept
    with pytest.raises(sf.FileError, match=r"a folder of the same study \(step: 5\.0\)"):
        Shards(folder, BodyProtocol(ROBOT, step=5.0).same_for_all())


def test_what_binds_is_named_beside_the_usual() -> None:
    protocol = BodyProtocol(ROBOT)
    strong = explain(protocol, CELL, 200.0)
    assert not strong.survived
    assert strong.cause
    assert strong.bindings
    assert all(one.usual < one.share <= 1.0 for one in strong.bindings)
    names = {one.name for one in strong.bindings}
    assert names & {"friction", "yaw friction", "sole's toe or heel"}
    nothing = explain(protocol, CELL, 0.0)
    assert nothing.survived
    assert nothing.bindings == ()
    assert nothing.used["friction used"] < strong.used["friction used"] + 1e-9
    assert nothing.used["largest landing error"] < 0.05


def test_an_early_landing_is_not_late_by_less_than_nothing() -> None:
    assert used_words(LATEST, -0.015) == "landing 15 ms early"
    assert used_words(LATEST, 0.02) == "landing 20 ms late"
    assert used_words("largest landing error", 0.05) == "landing off by 5 cm"


def test_what_is_explained_is_told_as_it_goes_on(monkeypatch) -> None:
    monkeypatch.setattr(body_limits, "explain", lambda p, cell, _: Nothing(cell))
    rows = [row("unified", direction, 0.0, "left", 50.0) for direction in DIRECTIONS]
    told = []
    found = explain_worst(SMALL, rows, lambda done, total: told.append((done, total)))
    assert [one["cell"]["direction"] for one in found] == list(DIRECTIONS)
    assert told == [(done, 4) for done in range(5)]


@dataclass(frozen=True)
class Nothing:
    """An explanation that nobody looked for."""

    cell: BodyCell


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--simulator", "mujoco", "--mass", "70"], "--mass with --simulator lipm"),
        (["--simulator", "mujoco", "--leg-speed", "3"], "--leg-speed with --simulator lipm"),
        (["--estimate"], "--estimate with --simulator mujoco"),
        (["--explain"], "--explain with --simulator mujoco"),
        (["--robot", "h1", "--robot", "g1"], "one --robot with --simulator lipm"),
        (["--simulator", "mujoco", "--method", "lqr"], "a method for a body (tracking, "),
        (["--simulator", "mujoco", "--robot", "paper-table2"], "a robot with a [body] table"),
        (["--simulator", "mujoco", "--grid", "0"], "`step` above 0 [N s]"),
        (["--simulator", "mujoco", "--phases", "0"], "`phases` as a whole number"),
    ],
)
def test_misuse_is_told(words, message: str, tmp_path) -> None:
    wrong = CliRunner().invoke(main, ["compare", *words, "--out", str(tmp_path / "x")])
    assert wrong.exit_code == 2
    assert message in wrong.stderr
    assert not (tmp_path / "x").exists()


def test_a_folder_of_another_name_is_refused() -> None:
    with pytest.raises(sf.ParameterError, match="at least one of `methods`"):
        BodyProtocol(ROBOT, methods=())


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
    rows[0] |= {"impulse": math.inf, "delta_v": math.inf, "cause": ""}
    methods = [{"key": "unified", "label": body_method("unified").label, "adapts": "all"}]
    measured = body_pushes(rows, methods, 68.0, 2.0, {"robot": "<b>", "velocity": "0.3, 0 m/s"})
    (line,) = body_table(measured).rows
    assert line[1:5] == ("80 (1.18)",) * 4
    assert line[-1] == "15 slip"
    assert pytest.approx(1.21, abs=0.005) == AIM
    files = write_body_report([measured], tmp_path)
    page = files[0].read_text("utf-8")
    assert "<b>" not in page
    assert "http" not in page.replace("http-equiv", "")
    assert write_body_report([measured], tmp_path / ".")[0].read_bytes() == page.encode()


def test_the_command_measures_reports_and_resumes(tmp_path) -> None:
    asked = [
        "compare", "--simulator", "mujoco", "--method", "tracking", "--phases", "1", "--grid",
        "50", "--workers", "1", "--out", str(tmp_path / "out"),
    ]  # fmt: skip
    first = CliRunner().invoke(main, asked)
    assert first.exit_code == 0, first.output
    assert "8 before the push" in first.stdout
    shards = sorted((tmp_path / "out" / "paper-biped" / "shards").iterdir())
    again = CliRunner().invoke(main, [*asked, "--json"])
    assert again.exit_code == 0, again.output
    (told,) = json.loads(again.stdout)["robots"]
    assert len(told["rows"]) == 8
    assert sorted((tmp_path / "out" / "paper-biped" / "shards").iterdir()) == shards
    for name in (
        "pushes.html",
        "pushes.md",
        "paper-biped/pushes.png",
        "paper-biped/pushes.parquet",
    ):
        assert (tmp_path / "out" / name).stat().st_size > 0

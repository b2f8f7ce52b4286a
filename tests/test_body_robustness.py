"""Walks while something is wrong: what is wrong, the rows, and what is shown of them."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.studies.compare import body_question
from surefoot.studies.compare.body_figures import walk_figure
from surefoot.studies.compare.body_question import (
    BODY_DISTURBANCES,
    SILENT,
    USUAL,
    BodyWalks,
    WalkCell,
    body_disturbance,
)
from surefoot.studies.compare.body_show import falls_table, walk_report, walk_table
from surefoot.studies.engine.study import Measured, run
from surefoot.worlds.body.estimator import BodyReadings

ROBOT = sf.load_robot("paper-biped")
SMALL = BodyWalks(ROBOT, conditions=(USUAL, "delay-5ms"), seeds=1, duration=1.6)


def row(condition: str, seed: int, **changes: object) -> dict:
    usual = {
        "method": "unified", "condition": condition, "seed": seed, "walked": True, "time": 20.0,
        "cause": "", "words": "", "dcm_error": 0.012, "estimate_error": 0.002, "drift": -0.03,
        "heading": 0.01, "speed": 0.3, "seconds": 1.0,
    }  # fmt: skip
    return usual | changes


@pytest.fixture
def shown() -> Measured[BodyWalks]:
    fall = {
        "walked": False, "time": 4.2, "cause": "slip", "words": "slip at 3.90 s: the left sole slid"
    }  # fmt: skip
    rows = [
        row(USUAL, 0), row(USUAL, 1, dcm_error=0.02, drift=math.nan),
        row("bumps-10mm", 0), row("bumps-10mm", 1, **fall),
    ]  # fmt: skip
    conditions = (USUAL, "bumps-10mm")
    study = BodyWalks(ROBOT, conditions=conditions, seeds=2)
    labels = [{"key": key, "label": body_disturbance(key).label} for key in conditions]
    notes = {"methods": [{"key": "unified", "label": "unified"}], "conditions": labels}
    return Measured(study, rows, [], {"robot": "paper-biped", "walks": "20 s"}, notes)


def test_every_condition_can_be_walked() -> None:
    assert len({one.key for one in BODY_DISTURBANCES}) == len(BODY_DISTURBANCES)
    for one in BODY_DISTURBANCES:
        assert one.noise(3).seed == one.surroundings(3).seed == 3
    usual, worst = body_disturbance(USUAL), body_disturbance("all-at-once")
    assert usual.noise(0) == sf.BodyNoise()
    assert usual.surroundings(0) == sf.Surroundings()
    assert worst.noise(0) == sf.BodyNoise(delay=0.005)
    assert worst.surroundings(2) == sf.Surroundings(0.4, 10.0, 1.1, 0.01, 2)


def test_what_is_alone_is_alone() -> None:
    alone = body_disturbance("velocity-noise").noise(0)
    for name in SILENT:
        assert getattr(alone, name) == (0.1 if name == "rate" else 0.0)
    inertial = body_disturbance("imu-noise").noise(0)
    assert inertial.encoder == inertial.rate == inertial.force == 0.0
    assert inertial.gyro == inertial.gyro_bias == 0.005


def test_a_row_is_the_same_twice_and_true() -> None:
    cell = WalkCell("unified", "mass+10%", 1)
    first, again = (SMALL.measure(cell) for _ in range(2))
    seconds = {"seconds": 0.0}
    assert repr(first | seconds) == repr(again | seconds)
    assert first["walked"]
    assert first["time"] == pytest.approx(SMALL.duration)
    assert 0.0 < first["estimate_error"] < 0.01
    assert 0.0 < first["dcm_error"] < 0.1


def test_a_fall_is_told_with_its_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    ice = replace(body_disturbance(USUAL), world={"friction": 0.05})
    monkeypatch.setattr(body_question, "body_disturbance", lambda _: ice)
    found = BodyWalks(ROBOT, duration=6.0).measure(WalkCell("unified", USUAL, 0))
    assert not found["walked"]
    assert found["time"] < 6.0
    assert found["cause"]
    assert found["words"].startswith(found["cause"])


def test_a_study_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = run(SMALL, tmp_path, workers=1)
    assert [one["condition"] for one in result.rows] == [USUAL, "delay-5ms"]
    assert all(one["walked"] for one in result.rows), result.rows
    monkeypatch.setattr(body_question, "measure_walk", None)
    again = run(SMALL, tmp_path, workers=1)
    assert repr(again.rows) == repr(result.rows)
    json.dumps(again.as_numbers(), allow_nan=False)
    with pytest.raises(sf.FileError, match="a folder of the same study"):
        run(BodyWalks(ROBOT, duration=9.0), tmp_path, workers=1)


def test_the_worst_walk_counts(shown: Measured[BodyWalks]) -> None:
    usual, rough = walk_table(shown, "unified").rows
    assert usual[1:] == ("2 of 2", "20", "2.0", "30", "10")
    assert rough[1] == "1 of 2; 4.2 s"
    assert rough[2] == "12"
    assert falls_table(shown).rows == [
        ("bumps of 10 mm", "1", "4.2 s", "slip at 3.90 s: the left sole slid")
    ]


def test_the_report_has_it_all(shown: Measured[BodyWalks], tmp_path: Path) -> None:
    files = walk_report([shown]).write(tmp_path)
    assert [path.name for path in files] == ["walks.html", "walks.md", "walks.png"]
    first = [path.read_bytes() for path in files]
    assert [path.read_bytes() for path in walk_report([shown]).write(tmp_path)] == first
    for content in first[:2]:
        assert "1 of 2; 4.2 s" in content.decode()
        assert "the left sole slid" in content.decode()
    figure = walk_figure([shown])
    (ax,) = figure.axes
    lines = {line.get_gid(): line for line in ax.lines}
    assert np.asarray(
        lines["tracking-paper-biped-unified-usual-noise"].get_xdata()
    ) == pytest.approx([12.0, 20.0])
    assert "fell-paper-biped-unified-bumps-10mm" in lines
    assert "fell-paper-biped-unified-usual-noise" not in lines


class Spikes:
    """A foot force that is too large in two cycles of three, or in all."""

    def __init__(self, every: bool) -> None:
        self.every = every

    def start(self) -> int:
        return 0

    def step(self, memory: int, readings: BodyReadings) -> tuple[BodyReadings, int]:
        if self.every or memory % 3:
            readings = readings._replace(foot_force=readings.foot_force + 25.0)
        return readings, memory + 1


def test_a_landing_is_not_believed_at_once(body_control: sf.BodyControl) -> None:
    plain, noisy, wrong = (
        sf.simulate_body(body_control, 2.5, noise=noise)
        for noise in (None, Spikes(False), Spikes(True))
    )
    usual, sooner, at_once = (
        min(step.duration for step in one.footsteps) for one in (plain, noisy, wrong)
    )
    # A real touch is believed a little sooner with a spike on top; a spike alone is not.
    assert sooner > 0.85 * usual
    assert at_once < 0.5 * usual


def test_an_estimate_knows_by_itself_how_late_its_sensors_are(
    body_control: sf.BodyControl,
) -> None:
    late = sf.BodyNoise(delay=0.005)
    known = sf.BodyEstimator(body_control.multibody, delay=0.005)
    walks = [
        sf.simulate_body(body_control, 1.5, noise=late, estimator=estimator)
        for estimator in (None, known)
    ]
    assert walks[0].estimator == walks[1].estimator
    assert np.array_equal(walks[0].com, walks[1].com)

"""The paper's pushes on a body: the one of Figs. 9 and 10, and the largest."""

from __future__ import annotations

from dataclasses import astuple, replace
from html import escape
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import surefoot as sf
from surefoot.cli import main
from surefoot.studies.engine.study import Measured, run
from surefoot.studies.reproduce.body import (
    IN_PART,
    PAPER_PUSHES,
    SHOWN_STEPS,
    BodyAnswer,
    back_words,
    body_answer,
    body_claim,
)
from surefoot.studies.reproduce.question import BodyCell, PaperOnBody
from surefoot.studies.reproduce.show import body_report, claims_of
from surefoot.studies.reproduce.walks import NOT_REPRODUCED, REPRODUCED

FORWARD, HEADLINE = PAPER_PUSHES[0], PAPER_PUSHES[-2]


@pytest.fixture(scope="module")
def robot() -> sf.Robot:
    return sf.load_robot("paper-biped")


@pytest.fixture(scope="module")
def answers(robot: sf.Robot) -> list[BodyAnswer]:
    return [body_answer(robot, "unified", push) for push in (FORWARD, HEADLINE)]


@pytest.fixture
def two_pushes(answers: list[BodyAnswer], monkeypatch: pytest.MonkeyPatch) -> None:
    """The study asks about the two pushes that were answered already."""
    cells = [BodyCell(one.method, one.push) for one in answers]
    monkeypatch.setattr(PaperOnBody, "cells", lambda study: cells)


def test_pushes_are_those_of_the_paper() -> None:
    assert [push.impulse for push in PAPER_PUSHES] == [35.2] * 3 + [70.56, 58.8, 58.8, 82.32, 85.0]
    assert {push.direction for push in PAPER_PUSHES} == {"forward", "inward", "outward"}


def test_the_push_comes_in_the_paper_s_phase(answers: list[BodyAnswer]) -> None:
    for one in answers:
        pushed, (push,) = one.steps[0], one.rollout.pushes
        assert pushed.side == sf.Side.RIGHT
        assert push.start == one.begin
        assert np.multiply(push.duration, push.force) == pytest.approx((one.push.impulse, 0.0))
        usual = one.usual_step
        # Of the planned duration: a foot touches the floor a little before that.
        row = np.searchsorted(one.rollout.time, one.begin) - 1
        planned = one.rollout.commands["step_duration"][row]
        assert (one.begin - usual.start) / planned == pytest.approx(0.2, abs=0.02)


def test_the_body_survives_what_the_point_mass_does(answers: list[BodyAnswer]) -> None:
    assert [one.alive for one in answers] == [True, True]
    first = answers[0]
    # The push takes the landing forward, and its effect dies out.
    assert first.steps[0].step[0] > first.usual_step.step[0] + 0.1
    assert first.off[0] < 0.06
    assert first.off[-1] < 0.02
    assert first.back_after is not None
    for one in answers:
        claim = body_claim(one)
        assert claim.verdict in (REPRODUCED, IN_PART)
        assert "walks on" in claim.ours
        assert back_words(one) in claim.ours


def test_a_fall_is_not_reproduced(answers: list[BodyAnswer]) -> None:
    fallen = replace(answers[1], alive=False)
    assert fallen.back_after is None
    assert body_claim(fallen).verdict == NOT_REPRODUCED


@pytest.mark.usefixtures("two_pushes")
def test_the_command_writes_the_report(tmp_path: Path) -> None:
    asked = ["reproduce", "--simulator", "mujoco", "--workers", "1", "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(main, asked)
    assert result.exit_code == 0, result.output
    assert "82.32 N s, forward; unified (ours): walks on; reproduced" in result.stdout
    assert (tmp_path / "out" / "pictures" / "body-unified-82.32-forward.png").stat().st_size > 0


@pytest.mark.usefixtures("two_pushes")
def test_the_report_has_every_push_and_its_picture(robot: sf.Robot, tmp_path: Path) -> None:
    found: Measured[PaperOnBody] = run(PaperOnBody(robot), tmp_path, workers=1)
    report, claims = body_report(found), claims_of(found.rows)
    assert len(claims) == len(report.pictures()) == 2
    files = report.write(tmp_path)
    assert [file.name for file in files[:2]] == ["paper_body.html", "paper_body.md"]
    page, text = (file.read_text("utf-8") for file in files[:2])
    assert "# The paper's pushes on a body" in text
    assert "surefoot reproduce --simulator mujoco" in text
    for claim in claims:
        for words in astuple(claim):
            assert words.strip()
            assert words in text
            assert escape(words) in page.replace("&#39;", "&#x27;")
    assert [len(row["steps"]) for row in found.rows] == [SHOWN_STEPS] * 2

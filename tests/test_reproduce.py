"""Every claim of the paper is a test: measured once, then asked one by one."""

from __future__ import annotations

import dataclasses
import math
import re
from pathlib import Path

import markupsafe
import numpy as np
import pytest

import surefoot as sf
from surefoot.studies.engine.report import Report
from surefoot.studies.engine.study import Measured, run
from surefoot.studies.reproduce import one_step
from surefoot.studies.reproduce.figures import PICTURES
from surefoot.studies.reproduce.measure import (
    claim_fig_5,
    claim_fig_8,
    claim_fig_9,
    claim_fig_11,
    paper_parameters,
)
from surefoot.studies.reproduce.one_step import (
    OneStepLimit,
    limits_by_assumptions,
    limits_table,
    nearest_limits,
)
from surefoot.studies.reproduce.question import OneStep, Paper
from surefoot.studies.reproduce.show import claims_of, paper_report
from surefoot.studies.reproduce.walks import (
    NOT_REPRODUCED,
    REPLAY_PUSH,
    REPRODUCED,
    UNDER_ASSUMPTIONS,
    Claim,
    paper_walk,
    replay_fall,
)
from surefoot.worlds.point.batch import pushed_landings

EXPECTED = [
    ("Fig. 4", "two walking velocities", UNDER_ASSUMPTIONS),
    ("Fig. 5", "40 N", UNDER_ASSUMPTIONS),
    ("Fig. 8", "142 N", UNDER_ASSUMPTIONS),
    ("Fig. 8, projected", "inside the support", REPRODUCED),
    ("IV-A, open loop", "undisturbed", REPRODUCED),
    ("IV-A, open loop", "push of 1 N", REPRODUCED),
    ("Fig. 9", "176 N", UNDER_ASSUMPTIONS),
    ("Fig. 10", "over time", UNDER_ASSUMPTIONS),
    ("IV-B, one step", "impulse in x", UNDER_ASSUMPTIONS),
    ("IV-B, one step", "impulse in y", UNDER_ASSUMPTIONS),
    ("Fig. 11", "82.32 N s", UNDER_ASSUMPTIONS),
    ("Fig. 12", "CoM velocity", UNDER_ASSUMPTIONS),
    ("abstract", "85 N s on 70 kg", UNDER_ASSUMPTIONS),
]


@pytest.fixture(scope="session")
def results(robot_70kg: sf.Robot, tmp_path_factory: pytest.TempPathFactory) -> Measured[Paper]:
    folder = tmp_path_factory.mktemp("paper")
    limits = run(OneStep(robot_70kg), folder / "one_step", workers=1)
    return run(Paper(robot_70kg, tuple(map(OneStepLimit.of, limits.rows))), folder, workers=1)


@pytest.fixture(scope="session")
def claims(results: Measured[Paper]) -> list[Claim]:
    return claims_of(results.rows)


@pytest.fixture(scope="session")
def limits(results: Measured[Paper]) -> tuple[OneStepLimit, ...]:
    return results.study.limits


@pytest.fixture(scope="session")
def report(results: Measured[Paper]) -> Report:
    return paper_report(results)


@pytest.fixture(scope="session")
def pictures(report: Report) -> dict[str, bytes]:
    return report.pictures()


@pytest.mark.parametrize(
    ("index", "expected"), list(enumerate(EXPECTED)), ids=[f"{e[0]}: {e[1]}" for e in EXPECTED]
)
def test_the_claim(claims: list[Claim], index: int, expected: tuple[str, str, str]) -> None:
    figure, words, verdict = expected
    claim = claims[index]
    assert claim.figure == figure
    assert words in claim.text
    assert claim.verdict == verdict
    assert all(getattr(claim, field.name).strip() for field in dataclasses.fields(claim))


def test_every_claim_is_expected(claims: list[Claim]) -> None:
    assert len(claims) == len(EXPECTED)


def printed(claims: list[Claim], figure: str) -> list[float]:
    claim = next(claim for claim in claims if claim.figure == figure)
    return [float(number) for number in re.findall(r"-?\d+\.\d+", claim.ours)]


def test_what_is_printed_is_what_was_measured(claims: list[Claim], robot_70kg: sf.Robot) -> None:
    walk = paper_walk(robot_70kg, "fig-8")
    out = walk.time[walk.zmp_excess > 0.0]
    expected = [out[0], out[-1], 1e3 * walk.zmp_excess.max()]
    assert printed(claims, "Fig. 8") == pytest.approx(expected, abs=0.06)
    third = paper_walk(robot_70kg, "fig-9").footsteps[2]
    assert printed(claims, "Fig. 10")[0] == pytest.approx(third.duration, abs=5e-4)


@pytest.mark.parametrize(
    ("claim", "walks"),
    [
        (claim_fig_5, ("fig-8",)),
        (claim_fig_8, ("fig-5",)),
        (claim_fig_9, ("fig-11", "fig-11")),
        (claim_fig_11, ("fig-9-without-small-pushes",)),
    ],
)
def test_a_claim_can_fail(claim, walks: tuple[str, ...], robot_70kg: sf.Robot) -> None:
    assert claim(*(paper_walk(robot_70kg, name) for name in walks)).verdict == NOT_REPRODUCED


def test_an_error_grows_with_the_divergent_rate(robot_70kg: sf.Robot) -> None:
    """Open loop: a push e^k times as large falls k / omega sooner."""
    falls = []
    for factor in (1.0, math.e**3):
        force = (factor * REPLAY_PUSH.force[0], 0.0)
        push = sf.Push(REPLAY_PUSH.start, REPLAY_PUSH.duration, force)
        falls.append(replay_fall(robot_70kg, 0.0, (push,)))
    # It falls 1.5 m from the foot that stands, and the feet alternate: not to the millisecond.
    assert falls[0] - falls[1] == pytest.approx(3.0 / robot_70kg.omega, abs=0.1)


def test_a_landing_in_the_first_step_is_one_in_the_third(robot_70kg: sf.Robot) -> None:
    controller = sf.HybridController(robot_70kg, (0.5, 0.0))
    (landing,) = pushed_landings(controller, [sf.Push(0.1, 0.2, (176.0, 0.0))])
    third = sf.simulate(controller, 2.0, [sf.Push(1.1, 0.2, (176.0, 0.0))]).footsteps[2]
    assert landing["time"] == pytest.approx(third.duration, abs=1e-9)
    assert landing["offset"] == pytest.approx(third.dcm_offset, abs=1e-9)
    assert landing["adapted"] == third.adapted


def test_landings_need_a_kernel(robot_70kg: sf.Robot) -> None:
    class Slow(sf.DcmTracking):
        @property
        def kernel(self):
            return None

    with pytest.raises(sf.ParameterError, match="a controller with a compiled kernel"):
        pushed_landings(Slow(robot_70kg, (0.5, 0.0)), [])


def test_the_table_holds_every_set_of_assumptions_once(limits: tuple[OneStepLimit, ...]) -> None:
    rows = limits_by_assumptions(limits)
    sets = math.prod(
        map(len, (one_step.HIPS, one_step.LEG_SPEEDS, one_step.OFFSET_WEIGHTS, one_step.PENALTIES))
    )
    assert len(rows) == 4 * sets
    assert len({words for words, _ in rows}) == len(rows)


def test_fewer_restrictions_never_lower_a_limit(limits: tuple[OneStepLimit, ...]) -> None:
    """Excluding landings during the push can only take away."""
    impulses = {dataclasses.replace(row, impulse=0.0): row.impulse for row in limits}
    for row, impulse in impulses.items():
        if not row.lands_during_push:
            assert impulse <= impulses[dataclasses.replace(row, lands_during_push=True)]


def test_the_limit_in_x_comes_out_under_named_assumptions(
    limits: tuple[OneStepLimit, ...],
) -> None:
    (first, *_) = nearest_limits(limits, 70.56, along_x=True)
    assert first.impulse == pytest.approx(70.56, abs=one_step.IMPULSE_STEP)
    assert math.isinf(first.leg_speed)
    assert not first.lands_during_push
    strict = nearest_limits([r for r in limits if r.nominal], 70.56, along_x=True)
    assert strict[0].impulse == pytest.approx(70.56, rel=0.03)


def test_one_set_of_assumptions_gives_both_limits(limits: tuple[OneStepLimit, ...]) -> None:
    """Table 2 as printed, its bounds on d, and a leg that is fast but not infinitely so."""
    words, (x, y, _) = limits_by_assumptions(limits)[0]
    assert "hip 0.01 m" in words
    assert "|d| within its bounds" in words
    assert x == pytest.approx(70.56, rel=0.03)
    assert y == pytest.approx(58.8, rel=0.03)


def test_everything_is_the_same_the_second_time(
    report: Report, pictures: dict[str, bytes], robot_70kg: sf.Robot
) -> None:
    names = ("fig-4a", "fig-4b", "fig-5", "fig-8", "fig-9", "fig-11")
    before = [paper_walk(robot_70kg, name) for name in names]
    paper_walk.cache_clear()
    for walk, again in zip(before, (paper_walk(robot_70kg, name) for name in names), strict=True):
        assert walk is not again
        assert np.array_equal(walk.observations, again.observations)
        assert np.array_equal(walk.commands, again.commands)
    for name, content in report.pictures().items():
        # Wall clock.
        if "decision-time" not in name:
            assert content == pictures[name], name


def test_the_report_holds_every_row_and_every_picture(
    report: Report, claims: list[Claim], limits: tuple[OneStepLimit, ...], robot_70kg: sf.Robot,
    tmp_path: Path,
) -> None:  # fmt: skip
    page, text, *drawn = report.write(tmp_path / "out")
    html, markdown = page.read_text(), text.read_text()
    for claim in claims:
        for words in (claim.ours, claim.why, claim.paper):
            assert words.replace("|", "\\|") in markdown
            assert str(markupsafe.escape(words)) in html
    rows = len(claims) + len(paper_parameters(robot_70kg)) + len(limits_table(limits).rows)
    assert html.count('<th scope="row">') == rows
    # All but the decision time, which differs from run to run, are in the page.
    assert html.count("data:image/png;base64,") == len(PICTURES) - 1
    assert [path.stem for path in drawn] == list(PICTURES)
    for path in drawn:
        assert f"pictures/{path.name}" in markdown
        assert path.read_bytes()[:4] == b"\x89PNG"
    assert "nothing is random" in html
    assert sf.__version__ in html

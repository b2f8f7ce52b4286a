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
from surefoot.studies.reproduce import one_step
from surefoot.studies.reproduce.figures import PICTURES
from surefoot.studies.reproduce.measure import (
    PaperResults,
    claim_fig_5,
    claim_fig_8,
    claim_fig_9,
    claim_fig_11,
    paper_parameters,
    reproduce_paper,
)
from surefoot.studies.reproduce.one_step import limits_by_assumptions, limits_table, nearest_limits
from surefoot.studies.reproduce.question import (
    NOT_REPRODUCED,
    REPLAY_PUSH,
    REPRODUCED,
    UNDER_ASSUMPTIONS,
    Claim,
    paper_rollouts,
    replay_fall,
)
from surefoot.studies.reproduce.show import paper_report
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
def results(robot_70kg: sf.Robot) -> PaperResults:
    return reproduce_paper(robot_70kg)


@pytest.fixture(scope="session")
def report(results: PaperResults, robot_70kg: sf.Robot) -> Report:
    return paper_report(robot_70kg, results)


@pytest.fixture(scope="session")
def pictures(report: Report) -> dict[str, bytes]:
    return report.pictures()


@pytest.mark.parametrize(
    ("index", "expected"), list(enumerate(EXPECTED)), ids=[f"{e[0]}: {e[1]}" for e in EXPECTED]
)
def test_the_claim(results: PaperResults, index: int, expected: tuple[str, str, str]) -> None:
    figure, words, verdict = expected
    claim = results.claims[index]
    assert claim.figure == figure
    assert words in claim.text
    assert claim.verdict == verdict
    assert all(getattr(claim, field.name).strip() for field in dataclasses.fields(claim))


def test_every_claim_is_expected(results: PaperResults) -> None:
    assert len(results.claims) == len(EXPECTED)


def claim_of(results: PaperResults, figure: str) -> Claim:
    return next(claim for claim in results.claims if claim.figure == figure)


def numbers(claim: Claim) -> list[float]:
    return [float(number) for number in re.findall(r"-?\d+\.\d+", claim.ours)]


def test_what_is_printed_is_what_was_measured(results: PaperResults) -> None:
    walk = results.rollouts["fig-8"]
    out = walk.time[walk.zmp_excess > 0.0]
    printed = numbers(claim_of(results, "Fig. 8"))
    assert printed == pytest.approx([out[0], out[-1], 1e3 * walk.zmp_excess.max()], abs=0.06)
    third = results.rollouts["fig-9"].footsteps[2]
    assert numbers(claim_of(results, "Fig. 10"))[0] == pytest.approx(third.duration, abs=5e-4)


def test_a_claim_can_fail(results: PaperResults) -> None:
    walks = results.rollouts
    assert claim_fig_5(walks["fig-8"]).verdict == NOT_REPRODUCED
    assert claim_fig_8(walks["fig-5"]).verdict == NOT_REPRODUCED
    assert claim_fig_9(walks["fig-11"], walks["fig-11"]).verdict == NOT_REPRODUCED
    assert claim_fig_11(walks["fig-9-without-small-pushes"]).verdict == NOT_REPRODUCED


def test_an_error_grows_with_the_divergent_rate(robot_70kg: sf.Robot) -> None:
    """Open loop: a push e^k times as large falls k / omega sooner."""
    falls = []
    for factor in (1.0, math.e**3):
        force = (factor * REPLAY_PUSH.force[0], 0.0)
        push = sf.Push(REPLAY_PUSH.start, REPLAY_PUSH.duration, force)
        falls.append(replay_fall(robot_70kg, 0.0, [push]))
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


def test_the_table_holds_every_set_of_assumptions_once(results: PaperResults) -> None:
    rows = limits_by_assumptions(results.limits)
    sets = math.prod(
        map(len, (one_step.HIPS, one_step.LEG_SPEEDS, one_step.OFFSET_WEIGHTS, one_step.PENALTIES))
    )
    assert len(rows) == 4 * sets
    assert len({words for words, _ in rows}) == len(rows)


def test_fewer_restrictions_never_lower_a_limit(results: PaperResults) -> None:
    """Excluding landings during the push can only take away."""
    limits = {dataclasses.replace(row, impulse=0.0): row.impulse for row in results.limits}
    for row, impulse in limits.items():
        if not row.lands_during_push:
            assert impulse <= limits[dataclasses.replace(row, lands_during_push=True)]


def test_the_limit_in_x_comes_out_under_named_assumptions(results: PaperResults) -> None:
    (first, *_) = nearest_limits(results.limits, 70.56, along_x=True)
    assert first.impulse == pytest.approx(70.56, abs=one_step.IMPULSE_STEP)
    assert math.isinf(first.leg_speed)
    assert not first.lands_during_push
    strict = nearest_limits([r for r in results.limits if r.nominal], 70.56, along_x=True)
    assert strict[0].impulse == pytest.approx(70.56, rel=0.03)


def test_one_set_of_assumptions_gives_both_limits(results: PaperResults) -> None:
    """Table 2 as printed, its bounds on d, and a leg that is fast but not infinitely so."""
    words, (x, y, _) = limits_by_assumptions(results.limits)[0]
    assert "hip 0.01 m" in words
    assert "|d| within its bounds" in words
    assert x == pytest.approx(70.56, rel=0.03)
    assert y == pytest.approx(58.8, rel=0.03)


def test_everything_is_the_same_the_second_time(
    results: PaperResults, pictures: dict[str, bytes], robot_70kg: sf.Robot
) -> None:
    again = paper_rollouts(robot_70kg)
    for name, walk in results.rollouts.items():
        assert np.array_equal(walk.observations, again[name].observations)
        assert np.array_equal(walk.commands, again[name].commands)
    repeated = dataclasses.replace(results, rollouts=again)
    for name, content in paper_report(robot_70kg, repeated).pictures().items():
        # Wall clock.
        if "decision-time" not in name:
            assert content == pictures[name], name


def test_the_report_holds_every_row_and_every_picture(
    report: Report, pictures: dict[str, bytes], results: PaperResults, robot_70kg, tmp_path: Path
) -> None:
    page, text, *drawn = report.write(tmp_path / "out")
    html, markdown = page.read_text(), text.read_text()
    for claim in results.claims:
        for words in (claim.ours, claim.why, claim.paper):
            assert words.replace("|", "\\|") in markdown
            assert str(markupsafe.escape(words)) in html
    rows = len(results.claims) + len(paper_parameters(robot_70kg))
    assert html.count('<th scope="row">') == rows + len(limits_table(results.limits).rows)
    # All but the decision time, which differs from run to run, are in the page.
    assert html.count("data:image/png;base64,") == len(PICTURES) - 1
    assert [path.stem for path in drawn] == list(PICTURES)
    for path in drawn:
        assert f"pictures/{path.name}" in markdown
        assert path.read_bytes()[:4] == b"\x89PNG"
    assert "nothing is random" in html
    assert sf.__version__ in html


def test_the_report_is_the_same_the_second_time(report: Report, tmp_path: Path) -> None:
    first, second = (report.write(tmp_path / name) for name in "ab")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]

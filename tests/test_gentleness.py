"""Small pushes are answered no more nervously than by the paper's method."""

from __future__ import annotations

import pytest

import surefoot as sf
from surefoot.studies.engine.pushed_walk import answer
from surefoot.studies.engine.study import Measured, run
from surefoot.studies.gentleness.question import Gentleness
from surefoot.studies.gentleness.show import gentleness_report, larger, numbers

TIMING = 5e-4
"""By how much more the time of a landing may change [s]."""


@pytest.fixture(scope="module")
def measured(robot: sf.Robot, tmp_path_factory: pytest.TempPathFactory) -> Measured[Gentleness]:
    study = Gentleness(robot, leg_speeds=(3.0,))
    return run(study, tmp_path_factory.mktemp("gentleness") / "out", workers=1)


def of(measured: Measured[Gentleness], impulse: float) -> list[dict]:
    return [row for row in measured.rows if row["impulse"] == impulse]


def values(rows: list[dict], key: str, quantity: str) -> list[float]:
    return [row[quantity] for row in rows if row["method"] == key]


def is_gentle(rows: list[dict], key: str, other: str) -> bool:
    """Whether a method moves ZMP and landing no further in any cell, and the time hardly."""
    times = zip(values(rows, key, "timing"), values(rows, other, "timing"), strict=True)
    return (
        larger(rows, key, other, "zmp_peak") == 0
        and larger(rows, key, other, "landing") == 0
        and all(mine <= theirs + TIMING for mine, theirs in times)
    )


def test_unified_is_never_less_gentle_than_the_hybrid(measured: Measured[Gentleness]) -> None:
    assert {row["impulse"] for row in measured.rows} == {5.0, 10.0, 20.0}
    for impulse in (5.0, 10.0, 20.0):
        rows = of(measured, impulse)
        assert len(values(rows, "unified", "zmp_peak")) == 16
        assert all(values(rows, "unified", "survived"))
        assert is_gentle(rows, "unified", "hybrid")
    # The law can fail: it does for the methods exchanged.
    assert not is_gentle(of(measured, 20.0), "hybrid", "unified")


def test_the_smallest_pushes_move_no_landing(measured: Measured[Gentleness]) -> None:
    assert max(values(of(measured, 5.0), "unified", "landing")) < 1e-9
    assert max(values(of(measured, 5.0), "unified", "timing")) < 1e-9


def test_without_comfort_it_is_not_gentle(robot: sf.Robot) -> None:
    push = sf.Push(1.1, 0.2, (25.0, 0.0))
    nervous = answer(sf.UnifiedController(robot, (0.5, 0.0), comfort=0.0), push)
    assert nervous.landing > 0.01 > answer(sf.UnifiedController(robot, (0.5, 0.0)), push).landing


def test_an_answer_is_measured_against_the_gait(robot: sf.Robot) -> None:
    none = answer(sf.UnifiedController(robot, (0.5, 0.0)), sf.Push(1.1, 0.2, (0.0, 0.0)))
    assert max(none.zmp_peak, none.zmp_rms, none.landing, none.timing) < 1e-9
    assert none.survived
    fallen = answer(sf.DcmTracking(robot, (0.5, 0.0)), sf.Push(1.1, 0.2, (400.0, 0.0)))
    assert not fallen.survived


def test_larger_counts_cells(robot: sf.Robot) -> None:
    study = Gentleness(robot, leg_speeds=(float("inf"),), impulses=(5.0,))
    rows = [
        {"leg_speed": float("inf"), "impulse": 5.0, "method": key, "angle": 0.0, "phase": phase,
         "zmp_peak": peak, "zmp_rms": 0.1, "landing": 0.1, "timing": 0.1}
        for key, phase, peak in (
            ("unified", 0.0, 0.1), ("unified", 0.5, 0.2), ("hybrid", 0.0, 0.2), ("hybrid", 0.5, 0.2)
        )
    ]  # fmt: skip
    assert larger(rows, "unified", "hybrid", "zmp_peak") == 0
    assert larger(rows, "hybrid", "unified", "zmp_peak") == 1
    (told,) = numbers(Measured(study, rows, [], {}))
    assert told["leg_speed"] is None
    assert told["methods"]["unified"]["zmp_peak"] == {"mean": pytest.approx(0.15), "largest": 0.2}
    assert told["unified_larger"]["zmp_peak"] == 0
    # What only one of them has answered is not compared.
    (told,) = numbers(Measured(study, rows[:3], [], {}))
    assert told["cells"] == 1
    assert numbers(Measured(study, rows[:2], [], {})) == []


def test_every_number_of_the_table_is_in_all_forms(measured: Measured[Gentleness]) -> None:
    report = gentleness_report(measured)
    for entry in numbers(measured):
        for own in entry["methods"].values():
            for quantity in own.values():
                words = f"{1e3 * quantity['mean']:.1f} {1e3 * quantity['largest']:6.1f}"
                assert words in report.markdown()
                assert words in report.html()

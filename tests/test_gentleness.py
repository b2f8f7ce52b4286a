"""Small pushes are answered no more nervously than by the paper's method."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

import surefoot as sf
from surefoot.cli import main
from surefoot.studies.gentleness.gentleness import (
    QUANTITIES,
    Answer,
    Gentleness,
    answer,
    gentleness,
)

TIMING = 5e-4
"""By how much more the time of a landing may change [s]."""


@pytest.fixture(scope="module")
def measured(robot: sf.Robot) -> list[Gentleness]:
    return gentleness(robot, leg_speeds=(3.0,))


def is_gentle(entry: Gentleness, key: str, other: str) -> bool:
    """Whether a method moves ZMP and landing no further in any cell, and the time hardly."""
    times = zip(entry.values(key, "timing"), entry.values(other, "timing"), strict=True)
    return (
        entry.larger(key, other, "zmp_peak") == 0
        and entry.larger(key, other, "landing") == 0
        and all(mine <= theirs + TIMING for mine, theirs in times)
    )


def test_unified_is_never_less_gentle_than_the_hybrid(measured: list[Gentleness]) -> None:
    assert [entry.impulse for entry in measured] == [5.0, 10.0, 20.0]
    for entry in measured:
        assert len(entry.answers["unified"]) == 16
        assert all(one.survived for one in entry.answers["unified"])
        assert is_gentle(entry, "unified", "hybrid")
    # The law can fail: it does for the methods exchanged.
    assert not is_gentle(measured[-1], "hybrid", "unified")


def test_the_smallest_pushes_move_no_landing(measured: list[Gentleness]) -> None:
    assert max(measured[0].values("unified", "landing")) < 1e-9
    assert max(measured[0].values("unified", "timing")) < 1e-9


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


def test_larger_counts_cells() -> None:
    low, high = Answer(0.1, 0.1, 0.1, 0.1, True), Answer(0.2, 0.1, 0.1, 0.1, True)
    entry = Gentleness(float("inf"), 5.0, {"one": (low, high), "other": (high, high)})
    assert (entry.larger("one", "other", "zmp_peak"), entry.larger("other", "one", "zmp_peak")) == (
        0,
        1,
    )
    numbers = entry.as_numbers()
    assert numbers["leg_speed"] is None
    assert numbers["methods"]["one"]["zmp_peak"] == {"mean": pytest.approx(0.15), "largest": 0.2}


def test_the_command_prints_the_table_and_the_numbers(measured: list[Gentleness]) -> None:
    arguments = ["gentleness", "--impulse", "10", "--leg-speed", "3"]
    words = CliRunner().invoke(main, arguments)
    assert words.exit_code == 0, words.output
    assert "Leg speed 3 m/s" in words.output
    assert "16 of 16" in words.output
    (told,) = json.loads(CliRunner().invoke(main, [*arguments, "--json"]).stdout)["gentleness"]
    assert told == measured[1].as_numbers()
    assert set(told["methods"]["unified"]) == set(QUANTITIES)
    assert f"{1e3 * told['methods']['hybrid']['landing']['mean']:.1f}" in words.output
    wrong = CliRunner().invoke(main, ["gentleness", "--leg-speed", "0"])
    assert wrong.exit_code == 2

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from push_comparison import METHODS, PROVENANCE, comparison, measured_rows
from surefoot.errors import ParameterError
from surefoot.rollout.outcome import RECOVERY_TIME, SETTLED_ROOM, SETTLED_VELOCITY
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import Choice, choose, share, survived, unbroken
from surefoot.studies.compare.show import (
    COLUMNS,
    LIMIT,
    cautions,
    comparison_report,
    comparison_table,
    note,
    protocol,
)
from surefoot.studies.engine.report import Table
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import select
from surefoot.studies.engine.words import angle_words, time_words

ROW = {
    "method": "a", "angle": 0.0, "phase": 0.0, "push_duration": 0.2, "leg_speed": 3.0,
    "impulse": 41.0, "delta_v": 0.6, "step": 1.0, "scanned": 41.0, "failure": "fell",
    "limit_point": 45.0, "limit_finite": 50.0, "limit_fixed": 9.0,
}  # fmt: skip
METHOD = {
    "key": "a", "label": "A", "source": "us", "adapts": "ZMP", "cannot": "step",
    "decision_p50": 1e-6, "decision_p99_9": 2e-6, "period": 1e-3,
}  # fmt: skip


@pytest.fixture(scope="module")
def measured() -> Measured[Comparison]:
    return comparison(measured_rows())


def one(**changes: Any) -> Measured[Comparison]:
    return comparison([{**ROW, **changes}], [METHOD], {})


def table(measured: Measured[Comparison], **choice: float) -> Table:
    chosen = choose(measured.rows, **choice)
    return comparison_table(measured, chosen.leg_speed, chosen)


def column(measured: Measured[Comparison], name: str, **choice: float) -> dict[str, str]:
    return {row[0]: row[COLUMNS.index(name)] for row in table(measured, **choice).rows}


@pytest.mark.parametrize(
    ("changes", "most", "fraction"),
    [
        ({}, 40.0, 0.8),
        ({"impulse": 42.5, "step": 2.5}, 40.0, 0.8),
        ({"impulse": 0.0}, 0.0, 0.0),
        ({"impulse": 70.0}, 69.0, 1.0),
        ({"impulse": math.inf, "failure": "none", "scanned": 30.0}, 30.0, 0.6),
        ({"impulse": np.float64(41.0)}, 40.0, 0.8),
    ],
)
def test_survived_is_one_step_below_what_fails(
    changes: dict[str, Any], most: float, fraction: float
) -> None:
    row = {**ROW, **changes}
    assert survived(row) == most
    assert share(row) == pytest.approx(fraction)


def test_a_share_is_of_the_limit_that_is_asked_for() -> None:
    assert share({**ROW, "limit_causal": 80.0}, "limit_causal") == 0.5
    assert math.isnan(share(ROW, "limit_causal"))
    assert math.isnan(share({**ROW, "limit_finite": 0.0}))
    assert share({**ROW, "survived_mean": 25.0}, survives="survived_mean") == 0.5


def test_a_mean_says_on_how_many_cells_it_stands(measured: Measured[Comparison]) -> None:
    for method in METHODS:
        rows, label = select(measured.rows, method=method["key"], leg_speed=3.0), method["label"]
        mean = 100.0 * sum(map(share, rows)) / len(rows)
        words = column(measured, "mean", leg_speed=3.0)[label]
        assert f"{mean:.0f} %" in words
        assert words.endswith("*") == (len(rows) < 192)
        count = column(measured, "cells", leg_speed=3.0)[label]
        assert count == ("192" if len(rows) == 192 else f"{len(rows)} of 192")
        worst = column(measured, "worst", leg_speed=3.0)[label]
        assert f"{100.0 * min(map(share, rows)):.0f} %" in worst


def test_a_lower_bound_is_marked() -> None:
    open_end = one(impulse=math.inf, failure="none", scanned=30.0)
    assert column(open_end, "mean") == {"A": "≥ 60 %", LIMIT: "100 %"}
    assert column(open_end, "forward [N s]")["A"] == "> 30"
    assert "≥" in note(open_end, choose(open_end.rows))
    assert column(one(), "mean")["A"] == "80 %"
    assert "≥" not in note(one(), choose(one().rows))


def test_what_was_not_measured_is_a_dash(measured: Measured[Comparison]) -> None:
    for name in ("mean", "worst", "forward [N s]", "fell", "unsettled"):
        assert column(measured, name, leg_speed=4.0)["Preview control"] == "–"
    assert column(measured, "cells", leg_speed=4.0)["Preview control"] == "0 of 192"
    back = column(measured, "back [N s]", leg_speed=3.0, phase=0.25)
    assert back["Capture point, swing to the point"] == "–"
    assert column(one(), "outward [N s]") == {"A": "–", LIMIT: "–"}


def test_smallest_failing_pushes_are_those_of_the_choice(measured: Measured[Comparison]) -> None:
    choice = {"leg_speed": 6.0, "push_duration": 0.4, "phase": 0.75}
    for name, angle in (("forward", 0.0), ("outward", 90.0), ("back", 180.0), ("inward", 270.0)):
        shown = column(measured, f"{name} [N s]", **choice)
        for method in METHODS:
            rows = select(measured.rows, method=method["key"], angle=angle, **choice)
            assert shown[method["label"]] == (f"{rows[0]['impulse']:g}" if rows else "–")
        (limit,) = {row["limit_finite"] for row in select(measured.rows, angle=angle, **choice)}
        assert shown[LIMIT] == f"{limit:.1f}"


def test_failures_are_counted_by_kind(measured: Measured[Comparison]) -> None:
    rows = select(measured.rows, method="step_location", leg_speed=3.0)
    unsettled = sum(row["failure"] == "unsettled" for row in rows)
    assert 0 < unsettled < len(rows)
    assert column(measured, "unsettled", leg_speed=3.0)["Step location only"] == str(unsettled)
    assert column(measured, "fell", leg_speed=3.0)["Step location only"] == str(
        len(rows) - unsettled
    )


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (2.1e-6, "2.1 µs"),
        (8e-7, "800 ns"),
        (9.1e-4, "910 µs"),
        (0.0123, "12.3 ms"),
        (1.5, "1.5 s"),
        (math.nan, "–"),
    ],
)
def test_times_have_the_unit_in_which_they_are_short(seconds: float, words: str) -> None:
    assert time_words(seconds) == words


def test_the_usual_choice() -> None:
    rows = measured_rows(4, 8)
    assert choose(rows) == Choice(3.0, 0.2, 0.5)
    unlimited = measured_rows(4, 1, (math.inf,), (0.4,))
    assert choose(unlimited) == Choice(math.inf, 0.4, 0.0)


def test_a_choice_must_have_been_measured(measured: Measured[Comparison]) -> None:
    with pytest.raises(ParameterError, match=r"`phase` that was measured: 0, 0\.125, .*; got 0\.3"):
        comparison_report(measured, Choice(3.0, 0.2, 0.3))
    with pytest.raises(
        ParameterError, match=r"`leg_speed` that was measured: .*; got 5\.0; choose"
    ):
        comparison_report(measured, Choice(5.0, 0.2, 0.5))


def test_the_protocol_says_what_the_code_does(measured: Measured[Comparison]) -> None:
    words = " ".join(protocol(measured.rows))
    assert f"within {RECOVERY_TIME:g}/ω" in words
    assert f"below {100.0 * SETTLED_ROOM:g} %" in words
    assert f"within {100.0 * SETTLED_VELOCITY:g} %" in words
    assert "steps of 1 N s" in words
    assert "at 2, 3, 4 and 6 m/s, and without limit" in words
    assert "8 directions, every 45°" in words


def test_holes_open_ends_and_passed_limits_are_told(measured: Measured[Comparison]) -> None:
    holes, open_ends = cautions(measured)
    assert "Preview control (48)" in holes
    assert "Hybrid of the paper" not in holes
    assert f"In {sum(map(unbroken, measured.rows))} cells nothing failed" in open_ends
    (beyond,) = cautions(one(impulse=70.0))
    assert "at most 69 N s against 50 N s" in beyond
    assert cautions(one()) == []


def test_the_report_says_it_all(measured: Measured[Comparison], tmp_path: Path) -> None:
    page, text, *pictures = comparison_report(measured).write(tmp_path / "out")
    assert (page.name, text.name) == ("compare.html", "compare.md")
    content = text.read_text()
    for heading in ("Leg speed 2 m/s", "Leg speed 6 m/s", "Unlimited leg speed", "Provenance"):
        assert f"## {heading}\n" in content
    for method in METHODS:
        for words in (method["label"], method["source"], method["cannot"]):
            assert words in content
    for key, value in PROVENANCE.items():
        assert f"| {key} | {value} |" in content
    linked = re.findall(r"!\[[^]]*\]\(([^)]+)\)", content)
    assert sorted(linked) == sorted(str(path.relative_to(tmp_path / "out")) for path in pictures)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in pictures)
    # The same comparison makes the same bytes.
    for path in comparison_report(measured).write(tmp_path / "again"):
        there = tmp_path / "out" / path.relative_to(tmp_path / "again")
        assert path.read_bytes() == there.read_bytes()


def test_the_papers_own_comparison_is_told_where_it_was_measured() -> None:
    rows = [
        {**ROW, "method": key, "impulse": impulse}
        for key, impulse in (("hybrid", 80.0), ("foot-placement-mpc", 40.0))
    ]
    methods = [{**METHOD, "key": row["method"]} for row in rows]
    report = comparison_report(comparison(rows, methods, {}))
    told = "forward 80 against 40 N s (ratio 2.00; the hybrid is ahead in 1 of 1 cells)"
    assert told in report.markdown()
    assert told in report.html({"pictures/shares.png": b""})


def test_the_report_says_where_robots_do_not_settle(measured: Measured[Comparison]) -> None:
    content = comparison_report(measured).markdown()
    own = select(measured.rows, method="step_location")
    unsettled = select(own, failure="unsettled")
    counted = len(select(unsettled, angle=180.0))
    found = re.search(r"\| Step location only \| (\d+) of (\d+) \| .*back \((\d+)\)", content)
    assert found is not None
    assert [int(value) for value in found.groups()] == [len(unsettled), len(own), counted]
    assert "Nowhere" in comparison_report(one()).markdown()


def test_directions_have_names() -> None:
    assert [angle_words(angle) for angle in (0.0, 90.0, 180.0, 270.0, 45.0)] == [
        "forward", "outward", "back", "inward", "45°",
    ]  # fmt: skip

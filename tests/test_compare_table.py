from __future__ import annotations

import io
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from push_comparison import METHODS, PROVENANCE, measured_rows
from surefoot.errors import FileError, ParameterError
from surefoot.rollout.outcome import RECOVERY_TIME, SETTLED_ROOM, SETTLED_VELOCITY
from surefoot.studies.compare.compare_report import compare_text, write_compare_report
from surefoot.studies.compare.compare_table import (
    COLUMNS,
    LIMIT,
    compare_table,
    print_compare_table,
)
from surefoot.studies.compare.compare_words import cautions, protocol
from surefoot.studies.compare.comparison import Choice, Comparison, choose, comparison
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
def measured() -> Comparison:
    return comparison(measured_rows(), METHODS, PROVENANCE)


def one(**changes: Any) -> Comparison:
    return comparison([{**ROW, **changes}], [METHOD], {})


def column(measured: Comparison, name: str, **choice: float) -> dict[str, str]:
    table = compare_table(measured, choose(measured, **choice))
    return {row[0]: row[COLUMNS.index(name)] for row in table.rows}


@pytest.mark.parametrize(
    ("changes", "survived", "fraction"),
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
    changes: dict[str, Any], survived: float, fraction: float
) -> None:
    (cell,) = one(**changes).cells
    assert cell.survived == survived
    assert cell.fraction == pytest.approx(fraction)


def test_a_mean_says_on_how_many_cells_it_stands(measured: Comparison) -> None:
    for method in measured.methods:
        cells = measured.select(method=method.key, leg_speed=3.0)
        mean = 100.0 * sum(cell.fraction for cell in cells) / len(cells)
        words = column(measured, "mean", leg_speed=3.0)[method.label]
        assert f"{mean:.0f} %" in words
        assert words.endswith("*") == (len(cells) < 192)
        count = column(measured, "cells", leg_speed=3.0)[method.label]
        assert count == ("192" if len(cells) == 192 else f"{len(cells)} of 192")
        worst = column(measured, "worst", leg_speed=3.0)[method.label]
        assert f"{100.0 * min(cell.fraction for cell in cells):.0f} %" in worst


def test_a_lower_bound_is_marked() -> None:
    open_end = one(impulse=math.inf, failure="none", scanned=30.0)
    assert column(open_end, "mean") == {"A": "≥ 60 %", LIMIT: "100 %"}
    assert column(open_end, "forward [N s]")["A"] == "> 30"
    assert "≥" in compare_table(open_end).note
    assert column(one(), "mean")["A"] == "80 %"
    assert "≥" not in compare_table(one()).note


def test_what_was_not_measured_is_a_dash(measured: Comparison) -> None:
    for name in ("mean", "worst", "forward [N s]", "fell", "unsettled"):
        assert column(measured, name, leg_speed=4.0)["Preview control"] == "–"
    assert column(measured, "cells", leg_speed=4.0)["Preview control"] == "0 of 192"
    back = column(measured, "back [N s]", leg_speed=3.0, phase=0.25)
    assert back["Capture point, swing to the point"] == "–"
    assert column(one(), "outward [N s]") == {"A": "–", LIMIT: "–"}


def test_smallest_failing_pushes_are_those_of_the_choice(measured: Comparison) -> None:
    choice = {"leg_speed": 6.0, "push_duration": 0.4, "phase": 0.75}
    for name, angle in (("forward", 0.0), ("outward", 90.0), ("back", 180.0), ("inward", 270.0)):
        shown = column(measured, f"{name} [N s]", **choice)
        for method in measured.methods:
            cells = measured.select(method=method.key, angle=angle, **choice)
            assert shown[method.label] == (f"{cells[0].impulse:g}" if cells else "–")
        (limit,) = {c.limit_finite for c in measured.select(angle=angle, **choice)}
        assert shown[LIMIT] == f"{limit:.1f}"


def test_failures_are_counted_by_kind(measured: Comparison) -> None:
    cells = measured.select(method="step_location", leg_speed=3.0)
    unsettled = sum(cell.failure == "unsettled" for cell in cells)
    assert 0 < unsettled < len(cells)
    assert column(measured, "unsettled", leg_speed=3.0)["Step location only"] == str(unsettled)
    assert column(measured, "fell", leg_speed=3.0)["Step location only"] == str(
        len(cells) - unsettled
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
    assert choose(comparison(rows, METHODS, {})) == Choice(3.0, 0.2, 0.5)
    unlimited = measured_rows(4, 1, (math.inf,), (0.4,))
    assert choose(comparison(unlimited, METHODS, {})) == Choice(math.inf, 0.4, 0.0)


@pytest.mark.parametrize("width", [80, 100, 170])
def test_the_terminal_shows_every_number_whatever_its_width(
    measured: Comparison, width: int
) -> None:
    stream = io.StringIO()
    print_compare_table(measured, Console(file=stream, width=width))
    printed = stream.getvalue()
    assert max(len(text.rstrip()) for text in printed.splitlines()) <= width
    for row in compare_table(measured).rows:
        for value in row[2:]:
            assert value in printed
    assert ("cycle p50" in printed.splitlines()[1]) == (width == 170)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"method": "b"}, r"expected `method` one of a; got 'b'; correct the row"),
        ({"angle": 360.0}, r"expected `angle` in \[0, 360\) deg; got 360.0; correct the row"),
        ({"phase": 1.0}, r"expected `phase` in \[0, 1\); got 1.0"),
        ({"impulse": math.nan}, "expected `impulse` of at least 0 N s"),
        ({"limit_finite": -1.0}, "expected `limit_finite` of at least 0 N s and finite; got -1.0"),
        ({"limit_finite": math.inf}, "expected `limit_finite` of at least 0 N s .*; got inf"),
        ({"failure": "slipped"}, "expected `failure` one of fell, unsettled, none; got 'slipped'"),
        ({"failure": "none"}, "expected an infinite `impulse` exactly where `failure` is none"),
        ({"speed": 3.0}, r"expected a row with the keys method, .*; got .*unknown \['speed'\]"),
    ],
)
def test_wrong_rows_are_told(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        one(**changes)


def test_wrong_sets_of_rows_are_told(measured: Comparison) -> None:
    with pytest.raises(ParameterError, match="expected each cell once"):
        comparison([ROW, ROW], [METHOD], {})
    with pytest.raises(ParameterError, match="expected each method once; got 'a' more than once"):
        comparison([ROW], [METHOD, METHOD], {})
    with pytest.raises(ParameterError, match="expected rows and methods; got 0 rows, 1 methods"):
        comparison([], [METHOD], {})
    other = {**ROW, "method": "b", "limit_finite": 51.0}
    with pytest.raises(ParameterError, match="expected the same limits for every method"):
        comparison([ROW, other], [METHOD, {**METHOD, "key": "b"}], {})
    with pytest.raises(ParameterError, match=r"missing \['label'\]"):
        comparison([ROW], [{k: v for k, v in METHOD.items() if k != "label"}], {})
    with pytest.raises(ParameterError, match=r"`phase` that was measured: 0, 0\.125, .*; got 0\.3"):
        compare_table(measured, Choice(3.0, 0.2, 0.3))


def test_the_protocol_says_what_the_code_does(measured: Comparison) -> None:
    words = " ".join(protocol(measured))
    assert f"within {RECOVERY_TIME:g}/ω" in words
    assert f"below {100.0 * SETTLED_ROOM:g} %" in words
    assert f"within {100.0 * SETTLED_VELOCITY:g} %" in words
    assert "steps of 1 N s" in words
    assert "at 2, 3, 4 and 6 m/s, and without limit" in words
    assert "8 directions, every 45°" in words


def test_holes_open_ends_and_passed_limits_are_told(measured: Comparison) -> None:
    holes, open_ends = cautions(measured)
    assert "Preview control (48)" in holes
    assert "Hybrid of the paper" not in holes
    assert f"In {sum(cell.unbroken for cell in measured.cells)} cells nothing failed" in open_ends
    (beyond,) = cautions(one(impulse=70.0))
    assert "at most 69 N s against 50 N s" in beyond
    assert cautions(one()) == []


def test_the_report_says_it_all(measured: Comparison, tmp_path: Path) -> None:
    remarks = ["The paper has 85 N s against 20 N s."]
    page, text, *pictures = write_compare_report(measured, tmp_path / "out", remarks)
    assert (page.name, text.name) == ("compare.html", "compare.md")
    content = text.read_text()
    assert remarks[0] in content
    assert remarks[0] in page.read_text()
    for heading in ("Leg speed 2 m/s", "Leg speed 6 m/s", "Unlimited leg speed", "Provenance"):
        assert f"## {heading}\n" in content
    for method in measured.methods:
        for words in (method.label, method.source, method.cannot):
            assert words in content
    for key, value in PROVENANCE.items():
        assert f"| {key} | {value} |" in content
    linked = re.findall(r"!\[[^]]*\]\(([^)]+)\)", content)
    assert sorted(linked) == sorted(str(path.relative_to(tmp_path / "out")) for path in pictures)
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in pictures)


def test_the_report_says_where_robots_do_not_settle(measured: Comparison) -> None:
    content = compare_text(measured)
    own = measured.select(method="step_location")
    unsettled = [cell for cell in own if cell.failure == "unsettled"]
    counted = sum(cell.angle == 180.0 for cell in unsettled)
    found = re.search(r"- Step location only: (\d+) of (\d+) cells; .*back \((\d+)\)", content)
    assert found is not None
    assert [int(value) for value in found.groups()] == [len(unsettled), len(own), counted]
    assert "Nowhere" in compare_text(one())


def test_a_table_of_the_report_has_one_text_for_each_column(measured: Comparison) -> None:
    table = compare_table(measured)
    assert all(len(row) == len(COLUMNS) for row in table.rows)
    header = next(line for line in compare_text(measured).splitlines() if "| adapts |" in line)
    assert header.count("|") == len(COLUMNS) + 1


def test_a_folder_that_cannot_be_written_is_told(measured: Comparison, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="expected a folder that can be written to"):
        write_compare_report(one(), tmp_path / "file")


def test_directions_have_names() -> None:
    assert [angle_words(angle) for angle in (0.0, 90.0, 180.0, 270.0, 45.0)] == [
        "forward", "outward", "back", "inward", "45°",
    ]  # fmt: skip

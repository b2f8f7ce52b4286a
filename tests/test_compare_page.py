"""The page of a comparison shows what was measured, as the reader chooses."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from playwright.sync_api import Page

from push_comparison import METHODS, PROVENANCE, comparison, measured_rows
from surefoot.studies.compare.page import page_data
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import choose, score, share, situation, survived, unbroken
from surefoot.studies.compare.show import comparison_report
from surefoot.studies.engine.report import embedded
from surefoot.studies.engine.scan import FAILURES
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import select, values


@pytest.fixture(scope="module")
def measured() -> Measured[Comparison]:
    return comparison(measured_rows())


@pytest.fixture(scope="module")
def path(measured: Measured[Comparison], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "compare.html"
    path.write_text(comparison_report(measured).html())
    return path


def row_of(page: Page, label: str) -> list[str]:
    """What the table says of a method."""
    rows = page.locator(".numbers tr").evaluate_all(
        "rows => rows.map(row => [...row.children].map(cell => cell.textContent))"
    )
    (row,) = [row for row in rows if row[0].startswith(label)]
    return row


def points(outline: str | None) -> list[tuple[float, ...]]:
    """The corners of a path."""
    return [tuple(map(float, pair.split(","))) for pair in re.split("[MLZ]", outline or "") if pair]


def test_what_is_embedded_is_what_was_measured(measured: Measured[Comparison]) -> None:
    number = {"inf": math.inf, "nan": math.nan}
    data = json.loads(embedded(page_data(measured, choose(measured.rows))))
    axes = {name: one["values"] for name, one in data["choices"].items()}
    speeds = [number.get(value, value) for value in axes["speed"]]
    assert speeds == values(measured.rows, "leg_speed")
    assert axes["phase"][-2:] == ["worst", "mean"]
    assert [one["chosen"] for one in data["choices"].values()] == [1, 1, 4]
    assert len(data["cells"]) == len(measured.rows)
    for row, entry in zip(measured.rows, data["cells"], strict=True):
        method, push, impulse, most, delta_v, failure = entry
        speed, duration, phase, angle, *limits = data["pushes"][push]
        assert data["methods"][method]["key"] == row["method"]
        assert situation(row) == (
            speeds[speed], axes["duration"][duration], axes["phase"][phase], data["angles"][angle],
        )  # fmt: skip
        assert number.get(impulse, impulse) == row["impulse"]
        assert number.get(delta_v, delta_v) == row["delta_v"]
        assert (most, FAILURES[failure]) == (survived(row), row["failure"])
        assert limits == [row[f"limit_{kind}"] for kind in ("point", "finite", "fixed", "causal")]


def test_sources_protocol_and_provenance_stand_below(path: Path) -> None:
    text = path.read_text()
    for words in ("impulse is scanned", *(entry["source"] for entry in METHODS),
                  *PROVENANCE.values()):  # fmt: skip
        assert words in text
    without_script = text[text.index("</figure>") : text.index("<script")]
    for heading in ("Leg speed 2 m/s", "Unlimited leg speed"):
        assert f"<h2>{heading}</h2>" in without_script
    assert without_script.count('<th scope="row">Hybrid of the paper</th>') == 6


@pytest.mark.parametrize("speed", [2.0, 3.0, math.inf])
def test_the_table_follows_the_leg_speed(
    path: Path, page: Page, measured: Measured[Comparison], speed: float
) -> None:
    page.goto(f"{path.as_uri()}#speed={speed:g}&duration=0.2&phase=0.25")
    rows = select(measured.rows, leg_speed=speed, push_duration=0.2, phase=0.25)
    for method in METHODS:
        own = {row["angle"]: row for row in select(rows, method=method["key"])}
        told = row_of(page, method["label"])
        failing = [
            "–" if angle not in own
            else f"> {own[angle]['scanned']:g}" if unbroken(own[angle])
            else f"{own[angle]['impulse']:g}"
            for angle in (0.0, 90.0, 180.0, 270.0)
        ]  # fmt: skip
        assert told[3:7] == failing
        shares = [share(row, "limit_causal") for row in own.values()]
        mean = f"{100.0 * math.fsum(shares) / len(shares):.0f} %" if shares else "–"
        assert told[-1].rstrip("*") == mean
        found = score(method["key"], rows)
        assert (f"{100.0 * found.mean:.0f} %" if own else "–") in told[1]
        assert told[1].endswith("*") == (0 < found.cells < found.possible)
    limits = [f"{row['limit_finite']:.1f}" for row in select(rows, method="unified")]
    assert row_of(page, "Theoretical limit")[3:7] == limits[::2]


def test_the_worst_phase_and_the_mean_over_phases(
    path: Path, page: Page, measured: Measured[Comparison]
) -> None:
    at = {"method": "hybrid", "leg_speed": 4.0, "push_duration": 0.1}
    rows = select(measured.rows, angle=0.0, **at)
    page.goto(f"{path.as_uri()}#speed=4&duration=0.1&phase=worst")
    assert row_of(page, "Hybrid")[3] == f"{min(row['impulse'] for row in rows):g}"
    page.get_by_label("mean", exact=True).check(force=True)
    mean = row_of(page, "Hybrid")
    assert mean[3] == f"{sum(row['impulse'] for row in rows) / len(rows):.1f}"
    every = select(measured.rows, **at)
    assert mean[1] == f"{100.0 * sum(map(share, every)) / len(every):.0f} %"


def test_only_chosen_methods_are_drawn_and_ranked(path: Path, page: Page) -> None:
    page.goto(f"{path.as_uri()}#speed=3&duration=0.2&phase=0.5&methods=hybrid,dcm_tracking")
    groups = page.locator("#map .method").evaluate_all("all => all.map(g => g.dataset.method)")
    assert sorted(groups) == ["1", "6"]
    finding = page.locator("#finding").text_content() or ""
    assert "Hybrid of the paper survives the most" in finding
    assert "DCM tracking follows" in finding
    assert "Unified" not in finding
    page.locator("#all").click()
    assert page.locator("#map .method").count() == len(METHODS)
    assert "methods=" not in page.url


def test_the_map_is_drawn_from_above_to_scale(
    path: Path, page: Page, measured: Measured[Comparison]
) -> None:
    page.goto(f"{path.as_uri()}#speed=3&duration=0.2&phase=0.5&methods=hybrid")
    shown, around = (
        points(page.locator(f"#map path.{kind}").get_attribute("d"))
        for kind in ("line", "limit.finite")
    )
    pushed = select(measured.rows, leg_speed=3.0, push_duration=0.2)
    largest = max(row["limit_finite"] for row in pushed)
    rows = select(pushed, method="hybrid", phase=0.5)
    for row, (x, y), outer in zip(rows, shown, around, strict=True):
        turn, radius = math.radians(row["angle"]), 200.0 * survived(row) / largest
        assert (x, y) == pytest.approx(
            (-radius * math.sin(turn), -radius * math.cos(turn)), abs=0.06
        )
        assert math.hypot(*outer) >= math.hypot(x, y)


@pytest.mark.parametrize("directions", [4, 72])
def test_few_and_many_directions_are_drawn(tmp_path: Path, page: Page, directions: int) -> None:
    found = comparison(measured_rows(directions, 1, (3.0,), (0.2,)))
    path = tmp_path / "compare.html"
    path.write_text(comparison_report(found).html())
    page.goto(path.as_uri())
    assert page.locator("#map .limit.finite").count() == (4 if directions == 4 else 1)
    assert (page.locator("#map .line.guide").count() > 0) == (directions == 4)
    assert "NaN" not in (page.locator("#map").inner_html())
    assert page.locator("#phase input").count() == 1


def test_arrow_keys_read_the_map(path: Path, page: Page, measured: Measured[Comparison]) -> None:
    page.goto(f"{path.as_uri()}#speed=3&duration=0.2&phase=0.5")
    for key in ("ArrowDown", "ArrowDown", "ArrowLeft", "ArrowLeft"):
        page.locator("#map").press(key)
    tip = (page.locator("#tip").text_content() or "").replace("\u00a0", " ")
    (row,) = select(
        measured.rows, method="hybrid", leg_speed=3.0, push_duration=0.2, phase=0.5, angle=90.0
    )
    assert "Hybrid of the paper, outward" in tip
    assert f"survives {survived(row):g} N s" in tip
    assert f"fell at {row['impulse']:g} N s ({row['delta_v']:.3f} m/s)" in tip
    page.locator("#map").press("Escape")
    assert page.locator("#tip").is_hidden()

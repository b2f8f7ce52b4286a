from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
from html.parser import HTMLParser
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from push_comparison import METHODS, PROVENANCE, comparison, measured_rows
from surefoot.studies.compare.page import SCRIPTS, page_data
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import (
    choose,
    score,
    select,
    share,
    situation,
    survived,
    unbroken,
    values,
)
from surefoot.studies.compare.show import comparison_report
from surefoot.studies.engine.scan import FAILURES
from surefoot.studies.engine.study import Measured

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no chromium to run the script in")


@pytest.fixture(scope="module")
def measured() -> Measured[Comparison]:
    return comparison(measured_rows())


@pytest.fixture(scope="module")
def page(measured: Measured[Comparison], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "compare.html"
    path.write_text(comparison_report(measured).html())
    return path


class Shown(HTMLParser):
    """What a page shows: rows of its tables by their id, and elements by theirs."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.words: dict[str, str] = {}
        self.checked: list[str] = []
        self._table = self._cell = False
        self._id = ""
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self._id = values.get("id") or self._id if tag != "p" else values.get("id") or ""
        if tag == "table":
            self._table = values.get("class") == "numbers"
        if self._table and tag == "tr":
            self.rows.append([])
        if self._table and tag in ("td", "th"):
            self.rows[-1].append("")
            self._cell = True

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th"):
            self._cell = False

    def handle_data(self, data: str) -> None:
        self.words[self._id] = self.words.get(self._id, "") + data
        if self._table and self._cell:
            self.rows[-1][-1] += data

    def row(self, label: str) -> list[str]:
        (row,) = [row for row in self.rows if row and row[0].startswith(label)]
        return row


def shown_by(page: Path, address: str = "") -> str:
    """The page after its script has run, in a browser."""
    assert BROWSER is not None
    done = subprocess.run(
        [
            BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom",
            f"--user-data-dir={page.parent / 'profile'}", f"{page.as_uri()}{address}",
        ],
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    return done.stdout


def data_of(text: str) -> Any:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    return json.loads(found.group(1))


def test_the_page_needs_nothing_else(page: Path) -> None:
    text = page.read_text()
    assert not re.search(r"https?:", text)
    assert not re.search(r"@import|url\(|<link|<iframe|fetch\(|XMLHttp|import\(", text)
    assert not re.search(r'\bsrc="(?!data:image/png;base64,)', text)
    assert "default-src 'none'" in text
    assert text.count("<!doctype html>") == 1


def test_what_is_embedded_is_what_was_measured(page: Path, measured: Measured[Comparison]) -> None:
    data = data_of(page.read_text())
    number = {"inf": math.inf, "nan": math.nan}
    speeds = [number.get(value, value) for value in data["speeds"]]
    assert speeds == values(measured.rows, "leg_speed")
    assert len(data["cells"]) == len(measured.rows)
    for row, entry in zip(measured.rows, data["cells"], strict=True):
        method, push, impulse, delta_v, step, scanned, failure = entry
        speed, duration, phase, angle, *limits = data["pushes"][push]
        assert data["methods"][method]["key"] == row["method"]
        assert situation(row) == (
            speeds[speed], data["durations"][duration], data["phases"][phase],
            data["angles"][angle],
        )  # fmt: skip
        assert number.get(impulse, impulse) == row["impulse"]
        assert number.get(delta_v, delta_v) == row["delta_v"]
        assert (step, scanned, FAILURES[failure]) == (row["step"], row["scanned"], row["failure"])
        assert limits == [row[f"limit_{kind}"] for kind in ("point", "finite", "fixed", "causal")]


def test_words_of_methods_and_remarks_are_escaped() -> None:
    nasty = "<b>&\"'</script>"
    methods = [{**entry, "label": nasty + entry["label"], "source": nasty} for entry in METHODS]
    found = comparison(measured_rows(4, 1, (3.0,), (0.2,)), methods, {"robot": nasty})
    text = comparison_report(found).html()
    assert "<b>" not in text
    assert text.count("</script>") == 1 + len(SCRIPTS)
    assert data_of(text)["methods"][0]["label"].startswith(nasty)


def test_every_id_that_the_script_asks_for_is_there_once(page: Path) -> None:
    text = page.read_text()
    asked = {"speed", "duration", "phase", "data"}
    for name in SCRIPTS:
        script = (files("surefoot.studies.compare") / name).read_text()
        asked |= set(re.findall(r'(?:byId|getElementById)\("([\w-]+)"\)', script))
    for name in asked - {"pick"}:
        assert len(re.findall(rf'\bid="{name}"', text)) == 1, name


def test_sources_protocol_and_provenance_stand_below(page: Path) -> None:
    text = page.read_text()
    for words in ("impulse is scanned", *(entry["source"] for entry in METHODS),
                  *PROVENANCE.values()):  # fmt: skip
        assert words in text
    without_script = text[text.index("</figure>") : text.index("<script")]
    for heading in ("Leg speed 2 m/s", "Unlimited leg speed"):
        assert f"<h2>{heading}</h2>" in without_script
    assert without_script.count('<th scope="row">Hybrid of the paper</th>') == 6


def test_the_page_opens_with_the_usual_choice(measured: Measured[Comparison]) -> None:
    assert page_data(measured, choose(measured.rows))["choice"] == {
        "speed": 1, "duration": 1, "phase": 4,
    }  # fmt: skip


@needs_browser
@pytest.mark.parametrize("speed", [2.0, 3.0, math.inf])
def test_the_table_follows_the_leg_speed(
    page: Path, measured: Measured[Comparison], speed: float
) -> None:
    shown = Shown(shown_by(page, f"#speed={speed:g}&duration=0.2&phase=0.25"))
    rows = select(measured.rows, leg_speed=speed, push_duration=0.2, phase=0.25)
    for method in METHODS:
        own = {row["angle"]: row for row in select(rows, method=method["key"])}
        told = shown.row(method["label"])
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
    assert shown.row("Theoretical limit")[3:7] == limits[::2]


@needs_browser
def test_the_worst_phase_and_the_mean_over_phases(
    page: Path, measured: Measured[Comparison]
) -> None:
    at = {"method": "hybrid", "leg_speed": 4.0, "push_duration": 0.1}
    rows = select(measured.rows, angle=0.0, **at)
    worst = Shown(shown_by(page, "#speed=4&duration=0.1&phase=worst")).row("Hybrid")
    assert worst[3] == f"{min(row['impulse'] for row in rows):g}"
    mean = Shown(shown_by(page, "#speed=4&duration=0.1&phase=mean")).row("Hybrid")
    assert mean[3] == f"{sum(row['impulse'] for row in rows) / len(rows):.1f}"
    every = select(measured.rows, **at)
    assert mean[1] == f"{100.0 * sum(map(share, every)) / len(every):.0f} %"


@needs_browser
def test_only_chosen_methods_are_drawn_and_ranked(page: Path) -> None:
    text = shown_by(page, "#speed=3&duration=0.2&phase=0.5&methods=hybrid,dcm_tracking")
    big = text[text.index('id="map"') : text.index('id="tip"')]
    assert sorted(re.findall(r'class="method" data-method="(\d)"', big)) == ["1", "6"]
    finding = Shown(text).words["finding"]
    assert "Hybrid of the paper survives the most" in finding
    assert "DCM tracking follows" in finding
    assert "Unified" not in finding


@needs_browser
def test_the_map_is_drawn_from_above_to_scale(page: Path, measured: Measured[Comparison]) -> None:
    text = shown_by(page, "#speed=3&duration=0.2&phase=0.5&methods=hybrid")
    big = text[text.index('id="map"') : text.index('id="tip"')]
    ((method_path,), (limit,)) = (
        re.findall(r'<path d="([^"]+)" class="line"', big),
        re.findall(r'<path d="([^"]+)" class="limit finite"', big),
    )
    points, around = (
        [tuple(map(float, pair.split(","))) for pair in re.split("[MLZ]", path) if pair]
        for path in (method_path, limit)
    )
    pushed = select(measured.rows, leg_speed=3.0, push_duration=0.2)
    largest = max(row["limit_finite"] for row in pushed)
    rows = select(pushed, method="hybrid", phase=0.5)
    for row, (x, y), outer in zip(rows, points, around, strict=True):
        turn, radius = math.radians(row["angle"]), 200.0 * survived(row) / largest
        assert (x, y) == pytest.approx(
            (-radius * math.sin(turn), -radius * math.cos(turn)), abs=0.06
        )
        assert math.hypot(*outer) >= math.hypot(x, y)


@needs_browser
@pytest.mark.parametrize("directions", [4, 72])
def test_few_and_many_directions_are_drawn(tmp_path: Path, directions: int) -> None:
    found = comparison(measured_rows(directions, 1, (3.0,), (0.2,)))
    path = tmp_path / "compare.html"
    path.write_text(comparison_report(found).html())
    text = shown_by(path)
    big = text[text.index('id="map"') : text.index('id="tip"')]
    assert big.count('class="limit finite"') == (4 if directions == 4 else 1)
    assert ('class="line guide"' in big) == (directions == 4)
    assert "NaN" not in big
    assert 'value="worst"' not in text


@needs_browser
def test_arrow_keys_read_the_map(
    page: Path, measured: Measured[Comparison], tmp_path: Path
) -> None:
    keys = """<script>for (const key of ["ArrowDown", "ArrowDown", "ArrowLeft", "ArrowLeft"])
      document.getElementById("map").dispatchEvent(new KeyboardEvent("keydown", {key}));</script>"""
    path = tmp_path / "keys.html"
    path.write_text(page.read_text().replace("</body>", f"{keys}</body>"))
    text = shown_by(path, "#speed=3&duration=0.2&phase=0.5").replace("&nbsp;", " ")
    tip = text[text.index('id="tip"') : text.index("</div>", text.index('id="tip"'))]
    (row,) = select(
        measured.rows, method="hybrid", leg_speed=3.0, push_duration=0.2, phase=0.5, angle=90.0
    )
    assert "Hybrid of the paper, outward" in tip
    assert f"survives {survived(row):g} N s" in tip
    assert f"fell at {row['impulse']:g} N s ({row['delta_v']:.3f} m/s)" in tip

"""Laws of both pages that draw themselves: one file, the same bytes, small, for every reader."""

from __future__ import annotations

import json
import re
from importlib.resources import files
from pathlib import Path

import pytest
from playwright.sync_api import Page

from made_up_map import arranged, made_up_rows
from push_comparison import METHODS, comparison, measured_rows
from surefoot.studies.compare.show import comparison_report
from surefoot.studies.engine.report import Report
from surefoot.studies.push_map.show import page_data, report

NASTY = "<b>&\"'</script>"


def map_report() -> Report:
    return report(arranged(made_up_rows()))


def compare_report() -> Report:
    methods = [{**entry, "label": NASTY + entry["label"], "source": NASTY} for entry in METHODS]
    rows = measured_rows(8, 2, (3.0, float("inf")), (0.2,))
    return comparison_report(comparison(rows, methods, {"robot": NASTY}))


@pytest.fixture(scope="module", params=[map_report, compare_report], ids=["push_map", "compare"])
def path(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(request.param().html())
    assert request.param().html() == path.read_text()
    return path


def test_a_page_needs_nothing_else(path: Path) -> None:
    text = path.read_text()
    assert not re.search(r"https?:", text)
    assert not re.search(r"@import|url\(|<link|<iframe|fetch\(|XMLHttp|import\(", text)
    assert not re.search(r'\bsrc="(?!data:image/png;base64,)', text)
    assert "default-src 'none'" in text
    assert text.count("<!doctype html>") == 1


def test_words_are_escaped_and_data_cannot_end_the_script(path: Path) -> None:
    text = path.read_text()
    assert "<b>" not in text
    assert text.count("</script>") == 3
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    assert "choices" in json.loads(found[1])


@pytest.mark.parametrize("study", ["compare", "push_map"])
def test_every_id_that_a_script_asks_for_is_there_once(study: str) -> None:
    markup, own, shared = (
        (files("surefoot.studies") / home / f"page.{kind}").read_text()
        for home, kind in ((study, "html"), (study, "js"), ("engine", "js"))
    )
    asked = set(re.findall(r'byId\("([\w-]+)"\)', own + shared)) - {"pick", "data"}
    assert len(asked) > 5
    for name in asked:
        assert len(re.findall(rf'\bid="{name}"', markup)) == 1, name


def test_a_telephone_shows_it_all(path: Path, page: Page) -> None:
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(path.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    for picture in page.locator("figure svg").all():
        box = picture.bounding_box()
        assert box is not None
        assert box["width"] > 300 or "0 0 30 14" in (picture.get_attribute("viewBox") or "")


def test_a_choice_stands_behind_the_address(path: Path, page: Page) -> None:
    page.goto(f"{path.as_uri()}#phase=0.52")
    assert "phase=0.5" in page.url
    before = page.locator("#map-caption").text_content()
    page.evaluate("location.hash = 'phase=0&show=steps'")
    page.wait_for_function("!location.hash.includes('0.5')")
    assert page.locator("#map-caption").text_content() != before


def test_a_map_of_every_impulse_on_the_usual_grid_stays_below_3_megabytes() -> None:
    numbers = arranged(made_up_rows())
    whole = len(report(numbers).html())
    walks = sum(len(page_data(numbers)[name]) for name in ("gap", "code", "margin")) / numbers.walks
    assert whole + 250_000 * walks < 3e6

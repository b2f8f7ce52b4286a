"""The page and the pictures of a push map: what they show is what was measured."""

from __future__ import annotations

import base64
import io
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from playwright.sync_api import Page, expect
from rich.console import Console

from figure_artists import one
from made_up_map import arranged, made_up_rows
from surefoot.errors import ParameterError
from surefoot.studies.push_map.map_numbers import MapNumbers, finding, protocol, summary
from surefoot.studies.push_map.measure import FELL
from surefoot.studies.push_map.pictures import heat_figure, polar_figure
from surefoot.studies.push_map.show import page_data, report

FILES = ["push-map.html", "push-map.md", "push-map.png", "push-map-polar.png"]


@pytest.fixture(scope="module")
def numbers() -> MapNumbers:
    return arranged(made_up_rows())


@pytest.fixture(scope="module")
def path(numbers: MapNumbers, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    assert [one.name for one in report(numbers).write(folder)] == FILES
    return folder / "push-map.html"


def test_rows_are_arranged_by_phase_and_direction(numbers: MapNumbers) -> None:
    rows = made_up_rows()
    assert numbers.walks == sum(len(row["impulses"]) for row in rows)
    for row in rows:
        place = list(numbers.phases).index(row["phase"]), list(numbers.angles).index(row["angle"])
        assert numbers.share[place] == row["survived"] / row["limit"]
        places = [round(j / 2.0) for j in row["impulses"]]
        assert numbers.fate[place][places].tolist() == row["fate"]
        assert (numbers.fate[place] >= 0).sum() == len(places)
    assert numbers.everywhere == 4.0 * math.floor(numbers.survived.min() / 4.0)
    steps = numbers.at(numbers.recovery_steps, 60.0)
    assert np.array_equal(np.isnan(steps), numbers.impulse <= 60.0)


def test_half_a_map_is_refused() -> None:
    with pytest.raises(ParameterError, match="got 31 rows of 4 phases and 8 directions"):
        arranged(made_up_rows()[1:])
    with pytest.raises(ParameterError, match="one row for each phase and direction"):
        arranged([])


def test_words_say_what_the_numbers_are(numbers: MapNumbers) -> None:
    found = summary(numbers)
    assert found["cells"] == 32
    assert found["cells_with_holes"] == 1
    assert found["fraction_worst"] == pytest.approx(float(numbers.share.min()))
    assert "In 1 of 32 cells" in finding(numbers)
    assert "narrower than 4 N s, may have been missed" in " ".join(protocol(numbers.study))
    full = arranged(made_up_rows(), coarse=2.0)
    assert "Every impulse was walked" in " ".join(protocol(full.study))
    assert "missed" not in " ".join(protocol(full.study))


def test_what_is_packed_is_what_was_measured(numbers: MapNumbers) -> None:
    data = page_data(numbers)
    count, gap, code, margin = (
        np.frombuffer(base64.b64decode(data[name]), kind)
        for name, kind in (("count", "<u2"), ("gap", "u1"), ("code", "u1"), ("margin", "<i2"))
    )
    ends = np.cumsum(count)
    for row, end, walks in zip(made_up_rows(), ends, count, strict=True):
        own = slice(end - walks, end)
        assert np.array_equal(2.0 * np.cumsum(gap[own].astype(int)), row["impulses"])
        assert (code[own] >> 6).tolist() == row["fate"]
        steps = [63 if steps < 0 else steps for steps in row["recovery_steps"]]
        assert (code[own] & 63).tolist() == steps
        assert 1e-4 * margin[own] == pytest.approx(row["margin"], abs=6e-5)


def test_a_reader_without_scripts_sees_the_axes_at_every_phase(
    numbers: MapNumbers, path: Path
) -> None:
    for text in (path.read_text(), path.with_suffix(".md").read_text()):
        for row in range(4):
            for way in range(0, 8, 2):
                assert f"{numbers.survived[row, way]:g} of {numbers.limit[row, way]:.1f}" in text


def test_a_cell_is_told_in_words(path: Path, page: Page, numbers: MapNumbers) -> None:
    page.goto(f"{path.as_uri()}#show=share&phase=0.25&angle=180&impulse=40")
    said = page.locator("#said")
    expect(said).to_contain_text("Pushed back (180°) at 0.25 of the step")
    expect(said).to_contain_text(f"survives {numbers.survived[1, 4]:g}\u00a0N\u00a0s")
    expect(said).to_contain_text(f"falls at {numbers.impulse[1, 4]:g}\u00a0N\u00a0s")
    expect(said).to_contain_text(f"which makes {100.0 * numbers.share[1, 4]:.0f} %")
    margin, steps = 100.0 * numbers.margin[1, 4, 20], numbers.recovery_steps[1, 4, 20]
    expect(said).to_contain_text(f"within {steps} steps, with a margin of {margin:g} cm")
    assert page.locator("#map rect.cell").count() == numbers.share.size
    assert page.locator("#scan rect.fate").count() == (numbers.fate[1, 4] >= 0).sum()
    assert page.locator("#map .hole").count() == 1


def test_keys_sliders_and_clicks_choose_the_same_cell(path: Path, page: Page) -> None:
    page.goto(f"{path.as_uri()}#show=survived&phase=0&angle=0&impulse=8")
    expect(page.locator("#said")).to_contain_text("Pushed forward (0°) at 0 of the step")
    expect(page.locator("#said")).to_contain_text("does not settle at")
    for key in ("ArrowLeft", "ArrowUp", "ArrowUp", "ArrowUp", "ArrowUp"):
        page.locator("#map").press(key)
    expect(page.locator("#said")).to_contain_text("Pushed towards 315° at 0.75 of the step")
    assert page.locator("#angle").input_value() == "7"
    for words in ("Impulse [N s], of steps and margin", "Phase of the step", "Direction"):
        assert page.get_by_role("slider", name=words, exact=True).count() == 1
    page.locator("#angle").press("Home")
    page.locator("#phase").press("ArrowLeft")
    expect(page.locator("#said")).to_contain_text("Pushed forward (0°) at 0.5 of the step")
    cell = page.locator("#map rect.cell").nth(8 * 2 + 2)
    box = cell.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    expect(page.locator("#tip")).to_contain_text("outward (90°), 0.5 of the step")
    page.mouse.down()
    page.mouse.up()
    expect(page.locator("#said")).to_contain_text("A harder push than that is survived again")
    assert "angle=90" in page.url
    expect(page.locator("#polar-caption")).to_contain_text("at 0.5 of the step")


def test_colours_follow_the_impulse(path: Path, page: Page, numbers: MapNumbers) -> None:
    page.goto(f"{path.as_uri()}#show=steps&phase=0&angle=0&impulse=60")
    lost = page.locator("#map rect.cell.lost").count()
    assert lost == np.isnan(numbers.at(numbers.recovery_steps, 60.0)).sum()
    page.locator("#impulse").press("End")
    assert page.locator("#map rect.cell.beyond").count() == (numbers.limit < 128.0).sum()
    page.locator("#impulse").press("Home")
    assert page.locator("#map rect.cell.lost, #map rect.cell.beyond").count() == 0
    page.get_by_label("Margin", exact=True).check(force=True)
    expect(page.locator("#map-caption")).to_contain_text("Margin under 0\u00a0N\u00a0s [cm]")
    page.get_by_label("Largest survived impulse", exact=True).check(force=True)
    fills = [rect.get_attribute("fill") for rect in page.locator("#map rect.cell").all()]
    most = int(np.argmax(numbers.survived))
    assert fills[most] == "rgb(253,231,37)"


def test_the_polar_map_is_drawn_from_above_to_scale(
    path: Path, page: Page, numbers: MapNumbers
) -> None:
    page.goto(f"{path.as_uri()}#phase=0.5&angle=90&impulse=8")
    outline = page.locator("#polar path.survived").get_attribute("d") or ""
    points = [tuple(map(float, pair.split(","))) for pair in re.split("[MLZ]", outline) if pair]
    highest = max(float(numbers.limit.max()), 2.0 * (numbers.fate.shape[2] - 1))
    for angle, survived, (x, y) in zip(numbers.angles, numbers.survived[2], points, strict=True):
        turn, radius = math.radians(angle), 200.0 * survived / highest
        at = (-radius * math.sin(turn), -radius * math.cos(turn))
        assert (x, y) == pytest.approx(at, abs=0.06)


def test_heat_maps_show_the_numbers(numbers: MapNumbers) -> None:
    figure = heat_figure(numbers)
    for key, values in (
        ("survived", numbers.survived), ("share", 100.0 * numbers.share),
        ("steps", numbers.at(numbers.recovery_steps, numbers.everywhere)),
        ("margin", 100.0 * numbers.at(numbers.margin, numbers.everywhere)),
    ):  # fmt: skip
        assert np.allclose(one(figure, f"heat-{key}").get_array(), values)
        assert one(figure, f"holes-{key}").get_xydata().tolist() == [[90.0, 0.5]]
    assert "[N s]" in figure.axes[0].get_title(loc="left")


def test_polar_maps_show_the_limit_around(numbers: MapNumbers) -> None:
    figure = polar_figure(numbers)
    for row, phase in enumerate(numbers.phases):
        for name, values in (("limit", numbers.limit), ("survived", numbers.survived)):
            line = one(figure, f"{name}-{phase:g}")
            assert np.allclose(line.get_ydata()[:-1], values[row])
            assert np.allclose(line.get_xdata()[:-1], np.radians(numbers.angles))


@pytest.mark.parametrize("draw", [heat_figure, polar_figure])
def test_the_words_over_a_picture_stay_inside_and_apart(draw: Any, numbers: MapNumbers) -> None:
    figure = draw(numbers)
    renderer = FigureCanvasAgg(figure).get_renderer()
    boxes = [text.get_window_extent(renderer) for text in figure.texts]
    assert len(boxes) > 2
    assert all(box.x1 < figure.bbox.x1 for box in boxes)
    below = [ax._left_title.get_window_extent(renderer) for ax in figure.axes]  # type: ignore[attr-defined]
    assert min(box.y0 for box in boxes) > max(box.y1 for box in below)


@pytest.mark.parametrize(("directions", "phases"), [(1, 1), (2, 1), (5, 7)])
def test_small_and_odd_maps_are_drawn(directions: int, phases: int, tmp_path: Path) -> None:
    rows = made_up_rows(directions, phases)
    rows[0] |= {
        "impulse": 0.0,
        "survived": 0.0,
        "fraction": 0.0,
        "fate": [FELL] * len(rows[0]["fate"]),
    }
    shown = report(arranged(rows, directions=directions, phases=phases))
    assert len(shown.write(tmp_path)) == len(FILES)
    said = io.StringIO()
    shown.print(Console(file=said))
    assert "forward" in said.getvalue()

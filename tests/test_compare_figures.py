from __future__ import annotations

import math
import re
from functools import partial
from typing import Any

import numpy as np
import pytest
from matplotlib import rc_context, style
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from figure_artists import assert_words_stand_apart, drawn, line
from push_comparison import METHODS, comparison, measured_rows
from surefoot.errors import ParameterError
from surefoot.show import palette
from surefoot.show.palette import mark
from surefoot.studies.compare.figures import fraction_figure, polar_figure
from surefoot.studies.compare.question import Comparison
from surefoot.studies.compare.scores import score, survived, unbroken
from surefoot.studies.engine.report import Figure as Drawn
from surefoot.studies.engine.study import Measured
from surefoot.studies.engine.table import select, values


def measured(directions: int = 8, phases: int = 8, **options: Any) -> Measured[Comparison]:
    options = {"speeds": (3.0, math.inf), "durations": (0.2,), **options}
    return comparison(measured_rows(directions, phases, **options))


@pytest.fixture(scope="module")
def eight() -> tuple[Measured[Comparison], Figure]:
    found = measured()
    with style.context(["default", palette.STYLE]):
        figure = polar_figure(found)
        figure.draw_without_rendering()
    return found, figure


def test_there_is_one_map_for_each_phase(eight: tuple[Measured[Comparison], Figure]) -> None:
    found, figure = eight
    titles = [ax.get_title(loc="left") for ax in figure.axes]
    assert titles == [f"phase {phase:.3g}" for phase in values(found.rows, "phase")]
    assert len({ax.get_ylim() for ax in figure.axes}) == 1


def test_radii_are_what_was_survived(eight: tuple[Measured[Comparison], Figure]) -> None:
    found, figure = eight
    for row in select(found.rows, leg_speed=3.0):
        key, phase, angle = row["method"], row["phase"], row["angle"]
        expected = pytest.approx((math.radians(angle), survived(row)))
        points = line(figure, f"{key}-{phase:g}")
        assert points[np.argmin(np.abs(points[:, 0] - math.radians(angle)))] == expected
        ((turn, radius),) = line(figure, f"{key}-{phase:g}-{angle:g}")
        assert (turn, radius) == expected


def test_forward_is_up_and_outward_is_left(eight: tuple[Measured[Comparison], Figure]) -> None:
    _, figure = eight
    ax = figure.axes[0]
    centre = ax.transData.transform((0.0, 0.0))
    ways = {"forward": (0, 1), "outward": (-1, 0), "back": (0, -1), "inward": (1, 0)}
    for index, (name, way) in enumerate(ways.items()):
        there = ax.transData.transform((index * math.pi / 2.0, 10.0)) - centre
        assert there / np.hypot(*there) == pytest.approx(way, abs=1e-9)
        label = drawn(figure, f"direction-{name}")[0]
        shift = label.get_window_extent().get_points().mean(axis=0) - centre
        assert np.dot(shift, way) > 0.9 * np.hypot(*shift)


@pytest.mark.parametrize("directions", [8, 72])
def test_the_limit_encloses_every_method(directions: int) -> None:
    found = measured(directions, 2)
    figure = polar_figure(found)
    for phase in values(found.rows, "phase"):
        outer = line(figure, f"limit-finite-{phase:g}")
        assert len(outer) == directions + 1
        assert outer[0, 1] == outer[-1, 1]
        assert (line(figure, f"limit-point-{phase:g}")[:, 1] <= outer[:, 1]).all()
        for method in METHODS:
            if drawn(figure, re.escape(f"{method['key']}-{phase:g}")):
                inner = line(figure, f"{method['key']}-{phase:g}")[:, 1]
                assert (inner[np.isfinite(inner)] <= outer[np.isfinite(inner), 1]).all()


def test_four_directions_claim_nothing_in_between() -> None:
    found = measured(4, 1)
    figure = polar_figure(found)
    assert drawn(figure, "limit-finite-0") == []
    assert len(drawn(figure, r"limit-finite-0-[\d.]+")) == 4
    for method in METHODS:
        (guide,) = drawn(figure, re.escape(f"{method['key']}-0"))
        assert guide.get_linestyle() not in ("-", "solid")
        assert guide.get_linewidth() < 1.0
        assert len(drawn(figure, rf"{method['key']}-0-[\d.]+")) == 4
    assert "what the sole adds" not in [text.get_text() for text in figure.legends[0].texts]


def test_what_was_not_measured_is_a_gap_and_is_named(
    eight: tuple[Measured[Comparison], Figure],
) -> None:
    _, figure = eight
    assert np.isnan(line(figure, "capture_point-0.25")[:, 1]).sum() == 2
    assert not drawn(figure, r"capture_point-0\.25-(135|180)")
    assert not np.isnan(line(figure, "capture_point-0.5")).any()
    assert drawn(figure, r"preview-0\.25") == []
    (note,) = drawn(figure, r"absent-0\.25")
    assert note.get_text() == "not measured: Preview control"
    assert drawn(figure, r"absent-0\.5") == []


def test_markers_tell_how_a_push_failed() -> None:
    found = measured(8, 1)
    figure = polar_figure(found, leg_speed=math.inf)
    kinds = {"fell": 0, "unsettled": 0, "none": 0}
    for row in select(found.rows, leg_speed=math.inf):
        name = f"{row['method']}-0-{row['angle']:g}"
        (marker,) = drawn(figure, re.escape(name))
        hollow = to_hex(marker.get_markerfacecolor()) == "#ffffff"
        assert hollow == (row["failure"] == "unsettled")
        assert bool(drawn(figure, f"{name}-open")) == unbroken(row)
        kinds[row["failure"]] += 1
    assert min(kinds.values()) > 0
    legend = [text.get_text() for text in figure.legends[0].texts]
    assert {"did not settle", "nothing failed so far"} <= set(legend)


def test_the_title_says_robot_leg_speed_and_duration(
    eight: tuple[Measured[Comparison], Figure],
) -> None:
    found, figure = eight
    assert figure.get_suptitle().split("  ·  ") == [
        "paper-biped", "leg speed 3 m/s", "pushes of 0.2 s",
    ]  # fmt: skip
    unlimited = polar_figure(found, leg_speed=math.inf).get_suptitle()
    assert "unlimited leg speed" in unlimited


@pytest.mark.parametrize("shape", [(8, 8), (72, 2), (4, 4), (8, 1), (4, 3)])
def test_words_of_a_map_do_not_overlap(shape: tuple[int, int]) -> None:
    with style.context(["default", palette.STYLE]):
        figure = polar_figure(measured(*shape))
        figure.draw_without_rendering()
    words = drawn(figure, "direction-.*|absent-.*") + figure.legends[0].get_texts()
    words += [ax._left_title for ax in figure.axes] + figure.texts
    assert_words_stand_apart(figure, words)


MANY = 40
"""More methods than anybody compares."""


def test_every_method_has_a_mark_of_its_own() -> None:
    marks = [mark(index) for index in range(MANY)]
    assert len({how.outline for how in marks}) == MANY
    assert len({(how.colour, how.dashed) for how in marks}) == MANY
    assert len({(how.dark, how.dashed) for how in marks}) == MANY


def luminance(colour: str) -> float:
    parts = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    r, g, b = (p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts)
    return 0.2126 * r + 0.7152 * g + 0.0722 * b


@pytest.mark.parametrize("how", [mark(n) for n in range(MANY)], ids=lambda how: how.colour)
def test_marks_stand_out_from_their_ground(how: Any) -> None:
    assert 1.05 / (luminance(how.colour) + 0.05) > 3.0
    assert (luminance(how.dark) + 0.05) / (luminance("#14171a") + 0.05) > 3.0


def test_shares_and_times_are_those_measured() -> None:
    found = measured()
    figure = fraction_figure(found)
    for method in METHODS:
        key = method["key"]
        for speed in values(found.rows, "leg_speed"):
            own = score(key, select(found.rows, leg_speed=speed))
            if not own.cells:
                (word,) = drawn(figure, f"absent-{key}-{speed:g}")
                assert word.get_text() == "not measured"
                continue
            for kind, share in (("mean", own.mean), ("worst", own.worst)):
                shown = line(figure, f"{kind}-{key}-{speed:g}")[0, 0]
                assert shown == pytest.approx(100.0 * share)
            partial = drawn(figure, f"partial-{key}-{speed:g}")
            assert [text.get_text() for text in partial] == (
                [] if own.complete else [f"{own.cells} of {own.possible}"]
            )
        assert line(figure, f"p50-{key}")[0, 0] == method["decision_p50"]
        assert line(figure, f"p99.9-{key}")[0, 0] == method["decision_p99_9"]
    assert figure.axes[-1].get_xscale() == "log"


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
def test_the_same_comparison_gives_the_same_bytes(ending: str) -> None:
    found = measured(4, 2)
    for draw in (polar_figure, fraction_figure):
        picture = Drawn(f"picture.{ending}", "", partial(draw, found))
        data = picture.content()
        with rc_context({"axes.facecolor": "black", "font.size": 30.0}):
            assert picture.content() == data
        assert not re.search(rb"Date|Creation", data)


def test_wrong_choices_are_told() -> None:
    found = measured(4, 1)
    with pytest.raises(ParameterError, match=r"`push_duration` that was measured: 0\.2; got 0\.5"):
        polar_figure(found, push_duration=0.5)
    rows = measured_rows(4, 1, (3.0,), (0.2,)) + measured_rows(4, 1, (6.0,), (0.4,))
    with pytest.raises(ParameterError, match=r"measured together; got 3 m/s and 0\.4 s; choose"):
        polar_figure(comparison(rows), 3.0, 0.4)

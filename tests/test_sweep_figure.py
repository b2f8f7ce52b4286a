"""The picture of a sweep: every kind of table, what has no number, and what is said about it."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import rc_context, style
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from figure_artists import assert_words_stand_apart, drawn, line
from surefoot.errors import FileError, ParameterError
from surefoot.robot.gait import GaitLimits, Swing
from surefoot.robot.robot import Foot, Trunk, load_robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.show import palette
from surefoot.studies.engine.study import Measured
from surefoot.studies.sweep.axes import column, wilson
from surefoot.studies.sweep.parameters import parameters
from surefoot.studies.sweep.pictures import draw_sweep, sweep_figure
from surefoot.studies.sweep.question import Sweep

ANGLES = [0.0, 90.0, 180.0, 270.0]
GAIN, ANGLE, LEG = "controller.dcm_gain", "push.angle", "controller.knows_leg"


def limits(gains: list[Any], angles: list[float] = ANGLES) -> list[dict[str, Any]]:
    """A table of push limits; the second gain is refused, nothing fails at the last angle."""
    rows: list[dict[str, Any]] = []
    for i, gain in enumerate(gains):
        for angle in angles:
            row = {GAIN: gain, ANGLE: angle, "outcome": "measured", "impulse": 50.0 + i + angle,
                   "failure": "fell", "limit": 60.0 + angle, "error": None}  # fmt: skip
            if i == 1:
                row |= {"outcome": "refused", "impulse": math.nan, "limit": None, "error": "no"}
            elif angle == angles[-1]:
                row |= {"impulse": math.inf, "failure": "none"}
            rows.append(row)
    return rows


def walks(count: int = 200) -> list[dict[str, Any]]:
    """Drawn walks: whoever is pushed with more than 50 N s falls, whatever the gain."""
    rng = np.random.default_rng(0)
    rows: list[dict[str, Any]] = []
    for _ in range(count):
        impulse, gain = rng.uniform(0.0, 100.0), math.exp(rng.uniform(0.0, 4.0))
        stood = impulse < 50.0
        rows.append(
            {"push.impulse": impulse, GAIN: gain, LEG: rng.choice([True, False]).item(),
             "outcome": "recovered" if stood else "fell", "survived": stood,
             "recovery_steps": 3 if stood else -1, "dcm_error": 0.001 * impulse, "error": None}
        )  # fmt: skip
    return rows


def table(rows: list[dict[str, Any]], *varied: str, sampling: Any = "grid") -> Measured[Sweep]:
    """What a study with these rows has measured."""
    study = Sweep(
        title="What happens?", measures="push-limit" if "impulse" in rows[0] else "walk",
        robot=load_robot("paper-biped"), source="paper-biped", controller="unified",
        sampling=sampling, samples=1, seed=0, step=1.0,
        fixed={}, vary={name: [] for name in varied},
    )  # fmt: skip
    return Measured(study, rows, [], {"robot": "paper-biped"})


def made(rows: list[dict[str, Any]], *varied: str, name: str | None = None, **more: Any) -> Figure:
    with style.context(["default", palette.STYLE]):
        figure = sweep_figure(table(rows, *varied, **more), name)
        figure.draw_without_rendering()
    return figure


def test_one_parameter_is_a_line_over_its_values() -> None:
    rows = [row for row in limits([1.0, 3.0, 9.0, 27.0]) if row[ANGLE] == 0.0]
    figure = made(rows, GAIN)
    ax = figure.axes[0]
    assert ax.get_xscale() == "log"
    assert ax.get_xlabel() == "controller.dcm_gain [1/s]"
    assert ax.get_ylabel() == "smallest push that fails [N s]"
    points = line(figure, "line-")
    assert points[:, 0] == pytest.approx([1.0, 3.0, 9.0, 27.0])
    assert points[[0, 2, 3], 1] == pytest.approx([50.0, 52.0, 53.0])
    assert np.isnan(points[1, 1])
    assert line(figure, "missing-refused-")[:, 0] == pytest.approx([3.0])
    assert line(figure, "limit-")[0, 1] == 60.0


def test_two_parameters_are_lines_with_words() -> None:
    figure = made(limits([1.0, 2.0, 3.0]), GAIN, ANGLE)
    assert figure.axes[0].get_xscale() == "linear"
    for word, angle in zip(("forward", "outward", "back"), ANGLES, strict=False):
        points = line(figure, f"line-{word}")
        assert points[[0, 2], 1] == pytest.approx([50.0 + angle, 52.0 + angle])
        (label,) = drawn(figure, f"label-{word}")
        assert label.xy[1] == pytest.approx(52.0 + angle)
        assert line(figure, f"missing-refused-{word}")[:, 0] == pytest.approx([2.0])
    assert line(figure, "endless-inward")[:, 0] == pytest.approx([1.0, 3.0])
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == [
        "refused",
        "nothing failed",
        "theoretical limit",
    ]


def test_lines_that_end_together_have_a_legend() -> None:
    rows = [{**row, "impulse": 50.0} for row in limits([1.0, 2.0, 3.0])]
    figure = made(rows, GAIN, ANGLE)
    assert drawn(figure, "label-.*") == []
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "forward", "outward", "back", "inward",
    ]  # fmt: skip
    widths = [drawn(figure, f"line-{word}")[0].get_linewidth() for word in ("forward", "inward")]
    assert widths[0] > widths[1]


def test_many_values_of_both_are_a_map() -> None:
    rows = limits([float(gain) for gain in range(1, 9)], [45.0 * i for i in range(8)])
    figure = made(rows, GAIN, ANGLE)
    cells, missing = drawn(figure, "cell-.*"), drawn(figure, "missing-.*")
    assert (len(cells), len(missing)) == (56, 8)
    assert all(cell.get_hatch() for cell in missing)
    assert {cell.get_gid()[:9] for cell in missing} == {"missing-1"}
    (word,) = drawn(figure, "word-2-3")
    assert float(word.get_text()) == pytest.approx(52.0 + 135.0, rel=5e-3)
    assert drawn(figure, "word-0-7")[0].get_text() == "↑"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [
        "refused", "↑ nothing failed",
    ]  # fmt: skip


def test_who_survived_over_two_parameters_is_a_map() -> None:
    rows = [
        {GAIN: gain, ANGLE: angle, "outcome": "fell", "survived": gain > 1.0}
        for gain in (1.0, 2.0) for angle in ANGLES
    ]  # fmt: skip
    figure = made(rows, GAIN, ANGLE)
    colours = {cell.get_gid()[5]: to_hex(cell.get_facecolor()) for cell in drawn(figure, "cell.*")}
    assert colours["0"] != colours["1"]
    words = [text.get_text() for text in figure.legends[0].get_texts()]
    assert words == ["survived", "not survived"]


def test_drawn_walks_show_which_parameter_matters() -> None:
    figure = made(walks(), "push.impulse", GAIN, LEG, sampling="latin-hypercube")
    shares = line(figure, "share-push.impulse")
    assert shares[0, 1] == 1.0
    assert shares[-1, 1] == 0.0
    gain = line(figure, f"share-{GAIN}")[:, 1]
    assert gain.min() > 0.2
    assert gain.max() < 0.8
    for place, share in line(figure, f"share-{GAIN}"):
        low, high = line(figure, f"interval-{GAIN}-{place:.6g}")[:, 1]
        assert low < share < high
    assert figure.axes[1].get_xscale() == "log"
    ticks = [text.get_text() for text in figure.axes[2].get_xticklabels()]
    assert sorted(ticks) == ["no", "yes"]
    assert figure.axes[0].get_title(loc="right") == "0% – 100%"


def test_drawn_numbers_have_a_median_and_their_points() -> None:
    rows = walks()
    figure = made(rows, "push.impulse", GAIN, name="dcm_error", sampling="monte-carlo")
    assert len(line(figure, "points-push.impulse")) == len(rows)
    for impulse, error in line(figure, "median-push.impulse"):
        assert error == pytest.approx(0.001 * impulse)
    steps = made(rows, "push.impulse", GAIN, name="recovery_steps", sampling="monte-carlo")
    assert (line(steps, "median-push.impulse")[:, 1] == 3.0).all()
    fell = [row["push.impulse"] for row in rows if not row["survived"]]
    assert line(steps, "missing-fell-push.impulse")[:, 0] == pytest.approx(fell)


def test_the_interval_is_that_of_wilson() -> None:
    # R: prop.test(8, 10, correct = FALSE), and that of 0 of 10.
    assert wilson(8, 10) == pytest.approx((0.4901625, 0.9433178), abs=1e-6)
    assert wilson(0, 10) == pytest.approx((0.0, 0.2775328), abs=1e-6)


@pytest.mark.parametrize(
    ("values", "words", "numeric"),
    [
        (["a", "b"], ("a", "b"), False),
        ([[1.0, 2.0], [3.0, 3.0]], ("1, 2", "3, 3"), False),
        ([[1.0, 1.0], [30.0, 30.0]], ("1", "30"), True),
        ([2.0, math.inf, None], ("2", "∞", "none"), False),
        ([True, False], ("yes", "no"), False),
    ],
)
def test_values_that_are_no_numbers_are_categories(values: Any, words: Any, numeric: bool) -> None:
    rows = [{"controller.step_weight": value, "outcome": "x", "margin": 1.0} for value in values]
    one = column(rows, "controller.step_weight", "unified")
    assert (one.words, one.numeric) == (words, numeric)
    figure = made(rows, "controller.step_weight", name="margin")
    assert tuple(text.get_text() for text in figure.axes[0].get_xticklabels()) == words


@pytest.mark.parametrize("first", [0.0, 0.01])
def test_geometric_values_have_such_an_axis(first: float) -> None:
    values = [first, 0.1, 1.0, 10.0, 100.0]
    figure = made([{GAIN: value, "outcome": "x", "impulse": 1.0} for value in values], GAIN)
    ax = figure.axes[0]
    assert ax.get_xscale() == ("log" if first else "symlog")
    at = ax.transData.transform([(value, 1.0) for value in values])[1:, 0]
    assert np.ptp(np.diff(at)) < 1e-6 * np.ptp(at)
    assert [text.get_text() for text in ax.get_xticklabels()] == [f"{v:g}" for v in values]


def test_nothing_measured_is_said() -> None:
    rows = [
        {**row, "outcome": "refused", "impulse": None, "push.phase": 0.0}
        for row in limits([1.0, 2.0, 4.0])
    ]
    for varied in ((GAIN,), (GAIN, ANGLE), (GAIN, ANGLE, "push.phase")):
        made(rows, *varied)
    (word,) = drawn(made(rows, GAIN, ANGLE), "empty")
    assert word.get_text() == "no cell has a number"


def test_the_title_says_what_was_asked() -> None:
    figure = made(walks(40), "push.impulse", GAIN, sampling="monte-carlo")
    assert figure.get_suptitle() == "What happens?"
    (words,) = drawn(figure, "about")
    assert words.get_text() == "paper-biped · unified · 40 cells, monte-carlo"


def test_every_number_of_the_robot_and_of_what_disturbs_it_can_vary_and_has_its_unit() -> None:
    known = parameters("unified")
    for room in ("robot", "plant"):
        for part, kind in (("foot", Foot), ("swing", Swing), ("trunk", Trunk)):
            assert {f"{room}.{part}.{name}" for name in kind.__struct_fields__} <= set(known)
    assert {f"gait.{name}" for name in GaitLimits.__struct_fields__} <= set(known)
    assert {f"disturbance.{one.name}" for one in fields(Disturbance)} <= set(known)
    unknown = {name for name, one in known.items() if not one.unit}
    assert {name for name in unknown if not name.startswith("controller.")} == {
        "push.step", "disturbance.seed",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("key", "name", "label"),
    [
        ("unified", "gait.step_x.max", "gait.step_x.max [m]"),
        ("unified", "robot.trunk.inertia", "robot.trunk.inertia [kg m²]"),
        ("unified", "controller.step_weight", "controller.step_weight [–]"),
        ("hybrid", "controller.step_weight", "controller.step_weight [1/m²]"),
    ],
)
def test_a_label_has_the_unit_that_the_owner_declares(key: str, name: str, label: str) -> None:
    assert column([{name: 0.5}], name, key).label == label


@pytest.mark.parametrize("kind", ["lines", "close", "map", "panels"])
def test_words_stay_inside_and_apart(kind: str) -> None:
    rows, varied, more = limits([1.0, 2.0, 4.0, 8.0, 16.0]), [GAIN, ANGLE], {}
    if kind == "close":
        rows = [{**row, "impulse": 50.0} for row in rows]
    elif kind == "map":
        rows = limits([float(gain) for gain in range(12)], [30.0 * i for i in range(12)])
    elif kind == "panels":
        rows = [{**row, "plant.mass": 60.0 + i} for i, row in enumerate(walks())]
        varied = ["push.impulse", GAIN, LEG, "plant.mass"]
        more = {"sampling": "monte-carlo"}
    with style.context(["default", palette.STYLE]):
        figure = sweep_figure(table(rows, *varied, **more))
        figure.draw_without_rendering()
    words = [*figure.texts, *(t for legend in figure.legends for t in legend.get_texts())]
    for ax in figure.axes:
        words += [ax.xaxis.label, ax.yaxis.label, ax._right_title, *ax.texts]  # type: ignore[attr-defined]
        words += [*ax.get_xticklabels(), *ax.get_yticklabels()]
        legend = ax.get_legend()
        words += legend.get_texts() if legend else []
    assert_words_stand_apart(figure, words)


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
def test_the_same_table_gives_the_same_bytes(tmp_path: Path, ending: str) -> None:
    rows = limits([1.0, 2.0, 4.0])
    draw_sweep(table(rows, GAIN, ANGLE), tmp_path / f"one{ending}")
    with rc_context({"axes.facecolor": "black", "font.size": 30.0}):
        draw_sweep(table(rows, GAIN, ANGLE), tmp_path / f"two{ending}")
    data = (tmp_path / f"one{ending}").read_bytes()
    assert data == (tmp_path / f"two{ending}").read_bytes()


def test_wrong_choices_are_told(tmp_path: Path) -> None:
    rows, path = limits([1.0, 2.0]), tmp_path / "sweep.png"
    with pytest.raises(
        ParameterError,
        match=r"table \(impulse, delta_v, limit, share\); got `impulses`; did you mean `impulse`\?",
    ):
        draw_sweep(table(rows, GAIN, ANGLE), path, "impulses")
    with pytest.raises(ParameterError, match="quantity of this table"):
        draw_sweep(table(rows, GAIN, ANGLE), path, "failure")
    with pytest.raises(FileError, match=r"expected a path ending in \.png, \.pdf, \.svg"):
        draw_sweep(table(rows, GAIN, ANGLE), tmp_path / "sweep.bmp")
    assert list(tmp_path.iterdir()) == []

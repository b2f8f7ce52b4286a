"""The noise-and-delay budget: its conditions, its cells, and what is shown of them."""

from __future__ import annotations

import json
import math
import shutil
from dataclasses import replace
from pathlib import Path

import polars
import pytest

import surefoot as sf
from surefoot.control.registry import find_method, methods
from surefoot.studies.compare.budget import (
    budget_figure,
    budget_report,
    lost_words,
    retained,
)
from surefoot.studies.compare.disturbances import (
    DISTURBANCES,
    UNDISTURBED,
    every_disturbance,
    named_disturbance,
)
from surefoot.studies.compare.measure import pushed_touchdown
from surefoot.studies.compare.question import Cell, Comparison
from surefoot.studies.compare.show import comparison_report
from surefoot.studies.engine.report import Figure
from surefoot.studies.engine.study import Measured, run
from surefoot.studies.engine.table import Shards

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
SMALL = Comparison(
    ROBOT, methods=("tracking", "hybrid"), directions=1, phases=1, step=10.0, seeds=2,
    disturbances=("none", "dcm-noise-5mm", "delay-20ms", "mass+10%"),
)  # fmt: skip
PUBLISHED = Path(__file__).parents[1] / "docs" / "compare" / "compare.parquet"


@pytest.fixture(scope="module")
def measured(tmp_path_factory) -> Measured[Comparison]:
    found = run(SMALL, tmp_path_factory.mktemp("budget") / "table", workers=1)
    assert not found.failures
    return found


def of(measured: Measured[Comparison], rows: list[dict]) -> Measured[Comparison]:
    return replace(measured, rows=rows)


def test_every_disturbance_has_one_name_and_is_wrong_in_its_own_way() -> None:
    assert every_disturbance()[0] == UNDISTURBED == "none"
    assert len({one.key for one in DISTURBANCES}) == len({one.label for one in DISTURBANCES})
    controller = methods()[0].controller(ROBOT, (0.5, 0.0))
    ways = [(one.walks(3), one.plant(ROBOT), one.estimator_of(controller)) for one in DISTURBANCES]
    assert len({repr(way) for way in ways}) == len(DISTURBANCES)
    for one in DISTURBANCES:
        helped = one.key.count("+") == 1 and not one.key.endswith("%")
        assert (one.estimator_of(controller) is not None) == helped, one.key
    with pytest.raises(sf.ParameterError, match=r"a disturbance \(none, .*\); got 'fog'"):
        named_disturbance("fog")


def test_what_is_drawn_is_walked_with_every_seed_and_an_offset_every_way() -> None:
    assert [one.seed for one in named_disturbance("velocity-noise").walks(3)] == [0, 1, 2]
    assert len(named_disturbance("delay-5ms").walks(3)) == 1
    offsets = {one.com_offset for one in named_disturbance("com-offset").walks(1)}
    assert offsets == {(0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)}


def test_one_rule_for_a_whole_budget_and_the_papers_without() -> None:
    assert not SMALL.must_settle
    assert Comparison(ROBOT).must_settle
    cells = list(SMALL.cells())
    assert len(set(cells)) == len(cells) == 2 * 4
    # A rule that is not the same does not go into one table.
    assert SMALL.common() != Comparison(ROBOT, step=10.0, seeds=2).common()


def test_the_worst_walk_counts() -> None:
    cell = Cell("hybrid", 90.0, 0.5, 0.2, 3.0, "com-offset")
    row = SMALL.measure(cell)
    one = find_method("hybrid")
    controller = one.controller(SMALL.walk.on_leg(3.0).robot, (0.5, 0.0), **one.compared)
    own = [
        sf.smallest_failing_push(
            controller, (0.0, 1.0), start=1.25, step=10.0, disturbance=one, must_settle=False
        ).impulse
        for one in named_disturbance("com-offset").walks(1)
    ]
    assert row["impulse"] == min(own) < max(own)
    assert row["survived_mean"] == pytest.approx(sum(own) / 4.0 - 10.0)
    assert row["failure"] == "fell"


def test_the_limit_is_that_of_the_plant() -> None:
    at = {
        key: SMALL.limits(Cell("hybrid", 0.0, 0.0, 0.2, 3.0, key))
        for key in ("none", "delay-20ms", "mass+10%", "height-10%")
    }
    assert at["delay-20ms"] == at["none"]
    assert at["mass+10%"]["limit_finite"] == pytest.approx(1.1 * at["none"]["limit_finite"])
    assert at["height-10%"]["limit_finite"] != pytest.approx(at["none"]["limit_finite"], rel=1e-3)


def test_a_budget_is_what_its_rows_say(measured) -> None:
    found = retained(measured)
    assert len(found) == 2 * 4
    at = {(row["method"], row["disturbance"]): row for row in measured.rows}
    for (key, wrong), kept in found.items():
        row, before = at[key, wrong], at[key, "none"]
        assert kept.share == pytest.approx((row["impulse"] - 10.0) / row["limit_finite"])
        assert kept.lost == before["impulse"] - row["impulse"]
        assert kept.cells == 1
    assert found["hybrid", "delay-20ms"].lost > 0.0
    assert found["hybrid", "mass+10%"].lost < 0.0
    assert found["hybrid", "delay-20ms"].change < 0.0
    assert "Not everything" not in budget_report(measured).markdown()
    disturbed = [row for row in measured.rows if row["disturbance"] != "none"]
    without = of(measured, disturbed)
    assert math.isnan(retained(without)["hybrid", "delay-20ms"].lost)
    assert "Not everything was measured" in budget_report(without).markdown()


def test_the_words_of_what_is_lost() -> None:
    lost = (3.25, -3.25, 23.4, -0.01, math.nan)
    minus = "\N{MINUS SIGN}"
    assert [lost_words(one) for one in lost] == [f"{minus}3.2", "+3.2", f"{minus}23", "0", "–"]


def test_the_report_holds_every_field(measured, tmp_path: Path) -> None:
    report = budget_report(measured)
    text = report.markdown()
    kept = retained(measured)["hybrid", "dcm-noise-5mm"]
    assert "| DCM noise 5 mm (2 walks) |" in text
    assert f"{100.0 * kept.share:.0f} %" in text
    files = report.write(tmp_path)
    assert [path.name for path in files] == ["budget.html", "budget.md", "budget.png"]
    first = [path.read_bytes() for path in files]
    assert [path.read_bytes() for path in report.write(tmp_path)] == first
    figure = budget_figure(measured)
    fields = {patch.get_gid(): patch for patch in figure.axes[0].patches}
    assert len(fields) == 2 * 4
    late, plain = fields["field-hybrid-delay-20ms"], fields["field-hybrid-none"]
    red, _, blue, _ = late.get_facecolor()
    assert red > blue  # orange is a loss
    assert len(set(plain.get_facecolor()[:3])) == 1
    partial = of(measured, [row for row in measured.rows if row["method"] != "hybrid"])
    assert "– was not measured" in budget_report(partial).markdown()
    drawn = Figure("partial.svg", "", lambda: budget_figure(partial)).content()
    assert b"field-hybrid-none" in drawn


def test_labels_of_the_picture_do_not_leave_it(measured) -> None:
    """All disturbances, the longest names last."""
    every = [{"key": one.key, "label": one.label} for one in methods()]
    wrongs = [{"key": one.key, "label": one.label, "walks": 1} for one in DISTURBANCES]
    notes = {"methods": every, "disturbances": wrongs}
    figure = budget_figure(replace(measured, notes=notes))
    figure.canvas.draw()
    width, height = figure.canvas.get_width_height()
    axes = figure.axes[0]
    for label in [*axes.get_xticklabels(), *axes.get_yticklabels()]:
        box = label.get_window_extent()
        assert 0.0 <= box.x0 < box.x1 <= width, label.get_text()
        assert 0.0 <= box.y0 < box.y1 <= height, label.get_text()


def test_the_published_table_is_still_one(tmp_path: Path) -> None:
    """It knows of no disturbance."""
    table = polars.read_parquet(PUBLISHED)
    rows = table.to_dicts()
    notes = polars.read_parquet_metadata(PUBLISHED)
    methods = json.loads(notes["surefoot.methods"])
    shown = Measured(Comparison(ROBOT), rows, [], {}, {"methods": methods})
    text = comparison_report(shown).markdown()
    assert f"{len(rows)} scans of pushes" in text
    assert len(rows) > 4000
    assert all(one["label"] in text for one in methods)
    few = Comparison(ROBOT, methods=("hybrid",), directions=2, phases=2)
    folder = tmp_path / "table"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Comparison, "measure", lambda *_: {"impulse": 1.0, "scanned": 1.0})
        run(few, folder, workers=1)
    shutil.rmtree(folder / "shards")
    common = json.loads((folder / "run.json").read_text())
    Shards(folder, common).add(rows)
    found = run(few, folder, workers=1)
    assert not found.failures
    assert all(row["impulse"] > 1.0 for row in found.rows)
    assert len(Shards(folder, common).rows) == len(rows)  # nothing was measured again


def test_a_method_that_cannot_walk_at_all_keeps_nothing(tmp_path: Path) -> None:
    """A scan whose first walk, unpushed, falls: 0 % is kept."""
    weak = Comparison(
        ROBOT, velocity=(0.3, 0.0), methods=("tracking",), directions=1, phases=1, step=50.0,
        disturbances=("none", "com-offset"),
    )  # fmt: skip
    found = run(weak, tmp_path / "table", workers=1)
    assert retained(found)["tracking", "com-offset"].share == 0.0


@pytest.mark.parametrize("key", ["none", "early-touchdown", "late-touchdown"])
def test_the_push_comes_in_the_same_phase_of_the_same_step(key: str) -> None:
    """An early or a late ground moves all touchdowns after it."""
    wrong, shift = named_disturbance(key), named_disturbance(key).disturbance.touchdown_shift
    (walk,) = wrong.walks(1)
    begins = pushed_touchdown(SMALL, "tracking", 3.0, key, walk)
    assert begins == pytest.approx(SMALL.walk.start(0.0) + 2.0 * shift, abs=1e-9)
    controller = find_method("tracking").controller(SMALL.walk.on_leg(3.0).robot, (0.5, 0.0))
    rollout = sf.simulate(controller, begins + 0.1, disturbance=walk)
    last = rollout.observations[-1]
    assert last["support_side"] == sf.Side.RIGHT
    assert last["elapsed"] == pytest.approx(0.1, abs=0.0011)

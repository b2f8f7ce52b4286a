"""The noise-and-delay budget: its conditions, its cells, and what is shown of them."""

from __future__ import annotations

import json
import math
from pathlib import Path

import polars
import pytest
from click.testing import CliRunner

import surefoot as sf
from surefoot.cli import main
from surefoot.control.registry import find_method
from surefoot.control.registry import methods as all_methods
from surefoot.studies.compare.budget import UNDISTURBED, Budget, budget
from surefoot.studies.compare.budget_figure import budget_figure, draw_budget, lost_words
from surefoot.studies.compare.budget_report import budget_text, write_budget_report
from surefoot.studies.compare.compare import (
    compare_methods,
    disturbances_of,
    open_shards,
    run_comparison,
)
from surefoot.studies.compare.comparison import comparison
from surefoot.studies.compare.conditions import CONDITIONS, condition, every_condition
from surefoot.studies.compare.measure import limits_of, measure, pushed_touchdown
from surefoot.studies.compare.question import Cell, Protocol, cell_key

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
SMALL = Protocol(
    ROBOT, methods=("tracking", "hybrid"), directions=1, phases=1, step=10.0, seeds=2,
    disturbances=("none", "dcm-noise-5mm", "delay-20ms", "mass+10%"),
)  # fmt: skip
PUBLISHED = Path(__file__).parents[1] / "docs" / "compare" / "compare.parquet"


@pytest.fixture(scope="module")
def rows(tmp_path_factory) -> list[dict]:
    shards = open_shards(SMALL, tmp_path_factory.mktemp("budget") / "table")
    rows, failures = run_comparison(SMALL, shards, workers=1)
    assert not failures
    return rows


def told(rows: list[dict]) -> Budget:
    methods = [{"key": key, "label": find_method(key).label} for key in SMALL.methods]
    return budget(rows, methods, disturbances_of(SMALL), {"robot": "paper-biped"})


def test_every_condition_has_one_name_and_is_wrong_in_its_own_way() -> None:
    assert every_condition()[0] == UNDISTURBED == "none"
    assert len({one.key for one in CONDITIONS}) == len({one.label for one in CONDITIONS})
    controller = all_methods()[0].controller(ROBOT, (0.5, 0.0))
    ways = [(one.walks(3), one.plant(ROBOT), one.estimator_of(controller)) for one in CONDITIONS]
    assert len({repr(way) for way in ways}) == len(CONDITIONS)
    for one in CONDITIONS:
        helped = one.key.count("+") == 1 and not one.key.endswith("%")
        assert (one.estimator_of(controller) is not None) == helped, one.key
    with pytest.raises(sf.ParameterError, match=r"a disturbance \(none, .*\); got 'fog'"):
        condition("fog")


def test_what_is_drawn_is_walked_with_every_seed_and_an_offset_every_way() -> None:
    assert [one.seed for one in condition("velocity-noise").walks(3)] == [0, 1, 2]
    assert len(condition("delay-5ms").walks(3)) == 1
    offsets = {one.com_offset for one in condition("com-offset").walks(1)}
    assert offsets == {(0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)}


def test_one_rule_for_a_whole_budget_and_the_papers_without() -> None:
    assert not SMALL.must_settle
    assert Protocol(ROBOT).must_settle
    cells = list(SMALL.cells())
    assert len({cell_key(cell) for cell in cells}) == len(cells) == 2 * 4
    # A rule that is not the same does not go into one table.
    assert SMALL.same_for_all() != Protocol(ROBOT, step=10.0, seeds=2).same_for_all()


def test_the_worst_walk_counts() -> None:
    cell = Cell("hybrid", 90.0, 0.5, 0.2, 3.0, "com-offset")
    row = measure(SMALL, cell)
    one = find_method("hybrid")
    controller = one.controller(SMALL.robot_with(3.0), (0.5, 0.0), **one.compared)
    own = [
        sf.smallest_failing_push(
            controller, (0.0, 1.0), start=1.25, step=10.0, disturbance=one, must_settle=False
        ).impulse
        for one in condition("com-offset").walks(1)
    ]
    assert row["impulse"] == min(own) < max(own)
    assert row["survived_mean"] == pytest.approx(sum(own) / 4.0 - 10.0)
    assert row["failure"] == "fell"


def test_the_limit_is_that_of_the_plant() -> None:
    at = {
        key: limits_of(SMALL, Cell("hybrid", 0.0, 0.0, 0.2, 3.0, key))
        for key in ("none", "delay-20ms", "mass+10%", "height-10%")
    }
    assert at["delay-20ms"] == at["none"]
    assert at["mass+10%"]["limit_finite"] == pytest.approx(1.1 * at["none"]["limit_finite"])
    assert at["height-10%"]["limit_finite"] != pytest.approx(at["none"]["limit_finite"], rel=1e-3)


def test_a_budget_is_what_its_rows_say(rows) -> None:
    measured = told(rows)
    assert measured.complete
    at = {(row["method"], row["disturbance"]): row for row in rows}
    for (key, wrong), kept in measured.kept.items():
        row, before = at[key, wrong], at[key, "none"]
        assert kept.share == pytest.approx((row["impulse"] - 10.0) / row["limit_finite"])
        assert kept.lost == before["impulse"] - row["impulse"]
        assert kept.cells == 1
    assert measured.kept["hybrid", "delay-20ms"].lost > 0.0
    assert measured.kept["hybrid", "mass+10%"].lost < 0.0
    assert measured.kept["hybrid", "delay-20ms"].change < 0.0
    without = told([row for row in rows if row["disturbance"] != "none"])
    assert math.isnan(without.kept["hybrid", "delay-20ms"].lost)
    assert not without.complete
    with pytest.raises(sf.ParameterError, match="rows of a comparison; got none"):
        budget([], [], [], {})


def test_the_words_of_what_is_lost() -> None:
    lost = (3.25, -3.25, 23.4, -0.01, math.nan)
    minus = "\N{MINUS SIGN}"
    assert [lost_words(one) for one in lost] == [f"{minus}3.2", "+3.2", f"{minus}23", "0", "–"]


def test_the_report_holds_every_field(rows, tmp_path: Path) -> None:
    measured = told(rows)
    text = budget_text(measured)
    kept = measured.kept["hybrid", "dcm-noise-5mm"]
    assert "| DCM noise 5 mm (2 walks) |" in text
    assert f"{100.0 * kept.share:.0f} %" in text
    files = write_budget_report(measured, tmp_path)
    assert [path.name for path in files] == ["budget.md", "budget.png"]
    first = [path.read_bytes() for path in files]
    assert [path.read_bytes() for path in write_budget_report(measured, tmp_path)] == first
    figure = budget_figure(measured)
    fields = {patch.get_gid(): patch for patch in figure.axes[0].patches}
    assert len(fields) == 2 * 4
    late, plain = fields["field-hybrid-delay-20ms"], fields["field-hybrid-none"]
    red, _, blue, _ = late.get_facecolor()
    assert red > blue  # orange is a loss
    assert len(set(plain.get_facecolor()[:3])) == 1
    partial = told([row for row in rows if row["method"] != "hybrid" or row["impulse"] > 1e9])
    assert "– was not measured" in budget_text(partial)
    draw_budget(partial, tmp_path / "partial.svg")
    assert "field-hybrid-none" in (tmp_path / "partial.svg").read_text("utf-8")
    with pytest.raises(sf.FileError, match=r"\.png, \.pdf, \.svg"):
        draw_budget(measured, tmp_path / "budget.bmp")


def test_labels_of_the_picture_do_not_leave_it(rows) -> None:
    """All disturbances, the longest names last."""
    methods = [{"key": one.key, "label": one.label} for one in all_methods()]
    wrongs = [{"key": one.key, "label": one.label, "walks": 1} for one in CONDITIONS]
    figure = budget_figure(budget(rows, methods, wrongs, {"robot": "paper-biped"}))
    figure.canvas.draw()
    width, height = figure.canvas.get_width_height()
    axes = figure.axes[0]
    for label in [*axes.get_xticklabels(), *axes.get_yticklabels()]:
        box = label.get_window_extent()
        assert 0.0 <= box.x0 < box.x1 <= width, label.get_text()
        assert 0.0 <= box.y0 < box.y1 <= height, label.get_text()


def test_the_command_asks_for_the_undisturbed_walk_too(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    asked = [
        "compare", "--mass", "70", "--method", "tracking", "--disturbance", "delay-10ms",
        "--disturbance", "late-touchdown", "--directions", "1", "--phases", "1", "--step", "10",
        "--workers", "1", "--out", str(folder),
    ]  # fmt: skip
    first = CliRunner().invoke(main, asked)
    assert first.exit_code == 0, first.output
    for words in ("undisturbed", "delay 10 ms", "touchdown 30 ms late", "1 DCM tracking"):
        assert words in first.stdout
    assert {path.name for path in folder.iterdir()} == {
        "budget.md", "budget.png", "compare.parquet", "run.json", "shards"
    }  # fmt: skip
    again = CliRunner().invoke(main, [*asked, "--json"])
    told = json.loads(again.stdout)
    assert [row["disturbance"] for row in told["rows"]] == ["none", "delay-10ms", "late-touchdown"]
    notes = polars.read_parquet_metadata(folder / "compare.parquet")
    assert json.loads(notes["surefoot.disturbances"]) == told["disturbances"]
    plain = CliRunner().invoke(main, [*asked[:5], *asked[9:]])
    assert plain.exit_code == 2
    assert "expected a folder of the same study (must_settle: True)" in plain.stderr
    wrong = CliRunner().invoke(main, ["compare", "--disturbance", "fog", "--out", str(folder)])
    assert wrong.exit_code == 2
    assert "expected a disturbance (none, dcm-noise-1mm," in wrong.stderr


def test_the_published_table_is_still_one(tmp_path: Path) -> None:
    """It knows of no disturbance."""
    table = polars.read_parquet(PUBLISHED)
    cells = table.drop("seconds", strict=False).to_dicts()
    notes = polars.read_parquet_metadata(PUBLISHED)
    methods = json.loads(notes["surefoot.methods"])
    assert len(comparison(cells, methods, {}).cells) == len(cells) > 4000
    folder = tmp_path / "table"
    open_shards(Protocol(ROBOT), folder).add(table.to_dicts())
    few = Protocol(ROBOT, methods=("hybrid",), directions=2, phases=2)
    rows, failures = run_comparison(few, open_shards(few, folder), workers=1)
    assert not failures
    assert all(row["impulse"] > 0.0 for row in rows)
    assert len(open_shards(few, folder).rows) == len(cells)  # nothing was measured again


def test_a_method_that_cannot_walk_at_all_keeps_nothing(tmp_path: Path) -> None:
    """A scan whose first walk, unpushed, falls: 0 % is kept."""
    weak = Protocol(
        ROBOT, velocity=(0.3, 0.0), methods=("tracking",), directions=1, phases=1, step=50.0,
        disturbances=("none", "com-offset"),
    )  # fmt: skip
    result = compare_methods(weak, tmp_path / "table", workers=1)
    measured = budget(result.rows, result.methods, result.disturbances, result.provenance)
    assert measured.kept["tracking", "com-offset"].share == 0.0
    assert result.remarks == []


@pytest.mark.parametrize("key", ["none", "early-touchdown", "late-touchdown"])
def test_the_push_comes_in_the_same_phase_of_the_same_step(key: str) -> None:
    """An early or a late ground moves all touchdowns after it."""
    wrong, shift = condition(key), condition(key).disturbance.touchdown_shift
    (walk,) = wrong.walks(1)
    begins = pushed_touchdown(SMALL, "tracking", 3.0, key, walk)
    assert begins == pytest.approx(SMALL.push_start(0.0) + 2.0 * shift, abs=1e-9)
    controller = find_method("tracking").controller(SMALL.robot_with(3.0), (0.5, 0.0))
    rollout = sf.simulate(controller, begins + 0.1, disturbance=walk)
    last = rollout.observations[-1]
    assert last["support_side"] == sf.Side.RIGHT
    assert last["elapsed"] == pytest.approx(0.1, abs=0.0011)

"""The comparison of methods: fair questions, rows that survive a kill, and the limit above all."""

from __future__ import annotations

import json
import math

import polars
import pytest

import surefoot as sf
from killed_studies import without_time
from surefoot.control.registry import find_method, method_names, methods
from surefoot.studies.compare.question import Cell, Comparison, able_methods, every_method
from surefoot.studies.compare.show import remarks
from surefoot.studies.engine.study import Measured, run

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
SMALL = Comparison(
    ROBOT, methods=("tracking", "hybrid"), directions=2, phases=2, leg_speeds=(3.0,), step=20.0
)


@pytest.fixture(scope="module")
def measured(tmp_path_factory) -> Measured[Comparison]:
    return run(SMALL, tmp_path_factory.mktemp("small") / "table", workers=1)


def test_every_method_has_one_name_everywhere() -> None:
    assert sorted(method_names()) == sorted(one.key for one in methods())
    assert len({one.label for one in methods()}) == len(methods())
    assert set(every_method()) == {one.key for one in methods() if not one.slow}
    with pytest.raises(sf.ParameterError, match=r"a method \(tracking, .*\); got 'lqr'"):
        find_method("lqr")


@pytest.mark.parametrize("one", methods(), ids=lambda one: one.key)
def test_every_method_makes_its_controller(one) -> None:
    controller = one.controller(ROBOT, (0.3, 0.0))
    assert isinstance(controller, sf.Controller)
    assert controller.gait.velocity == (0.3, 0.0)


def test_the_cells_are_the_whole_grid() -> None:
    protocol = Comparison(ROBOT, directions=4, phases=8, leg_speeds=(2.0, math.inf))
    cells = list(protocol.cells())
    assert len(cells) == len(set(cells)) == len(every_method()) * 2 * 8 * 4
    assert {cell.angle for cell in cells} == {0.0, 90.0, 180.0, 270.0}
    assert protocol.walk.start(0.2) == pytest.approx(1.1)  # the paper's push


def test_outward_is_towards_the_swing_foot() -> None:
    """The right foot stands in the pushed step, so outward is to the left."""
    controller = find_method("tracking").controller(ROBOT, (0.5, 0.0))
    rollout = sf.simulate(controller, SMALL.walk.start(0.5))
    seen = rollout.observations[-1]
    towards = seen["swing_foot"][:2] - seen["support_foot"]
    assert SMALL.walk.direction(90.0)[1] * towards[1] > 0.0
    assert SMALL.walk.direction(0.0) == (1.0, 0.0)
    assert SMALL.walk.direction(45.0) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))


def test_fixed_steps_are_walked_once_for_every_leg(monkeypatch) -> None:
    """And rightly so: on a slow leg they are the same walks."""
    cell = Cell("tracking", 0.0, 0.25, 0.2, 2.0)
    assert SMALL.measured_as(cell).leg_speed == math.inf
    assert SMALL.measured_as(Cell("hybrid", 0.0, 0.25, 0.2, 2.0)).leg_speed == 2.0
    fast = Comparison(ROBOT, velocity=(0.7, 0.0), methods=("tracking",))
    assert fast.measured_as(cell).leg_speed == 2.0  # the feet of this gait need more than 2 m/s
    ends = []
    for leg_speed in (2.0, math.inf):
        controller = sf.DcmTracking(SMALL.walk.on_leg(leg_speed).robot, (0.5, 0.0))
        rollout = sf.simulate(controller, 3.0, [sf.Push(1.1, 0.2, (120.0, 0.0))])
        ends.append(rollout.observations.tobytes())
    assert ends[0] == ends[1]


def test_a_row_is_what_a_scan_of_ones_own_says() -> None:
    study = Comparison(ROBOT, methods=("hybrid",), leg_speeds=(math.inf,))
    row = study.measure(Cell("hybrid", 180.0, 0.2, 0.2, math.inf))
    own = sf.smallest_failing_push(sf.HybridController(ROBOT, (0.5, 0.0)), (-1.0, 0.0))
    assert row["impulse"] == own.impulse == 265.0
    assert row["delta_v"] == pytest.approx(own.impulse / 70.0)
    assert row["failure"] == "fell"
    assert row["limit_point"] == pytest.approx(264.0, rel=0.01)
    assert row["limit_finite"] == pytest.approx(298.0, rel=0.01)
    assert row["limit_fixed"] == pytest.approx(34.0, rel=0.01)


def test_nobody_passes_the_limit(measured) -> None:
    assert len(measured.rows) == 2 * 2 * 2
    for row in measured.rows:
        survived = row["impulse"] - row["step"]
        fixed = row["method"] == "tracking"
        assert survived <= row["limit_fixed" if fixed else "limit_finite"] + 1e-9
        assert row["limit_fixed"] <= row["limit_finite"]
        assert row["limit_point"] <= row["limit_finite"]


def test_the_table_says_where_it_is_from(measured, tmp_path) -> None:
    run(SMALL, tmp_path / "table", workers=1)
    path = tmp_path / "table" / "compare.parquet"
    assert without_time(polars.read_parquet(path).to_dicts()) == without_time(measured.rows)
    notes = polars.read_parquet_metadata(path)
    provenance = json.loads(notes["surefoot.provenance"])
    assert provenance["robot"] == "paper-biped"
    assert provenance["mass"] == "70 kg"
    assert provenance["version"] == sf.__version__
    methods = json.loads(notes["surefoot.methods"])
    assert [one["key"] for one in methods] == list(SMALL.methods)
    for one in methods:
        assert 0.0 < one["decision_p50"] <= one["decision_p99_9"]


def test_the_number_of_workers_changes_nothing(measured, tmp_path) -> None:
    two = run(SMALL, tmp_path / "two", workers=2)
    assert not two.failures
    assert without_time(two.rows) == without_time(measured.rows)


def test_limits_do_not_depend_on_the_method() -> None:
    cells = [Cell(key, 90.0, 0.25, 0.1, 3.0) for key in every_method()]
    assert len({tuple(SMALL.limits(cell).values()) for cell in cells}) == 1


def row(key: str, impulse: float, angle: float = 0.0, speed: float = 3.0, phase: float = 0.0):
    return {
        "method": key, "impulse": impulse, "angle": angle, "leg_speed": speed, "phase": phase,
        "push_duration": 0.2,
    }  # fmt: skip


@pytest.mark.parametrize("key", ["tracking-stiff", "preview-control", "linear-mpc"])
@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -1.0)])
def test_fixed_steps_come_near_what_fixed_steps_allow(key: str, direction) -> None:
    """A strawman is a defect: at least 95 % of the limit of fixed steps."""
    controller = find_method(key).controller(ROBOT, (0.5, 0.0))
    limit = sf.fixed_steps_limit(ROBOT, direction).impulse
    force = (direction[0] * 0.95 * limit / 0.2, direction[1] * 0.95 * limit / 0.2)
    rollout = sf.simulate(controller, 9.0, [sf.Push(1.1, 0.2, force)])
    assert rollout.outcome is sf.Outcome.RECOVERED


def test_a_robot_without_a_trunk_is_compared_by_the_others(tmp_path) -> None:
    able, left_out = able_methods(sf.load_robot("paper-table2"), (0.3, 0.0))
    assert set(able) == set(every_method()) - {"ankle-hip-step-mpc"}
    assert "a robot with a trunk" in left_out["ankle-hip-step-mpc"]
    asked = Comparison(sf.load_robot("paper-table2"), (0.3, 0.0), methods=("ankle-hip-step-mpc",))
    with pytest.raises(sf.RobotError, match="a robot with a trunk"):
        run(asked, tmp_path / "table", workers=1)
    assert not (tmp_path / "table").exists()


def test_a_heavy_robot_is_scanned_far_enough(tmp_path) -> None:
    heavy = Comparison(
        ROBOT.replace(mass=400.0), methods=("hybrid",), directions=1, phases=1,
        leg_speeds=(math.inf,), step=20.0,
    )  # fmt: skip
    (row,) = run(heavy, tmp_path / "table", workers=1).rows
    assert row["failure"] == "fell"
    assert row["impulse"] > 600.0


def test_a_scan_that_nothing_ends_still_makes_a_table(tmp_path) -> None:
    coarse = Comparison(
        ROBOT, methods=("hybrid",), directions=1, phases=1, leg_speeds=(math.inf,), step=1000.0
    )
    result = run(coarse, tmp_path / "table", workers=1)
    (row,) = result.rows
    assert row["failure"] == "none"
    assert math.isinf(row["impulse"])
    assert json.dumps(result.as_numbers(), allow_nan=False)
    assert polars.read_parquet(tmp_path / "table" / "compare.parquet")["impulse"][0] == math.inf


def test_the_papers_claim_is_answered_from_the_rows() -> None:
    rows = [
        row("hybrid", 80.0), row("foot-placement-mpc", 40.0),
        row("hybrid", 30.0, phase=0.5), row("foot-placement-mpc", 60.0, phase=0.5),
        row("hybrid", 99.0, angle=90.0),
    ]  # fmt: skip
    opening, told = remarks(rows)
    assert "85 N s" in opening
    assert "20 N s" in opening
    assert "forward 30–80 against 40–60 N s (ratio 1.00; the hybrid is ahead in 1 of 2" in told
    assert "outward" not in told  # only one of the two was measured there
    assert remarks([row("hybrid", 80.0)]) == []
    unbeaten = [*rows[:2], row("hybrid", 50.0, phase=0.5)]
    unbeaten.append(row("foot-placement-mpc", math.inf, phase=0.5))
    assert "forward 50–80 against 40–no N s (the hybrid is ahead in 1 of 2" in remarks(unbeaten)[1]

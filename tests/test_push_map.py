"""A push map: its verdicts are those of single walks, of the third step, and of the mirror."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars
import pytest

import surefoot as sf
from surefoot.dcm.pushes import PUSH
from surefoot.studies.engine.study import Measured, run
from surefoot.studies.push_map import measure, question
from surefoot.studies.push_map.measure import FELL, PER_WALK, RECOVERED, UNSETTLED
from surefoot.studies.push_map.question import Cell, PushMap
from surefoot.worlds.point.batch import simulate_batch
from surefoot.worlds.point.progress import WALK_RESULT
from surefoot.worlds.point.walks import Walks

SMALL: dict[str, Any] = {"directions": 6, "phases": 2, "step": 10.0, "coarse": 40.0}
TABLE = "push-map.parquet"


@pytest.fixture(scope="module")
def slow_leg() -> sf.Robot:
    return sf.load_robot("paper-biped").with_leg(max_speed=3.0)


@pytest.fixture(scope="module")
def hybrid(slow_leg: sf.Robot) -> sf.HybridController:
    return sf.HybridController(slow_leg, (0.5, 0.0))


@pytest.fixture(scope="module")
def unified(slow_leg: sf.Robot) -> sf.UnifiedController:
    return sf.UnifiedController(slow_leg, (0.5, 0.0))


@pytest.fixture(scope="module")
def rows(hybrid: sf.HybridController, tmp_path_factory: pytest.TempPathFactory) -> list[dict]:
    return walked(PushMap(hybrid, **SMALL), tmp_path_factory.mktemp("small") / "map").rows


def walked(study: PushMap, folder: Path, **how: Any) -> Measured[PushMap]:
    """The map, measured in this process."""
    return run(study, folder, workers=1, **how)


def at(study: PushMap, phase: float) -> list[dict[str, Any]]:
    """The rows of one phase."""
    cells = [Cell(phase, angle) for angle in study.angles]
    rows = study.measure_many(cells)
    return [study.columns(cell) | row for cell, row in zip(cells, rows, strict=True)]  # type: ignore[operator]


def numbers(rows: list[dict[str, Any]]) -> list[tuple[Any, ...]]:
    """Rows as values that equal themselves, which NaN does not."""
    return [tuple(map(repr, row.values())) for row in rows]


def test_a_walk_of_the_map_is_the_walk_of_simulate(
    hybrid: sf.HybridController, rows: list[dict[str, Any]]
) -> None:
    duration, study = hybrid.gait.step_duration, PushMap(hybrid, **SMALL)
    for row in rows[::2]:
        x, y = study.direction(row["angle"])
        for number in range(0, len(row["impulses"]), 3):
            force = row["impulses"][number] / 0.2
            push = sf.Push(row["phase"] * duration, 0.2, (x * force, y * force))
            walk = sf.simulate(hybrid, push.end + 8.0, [push], first_support=sf.Side.RIGHT)
            fate = {sf.Outcome.RECOVERED: RECOVERED, sf.Outcome.FELL: FELL}
            assert row["fate"][number] == fate.get(walk.outcome, UNSETTLED)


@pytest.mark.parametrize("name", ["hybrid", "unified"])
@pytest.mark.parametrize("phase", [0.0, 0.55])
def test_the_first_step_answers_for_the_third(
    name: str, phase: float, request: pytest.FixtureRequest
) -> None:
    controller = request.getfixturevalue(name)
    study = PushMap(controller, directions=5, phases=20, step=4.0, coarse=4.0)
    for row in at(study, phase)[::2]:
        third = sf.smallest_failing_push(
            controller,
            study.direction(row["angle"]),
            start=(2.0 + phase) * controller.gait.step_duration,
            step=4.0,
        )
        assert row["impulse"] == third.impulse
        assert (row["failure"] == "fell") == third.fell


def test_left_is_right_in_the_mirror(
    hybrid: sf.HybridController, rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    left = PushMap(hybrid, **SMALL, support_side=sf.Side.LEFT)
    assert left.direction(90.0) == (0.0, -1.0)
    mirrored = walked(left, tmp_path / "map").rows
    for here, there in zip(rows, mirrored, strict=True):
        assert here["fate"] == there["fate"]
        assert here["recovery_steps"] == there["recovery_steps"]
        assert here["margin"] == pytest.approx(there["margin"], abs=1e-9)
        assert here["limit"] == pytest.approx(there["limit"], rel=1e-9)


def test_nothing_above_the_limit_is_survived(unified: sf.UnifiedController) -> None:
    study = PushMap(unified, directions=8, phases=20, step=20.0)
    for row in at(study, 0.3):
        assert row["survived"] <= row["limit"] < row["impulse"]
        assert 0.0 < row["limit_causal"] <= row["limit"]
        assert row["fraction"] <= row["fraction_causal"] <= 1.0
        pushes = np.zeros((6, 1), PUSH)
        start = 0.3 * unified.gait.step_duration
        pushes["start"], pushes["end"] = start, start + 0.2
        above = row["limit"] * np.array([1.005, 1.02, 1.05, 1.1, 1.3, 2.0])
        pushes["force"][:, 0] = np.outer(above / 0.2, study.direction(row["angle"]))
        walks = simulate_batch(
            unified, Walks(pushes=pushes), 9.0, first_support=sf.Side.RIGHT, stop_when_settled=True
        )
        assert not walks["settled"].any()


def test_the_fast_way_finds_what_the_full_one_does(
    hybrid: sf.HybridController, rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    full = PushMap(hybrid, **{**SMALL, "coarse": 10.0})
    every = walked(full, tmp_path / "map").rows
    for fast, row in zip(rows, every, strict=True):
        assert fast["impulse"] == row["impulse"]
        assert row["impulses"] == [10.0 * number for number in range(len(row["impulses"]))]
        assert row["impulses"][-2] <= row["limit"] < row["impulses"][-1]
        whole = dict(zip(row["impulses"], row["fate"], strict=True))
        assert all(whole[j] == f for j, f in zip(fast["impulses"], fast["fate"], strict=True))
        assert len(fast["impulses"]) < len(row["impulses"])


def with_holes(survives: Callable[[float], bool]) -> Callable[..., Any]:
    """In the place of `simulate_batch`: what an impulse does is given."""

    def walk(controller: Any, walks: Walks, **options: Any) -> Any:
        pushes = walks.push_table()
        impulses = 0.2 * np.hypot(*pushes["force"][:, 0].T)
        results = np.zeros(len(pushes), WALK_RESULT)
        results["settled"] = [survives(round(impulse, 6)) for impulse in impulses]
        results["fallen"] = ~results["settled"]
        return results

    return walk


@pytest.mark.parametrize(
    ("coarse", "impulse", "holes"), [(1.0, 13.0, True), (2.0, 13.0, True), (4.0, 40.0, False)]
)
def test_a_hole_narrower_than_the_coarse_step_is_missed(
    hybrid: sf.HybridController, monkeypatch: pytest.MonkeyPatch,
    coarse: float, impulse: float, holes: bool,
) -> None:  # fmt: skip
    monkeypatch.setattr(
        measure, "simulate_batch", with_holes(lambda j: j < 40.0 and not 13.0 <= j < 15.0)
    )
    (row,) = at(PushMap(hybrid, directions=1, phases=1, coarse=coarse), 0.0)
    assert (row["impulse"], row["holes"] > 0) == (impulse, holes)
    assert row["survived"] == impulse - 1.0
    assert row["failure"] == "fell"


def test_a_gait_that_nothing_fells_or_everything_does(
    hybrid: sf.HybridController, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = PushMap(hybrid, directions=1, phases=1, step=10.0)
    monkeypatch.setattr(measure, "simulate_batch", with_holes(lambda j: True))
    (row,) = at(study, 0.0)
    assert (row["impulse"], row["failure"], row["fraction"]) == (math.inf, "none", 1.0)
    assert row["survived"] == row["scanned"] == row["impulses"][-1]
    monkeypatch.setattr(measure, "simulate_batch", with_holes(lambda j: False))
    (row,) = at(study, 0.0)
    assert (row["impulse"], row["survived"], row["fraction"]) == (0.0, 0.0, 0.0)


def test_a_map_that_was_stopped_repeats_nothing(
    hybrid: sf.HybridController, rows: list[dict[str, Any]], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    walked_cells, honest = [], question.measure_cells
    study = PushMap(hybrid, **SMALL)
    monkeypatch.setattr(PushMap, "KEEP_EVERY", 0.0)

    def stopped(study: PushMap, cells: Any) -> Any:
        if walked_cells:
            raise KeyboardInterrupt
        return again(study, cells)

    def again(study: PushMap, cells: Any) -> Any:
        walked_cells.extend(cells)
        return honest(study, cells)

    monkeypatch.setattr(question, "measure_cells", stopped)
    with pytest.raises(KeyboardInterrupt):
        walked(study, tmp_path / "map")
    assert not (tmp_path / "map" / TABLE).exists()
    monkeypatch.setattr(question, "measure_cells", again)
    done: list[tuple[int, int]] = []
    found = walked(study, tmp_path / "map", report=lambda *so_far: done.append(so_far))
    assert walked_cells == list(study.cells())
    assert numbers(found.rows) == numbers(rows)
    assert done[0] == (6, 12)
    assert done[-1] == (12, 12)
    assert done == sorted(done)
    walked(study, tmp_path / "map")
    assert walked_cells == list(study.cells())


def test_the_number_of_workers_changes_nothing(
    hybrid: sf.HybridController, rows: list[dict[str, Any]], tmp_path: Path
) -> None:
    found = run(PushMap(hybrid, **SMALL), tmp_path / "map", workers=2)
    assert numbers(found.rows) == numbers(rows)


def test_the_table_says_where_it_is_from(hybrid: sf.HybridController, tmp_path: Path) -> None:
    study = PushMap(hybrid, directions=2, phases=1, step=40.0, label="the paper's hybrid")
    found = walked(study, tmp_path / "map")
    path = tmp_path / "map" / TABLE
    about = polars.read_parquet_metadata(path)
    assert json.loads(about["surefoot.provenance"]) == found.provenance
    assert json.loads(about["surefoot.grid"]) == study.grid()
    assert found.provenance["controller"] == "the paper's hybrid"
    assert "dcm_gain=3.0" in found.provenance["parameters"]
    walks = polars.read_parquet(path).explode(*PER_WALK)
    assert len(walks) == sum(len(row["impulses"]) for row in found.rows)
    with pytest.raises(sf.FileError, match=r"a folder of the same study \(step: 20.0\)"):
        walked(replace(study, step=20.0, coarse=None), tmp_path / "map")


def test_a_leg_that_cannot_keep_up_is_refused(tmp_path: Path, slow_leg: sf.Robot) -> None:
    crawling = sf.HybridController(slow_leg.with_leg(max_speed=0.3), (0.5, 0.0))
    with pytest.raises(sf.VelocityError, match="a leg of at least"):
        walked(PushMap(crawling, **SMALL), tmp_path / "map")
    assert not (tmp_path / "map").exists()

"""Sweeps: what a study may ask, that every cell is the walk it says, and that nothing is lost."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import polars
import pytest
from click.testing import CliRunner

import surefoot as sf
from surefoot.cli import main
from surefoot.studies.engine.study import run
from surefoot.studies.sweep.measure import measure_cells
from surefoot.studies.sweep.parameters import parameters, situation
from surefoot.studies.sweep.question import Sweep
from surefoot.studies.sweep.study_file import load_study, parse_study

ROBOT = sf.load_robot("paper-biped")

WALKS = """
controller = "hybrid"
[set]
robot.swing.max_speed = 3.0
push.phase = 0.25
[vary]
push.impulse = [0.0, 30.0, 80.0, 400.0]
push.angle = { from = 0.0, to = 270.0, count = 4 }
gait.velocity.x = [0.5, 9.0]
"""

DRAWN = """
controller = "tracking"
sampling = "SAMPLING"
samples = 64
seed = 3
[vary]
push.impulse = { from = 1.0, to = 40.0 }
controller.dcm_gain = { from = 0.1, to = 100.0, scale = "log" }
plant.mass = { mean = 68.0, deviation = 3.0 }
disturbance.dcm_noise = [0.0, 0.001]
"""


def rows_of(text: str, folder: Path, **how: Any) -> list[dict[str, Any]]:
    return run(parse_study(text), folder, **{"workers": 1, **how}).rows


@pytest.fixture(scope="module")
def walked(tmp_path_factory) -> tuple[Path, list[dict[str, Any]]]:
    folder = tmp_path_factory.mktemp("walked") / "table"
    return folder, rows_of(WALKS, folder)


def test_every_row_is_the_walk_it_says(walked) -> None:
    _, rows = walked
    assert len(rows) == 4 * 4 * 2
    leg = ROBOT.with_leg(max_speed=3.0)
    seen = set()
    for row in rows:
        if row["gait.velocity.x"] == 9.0:
            assert row["outcome"] == "refused"
            assert "9" in row["error"]
            continue
        controller = sf.HybridController(leg, (row["gait.velocity.x"], 0.0))
        impulse, angle = row["push.impulse"], math.radians(row["push.angle"])
        force = impulse / 0.2
        start = 2.25 * controller.gait.step_duration
        push = sf.Push(start, 0.2, (force * math.cos(angle), force * math.sin(angle)))
        pushes = [push] if impulse else []
        end = push.end + 8.0 if impulse else start + 8.0
        walk = sf.simulate(controller, min(end, max(row["end_time"], 1e-9)), pushes)
        assert row["outcome"] == walk.outcome.value, row
        assert row["survived"] == (walk.outcome in (sf.Outcome.RECOVERED, sf.Outcome.WALKED))
        assert row["error"] is None
        seen.add(row["outcome"])
    assert seen == {"walked", "recovered", "fell"}


def test_the_order_and_the_company_change_nothing(walked, tmp_path) -> None:
    _, rows = walked
    study = parse_study(WALKS)
    cells = list(study.cells())
    alone = [study.columns(cell) | measure_cells(study, [cell])[0] for cell in cells[::5]]
    assert repr(alone) == repr(rows[::5])
    assert repr(rows_of(WALKS, tmp_path / "two", workers=2)) == repr(rows)


def test_a_push_limit_is_the_smallest_failing_push(tmp_path) -> None:
    text = """
    measure = "push-limit"
    controller = "hybrid"
    step = 10.0
    [vary]
    push.angle = [180.0]
    controller.threshold = [0.02, 0.03]
    push.step = [2, 3]
    """
    for row in rows_of(text, tmp_path / "table"):
        controller = sf.HybridController(ROBOT, (0.5, 0.0), threshold=row["controller.threshold"])
        start = row["push.step"] * controller.gait.step_duration
        direct = sf.smallest_failing_push(controller, (-1.0, 0.0), start=start, step=10.0)
        assert (row["impulse"], row["failure"]) == (direct.impulse, "fell")
        assert row["share"] == pytest.approx((direct.impulse - 10.0) / row["limit"])


@pytest.mark.parametrize("sampling", ["latin-hypercube", "monte-carlo"])
def test_what_is_drawn_follows_its_distribution(sampling: str) -> None:
    study = parse_study(DRAWN.replace("SAMPLING", sampling))
    columns = list(zip(*(cell.values for cell in study.cells()), strict=True))
    again = [cell.values for cell in study.cells()]
    assert list(zip(*again, strict=True)) == columns
    impulse, gain, mass, noise = (np.array(column) for column in columns)
    assert 1.0 <= impulse.min() < impulse.max() <= 40.0
    assert np.median(gain) == pytest.approx(10.0**0.5, rel=0.8)
    assert mass.mean() == pytest.approx(68.0, abs=1.5)
    assert mass.std() == pytest.approx(3.0, abs=1.0)
    assert set(noise) == {0.0, 0.001}
    if sampling == "latin-hypercube":
        # One sample in each of 64 equal parts of every range.
        assert sorted(((impulse - 1.0) / 39.0 * 64).astype(int)) == list(range(64))
    other = parse_study(DRAWN.replace("SAMPLING", sampling).replace("seed = 3", "seed = 4"))
    assert [cell.values for cell in other.cells()] != again


def test_a_grid_has_every_combination_and_round_numbers() -> None:
    study = parse_study(
        "[vary]\npush.impulse = {from = 0.0, to = 0.3, count = 4}\npush.step = [1, 2]"
    )
    values = [cell.values for cell in study.cells()]
    assert values == [(i, s) for i in (0.0, 0.1, 0.2, 0.3) for s in (1, 2)]


def test_halves_of_pairs_and_rooms() -> None:
    made = situation(
        ROBOT,
        "unified",
        {
            "controller.step_weight.x": 3.0, "controller.offset_weight": [10.0, 20.0],
            "gait.step_x.max": 0.4, "gait.velocity.y": 0.1, "robot.foot.width": 0.1,
            "plant.mass": 80.0, "disturbance.com_offset.y": 0.01, "push.angle": 90.0,
            "push.step": 1, "push.impulse": 10.0,
        },
    )  # fmt: skip
    controller = made.controller
    assert isinstance(controller, sf.UnifiedController)
    assert (controller.step_weight, controller.offset_weight) == ((3.0, 1e-3), (10.0, 20.0))
    assert controller.robot.gait.step_x == (ROBOT.gait.step_x[0], 0.4)
    assert controller.gait.velocity == (0.5, 0.1)
    assert (controller.robot.foot.width, controller.robot.mass) == (0.1, ROBOT.mass)
    assert made.plant == controller.robot.replace(mass=80.0)
    assert made.disturbance == sf.Disturbance(com_offset=(0.0, 0.01))
    # The second step is on the left foot, and the other one swings to the right.
    push = made.made_push()
    assert push is not None
    assert push.force == (0.0, -50.0)
    assert push.start == controller.gait.step_duration


def test_every_name_that_is_offered_can_be_set() -> None:
    """Each parameter at its present value makes the same situation."""
    usual = situation(ROBOT, "unified", {})
    owners = {
        "robot": ROBOT, "plant": ROBOT, "controller": usual.controller, "push": usual.push,
        "disturbance": sf.Disturbance(),
    }  # fmt: skip
    present: dict[str, Any] = {"gait.velocity": [0.5, 0.0]}
    for name in parameters("unified"):
        room, _, rest = name.partition(".")
        found: Any = owners.get(room, ROBOT.gait)
        for part in rest.split("."):
            found = getattr(found, part, None)
        if found is not None:
            present[name] = list(found) if isinstance(found, tuple) else found
    made = situation(ROBOT, "unified", present)
    assert made.controller.parameters.tobytes() == usual.controller.parameters.tobytes()
    assert (made.plant, made.push) == (usual.plant, usual.push)
    assert made.disturbance == sf.Disturbance()
    assert len(present) > 40


WRONG = {
    "[set]\npush.impulse.x = 3.0\n[vary]\npush.angle = [1.0]": "a parameter of a study",
    "[vary]\ngait.velocity.min = [0.1]": "a parameter of a study",
    "[vary]\npush.impulse = {}": "as a list",
    "[vary]\npush.impulse = [1, 1.0]": "list of different values",
    "[vary]\npush.impulse = [1.0, 'a']": "the same kind",
    "[vary]\ngait.velocity = [[0.5, 0.0], [0.1, [2.0]]]": "the same kind",
    "measure = 'push-limit'\n[vary]\npush.impulse = [1.0]": "tries them all",
    "vary = {}": "at least one parameter",
    "[vary]\ncontroller.gain = [1.0]": "a parameter of a study (controller.ankle",
    "[vary]\npush.impuls = [1.0]": "did you mean `push.impulse`",
    "[vary]\npush.impulse = []": "list of different values",
    "[vary]\npush.impulse = [1.0, 1.0]": "list of different values",
    "[vary]\npush.impulse = 3.0": "as a list",
    "[vary]\npush.impulse = {from = 2.0, to = 1.0, count = 3}": "`from` below `to`",
    "[vary]\npush.impulse = {from = 0.0, to = 1.0, count = 3, scale = 'log'}": "`from` above 0",
    "[vary]\npush.impulse = {from = 0.0, to = 1.0}": "with a `count`",
    "[vary]\npush.impulse = {mean = 0.0, deviation = 1.0}": "a grid draws nothing",
    "[vary]\npush.impulse = {mean = 0.0, deviation = -1.0}": "`deviation` above 0",
    "sampling = 'grid'\nsamples = 5\n[vary]\npush.impulse = [1.0]": "no `samples` of a grid",
    "sampling = 'monte-carlo'\nsamples = 0\n[vary]\npush.impulse = [1.0]": "at least 1",
    "robt = 'h1'\n[vary]\npush.impulse = [1.0]": "robt",
    "step = nan\n[vary]\npush.impulse = [1.0]": "`step` above 0",
    "controller = 'pid'\n[vary]\npush.impulse = [1.0]": "a method",
    "[set]\npush.impulse = 1.0\n[vary]\npush.impulse = [1.0]": "in both",
}


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_study_is_refused(text: str, tmp_path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(sf.SurefootError) as error:
        load_study(path)
    assert WRONG[text] in str(error.value)
    if "method" not in WRONG[text]:
        assert "study.toml" in str(error.value)


def test_files_that_cannot_be_read(tmp_path) -> None:
    with pytest.raises(sf.FileError, match="a readable study"):
        load_study(tmp_path / "none.toml")
    (tmp_path / "half.toml").write_text("[vary\n")
    with pytest.raises(sf.FileError, match="a TOML document"):
        load_study(tmp_path / "half.toml")


def test_a_value_that_cannot_be_is_a_row_and_not_an_end(tmp_path) -> None:
    text = "[vary]\nrobot.mass = [68.0, -1.0]\ndisturbance.delay = [0.0, 0.0015, 0.002]\n"
    rows = rows_of(text, tmp_path / "table")
    outcomes = [row["outcome"] for row in rows]
    assert outcomes == ["walked", "refused", "walked", "refused", "refused", "refused"]
    assert "robot.mass" in rows[3]["error"]
    assert "whole number" in rows[1]["error"]


def test_the_last_row_of_many_may_be_of_another_kind(tmp_path) -> None:
    """Neither the reason for a refusal nor a fraction is lost behind a hundred others."""
    text = """
    controller = "tracking"
    [vary]
    robot.mass = [68.0, -1.0]
    push.phase = { from = 0.0, to = 0.5, count = 60 }
    push.angle = [0, 22.5]
    """
    rows = rows_of(text, tmp_path / "table")
    table = polars.read_parquet(tmp_path / "table" / "sweep.parquet")
    assert table["push.angle"].to_list() == [row["push.angle"] for row in rows]
    assert table["outcome"].value_counts().sort("outcome").rows() == [
        ("refused", 120), ("walked", 120),
    ]  # fmt: skip
    told: list[tuple[int, int]] = []
    again = rows_of(text, tmp_path / "table", report=lambda done, of: told.append((done, of)))
    assert told == [(240, 240)]
    for name in ("push.angle", "push.phase", "outcome", "error", "steps"):
        assert [row[name] for row in again] == [row[name] for row in rows]


def test_whole_numbers_are_drawn_whole_and_kept_exactly(tmp_path) -> None:
    text = """
    controller = "tracking"
    [vary]
    disturbance.seed = [1000000000001, 1000000000002]
    disturbance.dcm_noise = [0.001]
    push.step = { from = 1, to = 3, count = 3 }
    """
    rows = rows_of(text, tmp_path / "table")
    assert [row["push.step"] for row in rows] == [1, 2, 3] * 2
    assert len({row["dcm_error"] for row in rows[::3]}) == 2
    drawn = (
        text.replace("count = 3", "")
        .replace("to = 3,", "to = 3")
        .replace("[vary]", 'sampling = "monte-carlo"\nsamples = 30\n[vary]')
    )
    values = [cell.values for cell in parse_study(drawn).cells()]
    assert {type(step) for *_, step in values} == {int}
    assert len(rows_of(drawn, tmp_path / "drawn")) == 30


def test_what_is_set_wrong_is_refused_before_a_folder_is_begun(tmp_path) -> None:
    for line in ('push.impulse = "10"', "push.step = -1", 'robot.mass = "heavy"'):
        with pytest.raises(sf.SurefootError):
            rows_of(f"[set]\n{line}\n[vary]\npush.angle = [0.0]", tmp_path / "table")
        assert not (tmp_path / "table").exists()


def test_a_leg_without_a_limit_is_refused_and_not_a_failure(tmp_path) -> None:
    text = """measure = "push-limit"
    controller = "hybrid"
    [vary]
    robot.swing.max_speed = [0.4]"""
    found = run(parse_study(text), tmp_path / "table", workers=1)
    assert not found.failures
    assert found.rows[0]["outcome"] == "refused"
    assert "leg" in found.rows[0]["error"]


def test_more_values_of_the_same_study_measure_only_what_is_new(walked, tmp_path) -> None:
    folder = tmp_path / "table"
    rows_of(WALKS, folder)
    told: list[tuple[int, int]] = []
    more = WALKS.replace("80.0,", "80.0, 90.0,")
    rows_of(more, folder, report=lambda done, of: told.append((done, of)))
    assert told[0] == (32, 40)
    with pytest.raises(sf.FileError, match="a folder of the same study"):
        rows_of(WALKS.replace("0.25", "0.5"), folder)


def test_a_cell_that_could_not_be_measured_is_a_row(walked) -> None:
    study = parse_study(WALKS)
    cell = next(iter(study.cells()))
    row = study.failed(cell, "Traceback ...\nZeroDivisionError: a poisoned cell\n")
    assert row["outcome"] == "failed"
    assert row["error"] == "ZeroDivisionError: a poisoned cell"
    assert study.columns(cell).items() <= row.items()
    assert list(row) == list(walked[1][0])


def test_the_table_tells_where_it_comes_from(walked) -> None:
    folder, rows = walked
    assert len(polars.read_parquet(folder / "sweep.parquet")) == len(rows)
    notes = polars.read_parquet_metadata(folder / "sweep.parquet")
    about = json.loads(notes["surefoot.provenance"])
    assert (about["controller"], about["sampling"], about["seed"]) == ("hybrid", "grid", "0")
    study = json.loads(notes["surefoot.study"])
    assert study["fixed"] == {"robot.swing.max_speed": 3.0, "push.phase": 0.25}


def test_the_command(walked, tmp_path) -> None:
    folder, rows = walked
    study = tmp_path / "study.toml"
    study.write_text(WALKS)
    arguments = ["sweep", str(study), "--out", str(folder), "--workers", "1"]
    told = CliRunner().invoke(main, arguments)
    assert told.exit_code == 0, told.output
    assert "32 cells: 16 refused" in told.output
    numbers = json.loads(CliRunner().invoke(main, [*arguments, "--json"]).stdout)
    assert len(numbers["rows"]) == len(rows)
    assert numbers["varied"] == ["push.impulse", "push.angle", "gait.velocity.x"]
    bad = CliRunner().invoke(main, ["sweep", str(tmp_path / "none.toml")])
    assert bad.exit_code == 2
    assert "a readable study" in bad.output


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--plot", "PLOT", "--quantity", "impulse"), "a quantity of this table (survived, "),
        (("--plot", "PLOT", "--quantity", "stepz"), "did you mean `steps`"),
        (("--quantity", "steps"), "expected --plot with --quantity"),
    ],
)
def test_a_quantity_that_is_none_is_refused_before_anything_is_measured(
    options: tuple[str, ...], words: str, tmp_path
) -> None:
    study, folder = tmp_path / "study.toml", tmp_path / "table"
    study.write_text(WALKS)
    given = [str(tmp_path / "sweep.png") if one == "PLOT" else one for one in options]
    told = CliRunner().invoke(main, ["sweep", str(study), "--out", str(folder), *given])
    assert told.exit_code == 2
    assert words in told.output
    assert not folder.exists()


def test_a_robot_beside_the_study(tmp_path) -> None:
    text = (Path(sf.__file__).parent / "robot" / "presets" / "paper-biped.toml").read_text()
    (tmp_path / "mine.toml").write_text(text)
    (tmp_path / "study.toml").write_text('robot = "mine.toml"\n[vary]\npush.impulse = [10.0]\n')
    study = load_study(tmp_path / "study.toml")
    assert isinstance(study, Sweep)
    (row,) = run(study, tmp_path / "table", workers=1).rows
    assert row["outcome"] == "recovered"

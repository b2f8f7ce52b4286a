"""The engine of studies: rows survive a kill, failures are told, stamps know what rows are of."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import polars
import pytest

import surefoot as sf
from killed_studies import kill_when_kept, shards
from surefoot.studies.engine.study import OneByOne, Study, run
from surefoot.studies.engine.table import Shards


@dataclass(frozen=True)
class Cell:
    number: int
    share: float = 1.0 / 3.0


@dataclass(frozen=True)
class Squares(Study):
    """Squares of numbers; every third one cannot be measured."""

    numbers: tuple[int, ...] = (1, 2, 4)
    together: int = 1
    NAME: ClassVar[str] = "squares"
    KEEP_EVERY: ClassVar[float] = 0.0

    def cells(self) -> Iterator[Cell]:
        return (Cell(number) for number in self.numbers)

    def measure(self, cell: Cell) -> dict[str, Any]:
        if cell.number % 3 == 0:
            raise sf.RobotError("no multiple of three", str(cell.number), "leave it out")
        (
            Path(self.robot.name) / f"{cell.number}-{len(list(Path(self.robot.name).iterdir()))}"
        ).touch()
        return {"square": cell.number**2, "root": math.inf if cell.number == 4 else 1.0}

    def at_once(self) -> int:
        return self.together

    def common(self) -> dict[str, Any]:
        return {"what": "squares"}

    def provenance(self) -> dict[str, str]:
        return {"count": f"{len(self.numbers)}"}

    def notes(self, rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
        return {"largest": max(row["square"] for row in rows), "nothing": math.nan}


class Doubles(Squares):
    """What is even is measured as its half."""

    def measured_as(self, cell: Cell) -> Cell:
        return replace(cell, number=cell.number // 2) if cell.number % 2 == 0 else cell

    def failed(self, cell: Cell, error: str) -> dict[str, Any]:
        return {**self.columns(cell), "square": -1}


@pytest.fixture
def robot(tmp_path: Path) -> sf.Robot:
    """Its name is a folder, in which each measurement leaves a file."""
    (tmp_path / "log").mkdir()
    return sf.load_robot("paper-biped").replace(name=str(tmp_path / "log"))


def measured(robot: sf.Robot) -> list[int]:
    return sorted(int(path.name.split("-")[0]) for path in Path(robot.name).iterdir())


@pytest.mark.parametrize("together", [1, 2, 5])
def test_rows_stand_in_order_and_nothing_is_measured_twice(
    robot: sf.Robot, tmp_path: Path, together: int
) -> None:
    study = Squares(robot, (4, 1, 2, 1), together)
    found = run(study, tmp_path / "out", workers=1)
    assert [row["number"] for row in found.rows] == [4, 1, 2, 1]
    assert [row["square"] for row in found.rows] == [16, 1, 4, 1]
    assert measured(robot) == [1, 2, 4]
    again = run(replace(study, numbers=(2, 5)), tmp_path / "out", workers=1)
    assert [row["square"] for row in again.rows] == [4, 25]
    assert measured(robot) == [1, 2, 4, 5]


def test_cells_one_by_one_have_the_same_rows_in_the_same_folder(
    robot: sf.Robot, tmp_path: Path
) -> None:
    study, out = Squares(robot), tmp_path / "out"
    rows = OneByOne(study, out)
    assert [rows.row(Cell(number))["square"] for number in (4, 1, 4)] == [16, 1, 16]
    # What was asked for is on disk at once, and found there by whoever goes on.
    assert run(study, out, workers=1).rows == [OneByOne(study, out).row(Cell(n)) for n in (1, 2, 4)]
    assert measured(robot) == [1, 2, 4]
    found = rows.finished()
    assert [row["number"] for row in found.rows] == [4, 1]
    assert polars.read_parquet(out / "squares.parquet").to_dicts() == found.rows
    with pytest.raises(sf.RobotError, match="no multiple of three"):
        rows.row(Cell(3))


def test_a_table_says_where_it_is_from(robot: sf.Robot, tmp_path: Path) -> None:
    found = run(Squares(robot), tmp_path / "out", workers=1)
    path = tmp_path / "out" / "squares.parquet"
    assert polars.read_parquet(path).to_dicts() == found.rows
    notes = polars.read_parquet_metadata(path)
    assert json.loads(notes["surefoot.provenance"]) == found.provenance
    assert json.loads(notes["surefoot.largest"]) == found.notes["largest"] == 16
    names = list(found.provenance)
    assert names[:4] == ["version", "sources", "robot", "count"]
    assert {"python", "numpy", "numba", "machine", "date"} <= set(names)
    told = json.loads(json.dumps(found.as_numbers(), allow_nan=False))
    assert told["rows"][2] == {"number": 4, "share": 1.0 / 3.0, "square": 16, "root": None}
    assert (told["largest"], told["nothing"], told["failures"]) == (16, None, [])


@pytest.mark.parametrize("together", [1, 4])
def test_a_cell_that_cannot_be_measured_is_told_and_tried_again(
    robot: sf.Robot, tmp_path: Path, together: int
) -> None:
    found = run(Squares(robot, (1, 3, 4), together), tmp_path / "out", workers=1)
    assert [row["number"] for row in found.rows] == [1, 4]
    assert [one.cell for one in found.failures] == [Cell(3)]
    assert "no multiple of three" in found.failures[0].error
    assert found.as_numbers()["failures"][0]["number"] == 3
    with pytest.raises(sf.StudyError, match=r"no multiple of three.*mend that"):
        run(Squares(robot, (3, 6), together), tmp_path / "out", workers=1)


def test_cells_that_are_the_same_are_measured_once(robot: sf.Robot, tmp_path: Path) -> None:
    found = run(Doubles(robot, (1, 2, 5, 10, 6)), tmp_path / "out", workers=1)
    assert [(row["number"], row["square"]) for row in found.rows] == [
        (1, 1), (2, 1), (5, 25), (10, 25), (6, -1),
    ]  # fmt: skip
    assert measured(robot) == [1, 5]


def test_a_column_that_was_added_later_has_its_default(robot: sf.Robot, tmp_path: Path) -> None:
    found = run(Squares(robot), tmp_path / "out", workers=1)
    for path in (tmp_path / "out" / "shards").iterdir():
        path.unlink()
    common = json.loads((tmp_path / "out" / "run.json").read_text())
    older = [{name: value for name, value in row.items() if name != "share"} for row in found.rows]
    Shards(tmp_path / "out", common).add(older)
    assert run(Squares(robot), tmp_path / "out", workers=1).rows == older
    assert measured(robot) == [1, 2, 4]


def test_a_folder_of_other_questions_is_refused(robot: sf.Robot, tmp_path: Path) -> None:
    run(Squares(robot), tmp_path / "out", workers=1)
    with pytest.raises(sf.FileError, match=r"same study \(robot.*choose another folder"):
        run(Squares(robot.replace(mass=50.0)), tmp_path / "out", workers=1)
    assert measured(robot) == [1, 2, 4]


KILLED = """
import sys, time
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import surefoot as sf
from test_study import Squares
from surefoot.studies.engine.study import run
honest = Squares.measure
Squares.measure = lambda *a: (time.sleep(0.2), honest(*a))[1]
robot = sf.load_robot("paper-biped").replace(name=sys.argv[2])
run(Squares(robot, (1, 2, 4, 5, 7, 8)), Path(sys.argv[3]), workers=1)
"""


def test_a_killed_study_goes_on_and_repeats_nothing(robot: sf.Robot, tmp_path: Path) -> None:
    """kill -9 in the middle, three times; every finished cell is measured once."""
    here, folder, count = Path(__file__).parent, tmp_path / "out", 0
    for _ in range(3):
        count = kill_when_kept(KILLED, here, Path(robot.name), folder, count=count + 1)
    kept = [row["number"] for one in shards(folder) for row in polars.read_parquet(one).to_dicts()]
    assert 3 <= len(kept) < 6
    found = run(Squares(robot, (1, 2, 4, 5, 7, 8)), folder, workers=1)
    assert not found.failures
    assert [row["square"] for row in found.rows] == [1, 4, 16, 25, 49, 64]
    assert all(measured(robot).count(number) == 1 for number in kept)


def test_processes_measure_the_same(robot: sf.Robot, tmp_path: Path) -> None:
    study = Squares(robot, (1, 2, 3, 4, 5, 7))
    one, two = (run(study, tmp_path / f"{count}", workers=count) for count in (1, 2))
    assert one.rows == two.rows
    assert [failure.cell for failure in two.failures] == [Cell(3)]


def test_two_studies_add_to_one_table(tmp_path) -> None:
    """And a shard that was taken away is not written over."""
    first, second = (Shards(tmp_path / "table", {"what": "numbers"}) for _ in range(2))
    for number, one in enumerate([first, second, first]):
        one.add([{"number": number}])
    files = sorted((tmp_path / "table" / "shards").iterdir())
    assert len(files) == 3
    files[1].unlink()
    first.add([{"number": 3}])
    assert {row["number"] for row in Shards(tmp_path / "table", {"what": "numbers"}).rows} == {
        0,
        2,
        3,
    }


def test_a_full_disk_is_told_and_leaves_no_litter(tmp_path, monkeypatch) -> None:
    shards = Shards(tmp_path / "table", {"what": "numbers"})

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(sf.FileError, match=r"No space left .* free some space"):
        shards.add([{"number": 1}])
    assert list((tmp_path / "table" / "shards").iterdir()) == []


def test_a_broken_shard_is_named(tmp_path: Path) -> None:
    Shards(tmp_path / "table", {})
    (tmp_path / "table" / "shards" / "000000.parquet").write_bytes(b"PAR1 not really")
    with pytest.raises(sf.FileError, match=r"000000\.parquet.*delete that file"):
        Shards(tmp_path / "table", {})
    (tmp_path / "table" / "run.json").write_text("{")
    with pytest.raises(sf.FileError, match=r"run\.json.*delete it and its shards"):
        Shards(tmp_path / "table", {})

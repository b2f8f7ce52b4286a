"""A study: questions that are asked cell by cell, and everything that becomes of their answers.

A study is a folder with four files. `question` has a frozen dataclass made of `Study`: what is
asked, cell by cell. `measure` answers in one cell. `show` makes a `Report` of the rows. `command`
is what the user types. `run` here does the rest: it shares the cells among processes or the workers
of a cluster, keeps every finished row on disk, goes on where a killed run stopped, and writes one
table that says how to make it again.

    @dataclass(frozen=True)
    class Cell:
        mass: float

    @dataclass(frozen=True)
    class Falls(Study):
        masses: tuple[float, ...] = (50.0, 70.0)
        NAME: ClassVar = "falls"

        def cells(self) -> Iterator[Cell]:
            return (Cell(mass) for mass in self.masses)

        def measure(self, cell: Cell) -> Row:
            return {"fell": walk(self.robot.replace(mass=cell.mass)).fell}

    found = run(Falls(load_robot("paper-biped")), Path("falls"))
    found.rows  # [{"mass": 50.0, "fell": False}, ...], the columns of falls/falls.parquet
"""

from __future__ import annotations

import hashlib
import inspect
import platform
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field, fields
from datetime import date
from functools import partial
from importlib import metadata
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

from msgspec import to_builtins

from surefoot.compiled import source_stamp
from surefoot.errors import StudyError
from surefoot.robot.robot import Robot
from surefoot.studies.engine.table import Row, Shards, without_infinity, write_table
from surefoot.studies.engine.workers import Failure, Progress, Workers, measure_missing
from surefoot.version import VERSION

DIGITS = 12
"""Significant digits of a number by which a row is found again."""


@dataclass(frozen=True)
class Study:
    """Questions about a robot; a base for frozen dataclasses.

    A study says what its cells are and how one is measured. Cells are frozen dataclasses whose
    fields are columns of the table. A study and its cells go to other processes, so they are plain
    values, and `measure` may depend on nothing else.

    Attributes:
        robot: who walks.
        NAME: of the table, without its ending.
        KEEP_EVERY: a finished cell waits no longer than this to be written to disk [s].
        LIBRARIES: whose versions the table names.
    """

    robot: Robot

    NAME: ClassVar[str]
    KEEP_EVERY: ClassVar[float] = 5.0
    LIBRARIES: ClassVar[tuple[str, ...]] = ("numpy", "numba")

    def cells(self) -> Iterable[Any]:
        """Everything that is asked, in the order of the table."""
        raise NotImplementedError

    def measure(self, cell: Any) -> Row:
        """What was measured in a cell, by the names of its columns; in any process.

        Whatever it raises becomes a `Failure` of this cell, and the others go on.
        """
        raise NotImplementedError

    def measure_many(self, cells: Sequence[Any]) -> list[Row | str]:
        """The same for at most `at_once()` cells: for each its row, or why there is none.

        If it raises, each of them is measured alone.
        """
        return [self.measure(cell) for cell in cells]

    def at_once(self) -> int:
        """How many cells are measured together, at most; 1 unless that is faster."""
        return 1

    def columns(self, cell: Any) -> Row:
        """The columns that say which cell a row is of; its fields, unless a study says otherwise.

        Their values are its key, by which a row is found again in the folder.
        """
        return asdict(cell)

    def measured_as(self, cell: Any) -> Any:
        """The cell that is measured for this one: itself, or one that is known to be the same."""
        return cell

    def answer(self, cell: Any, row: Row) -> Row:
        """The row of a cell for which another one was measured, made of that one's row."""
        return row | self.columns(cell)

    def failed(self, cell: Any, error: str) -> Row | None:
        """The row of a cell that could not be measured; None to leave it out of the table."""
        return None

    def foreign_sources(self) -> dict[str, str]:
        """The content of what packages other than Surefoot bring to the rows, such as a control
        method, by name; "" if there is none. A row holds as long as this and `stamp` do."""
        return {}

    def common(self) -> dict[str, Any]:
        """What all rows of one folder have in common, as plain values, beside the robot, the
        version and the sources. A folder with other values is refused."""
        return {}

    def provenance(self) -> dict[str, str]:
        """What the table says of itself in words, beside version, sources, robot, libraries,
        machine and date."""
        return {}

    def notes(self, rows: Sequence[Row]) -> dict[str, Any]:
        """What else is known of all rows, as plain values; kept in the file and in `Measured`."""
        return {}

    def check(self) -> None:
        """Refuse what cannot be measured at all, before a folder is begun with it.

        Raises:
            SurefootError: for example, a method cannot control this robot.
        """


S = TypeVar("S", bound=Study)


@dataclass(frozen=True)
class Measured(Generic[S]):
    """What a study measured.

    Attributes:
        study: what was asked.
        rows: a row for each cell, in the order of `Study.cells`.
        failures: cells that could not be measured, and why.
        provenance: what the table says of itself, to be made again.
        notes: of `Study.notes`.
    """

    study: S
    rows: list[Row]
    failures: list[Failure]
    provenance: dict[str, str]
    notes: dict[str, Any] = field(default_factory=dict)

    def as_numbers(self) -> dict[str, Any]:
        """All of it for JSON, which has no word for infinity: null."""
        failures = [{**self.study.columns(one.cell), "error": one.error} for one in self.failures]
        numbers = {"rows": self.rows, **self.notes, "failures": failures}
        return without_infinity(numbers) | {"provenance": self.provenance}


def run(
    study: S, folder: Path, *, workers: int | Workers = -1, report: Progress | None = None
) -> Measured[S]:
    """Measure what is missing, and write the table into `folder`/NAME.parquet.

    The rows do not depend on who measures them, nor in which order. The same call tries those
    cells again that could not be measured.

    Args:
        study: what is asked.
        folder: keeps the rows; some of the same robot, version and sources may be there already.
        workers: processes, -1 for all cores; or who works instead, such as a `Cluster`.
        report: called with the number of cells that are there, and that of all.

    Raises:
        ParameterError: no workers.
        FileError: the folder cannot be written to, or holds rows of another study.
        StudyError: nothing could be measured, or a cluster was lost.
        MissingExtraError: joblib, polars or the library of a method is not installed.
        SurefootError: see `Study.check`.
    """
    study.check()
    cells = list(study.cells())
    shards = Shards(folder, _common(study))
    have = _kept(study, shards, cells[0]) if cells else {}
    wanted = {_key_of(study, one): one for one in map(study.measured_as, cells)}
    failures = measure_missing(
        partial(_rows, study), wanted, have, shards, workers=workers, at_once=study.at_once(),
        keep_every=study.KEEP_EVERY, report=report,
    )  # fmt: skip
    errors = {_key_of(study, one.cell): one.error for one in failures}
    rows = [row for cell in cells if (row := _row_of(study, cell, have, errors)) is not None]
    if cells and not rows:
        raise StudyError(
            "a cell that can be measured", failures[0].error.strip(), "mend that, and try again"
        )
    return _finished(study, folder, rows, failures)


class OneByOne(Generic[S]):
    """A study whose next cell depends on the rows before, such as a search.

    Such a study has no `cells`. A cell is measured when its row is asked for, in this process, and
    is on disk before the next one; a row that the folder has is not measured again. So the same
    questions in the same order go on where a killed process stopped.

    Args:
        study: what is asked.
        folder: see `run`.

    Raises:
        SurefootError: see `run`.
    """

    def __init__(self, study: S, folder: Path) -> None:
        study.check()
        self.study, self.folder = study, folder
        self._shards = Shards(folder, _common(study))
        self._have: dict[Any, Row] | None = None
        self._asked: dict[Any, Row] = {}

    def row(self, cell: Any) -> Row:
        """The row of a cell; whatever `Study.measure` raises is raised."""
        if self._have is None:
            self._have = _kept(self.study, self._shards, cell)
        key = _key_of(self.study, cell)
        if key not in self._have:
            self._have[key] = self.study.columns(cell) | self.study.measure(cell)
            self._shards.add([self._have[key]])
        self._asked[key] = self._have[key]
        return self._have[key]

    def finished(self) -> Measured[S]:
        """All rows that were asked for, in that order; written into `folder`/NAME.parquet."""
        return _finished(self.study, self.folder, list(self._asked.values()), [])


def stamp(kind: type) -> str:
    """All sources that a row depends on, as a hash: the kernels, this engine, and the folder of
    whoever asks.

    Args:
        kind: the class of a study, or whatever else asks; its folder is found from it, and those of
            the studies that it is made of.

    Raises:
        StudyError: the class is in no file, so that its changes cannot be noticed.
    """
    digest = hashlib.sha256(source_stamp().encode())
    asking = [base for base in kind.__mro__ if base is kind or issubclass(base, Study)]
    try:
        folders = {Path(inspect.getfile(base)).parent for base in asking}
    except (TypeError, OSError) as error:
        raise StudyError(
            "a study whose class is in a file", f"{kind.__name__}: {error}", "write it into one"
        ) from error
    for folder in sorted({Path(__file__).parent, *folders}):
        for path in sorted(folder.glob("*.py")):
            digest.update(f"{folder.name}/{path.name}".encode() + path.read_bytes())
    return digest.hexdigest()


def installed_version(name: str) -> str:
    """The version of a library, or "none"."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "none"


def made_with(*libraries: str) -> dict[str, str]:
    """What a study was made with, where and when.

    Args:
        *libraries: whose versions matter.
    """
    return {
        "python": platform.python_version(),
        **{name: installed_version(name) for name in libraries},
        "machine": f"{platform.system()} {platform.machine()}",
        "date": date.today().isoformat(),
    }


def _kept(study: Study, shards: Shards, cell: Any) -> dict[Any, Row]:
    """The rows of a folder by key; `cell` is any cell of the study."""
    # A row that was made before a column of its cell was thought of has the column's default.
    usual = {one.name: one.default for one in fields(cell)}
    names = list(study.columns(cell))
    return {_key([row.get(name, usual.get(name)) for name in names]): row for row in shards.rows}


def _finished(study: S, folder: Path, rows: list[Row], failures: list[Failure]) -> Measured[S]:
    """What was measured, and the table of it."""
    about, notes = _provenance(study), study.notes(rows)
    write_table(rows, folder / f"{study.NAME}.parquet", {"provenance": about, **notes})
    return Measured(study, rows, failures, about, notes)


def _rows(study: Study, cells: Sequence[Any]) -> list[Row | str]:
    """The columns of some cells with what was measured in them; text where that failed."""
    return [
        found if isinstance(found, str) else study.columns(cell) | found
        for cell, found in zip(cells, study.measure_many(cells), strict=True)
    ]


def _row_of(study: Study, cell: Any, have: dict[Any, Row], errors: dict[Any, str]) -> Row | None:
    measured = study.measured_as(cell)
    key = _key_of(study, measured)
    if key not in have:
        return study.failed(cell, errors[key])
    return have[key] if measured == cell else study.answer(cell, have[key])


def _key_of(study: Study, cell: Any) -> Any:
    return _key(list(study.columns(cell).values()))


def _key(value: Any) -> Any:
    """A value as part of a key; numbers rounded, so that they survive a file."""
    if isinstance(value, (list, tuple)):
        return tuple(map(_key, value))
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def _common(study: Study) -> dict[str, Any]:
    foreign = {f"sources of {one}": what for one, what in study.foreign_sources().items() if what}
    return {
        "robot": to_builtins(study.robot),
        **study.common(),
        "version": VERSION,
        "sources": stamp(type(study)),
        **foreign,
    }


def _provenance(study: Study) -> dict[str, str]:
    return {
        "version": VERSION,
        "sources": stamp(type(study))[:16],
        "robot": study.robot.name,
        **study.provenance(),
        **made_with(*study.LIBRARIES),
    }

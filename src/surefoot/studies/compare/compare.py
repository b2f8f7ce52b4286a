"""Compare control methods: the smallest push that each fails on, beside the limit for anybody.

Cells are shared among processes; every finished one is kept, so a study that was stopped goes on
where it was.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from surefoot.control.registry import find_method
from surefoot.errors import MissingExtraError, RobotError, StudyError
from surefoot.robot.robot import Robot
from surefoot.studies.compare.conditions import condition
from surefoot.studies.compare.measure import controller_of, decision_times, limits_of, measure
from surefoot.studies.compare.question import Cell, Protocol, cell_key, every_method
from surefoot.studies.compare.remarks import remarks
from surefoot.studies.engine.cells import Failure, measure_missing, without_infinity
from surefoot.studies.engine.provenance import installed_version, made_with, sources_stamp
from surefoot.studies.engine.table import Shards, write_table
from surefoot.version import VERSION

TABLE = "compare.parquet"
"""The name of the table in its folder."""

KEEP_EVERY = 5.0
"""A finished cell waits no longer than this to be written to disk [s]."""

TIMING_IMPULSE = 0.6
"""Decision times are taken under a push of this fraction of the smallest that fails."""


SOLVERS = ("daqp", "casadi")
"""Libraries that decide for some methods."""

TOLD = ("key", "label", "source", "adapts", "cannot")
"""What a table says of a method."""


@dataclass(frozen=True)
class Comparison:
    """What was measured, as plain data for whoever shows it.

    Attributes:
        rows: see `measure`.
        methods: see `methods_of`.
        disturbances: key and label of each that was asked for, and how many walks it took.
        provenance: what the table says of itself.
        remarks: what it says of the paper's own comparison, in paragraphs.
        failures: cells that could not be measured.
    """

    rows: list[dict[str, Any]]
    methods: list[dict[str, Any]]
    disturbances: list[dict[str, Any]]
    provenance: dict[str, str]
    remarks: list[str]
    failures: list[Failure]

    def as_numbers(self) -> dict[str, Any]:
        """All of it for JSON, which has no word for infinity: null, for a leg without a limit or a
        scan on which nothing failed."""
        return {
            "rows": [without_infinity(row) for row in self.rows],
            "methods": [without_infinity(row) for row in self.methods],
            "disturbances": self.disturbances,
            "provenance": self.provenance,
            "remarks": self.remarks,
            "failures": [{**asdict(one.cell), "error": one.error} for one in self.failures],
        }


def compare_methods(
    protocol: Protocol,
    folder: Path,
    *,
    workers: int = -1,
    report: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Measure what is missing, and write the table into `folder`/compare.parquet.

    Args:
        protocol: the questions.
        folder: keeps the rows; rows of the same robot, velocity and version may be there already.
        workers: processes, -1 for all cores.
        report: called with the number of cells that are there, and that of all.

    Raises:
        ParameterError: no workers.
        FileError: the folder cannot be written to, or holds rows of another study.
        StudyError: nothing could be measured.
        MissingExtraError: joblib, polars or the library of a method is not installed.
        SurefootError: a method cannot control this robot.
    """
    for key in protocol.methods:
        controller_of(protocol, key, protocol.leg_speeds[0])  # refused now rather than cell by cell
    shards = open_shards(protocol, folder)
    rows, failures = run_comparison(protocol, shards, workers=workers, report=report)
    if not rows:
        raise StudyError(
            "a cell that can be measured", failures[0].error.strip(), "mend that, and try again"
        )
    about = provenance(protocol)
    write_table(rows, folder / TABLE, {"provenance": about})
    methods = methods_of(protocol, rows)
    wrong = disturbances_of(protocol)
    notes = {"provenance": about, "methods": methods, "disturbances": wrong}
    write_table(rows, folder / TABLE, notes)
    # The paper disturbs nothing but the robot.
    said = remarks(rows) if protocol.must_settle else []
    return Comparison(rows, methods, wrong, about, said, failures)


def open_shards(protocol: Protocol, folder: Path) -> Shards:
    """The growing table of a comparison in a folder.

    Raises:
        FileError: the folder cannot be written to, or holds rows of another study.
        MissingExtraError: polars is not installed.
    """
    common = {
        **protocol.same_for_all(),
        "version": VERSION,
        "sources": study_stamp(),
        "solvers": {name: installed_version(name) for name in SOLVERS},
    }
    return Shards(folder, common)


def run_comparison(
    protocol: Protocol,
    shards: Shards,
    *,
    workers: int = -1,
    report: Callable[[int, int], None] | None = None,
) -> tuple[list[dict[str, Any]], list[Failure]]:
    """Measure every cell that is not there yet; a study that is stopped keeps what it has.

    Args:
        protocol: the questions.
        shards: keeps the rows.
        workers: processes, -1 for all cores.
        report: called with the number of cells that are there, and that of all.

    Returns:
        The rows of this protocol, in its order, and the cells that could not be measured.

    Raises:
        ParameterError: no workers.
        MissingExtraError: joblib is not installed.
    """
    have = {cell_key(_cell_of(row)): row for row in shards.rows}
    wanted = {cell_key(cell): cell for cell in protocol.cells()}
    # Cells that are walked alike are walked once.
    walks = {cell_key(walked): walked for walked in map(protocol.walked, wanted.values())}
    failures = measure_missing(
        measure, protocol, walks, have, shards,
        workers=workers, keep_every=KEEP_EVERY, report=report,
    )  # fmt: skip
    rows = []
    for cell in wanted.values():
        walked = protocol.walked(cell)
        row = have.get(cell_key(walked))
        if row is not None:
            # A walk that stands for another leg has the impulse of that leg, but not its limits.
            other = {} if walked == cell else asdict(cell) | limits_of(protocol, cell)
            rows.append(row | other)
    return rows, failures


def _cell_of(row: dict[str, Any]) -> Cell:
    # Tables of older versions know no disturbance.
    return Cell(**{name: row[name] for name in Cell.__dataclass_fields__ if name in row})


def methods_of(protocol: Protocol, rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """What a reader is told of each method that was measured, with the time that a cycle takes."""
    told, rows = [], list(rows)
    for key in protocol.methods:
        own = [row for row in rows if row["method"] == key]
        if own:
            words = {name: getattr(find_method(key), name) for name in TOLD}
            failing = min(min(row["impulse"], row["scanned"]) for row in own)
            told.append(words | decision_times(protocol, key, TIMING_IMPULSE * failing))
    return told


def disturbances_of(protocol: Protocol) -> list[dict[str, Any]]:
    """What a reader is told of each disturbance: `key`, `label`, and how many `walks` a scan of it
    takes, the worst of which counts."""
    return [
        {"key": one.key, "label": one.label, "walks": len(one.walks(protocol.seeds))}
        for one in map(condition, protocol.disturbances)
    ]


def able_methods(robot: Robot, velocity: tuple[float, float]) -> tuple[list[str], dict[str, str]]:
    """Which methods can be compared on a robot at a velocity [m/s], and why the others cannot.

    Returns:
        Their keys, but for the slow ones; and by its key, the reason of each that is left out.
    """
    able, left_out = [], {}
    for key in every_method():
        try:
            find_method(key).controller(robot, velocity)
        except (RobotError, MissingExtraError) as error:
            left_out[key] = str(error)
        else:
            able.append(key)
    return able, left_out


def study_stamp() -> str:
    """All sources that a row depends on, as a hash: the kernels, and what asks the questions."""
    return sources_stamp("compare")


def provenance(protocol: Protocol) -> dict[str, str]:
    """What a table must say of itself to be made again."""
    return {
        "version": VERSION,
        "sources": study_stamp()[:16],
        "robot": protocol.robot.name,
        "mass": f"{protocol.robot.mass:g} kg",
        "velocity": f"{protocol.velocity[0]:g}, {protocol.velocity[1]:g} m/s",
        **made_with("numpy", "numba", *SOLVERS),
    }

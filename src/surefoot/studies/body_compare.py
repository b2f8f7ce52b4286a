"""Compare methods on a body in physics: the smallest push that fells each of them.

Cells are shared among processes; every finished one is kept, so a study that was stopped goes on
where it was. Its rows do not depend on how many work on it.
"""

from __future__ import annotations

import hashlib
import math
import multiprocessing
import platform
import signal
import traceback
from collections.abc import Callable, Iterator
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass
from datetime import date
from pathlib import Path
from typing import Any

import msgspec

from surefoot.checks import optional_module
from surefoot.compiling import source_stamp
from surefoot.errors import StudyError, SurefootError
from surefoot.models.robot import Robot
from surefoot.studies.body_protocol import (
    PUSH_DURATION,
    RECOVERY_TIME,
    BodyCell,
    BodyProtocol,
    body_method,
    cell_key,
)
from surefoot.studies.body_push import controller_of, measure, mechanism_of
from surefoot.studies.compare import check_workers, installed_version
from surefoot.studies.shards import Shards, write_table
from surefoot.version import VERSION

TABLE = "pushes.parquet"
"""The name of the table of a robot in its folder."""

LIBRARIES = ("mujoco", "daqp", "numpy", "numba")
"""What else a row depends on."""


@dataclass(frozen=True)
class BodyFailure:
    """A cell that could not be measured, and why."""

    cell: BodyCell
    error: str


@dataclass(frozen=True)
class BodyComparison:
    """What was measured on one robot, as plain data for whoever shows it.

    Attributes:
        rows: see `studies.body_push.measure`.
        methods: `key`, `label` and `adapts` of each, in the order in which they are shown.
        mass: that Δv is of [kg].
        step: of the scans [N s].
        provenance: what the table says of itself.
        failures: cells that could not be measured.
    """

    rows: list[dict[str, Any]]
    methods: list[dict[str, str]]
    mass: float
    step: float
    provenance: dict[str, str]
    failures: list[BodyFailure]

    def as_numbers(self) -> dict[str, Any]:
        """All of it for JSON, which has no word for infinity: null, where nothing failed."""
        rows = [
            {
                name: None if isinstance(value, float) and math.isinf(value) else value
                for name, value in row.items()
            }
            for row in self.rows
        ]
        failures = [{**asdict(one.cell), "error": one.error} for one in self.failures]
        return asdict(self) | {"rows": rows, "failures": failures}


def compare_on_body(
    protocol: BodyProtocol,
    folder: Path,
    *,
    workers: int = -1,
    report: Callable[[int, int], None] | None = None,
) -> BodyComparison:
    """Measure what is missing, and write the table into `folder`/pushes.parquet.

    Args:
        protocol: the questions.
        folder: keeps the rows; rows of the same robot, velocity and version may be there already.
        workers: processes, -1 for all cores.
        report: called with the number of cells that are there, and that of all.

    Raises:
        ParameterError: no workers.
        FileError: the folder cannot be written to, or holds rows of another study.
        StudyError: nothing could be measured, or a worker was killed.
        MissingExtraError: joblib, polars, mujoco or daqp is not installed.
        SurefootError: a method cannot control this robot.
    """
    check_workers(workers)
    for key in protocol.methods:
        controller_of(protocol, key)  # refused now rather than cell by cell
    shards = Shards(folder, protocol.same_for_all() | {"version": VERSION, "sources": stamp()})
    rows, failures = run_cells(protocol, shards, workers=workers, report=report)
    if not rows:
        raise StudyError(
            "a cell that can be measured", failures[0].error.strip(), "mend that, and try again"
        )
    about = provenance(protocol)
    told = [
        {"key": one.key, "label": one.label, "adapts": one.adapts}
        for one in map(body_method, protocol.methods)
    ]
    write_table(rows, folder / TABLE, {"provenance": about, "methods": told})
    mass = mechanism_of(protocol.robot).mass
    return BodyComparison(rows, told, mass, protocol.step, about, failures)


def _measured(protocol: BodyProtocol, cell: BodyCell) -> tuple[BodyCell, dict[str, Any] | str]:
    """`measure` for another process: an error comes back as text, with its cell."""
    if multiprocessing.parent_process() is not None:
        # Ctrl-C is for the study, which keeps what it has and ends its workers.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        return cell, measure(protocol, cell)
    except SurefootError as error:
        return cell, str(error)
    except Exception:  # whatever it is, the other cells go on and this one is reported
        return cell, traceback.format_exc()


def run_cells(
    protocol: BodyProtocol,
    shards: Shards,
    *,
    workers: int = -1,
    report: Callable[[int, int], None] | None = None,
) -> tuple[list[dict[str, Any]], list[BodyFailure]]:
    """Measure every cell that is not there yet; each is kept as soon as it is done.

    Args:
        protocol: the questions.
        shards: keeps the rows.
        workers: processes, -1 for all cores.
        report: called with the number of cells that are there, and that of all.

    Returns:
        The rows of this protocol, in its order, and the cells that could not be measured.

    Raises:
        ParameterError: no workers.
        StudyError: a worker was killed from outside.
        MissingExtraError: joblib is not installed.
    """
    check_workers(workers)
    have = {cell_key(_cell_of(row)): row for row in shards.rows}
    wanted = {cell_key(cell): cell for cell in protocol.cells()}
    missing = [cell for key, cell in wanted.items() if key not in have]
    failures: list[BodyFailure] = []
    if report is not None:
        report(len(wanted) - len(missing), len(wanted))
    try:
        for done, (cell, result) in enumerate(_parallel(protocol, missing, workers), start=1):
            if isinstance(result, str):
                failures.append(BodyFailure(cell, result))
            else:
                shards.add([result])
                have[cell_key(cell)] = result
            if report is not None:
                report(len(wanted) - len(missing) + done, len(wanted))
    except BrokenProcessPool as error:
        raise StudyError(
            "workers that live as long as their study",
            "one that was killed, perhaps for want of memory",
            "what is measured is kept: give the same command again, with fewer --workers",
        ) from error
    return [have[key] for key in wanted if key in have], failures


def _cell_of(row: dict[str, Any]) -> BodyCell:
    return BodyCell(**{name: row[name] for name in BodyCell.__dataclass_fields__})


def _parallel(
    protocol: BodyProtocol, cells: list[BodyCell], workers: int
) -> Iterator[tuple[BodyCell, dict[str, Any] | str]]:
    joblib = optional_module("joblib", "studies on all cores", "study")
    jobs = (joblib.delayed(_measured)(protocol, cell) for cell in cells)
    yield from joblib.Parallel(n_jobs=workers, return_as="generator_unordered")(jobs)


def stamp() -> str:
    """All sources that a row depends on, as a hash: the kernels, and what asks the questions."""
    digest = hashlib.sha256(source_stamp().encode())
    for name in ("body_protocol", "body_push"):
        digest.update((Path(__file__).parent / f"{name}.py").read_bytes())
    return digest.hexdigest()


def robot_hash(robot: Robot) -> str:
    """The content of a robot's file as a hash, whatever its layout."""
    return hashlib.sha256(msgspec.json.encode(robot)).hexdigest()[:16]


def provenance(protocol: BodyProtocol) -> dict[str, str]:
    """What a table must say of itself to be made again."""
    vx, vy = protocol.velocity
    return {
        "version": VERSION,
        "sources": stamp()[:16],
        "robot": protocol.robot.name,
        "robot file": robot_hash(protocol.robot),
        "mass": f"{mechanism_of(protocol.robot).mass:.4g} kg",
        "velocity": f"{vx:g}, {vy:g} m/s",
        "push": f"{PUSH_DURATION:g} s on the trunk; {RECOVERY_TIME:g} s of walking after it",
        "scan": f"{protocol.step:g} N s, upwards from 0 to {protocol.largest:g} m/s",
        "phases": f"{protocol.phases}, in steps of both feet",
        "state": "estimated from its sensors" if protocol.estimate else "the truth",
        "python": platform.python_version(),
        **{name: installed_version(name) for name in LIBRARIES},
        "machine": f"{platform.system()} {platform.machine()}",
        "date": date.today().isoformat(),
    }

"""Compare methods on a body in physics: the smallest push that fells each of them.

Cells are shared among processes; every finished one is kept, so a study that was stopped goes on
where it was. Its rows do not depend on how many work on it.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from surefoot.errors import StudyError
from surefoot.robot.robot import Robot
from surefoot.studies.compare.body_protocol import (
    PUSH_DURATION,
    RECOVERY_TIME,
    BodyCell,
    BodyProtocol,
    body_method,
)
from surefoot.studies.compare.body_push import controller_of, measure, mechanism_of
from surefoot.studies.engine.cells import (
    Failure,
    Report,
    run_cells,
    study_as_numbers,
)
from surefoot.studies.engine.provenance import made_with, sources_stamp
from surefoot.studies.engine.table import Shards, write_table
from surefoot.version import VERSION

TABLE = "pushes.parquet"
"""The name of the table of a robot in its folder."""

LIBRARIES = ("mujoco", "daqp", "numpy", "numba")
"""What else a row depends on."""


@dataclass(frozen=True)
class BodyComparison:
    """What was measured on one robot, as plain data for whoever shows it.

    Attributes:
        rows: see `studies.compare.body_push.measure`.
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
    failures: list[Failure]

    def as_numbers(self) -> dict[str, Any]:
        """All of it for JSON; infinity, where nothing failed, is null."""
        return study_as_numbers(self)


def compare_on_body(
    protocol: BodyProtocol,
    folder: Path,
    *,
    workers: int = -1,
    report: Report | None = None,
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
        StudyError: nothing could be measured.
        MissingExtraError: joblib, polars, mujoco or daqp is not installed.
        SurefootError: a method cannot control this robot.
    """
    for key in protocol.methods:
        controller_of(protocol, key)  # refused now rather than cell by cell
    shards = Shards(folder, protocol.same_for_all() | {"version": VERSION, "sources": stamp()})
    rows, failures = run_cells(measure, BodyCell, protocol, shards, workers=workers, report=report)
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


def stamp() -> str:
    """All sources that a row depends on, as a hash: the kernels, and what asks the questions."""
    return sources_stamp("compare")


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
        "push": f"{PUSH_DURATION:g} s on the base; {RECOVERY_TIME:g} s of walking after it",
        "scan": f"{protocol.step:g} N s, upwards from 0 to {protocol.largest:g} m/s",
        "phases": f"{protocol.phases}, in steps of both feet",
        "state": f"estimated from {protocol.noise}" if protocol.estimate else "the truth",
        **made_with(*LIBRARIES),
    }

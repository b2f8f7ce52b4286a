"""Run a study: measure its cells wherever there are workers, and keep every row that is done."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from surefoot.control.registry import find_method
from surefoot.errors import RobotError, VelocityError
from surefoot.robot.robot import Robot, load_robot
from surefoot.studies.engine.cells import Failure, Row, measure_missing
from surefoot.studies.engine.provenance import made_with
from surefoot.studies.engine.study import stamp
from surefoot.studies.engine.table import Shards, write_table
from surefoot.studies.engine.workers import Processes, Workers
from surefoot.studies.sweep.sweep_cell import Sweep, measure_cells
from surefoot.studies.sweep.sweep_parameters import situation
from surefoot.studies.sweep.sweep_sampling import SweepCell, cell_key, sweep_cells
from surefoot.studies.sweep.sweep_study import Study
from surefoot.version import VERSION

TABLE = "sweep.parquet"
"""The name of the table in its folder."""

KEEP_EVERY = 5.0
"""A finished cell waits no longer than this to be written to disk [s]."""

AT_ONCE = 64
"""Walks of one task: enough that sending it is nothing beside walking."""


@dataclass(frozen=True)
class SweepTable:
    """What was measured.

    Attributes:
        study: the questions.
        rows: a row for each cell, in the order of the study; see `sweep_cell`.
        failures: cells that could not be measured.
        provenance: what the table says of itself.
    """

    study: Study
    rows: list[Row]
    failures: list[Failure]
    provenance: dict[str, str]


def run_sweep(
    study: Study,
    folder: Path,
    *,
    workers: Workers | None = None,
    report: Callable[[int, int], None] | None = None,
) -> SweepTable:
    """Measure what is missing, and write the table into `folder`/sweep.parquet.

    The rows do not depend on who measures them, nor in which order. Cells that could not be
    measured are in the table too, with the reason; the same call tries them again.

    Args:
        study: the questions.
        folder: keeps the rows; rows of the same study may be there already.
        workers: who measures, all cores of this machine if None.
        report: called with the number of cells that are there, and that of all.

    Raises:
        RobotError: the robot cannot be read.
        ParameterError: the method cannot be used.
        FileError: the folder cannot be written to, or holds rows of another study.
        StudyError: a cluster was lost.
        MissingExtraError: joblib, polars or the library of a method is not installed.
    """
    robot = load_robot(study.robot)
    workers = workers or Processes()
    sweep = Sweep(study, robot)
    # A method that cannot be used at all is refused now rather than cell by cell.
    _check_fixed(study, robot)
    compiled = find_method(study.controller).controller(robot, (0.0, 0.0)).kernel is not None
    wanted = list(sweep_cells(study))
    # What is drawn from lists may come twice; it is measured once.
    cells = {cell_key(cell.values): cell for cell in wanted}
    shards = Shards(folder, _common(study, robot))
    have = {cell_key(tuple(row[name] for name in study.vary)): row for row in shards.rows}
    failures = measure_missing(
        measure_cells,
        sweep,
        cells,
        have,
        shards,
        workers=workers,
        at_once=AT_ONCE if compiled and study.measure == "walk" else 1,
        keep_every=KEEP_EVERY,
        report=report,
    )
    errors = {cell_key(one.cell.values): one.error for one in failures}
    rows = []
    for cell in wanted:
        key = cell_key(cell.values)
        rows.append(have[key] if key in have else _failed(sweep, cell, errors[key]))
    about = _provenance(study, robot)
    write_table(rows, folder / TABLE, {"study": _plain(study), "provenance": about})
    return SweepTable(study, rows, failures, about)


def _check_fixed(study: Study, robot: Robot) -> None:
    """Refuse what is set for all cells if it makes no sense, before a folder is begun with it.

    Raises:
        ParameterError: a value has another type, or is out of range.
    """
    # What varies may be what makes a robot or a velocity possible.
    with contextlib.suppress(RobotError, VelocityError):
        situation(robot, study.controller, study.fixed)


def _failed(sweep: Sweep, cell: SweepCell, error: str) -> Row:
    lines = error.strip().splitlines()
    return {**sweep.row(cell), "outcome": "failed", "error": lines[-1] if lines else error}


def _plain(study: Study) -> dict[str, Any]:
    return msgspec.to_builtins(study)


def _common(study: Study, robot: Robot) -> dict[str, Any]:
    """What all rows of one table must have in common: everything but which values are taken."""
    asked = {
        name: value
        for name, value in _plain(study).items()
        if name not in ("title", "vary", "samples", "seed", "sampling", "robot")
    }
    return {
        **asked,
        "varied": list(study.vary),
        "robot": msgspec.to_builtins(robot),
        "version": VERSION,
        "sources": _stamp(),
    }


def _stamp() -> str:
    """All sources that a row depends on, as a hash: the kernels, and what asks the questions."""
    return stamp(Study)


def _provenance(study: Study, robot: Robot) -> dict[str, str]:
    """What a table must say of itself to be made again."""
    return {
        "version": VERSION,
        "sources": _stamp()[:16],
        "robot": robot.name,
        "controller": study.controller,
        "sampling": study.sampling,
        "seed": str(study.seed),
        **made_with("numpy", "numba"),
    }

"""Cells of a study shared among processes; every finished one is kept as soon as it may be."""

from __future__ import annotations

import math
import multiprocessing
import signal
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, fields
from typing import Any

from surefoot.checks import optional_module
from surefoot.errors import ParameterError, StudyError, SurefootError
from surefoot.studies.shards import Shards

Row = dict[str, Any]

Measure = Callable[[Any, Any], Row]
"""Makes a row of a protocol and one of its cells."""

Report = Callable[[int, int], None]
"""Called with the number of cells that are there, and that of all."""


@dataclass(frozen=True)
class Failure:
    """A cell that could not be measured, and why."""

    cell: Any
    error: str


def without_infinity(row: Row) -> Row:
    """A row for JSON, which has no word for infinity, nor for what is no number: null."""
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in row.items()
    }


def study_as_numbers(study: Any) -> dict[str, Any]:
    """A study for JSON: a dataclass whose `rows` and `failures` are those of `run_cells`."""
    rows = [without_infinity(row) for row in study.rows]
    failures = [{**asdict(one.cell), "error": one.error} for one in study.failures]
    return asdict(study) | {"rows": rows, "failures": failures}


def check_workers(workers: int) -> None:
    """Refuse a study that nobody works on.

    Raises:
        ParameterError: no workers.
    """
    if workers == 0:
        raise ParameterError("a number of workers", "0", "leave it out for all cores")


def run_cells(
    ask: Measure,
    kind: type,
    protocol: Any,
    shards: Shards,
    *,
    workers: int = -1,
    report: Report | None = None,
) -> tuple[list[Row], list[Failure]]:
    """Measure every cell that is not there yet; each is kept as soon as it is done.

    Args:
        ask: makes a row of a protocol and one of its cells, in any process.
        kind: of the cells, a dataclass; its fields are in the row.
        protocol: the questions; its `cells()` are to be measured.
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
    have = {_key_of(row, kind): row for row in shards.rows}
    wanted = {_key_of(asdict(cell), kind): cell for cell in protocol.cells()}
    failures = measure_missing(ask, protocol, wanted, have, shards, workers=workers, report=report)
    return [have[key] for key in wanted if key in have], failures


def _key_of(row: Row, kind: type) -> tuple[Any, ...]:
    """A cell as a key; its numbers rounded, so that it survives a file."""
    values = (row[one.name] for one in fields(kind))
    return tuple(round(value, 9) if isinstance(value, float) else value for value in values)


def measure_missing(
    measure: Measure,
    protocol: Any,
    cells: Mapping[Any, Any],
    have: dict[Any, Row],
    shards: Shards,
    *,
    workers: int,
    keep_every: float = 0.0,
    report: Report | None = None,
) -> list[Failure]:
    """Measure every cell that is not there yet; a study that is stopped keeps what it has.

    Args:
        measure: protocol and cell to a row, in any process.
        protocol: the questions.
        cells: all that are wanted, by key, in the order in which they are begun.
        have: rows that are there, by key; those that are measured are added.
        shards: keeps the rows.
        workers: processes, -1 for all cores.
        keep_every: a finished cell waits no longer than this to be written to disk [s].
        report: told how far it is.

    Returns:
        The cells that could not be measured.

    Raises:
        ParameterError: no workers.
        StudyError: a worker was killed from outside.
        MissingExtraError: joblib is not installed.
    """
    check_workers(workers)
    missing = {key: cell for key, cell in cells.items() if key not in have}
    keys = {cell: key for key, cell in missing.items()}
    failures: list[Failure] = []
    fresh: list[Row] = []
    kept, done = time.monotonic(), len(cells) - len(missing)
    if report is not None:
        report(done, len(cells))
    try:
        for cell, result in _parallel(measure, protocol, list(missing.values()), workers):
            if isinstance(result, str):
                failures.append(Failure(cell, result))
            else:
                fresh.append(result)
                have[keys[cell]] = result
            if time.monotonic() - kept >= keep_every:
                shards.add(fresh)
                fresh, kept = [], time.monotonic()
            done += 1
            if report is not None:
                report(done, len(cells))
    except BrokenProcessPool as error:
        raise StudyError(
            "workers that live as long as their study",
            "one that was killed, perhaps for want of memory",
            "what is measured is kept: give the same command again, with fewer --workers",
        ) from error
    finally:
        shards.add(fresh)
    return failures


def _measured(measure: Measure, protocol: Any, cell: Any) -> tuple[Any, Row | str]:
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


def _parallel(
    measure: Measure, protocol: Any, cells: list[Any], workers: int
) -> Iterator[tuple[Any, Row | str]]:
    joblib = optional_module("joblib", "studies on all cores", "study")
    jobs = (joblib.delayed(_measured)(measure, protocol, cell) for cell in cells)
    yield from joblib.Parallel(n_jobs=workers, return_as="generator_unordered")(jobs)

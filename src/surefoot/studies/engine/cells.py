"""Cells of a study shared among processes; every finished one is kept as soon as it may be."""

from __future__ import annotations

import math
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, TypeVar

from surefoot.errors import SurefootError
from surefoot.studies.engine.table import Shards
from surefoot.studies.engine.workers import Processes, Workers, all_results

T = TypeVar("T")

Row = dict[str, Any]

MeasureMany = Callable[[Sequence[Any]], "list[Row | str]"]
"""Makes a row of each of some cells, in any process; text for one that cannot be measured."""

Progress = Callable[[int, int], None]
"""Called with the number of cells that are there, and that of all."""


def select(rows: Iterable[Row], **choice: Any) -> list[Row]:
    """The rows whose values are those chosen, such as `leg_speed=3.0`."""
    return [row for row in rows if all(row[name] == value for name, value in choice.items())]


def values(rows: Iterable[Row], name: str) -> list[float]:
    """The different values of a column, upwards."""
    return sorted({row[name] for row in rows})


@dataclass(frozen=True)
class Failure:
    """A cell that could not be measured, and why."""

    cell: Any
    error: str


def without_infinity(value: Any) -> Any:
    """Plain values for JSON, which has no word for infinity, nor for what is no number: null."""
    if isinstance(value, dict):
        return {name: without_infinity(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [without_infinity(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def measure_missing(
    measure: MeasureMany,
    cells: Mapping[Any, Any],
    have: dict[Any, Row],
    shards: Shards,
    *,
    workers: int | Workers,
    at_once: int = 1,
    keep_every: float = 0.0,
    report: Progress | None = None,
) -> list[Failure]:
    """Measure every cell that is not there yet; a study that is stopped keeps what it has.

    Args:
        measure: what makes rows of at most `at_once` cells. If it raises, each is measured alone.
        cells: all that are wanted, by key, in the order in which they are begun.
        have: rows that are there, by key; those that are measured are added.
        shards: keeps the rows.
        workers: processes, -1 for all cores; or who works instead.
        at_once: how many cells are measured together, at most.
        keep_every: a finished cell waits no longer than this to be written to disk [s].
        report: called with the number of cells that are there, and that of all.

    Returns:
        The cells that could not be measured.

    Raises:
        ParameterError: no workers.
        StudyError: a cluster was lost.
        MissingExtraError: joblib is not installed.
    """
    who = Processes(workers) if isinstance(workers, int) else workers
    missing = {key: cell for key, cell in cells.items() if key not in have}
    work = _Work(measure)
    failures: list[Failure] = []
    fresh: list[Row] = []
    kept, done = time.monotonic(), len(cells) - len(missing)
    if report is not None:
        report(done, len(cells))
    tasks = dict(enumerate(batched(missing.items(), at_once)))
    try:
        for task, results in all_results(who, work, tasks, _each):
            answers = [results] * len(task) if isinstance(results, str) else results
            for (key, cell), result in zip(task, answers, strict=True):
                if isinstance(result, str):
                    failures.append(Failure(cell, result))
                else:
                    fresh.append(result)
                    have[key] = result
            if time.monotonic() - kept >= keep_every:
                shards.add(fresh)
                fresh, kept = [], time.monotonic()
            done += len(task)
            if report is not None:
                report(done, len(cells))
    finally:
        shards.add(fresh)
    return failures


@dataclass(frozen=True)
class _Work:
    """What is done with some cells in another process: an error comes back as text."""

    measure: MeasureMany

    def __call__(self, task: Sequence[tuple[Any, Any]]) -> list[Row | str] | str:
        try:
            return self.measure([cell for _, cell in task])
        except Exception as error:  # whatever it is, the other cells go on and this one is reported
            if len(task) > 1:
                return [self._alone(one) for one in task]
            return str(error) if isinstance(error, SurefootError) else traceback.format_exc()

    def _alone(self, one: tuple[Any, Any]) -> Row | str:
        found = self([one])
        return found if isinstance(found, str) else found[0]


def _each(task: Sequence[Any]) -> list[Sequence[Any]]:
    return [(one,) for one in task]


def batched(values: Iterable[T], size: int) -> Iterator[tuple[T, ...]]:
    """Values in tuples of `size`, the last one shorter."""
    left = iter(values)
    while some := tuple(islice(left, size)):
        yield some

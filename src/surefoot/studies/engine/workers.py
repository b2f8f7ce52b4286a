"""Who measures: processes of this machine, or the workers of a cluster. Both do the same work, and
every finished cell is kept as soon as it may be.

A worker may die, for want of memory or by a defect that no exception tells of. A task that was
under way is then done again; one that takes its worker with it wherever it is done is reported.
"""

from __future__ import annotations

import multiprocessing
import signal
import socket
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol, TypeVar
from urllib.parse import urlsplit

from surefoot.checks import optional_module
from surefoot.compiled import source_stamp
from surefoot.errors import ParameterError, StudyError, SurefootError
from surefoot.studies.engine.table import Row, Shards
from surefoot.version import VERSION

T = TypeVar("T")

KILLED = "the process that measured it died: out of memory, killed from outside, or crashed"
"""What is said of a task that takes its worker with it."""

UNDER_WAY = 4
"""So many tasks may be under way for each worker."""

PATIENCE = 30.0
"""A cluster that has no worker for so long has none [s]."""

Work = Callable[[Any], Any]
"""What is done with a task, in any process; it never raises."""


MeasureMany = Callable[[Sequence[Any]], "list[Row | str]"]
"""Makes a row of each of some cells, in any process; text for one that cannot be measured."""

Progress = Callable[[int, int], None]
"""Called with the number of cells that are there, and that of all."""


class WorkerKilledError(Exception):
    """A worker died; `suspects` are the tasks of which one may be the reason."""

    def __init__(self, suspects: list[int]) -> None:
        self.suspects = suspects
        super().__init__(KILLED)


class Workers(Protocol):
    """Somebody who works on tasks."""

    def results(self, work: Work, tasks: Mapping[int, Any]) -> Iterator[tuple[int, Any]]:
        """The number and the result of every task, as they are done.

        Raises:
            WorkerKilledError: a worker died, and its task is not to be done again by others.
        """
        ...

    def alone(self) -> Workers:
        """The same for one task that may kill its worker."""
        ...


@dataclass(frozen=True)
class Processes:
    """The processors of this machine, by joblib.

    Args:
        count: processes, -1 for all cores. With 1 everything is done in this one.

    Raises:
        ParameterError: nobody works.
        MissingExtraError: joblib is not installed.
    """

    count: int = -1

    def __post_init__(self) -> None:
        if self.count == 0:
            raise ParameterError("a number of workers", "0", "leave it out for all cores")
        optional_module("joblib", "studies on all cores", "study")

    def results(self, work: Work, tasks: Mapping[int, Any]) -> Iterator[tuple[int, Any]]:
        """See `Workers`."""
        joblib = optional_module("joblib", "studies on all cores", "study")
        pool = joblib.Parallel(n_jobs=self.count, return_as="generator_unordered")
        done: set[int] = set()
        try:
            jobs = (joblib.delayed(_numbered)(work, number, tasks[number]) for number in tasks)
            for number, result in pool(jobs):
                done.add(number)
                yield number, result
        except BrokenProcessPool as error:
            left = (number for number in tasks if number not in done)
            count = UNDER_WAY * joblib.effective_n_jobs(self.count)
            raise WorkerKilledError(list(islice(left, count))) from error

    def alone(self) -> Processes:
        """A process of its own: the study outlives it."""
        return Processes(2)


@dataclass(frozen=True)
class Cluster:
    """The workers of a dask cluster; each needs the same version of Surefoot.

    Args:
        address: of its scheduler, such as "tcp://10.0.0.1:8786".

    Raises:
        MissingExtraError: dask.distributed is not installed.
        StudyError: nobody answers there, there is no worker, or one has another version.
    """

    address: str

    def __post_init__(self) -> None:
        with self._client() as client:
            deadline = time.monotonic() + PATIENCE
            while not client.scheduler_info()["workers"]:
                if time.monotonic() > deadline:
                    raise StudyError(
                        f"a cluster with workers at {self.address}",
                        f"none within {PATIENCE:g} s",
                        f"start some with `dask worker {self.address}`",
                    )
                time.sleep(0.1)
            mine = _version()
            others = {
                where: version
                for where, version in client.run(_version, on_error="return").items()
                if version != mine
            }
            if others:
                where, version = next(iter(others.items()))
                raise StudyError(
                    f"workers with the Surefoot of this process ({mine})",
                    f"{len(others)} with another, {where} with {version}",
                    "install the same one there",
                )

    def _client(self) -> Any:
        distributed = optional_module("distributed", "studies on a cluster", "cluster")
        where = self.address if "://" in self.address else f"tcp://{self.address}"
        try:
            # A client that finds nobody is never quite gone, and may lock up the next one.
            parts = urlsplit(where)
            if not (parts.hostname and parts.port):
                raise ValueError("no host and port")
            socket.create_connection((parts.hostname, parts.port), timeout=PATIENCE).close()
            return distributed.Client(where, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise StudyError(
                "the address of a dask scheduler, such as tcp://10.0.0.1:8786",
                f"{self.address}: {error}",
                "start one with `dask scheduler`; it says its address",
            ) from error

    def results(self, work: Work, tasks: Mapping[int, Any]) -> Iterator[tuple[int, Any]]:
        """See `Workers`. The cluster gives the task of a worker that died to another one; one with
        which three died is given back."""
        distributed = optional_module("distributed", "studies on a cluster", "cluster")
        with self._client() as client:
            numbers = iter(tasks)
            queue = distributed.as_completed(loop=client.loop, raise_errors=False)
            under_way: dict[Any, int] = {}

            def submit(count: int) -> None:
                for number in islice(numbers, count):
                    future = client.submit(work, tasks[number], pure=False)
                    under_way[future] = number
                    queue.add(future)

            submit(UNDER_WAY * max(1, sum(client.ncores().values())))
            for future in queue:
                number = under_way.pop(future)
                if future.status == "error":
                    error = future.exception()
                    if isinstance(error, distributed.KilledWorker):
                        raise WorkerKilledError([number]) from error
                    raise error
                if future.status != "finished":
                    raise StudyError(
                        f"the cluster at {self.address} to stay",
                        "a connection that is lost",
                        "start it again and give the same command; what is measured is kept",
                    )
                yield number, future.result()
                submit(1)

    def alone(self) -> Cluster:
        """The same one: its other tasks outlive a worker anyway."""
        return self


def _version() -> str:
    return f"{VERSION}, {source_stamp()[:12]}"


def _numbered(work: Work, number: int, task: Any) -> tuple[int, Any]:
    """`work` in another process of this machine, whose Ctrl-C is for the study."""
    in_main = threading.current_thread() is threading.main_thread()
    if multiprocessing.parent_process() is not None and in_main:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    return number, work(task)


def all_results(
    workers: Workers, work: Work, tasks: Mapping[int, Any], parts: Callable[[Any], list[Any]]
) -> Iterator[tuple[Any, Any]]:
    """Every task with its result, as they are done, whatever becomes of the workers.

    Args:
        workers: who works.
        work: what is done with a task, in any process; it never raises.
        tasks: by number, in the order in which they are begun.
        parts: splits a task into smaller ones, itself if it cannot be split.

    Yields:
        A task, or a part of one, and its result; `KILLED` for one that killed its worker.
    """
    left = dict(tasks)
    while left:
        try:
            for number, result in workers.results(work, dict(left)):
                yield left.pop(number), result
        except WorkerKilledError as error:
            for number in error.suspects:
                if number in left:
                    yield from _alone(workers, work, left.pop(number), parts)


def _alone(
    workers: Workers,
    work: Work,
    task: Any,
    parts: Callable[[Any], list[Any]],
    last: bool = False,
) -> Iterator[tuple[Any, Any]]:
    """A task that may kill its worker, all by itself; the smallest that does so twice is given up:
    once may have been somebody else's doing."""
    try:
        ((_, result),) = workers.alone().results(work, {0: task})
    except WorkerKilledError:
        smaller = parts(task)
        if len(smaller) == 1 and last:
            yield task, KILLED
            return
        for one in smaller:
            yield from _alone(workers, work, one, parts, last=len(smaller) == 1)
    else:
        yield task, result


@dataclass(frozen=True)
class Failure:
    """A cell that could not be measured, and why."""

    cell: Any
    error: str


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

"""Who measures: processes of this machine, or the workers of a cluster. Both do the same work.

A worker may die, for want of memory or by a defect that no exception tells of. A task that was
under way is then done again; one that takes its worker with it wherever it is done is reported.
"""

from __future__ import annotations

import multiprocessing
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol
from urllib.parse import urlsplit

from surefoot.checks import optional_module
from surefoot.compiled import source_stamp
from surefoot.errors import ParameterError, StudyError
from surefoot.version import VERSION

KILLED = "the process that measured it died: out of memory, killed from outside, or crashed"
"""What is said of a task that takes its worker with it."""

UNDER_WAY = 4
"""So many tasks may be under way for each worker."""

PATIENCE = 30.0
"""A cluster that has no worker for so long has none [s]."""

Work = Callable[[Any], Any]
"""What is done with a task, in any process; it never raises."""


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

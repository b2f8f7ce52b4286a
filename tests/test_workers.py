"""Work shared among processes and on a cluster: what dies is done again, what kills is named."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Event, Thread
from typing import Any

import pytest

import surefoot as sf
import surefoot.studies.engine.workers as workers
from surefoot.studies.engine.table import Shards
from surefoot.studies.engine.workers import (
    KILLED,
    Cluster,
    Processes,
    all_results,
    batched,
    measure_missing,
)

distributed = pytest.importorskip("distributed")

WORKER = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--no-dashboard"]


def doubled(task: tuple[int, ...]) -> list[int]:
    return [2 * one for one in task]


@dataclass(frozen=True)
class Poison:
    """Doubles its numbers, but one of them takes its process with it, and one only the first."""

    deadly: int
    once: Path
    seconds: float = 0.0

    def __call__(self, task: tuple[int, ...]) -> list[int]:
        time.sleep(self.seconds * len(task))
        if self.deadly in task:
            os.kill(os.getpid(), signal.SIGKILL)
        if 7 in task and not self.once.exists():
            self.once.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return doubled(task)


def each(task: tuple[int, ...]) -> list[tuple[int, ...]]:
    return [(one,) for one in task]


def tasks(count: int = 40, size: int = 4) -> dict[int, tuple[int, ...]]:
    return dict(enumerate(batched(range(count), size)))


def answers(found: Iterator[tuple[Any, Any]]) -> dict[int, Any]:
    """By number, each told once."""
    result: dict[int, Any] = {}
    for task, told in found:
        for place, one in enumerate(task):
            assert one not in result, f"{one} is told twice"
            result[one] = told if isinstance(told, str) else told[place]
    return result


@dataclass
class LocalCluster:
    """A scheduler and workers as processes of their own, on the loopback interface."""

    folder: Path
    scheduler: subprocess.Popen[str]
    address: str
    workers: list[subprocess.Popen[bytes]]

    @classmethod
    def start(cls, folder: Path, workers: int = 2) -> LocalCluster:
        scheduler = subprocess.Popen(
            [
                sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1",
                "--port", "0", "--no-dashboard",
            ],
            stderr=subprocess.PIPE, text=True, cwd=folder, env=cls.environment(),
        )  # fmt: skip
        assert scheduler.stderr is not None
        for line in scheduler.stderr:
            told = re.search(r"tcp://127\.0\.0\.1:\d+", line)
            if told and "Scheduler at" in line:
                break
        else:
            pytest.fail("the scheduler says no address")
        one = cls(folder, scheduler, told[0], [])
        for _ in range(workers):
            one.add_worker()
        return one

    @staticmethod
    def environment() -> dict[str, str]:
        return {
            **os.environ,
            "PYTHONPATH": os.pathsep.join((*sys.path, str(Path(__file__).parent))),
        }

    def add_worker(self) -> subprocess.Popen[bytes]:
        # Without a nanny: a worker that dies stays dead.
        worker = subprocess.Popen(
            [*WORKER, self.address, "--no-nanny", "--local-directory", str(self.folder)],
            stderr=subprocess.DEVNULL, cwd=self.folder, env=self.environment(),
        )  # fmt: skip
        self.workers.append(worker)
        return worker

    def stop(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()
        assert self.scheduler.stderr is not None
        self.scheduler.stderr.close()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[LocalCluster]:
    one = LocalCluster.start(tmp_path)
    yield one
    one.stop()


def test_processes_do_all_the_work() -> None:
    found = answers(all_results(Processes(2), doubled, tasks(), each))
    assert found == {number: 2 * number for number in range(40)}


def test_a_worker_that_dies_costs_nothing_and_one_that_is_killed_by_its_task_is_named(
    tmp_path: Path,
) -> None:
    work = Poison(deadly=22, once=tmp_path / "once")
    found = answers(all_results(Processes(2), work, tasks(), each))
    assert found[22] == KILLED
    del found[22]
    assert found == {number: 2 * number for number in range(40) if number != 22}
    assert (tmp_path / "once").exists()


def test_a_poisoned_cell_of_a_study_is_a_failure_and_the_rest_is_kept(tmp_path: Path) -> None:
    shards = Shards(tmp_path / "table", {"study": "poison"})
    have: dict[Any, Any] = {}
    measure = partial(poisoned_rows, tmp_path / "once")
    failures = measure_missing(measure, {n: n for n in range(12)}, have, shards, workers=2)
    assert [(one.cell, one.error) for one in failures] == [(5, KILLED)]
    assert sorted(row["cell"] for row in shards.rows) == [n for n in range(12) if n != 5]


def poisoned_rows(once: Path, cells: Sequence[int]) -> list[dict[str, int] | str]:
    Poison(deadly=5, once=once)(tuple(cells))
    return [{"cell": cell} for cell in cells]


def test_a_cluster_does_the_same_work(cluster: LocalCluster) -> None:
    found = answers(all_results(Cluster(cluster.address), doubled, tasks(), each))
    assert found == {number: 2 * number for number in range(40)}


def test_killing_a_worker_of_the_cluster_loses_nothing(
    cluster: LocalCluster, tmp_path: Path
) -> None:
    slow = Poison(deadly=-1, once=tmp_path, seconds=0.02)
    found: dict[int, Any] = {}
    for count, (task, told) in enumerate(
        all_results(Cluster(cluster.address), slow, tasks(), each)
    ):
        found |= dict(zip(task, told, strict=True))
        if count == 1:
            cluster.workers[0].kill()
    assert cluster.workers[0].wait() != 0
    assert found == {number: 2 * number for number in range(40)}


def test_a_task_that_kills_workers_of_the_cluster_is_named(tmp_path: Path) -> None:
    """Workers die of it, one after the other; the last one does the rest."""
    cluster = LocalCluster.start(tmp_path, workers=1)
    try:
        who = Cluster(cluster.address)
        work = Poison(deadly=3, once=tmp_path)
        found: dict[int, Any] = {}
        for task, told in Revived(cluster).results(who, work):
            found |= {one: told if isinstance(told, str) else 2 * one for one in task}
    finally:
        cluster.stop()
    assert found == {number: KILLED if number == 3 else 2 * number for number in range(8)}


@dataclass
class Revived:
    """Whoever looks after a cluster starts a worker where one has died."""

    cluster: LocalCluster

    def results(self, who: Cluster, work: Poison) -> Iterator[tuple[Any, Any]]:
        over = Event()

        def look() -> None:
            while not over.wait(0.05):
                if self.cluster.workers[-1].poll() is not None:
                    self.cluster.add_worker()

        watch = Thread(target=look)
        watch.start()
        try:
            yield from all_results(who, work, tasks(8, 4), each)
        finally:
            over.set()
            watch.join()


def test_nobody_at_the_address() -> None:
    with pytest.raises(sf.StudyError, match=r"address of a dask scheduler.*start one with"):
        Cluster("nowhere")
    with pytest.raises(sf.StudyError, match="refused"):
        Cluster("tcp://127.0.0.1:9")
    with pytest.raises(sf.ParameterError, match="number of workers"):
        Processes(0)


def test_another_version_on_the_cluster_is_refused(cluster: LocalCluster, monkeypatch) -> None:
    monkeypatch.setattr(workers, "VERSION", "0.0.1")
    mine = workers._version()
    monkeypatch.setattr(workers, "_version", lambda: mine)
    with pytest.raises(
        sf.StudyError, match=r"workers with the Surefoot of this process .0\.0\.1.*install the same"
    ):
        Told(cluster.address)


class Told(Cluster):
    """A cluster whose workers tell their own version, which the test leaves alone."""

    def _client(self) -> Any:
        client = super()._client()
        ask = client.run
        client.run = lambda _, **how: ask(version_there, **how)
        return client


def version_there() -> str:
    return workers._version()

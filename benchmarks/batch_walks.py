"""How many control cycles a second run in closed loop, in a batch of walks."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter

import numpy as np
from numba import njit

import surefoot as sf
from figures import Figure, Report
from rounds import Task
from step_problems import ROBOT

WALKS = 256
"""Walks of a batch; every one is pushed, no two alike."""

RATE, SCALING = 1e7, 1.9
"""Targets: cycles a second on two cores, and how many times those of one core."""

LOOP = 2_000_000
"""Iterations of the loop that measures the speed of the second core at the moment."""


def batch_figures(report: Report, rounds: int, duration: float, yardstick: Task) -> list[Figure]:
    """The same walks with one worker and with two, in turns.

    Args:
        report: where the number of cycles goes.
        rounds: how often.
        duration: of a walk [s].
        yardstick: our compiled solve, for the ratio.
    """
    controller = sf.HybridController(sf.load_robot(ROBOT), (0.5, 0.0))
    # The latest push first: walks that are pushed later could share the way up to there.
    table = sf.Walks(pushes=_pushes()[::-1])

    def walk(workers: int) -> int:
        results = sf.simulate_batch(controller, table, duration, workers=workers)
        return int(results["cycles"].sum())

    cycles = walk(2)
    _loop(1)
    rows = []
    for _ in range(rounds):
        times = [_elapsed(work, workers) for work in (walk, _loop_twice) for workers in (1, 2)]
        rows.append((*times, float(np.median(yardstick.sample()))))
    one, two, loop_one, loop_two, solve = np.array(rows).T
    report.facts["batch"] = f"{2 * rounds * cycles:.3g} cycles in all"
    report.extra["batch_cycles"] = 2 * rounds * cycles
    rate, machine = cycles / float(np.median(two)), float(np.median(loop_one / loop_two))
    free = machine >= SCALING
    return [
        Figure("batch, hybrid controller, 1 worker: cycles", cycles / float(np.median(one)), "1/s"),
        Figure(
            "  one cycle, of control and simulation",
            float(np.median(one)) / cycles,
            ratio=float(np.median(one / solve)) / cycles,
        ),
        Figure("batch, hybrid controller, 2 workers: cycles", rate, "1/s", None, RATE,
               more_is_better=True, judged=free),
        Figure("  times those of 1 worker", float(np.median(one / two)), "", None, SCALING,
               more_is_better=True, judged=free),
        Figure("  for comparison: a loop that touches no memory", machine, ""),
    ]  # fmt: skip


def _pushes() -> list[list[sf.Push]]:
    """One push a walk, in all directions, from none to the largest that can be survived."""
    pushes = []
    for i in range(WALKS):
        angle, force = 2.4 * i, 0.5 * i
        forces = force * math.cos(angle), 0.4 * force * math.sin(angle)
        pushes.append([sf.Push(start=0.5 + 0.002 * i, duration=0.2, force=forces)])
    return pushes


def _elapsed(work: Callable[[int], object], workers: int) -> float:
    before = perf_counter()
    work(workers)
    return perf_counter() - before


def _loop_twice(workers: int) -> None:
    """Two equal loops, one after the other or side by side."""
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(_loop, (LOOP, LOOP)))


@njit(nogil=True)
def _loop(count):
    value = 0.1
    for _ in range(count):
        value = math.exp(-value)
    return value

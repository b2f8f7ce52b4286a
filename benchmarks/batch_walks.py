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
from step_problems import ROBOT
from surefoot.simulation.batch import simulate_batch

WALKS = 256
"""Walks of a batch; every one is pushed, no two alike."""

RATE, SCALING = 1e7, 1.9
"""Targets: cycles a second on two cores, and how many times those of one core."""

SPINS = 2_000_000
"""Length of the loop that shows how much a second core is worth at the moment."""


def batch_figures(
    report: Report, rounds: int, duration: float, compiled_solve: float
) -> list[Figure]:
    """The same walks with one worker and with two, in turns.

    Args:
        report: where the number of cycles goes, and what the machine itself can do.
        rounds: how often.
        duration: of a walk [s].
        compiled_solve: time of our compiled solve, for the ratio [s].
    """
    controller = sf.HybridController(sf.load_robot(ROBOT), (0.5, 0.0))
    pushes = _pushes()

    def walk(workers: int) -> int:
        results = simulate_batch(
            controller, pushes, duration, stop_when_settled=False, workers=workers
        )
        return int(results["cycles"].sum())

    walk(2)
    _spin(1)
    cycles = walk(1)
    walks = np.array([(_elapsed(walk, 1), _elapsed(walk, 2)) for _ in range(rounds)])
    spins = np.array([(_elapsed(_spin_twice, 1), _elapsed(_spin_twice, 2)) for _ in range(rounds)])
    machine = float(np.median(spins[:, 0] / spins[:, 1]))
    report.facts["batch"] = (
        f"{2 * rounds * cycles:.3g} cycles in all; a second core was worth x{machine:.2f} "
        "to a loop that touches no memory, in the same minute"
    )
    report.extra["batch_cycles"], report.extra["machine_scaling"] = 2 * rounds * cycles, machine
    one, two = (float(time) for time in np.median(walks, axis=0) / cycles)
    scaling = float(np.median(walks[:, 0] / walks[:, 1]))
    return [
        Figure("batch, hybrid controller, 1 worker: cycles", 1.0 / one, "1/s"),
        Figure("  one cycle, of control and simulation", one, ratio=one / compiled_solve),
        Figure(
            "batch, hybrid controller, 2 workers: cycles",
            1.0 / two,
            "1/s",
            target=RATE,
            more_is_better=True,
        ),
        Figure("  times those of 1 worker", scaling, "", target=SCALING, more_is_better=True),
    ]


def _pushes() -> list[list[sf.Push]]:
    """One push a walk, in all directions, from none to the most that can be survived."""
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


def _spin_twice(workers: int) -> None:
    """Two equal loops, one after the other or side by side."""
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(_spin, (SPINS, SPINS)))


@njit(cache=True, nogil=True)
def _spin(count):
    value = 0.1
    for _ in range(count):
        value = math.exp(-value)
    return value

"""Measure several things in turns.

A shared machine is fast in one second and slow in the next. So every task is measured a little in
every round, and a ratio compares what two tasks took in the SAME round; its median over the rounds
is what counts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter_ns
from typing import Any

import numpy as np
from numpy.typing import NDArray

from figures import Figure


@dataclass(frozen=True)
class Task:
    """Something to be timed.

    Attributes:
        what: what it is.
        sample: one round of it: the time of each piece, shape (n,) [s].
        has_tail: whether a piece is one call, so that its 99.9th percentile means something.
        target: for the median [s].
        target_p999: for the 99.9th percentile [s].
    """

    what: str
    sample: Callable[[], NDArray[np.float64]]
    has_tail: bool = False
    target: float | None = None
    target_p999: float | None = None


def measure(tasks: Sequence[Task], rounds: int) -> list[Figure]:
    """Time all tasks in turns; ratios are to the first one.

    Args:
        tasks: what to time; one more round goes before and is thrown away.
        rounds: how many rounds count.

    Returns:
        One figure a task.
    """
    samples: list[list[NDArray[np.float64]]] = [[] for _ in tasks]
    for number in range(-1, rounds):
        for task, kept in zip(tasks, samples, strict=True):
            times = task.sample()
            if number >= 0:
                kept.append(times)
    medians = np.array([[np.median(times) for times in kept] for kept in samples])
    ratios = np.median(medians / medians[0], axis=1)
    return [
        Figure(
            what=task.what,
            p50=float(np.median(np.concatenate(kept))),
            p999=float(np.percentile(np.concatenate(kept), 99.9)) if task.has_tail else None,
            target=task.target,
            target_p999=task.target_p999,
            ratio=float(ratio),
        )
        for task, kept, ratio in zip(tasks, samples, ratios, strict=True)
    ]


def time_blocks(
    run: Callable[[Any], object], blocks: Sequence[Any], size: int
) -> NDArray[np.float64]:
    """The time of one piece in each block of `size` pieces, shape (number of blocks,) [s].

    The call of `run` and the timer count as part of the block: nothing is subtracted.
    """
    times = np.empty(len(blocks))
    for i, block in enumerate(blocks):
        before = perf_counter_ns()
        run(block)
        times[i] = perf_counter_ns() - before
    return times * (1e-9 / size)


def time_calls(call: Callable[[Any], object], arguments: Sequence[Any]) -> NDArray[np.float64]:
    """The time of every single call, the timer's own time included, shape (n,) [s]."""
    return time_blocks(call, arguments, 1)


def timer_overhead(count: int = 20000) -> float:
    """The median time between two readings of the clock with nothing in between [s]."""
    times = np.empty(count)
    for i in range(count):
        before = perf_counter_ns()
        times[i] = perf_counter_ns() - before
    return float(np.median(times)) * 1e-9

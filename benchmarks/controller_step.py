"""How long one whole cycle of the hybrid controller takes from Python."""

from __future__ import annotations

from time import perf_counter_ns

import numpy as np
from numpy.typing import NDArray

import surefoot as sf
from figures import Report
from rounds import Task
from step_problems import ROBOT

PUSH = sf.Push(start=1.1, duration=0.2, force=(176.0, 0.0))
"""The push of the paper's Fig. 6."""

TARGET, TARGET_P999 = 5e-6, 50e-6


def controller_tasks(duration: float) -> list[Task]:
    """A pushed walk replayed: cycles that track, and cycles that decide the step anew.

    Args:
        duration: of the walk [s].
    """
    tasks = []
    for what, threshold, mode in (
        ("controller step from Python, tracking", 0.025, sf.Mode.TRACKING),
        ("controller step from Python, adapting", 0.0, sf.Mode.ADAPTING),
    ):
        controller = sf.HybridController(sf.load_robot(ROBOT), (0.5, 0.0), threshold=threshold)
        walk = sf.simulate(controller, duration, [PUSH])
        observations = [
            sf.Observation.of(walk.observations[i : i + 1].copy()) for i in range(len(walk.time))
        ]
        chosen = walk.commands["mode"] == mode

        def sample(
            controller: sf.HybridController = controller,
            observations: list[sf.Observation] = observations,
            chosen: NDArray[np.bool_] = chosen,
        ) -> NDArray[np.float64]:
            return replay(controller, observations)[chosen]

        tasks.append(Task(what, sample, True, TARGET, TARGET_P999))
    return tasks


def replay(
    controller: sf.HybridController, observations: list[sf.Observation]
) -> NDArray[np.float64]:
    """The time of every cycle, the timer's own time included, shape (n,) [s].

    Garbage is collected as in any program.
    """
    times = np.empty(len(observations))
    state = controller.start(observations[0])
    for i, observation in enumerate(observations):
        before = perf_counter_ns()
        _command, state = controller.step(state, observation)
        times[i] = perf_counter_ns() - before
    return times * 1e-9


def report_timer(report: Report, overhead: float) -> None:
    """Report the timer's share of a single timed call."""
    report.facts["timer"] = (
        f"{overhead * 1e9:.0f} ns between two readings of the clock; single calls contain it"
    )
    report.extra["timer_overhead"] = overhead

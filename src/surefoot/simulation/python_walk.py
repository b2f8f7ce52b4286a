"""Walks of controllers without a compiled kernel, cycle by cycle, with the outcome of a batch.

State and world are values, so walks that differ in their push only are walked together up to the
push, and fork there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.compiling import entry_point, njit
from surefoot.models.interfaces import COMMAND, Controller, Observation
from surefoot.models.pushes import Push
from surefoot.models.record import copy_array, new_array
from surefoot.simulation.lipm_simulator import LIPM_WORLD, LipmSimulator
from surefoot.simulation.outcome import MONITOR
from surefoot.simulation.progress import PROGRESS, see


@njit
def _see(monitor, world, command, progress):
    see(monitor[0], world[0], command[0], progress[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_see, MONITOR, LIPM_WORLD, COMMAND, PROGRESS)


def walk_in_python(
    controller: Controller,
    pushes: Sequence[Sequence[Push]],
    observation: Observation,
    progress: NDArray[np.void],
    results: NDArray[np.void],
) -> None:
    """One walk for each list of pushes, all from the same start.

    Args:
        controller: what decides.
        pushes: of each walk.
        observation: the first one.
        progress: a `PROGRESS` record of walks that have not begun, not changed.
        results: `WALK_RESULT` records, written.
    """
    simulator = LipmSimulator(controller.robot, controller.period)
    begin = _Loop(controller.start(observation), simulator.start(observation), new_array(MONITOR))
    first = min((push.start for row in pushes for push in row), default=0.0)
    before, so_far = _walk(controller, simulator, begin, copy_array(progress), until=first)
    for row, result in zip(pushes, results, strict=True):
        pushed = replace(simulator, pushes=row)
        end, seen = _walk(controller, pushed, before, copy_array(so_far))
        final = end.world["observation"]
        result["end_time"], result["cycles"] = final["time"][0], seen["cycles"][0]
        result["fallen"], result["settled"] = seen["fallen"][0], seen["settled"][0]
        result["final"] = final[0]


class _Loop(NamedTuple):
    """A closed loop between two cycles: three records, each of shape (1,)."""

    state: NDArray[np.void]
    world: NDArray[np.void]
    monitor: NDArray[np.void]


def _walk(
    controller: Controller,
    simulator: LipmSimulator,
    begin: _Loop,
    progress: NDArray[np.void],
    until: float | None = None,
) -> tuple[_Loop, NDArray[np.void]]:
    """Walk to the end, or as long as every cycle is over before `until`; writes `progress`."""
    state, world, monitor = begin.state, begin.world, copy_array(begin.monitor)
    observed = Observation.of(world["observation"])
    while until is None or observed.array["time"][0] + controller.period < until:
        command, next_state = controller.step(state, observed)
        _compiled()(monitor, world, command.array, progress)
        if progress["ended"][0]:
            break
        state = next_state
        observed, world = simulator.step(world, command)
    return _Loop(state, world, monitor), progress

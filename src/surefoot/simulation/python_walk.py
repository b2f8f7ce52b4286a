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
from surefoot.models.interfaces import COMMAND, Command, Observation
from surefoot.models.pushes import Push
from surefoot.models.record import copy_array, new_array
from surefoot.simulation.lipm_simulator import LIPM_WORLD, LipmSimulator
from surefoot.simulation.outcome import MONITOR
from surefoot.simulation.progress import PROGRESS, see
from surefoot.simulation.senses import Senses


@njit
def _see(monitor, world, command, progress):
    see(monitor[0], world[0], command[0], progress[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_see, MONITOR, LIPM_WORLD, COMMAND, PROGRESS)


def walk_in_python(
    simulator: LipmSimulator,
    senses: Senses,
    pushes: Sequence[Sequence[Push]],
    observation: Observation,
    progress: NDArray[np.void],
    results: NDArray[np.void],
) -> None:
    """One walk for each list of pushes, all from the same start.

    Args:
        simulator: moves the world; without pushes.
        senses: what the controller, which it names, is told of it.
        pushes: of each walk.
        observation: the first one.
        progress: a `PROGRESS` record of walks that have not begun, not changed.
        results: `WALK_RESULT` records, written.
    """
    state = senses.controller.start(observation)
    begin = _Loop(
        state, simulator.start(observation), new_array(MONITOR), senses.start(), new_array(COMMAND)
    )
    first = min((push.start for row in pushes for push in row), default=0.0)
    before, so_far = _walk(simulator, senses, begin, copy_array(progress), until=first)
    for row, result in zip(pushes, results, strict=True):
        pushed = replace(simulator, pushes=row)
        end, seen = _walk(pushed, senses, before, copy_array(so_far))
        final = end.world["observation"]
        result["end_time"], result["cycles"] = final["time"][0], seen["cycles"][0]
        result["fallen"], result["settled"] = seen["fallen"][0], seen["settled"][0]
        result["final"] = final[0]


class _Loop(NamedTuple):
    """A closed loop between two cycles: records of shape (1,)."""

    state: NDArray[np.void]
    world: NDArray[np.void]
    monitor: NDArray[np.void]
    sensed: NDArray[np.void]
    command: NDArray[np.void]


def _walk(
    simulator: LipmSimulator,
    senses: Senses,
    begin: _Loop,
    progress: NDArray[np.void],
    until: float | None = None,
) -> tuple[_Loop, NDArray[np.void]]:
    """Walk to the end, or as long as every cycle is over before `until`; writes `progress`."""
    controller = senses.controller
    state, world, monitor = begin.state, begin.world, copy_array(begin.monitor)
    sensed, command = begin.sensed, Command.of(begin.command)
    while until is None or world["observation"]["time"][0] + controller.period < until:
        observed, next_sensed = senses.step(sensed, world, command)
        answer, next_state = controller.step(state, observed)
        _compiled()(monitor, world, answer.array, progress)
        if progress["ended"][0]:
            break
        state, sensed, command = next_state, next_sensed, answer
        _, world = simulator.step(world, command)
    return _Loop(state, world, monitor, sensed, command.array), progress

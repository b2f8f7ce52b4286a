"""Walks of controllers without a compiled kernel, cycle by cycle, with the outcome of a batch.

State and world are values, so walks that differ in their push only are walked together up to the
push, and fork there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.interface import COMMAND, OBSERVATION, Command, Observation
from surefoot.record import copy_array, new_array
from surefoot.rollout.outcome import MONITOR
from surefoot.worlds.point.plant import LIPM_WORLD, LipmSimulator
from surefoot.worlds.point.progress import PROGRESS, WALK_RESULT, finish, see
from surefoot.worlds.point.sensors import Senses
from surefoot.worlds.point.walks import first_starts, last_ends


@njit
def _see(monitor, world, command, progress):
    see(monitor[0], world[0], command[0], progress[0])


@njit
def _finish(progress, observation, result):
    finish(progress[0], observation[0], result[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_see, MONITOR, LIPM_WORLD, COMMAND, PROGRESS)


@cache
def _compiled_finish() -> Callable[..., None]:
    return entry_point(_finish, PROGRESS, OBSERVATION, WALK_RESULT)


def walk_in_python(
    simulator: LipmSimulator,
    senses: Senses,
    pushes: NDArray[np.void],
    observation: Observation,
    progress: NDArray[np.void],
    results: NDArray[np.void],
) -> None:
    """One walk for each row of pushes, all from the same start.

    Args:
        simulator: moves the world; without pushes.
        senses: what the controller, which it names, is told of it.
        pushes: `PUSH` records, shape (walks, pushes).
        observation: the first one.
        progress: a `PROGRESS` record of walks that have not begun, not changed.
        results: `WALK_RESULT` records, written.
    """
    state = senses.controller.start(observation)
    begin = _Loop(
        state, simulator.start(observation), new_array(MONITOR), senses.start(), new_array(COMMAND)
    )
    firsts, quiet = first_starts(pushes), last_ends(pushes)
    trunk, so_far = begin, copy_array(progress)
    first = float(firsts.min(initial=math.inf))
    if math.isfinite(first):
        so_far["quiet_time"] = first
        trunk = _walk(simulator, senses, begin, so_far, until=first)
    for i, row in enumerate(pushes):
        # A walk that nothing pushes is judged from its start.
        pushed = math.isfinite(firsts[i])
        end, seen = (trunk, copy_array(so_far)) if pushed else (begin, copy_array(progress))
        seen["quiet_time"] = quiet[i]
        if not seen["ended"][0]:
            end = _walk(simulator.pushed_by(row), senses, end, seen)
        final = copy_array(end.world["observation"])
        _compiled_finish()(seen, final, results[i : i + 1])


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
) -> _Loop:
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
    return _Loop(state, world, monitor, sensed, command.array)

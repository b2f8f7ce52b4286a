"""Many walks at once: the same compiled cycles, in a closed loop that never returns to Python.

A controller's kernel enters as a pointer to compiled code, so one loop serves every controller and
stays in the cache. Walks are shared among threads; each is computed alone, so their number and the
number of threads change nothing.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from surefoot.compiling import function_pointer, njit
from surefoot.errors import ParameterError
from surefoot.models.footsteps import Side
from surefoot.models.interfaces import OBSERVATION, Controller
from surefoot.models.pushes import PUSH, Push
from surefoot.simulation.lipm_simulator import LipmSimulator, lipm_cycle
from surefoot.simulation.outcome import MONITOR, is_settled, watch

WALK_RESULT = np.dtype(
    [
        ("end_time", "f8"),
        ("cycles", "i8"),
        ("fallen", "?"),
        ("settled", "?"),
        ("final", OBSERVATION),
    ],
)
"""One walk: when it ended [s], cycles, how, and the last observation."""


@njit
def _walk(
    kernel, parameters, states, simulator, world, velocity, pushes, quiet_time, duration, result
):
    """One closed loop until a fall, the end, or (after `quiet_time`) the nominal gait.

    `states` and `world` are arrays of two records: now, and the next one; they swap each cycle.
    """
    monitor = np.zeros(1, MONITOR)[0]
    now, cycles = 0, 0
    while True:
        observation = world[now].observation
        kernel(parameters, states[now], observation, states[1 - now])
        command = states[1 - now].command
        watch(monitor, observation, command)
        cycles += 1
        rested = observation.time > quiet_time and monitor.touchdown_time[2] > quiet_time
        fallen = world[now].fallen != 0
        ended = fallen or observation.time >= duration
        settled = (ended or rested) and is_settled(monitor, velocity[0], velocity[1])
        if ended or settled:
            result.end_time, result.cycles = observation.time, cycles
            result.fallen, result.settled = fallen, settled and not fallen
            result.final = observation
            return
        lipm_cycle(simulator, world[now], command, pushes, world[1 - now])
        now = 1 - now


@njit
def _walk_range(
    kernel, parameters, state, simulator, world, velocity, pushes, quiet, duration, results
):
    """Walks with the rows of `pushes`, each from the same start."""
    states, worlds = np.empty(2, state.dtype), np.empty(2, world.dtype)
    for i in range(results.shape[0]):
        states[0], worlds[0] = state[0], world[0]
        _walk(
            kernel, parameters[0], states, simulator[0], worlds, velocity, pushes[i],
            quiet, duration, results[i],
        )  # fmt: skip


def kernel_pointer(controller: Controller, state: NDArray[np.void]) -> object:
    """A controller's kernel as a pointer, of a type that the cache on disk understands.

    Raises:
        ParameterError: it has none.
    """
    if controller.kernel is None:
        raise ParameterError(
            "a controller with a compiled kernel",
            type(controller).__name__,
            "run its walks one by one with surefoot.simulate",
        )
    return _pointer(controller.kernel, controller.parameters.dtype, state.dtype)


@cache
def _pointer(kernel: Callable[..., None], parameters: np.dtype, state: np.dtype) -> object:
    record = numba.from_dtype
    signature = types.void(record(parameters), record(state), record(OBSERVATION), record(state))
    return function_pointer(kernel, signature)


def simulate_batch(
    controller: Controller,
    pushes: Sequence[Sequence[Push]],
    duration: float,
    *,
    first_support: Side = Side.RIGHT,
    stop_when_settled: bool = True,
    workers: int | None = None,
) -> NDArray[np.void]:
    """Many walks of one controller, one for each list of pushes.

    Args:
        controller: what decides; it must have a compiled kernel.
        pushes: the pushes of each walk, the same number in all.
        duration: how long to walk at most [s].
        first_support: the foot that stands in the first step.
        stop_when_settled: end a walk once the nominal gait is back after the last push; False
            walks on to the end.
        workers: threads, all cores if None.

    Returns:
        `WALK_RESULT` records, shape (len(pushes),).

    Raises:
        ParameterError: the controller has no kernel, or the walks differ in their number of pushes.
    """
    if len({len(row) for row in pushes}) > 1:
        raise ParameterError(
            "the same number of pushes in every walk",
            f"{sorted({len(row) for row in pushes})}",
            "fill up with pushes of no force",
        )
    width = len(pushes[0]) if len(pushes) else 0
    rows = [[(push.start, push.end, push.force) for push in walk] for walk in pushes]
    table = np.array(rows, PUSH).reshape(len(pushes), width)
    last = max((push.end for row in pushes for push in row), default=0.0)
    quiet = last if stop_when_settled else math.inf
    simulator = LipmSimulator(controller.robot, controller.period)
    observation = controller.first_observation(first_support)
    state, world = controller.start(observation), simulator.start(observation)
    velocity = np.array(controller.gait.velocity)
    kernel = kernel_pointer(controller, state)
    results = np.zeros(len(pushes), WALK_RESULT)

    def run(part: slice) -> None:
        _walk_range(
            kernel, controller.parameters, state, simulator.parameters, world, velocity,
            table[part], quiet, duration, results[part],
        )  # fmt: skip

    workers = workers or os.cpu_count() or 1
    # Small parts: walks that fall end early, so equal shares would not be equal work.
    size = max(1, min(8, math.ceil(len(pushes) / (8 * workers))))
    parts = [slice(i, i + size) for i in range(0, len(pushes), size)]
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(run, parts))
    return results

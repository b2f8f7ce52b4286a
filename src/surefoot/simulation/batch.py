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
from surefoot.models.estimator import Estimator
from surefoot.models.footsteps import Side
from surefoot.models.interfaces import OBSERVATION, Controller
from surefoot.models.pushes import PUSH, Push
from surefoot.models.robot import Robot
from surefoot.simulation.disturbance import Disturbance
from surefoot.simulation.lipm_simulator import LipmSimulator, lipm_cycle
from surefoot.simulation.outcome import MONITOR
from surefoot.simulation.progress import new_progress, see
from surefoot.simulation.python_walk import walk_in_python
from surefoot.simulation.senses import Senses, sense

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
def _walk(kernel, parameters, states, simulator, world, senses, sensed, progress, pushes, result):
    """One closed loop until a fall, the end, or (after the last push) the nominal gait.

    `states` and `world` are arrays of two records: now, and the next one; they swap each cycle.
    """
    monitor = np.zeros(1, MONITOR)[0]
    now = 0
    while True:
        observation = world[now].observation
        if senses.active:
            sense(senses, world[now], states[now].command, sensed)
            kernel(parameters, states[now], sensed.seen, states[1 - now])
        else:
            kernel(parameters, states[now], observation, states[1 - now])
        command = states[1 - now].command
        see(monitor, world[now], command, progress)
        if progress.ended:
            result.end_time, result.cycles = observation.time, progress.cycles
            result.fallen, result.settled = progress.fallen, progress.settled
            result.final = observation
            return
        lipm_cycle(simulator, world[now], command, pushes, world[1 - now])
        now = 1 - now


@njit
def _walk_range(
    kernel, parameters, state, simulator, world, senses, nothing, progress, pushes, results
):
    """Walks with the rows of `pushes`, each from the same start, at which `nothing` was sensed."""
    states, worlds = np.empty(2, state.dtype), np.empty(2, world.dtype)
    mine, sensed = np.empty(1, progress.dtype), np.empty(1, nothing.dtype)
    for i in range(results.shape[0]):
        states[:], worlds[0], mine[0] = state[0], world[0], progress[0]
        sensed[0] = nothing[0]
        _walk(
            kernel, parameters[0], states, simulator[0], worlds, senses[0], sensed[0], mine[0],
            pushes[i], results[i],
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
    plant: Robot | None = None,
    disturbance: Disturbance | None = None,
    estimator: Estimator | None = None,
) -> NDArray[np.void]:
    """Many walks of one controller, one for each list of pushes.

    Args:
        controller: what decides. Without a compiled kernel its walks go one after the other.
        pushes: the pushes of each walk, the same number in all.
        duration: how long to walk at most [s].
        first_support: the foot that stands in the first step.
        stop_when_settled: end a walk once the nominal gait is back after the last push; False
            walks on to the end.
        workers: threads, all cores if None.
        plant: the robot that is moved, if it is not the one the controller believes in.
        disturbance: of all walks, as for `simulate`; the same noise in each.
        estimator: between what is measured and the controller.

    Returns:
        `WALK_RESULT` records, shape (len(pushes),).

    Raises:
        ParameterError: the walks differ in their number of pushes, or the delay is no whole number
            of control periods.
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
    observation = controller.first_observation(first_support)
    progress = new_progress(controller.gait.velocity, quiet, duration)
    results = np.zeros(len(pushes), WALK_RESULT)
    plant = plant or controller.robot
    simulator = LipmSimulator(plant, controller.period, disturbance=disturbance)
    senses = Senses(controller, plant, disturbance, estimator)
    if controller.kernel is None:
        walk_in_python(simulator, senses, pushes, observation, progress, results)
        return results
    state, world = controller.start(observation), simulator.start(observation)
    kernel = kernel_pointer(controller, state)

    def run(part: slice) -> None:
        _walk_range(
            kernel, controller.parameters, state, simulator.parameters, world, senses.parameters,
            senses.start(), progress, table[part], results[part],
        )  # fmt: skip

    workers = workers or os.cpu_count() or 1
    # Small parts: walks that fall end early, so equal shares would not be equal work.
    size = max(1, min(8, math.ceil(len(pushes) / (8 * workers))))
    parts = [slice(i, i + size) for i in range(0, len(pushes), size)]
    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(run, parts))
    return results

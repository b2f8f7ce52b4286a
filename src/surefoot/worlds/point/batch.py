"""Many walks at once: the same compiled cycles, in a closed loop that never returns to Python.

A controller's kernel enters as a pointer to compiled code, so one loop serves every controller and
stays in the cache. Walks are shared among threads; each is the same as if it were alone, so their
number and the number of threads change nothing. Walks that differ in their pushes only are one
walk up to the first of these, which is walked once.

Threads and not Numba's `prange`: that shares in equal parts, while walks that fall end early; and
its worker threads must not be entered from two threads, as the workers of a cluster do.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import function_pointer, njit
from surefoot.control.estimator import Estimator
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError
from surefoot.interface import OBSERVATION, Controller
from surefoot.record import new_array, stack
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.rollout.outcome import MONITOR
from surefoot.worlds.point.plant import lipm_cycle
from surefoot.worlds.point.progress import WALK_RESULT, Judge, finish, judge
from surefoot.worlds.point.sensors import measure
from surefoot.worlds.point.walks import (
    Chunk,
    Question,
    Walks,
    chunks_of,
    first_starts,
    last_ends,
)
from surefoot.worlds.point.world import PointWorld

PART = 8
"""A thread takes at most so many: walks that fall end early, equal shares would be unequal work."""


@njit
def _walk(
    kernel,
    parameters,
    states,
    simulator,
    worlds,
    sensors,
    measured,
    monitor,
    progress,
    pushes,
    until,
):
    """One closed loop until the walk ends, or as long as every cycle is over before `until`.

    `states` and `worlds` are arrays of two records that swap each cycle; before and after this
    the first one is now. Every argument is a record of its own kind, and a record that held them
    would differ from controller to controller, so that the loop would be compiled for each.
    """
    now = 0
    while worlds[now].observation.time + simulator.period < until:
        observation = worlds[now].observation
        if sensors.active:
            measure(sensors, worlds[now], states[now].command, measured)
            kernel(parameters, states[now], measured.observation, states[1 - now])
        else:
            kernel(parameters, states[now], observation, states[1 - now])
        command = states[1 - now].command
        judge(monitor, worlds[now], command, progress)
        if progress.ended:
            break
        lipm_cycle(simulator, worlds[now], command, pushes, worlds[1 - now])
        now = 1 - now
    if now == 1:
        states[0], worlds[0] = states[1], worlds[1]


@njit
def _walk_range(kernel, records, trunk, branch, scene, seeds, firsts, quiets, pushes, results):
    """Walks with the rows of `pushes`, each from the start of its scene.

    The trunk is a walk that is not pushed yet; the next walk branches off from it, if it is one of
    the same scene that is not pushed earlier.

    Those that differ from walk to walk are arrays of their own, cut for each thread.

    `records` are by scene parameters, state, simulator, world, sensors, what was measured, monitor
    and progress; `trunk` and `branch` are room for one walk, see `_room`.
    """
    parameters, state, simulator, world, given, nothing, watched, progress = records
    states, worlds, plant, sensors, measured, watch, mine = trunk
    states_on, worlds_on, _, _, measured_on, watch_on, mine_on = branch
    grown, grown_seed = -1, -1
    for i in range(results.shape[0]):
        k = scene[i]
        # What was measured of the trunk must be the same before the end of this walk's last push.
        late = min(firsts[i], quiets[i]) < worlds[0].observation.time or mine[0].ended
        if k != grown or seeds[i] != grown_seed or late:
            # A kernel writes what it has a use for; the rest of both is as in the beginning.
            states[:] = state[k]
            worlds[0], mine[0] = world[k], progress[k]
            plant[0], sensors[0] = simulator[k], given[k]
            measured[0], watch[0] = nothing[0], watched[0]
            if seeds[i] >= 0:
                plant[0].seed = sensors[0].errors.seed = seeds[i]
            grown, grown_seed = k, seeds[i]
        mine[0].quiet_time = quiets[i]
        if not mine[0].ended:
            _walk(
                kernel, parameters[k], states, plant[0], worlds, sensors[0], measured[0], watch[0],
                mine[0], pushes[i], firsts[i],
            )  # fmt: skip
        states_on[:] = states
        worlds_on[0], mine_on[0] = worlds[0], mine[0]
        measured_on[0], watch_on[0] = measured[0], watch[0]
        if not mine[0].ended:
            _walk(
                kernel, parameters[k], states_on, plant[0], worlds_on, sensors[0], measured_on[0],
                watch_on[0], mine_on[0], pushes[i], math.inf,
            )  # fmt: skip
        finish(mine_on[0], worlds_on[0].observation, results[i])


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
    walks: Walks | Sequence[Sequence[Push]] | int,
    duration: float = 6.0,
    *,
    first_support: Side | None = None,
    stop_when_settled: bool = False,
    workers: int | None = None,
    plant: Robot | None = None,
    disturbance: Disturbance | None = None,
    estimator: Estimator | None = None,
    report: Callable[[int, int], None] | None = None,
) -> NDArray[np.void]:
    """Many walks, each to the bit the one that `simulate` would walk.

    Args:
        controller: what decides. With a compiled kernel a cycle of all takes a tenth of a
            microsecond or a little more; without, its walks go one after the other.
        walks: a table of what differs between them; or the pushes of each; or how many there are,
            which differ in the seed of their noise only, from that of `disturbance` on.
        duration: how long to walk at most [s].
        first_support: the foot that stands in the first step, the controller's choice if None.
        stop_when_settled: end a walk once the nominal gait is back after the last push.
        workers: threads, all cores if None.
        plant: the robot that is moved, if it is not the one the controller believes in.
        disturbance: of all walks, as for `simulate`.
        estimator: between what is measured and the controller.
        report: called with the number of walks that are done, and that of all.

    Returns:
        `WALK_RESULT` records, shape (walks,).

    Raises:
        ParameterError: the table is wrong, the duration is not positive, or the delay is no whole
            number of control periods.
        SurefootError: a controller refuses its parameters.
    """
    check_number("duration", duration, 0.0, "s", above=True)
    if workers is not None:
        check_number("workers", workers, 1.0, "threads")
    table = _table(walks, disturbance)
    question = Question(
        controller, duration, stop_when_settled, first_support, plant, disturbance, estimator
    )
    results = np.zeros(len(table), WALK_RESULT)
    pool = ThreadPoolExecutor(workers or os.cpu_count() or 1)
    try:
        for part in chunks_of(question, table):
            compiled = part.scenes[0].controller.kernel is not None
            walk = _walk_compiled if compiled else _walk_in_python
            walk(part, results[part.where], pool)
            if report is not None:
                report(part.where.stop, len(table))
    finally:
        pool.shutdown(cancel_futures=True)
    return results


def _table(walks: Walks | Sequence[Sequence[Push]] | int, disturbance: Disturbance | None) -> Walks:
    if isinstance(walks, Walks):
        return walks
    if isinstance(walks, (int, np.integer)):
        seed = (disturbance or Disturbance()).seed
        return Walks(count=walks, seeds=range(seed, seed + int(walks)))
    return Walks(pushes=walks)


def _walk_compiled(part: Chunk, results: NDArray[np.void], pool: ThreadPoolExecutor) -> None:
    scenes = part.scenes
    states = [one.controller.start(one.start) for one in scenes]
    records = tuple(
        stack(arrays, arrays[0].dtype)
        for arrays in (
            [one.controller.parameters for one in scenes],
            states,
            [one.simulator.parameters for one in scenes],
            [one.simulator.start(one.start) for one in scenes],
            [one.sensors.parameters for one in scenes],
            [scenes[0].sensors.start()],
            [new_array(MONITOR)],
            [one.progress for one in scenes],
        )
    )
    kernel = kernel_pointer(scenes[0].controller, states[0])
    rows = part.scene, part.seeds, first_starts(part.pushes), last_ends(part.pushes), part.pushes

    def run(share: slice) -> None:
        trunk, branch = _room(records), _room(records)
        _walk_range(kernel, records, trunk, branch, *(row[share] for row in rows), results[share])

    count, threads = len(results), pool._max_workers
    size = max(1, min(PART, math.ceil(count / (8 * threads))))
    list(pool.map(run, [slice(i, i + size) for i in range(0, count, size)]))


def _room(records: tuple[NDArray[np.void], ...]) -> tuple[NDArray[np.void], ...]:
    """Room for one walk: two states and two worlds that swap, then simulator, sensors, what was
    measured, monitor and progress."""
    _, state, simulator, world, *rest = (one.dtype for one in records)
    kinds = ((state, 2), (world, 2), (simulator, 1), *((one, 1) for one in rest))
    return tuple(np.empty(count, kind) for kind, count in kinds)


def _walk_in_python(part: Chunk, results: NDArray[np.void], pool: ThreadPoolExecutor) -> None:
    """One after the other; those of one scene and seed branch off at their first push."""
    for number, seed in sorted({*zip(part.scene.tolist(), part.seeds.tolist(), strict=True)}):
        rows = np.flatnonzero((part.scene == number) & (part.seeds == seed))
        scene, found = part.scenes[number], np.zeros(len(rows), WALK_RESULT)
        sensors, disturbance = scene.sensors, scene.sensors.disturbance
        if seed >= 0:
            disturbance = replace(disturbance or Disturbance(), seed=seed)
        world = PointWorld(
            scene.controller, sensors.plant, disturbance, sensors.estimator,
            start=scene.start, retained=0.0,
        )  # fmt: skip
        _walk_forks(world, Judge(scene.progress), part.pushes[rows], found)
        results[rows] = found


def _walk_forks(
    start: PointWorld, unjudged: Judge, pushes: NDArray[np.void], results: NDArray[np.void]
) -> None:
    """One walk for each row of pushes, all from the same start."""
    firsts, quiets = first_starts(pushes), last_ends(pushes)
    first = float(firsts.min(initial=math.inf))
    trunk, judge = start.fork(), unjudged.fork(first)
    if math.isfinite(first):
        _walk_on(trunk, judge, first)
    for i, row in enumerate(pushes):
        # A walk that nothing pushes is judged from its start.
        pushed = math.isfinite(firsts[i])
        world, mine = (trunk, judge) if pushed else (start, unjudged)
        world, mine = world.fork(), mine.fork(quiets[i])
        world.push_with(row)
        if not mine.ended:
            _walk_on(world, mine, math.inf)
        mine.finish(world.record["observation"], results[i : i + 1])


def _walk_on(world: PointWorld, judge: Judge, until: float) -> None:
    """What `_walk` does, for controllers without a kernel."""
    while world.time + world.controller.period < until:
        world.observe()
        world.decide()
        if judge.judge(world.record, world.command):
            return
        world.act()

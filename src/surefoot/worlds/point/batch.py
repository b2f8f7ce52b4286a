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
from typing import NamedTuple

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import function_pointer, njit
from surefoot.control.estimator import Estimator
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError
from surefoot.interface import OBSERVATION, Controller, Mode
from surefoot.record import Record, Vector2, field, new_array, stack
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.rollout.outcome import MONITOR
from surefoot.worlds.point.plant import LipmSimulator, lipm_cycle
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

_ADAPTING = int(Mode.ADAPTING)

PART = 8
"""A thread takes at most so many: walks that fall end early, equal shares would be unequal work."""


class Landing(Record):
    """The end of a step."""

    time: float = field("s", "since it began")
    offset: Vector2 = field("m", "DCM relative to the foot that landed")
    adapted: bool = field("", "whether the step was decided online")


LANDING = Landing.DTYPE


class _Room(NamedTuple):
    """Room for one walk: arrays of two records that swap each cycle, and of one record."""

    states: NDArray[np.void]
    worlds: NDArray[np.void]
    simulator: NDArray[np.void]
    sensors: NDArray[np.void]
    measured: NDArray[np.void]
    monitor: NDArray[np.void]
    progress: NDArray[np.void]


class _Rows(NamedTuple):
    """What differs from walk to walk: scene, seed, when the first push begins and when the last one
    is over [s], `PUSH` records."""

    scene: NDArray[np.int64]
    seeds: NDArray[np.int64]
    firsts: NDArray[np.float64]
    quiets: NDArray[np.float64]
    pushes: NDArray[np.void]


@njit
def _walk(kernel, parameters, room, pushes, until):
    """One closed loop until the walk ends, or as long as every cycle is over before `until`.

    Before and after this the first one of the states and worlds is now.
    """
    states, worlds, progress = room.states, room.worlds, room.progress[0]
    simulator, sensors = room.simulator[0], room.sensors[0]
    measured, monitor = room.measured[0], room.monitor[0]
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
def _walk_range(kernel, parameters, scenes, trunk, branch, rows, results):
    """Walks from the starts of their scenes, of which `scenes` has a row each, one state and world.

    The trunk is a walk that is not pushed yet; the next walk branches off from it, if it is one of
    the same scene that is not pushed earlier.
    """
    grown, grown_seed = -1, -1
    for i in range(results.shape[0]):
        k, seed, first = rows.scene[i], rows.seeds[i], rows.firsts[i]
        # What was measured of the trunk must be the same before the end of this walk's last push.
        late = min(first, rows.quiets[i]) < trunk.worlds[0].observation.time
        late = late or trunk.progress[0].ended
        if k != grown or seed != grown_seed or late:
            # A kernel writes what it has a use for; the rest of both is as in the beginning.
            trunk.states[:] = scenes.states[k]
            trunk.worlds[0], trunk.progress[0] = scenes.worlds[k], scenes.progress[k]
            trunk.simulator[0], trunk.sensors[0] = scenes.simulator[k], scenes.sensors[k]
            trunk.measured[0], trunk.monitor[0] = scenes.measured[0], scenes.monitor[0]
            if seed >= 0:
                trunk.simulator[0].seed = trunk.sensors[0].errors.seed = seed
            grown, grown_seed = k, seed
        trunk.progress[0].quiet_time = rows.quiets[i]
        if not trunk.progress[0].ended:
            _walk(kernel, parameters[k], trunk, rows.pushes[i], first)
        branch.states[:] = trunk.states
        branch.worlds[0], branch.progress[0] = trunk.worlds[0], trunk.progress[0]
        branch.simulator[0], branch.sensors[0] = trunk.simulator[0], trunk.sensors[0]
        branch.measured[0], branch.monitor[0] = trunk.measured[0], trunk.monitor[0]
        if not branch.progress[0].ended:
            _walk(kernel, parameters[k], branch, rows.pushes[i], math.inf)
        finish(branch.progress[0], branch.worlds[0].observation, results[i])


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
        `WalkResult` records, shape (walks,).

    Raises:
        ParameterError: the table is refused, the duration is not positive, or the delay is no whole
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
    controllers = [one.controller for one in part.scenes]
    states = [one.controller.start(one.start) for one in part.scenes]
    parameters = stack([one.parameters for one in controllers], controllers[0].parameters.dtype)
    scenes = _Room(
        *(
            stack(arrays, arrays[0].dtype)
            for arrays in (
                states,
                [one.simulator.start(one.start) for one in part.scenes],
                [one.simulator.parameters for one in part.scenes],
                [one.sensors.parameters for one in part.scenes],
                [part.scenes[0].sensors.start()],
                [new_array(MONITOR)],
                [one.progress for one in part.scenes],
            )
        )
    )
    kernel = kernel_pointer(controllers[0], states[0])
    rows = _Rows(
        part.scene, part.seeds, first_starts(part.pushes), last_ends(part.pushes), part.pushes
    )

    def run(share: slice) -> None:
        trunk, branch = _room(scenes), _room(scenes)
        mine = _Rows._make(row[share] for row in rows)
        _walk_range(kernel, parameters, scenes, trunk, branch, mine, results[share])

    count, threads = len(results), pool._max_workers
    size = max(1, min(PART, math.ceil(count / (8 * threads))))
    list(pool.map(run, [slice(i, i + size) for i in range(0, count, size)]))


def _room(scenes: _Room) -> _Room:
    return _Room(*(np.empty(2 if i < 2 else 1, one.dtype) for i, one in enumerate(scenes)))


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
        world.decide()
        if judge.judge(world.record, world.command):
            return
        world.act()


@njit
def _land_all(kernel, parameters, state, simulator, world, pushes, max_cycles, landings):
    """One step under each row of `pushes`, up to its touchdown."""
    states, worlds = np.empty(2, state.dtype), np.empty(2, world.dtype)
    for i in range(landings.shape[0]):
        states[:], worlds[0] = state[0], world[0]
        now, adapted = 0, False
        for _ in range(max_cycles):
            kernel(parameters[0], states[now], worlds[now].observation, states[1 - now])
            command = states[1 - now].command
            adapted = adapted or command.mode == _ADAPTING
            lipm_cycle(simulator[0], worlds[now], command, pushes[i], worlds[1 - now])
            now = 1 - now
            if worlds[now].steps > 0:
                break
        observation = worlds[now].observation
        landings[i].time, landings[i].adapted = observation.time, adapted
        for k in range(2):
            landings[i].offset[k] = observation.dcm[k] - observation.support_foot[k]


def pushed_landings(
    controller: Controller, pushes: Sequence[Push], first_support: Side = Side.RIGHT
) -> NDArray[np.void]:
    """How one step from the nominal gait ends under each of several pushes.

    The gait is periodic, so a push in the third step is as good as one in the first.

    Args:
        controller: what decides; it must have a compiled kernel.
        pushes: one for each walk; their time counts from the touchdown that begins the step.
        first_support: the foot that stands.

    Returns:
        `Landing` records, shape (len(pushes),).

    Raises:
        ParameterError: the controller has no kernel.
    """
    simulator = LipmSimulator(controller.robot, controller.period)
    observation = controller.first_observation(first_support)
    state = controller.start(observation)
    table = Walks(pushes=[[push] for push in pushes]).push_table()
    landings = np.zeros(len(pushes), LANDING)
    max_cycles = math.ceil(2.0 * controller.robot.gait.step_duration[1] / controller.period)
    kernel = kernel_pointer(controller, state)
    _land_all(
        kernel, controller.parameters, state, simulator.parameters, simulator.start(observation),
        table, max_cycles, landings,
    )  # fmt: skip
    return landings

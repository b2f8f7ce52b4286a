"""What a push map measures: the fate of every walk of some cells, and the limits there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.push_limit import PushCase, fixed_steps_limit
from surefoot.dcm.pushes import PUSH
from surefoot.rollout.outcome import recovery_time
from surefoot.studies.engine.scan import FAILURES
from surefoot.studies.engine.table import Row
from surefoot.worlds.point.batch import simulate_batch
from surefoot.worlds.point.walks import Walks

if TYPE_CHECKING:
    from surefoot.studies.push_map.question import Cell, PushMap

RECOVERED, UNSETTLED, FELL, NOT_WALKED = 0, 1, 2, -1
"""What becomes of a walk, in the order of `FAILURES`: back on its gait in time after the push;
still walking, but beside it; on the ground. And an impulse that the fast way has passed over."""

WALK = np.dtype(
    [("fate", "i1"), ("recovery_steps", "i2"), ("recovery_time", "f8"), ("margin", "f8")]
)
"""One walk: what becomes of it; steps (-1 if none) and time until it is settled [s]; how far the
DCM offset stays inside of what stepping can save [m]."""

PER_WALK = ("impulses", *(WALK.names or ()))
"""Columns that hold a list: a value for each walk of the cell."""

_NOT_WALKED = np.array((NOT_WALKED, -1, math.nan, math.nan), WALK)


def measure_cells(study: PushMap, cells: Sequence[Cell]) -> list[Row]:
    """The rows of some cells, see `cell_row`; all their walks are one batch."""
    limits = [_limits(study, cell) for cell in cells]
    counts = [study.count(known) for known, _, _ in limits]
    walks = np.full((len(cells), max(counts)), _NOT_WALKED)
    first = [study.first_look(count) for count in counts]
    _walk(study, cells, walks, first)
    between = [_between(fate, looked) for fate, looked in zip(walks["fate"], first, strict=True)]
    _walk(study, cells, walks, between)
    return [
        cell_row(study, cell, known, own)
        for cell, known, own in zip(cells, limits, walks, strict=True)
    ]


def cell_row(
    study: PushMap, cell: Cell, limits: tuple[float, float, float], walks: NDArray[np.void]
) -> Row:
    """One row of the table.

    Args:
        study: the map.
        cell: whose row it is.
        limits: with the whole sole, as in `limit`, `limit_causal` and `limit_fixed` [N s].
        walks: `WALK` records of its impulses upwards.

    Returns:
        `impulse` (the smallest that fails, inf if none does [N s]), `delta_v` [m/s], `failure`
        (see `FAILURES`), `survived` (the largest impulse below which all were [N s]), `scanned`
        (the largest that was tried [N s]), `limit` (the theoretical one with the whole sole),
        `limit_causal` (of those who do not know when the push ends) and `limit_fixed` (without
        moving a landing) [N s], `fraction` of the limit and `fraction_causal`, at most 1, `holes`
        (how many of the walked impulses above the smallest failing one were survived); and lists
        of the walks: `impulses` [N s], `fate` (0 recovered, 1 not settled, 2 fell), and the others
        of `WALK`.
    """
    there = np.flatnonzero(walks["fate"] != NOT_WALKED)
    impulses, walks, (limit, causal, fixed) = study.step * there, walks[there], limits
    failed = np.flatnonzero(walks["fate"] != RECOVERED)
    scanned = float(impulses[-1])
    impulse = float(impulses[failed[0]]) if len(failed) else math.inf
    survived = max(impulse - study.step, 0.0) if len(failed) else scanned
    return {
        "impulse": impulse,
        "delta_v": impulse / study.robot.mass,
        "failure": FAILURES[walks["fate"][failed[0]]] if len(failed) else FAILURES[RECOVERED],
        "survived": survived,
        "scanned": scanned,
        "limit": limit,
        "limit_causal": causal,
        "limit_fixed": fixed,
        "fraction": min(survived / limit, 1.0) if limit > 0.0 else math.nan,
        "fraction_causal": min(survived / causal, 1.0) if causal > 0.0 else math.nan,
        "holes": int(np.sum((walks["fate"] == RECOVERED) & (impulses > impulse))),
        "impulses": impulses.tolist(),
        **{name: walks[name].tolist() for name in PER_WALK[1:]},
    }


def _walk(
    study: PushMap,
    cells: Sequence[Cell],
    walks: NDArray[np.void],
    which: Sequence[NDArray[np.int64]],
) -> None:
    """Walk these impulses of each cell, and keep in `walks` what becomes of them."""
    rows = np.repeat(np.arange(len(cells)), [len(one) for one in which])
    numbers = np.concatenate(which)
    if len(numbers) == 0:
        return
    starts = np.array([study.start(cell) for cell in cells])[rows]
    units = np.array([study.direction(cell.angle) for cell in cells])[rows]
    pushes = np.zeros((len(rows), 1), PUSH)
    pushes["start"][:, 0], pushes["end"][:, 0] = starts, starts + study.push_duration
    sizes = study.step * numbers / study.push_duration
    pushes["force"][:, 0] = units * sizes[:, np.newaxis]
    durations = starts + study.push_duration + recovery_time(study.controller)
    results = simulate_batch(
        study.controller,
        Walks(pushes=pushes, durations=durations.tolist()),
        first_support=study.support_side,
        stop_when_settled=True,
        workers=1,
    )
    walking = np.where(results["fallen"], FELL, UNSETTLED)
    walks["fate"][rows, numbers] = np.where(results["settled"], RECOVERED, walking)
    for name in PER_WALK[2:]:
        walks[name][rows, numbers] = results[name]


def _between(fate: NDArray[np.int8], walked: NDArray[np.int64]) -> NDArray[np.int64]:
    """The impulses between two walked ones of which one was survived and the other not."""
    good = fate[walked] == RECOVERED
    turns = np.flatnonzero(good[1:] != good[:-1])
    gaps = [np.arange(walked[turn] + 1, walked[turn + 1]) for turn in turns]
    return np.concatenate(gaps) if gaps else np.zeros(0, np.int64)


def _limits(study: PushMap, cell: Cell) -> tuple[float, float, float]:
    """The theoretical limits with the whole sole [N s]: of a push that is known, of one whose end
    is unknown, and without moving a landing."""
    case = PushCase(
        study.robot,
        study.direction(cell.angle),
        velocity=study.controller.gait.velocity,
        elapsed=study.start(cell),
        duration=study.push_duration,
        support_side=study.support_side,
        zmp_reach=study.robot.foot.half,
    )
    fixed = fixed_steps_limit(case.robot, case.direction, duration=case.duration)
    return case.limit().impulse, case.causal_limit().impulse, fixed.impulse

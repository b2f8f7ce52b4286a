"""A push map: what becomes of a robot under every impulse, in every direction and phase of a step.

In each cell, a direction and a phase, the impulse goes from zero to the first above what anybody
can survive. The push is in the first step of the walk: the gait is periodic, so the answer is that
of any later step, two steps sooner.

There are two ways. All impulses can be walked. Or, much faster, every tenth or so first, and then
every one between two of which one was survived and the other not: what that misses is a hole
narrower than the coarse step, a failure between two neighbours that were both survived.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import to_builtins
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.dcm.causal_limit import causal_push_limit
from surefoot.dcm.push_limit import check_leg, fixed_steps_limit, push_limit
from surefoot.dcm.pushes import PUSH
from surefoot.interface import Controller
from surefoot.rollout.outcome import recovery_time
from surefoot.rollout.rollout import describe
from surefoot.studies.engine.cells import Report, Row, without_infinity
from surefoot.studies.engine.provenance import made_with
from surefoot.studies.engine.study import stamp
from surefoot.studies.engine.table import Shards, write_table
from surefoot.studies.push_map.push_grid import PushGrid
from surefoot.version import VERSION
from surefoot.worlds.point.batch import simulate_batch
from surefoot.worlds.point.walks import Walks

TABLE = "push-map.parquet"
"""The name of the table in its folder."""

RECOVERED, UNSETTLED, FELL, NOT_WALKED = 0, 1, 2, -1
"""What becomes of a walk: back on its gait in time after the push; still walking, but beside it; on
the ground. And an impulse that the fast way has passed over."""

FAILURES = ("none", "unsettled", "fell")
"""The same in words, of the smallest impulse that fails."""

PER_WALK = ("impulses", "fate", "recovery_steps", "recovery_time", "margin")
"""Columns that hold a list: a value for each walk of the cell."""


@dataclass(frozen=True)
class PushCube:
    """What was measured, as plain data for whoever shows it.

    Attributes:
        rows: one for each cell, phase after phase, see `cell_row`.
        grid: which pushes, see `PushGrid.as_numbers`.
        provenance: what the table says of itself.
    """

    rows: list[Row]
    grid: dict[str, Any]
    provenance: dict[str, str]

    @property
    def walks(self) -> int:
        """How many walks that took."""
        return sum(len(row["impulses"]) for row in self.rows)

    def as_numbers(self) -> dict[str, Any]:
        """For JSON, without the single walks; what is infinite or no number is null."""
        cells = [{k: v for k, v in row.items() if k not in PER_WALK} for row in self.rows]
        return {
            "grid": self.grid,
            "cells": [without_infinity(cell) for cell in cells],
            "walks": self.walks,
            "provenance": self.provenance,
        }


def measure_cube(
    controller: Controller,
    grid: PushGrid,
    folder: Path,
    *,
    name: str = "",
    workers: int | None = None,
    report: Report | None = None,
) -> PushCube:
    """Walk what is missing, and write the table into `folder`/push-map.parquet.

    Args:
        controller: what decides; its robot and velocity are those of the map.
        grid: which pushes.
        folder: keeps the phases that are finished; made if it is missing.
        name: of the controller, in words; that of its class if empty.
        workers: threads, all cores if None.
        report: called with the number of cells that are there, and that of all.

    Raises:
        ParameterError: no workers.
        VelocityError: the leg is too weak for its gait.
        FileError: the folder cannot be written to, or holds another map.
        MissingExtraError: polars is not installed.
    """
    if workers is not None:
        check_number("workers", workers, 1.0, "threads")
    check_leg(controller.robot, controller.gait)
    shards = Shards(folder, _common(controller, grid))
    by_phase: dict[float, list[Row]] = {}
    for row in shards.rows:
        by_phase.setdefault(round(row["phase"], 9), []).append(row)
    done, total = 0, grid.directions * grid.phases
    for phase in grid.fractions:
        rows = by_phase.get(round(phase, 9))
        if rows is None:

            def tell(part: float, done: int = done) -> None:
                if report is not None:
                    report(done + int(part * grid.directions), total)

            rows = measure_phase(controller, grid, phase, workers=workers, report=tell)
            shards.add(rows)
            by_phase[round(phase, 9)] = rows
        done += len(rows)
        if report is not None:
            report(done, total)
    wanted = [row for phase in grid.fractions for row in by_phase[round(phase, 9)]]
    about = _provenance(controller, grid, name)
    write_table(wanted, folder / TABLE, {"provenance": about, "grid": grid.as_numbers()})
    return PushCube(wanted, grid.as_numbers(), about)


def warm_up(controller: Controller) -> None:
    """A few walks, so that whatever has to be compiled is.

    Raises:
        VelocityError: the leg is too weak for its gait.
    """
    check_leg(controller.robot, controller.gait)
    grid = PushGrid(directions=3, phases=1, step=1e4)
    measure_phase(controller, grid, 0.9)


def measure_phase(
    controller: Controller,
    grid: PushGrid,
    phase: float,
    *,
    workers: int | None = None,
    report: Callable[[float], None] | None = None,
) -> list[Row]:
    """The rows of all directions at one phase, see `cell_row`.

    Args:
        controller: what decides.
        grid: which pushes.
        phase: fraction of the step.
        workers: threads, all cores if None.
        report: told how much of it is done, from 0 to 1.
    """
    start = phase * controller.gait.step_duration
    limits = _limits(controller, grid, start, workers)
    counts = [grid.count(limit) for limit, _ in limits]
    walked = _Walked.empty(grid.directions, max(counts))

    def walk(which: Sequence[NDArray[np.int64]], before: float, share: float) -> None:
        cells = np.repeat(np.arange(grid.directions), [len(one) for one in which])
        numbers = np.concatenate(which)
        if len(numbers) == 0:
            return
        results = simulate_batch(
            controller,
            Walks(pushes=_pushes(grid, start, cells, numbers)),
            start + grid.push_duration + recovery_time(controller),
            first_support=grid.support_side,
            stop_when_settled=True,
            workers=workers,
            report=lambda done, all_of: report and report(before + share * done / all_of),
        )
        walked.keep(cells, numbers, results)

    first = [grid.first_look(count) for count in counts]
    walk(first, 0.0, 0.85 if grid.stride > 1 else 1.0)
    walk([_between(walked.fate[cell], first[cell]) for cell in range(grid.directions)], 0.85, 0.15)
    return [
        cell_row(controller, grid, phase, angle, both, walked.cell(number, grid.step))
        for number, (angle, both) in enumerate(zip(grid.angles, limits, strict=True))
    ]


def cell_row(
    controller: Controller,
    grid: PushGrid,
    phase: float,
    angle: float,
    limits: tuple[float, float],
    walks: dict[str, NDArray[Any]],
) -> Row:
    """One row of the table; `limits` are those of a push that is known, and of unknown end [N s].

    Returns:
        `phase` (fraction of the step), `angle` [deg], `impulse` (the smallest that fails, inf if
        none does [N s]), `delta_v` [m/s], `failure` (see `FAILURES`), `survived` (the largest
        impulse below which all were [N s]), `limit` (with the whole sole, for anybody),
        `limit_causal` (for those who do not know when the push ends) and `limit_fixed` (without
        moving a landing) [N s], `fraction` of the limit and `fraction_causal`, at most 1, `holes`
        (how many of the walked impulses above the smallest failing one were survived); and lists
        of the walks: `impulses` [N s], `fate` (0 recovered, 1 not settled, 2 fell),
        `recovery_steps` (-1 if none), `recovery_time` [s] (NaN if none), `margin` [m].
    """
    fate, impulses, (limit, causal) = walks["fate"], walks["impulses"], limits
    failed = np.flatnonzero(fate != RECOVERED)
    scanned = float(impulses[-1])
    impulse = float(impulses[failed[0]]) if len(failed) else math.inf
    survived = max(impulse - grid.step, 0.0) if len(failed) else scanned
    fixed = fixed_steps_limit(
        controller.robot, grid.direction(angle), duration=grid.push_duration
    ).impulse
    return {
        "phase": phase,
        "angle": angle,
        "impulse": impulse,
        "delta_v": impulse / controller.robot.mass,
        "failure": FAILURES[int(fate[failed[0]])] if len(failed) else FAILURES[0],
        "survived": survived,
        "scanned": scanned,
        "limit": limit,
        "limit_causal": causal,
        "limit_fixed": fixed,
        "fraction": min(survived / limit, 1.0) if limit > 0.0 else math.nan,
        "fraction_causal": min(survived / causal, 1.0) if causal > 0.0 else math.nan,
        "holes": int(np.sum((fate == RECOVERED) & (impulses > impulse))),
        **{name: walks[name].tolist() for name in PER_WALK},
    }


@dataclass(frozen=True)
class _Walked:
    """What became of the walks of one phase, by cell and number of the impulse."""

    fate: NDArray[np.int8]
    recovery_steps: NDArray[np.int16]
    recovery_time: NDArray[np.float64]
    margin: NDArray[np.float64]

    @classmethod
    def empty(cls, cells: int, impulses: int) -> _Walked:
        shape = (cells, impulses)
        return cls(
            np.full(shape, NOT_WALKED, np.int8), np.full(shape, -1, np.int16),
            np.full(shape, math.nan), np.full(shape, math.nan),
        )  # fmt: skip

    def keep(
        self, cells: NDArray[np.int64], numbers: NDArray[np.int64], results: NDArray[np.void]
    ) -> None:
        """Take in `WALK_RESULT` records."""
        walking = np.where(results["fallen"], FELL, UNSETTLED)
        self.fate[cells, numbers] = np.where(results["settled"], RECOVERED, walking)
        for name in ("recovery_steps", "recovery_time", "margin"):
            getattr(self, name)[cells, numbers] = results[name]

    def cell(self, number: int, step: float) -> dict[str, NDArray[Any]]:
        """The walks of one cell, the impulses upwards."""
        there = np.flatnonzero(self.fate[number] != NOT_WALKED)
        found = {name: getattr(self, name)[number, there] for name in PER_WALK[1:]}
        return {"impulses": step * there, **found}


def _between(fate: NDArray[np.int8], walked: NDArray[np.int64]) -> NDArray[np.int64]:
    """The impulses between two walked ones of which one was survived and the other not."""
    good = fate[walked] == RECOVERED
    turns = np.flatnonzero(good[1:] != good[:-1])
    gaps = [np.arange(walked[turn] + 1, walked[turn + 1]) for turn in turns]
    return np.concatenate(gaps) if gaps else np.zeros(0, np.int64)


def _pushes(
    grid: PushGrid, start: float, cells: NDArray[np.int64], numbers: NDArray[np.int64]
) -> NDArray[np.void]:
    """The `PUSH` records of some walks, shape (walks, 1)."""
    units = np.array([grid.direction(angle) for angle in grid.angles])
    pushes = np.zeros((len(cells), 1), PUSH)
    pushes["start"], pushes["end"] = start, start + grid.push_duration
    sizes = grid.step * numbers / grid.push_duration
    pushes["force"][:, 0] = units[cells] * sizes[:, np.newaxis]
    return pushes


def _limits(
    controller: Controller, grid: PushGrid, elapsed: float, workers: int | None
) -> list[tuple[float, float]]:
    """What nobody can pass in each direction, with the whole sole, and what nobody can who does not
    know when the push ends [N s]."""

    def limit(angle: float) -> tuple[float, float]:
        known, causal = (
            largest(
                controller.robot,
                grid.direction(angle),
                velocity=controller.gait.velocity,
                elapsed=elapsed,
                duration=grid.push_duration,
                support_side=grid.support_side,
                zmp_reach=controller.robot.foot.half,
            ).impulse
            for largest in (push_limit, causal_push_limit)
        )
        return known, causal

    # The tables that all share are made once.
    first, *others = grid.angles
    before = limit(first)
    with ThreadPoolExecutor(workers) as pool:
        return [before, *pool.map(limit, others)]


def _common(controller: Controller, grid: PushGrid) -> dict[str, Any]:
    """What all phases of one map must have in common, as plain values."""
    return {
        **grid.as_numbers(),
        "robot": to_builtins(controller.robot),
        "velocity": list(controller.gait.velocity),
        "controller": f"{type(controller).__name__}({describe(controller)})",
        "version": VERSION,
        "sources": stamp(PushGrid),
    }


def _provenance(controller: Controller, grid: PushGrid, name: str) -> dict[str, str]:
    """What a table must say of itself to be made again."""
    robot, velocity = controller.robot, controller.gait.velocity
    return {
        "version": VERSION,
        "sources": _common(controller, grid)["sources"][:16],
        "robot": robot.name,
        "mass": f"{robot.mass:g} kg",
        "leg speed": f"{robot.swing.max_speed:g} m/s",
        "velocity": f"{velocity[0]:g}, {velocity[1]:g} m/s",
        "controller": name or type(controller).__name__,
        "parameters": describe(controller),
        "step": f"{grid.step:g} N s",
        "coarse step": f"{grid.coarse:g} N s" if grid.stride > 1 else "none: all impulses walked",
        "push": f"{grid.push_duration:g} s",
        **made_with("numpy", "numba"),
    }

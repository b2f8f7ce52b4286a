"""Walks of a body on what its sensors tell, while something is wrong: how well, or why it fell."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import to_builtins

from surefoot.checks import check_number, check_pair
from surefoot.errors import ParameterError, StudyError
from surefoot.robot.robot import Robot
from surefoot.rollout.measures import measure_body
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import BodyTrace
from surefoot.studies.compare.body_compare import LIBRARIES, robot_hash
from surefoot.studies.compare.body_conditions import BODY_CONDITIONS, body_condition
from surefoot.studies.compare.body_protocol import body_method
from surefoot.studies.compare.body_push import NO_STEP, STUCK, mechanism_of
from surefoot.studies.engine.cells import Failure, run_cells, study_as_numbers
from surefoot.studies.engine.provenance import made_with, sources_stamp
from surefoot.studies.engine.table import Shards, write_table
from surefoot.version import VERSION
from surefoot.worlds.body.gait import body_control, walking_robot
from surefoot.worlds.body.world import simulate_body

TABLE = "walks.parquet"
"""The name of the table of a robot in its folder."""


@dataclass(frozen=True)
class WalkCell:
    """One walk.

    Attributes:
        method: its key.
        condition: key of what is wrong.
        seed: of noise and bumps.
    """

    method: str
    condition: str
    seed: int


@dataclass(frozen=True)
class WalkProtocol:
    """The same walks for every method.

    Args:
        robot: who walks; it has a `[body]`.
        velocity: commanded [m/s].
        methods: keys of `studies.compare.body_protocol.BODY_METHODS`.
        conditions: keys of `studies.compare.body_conditions.BODY_CONDITIONS`.
        seeds: how many, from 0 on.
        duration: of a walk [s].

    Raises:
        ParameterError: an argument is out of range, or there is nothing to measure.
    """

    robot: Robot
    velocity: tuple[float, float] = (0.3, 0.0)
    methods: tuple[str, ...] = ("unified",)
    conditions: tuple[str, ...] = field(
        default_factory=lambda: tuple(one.key for one in BODY_CONDITIONS)
    )
    seeds: int = 3
    duration: float = 20.0

    def __post_init__(self) -> None:
        for key in self.methods:
            body_method(key)
        for key in self.conditions:
            body_condition(key)
        check_pair("velocity", self.velocity, -math.inf, "m/s")
        check_number("duration", self.duration, 0.0, "s", above=True)
        if isinstance(self.seeds, bool) or not isinstance(self.seeds, int) or self.seeds < 1:
            raise ParameterError(
                "`seeds` as a whole number of at least 1", repr(self.seeds), "3 are usual"
            )
        for name in ("methods", "conditions"):
            keys = getattr(self, name)
            if not keys or len(set(keys)) < len(keys):
                raise ParameterError(
                    f"at least one of `{name}`, each of them once", f"{keys}", "name some"
                )

    def cells(self) -> Iterator[WalkCell]:
        """Every walk."""
        for key, condition, seed in product(self.methods, self.conditions, range(self.seeds)):
            yield WalkCell(key, condition, seed)

    def same_for_all(self) -> dict[str, Any]:
        """What all walks of one table must have in common, as plain values."""
        return {
            "robot": to_builtins(self.robot),
            "velocity": list(self.velocity),
            "duration": self.duration,
        }


@dataclass(frozen=True)
class WalkStudy:
    """What was measured on one robot, as plain data for whoever shows it.

    Attributes:
        rows: see `measure_walk`.
        methods, conditions: key and label of each, in the order in which they are shown.
        provenance: what the table says of itself.
        failures: walks that could not be measured.
    """

    rows: list[dict[str, Any]]
    methods: list[dict[str, str]]
    conditions: list[dict[str, str]]
    provenance: dict[str, str]
    failures: list[Failure]

    def as_numbers(self) -> dict[str, Any]:
        """All of it for JSON; what is not there is null."""
        return study_as_numbers(self)


def walk_disturbed(
    protocol: WalkProtocol,
    folder: Path,
    *,
    workers: int = -1,
    report: Callable[[int, int], None] | None = None,
) -> WalkStudy:
    """Walk what is missing, and write the table into `folder`/walks.parquet.

    Args:
        protocol: the walks.
        folder: keeps the rows; rows of the same robot, velocity and version may be there already.
        workers: processes, -1 for all cores.
        report: called with the number of walks that are there, and that of all.

    Raises:
        ParameterError: no workers.
        FileError: the folder cannot be written to, or holds rows of another study.
        StudyError: nothing could be measured.
        MissingExtraError: joblib, polars, mujoco or daqp is not installed.
        SurefootError: a method cannot control this robot.
    """
    believed = walking_robot(mechanism_of(protocol.robot))
    for key in protocol.methods:
        body_method(key).make(believed, protocol.velocity)  # refused now, not walk by walk
    same = protocol.same_for_all() | {"version": VERSION, "sources": _stamp()}
    shards = Shards(folder, same)
    rows, failures = run_cells(
        measure_walk, WalkCell, protocol, shards, workers=workers, report=report
    )
    if not rows:
        raise StudyError(
            "a walk that can be measured", failures[0].error.strip(), "mend that, and try again"
        )
    about = _provenance(protocol)
    methods = [{"key": one.key, "label": one.label} for one in map(body_method, protocol.methods)]
    wrong = [
        {"key": one.key, "label": one.label} for one in map(body_condition, protocol.conditions)
    ]
    notes = {"provenance": about, "methods": methods, "conditions": wrong}
    write_table(rows, folder / TABLE, notes)
    return WalkStudy(rows, methods, wrong, about, failures)


def measure_walk(protocol: WalkProtocol, cell: WalkCell) -> dict[str, Any]:
    """One row of the table.

    Args:
        protocol: the walks.
        cell: the one to walk.

    Returns:
        The cell; whether it `walked` to the end and for how long (`time` [s]), and of a fall
        `cause` and `words`; root mean squares while walking of `dcm_error`, DCM against its plan
        as seen from the standing foot, and `estimate_error`, DCM told against the true one,
        likewise [m]; `drift` of the feet to the left of the course [m] and `heading` of the base
        away from it [rad] in the end, `speed` held [m/s]. NaN is what there is not.
    """
    before, mechanism = time.perf_counter(), mechanism_of(protocol.robot)
    wrong = body_condition(cell.condition)
    method = body_method(cell.method).make(walking_robot(mechanism), protocol.velocity)
    rollout = simulate_body(
        body_control(method, mechanism),
        protocol.duration,
        surroundings=wrong.surroundings(cell.seed),
        noise=wrong.noise(cell.seed),
    )
    trace = rollout.body
    if trace is None:
        raise StudyError("a walk of a body", "one without a trace", "report this as a bug")
    measures, (cause, words) = measure_body(rollout, trace), _cause(rollout, trace)
    speed = math.nan if measures.speed is None else measures.speed[0]
    return {
        **asdict(cell),
        "walked": not cause,
        "time": float(rollout.time[-1]),
        "cause": cause,
        "words": words,
        "dcm_error": tracking_error(rollout, trace),
        "estimate_error": measures.estimate.get("dcm", math.nan),
        "drift": math.nan if measures.lateral_drift is None else measures.lateral_drift,
        "heading": math.nan if measures.heading_error is None else measures.heading_error,
        "speed": speed,
        "seconds": time.perf_counter() - before,
    }


def tracking_error(rollout: Rollout, trace: BodyTrace) -> float:
    """Root mean square of the true DCM against its plan, both from the standing foot [m].

    The plan is from where the foot is believed to stand: a place that is remembered wrongly, which
    no controller feels, is left out. NaN if it never walked.
    """
    walking = trace.walking
    if not walking.any():
        return math.nan
    away = rollout.dcm - rollout.support_foot
    planned = rollout.dcm_plan - rollout.seen["support_foot"]
    error = (away - planned)[walking]
    return float(np.sqrt((error**2).sum(axis=1).mean()))


def _cause(rollout: Rollout, trace: BodyTrace) -> tuple[str, str]:
    """Why it did not walk to the end; empty if it did."""
    fall = rollout.body_fall
    if fall is not None:
        return fall.cause.value, fall.sentence
    if not trace.walking[-1] or rollout.observations["elapsed"][-1] > STUCK:
        return NO_STEP, "it stood instead of walking"
    return "", ""


def _stamp() -> str:
    """All sources that a row depends on, as a hash."""
    return sources_stamp("compare")


def _provenance(protocol: WalkProtocol) -> dict[str, str]:
    """What a table must say of itself to be made again."""
    vx, vy = protocol.velocity
    return {
        "version": VERSION,
        "sources": _stamp()[:16],
        "robot": protocol.robot.name,
        "robot file": robot_hash(protocol.robot),
        "mass": f"{mechanism_of(protocol.robot).mass:.4g} kg",
        "velocity": f"{vx:g}, {vy:g} m/s",
        "walks": f"{protocol.duration:g} s from a stand, {protocol.seeds} seeds",
        "state": "estimated from its sensors",
        **made_with(*LIBRARIES),
    }

"""What is measured in the cells of a sweep: one walk in each, or the smallest push that fails."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from surefoot.dcm.push_limit import push_limit
from surefoot.errors import SurefootError
from surefoot.robot.feet import Side
from surefoot.rollout.outcome import recovery_time
from surefoot.studies.engine.scan import LARGEST_BEYOND, LARGEST_SHARE, smallest_failing_push
from surefoot.studies.engine.table import Row
from surefoot.studies.sweep.parameters import Situation, situation
from surefoot.worlds.point.batch import simulate_batch
from surefoot.worlds.point.walks import Walks

if TYPE_CHECKING:
    from surefoot.studies.sweep.question import Cell, Sweep

REFUSED = "refused"
"""The outcome of a cell whose robot, gait or controller there cannot be."""

FAILED = "failed"
"""The outcome of a cell that could not be measured."""


@dataclass(frozen=True)
class Result:
    """A column of what was measured.

    Attributes:
        usual: its value in a cell that has none.
        words: what it is, on an axis; empty if it is not drawn.
        unit: of its values, empty for a pure number.
        head: above it on the terminal; empty if it does not stand there.
    """

    usual: Any
    words: str = ""
    unit: str = ""
    head: str = ""


WALK = {
    "outcome": Result("", head="outcome"),
    "survived": Result(False, "survived"),
    "end_time": Result(math.nan, "end of the walk", "s"),
    "steps": Result(-1, "steps of the walk"),
    "recovery_time": Result(math.nan, "time until settled", "s"),
    "recovery_steps": Result(-1, "steps until settled", head="steps back"),
    "margin": Result(math.nan, "least margin at a touchdown", "m", "margin [m]"),
    "dcm_error": Result(math.nan, "largest DCM error", "m", "DCM error [m]"),
}
"""What a row says of a walk: "recovered" (of a push), "walked" (without one), "unsettled", "fell"
or "refused"; the others as in `WALK_RESULT`."""

LIMIT = {
    "outcome": Result("", head="outcome"),
    "impulse": Result(math.nan, "smallest push that fails", "N s", "fails at [N s]"),
    "delta_v": Result(math.nan, "smallest change of velocity that fails", "m/s", "[m/s]"),
    "failure": Result(""),
    "limit": Result(math.nan, "theoretical limit", "N s"),
    "share": Result(math.nan, "survived, as a share of the limit", "-", "of the limit"),
}
"""What a row says of a push limit: "measured" or "refused"; the smallest failing impulse and how it
failed; the theoretical limit, and what is survived as a share of it."""

RESULTS = {"walk": WALK, "push-limit": LIMIT}
"""The columns of results, by what a study measures."""


def measure_cells(study: Sweep, cells: Sequence[Cell]) -> list[Row]:
    """A row for each cell. One that cannot be is a finding like any other: its row says why."""
    rows = [empty_row(study) for _ in cells]
    made: list[tuple[Row, Situation]] = []
    for row, cell in zip(rows, cells, strict=True):
        values = study.fixed | study.columns(cell)
        try:
            made.append((row, situation(study.robot, study.controller, values)))
        except SurefootError as error:
            row |= {"outcome": REFUSED, "error": str(error)}
    if study.measures == "push-limit":
        for row, one in made:
            try:
                row |= _limit(study.step, one)
            except SurefootError as error:  # a leg that is too slow for its gait has no limit
                row |= {"outcome": REFUSED, "error": str(error)}
        return rows
    for disturbed in (False, True):
        some = [pair for pair in made if (pair[1].disturbance is not None) == disturbed]
        if some:
            found = _walks([one for _, one in some], disturbed)
            for (row, _), result in zip(some, found, strict=True):
                row |= result
    return rows


def empty_row(study: Sweep) -> Row:
    """What stands for no result."""
    return {name: one.usual for name, one in RESULTS[study.measures].items()} | {"error": None}


def _walks(situations: Sequence[Situation], disturbed: bool) -> list[dict[str, Any]]:
    """One batch. A disturbed walk goes on to its end: under noise no gait settles for good, so it
    survives if the robot does not fall."""
    pushes = [one.made_push() for one in situations]
    ends = [one.start() if push is None else push.end
            for one, push in zip(situations, pushes, strict=True)]  # fmt: skip
    table = Walks(
        pushes=[[] if push is None else [push] for push in pushes],
        controllers=[one.controller for one in situations],
        plants=[one.plant for one in situations],
        disturbances=[one.disturbance for one in situations] if disturbed else None,  # type: ignore[misc]
        durations=[
            end + recovery_time(one.controller) for one, end in zip(situations, ends, strict=True)
        ],
    )
    results = simulate_batch(
        situations[0].controller,
        table,
        first_support=Side.RIGHT,
        stop_when_settled=not disturbed,
        workers=1,
    )
    found = []
    for push, result in zip(pushes, results, strict=True):
        row = {name: result[name].item() for name in WALK if name in result.dtype.names}
        settled = bool(result["settled"])
        well = "walked" if push is None else "recovered"
        row["outcome"] = "fell" if result["fallen"] else (well if settled else "unsettled")
        row["survived"] = not result["fallen"] and (settled or disturbed)
        found.append(row)
    return found


def _limit(step: float, one: Situation) -> dict[str, Any]:
    limit = push_limit(
        one.plant,
        one.direction(),
        velocity=one.controller.gait.velocity,
        elapsed=one.elapsed,
        duration=one.push.duration,
        support_side=one.support_side,
        zmp_reach=one.plant.foot.half,
    ).impulse
    found = smallest_failing_push(
        one.controller,
        one.direction(),
        start=one.start(),
        duration=one.push.duration,
        step=step,
        largest=LARGEST_SHARE * limit + LARGEST_BEYOND,
        first_support=Side.RIGHT,
        workers=1,
        plant=one.plant,
        disturbance=one.disturbance,
        must_settle=one.disturbance is None,
    )
    return {
        "outcome": "measured",
        "impulse": found.impulse,
        "delta_v": found.delta_v,
        "failure": found.failure,
        "limit": limit,
        "share": found.survived / limit if limit > 0.0 else math.nan,
    }

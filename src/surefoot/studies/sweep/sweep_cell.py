"""What is measured in the cells of a sweep: one walk in each, or the smallest push that fails."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from surefoot.dcm.push_limit import push_limit
from surefoot.errors import SurefootError
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.outcome import recovery_time
from surefoot.studies.engine.scan import LARGEST_BEYOND, LARGEST_SHARE, smallest_failing_push
from surefoot.studies.sweep.sweep_parameters import Situation, situation
from surefoot.studies.sweep.sweep_sampling import SweepCell
from surefoot.studies.sweep.sweep_study import Study
from surefoot.worlds.point.batch import simulate_batch
from surefoot.worlds.point.walks import Walks

REFUSED = "refused"
"""The outcome of a cell whose robot, gait or controller there cannot be."""

OUTCOMES = {
    "outcome": "", "survived": False, "end_time": math.nan, "steps": -1, "recovery_time": math.nan,
    "recovery_steps": -1, "margin": math.nan, "dcm_error": math.nan,
}  # fmt: skip
"""What a row says of a walk: "recovered" (of a push), "walked" (without one), "unsettled", "fell"
or "refused"; the others as in `WALK_RESULT`."""

LIMITS = {
    "outcome": "", "impulse": math.nan, "delta_v": math.nan, "failure": "", "limit": math.nan,
    "share": math.nan,
}  # fmt: skip
"""What a row says of a push limit: "measured" or "refused"; the smallest failing impulse [N s, m/s]
and how it failed; the limit for anybody [N s], and what is survived as a share of it."""

RESULTS = {"walk": OUTCOMES, "push-limit": LIMITS}
"""What a row says of what was measured, before it is."""


@dataclass(frozen=True)
class Sweep:
    """A study with its robot, as it goes to other processes."""

    study: Study
    robot: Robot

    def row(self, cell: SweepCell) -> dict[str, Any]:
        """The beginning of a row: what differs."""
        return dict(zip(self.study.vary, cell.values, strict=True))

    def situation(self, cell: SweepCell) -> Situation:
        """What a cell is about.

        Raises:
            SurefootError: there cannot be such a robot, gait or controller.
        """
        values = {**self.study.fixed, **self.row(cell)}
        return situation(self.robot, self.study.controller, values)


def measure_cells(sweep: Sweep, cells: Sequence[SweepCell]) -> list[dict[str, Any] | str]:
    """A row for each cell.

    A cell that cannot be is a finding like any other: its row says why. Text is for one that could
    not be measured.
    """
    rows: list[dict[str, Any] | str] = []
    made: list[tuple[int, Situation]] = []
    usual = RESULTS[sweep.study.measure]
    for index, cell in enumerate(cells):
        row = {**sweep.row(cell), **usual, "error": None}
        try:
            made.append((index, sweep.situation(cell)))
        except SurefootError as error:
            row |= {"outcome": REFUSED, "error": str(error)}
        rows.append(row)
    if sweep.study.measure == "push-limit":
        for index, one in made:
            try:
                found = _limit(sweep.study, one)
            except SurefootError as error:  # a leg that is too slow for its gait has no limit
                found = {"outcome": REFUSED, "error": str(error)}
            rows[index] |= found  # type: ignore[operator]
        return rows
    for disturbed in (False, True):
        some = [(index, one) for index, one in made if (one.disturbance is not None) == disturbed]
        if some:
            found = _walks([one for _, one in some], disturbed)
            for (index, _), result in zip(some, found, strict=True):
                rows[index] |= result  # type: ignore[operator]
    return rows


def _walks(situations: Sequence[Situation], disturbed: bool) -> list[dict[str, Any]]:
    """Disturbed walks go on to the end: nobody settles for good, and not to fall is all."""
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
        row = {name: result[name].item() for name in OUTCOMES if name in result.dtype.names}
        settled = bool(result["settled"])
        well = "walked" if push is None else "recovered"
        row["outcome"] = "fell" if result["fallen"] else (well if settled else "unsettled")
        row["survived"] = not result["fallen"] and (settled or disturbed)
        found.append(row)
    return found


def _limit(study: Study, one: Situation) -> dict[str, Any]:
    limit = _push_limit(
        one.plant,
        one.direction(),
        one.controller.gait.velocity,
        one.push["phase"] * one.controller.gait.step_duration,
        one.push["duration"],
        one.support_side,
    )
    found = smallest_failing_push(
        one.controller,
        one.direction(),
        start=one.start(),
        duration=one.push["duration"],
        step=study.step,
        largest=LARGEST_SHARE * limit + LARGEST_BEYOND,
        first_support=Side.RIGHT,
        workers=1,
        plant=one.plant,
        disturbance=one.disturbance,
        must_settle=one.disturbance is None,
    )
    failed = math.isfinite(found.impulse)
    return {
        "outcome": "measured",
        "impulse": found.impulse,
        "delta_v": found.delta_v,
        "failure": ("fell" if found.fell else "unsettled") if failed else "none",
        "limit": limit,
        "share": found.survived / limit if limit > 0.0 else math.nan,
    }


@lru_cache(maxsize=4096)
def _push_limit(
    plant: Robot,
    direction: tuple[float, float],
    velocity: tuple[float, float],
    elapsed: float,
    duration: float,
    side: Side,
) -> float:
    return push_limit(
        plant,
        direction,
        velocity=velocity,
        elapsed=elapsed,
        duration=duration,
        support_side=side,
        zmp_reach=plant.foot.half,
    ).impulse

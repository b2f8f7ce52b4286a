"""Robots of no preset: what they survive, and that they always come back."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from random_cells import RandomCell, random_cell
from surefoot.control.registry import methods
from surefoot.dcm.viable_displacement import viable_displacement

SHARES = [*np.arange(0.04, 0.93, 0.04), 0.95]
"""Of the causal limit; `benchmarks/push_shares.py` has finer steps and hundreds of cells."""

CELLS, ACCELERATED = range(300, 312), range(400, 405)

STEPS_TO_SETTLE = 12
"""From the gait's own room on: its last error has to become a twenty-fifth of that."""


@pytest.mark.parametrize("seed", CELLS)
def test_95_percent_of_what_can_be_survived_without_knowing_the_end(seed: int) -> None:
    """And every smaller push of the scan: no holes."""
    cell = random_cell(seed)
    settled = cell.settles(cell.controller(), SHARES, cell.causal_limit().impulse)
    assert settled.all(), np.array(SHARES)[~settled]


@pytest.mark.parametrize("seed", ACCELERATED)
def test_a_leg_that_has_to_accelerate(seed: int) -> None:
    cell = random_cell(seed, acceleration=True)
    shares = [share for share in SHARES if share <= 0.92]
    settled = cell.settles(cell.controller(), shares, cell.causal_limit().impulse)
    assert settled.all(), np.array(shares)[~settled]


@pytest.mark.parametrize("seed", range(304, 307))
def test_a_shorter_push_of_the_same_force_is_survived(seed: int) -> None:
    """A push that ends sooner than it might is no worse: nothing was gambled on its going on."""
    cell = random_cell(seed)
    controller, force = cell.controller(), 0.95 * cell.causal_limit().impulse / cell.duration
    pushes = []
    for share in (0.05, 0.2, 0.4, 0.6, 0.8):
        duration = share * cell.duration
        x, y = cell.direction
        pushes.append([sf.Push(cell.start, duration, (force * x, force * y))])
    results = sf.simulate_batch(
        controller, pushes, cell.start + 40.0 * cell.gait.step_duration,
        stop_when_settled=True, first_support=cell.support_side,
    )  # fmt: skip
    assert results["settled"].all()


def largest_steps(cell: RandomCell, start: sf.Observation) -> float:
    """N <= ln(M / m0) / (omega T_min) + 1 on the axis that is nearest to what cannot be saved."""
    robot, reach, most = cell.robot, cell.zmp_reach, 0.0
    tables, side = viable_displacement(robot), int(start.support_side)
    for axis, (turn, behind) in enumerate(((1.0, -1.0), (float(side), 1.0))):
        step = behind * turn * float(start.swing_foot[axis] - start.support_foot[axis])
        offset = turn * float(start.dcm[axis] - start.support_foot[axis])
        high = tables.after_step(axis, 1, step) + reach[axis]
        low = -tables.after_step(axis, -1, step) - reach[axis]
        most = max(most, math.log((high - low) / min(high - offset, offset - low)))
    return most / (robot.omega * robot.gait.step_duration[0]) + 1.0


@pytest.mark.parametrize("acceleration", [False, True])
@pytest.mark.parametrize("seed", range(500, 506))
def test_from_whatever_can_be_saved_the_gait_is_back(seed: int, acceleration: bool) -> None:
    """In a number of steps that grows with the logarithm of how near the edge is."""
    cell = random_cell(seed, acceleration=acceleration)
    starts = cell.viable_starts(20)
    most = [2.0 * largest_steps(cell, start) + STEPS_TO_SETTLE for start in starts]
    results = sf.simulate_batch(
        cell.controller(),
        sf.Walks(starts=starts),
        max(most) * cell.robot.gait.step_duration[1],
        stop_when_settled=True,
    )
    assert results["settled"].all()
    assert (results["steps"] <= most).all()


@pytest.mark.parametrize("seed", [301, 305, 309])
def test_no_other_method_survives_more(seed: int) -> None:
    """Every other compiled method fails at the latest where the unified controller does."""
    cell = random_cell(seed)
    cell = replace(cell, zmp_reach=cell.robot.foot.half)
    limit, shares = cell.causal_limit().impulse, np.arange(0.05, 1.101, 0.05)
    survived = {}
    for method in methods():
        given = {**method.compared, "step_duration": cell.step_duration}
        try:
            controller = method.controller(cell.robot, cell.velocity, **given)
        except sf.SurefootError:
            continue  # It does not walk on this leg at all.
        if controller.kernel is not None:
            settled = cell.settles(controller, shares, limit)
            survived[method.key] = len(shares) if settled.all() else int(np.argmin(settled))
    assert len(survived) > 4
    assert max(survived.values()) == survived["unified"], survived

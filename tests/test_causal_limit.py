"""The limit of a push whose end is not known: laws, a formula, and value iteration."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import surefoot as sf
from random_cells import random_cell
from scales import Scale
from surefoot.dcm.limit_grid import axis_pushes, causal_grid_limit, largest_causal_disagreement
from surefoot.dcm.limit_sweep import Mesh
from surefoot.dcm.push_limit import PushCase, gait_in_step
from surefoot.dcm.pushed_step import best_schedule
from surefoot.dcm.pushes import eight_directions
from surefoot.dcm.viable_displacement import viable_displacement

WAYS = eight_directions(sf.Side.RIGHT)
LEGS = ("unlimited", "fast", "accelerated")


def share(case: PushCase) -> float:
    return case.causal_limit().impulse / case.limit().impulse


def cells(
    seed: int, leg: str, count: int, below: float = 0.99, axes: bool = False
) -> Iterator[PushCase]:
    """Random robots and pushes in which it costs something not to know the end."""
    for number in itertools.count(10_000 * seed):
        cell = random_cell(number, acceleration=leg == "accelerated")
        unlimited = math.isinf(cell.robot.swing.max_speed)
        if leg != "accelerated" and unlimited != (leg == "unlimited"):
            continue
        cell = replace(cell, together=not axes)
        if (axes and all(cell.direction)) or cell.limit().impulse <= 0.0:
            continue
        if share(cell) <= below:
            yield cell
            count -= 1
        if count == 0:
            return


@pytest.mark.parametrize("leg", LEGS)
def test_never_above_the_limit_of_who_knows_the_end(leg: str) -> None:
    shares = []
    for cell in cells(3, leg, 40, below=1.0):
        alone = replace(cell, together=False)
        shares.append(share(cell))
        assert 0.0 < shares[-1] <= 1.0
        assert 0.0 < share(alone) <= 1.0
        assert cell.causal_limit().impulse <= alone.causal_limit().impulse * (1.0 + 2e-3)
    assert min(shares) < 0.999 or leg != "unlimited"


@pytest.mark.parametrize(("way", "elapsed"), [("outward", 0.25), ("back", 0.4), ("forward", 0.2)])
@pytest.mark.parametrize("duration", [0.02, 0.1, 0.19])
def test_an_unlimited_leg_by_hand(robot: sf.Robot, way: str, elapsed: float, duration) -> None:
    """The next landing takes place after s. Then the rest of the push has to fit between both ends
    of what can be saved, and all of it into the room that is left of waiting."""
    tables, omega = viable_displacement(robot), robot.omega
    axis, sign = (1 if way == "outward" else 0), (-1 if way == "back" else 1)
    offset, *_ = gait_in_step(sf.nominal_gait(robot, (0.5, 0.0)), sf.Side.RIGHT, elapsed)
    step = 0.5
    ahead = tables.after_step(axis, sign if axis == 0 else -sign, step)
    width = ahead + tables.after_step(axis, -sign if axis == 0 else sign, step)
    delay = np.linspace(0.0, duration, 100_001)[:-1]
    room = np.exp(-omega * delay) * (step + ahead) - sign * offset[axis]
    fitting = width / -np.expm1(-omega * (duration - delay))
    force = np.minimum(room / -math.expm1(-omega * duration), fitting).max()
    found = sf.causal_push_limit(robot, WAYS[way], elapsed=elapsed, duration=duration).impulse
    expected = robot.mass * omega**2 * duration * force
    assert found == pytest.approx(expected, rel=2e-4)


def test_the_costly_cells_of_the_paper_biped(robot: sf.Robot) -> None:
    """Where e^(omega T_min) is 2 or the box is lopsided, as an earlier computation found."""
    outward = PushCase(robot, WAYS["outward"], elapsed=0.25, duration=0.1)
    assert share(outward) == pytest.approx(0.95, abs=0.01)
    back = PushCase(robot, WAYS["back"], elapsed=0.4, duration=0.1)
    assert share(back) == pytest.approx(0.955, abs=0.01)
    slow = robot.with_leg(max_speed=3.0)
    for way, elapsed in itertools.product(WAYS.values(), (0.0, 0.2, 0.4)):
        assert share(PushCase(slow, way, elapsed=elapsed)) > 0.98


@pytest.mark.parametrize(("leg", "count"), [("unlimited", 4), ("fast", 2)])
def test_value_iteration_finds_the_same(leg: str, count: int) -> None:
    """Along the axes, each by itself: of both ways the time step of the grid is the error."""
    for cell in cells(5, leg, count, below=0.97, axes=True):
        time_step = min(0.015 / cell.robot.omega, cell.duration / 4)
        grid = causal_grid_limit(cell, Mesh(time_step, 80))
        assert cell.causal_limit().impulse == pytest.approx(grid, rel=0.015)
        assert grid < 0.985 * cell.limit().impulse


def test_the_check_of_the_command_line(robot: sf.Robot) -> None:
    worst = largest_causal_disagreement(axis_pushes([robot], [0.2, 0.4], duration=0.1))
    assert worst["fraction"] < 0.01
    known = sf.push_limit(
        robot, WAYS[worst["direction"]], elapsed=worst["elapsed"], duration=0.1,
        zmp_reach=robot.foot.half if worst["finite_foot"] else (0.0, 0.0),
    ).impulse  # fmt: skip
    assert worst["impulse"] < 0.97 * known


@pytest.mark.parametrize("leg", LEGS)
def test_a_push_that_is_over_before_the_foot_may_land_costs_nothing_more(leg: str) -> None:
    for cell in cells(4, leg, 5, below=1.0):
        shortest = cell.robot.gait.step_duration[0]
        early = replace(cell, elapsed=0.0, duration=0.9 * shortest)
        if early.limit().impulse > 0.0:
            assert share(early) == 1.0


def test_a_blow_has_no_end_to_be_known() -> None:
    """To land after the push instead of in it costs e^(-omega D) at most of its limit."""
    for cell in cells(6, "unlimited", 4):
        missing = [1.0 - share(replace(cell, duration=short)) for short in (1e-2, 1e-3, 1e-4)]
        assert missing[2] <= missing[1] <= missing[0] + 1e-6
        assert missing[2] < 2e-3


@pytest.mark.parametrize("leg", LEGS)
def test_longer_pushes_are_no_stronger_and_weaker_ones_have_no_holes(leg: str) -> None:
    """Who is viable throughout a push is so throughout a shorter one, and a weaker one."""
    for cell in cells(7, leg, 2):
        forces = [
            replace(cell, duration=part * cell.duration).causal_limit().impulse / part
            for part in (0.1, 0.3, 0.6, 0.9, 1.0)
        ]
        assert (np.diff(forces) <= 1e-3 * forces[-1]).all()
        room, times = best_schedule(cell.step)
        survived = share(cell) * room
        for part in (0.02, 0.1, 0.4, 0.7, 0.9, 0.999):
            kept = cell.step.causal_share(cell.duration, part * survived, times)
            assert kept == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("leg", LEGS)
def test_left_is_the_mirror_of_right(leg: str) -> None:
    for cell in cells(8, leg, 2):
        mirrored = replace(
            cell,
            direction=(cell.direction[0], -cell.direction[1]),
            velocity=(cell.velocity[0], -cell.velocity[1]),
            support_side=cell.support_side.other,
        )
        for limit in (PushCase.limit, PushCase.causal_limit):
            assert limit(mirrored).impulse == pytest.approx(limit(cell).impulse, rel=1e-12)


@pytest.mark.parametrize(
    "scale", [Scale(4.0, 3.0), Scale(0.25, 0.01), Scale(9.7, 77.0), Scale(0.13, 1.0)], ids=str
)
@pytest.mark.parametrize("leg", LEGS)
def test_dynamic_similarity(leg: str, scale: Scale) -> None:
    for cell in cells(9, leg, 2):
        for limit in (PushCase.limit, PushCase.causal_limit):
            expected = scale.impulse * limit(cell).impulse
            assert limit(scale.case(cell)).impulse == pytest.approx(expected, rel=1e-9)


def test_misuse_is_refused_as_by_the_other_limit(robot: sf.Robot) -> None:
    for name, value in (("direction", (0.0, 0.0)), ("duration", 0.0)):
        with pytest.raises(sf.ParameterError, match=name):
            sf.causal_push_limit(robot, **{"direction": (1.0, 0.0), name: value})

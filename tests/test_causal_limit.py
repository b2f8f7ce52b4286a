"""The limit of a push whose end nobody knows: laws, a formula, and value iteration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec import structs

import surefoot as sf
from scales import Scale
from surefoot.dcm.limit_grid import causal_grid_limit, largest_causal_disagreement
from surefoot.dcm.push_limit import (
    PushCase,
    best_landings,
    gait_in_step,
)
from surefoot.dcm.pushes import eight_directions
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.errors import SurefootError

WAYS = eight_directions(sf.Side.RIGHT)
LEGS = ("unlimited", "fast", "accelerated")

Cell = tuple[sf.Robot, tuple[float, float], dict]


def drawn_robot(rng: np.random.Generator, leg: str) -> sf.Robot:
    """A robot like no other: everything in its own heights and times, but drawn."""
    robot = sf.load_robot("paper-biped").replace(body=None)
    height = rng.uniform(0.25, 1.2)
    time, pace = math.sqrt(height / 9.81), math.sqrt(height * 9.81)
    shortest = rng.uniform(0.3, 1.2) * time
    hip, ahead = rng.uniform(0.12, 0.35) * height, rng.uniform(0.3, 0.9) * height
    swing = structs.replace(robot.swing, max_speed=math.inf, max_acceleration=math.inf)
    if leg != "unlimited":
        swing = structs.replace(swing, max_speed=rng.uniform(0.6, 4.0) * pace)
    if leg == "accelerated":
        swing = structs.replace(swing, max_acceleration=rng.uniform(3.0, 20.0) * 9.81)
    gait = structs.replace(
        robot.gait,
        step_duration=(shortest, shortest + rng.uniform(0.5, 3.0) * time),
        step_x=(-ahead * rng.uniform(0.3, 1.0), ahead),
        step_y=(-hip * rng.uniform(0.1, 0.9), rng.uniform(0.1, 0.5) * height),
    )
    foot = structs.replace(
        robot.foot,
        length=rng.uniform(0.1, 0.3) * height,
        width=min(rng.uniform(0.05, 0.15) * height, 0.9 * (hip + gait.step_y[0])),
    )
    return robot.replace(
        mass=rng.uniform(3.0, 120.0), com_height=height, hip=hip, foot=foot, gait=gait, swing=swing
    )


def drawn_cell(rng: np.random.Generator, leg: str, names=tuple(WAYS)) -> Cell:
    """A robot, a direction and what else is known of a push, of a gait that the robot has."""
    while True:
        try:
            robot = drawn_robot(rng, leg)
            speed = rng.uniform(-0.3, 0.8) * sf.largest_speed(robot, (1.0, 0.0))
            gait = sf.nominal_gait(robot, (speed, 0.0))
            push = {
                "velocity": (speed, 0.0),
                "elapsed": rng.uniform(0.0, 0.95) * gait.step_duration,
                "duration": math.exp(rng.uniform(math.log(0.005), math.log(0.5))),
                "zmp_reach": robot.foot.half if rng.random() < 0.5 else (0.0, 0.0),
            }
            way = WAYS[names[rng.integers(len(names))]]
            if sf.push_limit(robot, way, **push).impulse > 0.0:
                return robot, way, push
        except SurefootError:
            continue


def share(robot: sf.Robot, way, **push) -> float:
    causal = sf.causal_push_limit(robot, way, **push)
    return causal.impulse / sf.push_limit(robot, way, **push).impulse


def costly_cells(seed: int, leg: str, count: int, below: float = 0.99, **options) -> list[Cell]:
    """Cells in which it costs something not to know the end."""
    rng, cells = np.random.default_rng(seed), []
    while len(cells) < count:
        robot, way, push = drawn_cell(rng, leg, **options)
        if share(robot, way, **push) < below:
            cells.append((robot, way, push))
    return cells


@pytest.mark.parametrize("leg", LEGS)
def test_never_above_the_limit_of_who_knows_the_end(leg: str) -> None:
    rng = np.random.default_rng(3)
    shares = []
    for _ in range(40):
        robot, way, push = drawn_cell(rng, leg)
        together, apart = (share(robot, way, **push, together=both) for both in (True, False))
        assert 0.0 < together <= 1.0
        assert 0.0 < apart <= 1.0
        shares.append(together)
        causal = sf.causal_push_limit(robot, way, **push).impulse
        upper = sf.causal_push_limit(robot, way, **push, together=False).impulse
        assert causal <= upper * (1.0 + 2e-3)
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
    assert share(robot, WAYS["outward"], elapsed=0.25, duration=0.1) == pytest.approx(
        0.95, abs=0.01
    )
    assert share(robot, WAYS["back"], elapsed=0.4, duration=0.1) == pytest.approx(0.955, abs=0.01)
    slow = robot.with_leg(max_speed=3.0)
    for way in WAYS.values():
        for elapsed in (0.0, 0.2, 0.4):
            assert share(slow, way, elapsed=elapsed) > 0.98


@pytest.mark.parametrize(("leg", "count"), [("unlimited", 4), ("fast", 2)])
def test_value_iteration_finds_the_same(leg: str, count: int) -> None:
    """Along the axes, each by itself: of both ways the time step of the grid is the error."""
    axes = ("forward", "back", "outward", "inward")
    for robot, way, push in costly_cells(5, leg, count, below=0.97, names=axes):
        time_step = min(0.015 / robot.omega, push["duration"] / 4)
        grid = causal_grid_limit(robot, way, **push, time_step=time_step, intervals=80)
        found = sf.causal_push_limit(robot, way, **push, together=False).impulse
        known = sf.push_limit(robot, way, **push, together=False).impulse
        assert found == pytest.approx(grid, rel=0.015)
        assert grid < 0.985 * known


def test_the_check_of_the_command_line(robot: sf.Robot) -> None:
    worst = largest_causal_disagreement([robot], [0.2, 0.4], duration=0.1)
    assert worst.fraction < 0.01
    assert worst.impulse < 0.97 * sf.push_limit(
        robot, WAYS[worst.direction], elapsed=worst.elapsed, duration=0.1,
        zmp_reach=robot.foot.half if worst.finite_foot else (0.0, 0.0),
    ).impulse  # fmt: skip


def test_a_push_that_is_over_before_the_foot_may_land_costs_nothing_more() -> None:
    rng = np.random.default_rng(4)
    for leg in LEGS:
        for _ in range(5):
            robot, way, push = drawn_cell(rng, leg)
            early = {**push, "elapsed": 0.0, "duration": 0.9 * robot.gait.step_duration[0]}
            if sf.push_limit(robot, way, **early).impulse > 0.0:
                assert share(robot, way, **early) == 1.0


def test_a_blow_has_no_end_to_be_known() -> None:
    """To land after the push instead of in it costs e^(-omega D) at most of what it is worth."""
    for robot, way, push in costly_cells(6, "unlimited", 4):
        shares = [share(robot, way, **{**push, "duration": short}) for short in (1e-2, 1e-3, 1e-4)]
        missing = [1.0 - one for one in shares]
        assert missing[2] <= missing[1] <= missing[0] + 1e-6
        assert missing[2] < 2e-3


@pytest.mark.parametrize("leg", LEGS)
def test_longer_pushes_are_no_stronger_and_weaker_ones_have_no_holes(leg: str) -> None:
    """Who is viable throughout a push is so throughout a shorter one, and a weaker one."""
    for robot, way, push in costly_cells(7, leg, 2):
        forces = [
            sf.causal_push_limit(
                robot, way, **{**push, "duration": part * push["duration"]}
            ).impulse
            / part
            for part in (0.1, 0.3, 0.6, 0.9, 1.0)
        ]
        assert (np.diff(forces) <= 1e-3 * forces[-1]).all()
        gait = sf.nominal_gait(robot, push["velocity"])
        direction = sf.causal_push_limit(robot, way, **push).direction
        case = PushCase(robot, gait, direction, push["elapsed"], sf.Side.RIGHT, push["zmp_reach"])
        room, times = best_landings(case)
        survived = share(robot, way, **push) * room
        for part in (0.02, 0.1, 0.4, 0.7, 0.9, 0.999):
            kept = case.step().causal_share(push["duration"], part * survived, times)
            assert kept == pytest.approx(1.0, abs=1e-4)


def test_left_is_the_mirror_of_right() -> None:
    for leg in LEGS:
        for robot, (x, y), push in costly_cells(8, leg, 2):
            right = sf.causal_push_limit(robot, (x, y), **push)
            left = sf.causal_push_limit(robot, (x, -y), **push, support_side=sf.Side.LEFT)
            assert left.impulse == pytest.approx(right.impulse, rel=1e-12)


@pytest.mark.parametrize(
    "scale", [Scale(4.0, 3.0), Scale(0.25, 0.01), Scale(9.7, 77.0), Scale(0.13, 1.0)], ids=str
)
def test_dynamic_similarity(scale: Scale) -> None:
    for leg in LEGS:
        for robot, way, push in costly_cells(9, leg, 2):
            reach = push["zmp_reach"]
            scaled = {
                "velocity": scale.velocity(push["velocity"]),
                "elapsed": scale.time * push["elapsed"],
                "duration": scale.time * push["duration"],
                "zmp_reach": (scale.length * reach[0], scale.length * reach[1]),
            }
            for limit in (sf.push_limit, sf.causal_push_limit):
                expected = scale.impulse * limit(robot, way, **push).impulse
                found = limit(scale.robot(robot), way, **scaled).impulse
                assert found == pytest.approx(expected, rel=1e-9)


def test_misuse_is_told_as_by_the_other_limit(robot: sf.Robot) -> None:
    with pytest.raises(sf.ParameterError, match="direction"):
        sf.causal_push_limit(robot, (0.0, 0.0))
    with pytest.raises(sf.ParameterError, match="duration"):
        sf.causal_push_limit(robot, (1.0, 0.0), duration=0.0)

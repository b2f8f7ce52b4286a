"""One schedule of landings for both axes: bounds from above and below, brute force, laws."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from msgspec import structs

import surefoot as sf
from surefoot.dcm.push_limit import PushCase
from surefoot.dcm.pushed_step import PushedStep, best_schedule
from surefoot.dcm.pushes import eight_directions

WAYS = eight_directions(sf.Side.RIGHT)
CASES = [
    ("forward-outward", 0.4, 3.0, math.inf, (0.5, 0.0)),
    ("forward-outward", 0.4, 3.0, 60.0, (0.5, 0.0)),
    ("forward-inward", 0.1, 3.0, 60.0, (0.5, 0.0)),
    ("forward-inward", 0.1, 4.0, 30.0, (0.3, 0.0)),
    ("back-outward", 0.2, 4.0, math.inf, (-0.3, 0.0)),
    ("back-inward", 0.4, 3.0, 60.0, (-0.3, 0.1)),
]


def pushed(way: str, elapsed: float, speed: float, acceleration: float, velocity) -> PushedStep:
    robot = sf.load_robot("paper-biped").with_leg(max_speed=speed, max_acceleration=acceleration)
    return PushCase(robot, WAYS[way], velocity=velocity, elapsed=elapsed).step


@pytest.mark.parametrize("case", CASES)
def test_no_other_schedule_has_more_room(case) -> None:
    """A dense scan, and a cloud around the best: with the last period shared by all later steps."""
    step = pushed(*case)
    room, schedule = best_schedule(step)
    assert room <= min(step.axis_rooms().values()) + 1e-12
    shortest, longest = step.robot.gait.step_duration
    first = np.linspace(max(shortest - step.elapsed, 0.0), longest - step.elapsed, 25)
    later = shortest + (longest - shortest) * np.linspace(0.0, 1.0, 7) ** 2
    scanned = [
        step.room((one, two, three, period))
        for one, two, three, period in itertools.product(first, later, later, later[:4])
    ]
    assert max(scanned) <= room + 1e-6
    rng = np.random.default_rng(0)
    lower = np.array([first[0], *[shortest] * 3])
    upper = np.array([first[-1], *[longest] * 3])
    best = np.array(schedule[:4])
    for spread in (0.05, 0.01, 0.002, 0.0004):
        cloud = best + spread * rng.normal(size=(1500, 4)) * rng.random((1500, 1))
        near = max(step.room(each) for each in np.clip(cloud, lower, upper))
        assert near <= room * (1.0 + 6e-4)


@pytest.mark.parametrize("case", CASES)
def test_hoping_for_better_later_brings_little(case) -> None:
    """If each axis goes its own way after k landings nothing attainable is missed, so this bounds
    the limit from above; with the times found so far both bounds close."""
    step = pushed(*case)
    room, schedule = best_schedule(step)
    times = [*schedule[:3], *[schedule[3]] * 6]
    hopeful = [step.room((*times[:k], 0.2), own_times=True) for k in (2, 4, 8)]
    assert hopeful[0] >= hopeful[1] - 2e-5
    assert hopeful[1] >= hopeful[2] - 2e-5
    assert room - 2e-5 <= hopeful[2] <= room * 1.002 + 2e-5


def forward_pass(step: PushedStep, schedule, landings: int = 12) -> float:
    """The room by another way: landings in the order of time, each as good as a fine grid has it.

    For a fixed schedule an axis is a chain; of all its chains of grid points the best one is found
    by looking at every pair of neighbours, forwards in time.
    """
    robot, (offset, foot, velocity) = step.robot, step.state
    times = [*schedule[:3], *[schedule[3]] * landings][:landings]
    room = math.inf
    for axis, part in enumerate(step.direction):
        low, high = robot.gait.step_x if axis == 0 else (
            robot.hip + robot.gait.step_y[0], robot.hip + robot.gait.step_y[1]
        )  # fmt: skip
        grid, sign = np.linspace(low, high, 501), math.copysign(1.0, part)
        slack = 1.5 * (grid[1] - grid[0])
        decay, best = 1.0, np.zeros(0)
        for k, time in enumerate(times):
            decay *= math.exp(-robot.omega * time)
            turned = -1.0 if axis == 1 and k % 2 == 1 else 1.0
            gain = decay * sign * turned * grid
            way = way_of_leg(robot, 0.0, time)
            if k == 0:
                ahead = foot[axis] + way_of_leg(robot, velocity[axis], time)
                behind = foot[axis] - way_of_leg(robot, -velocity[axis], time)
                open_ = (grid <= ahead + slack / 3) & (grid >= behind - slack / 3)
                best = np.where(open_, gain, -np.inf)
                continue
            start = -grid if axis == 0 else grid
            pairs = np.where(np.abs(grid[:, None] - start) <= way + slack / 3, best, -np.inf)
            best = pairs.max(axis=1) + gain
        room = min(room, (best.max() - sign * offset[axis]) / abs(part))
    return room


def way_of_leg(robot: sf.Robot, velocity: float, time: float) -> float:
    """How far the foot gets, in small steps of time."""
    speed, acceleration = robot.swing.max_speed, robot.swing.max_acceleration
    if math.isinf(acceleration):
        return speed * time
    moments = (np.arange(2000) + 0.5) * time / 2000
    return float(np.minimum(velocity + acceleration * moments, speed).mean() * time)


@pytest.mark.parametrize("case", CASES)
def test_a_forward_pass_over_a_grid_finds_the_same_room(case) -> None:
    step = pushed(*case)
    for schedule in (best_schedule(step)[1][:4], (0.3, 0.25, 0.3, 0.24), (0.15, 0.2, 0.35, 0.3)):
        found = step.room(schedule)
        if found > 0.0:
            assert found == pytest.approx(forward_pass(step, schedule), abs=4e-3)


def test_the_axis_that_is_not_pushed_has_to_be_held_too(robot: sf.Robot) -> None:
    """Sideways this robot has to wait before it lands, and pushed forward it would rather not."""
    limits = structs.replace(robot.gait, step_y=(-0.002, 0.01))
    narrow = robot.replace(hip=0.3, gait=limits).with_leg(max_speed=2.0)
    limit = sf.push_limit(narrow, (1.0, 0.0), velocity=(0.3, 0.0), elapsed=0.2)
    wide = robot.replace(hip=0.3).with_leg(max_speed=2.0)
    free = sf.push_limit(wide, (1.0, 0.0), velocity=(0.3, 0.0), elapsed=0.2)
    assert 0.0 < limit.impulse < 0.95 * free.impulse


def test_the_directions_go_round() -> None:
    angles = [math.degrees(math.atan2(y, x)) % 360.0 for x, y in WAYS.values()]
    assert angles == pytest.approx([0, 45, 90, 135, 180, 225, 270, 315])
    assert all(math.hypot(*way) == pytest.approx(1.0) for way in WAYS.values())
    mirrored = eight_directions(sf.Side.LEFT)
    assert all(mirrored[name] == (x, -y) for name, (x, y) in WAYS.items())


def test_diagonal_limits_obey_the_laws_of_the_axes(robot: sf.Robot) -> None:
    legs = [
        robot.with_leg(max_speed=speed, max_acceleration=acceleration)
        for speed, acceleration in ((2.0, 30.0), (3.0, 30.0), (3.0, 60.0), (4.0, 120.0))
    ]
    for way in ("forward-outward", "back-inward"):
        found = [sf.push_limit(leg, WAYS[way], elapsed=0.3).impulse for leg in legs]
        assert (np.diff(found) > -1e-3 * found[0]).all()
        sole = sf.push_limit(legs[1], WAYS[way], elapsed=0.3, zmp_reach=robot.foot.half).impulse
        assert sole > found[1]

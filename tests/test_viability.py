"""What can still be saved by stepping: offsets, landings, and the distance of a fall."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec import structs

import surefoot as sf
from random_cells import random_cell, random_robot
from surefoot.dcm.push_limit import impulse_per_offset
from surefoot.dcm.viability import fall_distance, viable_landings
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.interface import COMMAND, OBSERVATION, rotate_record
from surefoot.record import copy_array
from surefoot.robot.robot import Trunk

ROBOT = sf.load_robot("paper-biped")


def test_the_bounds_of_table_2() -> None:
    wide = sf.viable_offsets(ROBOT, sf.Side.RIGHT)
    assert wide.upper == pytest.approx((0.4929, 0.1635), abs=5e-5)
    assert wide.lower == pytest.approx((-0.4929, -0.3294), abs=5e-5)
    narrow = sf.viable_offsets(ROBOT.replace(hip=0.1), sf.Side.LEFT)
    assert (narrow.lower[1], narrow.upper[1]) == pytest.approx((-0.1967, 0.2962), abs=5e-5)


def test_offsets_of_left_mirror_those_of_right() -> None:
    right, left = (sf.viable_offsets(ROBOT, side) for side in sf.Side)
    assert left.lower[1] == -right.upper[1]
    assert left.upper[1] == -right.lower[1]
    assert (left.lower[0], left.upper[0]) == (right.lower[0], right.upper[0])


def test_a_finite_foot_widens_both_ends() -> None:
    point = sf.viable_offsets(ROBOT, sf.Side.LEFT)
    finite = sf.viable_offsets(ROBOT, sf.Side.LEFT, ROBOT.foot.half)
    assert np.subtract(finite.upper, point.upper) == pytest.approx(ROBOT.foot.half)
    assert np.subtract(point.lower, finite.lower) == pytest.approx(ROBOT.foot.half)


def test_margin_counts_inside_and_outside() -> None:
    viable = sf.ViableOffsets((-1.0, -2.0), (1.0, 2.0))
    assert viable.margin((0.0, 0.0)) == 1.0
    assert viable.margin((0.9, 1.95)) == pytest.approx(0.05)
    assert viable.margin((0.0, 2.5)) == pytest.approx(-0.5)


@pytest.mark.parametrize("hip", [0.01, 0.1, 0.2])
@pytest.mark.parametrize("reach", [0.0, 0.055])
@pytest.mark.parametrize("step_y", [(-0.2, 0.3), (-0.02, 0.05), (0.0, 0.01), (-0.1, 0.0)])
def test_the_lateral_bounds_are_the_fixed_point_of_what_steps_can_do(hip, reach, step_y) -> None:
    """Independent: iterate the one-step map of intervals instead of the closed form.

    In the frame of the standing foot, positive towards its swing side, an offset e grows to
    E e -+ reach (E - 1), and a step of width w turns it into w - e' for the next foot. The time
    of the step may be any between the limits.
    """
    limits = structs.replace(ROBOT.gait, step_y=step_y)
    robot = ROBOT.replace(hip=hip, gait=limits)
    growth = np.exp(robot.omega * np.linspace(*limits.step_duration, 7))
    inner, outer = hip + step_y[0], hip + step_y[1]
    low, high = -10.0, 10.0
    for _ in range(400):
        # Savable now: some w in [inner, outer] and some zmp bring w - (grown e) into [low, high].
        low, high = (
            ((inner - high - reach * (growth - 1.0)) / growth).min(),
            ((outer - low + reach * (growth - 1.0)) / growth).max(),
        )
    viable = sf.viable_offsets(robot, sf.Side.LEFT, (reach, reach))
    assert (low, high) == pytest.approx((viable.lower[1], viable.upper[1]), abs=1e-12)


def test_the_forward_bound_is_what_the_longest_fastest_steps_hold() -> None:
    growth = math.exp(ROBOT.omega * ROBOT.gait.step_duration[0])
    bound = sf.viable_offsets(ROBOT, sf.Side.LEFT).upper[0]
    inside, outside = bound - 1e-6, bound + 1e-6
    for _ in range(30):
        inside = inside * growth - ROBOT.gait.step_x[1]
        outside = outside * growth - ROBOT.gait.step_x[1]
    assert inside < -1.0  # it gets ahead of the robot, which could now take shorter steps
    assert outside > 1.0


def test_a_narrow_lateral_range_still_holds_its_nominal_gait() -> None:
    """A robot that can hardly change its step width waits instead: no false alarm."""
    narrow = ROBOT.replace(gait=structs.replace(ROBOT.gait, step_y=(-0.02, 0.05)))
    for velocity in ((0.5, 0.0), (0.0, 0.0), (-0.3, 0.02)):
        gait = sf.nominal_gait(narrow, velocity)
        assert sf.viable_offsets(narrow, sf.Side.RIGHT).margin(gait.dcm_offset(sf.Side.RIGHT)) > 0.0


def test_a_side_may_be_given_as_its_number() -> None:
    """An observation holds a number; the sign must not get lost on the way."""
    gait = sf.nominal_gait(ROBOT, (0.3, 0.1))
    for side in sf.Side:
        assert sf.viable_offsets(ROBOT, int(side)) == sf.viable_offsets(ROBOT, side)  # type: ignore[arg-type]
        assert ROBOT.gait.step_box(int(side), 0.2) == ROBOT.gait.step_box(side, 0.2)  # type: ignore[arg-type]
        assert gait.dcm_offset(int(side)) == gait.dcm_offset(side)  # type: ignore[arg-type]
        assert gait.observation(side).support_side is side


@pytest.mark.parametrize("seed", range(30))
def test_no_state_that_is_called_a_fall_can_be_saved(seed: int) -> None:
    """By the tables of what can be saved: none of these contains a state that is so far away."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, acceleration=seed % 2 == 1)
    tables = viable_displacement(robot.with_leg(max_speed=math.inf) if seed % 3 else robot)
    largest = 0.0
    for _ in range(100):
        elapsed = rng.uniform(0.0, 1.2) * robot.gait.step_duration[0]
        corner = rng.choice((-1, 1), 2)
        for sign_x, sign_y in (corner, -corner):
            rooms = []
            for axis, sign in enumerate((sign_x, sign_y)):
                low, width = tables.low[axis], 100 * tables.spacing[axis]
                foot = low + rng.uniform(0.0, 1.0) * width
                value = tables.in_step(axis, int(sign), foot, elapsed)
                rooms.append(value + robot.foot.half[axis])
            largest = max(largest, math.hypot(*rooms))
    assert 0.0 < largest <= fall_distance(robot)


@pytest.mark.parametrize("seed", range(20))
def test_no_schedule_of_steps_saves_what_is_called_a_fall(seed: int) -> None:
    """Backwards in time, from an offset of 0: steps, turns and ZMPs of all sorts, and the worst."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng)
    shortest, longest = robot.gait.step_duration
    half, most = np.array(robot.foot.half), fall_distance(robot)
    low, high = robot.gait.step_box(sf.Side.RIGHT, robot.hip)
    largest = 0.0
    for _ in range(200):
        offset, heading, side = np.zeros(2), 0.0, 1.0
        worst, turn = rng.random() < 0.5, rng.choice((0.0, rng.uniform(-math.pi, math.pi)))
        for _ in range(12):
            share = rng.integers(0, 2, 2) if worst else rng.uniform(0.0, 1.0, 2)
            step = np.array(low) + share * np.subtract(high, low)
            step[1] *= side
            cosine, sine = math.cos(heading), math.sin(heading)
            turned = np.array([[cosine, -sine], [sine, cosine]])
            zmp = half * (rng.choice((-1, 1), 2) if worst else rng.uniform(-1.0, 1.0, 2))
            # At the landing, and then at the touchdown before it.
            offset = offset + turned @ step
            largest = max(largest, float(np.linalg.norm(offset)))
            time = shortest if worst else rng.uniform(shortest, longest)
            offset = turned @ zmp + (offset - turned @ zmp) * math.exp(-robot.omega * time)
            heading, side = heading + turn, -side
    assert 0.25 * most < largest <= most


@pytest.mark.parametrize("seed", range(6))
def test_who_cannot_be_saved_is_called_fallen_soon(seed: int) -> None:
    """What is lost by m0 is beyond any distance d after ln(2 d / m0) / omega."""
    cell = random_cell(seed)
    lost = 0.05 * cell.limit().impulse / impulse_per_offset(cell.robot, cell.duration)
    push = cell.push(1.05 * cell.limit().impulse)
    soon = math.log(2.0 * fall_distance(cell.robot) / lost) / cell.robot.omega
    rollout = sf.simulate(
        cell.controller(), push.end + soon, [push], first_support=cell.support_side
    )
    assert rollout.outcome is sf.Outcome.FELL


def test_the_distance_of_a_fall_where_steps_are_all_but_endless() -> None:
    """For E close to 1 a great many steps count, and rounding does not."""
    quick = structs.replace(ROBOT.gait, step_duration=(1e-6, 0.8))
    distance = fall_distance(ROBOT.replace(gait=quick, trunk=None))
    steps = math.hypot(0.5, 0.5) / (ROBOT.omega * 1e-6)
    assert distance == pytest.approx(steps, rel=1e-5)


def test_a_trunk_saves_more_but_not_more_than_the_bound() -> None:
    without = ROBOT.replace(trunk=None)
    assert fall_distance(ROBOT) > fall_distance(without)
    weak = ROBOT.replace(trunk=Trunk(inertia=1e-9, max_torque=1e-9, max_lean=1e-9))
    assert fall_distance(weak) == pytest.approx(fall_distance(without), rel=1e-6)


def test_the_steps_of_a_controller_count_that_knows_another_robot() -> None:
    narrow = ROBOT.replace(
        gait=structs.replace(ROBOT.gait, step_x=(-0.05, 0.05), step_y=(-0.02, 0.02)), trunk=None
    )
    own, other = fall_distance(narrow), fall_distance(ROBOT.replace(trunk=None))
    assert own < 0.5 * other
    assert fall_distance(narrow, ROBOT) == pytest.approx(other)
    assert fall_distance(ROBOT, narrow) == fall_distance(ROBOT)
    # What such a controller saves by steps of its own is no fall.
    push = sf.Push(1.1, 0.1, (1200.0, 0.0))
    rollout = sf.simulate(sf.UnifiedController(ROBOT, (0.4, 0.0)), 3.0, [push], plant=narrow)
    away = np.hypot(*(rollout.dcm - rollout.support_foot).T)
    assert away.max() > own
    assert rollout.outcome is not sf.Outcome.FELL


ROBOTS = [sf.load_robot(name) for name in sf.preset_names()]
EVERY_ROBOT = pytest.mark.parametrize("robot", ROBOTS, ids=lambda robot: robot.name)


def walk_of(robot: sf.Robot, first: sf.Side, push: tuple[float, float] = (0.0, 0.0)) -> sf.Rollout:
    controller = sf.UnifiedController(robot, (0.2, 0.0))
    pushes = [sf.Push(0.3, 0.1, push)] if any(push) else []
    return sf.simulate(controller, 1.5, pushes, first_support=first)


@pytest.fixture(scope="module")
def pushed(robot: sf.Robot) -> sf.Rollout:
    return walk_of(robot, sf.Side.LEFT, (150.0, 90.0))


def boxes(rollout: sf.Rollout) -> np.ndarray:
    rows = zip(rollout.observations, rollout.commands, strict=True)
    return np.array([viable_landings(rollout.robot, seen, answer) for seen, answer in rows])


@EVERY_ROBOT
def test_the_nominal_landing_can_always_be_saved(robot: sf.Robot) -> None:
    """At every cycle of a walk that nothing disturbs."""
    walk = walk_of(robot, sf.Side.LEFT)
    step = walk.commands["step_location"] - walk.support_foot
    box = boxes(walk)
    assert (box[:, 0] <= step + 1e-6).all()
    assert (step <= box[:, 1] + 1e-6).all()


@EVERY_ROBOT
def test_every_landing_is_one_the_gait_allows(robot: sf.Robot) -> None:
    walk = walk_of(robot, sf.Side.RIGHT, (0.0, 40.0))
    box, side = boxes(walk), walk.support_side
    gait = robot.gait
    assert (box[:, 0, 0] >= gait.step_x[0]).all()
    assert (box[:, 1, 0] <= gait.step_x[1]).all()
    width = np.sort(side[:, None] * box[:, :, 1], axis=1) - robot.hip
    there = (box[:, 1] > box[:, 0]).all(axis=1)
    assert (width[there, 0] >= gait.step_y[0] - 1e-12).all()
    assert (width[there, 1] <= gait.step_y[1] + 1e-12).all()


def test_the_box_shrinks_to_where_the_foot_is(robot: sf.Robot) -> None:
    """A leg of limited speed has fewer choices the later it is."""
    robot = robot.with_leg(max_speed=2.0)
    walk = walk_of(robot, sf.Side.LEFT)
    last = int(np.flatnonzero(np.diff(walk.support_side))[0])
    size = np.ptp(boxes(walk), axis=1)
    assert (size[last] < 0.02).all()
    assert (size[last // 2] > 0.1).all()


def test_landings_of_left_mirror_those_of_right(robot: sf.Robot, pushed: sf.Rollout) -> None:
    box, mirrored = boxes(pushed), boxes(walk_of(robot, sf.Side.RIGHT, (150.0, -90.0)))
    assert mirrored[:, :, 0] == pytest.approx(box[:, :, 0], abs=1e-9)
    assert mirrored[:, 0, 1] == pytest.approx(-box[:, 1, 1], abs=1e-9)
    assert mirrored[:, 1, 1] == pytest.approx(-box[:, 0, 1], abs=1e-9)


@pytest.mark.parametrize("angle", [0.3, -1.2, 0.5 * math.pi, 3.0])
def test_it_does_not_matter_where_north_is(pushed: sf.Rollout, angle: float) -> None:
    box = boxes(pushed)
    for row in range(0, len(box), 50):
        seen = rotate_record(np.array([pushed.observations[row]], OBSERVATION), angle)[0]
        answer = rotate_record(np.array([pushed.commands[row]], COMMAND), angle)[0]
        assert viable_landings(pushed.robot, seen, answer) == pytest.approx(box[row], abs=1e-9)


def test_a_shift_does_not_matter(pushed: sf.Rollout) -> None:
    box, row = boxes(pushed), 350
    seen = copy_array(np.array([pushed.observations[row]], OBSERVATION))
    answer = copy_array(np.array([pushed.commands[row]], COMMAND))
    for name in ("com", "dcm", "support_foot", "swing_foot"):
        seen[name][0, :2] += (3.0, -2.0)
    for name in ("zmp", "step_location"):
        answer[name][0] += (3.0, -2.0)
    assert viable_landings(pushed.robot, seen[0], answer[0]) == pytest.approx(box[row], abs=1e-9)


@pytest.mark.parametrize("away", [(2.0, 0.0), (-2.0, 0.0), (0.0, 2.0), (0.0, -2.0)])
def test_a_dcm_far_away_cannot_be_saved(pushed: sf.Rollout, away: tuple[float, float]) -> None:
    seen = copy_array(np.array([pushed.observations[100]], OBSERVATION))
    seen["dcm"][0] += away
    low, high = viable_landings(pushed.robot, seen[0], pushed.commands[100])
    assert not (high > low).all()

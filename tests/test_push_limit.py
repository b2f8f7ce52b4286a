"""The largest push that any policy survives: laws, a second computation, and golden numbers.

The golden numbers are of an independent prototype: 70 kg, hip 0.2 m, 0.5 m/s with steps of 0.5 s,
pushed for 0.2 s. Its swing foot moved evenly, not along a quintic, so forward and back are compared
at touchdown only, where the paths agree.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from msgspec import structs

import surefoot as sf
from surefoot.dcm.leg import furthest
from surefoot.dcm.limit_grid import axis_pushes, grid_limit, largest_disagreement
from surefoot.dcm.limit_sweep import USUAL, Mesh
from surefoot.dcm.push_limit import PushCase, fixed_steps_limit, gait_in_step
from surefoot.dcm.pushes import DIRECTIONS, push_direction
from surefoot.dcm.viable_displacement import NODES, viable_displacement

PHASES = (0.0, 0.1, 0.2, 0.3, 0.4)
WAYS = {
    name: push_direction(DIRECTIONS[name], sf.Side.RIGHT)
    for name in ("forward", "back", "outward", "inward")
}


def with_steps(robot: sf.Robot, hip: float, step_y: tuple[float, float]) -> sf.Robot:
    return robot.replace(hip=hip, gait=structs.replace(robot.gait, step_y=step_y))


def impulses(robot: sf.Robot, **options) -> list[float]:
    return [sf.push_limit(robot, way, **options).impulse for way in WAYS.values()]


def test_an_unlimited_leg(robot_70kg: sf.Robot) -> None:
    half = robot_70kg.foot.half
    assert impulses(robot_70kg) == pytest.approx([213, 264, 145, 93], abs=0.5)
    assert impulses(robot_70kg, zmp_reach=half) == pytest.approx([247, 298, 164, 112], abs=0.5)
    fixed = [fixed_steps_limit(robot_70kg, way).impulse for way in WAYS.values()]
    assert fixed == pytest.approx([34, 34, 19, 19], abs=0.5)


@pytest.mark.parametrize(
    ("way", "point", "sole"),
    [
        ("outward", (102, 145, 139, 131, 118), (121, 164, 158, 149, 137)),
        ("inward", (66, 93, 109, 118, 130), (85, 112, 128, 136, 149)),
        ("forward", (89,), (123,)),
        ("back", (142,), (176,)),
    ],
)
def test_a_leg_of_3_m_per_s(robot_70kg: sf.Robot, way: str, point, sole) -> None:
    slow = robot_70kg.with_leg(max_speed=3.0)
    for reach, golden in (((0.0, 0.0), point), (robot_70kg.foot.half, sole)):
        found = [
            sf.push_limit(slow, WAYS[way], elapsed=elapsed, zmp_reach=reach).impulse
            for elapsed in PHASES[: len(golden)]
        ]
        assert found == pytest.approx(golden, abs=0.55)


def test_the_displacement_after_a_step(robot: sf.Robot) -> None:
    tables = viable_displacement(robot.with_leg(max_speed=3.0))
    found = [tables.after_step(0, 1, step) for step in (0.0, 0.25, 0.5)]
    assert found == pytest.approx([0.3645, 0.3123, 0.2343], abs=5e-5)


@pytest.mark.parametrize("hip", [0.01, 0.1, 0.2])
@pytest.mark.parametrize("step_y", [(-0.2, 0.3), (-0.02, 0.05), (0.0, 0.01), (-0.1, 0.0)])
def test_without_a_limited_leg_the_tables_are_the_viable_offsets(
    robot: sf.Robot, hip: float, step_y: tuple[float, float]
) -> None:
    narrow = with_steps(robot, hip, step_y)
    tables, viable = viable_displacement(narrow), sf.viable_offsets(narrow, sf.Side.LEFT)
    for axis in range(2):
        for step in tables.low[axis] + tables.spacing[axis] * np.array([0, 17, 33.3, NODES - 1]):
            found = -tables.after_step(axis, -1, step), tables.after_step(axis, 1, step)
            assert found == pytest.approx((viable.lower[axis], viable.upper[axis]), abs=1e-9)


@pytest.mark.parametrize(
    ("speed", "acceleration"),
    [(1.0, math.inf), (3.0, math.inf), (6.0, math.inf), (3.0, 30.0), (6.0, 60.0), (math.inf, 60.0)],
)
@pytest.mark.parametrize("step_y", [(-0.2, 0.3), (-0.02, 0.05)])
def test_the_tables_satisfy_their_equation(
    robot: sf.Robot, speed: float, acceleration: float, step_y
) -> None:
    """By brute force over landings and landing times, from some nodes."""
    slow = with_steps(robot, 0.2, step_y).with_leg(max_speed=speed, max_acceleration=acceleration)
    tables = viable_displacement(slow)
    shortest, longest = robot.gait.step_duration
    times = np.linspace(shortest, longest, 601)[:, np.newaxis]
    ways = np.array([[furthest(0.0, time[0], speed, acceleration)] for time in times])
    for axis, (k, sign) in itertools.product(range(2), enumerate((1.0, -1.0))):
        nodes = tables.low[axis] + tables.spacing[axis] * np.arange(NODES)
        landings = np.linspace(nodes[0], nodes[-1], 1001)
        after = np.interp(landings, nodes, tables.values[axis, k if axis == 0 else 1 - k])
        for node in (0, 30, 61, 100):
            foot = -nodes[node] if axis == 0 else nodes[node]
            value = np.exp(-slow.omega * times) * (sign * landings + after)
            value[np.abs(landings - foot) > ways + 1e-9] = -np.inf
            assert tables.values[axis, k, node] == pytest.approx(value.max(), abs=6e-4)
            assert tables.values[axis, k, node] >= value.max() - 1e-9


@pytest.mark.parametrize(("axis", "sign"), [(0, 1), (0, -1), (1, 1), (1, -1)])
def test_the_limit_in_a_step_satisfies_its_equation(robot: sf.Robot, axis: int, sign: int) -> None:
    """Wait a little: the foot moves on at most V h, and a value Z then is e^(-omega h) Z now."""
    tables, wait = viable_displacement(robot.with_leg(max_speed=3.0)), 0.01
    for foot, elapsed in itertools.product((-0.2, 0.0, 0.15, 0.3), (0.0, 0.05, 0.19, 0.25, 0.5)):
        if axis == 1 and foot < tables.low[1]:
            continue
        now = tables.in_step(axis, sign, foot, elapsed)
        moves = np.linspace(-3.0 * wait, 3.0 * wait, 61)
        later = max(
            math.exp(-robot.omega * wait) * tables.in_step(axis, sign, foot + move, elapsed + wait)
            for move in moves
        )
        if elapsed + wait <= robot.gait.step_duration[0]:
            assert now == pytest.approx(later, abs=1e-9)
        else:
            # It may be better to land first, even here and now.
            after = tables.after_step(axis, sign if axis == 0 else -sign, foot)
            assert now >= max(later, sign * foot + after) - 1e-9


@pytest.mark.parametrize("velocity", [0.0, 1.5, -2.0])
@pytest.mark.parametrize("acceleration", [20.0, 60.0])
def test_the_limit_in_a_step_is_the_best_of_all_landings(robot, velocity, acceleration) -> None:
    """By brute force over landing times and all that the moving foot can reach in them."""
    leg = robot.with_leg(max_speed=3.0, max_acceleration=acceleration)
    tables = viable_displacement(leg)
    for axis, k, foot, elapsed in itertools.product((0, 1), (0, 1), (0.1, 0.3), (0.05, 0.25)):
        sign, low = 1 - 2 * k, tables.low[axis]
        nodes = low + tables.spacing[axis] * np.arange(NODES)
        after = tables.values[axis, k if axis == 0 else 1 - k]
        best = -math.inf
        for time in np.linspace(max(0.2 - elapsed, 0.0), 0.8 - elapsed, 801):
            ahead = foot + furthest(velocity, time, 3.0, acceleration)
            behind = foot - furthest(-velocity, time, 3.0, acceleration)
            if behind > nodes[-1] or ahead < low:
                continue
            # A concave value has its maximum at a node inside or at an end of the reach.
            inside = nodes[(nodes >= behind) & (nodes <= ahead)]
            landings = np.append(inside, np.clip((behind, ahead), low, nodes[-1]))
            value = sign * landings + np.interp(landings, nodes, after)
            best = max(best, math.exp(-leg.omega * time) * value.max())
        found = tables.in_step(axis, sign, foot, elapsed, velocity)
        assert found == pytest.approx(best, abs=1e-3)
        assert found >= best - 1e-12


def test_the_acceleration_takes_its_share(robot: sf.Robot) -> None:
    """More of it never hurts, and very much of it is as good as no limit."""
    tables = [
        impulses(robot.with_leg(max_speed=3.0, max_acceleration=acceleration), elapsed=0.25)
        for acceleration in (20.0, 30.0, 60.0, 120.0, 1e6, math.inf)
    ]
    assert (np.diff(tables, axis=0) >= -1e-9).all()
    assert (np.array(tables[0]) < 0.97 * np.array(tables[-1])).all()
    assert tables[-2] == pytest.approx(tables[-1], rel=1e-4)


@pytest.mark.parametrize(
    ("speed", "acceleration", "mesh"),
    [
        *((speed, math.inf, Mesh(0.004, 100)) for speed in (2.0, 6.0, math.inf)),
        (3.0, 60.0, USUAL._replace(levels=4)),
    ],
)
@pytest.mark.parametrize("sole", [False, True])
def test_a_grid_agrees(robot, speed: float, acceleration: float, mesh: Mesh, sole: bool) -> None:
    leg = robot.with_leg(max_speed=speed, max_acceleration=acceleration)
    reach = robot.foot.half if sole else (0.0, 0.0)
    for way, elapsed in itertools.product(WAYS.values(), PHASES):
        case = PushCase(leg, way, elapsed=elapsed, zmp_reach=reach)
        assert case.limit().impulse == pytest.approx(grid_limit(case, mesh), rel=0.01)


def test_a_grid_agrees_where_waiting_is_best(robot: sf.Robot) -> None:
    """A narrow lateral range, and a step box that is not the same forward and back."""
    limits = structs.replace(robot.gait, step_x=(-0.3, 0.5), step_y=(-0.02, 0.05))
    narrow = robot.replace(gait=limits).with_leg(max_speed=3.0)
    assert viable_displacement(narrow).after_step(1, -1, 0.2) < 0.0
    found = largest_disagreement(axis_pushes([narrow], (0.05, 0.2), (0.3, 0.01), 0.1))
    assert found["fraction"] < 0.01
    # Across it has to wait, which the axis of the push would rather not.
    both = {"velocity": (0.3, 0.01), "elapsed": 0.05, "duration": 0.1}
    alone = sf.push_limit(narrow, WAYS["back"], together=False, **both).impulse
    assert sf.push_limit(narrow, WAYS["back"], **both).impulse == pytest.approx(
        0.848 * alone, rel=0.01
    )


@pytest.mark.parametrize("leg_speed", [2.0, math.inf])
@pytest.mark.parametrize("velocity", [(0.0, 0.0), (-0.3, 0.0), (0.1, 0.2)])
@pytest.mark.parametrize("name", ["forward", "back", "outward", "inward"])
def test_step_timing_stays_below_the_limit_of_a_point_foot(name, velocity, leg_speed) -> None:
    """Its ZMP rests, so it is bound by the point foot; at any velocity, on any leg."""
    robot = sf.load_robot("paper-biped").replace(swing=sf.Swing(max_speed=leg_speed))
    controller = sf.StepTiming(robot, velocity)
    direction = WAYS[name]
    duration = controller.gait.step_duration
    limit = sf.push_limit(robot, direction, velocity=velocity, elapsed=0.25 * duration).impulse
    failing = sf.smallest_failing_push(controller, direction, start=2.25 * duration).impulse
    assert 0.3 * limit < failing - 1.0 <= limit + 1e-9


def test_a_gait_that_the_leg_cannot_swing_has_no_limit() -> None:
    slow = sf.load_robot("paper-biped").replace(swing=sf.Swing(max_speed=1.5))
    with pytest.raises(sf.VelocityError, match=r"at least 1\.875 m/s .* less than about 0\.4 m/s"):
        sf.push_limit(slow, (1.0, 0.0))
    assert sf.push_limit(slow, (1.0, 0.0), velocity=(0.3, 0.0)).impulse > 0.0
    weak = slow.with_leg(max_speed=3.0, max_acceleration=10.0)
    with pytest.raises(sf.VelocityError, match=r"at least 11\.55 m/s\^2 .* less than about 0\.43"):
        sf.push_limit(weak, (1.0, 0.0))
    assert sf.push_limit(weak, (1.0, 0.0), velocity=(0.4, 0.0)).impulse > 0.0


@pytest.mark.parametrize("way", WAYS)
def test_no_controller_passes_the_limit(robot_70kg: sf.Robot, way: str) -> None:
    controller = sf.HybridController(
        robot_70kg, (0.5, 0.0), threshold=0.0, offset_weight=(1000.0, 1000.0)
    )
    limit = sf.push_limit(robot_70kg, WAYS[way]).impulse
    survived = sf.smallest_failing_push(controller, WAYS[way]).impulse - 1.0
    assert survived <= limit
    assert survived >= (0.98 if way == "forward" else 0.85) * limit


def test_walking_backwards_mirrors_walking_forwards(robot: sf.Robot) -> None:
    slow = robot.with_leg(max_speed=3.0)
    ahead = sf.push_limit(slow, (1.0, 0.0), velocity=(0.5, 0.0))
    behind = sf.push_limit(slow, (-1.0, 0.0), velocity=(-0.5, 0.0))
    assert behind.impulse == pytest.approx(ahead.impulse, rel=1e-9)


def test_a_faster_leg_and_a_larger_foot_survive_more(robot: sf.Robot) -> None:
    speeds = (2.0, 2.5, 3.0, 4.0, 6.0, 10.0, math.inf)
    table = np.array([impulses(robot.with_leg(max_speed=speed), elapsed=0.2) for speed in speeds])
    assert (np.diff(table, axis=0) >= -1e-9).all()
    assert (table[-1] > 1.2 * table[0]).all()
    reaches = [(0.0, 0.0), (0.05, 0.02), (0.1, 0.055)]
    table = np.array([impulses(robot, zmp_reach=reach) for reach in reaches])
    assert (np.diff(table, axis=0) > 0.0).all()


def test_a_diagonal_of_an_unlimited_leg_has_the_least_of_both_axes(robot: sf.Robot) -> None:
    """Such a leg lands as soon as it may, whatever the axis, so nothing has to be agreed on."""
    forward, outward = (sf.push_limit(robot, way) for way in ((1.0, 0.0), (0.0, 1.0)))
    diagonal = sf.push_limit(robot, (3.0, 4.0))
    assert diagonal.direction == pytest.approx((0.6, 0.8))
    assert diagonal.delta_v == pytest.approx(diagonal.impulse / robot.mass)
    least = min(forward.impulse / 0.6, outward.impulse / 0.8)
    assert diagonal.impulse == pytest.approx(least, rel=1e-4)
    fixed = fixed_steps_limit(robot, (3.0, 4.0))
    sideways = fixed_steps_limit(robot, (0.0, 1.0))
    assert fixed.impulse == pytest.approx(sideways.impulse / 0.8)


@pytest.mark.parametrize("velocity", [(0.5, 0.0), (0.3, 0.1), (-0.2, -0.05)])
def test_it_starts_where_a_walk_is(robot: sf.Robot, velocity: tuple[float, float]) -> None:
    controller = sf.HybridController(robot, velocity)
    walk = sf.simulate(controller, 1.5)
    for step, elapsed in ((1, 0.1), (2, 0.3)):
        side, start = walk.footsteps[step].side, walk.footsteps[step].start
        row = int(np.argmin(np.abs(walk.time - (start + elapsed))))
        offset, foot, velocity_of_foot = gait_in_step(
            controller.gait, side, float(walk.time[row] - start)
        )
        support = np.array(walk.footsteps[step].support_foot)
        dcm = walk.dcm[row] - support
        swing = walk.swing_foot[row, :2] - support
        assert (dcm[0], side * dcm[1]) == pytest.approx(offset, abs=1e-6)
        assert (swing[0], side * swing[1]) == pytest.approx(foot, abs=1e-6)
        speed = walk.observations["swing_foot_velocity"][row]
        assert (speed[0], side * speed[1]) == pytest.approx(velocity_of_foot, abs=1e-6)


def test_the_fastest_gait_has_nothing_left_for_a_push(robot: sf.Robot) -> None:
    fastest = sf.largest_speed(robot, (1.0, 0.0))
    limit = sf.push_limit(robot, (1.0, 0.0), velocity=(fastest, 0.0), elapsed=0.18)
    slower = sf.push_limit(robot, (1.0, 0.0), velocity=(0.96 * fastest, 0.0), elapsed=0.18)
    assert limit.impulse == pytest.approx(0.0, abs=1e-5 * slower.impulse)
    assert slower.impulse > 10.0


def test_the_disagreement_names_its_case(robot: sf.Robot) -> None:
    found = largest_disagreement(axis_pushes([robot], (0.1,)))
    reach = robot.foot.half if found["finite_foot"] else (0.0, 0.0)
    limit = sf.push_limit(robot, WAYS[found["direction"]], zmp_reach=reach).impulse
    assert found["impulse"] == limit
    difference, larger = abs(limit - found["grid_impulse"]), max(limit, found["grid_impulse"])
    assert found["fraction"] == pytest.approx(difference / larger)
    assert found["leg_speed"] is found["leg_acceleration"] is None
    slow = largest_disagreement(axis_pushes([robot.with_leg(max_speed=3.0)], (0.1,)))
    assert slow["leg_speed"] == 3.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"direction": (0.0, 0.0)}, "some length"),
        ({"direction": 1.0}, "`direction` as a pair"),
        ({"elapsed": -0.1}, "`elapsed` of at least 0"),
        ({"elapsed": 0.6}, "inside the step, at most 0.5"),
        ({"duration": 0.0}, "`duration` above 0"),
        ({"zmp_reach": (-0.1, 0.0)}, "`zmp_reach` of at least 0"),
        ({"step_duration": 5.0}, "a step duration in"),
    ],
)
def test_misuse_is_refused(robot: sf.Robot, options: dict, words: str) -> None:
    with pytest.raises(sf.ParameterError, match=words):
        sf.push_limit(robot, **{"direction": (1.0, 0.0), **options})


def test_a_leg_that_cannot_step_is_refused(robot: sf.Robot) -> None:
    lame = robot.replace(gait=structs.replace(robot.gait, step_x=(-0.1, 0.5)))
    with pytest.raises(sf.RobotError, match=r"`max_speed` of the swing of at least 0\.5"):
        sf.push_limit(lame.with_leg(max_speed=0.4), (1.0, 0.0), velocity=(0.05, 0.0))

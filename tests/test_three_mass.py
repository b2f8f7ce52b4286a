"""The three-mass pendulum: its plant against the masses themselves, and the method made for it."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import surefoot as sf
from surefoot.cli import main
from surefoot.control.registry import methods
from surefoot.control.three_mass import ThreeMassCapture, flight_share, least_cost
from surefoot.dcm.swing_foot import quintic
from surefoot.dcm.three_mass import three_mass
from surefoot.rollout.rollout import Rollout

ROBOT = sf.load_robot("paper-biped").with_leg(max_speed=6.0, max_acceleration=60.0)
HEAVY = ROBOT.with_heavy_legs()
VELOCITY = (0.4, 0.1)
PUSH = sf.Push(1.1, 0.2, (60.0, 25.0))


def _moment_errors(walk: Rollout) -> np.ndarray:
    """Of every cycle inside a step: the moment of gravity, push and inertia of trunk and two legs
    about the commanded ZMP, per weight [m]; by finite differences, without the pendulum."""
    robot, legs = walk.robot, walk.robot.legs
    assert legs is not None
    trunk = robot.mass - 2.0 * legs.mass
    low = (1.0 - legs.com) * legs.length
    high = (robot.mass * robot.com_height - 2.0 * legs.mass * low) / trunk
    seen, time = walk.observations, walk.time
    feet = seen["support_foot"], seen["swing_foot"][:, :2]
    hip = robot.mass * seen["com"] - legs.mass * legs.com * (feet[0] + feet[1])
    hip = hip / (trunk + 2.0 * legs.mass * (1.0 - legs.com))
    first, second = ((1.0 - legs.com) * hip + legs.com * foot for foot in feet)
    step = time[1] - time[0]

    def rate(place: np.ndarray) -> np.ndarray:
        return (place[2:] - 2.0 * place[1:-1] + place[:-2]) / step**2

    zmp = 0.5 * (walk.commands["zmp"][1:-1] + walk.commands["zmp"][:-2])
    force = np.array([sum_force(walk, at) for at in time[1:-1]])
    moment = robot.gravity * (
        trunk * (hip[1:-1] - zmp) + legs.mass * (first[1:-1] + second[1:-1] - 2.0 * zmp)
    )
    moment += force * robot.com_height
    inertia = trunk * high * rate(hip) + legs.mass * low * (rate(first) + rate(second))
    turning = 2.0 * rate(hip) - rate(feet[0]) - rate(feet[1])
    inertia += legs.inertia / legs.length * turning
    inside = np.diff(seen["support_side"])
    smooth = (inside[1:] == 0) & (inside[:-1] == 0) & (np.abs(np.diff(time, 2)) < 1e-9)
    edges = np.array([any(abs(at - e) < 2.0 * step for p in walk.pushes for e in (p.start, p.end))
                      for at in time[1:-1]])  # fmt: skip
    error = np.abs(moment - inertia).max(axis=1) / (robot.mass * robot.gravity)
    return error[smooth & ~edges]


def sum_force(walk: Rollout, at: float) -> np.ndarray:
    return sum(
        (np.array(push.force) for push in walk.pushes if push.start <= at < push.end), np.zeros(2)
    )


def test_trunk_and_legs_obey_their_moment_balance() -> None:
    """c'' = omega'^2 (...) is the balance of three masses: the plant never computes that."""
    walk = sf.simulate(sf.DcmTracking(HEAVY, VELOCITY), 3.0, [PUSH])
    errors = _moment_errors(walk)
    assert len(errors) > 2500
    assert errors.max() < 2e-5
    wrong = walk.robot.replace(legs=dataclass_with(walk.robot.legs, com=0.3))
    assert _moment_errors(dataclasses.replace(walk, robot=wrong)).max() > 1e-3


def dataclass_with(legs, **changes):
    return type(legs)(**{**{n: getattr(legs, n) for n in legs.__struct_fields__}, **changes})


def test_legs_without_weight_are_a_point_mass() -> None:
    light = dataclass_with(ROBOT.legs, mass=1e-12, inertia=1e-12)
    walk = sf.simulate(sf.HybridController(ROBOT, VELOCITY), 2.0, [PUSH])
    same = sf.simulate(
        sf.HybridController(ROBOT, VELOCITY), 2.0, [PUSH],
        plant=ROBOT.replace(legs=light).with_heavy_legs(),
    )  # fmt: skip
    assert np.allclose(walk.observations["com"], same.observations["com"], rtol=0, atol=1e-9)


def test_a_step_that_is_cut_in_two_is_the_same_step() -> None:
    """The flow is exact: on the same cubic of the foot two half cycles are the whole one."""
    simulator = sf.LipmSimulator(HEAVY, 0.02, [PUSH])
    finer = sf.LipmSimulator(HEAVY, 0.01, [PUSH])
    start = sf.HybridController(HEAVY, VELOCITY).first_observation(None)
    start = start.replace(time=1.09, elapsed=0.1, swing_foot_velocity=(0.9, 0.1, 0.0))
    speed, duration = np.array([1.2, -0.2]), 0.02
    place = start.swing_foot[:2] + np.array([0.021, 0.001])

    def commanded(at: float) -> sf.Command:
        first, moved = start.swing_foot_velocity[:2], place - start.swing_foot[:2]
        u = at / duration
        h = u * u * (3.0 - 2.0 * u), u * (1 - u) ** 2, u * u * (u - 1.0)
        d = 6.0 * u * (1.0 - u), (1 - u) * (1 - 3 * u), u * (3 * u - 2)
        then = h[0] * moved + duration * (h[1] * first + h[2] * speed)
        then_speed = d[0] * moved / duration + d[1] * first + d[2] * speed
        foot = start.swing_foot[:2] + then
        return sf.Command(
            zmp=start.support_foot, dcm_plan=start.dcm, step_location=(0.3, 0.2),
            step_duration=0.5, swing_foot=(*foot, 0.0), swing_foot_velocity=(*then_speed, 0.0),
        )  # fmt: skip

    once, _ = simulator.step(simulator.start(start), commanded(0.02))
    _, world = finer.step(finer.start(start), commanded(0.01))
    twice, _ = finer.step(world, commanded(0.02))
    assert np.allclose(twice.com, once.com, rtol=0, atol=1e-13)
    assert np.allclose(twice.com_velocity, once.com_velocity, rtol=0, atol=1e-12)
    assert np.abs(twice.com_velocity - start.com_velocity).max() > 1e-3


def test_a_foot_that_lands_in_motion_passes_its_momentum_on() -> None:
    """Nothing but gravity acts about the ZMP at a touchdown: the angular momentum stays."""
    simulator = sf.LipmSimulator(HEAVY, 1e-6)
    start = sf.HybridController(HEAVY, VELOCITY).first_observation(None)
    start = start.replace(elapsed=0.4, swing_foot_velocity=(1.5, -0.4, 0.0))
    command = sf.Command(
        zmp=start.support_foot, dcm_plan=start.dcm, step_location=start.swing_foot[:2],
        step_duration=0.4 + 1e-6, swing_foot=(*(start.swing_foot[:2] + 1.5e-6), 0.0),
        swing_foot_velocity=(1.5, -0.4, 0.0),
    )  # fmt: skip
    landed, _ = simulator.step(simulator.start(start), command)
    pendulum = three_mass(HEAVY)
    gain = ROBOT.gravity / pendulum.height * pendulum.foot_gain
    lost = np.array([1.5, -0.4]) * gain
    assert np.allclose(start.com_velocity - landed.com_velocity, lost, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("key", [one.key for one in methods() if not one.slow])
def test_told_what_legs_need_every_method_walks_as_a_point_mass(key: str) -> None:
    """The ZMP is moved by their share: the CoM moves as without them, to the hold of the ZMP."""
    method = next(one for one in methods() if one.key == key)
    robot = ROBOT.with_heavy_legs(known=True)
    walk = sf.simulate(method.controller(robot, (0.4, 0.0)), 4.0)
    assert not walk.fallen
    light = sf.simulate(method.controller(ROBOT, (0.4, 0.0)), 4.0)
    count = min(len(walk.time), len(light.time))
    away = walk.observations["com"][:count] - light.observations["com"][:count]
    assert np.abs(away).max() < 0.02


@pytest.mark.parametrize("velocity", [(0.5, 0.0), (0.0, 0.0), (-0.2, 0.1)])
def test_the_method_walks_with_its_zmp_at_rest(velocity: tuple[float, float]) -> None:
    """Its periodic gait, legs included, is the plant's own: nothing is left for the ZMP to do."""
    walk = sf.simulate(ThreeMassCapture(HEAVY, velocity), 12.0)
    late = walk.time > 9.0
    away = walk.commands["zmp"] - walk.observations["support_foot"]
    assert np.abs(away[late]).max() < 1e-4
    steps = walk.commands["step_location"] - walk.observations["support_foot"]
    gait = ThreeMassCapture(HEAVY, velocity).gait
    for side in sf.Side:
        mine = late & (walk.observations["support_side"] == side)
        assert np.allclose(steps[mine], gait.step(side), rtol=0, atol=1e-3)


def test_the_method_on_a_point_mass_is_of_massless_legs() -> None:
    walk = sf.simulate(ThreeMassCapture(ROBOT, (0.5, 0.0)), 4.0)
    away = walk.commands["zmp"] - walk.observations["support_foot"]
    assert np.abs(away).max() < 1e-9


def test_the_cost_is_least() -> None:
    """Against every point of a grid over the box, for random costs and bounds."""
    rng = np.random.default_rng(3)
    for _ in range(300):
        costs = tuple(rng.uniform(0.1, 5.0, 3) * (1.0, 10.0 ** rng.uniform(0, 3), 1.0))
        error, by_zmp, by_step = (
            rng.uniform(-0.5, 0.5),
            -rng.uniform(0.1, 5.0),
            -rng.uniform(0.5, 1),
        )
        low, high, half = rng.uniform(-0.4, 0.1), rng.uniform(0.15, 0.5), rng.uniform(0.01, 0.2)

        def cost(u, s, costs=costs, error=error, by_zmp=by_zmp, by_step=by_step):
            return (
                costs[0] * u**2
                + costs[1] * (error + by_zmp * u + by_step * s) ** 2
                + (costs[2] * s**2)
            )

        u, s = least_cost(costs, error, by_zmp, by_step, (low, high, half))
        assert abs(u) <= half
        assert low <= s <= high
        grid = np.meshgrid(np.linspace(-half, half, 201), np.linspace(low, high, 201))
        assert cost(u, s) <= cost(*grid).min() * (1.0 + 1e-9)


def test_flight_share_is_the_integral() -> None:
    omega, duration, away, velocity, acceleration = 3.2, 0.4, 0.3, -0.5, 2.0
    count = 20000
    middle = (np.arange(count) + 0.5) * duration / count
    total = sum(
        math.exp(omega * (duration - at))
        * quintic.py_func(0.0, velocity, acceleration, away, 0.0, duration, at)[2]
        for at in middle
    )
    share = flight_share.py_func(omega, duration, away, velocity, acceleration)
    assert share == pytest.approx(omega * total * duration / count, rel=1e-7)


def test_scaled_robots_walk_alike() -> None:
    """Dynamic similarity: half the length and a third of the mass."""
    small = HEAVY.replace(body=None).scaled(length=0.5, mass=1.0 / 3.0)
    own, other = three_mass(HEAVY), three_mass(small)
    assert other.height == pytest.approx(0.5 * own.height)
    assert other.foot_gain == pytest.approx(0.5 * own.foot_gain)


def test_a_robot_without_legs_says_what_to_give() -> None:
    with pytest.raises(sf.RobotError, match=r"\[legs\]"):
        ROBOT.replace(legs=None).with_heavy_legs()
    with pytest.raises(sf.RobotError, match="ONE leg"):
        ROBOT.replace(mass=30.0).with_heavy_legs()
    with pytest.raises(sf.RobotError, match="`com` of the legs"):
        dataclass_with(ROBOT.legs, com=1.2)


def test_the_command_line_moves_heavy_legs() -> None:
    command = ["walk", "--simulator", "three-mass", "--duration", "2", "--json"]
    walks = []
    for options in ([], ["--legs-unknown"]):
        done = CliRunner().invoke(main, [*command, "--controller", "tracking", *options])
        assert done.exit_code == 0, done.output
        walks.append(json.loads(done.stdout))
    assert walks[0]["largest_dcm_error"] < walks[1]["largest_dcm_error"]
    done = CliRunner().invoke(main, ["walk", "--legs-unknown"])
    assert done.exit_code == 2
    assert "--simulator three-mass" in done.stderr


def test_who_walks_on_has_recovered() -> None:
    """16 / omega and 8 steps after the push, not sooner; in a batch as alone."""
    robot, after = ROBOT.with_heavy_legs(known=True), 16.0 / ROBOT.omega
    controller = sf.UnifiedController(robot, (0.4, 0.0))
    walk = sf.simulate(controller, PUSH.end + after - 0.1, [PUSH])
    assert walk.outcome is sf.Outcome.UNSETTLED
    assert sf.simulate(controller, PUSH.end + after + 0.1, [PUSH]).outcome is sf.Outcome.RECOVERED
    (result,) = sf.simulate_batch(controller, [[PUSH]], 9.0, stop_when_settled=True)
    assert result["settled"]
    assert result["recovery_time"] >= after
    assert result["recovery_steps"] >= 8

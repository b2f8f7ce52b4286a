"""The unified controller: up to the limit, gentle below it, and what it says of itself is true."""

from __future__ import annotations

import math

import numpy as np
import pytest

import surefoot as sf
from surefoot.conformance import closed_loop
from surefoot.control.push_observer import SMOOTHINGS
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.worlds.point.batch import simulate_batch

ROBOT = sf.load_robot("paper-biped").replace(mass=70.0)
PUSHED_STEP = 2

Case = tuple[float, float, bool, float, float, float, float]

CASES: list[Case] = [
    # leg speed, hip, ankle, duration, phase, direction [deg], v_x
    (3.0, 0.2, True, 0.2, 0.0, 0.0, 0.5),
    (3.0, 0.2, True, 0.2, 0.25, 90.0, 0.5),
    (3.0, 0.2, True, 0.5, 0.75, 270.0, 0.5),
    (3.0, 0.2, False, 0.2, 0.5, 180.0, 0.5),
    (3.0, 0.1, True, 0.005, 0.875, 315.0, 0.5),
    (2.0, 0.2, True, 0.5, 0.25, 0.0, 0.5),
    (2.0, 0.1, False, 0.05, 0.875, 45.0, 0.5),
    (2.0, 0.2, False, 0.05, 0.5, 135.0, -0.3),
    (4.0, 0.2, True, 0.3, 0.375, 225.0, 0.8),
    (4.0, 0.1, False, 0.1, 0.625, 90.0, 0.0),
    (6.0, 0.1, True, 0.1, 0.375, 45.0, 0.8),
    (6.0, 0.2, True, 0.3, 0.125, 180.0, -0.3),
]
"""Of the matrix of all combinations; docs/unified.md has a larger sample of it."""

ACCELERATIONS = [
    # leg speed, its acceleration, hip, ankle, duration, phase, direction [deg], v_x, share
    (3.0, 60.0, 0.2, True, 0.2, 0.25, 0.0, 0.5, 0.97),
    (3.0, 30.0, 0.2, True, 0.2, 0.5, 180.0, 0.5, 0.94),
    (3.0, 120.0, 0.1, True, 0.3, 0.75, 90.0, 0.0, 0.97),
    (4.0, 60.0, 0.2, True, 0.1, 0.125, 270.0, 0.5, 0.97),
]
"""In the second the foot flies the wrong way: best would be to land in the cycle of the push."""


def settles(speed, acceleration, hip, ankle, duration, phase, angle, v_x, shares) -> np.ndarray:
    """Whether it survives each share of the limit of a situation."""
    robot = ROBOT.replace(hip=hip).with_leg(max_speed=speed, max_acceleration=acceleration)
    controller = sf.UnifiedController(robot, (v_x, 0.0), ankle=ankle)
    step = controller.gait.step_duration
    radians = math.radians(angle)
    direction = (round(math.cos(radians), 12), round(math.sin(radians), 12))
    limit = sf.push_limit(
        robot,
        direction,
        velocity=(v_x, 0.0),
        elapsed=phase * step,
        duration=duration,
        zmp_reach=robot.foot.half if ankle else (0.0, 0.0),
    ).impulse
    start = (PUSHED_STEP + phase) * step
    pushes = [
        [sf.Push.of_impulse(share * limit, direction, start=start, duration=duration)]
        for share in shares
    ]
    end = start + duration + 8.0
    return simulate_batch(controller, pushes, end, stop_when_settled=True)["settled"]


@pytest.mark.parametrize("case", CASES)
def test_it_survives_98_percent_of_the_limit(case: Case) -> None:
    """And every smaller push of a scan in steps of 2 %: no holes. Nobody survives 102 %."""
    speed, *rest = case
    shares = [*np.arange(0.0, 0.98, 0.02), 0.98, 1.02]
    settled = settles(speed, math.inf, *rest, shares)
    assert settled[:-1].all(), np.array(shares)[~settled]
    assert not settled[-1]


@pytest.mark.parametrize("case", ACCELERATIONS)
def test_it_knows_that_a_leg_has_to_accelerate(case) -> None:
    *situation, share = case
    shares = [*np.arange(0.0, share, 0.03), share, 1.03]
    settled = settles(*situation, shares)
    assert settled[:-1].all(), np.array(shares)[~settled]
    assert not settled[-1]


def test_a_leg_of_very_large_acceleration_is_one_without_that_limit() -> None:
    push = sf.Push(1.1, 0.2, (350.0, 80.0))
    free, fast = (
        sf.simulate(
            sf.UnifiedController(ROBOT.with_leg(max_speed=3.0, max_acceleration=limit), (0.5, 0.0)),
            4.0,
            [push],
        )
        for limit in (math.inf, 1e7)
    )
    for one, other in zip(free.footsteps, fast.footsteps, strict=True):
        assert one.step == pytest.approx(other.step, abs=2e-3)
        assert one.duration == pytest.approx(other.duration, abs=2e-3)


def walk(controller: sf.UnifiedController, cycles: int, pushes=(), **how):
    """Observations, decisions and commands of a closed loop."""
    begin = controller.first_observation()
    for true, command, state in closed_loop(controller, begin, cycles, pushes, **how):
        yield true, controller.decision(state), command


@pytest.fixture(scope="module")
def slow_leg() -> sf.Robot:
    return ROBOT.with_leg(max_speed=3.0)


@pytest.mark.parametrize("ankle", [True, False])
def test_undisturbed_no_limit_is_active(slow_leg: sf.Robot, ankle: bool) -> None:
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0), ankle=ankle)
    for _, decision, command in walk(controller, 1500):
        assert decision.active is sf.Limit.NONE
        assert decision.share == 1.0
        assert decision.iterations == 1
        assert decision.force.tolist() == [0.0, 0.0]
        assert command.mode is sf.Mode.TRACKING


@pytest.mark.parametrize(
    ("ankle", "acceleration"), [(True, math.inf), (False, math.inf), (True, 30.0), (False, 120.0)]
)
def test_the_margin_is_that_of_the_tables(slow_leg: sf.Robot, ankle: bool, acceleration) -> None:
    """The least room to a bound of the viable set, from the same tables by another search."""
    slow_leg = slow_leg.with_leg(max_acceleration=acceleration)
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0), ankle=ankle)
    tables, half = viable_displacement(slow_leg), slow_leg.foot.half if ankle else (0.0, 0.0)
    pushes = [sf.Push(0.6, 0.2, (250.0, -60.0))]
    for observation, decision, command in walk(controller, 1400, pushes):
        # The last moments of a step are committed to it, which the tables do not know.
        if observation.elapsed > command.step_duration - 0.02 or observation.elapsed > 0.19:
            continue
        rooms = []
        for axis in range(2):
            side = int(observation.support_side) if axis == 1 else 1
            foot = side * (observation.swing_foot[axis] - observation.support_foot[axis])
            offset = side * (observation.dcm[axis] - observation.support_foot[axis])
            speed = float(side * observation.swing_foot_velocity[axis])
            for sign in (1, -1):
                saved = tables.in_step(axis, sign, float(foot), observation.elapsed, speed)
                rooms.append(saved + half[axis] - sign * offset)
        assert decision.margin == pytest.approx(min(rooms), abs=1e-5)


def test_the_margin_falls_with_a_push_and_comes_back(slow_leg: sf.Robot) -> None:
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0))
    margins = np.array(
        [d.margin for _, d, _ in walk(controller, 6000, [sf.Push(1.0, 0.2, (550.0, 0.0))])]
    )
    quiet, hit = margins[400:1000].min(), margins[1000:1500].min()
    assert 0.0 < hit < 0.3 * quiet
    assert margins[-1000:].min() == pytest.approx(quiet, abs=1e-3)


def test_a_push_beyond_the_limit_is_called_lost_before_the_fall(slow_leg: sf.Robot) -> None:
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0))
    cycles = list(walk(controller, 1300, [sf.Push(1.0, 0.2, (750.0, 0.0))]))
    lost = next(i for i, (_, decision, _) in enumerate(cycles) if decision.margin < 0.0)
    observation, decision, _ = cycles[lost]
    assert observation.time < 1.25
    assert np.hypot(*(observation.dcm - observation.support_foot)) < 0.8
    assert sf.Limit.RESERVE in decision.active
    later = [d.active for _, d, _ in cycles[lost:]]
    assert any(sf.Limit.LOST in active for active in later)
    assert any(sf.Limit.ZMP_X in active for active in later)


@pytest.mark.parametrize("force", [(60.0, 0.0), (-200.0, 35.0)])
def test_a_push_is_seen_in_the_cycle_after_it_begins(slow_leg: sf.Robot, force) -> None:
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0))
    expected = np.array(force) / (slow_leg.mass * slow_leg.omega**2)
    for observation, decision, _ in walk(controller, 1000, [sf.Push(0.7, 0.1, force)]):
        if 0.7015 < observation.time < 0.7995:
            assert decision.force == pytest.approx(expected, abs=1e-9)
        elif observation.time < 0.7005:
            assert decision.force == pytest.approx((0.0, 0.0), abs=1e-9)
        elif observation.time > 0.8 + 10.0 * SMOOTHINGS[1]:
            assert decision.force == pytest.approx((0.0, 0.0), abs=1e-4 * np.abs(expected).max())


@pytest.mark.parametrize("noise", [0.001, 0.005])
def test_noise_alone_moves_no_landing(slow_leg: sf.Robot, noise: float) -> None:
    """300 times the noise of the DCM is in the push of one cycle; the observer knows it for what
    it is."""
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0))
    rollout = sf.simulate(controller, 5.0, disturbance=sf.Disturbance(dcm_noise=noise))
    assert not rollout.fallen
    for step in rollout.footsteps:
        assert step.duration == pytest.approx(controller.gait.step_duration, abs=2e-3)
        assert step.step == pytest.approx(controller.gait.step(step.side), abs=4.0 * noise)


@pytest.mark.parametrize(
    ("disturbance", "share"),
    [
        (sf.Disturbance(dcm_noise=0.001), 0.95),
        (sf.Disturbance(dcm_noise=0.005), 0.9),
        (sf.Disturbance(delay=0.005), 0.92),
        (sf.Disturbance(landing_error=0.01), 0.9),
    ],
)
def test_what_noise_and_delay_leave_of_the_limit(slow_leg: sf.Robot, disturbance, share) -> None:
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0))
    for direction in ((1.0, 0.0), (0.0, 1.0)):
        limit = sf.push_limit(
            slow_leg, direction, elapsed=0.1, duration=0.2, zmp_reach=slow_leg.foot.half
        ).impulse
        force = share * limit / 0.2
        push = sf.Push(1.1, 0.2, (force * direction[0], force * direction[1]))
        rollout = sf.simulate(controller, 6.0, [push], disturbance=disturbance)
        assert not rollout.fallen


@pytest.mark.parametrize(
    ("speed", "acceleration", "velocity"),
    [(0.9, math.inf, 0.5), (1.3, math.inf, 0.8), (3.0, 2.0, 0.5), (1.3, math.inf, 1.5)],
)
def test_a_leg_that_is_late_in_every_step_is_refused(speed, acceleration, velocity) -> None:
    robot = ROBOT.with_leg(max_speed=speed, max_acceleration=acceleration)
    with pytest.raises(sf.VelocityError, match=r"a leg that swings in the .* s of a step"):
        sf.UnifiedController(robot, (velocity, 0.0))


@pytest.mark.parametrize(("speed", "velocity"), [(1.3, 0.5), (1.7, 0.8), (2.0, 0.8)])
def test_a_slow_leg_that_is_accepted_walks(speed: float, velocity: float) -> None:
    controller = sf.UnifiedController(ROBOT.with_leg(max_speed=speed), (velocity, 0.0))
    assert not sf.simulate(controller, 6.0).fallen


def test_what_pushed_before_a_gap_is_forgotten(slow_leg: sf.Robot) -> None:
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0))

    def measured(cycle: int, true: sf.Observation) -> sf.Observation:
        return true.replace(dcm=(math.nan, 0.0)) if 650 <= cycle < 800 else true

    pushes = [sf.Push(0.55, 0.15, (250.0, 0.0))]
    forces = [decision.force for _, decision, _ in walk(controller, 900, pushes, measured=measured)]
    assert forces[600][0] > 0.2
    assert np.array(forces[801:]) == pytest.approx(np.zeros((99, 2)), abs=1e-9)


def test_one_bad_sample_ends_no_step(slow_leg: sf.Robot) -> None:
    """However long the control period is."""

    def measured(_: int, true: sf.Observation) -> sf.Observation:
        bad = abs(true.time - 0.4) < 1e-9
        return true.replace(dcm=true.dcm + 0.05) if bad else true

    for period in (0.001, 0.005):
        controller = sf.UnifiedController(slow_leg, (0.5, 0.0), period=period)
        *_, (last, _, _) = walk(controller, round(0.45 / period) + 1, measured=measured)
        assert last.support_side is sf.Side.RIGHT


def test_a_batch_of_one_is_the_walk(slow_leg: sf.Robot) -> None:
    controller = sf.UnifiedController(slow_leg, (0.5, 0.0))
    push = sf.Push(1.1, 0.2, (400.0, 120.0))
    rollout = sf.simulate(controller, 3.0, [push])
    one = simulate_batch(controller, [[push]], 3.0)
    assert one["final"][0].tobytes() == rollout.observations[-1].tobytes()

"""Why a body fell: every cause, forced in physics or written into a walk that knows none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

import surefoot as sf
from surefoot.rollout.fall import QUIET, find_fall
from surefoot.rollout.fall_signs import max_dcm, sole_edge

CYCLES = 2700


@pytest.fixture(scope="module")
def walk(body_control: sf.BodyControl) -> sf.Rollout:
    """A walk without trouble."""
    rollout = sf.simulate_body(body_control, 0.001 * CYCLES, estimator="truth")
    assert not rollout.fallen
    return rollout


def changed(walk: sf.Rollout, fate: int = 4, **arrays: Any) -> sf.BodyFall:
    """The cause of a fall in which the walk ended, with other arrays in its trace or commands."""
    assert walk.body is not None
    commands = walk.commands.copy()
    for name in [name for name in arrays if name in (commands.dtype.names or ())]:
        commands[name] = arrays.pop(name)
    observations = walk.observations.copy()
    for name in [name for name in arrays if name in (observations.dtype.names or ())]:
        observations[name] = arrays.pop(name)
    return find_fall(observations, commands, replace(walk.body, fate=fate, **arrays))


def last_stance(walk: sf.Rollout) -> tuple[int, int, int]:
    """First row, last row and foot of the last finished step."""
    step, last = walk.footsteps[-2:]
    rows = np.searchsorted(walk.time, [step.start, last.start])
    return int(rows[0]), int(rows[1]), 0 if step.side is sf.Side.LEFT else 1


def test_a_walk_without_trouble_has_no_sign(walk: sf.Rollout) -> None:
    fall = changed(walk)
    assert fall.cause is sf.FallCause.OUT_OF_REACH
    assert fall.time == fall.end == pytest.approx(walk.time[-1] + 0.001)
    assert walk.body_fall is None
    still = np.zeros_like(walk.body.phase)
    fall = changed(walk, phase=still, dcm=walk.support_foot)
    assert (fall.cause, fall.words) == (sf.FallCause.IN_A_STAND, "its legs did not hold it")


def test_slip(walk: sf.Rollout) -> None:
    first, last, foot = last_stance(walk)
    soles = walk.body.sole_position.copy()
    soles[first + 100 : last, foot, 0] += np.linspace(0.0, 0.06, last - first - 100)
    fall = changed(walk, sole_position=soles)
    assert fall.cause is sf.FallCause.SLIP
    assert fall.part == ("left", "right")[foot]
    assert first + 100 < 1000.0 * fall.time < last
    assert fall.evidence["way"] == pytest.approx(0.06, abs=0.01)
    assert f"the {fall.part} sole slid by 6 cm" in fall.sentence


def test_a_sole_that_rolls_over_its_edge_does_not_slip(walk: sf.Rollout) -> None:
    first, last, foot = last_stance(walk)
    soles, turn = walk.body.sole_position.copy(), walk.body.sole_turn.copy()
    soles[first + 100 : last, foot, 0] += np.linspace(0.0, 0.06, last - first - 100)
    turn[first + 60 : last, foot, 1] = 0.3
    assert changed(walk, sole_position=soles, sole_turn=turn).cause is not sf.FallCause.SLIP


@pytest.mark.parametrize(("length", "found"), [(0.12, True), (0.05, False)])
def test_torque_limit(walk: sf.Rollout, length: float, found: bool) -> None:
    torque, trace = walk.body.torque.copy(), walk.body
    motor, begin = 3, CYCLES - 500
    torque[begin : begin + round(1000 * length), motor] = trace.torque_limit[motor]
    fall = changed(walk, torque=torque)
    assert (fall.cause is sf.FallCause.TORQUE_LIMIT) == found
    if found:
        assert fall.part == trace.joints[motor]
        assert fall.time == pytest.approx(0.001 * begin, abs=0.03)
        assert fall.evidence["limit"] == trace.torque_limit[motor]


def test_a_motor_at_its_speed_gives_all_it_can_though_it_is_less(walk: sf.Rollout) -> None:
    torque, velocity = walk.body.torque.copy(), walk.body.velocity.copy()
    rows, motor = slice(CYCLES - 500, CYCLES - 300), 3
    velocity[rows, walk.body.motor_dofs[motor]] = 0.95 * walk.body.speed_limit[motor]
    torque[rows, motor] = 0.5 * walk.body.torque_limit[motor]
    fall = changed(walk, torque=torque, velocity=velocity)
    assert fall.cause is sf.FallCause.TORQUE_LIMIT


def test_leg_too_slow_by_its_own_word(walk: sf.Rollout) -> None:
    first, _, foot = last_stance(walk)
    status = walk.commands["status"].copy()
    status[first + 50 : first + 90] |= sf.Status.UNREACHABLE
    fall = changed(walk, status=status)
    assert fall.cause is sf.FallCause.LEG_TOO_SLOW
    assert fall.part == ("right", "left")[foot]
    assert fall.time == pytest.approx(0.001 * (first + 50))


def test_leg_too_slow_by_where_it_landed(walk: sf.Rollout) -> None:
    _, last, _ = last_stance(walk)
    target = walk.commands["step_location"].copy()
    target[last - 20 : last] += (0.08, 0.0)
    fall = changed(walk, step_location=target)
    assert fall.cause is sf.FallCause.LEG_TOO_SLOW
    assert fall.evidence["distance"] == pytest.approx(0.08, abs=0.03)
    assert "cm from its target" in fall.words


def test_trip(walk: sf.Rollout) -> None:
    first, _, foot = last_stance(walk)
    force = walk.body.sole_force.copy()
    force[first + 200 : first + 205, 1 - foot, 2] = 150.0
    soles, period = walk.body.sole_position.copy(), walk.time[1] - walk.time[0]
    # Fast before, slow when it touches, and stopped by that.
    swing = soles[first : first + 210, 1 - foot, 0]
    swing[:150] += np.linspace(-0.45, 0.0, 150)
    swing[190:201] = swing[190] + 0.7 * period * np.arange(11)
    swing[201:] = swing[200]
    height = soles[first + 200, 1 - foot, 2]
    fall = changed(walk, sole_force=force, sole_position=soles)
    assert fall.cause is sf.FallCause.TRIP
    assert fall.part == ("right", "left")[foot]
    assert fall.time == pytest.approx(0.001 * (first + 200))
    assert fall.evidence["speed"] == pytest.approx(0.7, abs=0.02)
    assert fall.evidence["height"] == height
    assert "m/s, the middle of its sole" in fall.words
    swing[190:201] = swing[190] + 0.2 * period * np.arange(11)
    swing[201:] = swing[200]
    fall = changed(walk, sole_force=force, sole_position=soles)
    assert fall.cause is not sf.FallCause.TRIP


def test_missed_ground(walk: sf.Rollout) -> None:
    first, last, foot = last_stance(walk)
    duration = walk.commands["step_duration"].copy()
    duration[first:last] = 0.2
    fall = changed(walk, step_duration=duration)
    assert fall.cause is sf.FallCause.MISSED_GROUND
    assert fall.part == ("right", "left")[foot]
    assert fall.time == pytest.approx(0.001 * first + 0.28, abs=0.003)


def test_crossing(walk: sf.Rollout) -> None:
    fall = changed(walk, fate=1)
    assert fall.cause is sf.FallCause.CROSSING
    assert fall.sentence == "crossing at 2.70 s: one leg met the other"


def test_out_of_reach(walk: sf.Rollout) -> None:
    first, last, _ = last_stance(walk)
    dcm = walk.dcm.copy()
    dcm[first + 100 :] += (0.9, 0.0)
    fall = changed(walk, dcm=dcm)
    assert fall.cause is sf.FallCause.OUT_OF_REACH
    assert fall.time == pytest.approx(0.001 * (first + 100), abs=0.3)
    assert first < 1000.0 * fall.time <= last
    assert fall.evidence["beyond"] > 0.0


@pytest.mark.parametrize("edge", [0.005, 0.05])
@pytest.mark.parametrize("most", [-0.2, -0.05, 0.02, 0.06, 0.4])
@pytest.mark.parametrize(("soon", "late"), [(0.0, 0.3), (0.1, 0.45), (0.0, 0.0)])
def test_the_furthest_dcm_is_that_which_some_landing_catches(
    most: float, edge: float, soon: float, late: float
) -> None:
    times = np.linspace(soon, late, 31)
    dcm = np.linspace(-0.3, 0.5, 4001)
    # The ZMP at the edge of the sole pushes back as hard as it can.
    lands_at = edge + (dcm[:, None] - edge) * np.exp(3.5 * times)
    saved = dcm[(lands_at <= most + 1e-12).any(axis=1)].max()
    parts = (np.exp(-3.5 * np.array([soon])), np.exp(-3.5 * np.array([late])))
    assert max_dcm(np.array([most]), np.array([edge]), parts) == pytest.approx(saved, abs=2.1e-4)


def test_the_zmp_may_go_to_the_edge_of_the_real_sole(walk: sf.Rollout) -> None:
    trace = walk.body
    assert trace is not None
    assert sole_edge(trace) == pytest.approx([0.1, trace.believed.foot.width / 2])
    assert trace.robot.body is not None
    able = msgspec.structs.replace(trace.robot.body, ankle_roll="actuated")
    pushes = replace(trace, robot=trace.robot.replace(body=able))
    assert sole_edge(pushes) == pytest.approx([0.1, 0.055])


def test_a_stand_that_is_pushed_over(body_control: sf.BodyControl) -> None:
    push = sf.Push(0.1, 0.15, (0.0, 2000.0))
    rollout = sf.simulate_body(
        body_control, 2.0, [push], steering=[(0.0, sf.Steering(standing=True))], estimator="truth"
    )
    fall = rollout.body_fall
    assert fall is not None
    assert fall.cause is sf.FallCause.IN_A_STAND
    assert 0.1 < fall.time < fall.end
    assert "the DCM left the feet, by" in fall.sentence
    before = rollout.time < fall.time - 1e-9
    assert np.abs(rollout.dcm[before]).max() < 0.5 * rollout.robot.hip + 0.1


def test_what_came_first_is_the_cause_unless_it_was_long_before(walk: sf.Rollout) -> None:
    first, _, _ = last_stance(walk)
    status = walk.commands["status"].copy()
    status[first + 50 : first + 90] |= sf.Status.UNREACHABLE
    torque = walk.body.torque.copy()
    torque[-150:, 3] = walk.body.torque_limit[3]
    assert changed(walk, status=status, torque=torque).cause is sf.FallCause.LEG_TOO_SLOW
    early = round(1000 * (walk.time[-1] - 0.15 - QUIET / walk.robot.omega)) - 300
    row = next(r for r in range(early, 0, -1) if walk.body.walking[r])
    status[:] = 0
    status[row - 60 : row] |= sf.Status.UNREACHABLE
    assert changed(walk, status=status, torque=torque).cause is sf.FallCause.TORQUE_LIMIT


def rollout_of(
    body_control: sf.BodyControl, change: Callable[[sf.Robot], sf.Robot], **arguments: Any
) -> sf.Rollout:
    multibody = sf.load_multibody(change(body_control.multibody.robot))
    controller = sf.body_controller("unified", sf.walking_robot(multibody), (0.3, 0.0))
    control = sf.body_control(controller, multibody)
    return sf.simulate_body(control, 5.0, estimator="truth", **arguments)


def test_ice_makes_it_slip(body_control: sf.BodyControl) -> None:
    ice = sf.Surroundings(friction=0.12)
    rollout = sf.simulate_body(body_control, 6.0, estimator="truth", surroundings=ice)
    assert rollout.outcome is sf.Outcome.FELL
    assert rollout.body_fall is not None
    assert rollout.body_fall.cause is sf.FallCause.SLIP
    assert "slid" in rollout.body_fall.sentence


def test_weak_knees_are_at_their_limit(body_control: sf.BodyControl) -> None:
    def weak(robot: sf.Robot) -> sf.Robot:
        body = robot.body
        assert body is not None
        torque = {**body.torque, "*_knee": 45.0}
        return robot.replace(body=msgspec.structs.replace(body, torque=torque))

    rollout = rollout_of(body_control, weak)
    assert rollout.body_fall is not None
    assert rollout.body_fall.cause is sf.FallCause.TORQUE_LIMIT
    assert rollout.body_fall.part.endswith("knee")


def test_a_push_that_nobody_survives(body_control: sf.BodyControl) -> None:
    push = sf.Push(2.0, 0.1, (0.0, 2000.0))
    rollout = sf.simulate_body(body_control, 5.0, [push], estimator="truth")
    assert rollout.outcome is sf.Outcome.FELL
    fall = rollout.body_fall
    assert fall is not None
    assert 2.0 <= fall.time <= fall.end < 3.5
    assert rollout.time[-1] == pytest.approx(fall.end - 0.001)

"""Walking a body: left is right, speed and heading are held, turning and standing."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest

import surefoot as sf
from surefoot.geometry import rotated
from surefoot.record import new_array
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.controller import BodyControl
from surefoot.worlds.body.course import Course, CourseController
from surefoot.worlds.body.course import VelocityCorrection as Correction
from surefoot.worlds.body.inverse_dynamics import InverseDynamics
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.step import BODY_LIMITS, BODY_WALK, STAND, WALK, keep_apart
from surefoot.worlds.steering import Steering

COURSE = CourseController(0.5, 0.15, 0.03)
"""Of `BodyControl` by default."""


def control_of(
    multibody: Multibody, velocity: tuple[float, float], side: sf.Side = sf.Side.RIGHT
) -> BodyControl:
    controller = sf.body_controller("unified", sf.walking_robot(multibody), velocity)
    return BodyControl(controller, multibody, InverseDynamics(multibody), first_support=side)


def walk(
    control: BodyControl, seconds: float, steering: Steering, push: sf.Push | None = None
) -> tuple[np.ndarray, BodyPlant]:
    """CoM, heading and phase of every cycle, with the truth for an estimate."""
    plant = BodyPlant(control.multibody, pushes=[push] if push else [])
    state, rows = control.start(), []
    for _ in range(round(seconds * 1000)):
        command, state = control.step(
            state, plant.time, plant.position, plant.velocity, plant.foot_force, steering
        )
        plant.act(command)
        assert plant.state() == STAND
        now = state.walk[0]
        rows.append([*control.mechanics.com, float(now["heading"]), float(now["phase"])])
    return np.array(rows), plant


def test_left_is_right(multibody: Multibody) -> None:
    push = sf.Push(2.0, 0.2, (30.0, 60.0))
    mirror = sf.Push(2.0, 0.2, (30.0, -60.0))
    left, _ = walk(control_of(multibody, (0.2, 0.05)), 3.0, Steering((0.2, 0.05)), push)
    control = control_of(multibody, (0.2, -0.05), sf.Side.LEFT)
    right, _ = walk(control, 3.0, Steering((0.2, -0.05)), mirror)
    # Rounding differs, and a walk grows it: e^(omega T) a step.
    assert right[:, [0, 2]] == pytest.approx(left[:, [0, 2]], abs=1e-6)
    assert right[:, 1] == pytest.approx(-left[:, 1], abs=1e-6)


@pytest.mark.parametrize("support", [0, 1])
@pytest.mark.parametrize(("speed", "start"), [(1.0, 0.2), (3.0, 0.5), (0.5, 0.02), (-1.0, 0.02)])
def test_a_foot_that_swings_inward_stops_before_its_fellow(
    support: int, speed: float, start: float
) -> None:
    limits, walk = new_array(BODY_LIMITS), new_array(BODY_WALK)
    limits["min_distance"], limits["braking"], limits["period"] = 0.15, 40.0, 0.001
    walk["support"] = support
    side, stance = (1.0 if support == 1 else -1.0), 0.3
    place = np.array([0.1, stance + side * (0.15 + start)])
    velocity = np.array([2.0, -side * speed])
    fastest = 0.0
    for _ in range(500):
        before, acceleration = velocity[1], np.array([5.0, 0.0])
        place += 0.001 * velocity
        keep_apart(limits[0], walk[0], stance, place, velocity, acceleration)
        fastest = max(fastest, abs(velocity[1] - before) / 0.001)
        assert velocity[0] == 2.0
        assert acceleration[0] == 5.0
        if speed < 0.0:
            assert velocity[1] == -side * speed
    room = side * (place[1] - stance) - 0.15
    # What is left of the way to the wall within a cycle, when the wall is seen at last.
    assert room > (-2e-3 if start > 0.1 else -5e-3)
    assert abs(velocity[1]) < 0.1 or speed < 0.0
    assert fastest < 50.0 or start < 0.1


def test_a_wide_walk_keeps_the_places_of_the_soles(robot: sf.Robot) -> None:
    body = robot.body
    assert body is not None
    wide = msgspec.structs.replace(body, step_width=0.28, gait=None)
    narrow = msgspec.structs.replace(body, gait=None)
    walkers = [
        sf.walking_robot(sf.load_multibody(robot.replace(body=one))) for one in (wide, narrow)
    ]
    assert [one.hip for one in walkers] == [0.28, robot.hip]
    for end in range(2):
        places = [one.hip + one.gait.step_y[end] for one in walkers]
        assert places[0] == pytest.approx(places[1])
    with pytest.raises(sf.RobotError, match="`step_width` of the body to be positive"):
        msgspec.structs.replace(body, step_width=-0.1)


@pytest.mark.parametrize("velocity", [(0.3, 0.0), (-0.2, 0.0), (0.0, 0.1)])
def test_the_speed_is_held(multibody: Multibody, velocity: tuple[float, float]) -> None:
    rows, _ = walk(control_of(multibody, velocity), 11.0, Steering(velocity))
    mean = (rows[-1, :2] - rows[6000, :2]) / (1e-3 * (len(rows) - 1 - 6000))
    # Over five seconds: 5 % of the speed, and what a step of the sway is worth. What the start has
    # cost is made up for before, at most 0.03 m/s faster with every second.
    assert mean == pytest.approx(velocity, abs=0.05 * math.hypot(*velocity) + 0.012)
    assert abs(rows[-1, 3]) < math.radians(2.0)


def test_it_turns_at_the_rate_that_is_asked(multibody: Multibody) -> None:
    rows, _ = walk(control_of(multibody, (0.2, 0.0)), 8.0, Steering((0.2, 0.0), turning=0.3))
    rate = (rows[-1, 3] - rows[3000, 3]) / (1e-3 * (len(rows) - 1 - 3000))
    assert rate == pytest.approx(0.3, rel=0.1)


def test_a_body_that_is_to_stand_stands(multibody: Multibody) -> None:
    control, steering = control_of(multibody, (0.0, 0.0)), Steering(standing=True)
    rows, plant = walk(control, 2.0, steering)
    assert np.abs(rows[-1, :2]).max() < 0.02
    assert np.abs(plant.velocity).max() < 0.01


def test_steps_begin_after_a_stand(multibody: Multibody) -> None:
    phases = walk(control_of(multibody, (0.0, 0.0)), 1.5, Steering())[0][:, 4].tolist()
    assert phases[0] == STAND
    assert phases[-1] == WALK
    assert phases == sorted(phases)


def test_a_course_is_an_arc() -> None:
    turning, speed = 0.5, 0.3
    course = Course((0.0, 0.0), 0.0, 0.0)
    steering = Steering((speed, 0.0), turning)
    for time in np.arange(1, 2001) * 1e-3:
        course = course.moved(steering, float(time))
    radius, angle = speed / turning, turning * 2.0
    expected = (radius * math.sin(angle), radius * (1.0 - math.cos(angle)))
    assert course.place == pytest.approx(expected, abs=1e-6)
    assert course.heading == pytest.approx(angle)


def test_a_course_waits_and_pulls() -> None:
    course = Course((1.0, 0.0), math.pi / 2, 0.0)
    assert course.waiting_for((0.0, 0.0), 0.3).place == pytest.approx((0.3, 0.0))
    assert course.waiting_for((0.9, 0.0), 0.3) == course
    # Ahead in the world is to the right of a robot that heads to the left.
    error = course.error((0.0, 0.0), course.heading)
    assert error == pytest.approx((0.0, -1.0))
    still = replace(COURSE, max_total=1.0, max_change=10.0)
    assert still.correction(Correction(), error, 0.4, 0.0).back == pytest.approx((0.0, -0.5))
    assert replace(still, max_total=0.1).correction(Correction(), error, 0.4, 0.0).total[1] == -0.1


def held(
    off: tuple[float, float], own: tuple[float, float], turning: float, seconds: float
) -> tuple[np.ndarray, Correction]:
    """Distances from the course after each step of a robot that goes where it is told, and by
    itself at `own` in its heading; it begins `off` its course. The last correction too."""
    step, steering, correction = 0.35, Steering((0.3, 0.0), turning), Correction()
    place, course, distances = off, Course((0.0, 0.0), 1.0, 0.0), []
    for n in range(1, round(seconds / step)):
        # It is told in the heading that the step ends with, as by `BodyControl`.
        heading = course.heading + turning * step
        told = (0.3 + correction.total[0] + own[0], correction.total[1] + own[1])
        x, y = rotated(told, heading - 0.5 * turning * step)
        place = (place[0] + x * step, place[1] + y * step)
        course = course.moved(steering, n * step).waiting_for(place, 0.3)
        error = course.error(place, course.heading + turning * step)
        correction = COURSE.correction(correction, error, step, turning)
        distances.append(math.hypot(*error))
    return np.array(distances), correction


@pytest.mark.parametrize("turning", [0.0, 0.2, -1.5])
def test_a_course_learns_what_takes_the_robot_off_it(turning: float) -> None:
    """Unless it turns: then it is as far off as without learning."""
    distances, correction = held((0.0, 0.0), (-0.02, 0.04), turning, 60.0)
    assert distances.max() < math.hypot(0.02, 0.04) / COURSE.rate
    if turning == 0.0:
        assert distances[-1] < 2e-3
        assert correction.drift == pytest.approx((0.02, -0.04), abs=2e-3)
    else:
        assert correction.drift == (0.0, 0.0)


@pytest.mark.parametrize("turning", [0.0, 0.5, 1.5, -1.5])
@pytest.mark.parametrize("off", [(0.28, 0.0), (0.0, -0.2), (-0.15, 0.15)])
def test_what_a_push_took_is_made_up_for(off: tuple[float, float], turning: float) -> None:
    distances, correction = held(off, (0.0, 0.0), turning, 25.0)
    assert distances[-1] < 0.01
    # Once it is back it stays: little of the way back is taken for a drift.
    back = int(np.argmax(distances < 0.02))
    assert 0 < back < 30
    assert distances[back:].max() < 0.14 * math.hypot(*off)
    assert math.hypot(*correction.drift) < 0.01


def test_the_way_back_begins_slowly() -> None:
    start = Correction((0.01, -0.02), (0.0, 0.0))
    after = COURSE.correction(start, (0.3, -0.3), 0.4, 0.0)
    assert after.drift == start.drift
    assert after.back == pytest.approx((0.4 * 0.03, -0.4 * 0.03))
    for _ in range(20):
        after = COURSE.correction(after, (0.4, -0.4), 0.4, 0.0)
    assert after.drift == start.drift
    assert after.total == pytest.approx((COURSE.max_total, -COURSE.max_total))


def test_what_could_not_be_told_teaches_nothing(multibody: Multibody) -> None:
    """At the edge of what can be walked: a part of the correction, of which the next one knows."""
    control = control_of(multibody, (0.3, 0.0))
    before, wish = (
        Correction((0.01, 0.02), (0.0, 0.0)),
        Correction((0.02, 0.05), (0.0, 0.1)),
    )
    for vy, part in ((0.0, 1.0), (0.16, 0.5), (0.2, 0.25), (0.25, 0.0)):
        steering = Steering((0.0, vy))
        controller, correction = control._towards(control.controller, before, wish, steering)
        assert correction.total == pytest.approx((part * 0.02, part * 0.15), abs=1e-12)
        assert controller.gait.velocity == pytest.approx((part * 0.02, vy + part * 0.15))
        assert correction.drift == (wish.drift if part == 1.0 else before.drift)


def test_a_hold_is_the_same_to_both_sides() -> None:
    rng = np.random.default_rng(0)
    for row in rng.normal(size=(50, 6)) * (0.1, 0.1, 0.1, 0.1, 0.3, 0.3):
        drift, back, error = row[:2], row[2:4], row[4:]
        there = COURSE.correction(Correction(tuple(drift), tuple(back)), tuple(error), 0.3, 0.0)
        here = COURSE.correction(Correction(tuple(-drift), tuple(-back)), tuple(-error), 0.3, 0.0)
        assert here.drift == tuple(-x for x in there.drift)
        assert here.back == tuple(-x for x in there.back)


@pytest.mark.parametrize("wrong", [{"turning": math.nan}, {"velocity": (0.3, math.inf)}])
def test_a_steering_that_is_no_number_is_refused(wrong: dict) -> None:
    with pytest.raises(sf.ParameterError, match=next(iter(wrong))):
        Steering(**wrong)

"""Walks that go on and on: those of `simulate` to the bit, pushed and steered on the way."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

import surefoot as sf
from surefoot.geometry import rotated_by
from surefoot.rollout.snapshot import Snapshot, snapshot_of
from surefoot.worlds.body.world import BodyWorld
from surefoot.worlds.point.world import PointWorld
from surefoot.worlds.world import World

PUSH = sf.Push(1.1, 0.2, (176.0, 30.0))
BODY_PUSH = sf.Push(1.5, 0.2, (100.0, 0.0))


@pytest.fixture(scope="module")
def controller(robot: sf.Robot) -> sf.UnifiedController:
    return sf.UnifiedController(robot, (0.3, 0.0))


@pytest.fixture
def walk(controller: sf.UnifiedController) -> PointWorld:
    return PointWorld(controller)


def go(walk: World, until: float) -> None:
    while walk.time < until - 1e-9 and not walk.fallen:
        walk.step()


def assert_same_cycles(one: sf.Rollout, other: sf.Rollout, rows: slice = slice(None)) -> None:
    """These rows of both, to the bit."""
    assert len(one.time[rows]) == len(other.time[rows])
    assert one.observations[rows].tobytes() == other.observations[rows].tobytes()
    assert one.commands[rows].tobytes() == other.commands[rows].tobytes()
    assert one.seen[rows].tobytes() == other.seen[rows].tobytes()


def test_it_is_the_walk_of_simulate(controller: sf.UnifiedController, walk: PointWorld) -> None:
    """Push and change of velocity are known beforehand there, and given on the way here."""
    changes = [(2.0, (0.5, 0.1)), (3.0, (0.0, 0.0))]
    whole = sf.simulate(controller, 4.0, [PUSH], velocity_changes=changes)
    go(walk, 0.5)
    walk.push(PUSH)
    for time, velocity in changes:
        go(walk, time)
        walk.steer(sf.Steering(velocity))
    go(walk, 4.0)
    walk.decide()
    live = walk.rollout()
    assert_same_cycles(live, whole)
    assert live.pushes == whole.pushes == (PUSH,)
    assert [to for _, to in live.velocities] == [to for _, to in whole.velocities]
    assert live.outcome is whole.outcome


def test_a_push_of_the_past_acts_from_now_on(walk: PointWorld) -> None:
    go(walk, 1.0)
    before = walk.snapshot().observation["com_velocity"].copy()
    walk.push(sf.Push(0.9, 0.15, (400.0, 0.0)))
    assert walk.snapshot().force == (400.0, 0.0)
    go(walk, 1.05)
    walk.step()
    faster = walk.snapshot().observation["com_velocity"] - before
    # 50 ms of the 150 are left; the pendulum's own acceleration is the rest.
    assert faster[0] == pytest.approx(400.0 * 0.05 / walk.robot.mass, abs=0.1)
    assert walk.snapshot().force == (0.0, 0.0)


def test_what_cannot_be_walked_leaves_it_walking(walk: PointWorld) -> None:
    go(walk, 1.0)
    with pytest.raises(sf.VelocityError):
        walk.steer(sf.Steering((3.0, 0.0)))
    assert walk.steering == sf.Steering((0.3, 0.0))
    assert walk.controller.gait.velocity == (0.3, 0.0)
    go(walk, 4.0)
    assert walk.rollout().outcome is sf.Outcome.WALKED


def test_a_stand_is_a_walk_in_place(walk: PointWorld) -> None:
    walk.steer(sf.Steering((0.3, 0.0), standing=True))
    assert walk.controller.gait.velocity == (0.0, 0.0)


def test_it_turns_by_its_rate_and_walks_on(walk: PointWorld) -> None:
    walk.steer(sf.Steering((0.3, 0.0), turning=0.3))
    go(walk, 20.0)
    rollout, turn = walk.rollout(), 0.3 * walk.controller.gait.step_duration
    begins = np.flatnonzero(np.diff(rollout.support_side)) + 1
    # A foot is set down with the heading of the step that begins then.
    headings = turn * np.arange(1, len(begins) + 1)
    assert rollout.observations["support_yaw"][begins] == pytest.approx(headings, abs=1e-9)
    assert headings[-1] == pytest.approx(0.3 * 20.0, abs=2.0 * turn)
    assert all(0.3 < step.duration < 0.8 for step in rollout.footsteps)
    assert not walk.fallen
    # It walks on as steadily as one that goes straight: in its own heading all steps are alike.
    steps = rotated_by(np.array([step.step for step in rollout.footsteps]), turn - headings)
    assert np.abs(steps[20:-2] - steps[22:]).max() < 1e-3
    assert steps[20:].mean(axis=0)[0] == pytest.approx(0.3 * turn / 0.3, abs=0.03)


def test_a_turning_walk_survives_a_push(walk: PointWorld) -> None:
    walk.steer(sf.Steering((0.3, 0.0), turning=0.5))
    walk.push(sf.Push(3.1, 0.2, (200.0, 0.0)))
    go(walk, 12.0)
    assert not walk.fallen


@pytest.mark.parametrize("key", ["unified", "hybrid"])
def test_turning_left_mirrors_turning_right(robot: sf.Robot, key: str) -> None:
    """Starting on the other foot, pushed from the other side."""
    make = {"unified": sf.UnifiedController, "hybrid": sf.HybridController}[key]
    seen = []
    for sign, first in ((1.0, sf.Side.LEFT), (-1.0, sf.Side.RIGHT)):
        walk = PointWorld(make(robot, (0.3, 0.0)), first_support=first)
        walk.steer(sf.Steering((0.3, sign * 0.1), turning=sign * 0.4))
        walk.push(sf.Push(2.3, 0.2, (100.0, sign * 80.0)))
        go(walk, 5.0)
        seen.append(walk.rollout().observations)
    left, right = seen
    for name in ("com", "dcm", "support_foot", "swing_foot"):
        assert left[name][:, 0] == pytest.approx(right[name][:, 0], abs=1e-9), name
        assert left[name][:, 1] == pytest.approx(-right[name][:, 1], abs=1e-9), name
    assert left["support_yaw"] == pytest.approx(-right["support_yaw"], abs=1e-9)
    assert (left["support_side"] == -right["support_side"]).all()


def test_only_the_end_is_retained(controller: sf.UnifiedController, walk: PointWorld) -> None:
    """With the pushes of it, and the velocity that held when it began."""
    short = PointWorld(controller, retained=1.0)
    late = sf.Push(3.5, 0.2, (50.0, 0.0))
    for one in (short, walk):
        one.push(PUSH)
        one.push(late)
        go(one, 2.0)
        one.steer(sf.Steering((0.4, 0.0)))
        go(one, 4.0)
    whole, end = walk.rollout(), short.rollout()
    assert len(end.time) == 1000
    assert end.time[0] == pytest.approx(3.0, abs=0.01)
    assert_same_cycles(end, whole, slice(-1000, None))
    assert whole.pushes == (PUSH, late)
    assert end.pushes == (late,)
    assert end.velocities == ((end.time[0], (0.4, 0.0)),)
    assert end.footsteps[-1].landing == pytest.approx(whole.footsteps[-1].landing)


def test_a_snapshot_is_a_row_of_the_walk(walk: PointWorld) -> None:
    walk.push(PUSH)
    go(walk, 1.2)
    now, later = walk.snapshot(), snapshot_of(walk.rollout(), -1)
    assert_same_snapshot(now, later)
    assert now.force == PUSH.force


def assert_same_snapshot(one: Snapshot, other: Snapshot) -> None:
    assert one.observation.tobytes() == other.observation.tobytes()
    assert one.command.tobytes() == other.command.tobytes()
    assert (one.com_height, one.force, one.both_feet) == (
        other.com_height,
        other.force,
        other.both_feet,
    )
    assert one.floor_zmp == pytest.approx(other.floor_zmp, nan_ok=True)
    assert one.soles() == pytest.approx(other.soles())


def test_nothing_is_seen_before_the_first_cycle(
    walk: PointWorld, body_control: sf.BodyControl
) -> None:
    for one in (walk, BodyWorld(body_control)):
        with pytest.raises(IndexError):
            one.snapshot()


@pytest.fixture(scope="module")
def body_walk(body_control: sf.BodyControl) -> sf.Rollout:
    """Pushed and steered as known beforehand, with usual noise."""
    steering = [(1.2, sf.Steering((0.3, 0.0), turning=0.3))]
    return sf.simulate_body(body_control, 2.4, [BODY_PUSH], steering=steering, noise=sf.BodyNoise())


def steered_body(control: sf.BodyControl, retained: float) -> BodyWorld:
    """The same, given on the way."""
    estimator = sf.BodyEstimator(control.multibody)
    walk = BodyWorld(control, noise=sf.BodyNoise(), estimator=estimator, retained=retained)
    go(walk, 1.2)
    walk.steer(sf.Steering((0.3, 0.0), turning=0.3))
    walk.push(BODY_PUSH)
    while walk.cycles < 2401:
        walk.step()
    return walk


@pytest.mark.parametrize("retained", [60.0, 0.7], ids=["all", "the end"])
def test_a_body_is_that_of_simulate_body(
    body_control: sf.BodyControl, body_walk: sf.Rollout, retained: float
) -> None:
    live = steered_body(body_control, retained).rollout()
    assert len(live.time) == min(round(1000 * retained), 2401)
    # Speeds of the feet are differences: those of a first row are one-sided.
    rows = slice(1 - min(round(1000 * retained), 2401), None)
    assert_same_cycles(live, body_walk, rows)
    # What was over before the first row that is retained is not of this rollout.
    assert live.pushes == ((BODY_PUSH,) if BODY_PUSH.end > live.time[0] else ())
    assert live.velocities[0][0] == live.time[0]
    assert live.body is not None
    assert body_walk.body is not None
    for field in [one for one in fields(live.body) if one.compare]:
        ours, theirs = getattr(live.body, field.name), getattr(body_walk.body, field.name)
        if isinstance(ours, np.ndarray) and len(ours) == len(live.time):
            assert ours[rows].tobytes() == theirs[rows].tobytes(), field.name


def test_a_snapshot_of_a_body_is_a_row_of_the_walk(body_control: sf.BodyControl) -> None:
    walk = steered_body(body_control, 0.7)
    rollout, now = walk.rollout(), walk.snapshot()
    assert_same_snapshot(now, snapshot_of(rollout, -1))
    assert now.position is not None
    assert now.position == pytest.approx(snapshot_of(rollout, -1).position)
    assert now.time == pytest.approx(2.4)


def test_a_body_cannot_be_steered_faster_than_it_walks(body_control: sf.BodyControl) -> None:
    walk = BodyWorld(body_control)
    with pytest.raises(sf.VelocityError):
        walk.steer(sf.Steering((5.0, 0.0)))
    go(walk, 0.5)
    assert walk.steering == sf.Steering((0.3, 0.0))
    assert not walk.fallen


@pytest.mark.parametrize("world", ["point", "body"])
def test_a_fork_walks_as_the_walk_itself_would(
    world: str, controller: sf.UnifiedController, body_control: sf.BodyControl
) -> None:
    """A walk pushed after it was forked is the walk that was pushed; its parent does not notice."""
    push = sf.Push(1.6, 0.2, (90.0, 20.0))

    def begin() -> World:
        if world == "point":
            return PointWorld(controller, disturbance=sf.Disturbance(dcm_noise=0.001))
        estimator = sf.BodyEstimator(body_control.multibody)
        control = body_control.fresh()
        return BodyWorld(control, noise=sf.BodyNoise(), estimator=estimator)

    whole, parent = begin(), begin()
    whole.push(push)
    go(whole, 2.2)
    go(parent, 1.6)
    fork, brief = parent.fork(), parent.fork(recorded=False)
    for one in (fork, brief):
        one.push(push)
        go(one, 2.2)
    assert parent.time == pytest.approx(1.6, abs=2e-3)
    assert parent.pushes == ()
    assert_same_cycles(fork.rollout(), whole.rollout())
    assert fork.rollout().pushes == (push,)
    with pytest.raises(IndexError):
        brief.snapshot()
    last = [
        one.command if isinstance(one, PointWorld) else one.state.command for one in (brief, whole)
    ]
    assert last[0] == last[1]
    # The parent goes on as if nobody had been pushed.
    usual = begin()
    for one in (usual, parent):
        go(one, 2.2)
    assert_same_cycles(parent.rollout(), usual.rollout())


def test_a_plan_is_given_up_for_a_command(controller: sf.UnifiedController) -> None:
    plan = [(0.5, sf.Steering((0.1, 0.0))), (1.5, sf.Steering((0.0, 0.0)))]
    walk = PointWorld(controller).prepare(plan=plan)
    walk.run(1.0)
    assert walk.steering == plan[0][1]
    walk.steer(sf.Steering((0.2, 0.0)))
    walk.run(2.0)
    assert walk.steering == sf.Steering((0.2, 0.0))


def test_a_watch_is_called_once_for_every_row(controller: sf.UnifiedController) -> None:
    watched: list[sf.Command] = []
    walk = sf.simulate(controller, 0.8, watch=lambda world: watched.append(world.command))
    assert [one.array.tobytes() for one in watched] == [row.tobytes() for row in walk.commands]

"""A walk in real time without its page: what it is told to do, and what it says of it."""

from __future__ import annotations

import math
import random
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace

import pytest

import surefoot as sf
from surefoot.cli.live import make_walk
from surefoot.live.replay import scenes_of
from surefoot.live.run import REMEMBERED, SAMPLING, Choice, LiveRun
from surefoot.worlds.world import World

FORWARD, LEFT = 0.0, 0.5 * math.pi
WALKING = "Walking: 0.3 m/s forward, a step every 0.50 s."


def run_of(**choice: str) -> LiveRun:
    run = LiveRun(make_walk, Choice(**choice), sf.Steering((0.3, 0.0)))
    run.advance(2.0)
    return run


@pytest.fixture
def run() -> LiveRun:
    return run_of()


def said(run: LiveRun, seconds: float) -> list[str]:
    """Every new sentence of a time, as a page would show them."""
    sentences = [run.sentence()]
    for _ in range(round(seconds / 0.02)):
        run.advance(0.02)
        if run.sentence() != sentences[-1]:
            sentences.append(run.sentence())
    return sentences


def test_it_says_how_it_walks(run: LiveRun) -> None:
    assert run.sentence() == WALKING
    run.steer(sf.Steering((0.5, 0.1)))
    run.advance(1.0)
    assert run.sentence().startswith("Walking: 0.5 m/s forward, 0.1 m/s left")


def test_a_push_is_told_from_its_start_to_its_end(run: LiveRun) -> None:
    run.push(FORWARD, 40.0)
    story = said(run, 4.0)
    push = "Pushed 40 N s forward (0.59 m/s)"
    assert story[0] == f"{push}."
    assert story[1].startswith(f"{push}: landing ")
    assert all(words.startswith(push) for words in story)
    planned = [words for words in story if ": landing" in words]
    landed = [words for words in story if ": landed" in words]
    assert planned[-1].endswith("m further forward.")
    assert landed[0].endswith("m further forward.")
    assert story == [story[0], *planned, *landed]
    assert landed[-1].endswith("; back in its gait after 1 more step.")


def test_what_it_says_of_the_landing_is_true(run: LiveRun) -> None:
    """The words of a moment against the plans before the push and at that moment."""
    before = run.walk.snapshot().command["step_location"].copy()
    run.push(FORWARD, 40.0)
    run.advance(0.2)
    after = run.walk.snapshot().command["step_location"]
    assert after[0] - before[0] > 0.1
    assert f"{math.dist(before, after):.2f} m further forward" in run.sentence()


@pytest.mark.parametrize(
    ("direction", "impulse", "towards", "further"),
    [
        (0.5 * math.pi, 20.0, "left", "left"),
        (-0.5 * math.pi, 20.0, "right", "right"),
        (math.pi, 40.0, "backward", "backward"),
    ],
)
def test_directions_are_the_robots_own(
    run: LiveRun, direction: float, impulse: float, towards: str, further: str
) -> None:
    """Whichever foot stands, and wherever north is."""
    run.steer(sf.Steering((0.3, 0.0), turning=0.5))
    run.advance(5.0)
    yaw = float(run.walk.snapshot().observation["support_yaw"])
    assert yaw > 1.0
    run.push(direction, impulse)
    story = said(run, 0.1)
    x, y = run.walk.snapshot().force
    assert math.remainder(math.atan2(y, x) - yaw - direction, math.tau) == pytest.approx(0.0)
    story += said(run, 1.5)
    assert f"Pushed {impulse:.0f} N s {towards} (" in story[0]
    assert any(f"m further {further}" in words for words in story)
    assert f"Pushed {impulse:.0f} N s {towards} (" in scenes_of(run.rollout()).sentences[-1]


def test_a_ghost_is_pushed_too_and_its_fall_is_told() -> None:
    run = run_of(ghost="tracking")
    run.push(FORWARD, 40.0)
    assert said(run, 4.0)[-1].endswith("back in its gait after 1 more step. "
                                       "The ghost (tracking) has fallen.")  # fmt: skip
    assert run.ghost is not None
    assert run.ghost.fallen
    assert not run.walk.fallen
    assert run.ghost.snapshot().time < run.walk.time
    pushes = [walk.rollout().pushes for walk in (run.walk, run.ghost)]
    assert pushes[0] == pushes[1] != ()


def test_a_fall_is_told_with_its_reason_and_a_reset_walks_again() -> None:
    run = run_of(controller="tracking")
    run.push(FORWARD, 40.0)
    story = said(run, 3.0)
    assert run.walk.fallen
    for words in (story[-1], scenes_of(run.rollout()).sentences[-1]):
        assert "It fell. Fell forward at" in words
        assert "Its controller did not move its steps." in words
    time = run.walk.time
    run.push(FORWARD, 40.0)
    run.advance(1.0)
    assert run.walk.time == time
    run.reset()
    run.advance(1.0)
    assert run.sentence() == WALKING
    assert run.generation == 2
    assert run.walk.rollout().pushes == ()


def test_what_it_cannot_walk_it_says_and_walks_on(run: LiveRun) -> None:
    run.steer(sf.Steering((3.0, 0.0)))
    assert "expected at most" in run.notice
    assert "got 3 m/s" in run.notice
    assert run.steering == run.walk.steering == sf.Steering((0.3, 0.0))
    run.advance(2.0)
    assert run.sentence() == WALKING
    run.steer(sf.Steering((0.4, 0.0)))
    assert run.notice == ""


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"controller": "nothing"}, "got 'nothing'"),
        ({"ghost": "nothing"}, "got 'nothing'"),
        ({"robot": "nobody"}, "'nobody'"),
    ],
)
def test_who_cannot_walk_leaves_the_old_one_walking(
    run: LiveRun, change: dict[str, str], why: str
) -> None:
    walk, choice = run.walk, run.choice
    run.choose(replace(choice, **change))
    assert why in run.notice
    assert run.walk is walk
    assert run.choice == choice
    run.advance(1.0)
    assert run.walk.time == pytest.approx(3.0, abs=0.01)


def test_one_that_is_too_slow_for_it_begins_in_place(run: LiveRun) -> None:
    run.steer(sf.Steering((2.0, 0.0)))
    assert run.notice == ""
    run.choose(Choice(robot="g1"))
    assert run.notice.startswith("walks in place: expected ")
    assert run.choice.robot == "g1"
    assert run.steering == sf.Steering()


def test_a_single_period_is_one_cycle(run: LiveRun) -> None:
    period, cycles = run.walk.controller.period, len(run.rollout().time)
    for count in range(1, 20):
        run.advance(period)
        assert len(run.rollout().time) == cycles + count


def test_samples_are_those_of_the_last_seconds(run: LiveRun) -> None:
    run.advance(8.0)
    times = [sample.time for sample in run.samples]
    assert times[-1] - times[0] == pytest.approx(REMEMBERED, abs=2.0 * SAMPLING)
    assert all(abs(sample.zmp[0]) <= 0.1 + 1e-9 for sample in run.samples)
    assert all(sample.decision_time > 0.0 for sample in run.samples)


@pytest.fixture
def restless() -> Iterator[None]:
    """Threads take turns as often as they can."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(interval)


@pytest.mark.usefixtures("restless")
def test_requests_come_from_any_thread() -> None:
    """Four tabs push and steer while time passes: both walks are told the same, in order."""
    run, errors = run_of(ghost="hybrid"), []

    def tab(seed: int) -> None:
        rng = random.Random(seed)
        try:
            for _ in range(100):
                run.push(rng.uniform(-math.pi, math.pi), rng.uniform(0.0, 0.1))
                run.steer(sf.Steering((rng.uniform(0.2, 0.4), 0.0), rng.uniform(-0.4, 0.4)))
                run.sentence(), run.view(), list(run.samples)
        except BaseException as error:
            errors.append(error)

    tabs = [threading.Thread(target=tab, args=(seed,)) for seed in range(4)]
    for one in tabs:
        one.start()
    while any(one.is_alive() for one in tabs):
        run.advance(0.01)
    assert errors == []
    assert run.ghost is not None
    ours, theirs = run.walk.rollout().pushes, run.ghost.rollout().pushes
    # One push at a time: most of those that came at once are refused.
    assert 1 <= len(ours) < 400
    assert ours == theirs
    assert run.walk.steering == run.ghost.steering == run.steering
    run.reset()
    run.advance(0.5)
    assert run.sentence().startswith("Walking: ")


def test_a_ghost_that_survives_walks_on_alone() -> None:
    run = run_of(controller="tracking", ghost="unified")
    run.push(FORWARD, 60.0)
    run.advance(8.0)
    assert run.walk.fallen
    assert run.ghost is not None
    assert not run.ghost.fallen
    assert run.ghost.time > 7.9
    assert "The ghost (unified) walks on." in run.sentence()


def test_a_fall_is_told_alike_at_every_heading() -> None:
    told = []
    for turning in (0.0, 0.5):
        run = run_of(controller="hybrid")
        run.steer(sf.Steering((0.3, 0.0), turning))
        run.advance(6.0)
        run.steer(sf.Steering((0.3, 0.0)))
        run.advance(4.0)
        yaw = float(run.walk.snapshot().observation["support_yaw"])
        assert (abs(yaw) > 1.0) == (turning > 0.0)
        run.push(FORWARD, 300.0)
        run.advance(6.0)
        assert run.walk.fallen
        told.append(run.sentence())
        replayed = scenes_of(run.rollout()).sentences
        assert replayed[0] == "Walking: 0.3 m/s forward, a step every 0.50 s."
        assert "Fell forward" in replayed[-1]
    assert "Fell forward" in told[0]
    assert "Fell forward" in told[1]


def test_what_a_page_sends_is_held_in_bounds(run: LiveRun) -> None:
    for pace in (math.nan, math.inf, 1e9, -1.0):
        run.pace = pace
        assert 0.0 <= run.pace <= 2.0
    run.push(FORWARD, math.nan)
    assert not run.rollout().pushes
    run.push(FORWARD, 1e9)
    run.advance(0.1)
    assert run.rollout().pushes[0].impulse[0] <= 300.0


def test_a_key_that_is_held_down_pushes_once(run: LiveRun) -> None:
    for _ in range(5):
        run.push(FORWARD, 20.0)
        run.advance(0.03)
    assert len(run.rollout().pushes) == 1
    run.advance(0.1)
    run.push(FORWARD, 20.0)
    assert len(run.rollout().pushes) == 2


def test_a_single_step_while_it_is_paused_is_a_sample(run: LiveRun) -> None:
    run.paused = True
    before = len(run.samples)
    run.advance(run.walk.controller.period)
    assert len(run.samples) == before + 1


def test_the_old_one_walks_on_while_another_is_made() -> None:
    started, ready = threading.Event(), threading.Event()

    def slowly(choice: Choice, key: str, steering: sf.Steering) -> World:
        if choice.robot == "talos":
            started.set()
            assert ready.wait(60.0)
        return make_walk(choice, key, steering)

    run = LiveRun(slowly, Choice(), sf.Steering((0.3, 0.0)))
    choosing = threading.Thread(target=run.choose, args=(Choice(robot="talos"),))
    choosing.start()
    assert started.wait(60.0)
    before = run.walk.time
    run.advance(0.2)
    run.steer(sf.Steering((0.2, 0.0)))
    assert run.walk.time > before + 0.19
    ready.set()
    choosing.join()
    assert run.walk.robot.name == "talos"
    assert run.walk.controller.gait.velocity == (0.2, 0.0)
    assert run.notice == ""

"""The decisions of a walk: found again to the bit, told in words, drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

import surefoot as sf
from invoked import numbers, refused, run
from surefoot.show.decisions import DecidedWalk, decision_figure, draw_decisions
from surefoot.show.words import LIMIT_WORDS, closest_call, margin_sentence


@pytest.fixture(scope="module")
def robot() -> sf.Robot:
    plain = sf.load_robot("paper-biped")
    return plain.replace(swing=structs.replace(plain.swing, max_speed=3.0))


@pytest.fixture(scope="module")
def controller(robot: sf.Robot) -> sf.UnifiedController:
    return sf.UnifiedController(robot, (0.5, 0.0))


def forward(impulse: float) -> sf.Push:
    return sf.Push(1.1, 0.2, (impulse / 0.2, 0.0))


@pytest.fixture(scope="module")
def hard(controller: sf.UnifiedController) -> sf.Rollout:
    """A push near the limit of 115.9 N s."""
    return sf.simulate(controller, 3.0, [forward(113.0)])


@pytest.fixture(scope="module")
def decided(controller: sf.UnifiedController, hard: sf.Rollout) -> np.ndarray:
    return sf.decisions(controller, hard)


def test_decisions_are_those_the_walk_was_commanded_with(hard: sf.Rollout, decided) -> None:
    assert decided.shape == hard.time.shape
    duration = np.log(decided["tau"]) / hard.robot.omega
    np.testing.assert_allclose(duration, hard.commands["step_duration"], atol=1e-12)
    assert (np.diff(duration) != 0.0).any()
    side = np.column_stack([np.ones(len(hard.time)), hard.support_side])
    landing = hard.support_foot + side * decided["step"]
    np.testing.assert_allclose(landing, hard.commands["step_location"], atol=1e-12)


def test_a_saved_walk_can_be_decided_again(controller, hard, decided, tmp_path: Path) -> None:
    hard.save(tmp_path / "walk.npz")
    again = sf.decisions(controller, sf.load_rollout(tmp_path / "walk.npz"))
    assert again.tobytes() == decided.tobytes()


def test_new_velocities_are_followed(controller: sf.UnifiedController) -> None:
    rollout = sf.simulate(controller, 2.0, velocity_changes=[(0.7, (0.2, 0.1)), (1.3, (0.0, 0.0))])
    assert len(sf.decisions(controller, rollout)) == len(rollout.time)


def test_what_was_seen_counts_not_what_was_true(robot, controller, tmp_path: Path) -> None:
    disturbance = sf.Disturbance(dcm_noise=0.001, delay=0.005, landing_error=0.005, seed=3)
    rollout = sf.simulate(
        controller, 1.5, [forward(30.0)], plant=robot.replace(mass=75.0), disturbance=disturbance,
        first_support=sf.Side.LEFT,
    )  # fmt: skip
    decided = sf.decisions(controller, rollout)
    rollout.save(tmp_path / "walk.npz")
    again = sf.decisions(controller, sf.load_rollout(tmp_path / "walk.npz"))
    assert again.tobytes() == decided.tobytes()


def test_another_controller_is_told_from_the_one_that_walked(robot, hard: sf.Rollout) -> None:
    with pytest.raises(sf.ParameterError, match=r"decides otherwise at 1\.1"):
        sf.decisions(sf.UnifiedController(robot, (0.5, 0.0), horizon=0.0), hard)
    with pytest.raises(sf.ParameterError, match=r"UnifiedController.*; got HybridController"):
        sf.decisions(sf.HybridController(robot, (0.5, 0.0)), hard)


def test_the_smallest_margin_is_what_the_push_left(robot, hard: sf.Rollout, decided) -> None:
    # What more of the same push would have been survived, as a displacement at its end; the limits
    # of both are known independently of the controller.
    call = closest_call(hard, decided)
    limit = sf.push_limit(robot, (1.0, 0.0), elapsed=0.1, zmp_reach=robot.foot.half).impulse
    growth = np.exp(robot.omega * 0.2)
    left = (limit - 113.0) / (0.2 * robot.mass * robot.omega**2) * (growth - 1.0)
    assert call["time"] == pytest.approx(1.3, abs=2e-3)
    assert 0.5 * left < call["margin"] <= left
    assert {"ZMP_X", "LEG_X", "RESERVE"} <= set(call["limits"])
    assert margin_sentence(call).startswith(f"smallest margin {1e3 * call['margin']:.1f} mm at 1.3")


def test_a_walk_that_is_lost_says_since_when(controller: sf.UnifiedController) -> None:
    rollout = sf.simulate(controller, 3.0, [forward(140.0)])
    assert rollout.outcome is sf.Outcome.FELL
    call = closest_call(rollout, sf.decisions(controller, rollout))
    assert -0.01 < call["margin"] < 0.0
    assert 1.1 < call["time"] < 1.3
    assert margin_sentence(call).startswith("nothing could save it from 1.2")


def test_an_undisturbed_walk_is_at_no_limit(controller: sf.UnifiedController) -> None:
    rollout = sf.simulate(controller, 1.2)
    call = closest_call(rollout, sf.decisions(controller, rollout))
    assert (call["time"], call["limits"]) == (0.0, [])
    assert margin_sentence(call).endswith("no limit was reached")


def test_every_limit_has_a_name() -> None:
    assert set(LIMIT_WORDS) == set(sf.Limit) - {sf.Limit.NONE}


def test_the_picture_draws_what_was_decided(hard: sf.Rollout, decided, tmp_path: Path) -> None:
    walks = [DecidedWalk(hard, decided, "one"), DecidedWalk(hard, decided, "two")]
    axes = decision_figure(walks).axes
    assert len(axes) == 14
    (margin,) = (line.get_ydata() for line in axes[0].lines if line.get_gid() == "margin")
    assert np.nanmin(margin) == pytest.approx(1e3 * decided["margin"].min())
    assert [ax.get_ylim() for ax in axes[:7]] == [ax.get_ylim() for ax in axes[7:]]
    draw_decisions(walks[:1], tmp_path / "a.png")
    draw_decisions(walks[:1], tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


WALK = ("walk", "--duration", "2", "--controller")


def test_walk_tells_the_smallest_margin_of_the_unified_controller(tmp_path: Path) -> None:
    pushed = ("--leg-speed", "3", "--push", "565,0@1.1+0.2")
    path = tmp_path / "decisions.png"
    words = run(*WALK, "unified", *pushed, "--plot-decisions", str(path)).output
    assert "at their limits: ZMP in x, leg in x" in words
    assert path.read_bytes().startswith(b"\x89PNG")
    told = numbers(*WALK, "unified", *pushed)
    assert told["smallest_margin"]["time"] == pytest.approx(1.3, abs=2e-3)
    assert f"smallest margin {1e3 * told['smallest_margin']['margin']:.1f} mm" in words
    assert numbers(*WALK, "hybrid")["smallest_margin"] is None


def test_decisions_of_another_method_cannot_be_drawn(tmp_path: Path) -> None:
    path = str(tmp_path / "decisions.png")
    said = refused(*WALK, "hybrid", "--plot-decisions", path)
    assert "the controller that keeps its decisions, unified" in said
    refused(*WALK, "unified", "--plot-decisions", "walk.bmp")

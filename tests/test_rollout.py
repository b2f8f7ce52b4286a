from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf

ROBOT = sf.load_robot("paper-biped")


def test_arrays_are_time_first(pushed_walk: sf.Rollout) -> None:
    n = len(pushed_walk.time)
    assert n > 6000
    for name in ("com", "com_velocity", "dcm", "dcm_plan", "dcm_error", "zmp", "support_foot"):
        assert getattr(pushed_walk, name).shape == (n, 2), name
    assert pushed_walk.swing_foot.shape == (n, 3)
    for name in ("zmp_excess", "support_side", "adapting", "decision_time"):
        assert getattr(pushed_walk, name).shape == (n,), name
    assert (np.diff(pushed_walk.time) > 0.0).all()


def test_the_dcm_is_that_of_com_and_velocity(pushed_walk: sf.Rollout) -> None:
    dcm = pushed_walk.com + pushed_walk.com_velocity / pushed_walk.robot.omega
    assert pushed_walk.dcm == pytest.approx(dcm, abs=1e-12)


def test_footsteps_fit_together(pushed_walk: sf.Rollout) -> None:
    steps = pushed_walk.footsteps
    assert [step.index for step in steps] == list(range(len(steps)))
    for one, two in pairwise(steps):
        assert two.support_foot == one.landing
        assert two.side == one.side.other
        assert two.start == pytest.approx(one.start + one.duration, abs=1e-12)
    assert [step.adapted for step in steps[:4]] == [False, False, True, False]


def test_the_excess_of_the_zmp() -> None:
    push = [sf.Push(1.1, 0.2, (142.0, 0.0))]
    free = sf.simulate(sf.DcmTracking(ROBOT, (0.5, 0.0), project_zmp=False), 3.0, push)
    kept = sf.simulate(sf.DcmTracking(ROBOT, (0.5, 0.0)), 3.0, push)
    assert kept.zmp_excess.max() == 0.0
    outside = np.abs(free.zmp - free.support_foot)[:, 0].max() - 0.1
    assert free.zmp_excess.max() == pytest.approx(outside)
    assert outside > 0.05


def test_outcomes() -> None:
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    assert sf.simulate(controller, 3.0).outcome is sf.Outcome.WALKED
    later = [sf.Push(50.0, 0.2, (300.0, 0.0))]
    assert sf.simulate(controller, 3.0, later).outcome is sf.Outcome.WALKED
    push = [sf.Push(1.1, 0.2, (300.0, 0.0))]
    assert sf.simulate(controller, 6.0, push).outcome is sf.Outcome.RECOVERED
    assert sf.simulate(controller, 1.6, push).outcome is sf.Outcome.UNSETTLED
    assert sf.simulate(controller, 0.3).outcome is sf.Outcome.UNSETTLED
    push = [sf.Push(1.1, 0.2, (1300.0, 0.0))]
    assert sf.simulate(controller, 6.0, push).outcome is sf.Outcome.FELL


@pytest.mark.parametrize(
    ("force", "limit"),
    [
        ((1300.0, 0.0), "forward"),
        ((-1500.0, 0.0), "backward"),
        ((0.0, 900.0), "left"),
        ((0.0, -900.0), "right"),
    ],
)
def test_a_fall_comes_with_its_evidence(force, limit: str) -> None:
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    rollout = sf.simulate(controller, 6.0, [sf.Push(1.1, 0.2, force)])
    fall = rollout.fall
    assert fall is not None
    assert fall.limit == limit
    assert fall.time == rollout.time[-1]
    assert fall.distance > 1.5
    assert fall.last_viable_time is not None
    assert fall.last_viable_time < fall.time
    assert fall.last_margin is not None
    assert fall.last_margin >= 0.0
    if fall.lost_time is not None:
        assert fall.lost_margin is not None
        assert fall.lost_margin < 0.0
        assert fall.last_viable_time < fall.lost_time <= fall.time


def test_no_fall_no_evidence(pushed_walk: sf.Rollout) -> None:
    assert pushed_walk.fall is None


@pytest.mark.parametrize("part", [0.0, 0.01, 0.5, 0.9, 0.999])
def test_a_file_that_was_cut_short(pushed_walk: sf.Rollout, tmp_path: Path, part: float) -> None:
    path = tmp_path / "walk.npz"
    pushed_walk.save(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(sf.FileError, match=r"a rollout that Rollout\.save wrote.*cut short"):
        sf.load_rollout(path)


def test_a_file_that_was_damaged(pushed_walk: sf.Rollout, tmp_path: Path) -> None:
    path = tmp_path / "walk.npz"
    pushed_walk.save(path)
    whole = bytearray(path.read_bytes())
    middle = len(whole) // 2
    whole[middle : middle + 64] = bytes(64)
    path.write_bytes(whole)
    with pytest.raises(sf.FileError, match="a rollout that"):
        sf.load_rollout(path)


def rewritten(source: Path, target: Path, **changes) -> Path:
    with np.load(source) as archive:
        about = json.loads(str(archive["about"])) | changes
        arrays = {name: archive[name] for name in archive.files if name != "about"}
    np.savez(target, about=np.array(json.dumps(about)), **arrays)
    return target


def test_files_of_another_kind(pushed_walk: sf.Rollout, tmp_path: Path) -> None:
    good = tmp_path / "walk.npz"
    pushed_walk.save(good)
    with pytest.raises(sf.FileError, match=r"format 1 to 4; got .* with format 99"):
        sf.load_rollout(rewritten(good, tmp_path / "new.npz", format=99))
    with pytest.raises(sf.FileError, match="a complete description"):
        sf.load_rollout(rewritten(good, tmp_path / "bad.npz", robot={"name": "none"}))
    np.savez(tmp_path / "other.npz", values=np.zeros(3))
    with pytest.raises(sf.FileError, match="a rollout that"):
        sf.load_rollout(tmp_path / "other.npz")
    with pytest.raises(sf.FileError, match="a rollout that"):
        sf.load_rollout(tmp_path / "none.npz")


def test_places_where_nothing_can_be_saved(pushed_walk: sf.Rollout, tmp_path: Path) -> None:
    with pytest.raises(sf.FileError, match=r"a path ending in \.npz"):
        pushed_walk.save(tmp_path / "walk.txt")
    with pytest.raises(sf.FileError, match="a directory that exists"):
        pushed_walk.save(tmp_path / "none" / "walk.npz")
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(sf.FileError, match="a file; got the directory"):
        pushed_walk.save(tmp_path / "folder.npz")


def test_settled_means_two_per_cent_of_the_velocity(pushed_walk: sf.Rollout) -> None:
    """The same walk, judged against commands that it misses by a little less and a little more."""
    assert sf.Outcome.RECOVERED is pushed_walk.outcome
    for factor, outcome in ((0.983, sf.Outcome.RECOVERED), (0.977, sf.Outcome.UNSETTLED)):
        velocities = ((0.0, (0.5 * factor, 0.0)),)
        assert replace(pushed_walk, velocities=velocities).outcome is outcome


@pytest.mark.parametrize("first_support", list(sf.Side))
def test_the_evidence_of_a_fall_counts_from_the_right_side(first_support: sf.Side) -> None:
    """Its margins are those of the finite foot at the touchdowns that it names."""
    controller = sf.HybridController(ROBOT, (0.5, 0.0))
    push = sf.Push(1.1, 0.2, (0.0, 900.0 * first_support))
    rollout = sf.simulate(controller, 6.0, [push], first_support=first_support)
    fall = rollout.fall
    assert fall is not None
    assert fall.last_viable_time is not None
    margins = {
        step.start + step.duration: sf.viable_offsets(ROBOT, step.side, ROBOT.foot.half).margin(
            step.dcm_offset
        )
        for step in rollout.footsteps
    }
    assert fall.last_margin == margins[fall.last_viable_time]
    undisturbed = [s for s in rollout.footsteps if s.start + s.duration < 1.1]
    # d = -0.0296 (right support): 0.0296 + 0.1635 + 0.055 from the inner bound.
    for step in undisturbed:
        assert margins[step.start + step.duration] == pytest.approx(0.2481, abs=1e-4)

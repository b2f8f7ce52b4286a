"""Playback of saved walks: scenes, sentences, and the one file to send around."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from invoked import refused, run
from surefoot.live.replay import Scenes, scenes_of
from surefoot.live.story import SAMPLING
from surefoot.rollout.snapshot import snapshot_of

PUSH = sf.Push(1.1, 0.2, (176.0, 0.0))


@pytest.fixture(scope="module")
def walk() -> sf.Rollout:
    controller = sf.UnifiedController(sf.load_robot("paper-biped"), velocity=(0.5, 0.0))
    return sf.simulate(controller, 3.0, [PUSH])


@pytest.fixture(scope="module")
def scenes(walk: sf.Rollout) -> Scenes:
    return scenes_of(walk)


@pytest.fixture
def saved(walk: sf.Rollout, tmp_path: Path) -> Path:
    path = tmp_path / "walk.npz"
    walk.save(path)
    return path


def test_scenes_go_from_the_first_cycle_to_the_last(walk: sf.Rollout, scenes: Scenes) -> None:
    assert scenes.cycles[0] == 0
    assert scenes.cycles[-1] == len(walk.time) - 1
    gaps = np.diff(walk.time[scenes.cycles])
    assert gaps.max() < SAMPLING + 2e-3
    assert len(scenes.sentences) == len(scenes.samples) == len(scenes.cycles)


def test_a_time_finds_its_scene(walk: sf.Rollout, scenes: Scenes) -> None:
    for time in (-1.0, 0.0, 0.5, 1.234, 99.0):
        scene = scenes.at(time)
        assert walk.time[scenes.cycles[scene]] <= max(time, 0.0) + 1e-9
    assert scenes.at(99.0) == len(scenes.cycles) - 1


def test_the_sentences_tell_the_push_and_what_became_of_it(scenes: Scenes) -> None:
    assert scenes.sentences[0] == "Walking: 0.5 m/s forward, a step every 0.50 s."
    during = scenes.sentences[scenes.at(1.35)]
    assert during.startswith("Pushed 35 N s forward (0.52 m/s): landing")
    assert "further forward" in during
    assert scenes.sentences[-1].endswith("back in its gait after 1 more step.")


def test_a_snapshot_is_a_row_of_the_walk(walk: sf.Rollout) -> None:
    cycle = int(np.searchsorted(walk.time, 1.2))
    snapshot = snapshot_of(walk, cycle)
    assert snapshot.time == walk.time[cycle]
    assert snapshot.force == PUSH.force
    assert np.array_equal(snapshot.observation["dcm"], walk.dcm[cycle])
    carrying = 0 if snapshot.support is sf.Side.LEFT else 1
    assert np.array_equal(snapshot.soles()[carrying, :2], walk.support_foot[cycle])


def test_one_file_plays_without_a_network(saved: Path, tmp_path: Path) -> None:
    page = tmp_path / "walk.html"
    done = run("replay", str(saved), "--html", str(page))
    assert done.exit_code == 0, done.output
    assert "MB" in done.output
    text = page.read_text(encoding="utf-8")
    assert "walk.npz: paper-biped, 0.5 m/s forward" in text
    assert "back in its gait" in text
    head = text[: text.index("srcdoc=")]
    assert not re.findall(r'(?:src|href)="?https?://', head)
    assert "__VISER_EMBED_DATA__" in text
    assert "<svg" in text


def test_what_is_missing_of_a_walk_is_told(walk: sf.Rollout, tmp_path: Path) -> None:
    log, page = tmp_path / "walk.mcap", tmp_path / "walk.html"
    walk.save(log)
    log.write_bytes(log.read_bytes()[: -log.stat().st_size // 3])
    done = run("replay", str(log), "--html", str(page))
    assert done.exit_code == 0, done.output
    assert "note:" in done.stderr
    assert page.exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["no.npz"], "no.npz"),
        (["{saved}", "--html", "walk.pdf"], "a path ending in .html"),
        (["{saved}", "--html", "nowhere/walk.html"], "nowhere"),
        (["{saved}", "--host", "203.0.113.7"], "--host with an address of this machine"),
    ],
)
def test_misuse_is_told(arguments: list[str], words: str, saved: Path) -> None:
    given = [one.format(saved=saved) for one in arguments]
    assert words in refused("replay", *given)

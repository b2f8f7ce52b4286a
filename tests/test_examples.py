"""The examples run as a newcomer runs them, and show what they promise."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import surefoot as sf

EXAMPLES = Path(__file__).parents[1] / "examples"


def run(folder: Path, name: str, *arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, EXAMPLES / name, *arguments], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize(("arguments", "picture"), [((), "walk.png"), (("mine.svg",), "mine.svg")])
def test_walk_and_push(tmp_path: Path, arguments: tuple[str, ...], picture: str) -> None:
    printed = run(tmp_path, "00_walk_and_push.py", *arguments)
    assert "pushed with 35.2 N s, 0.52 m/s, forward" in printed
    decided = re.findall(r"^ +\d+ .* (planned|online)$", printed, re.MULTILINE)
    assert decided == ["online" if step == 3 else "planned" for step in range(1, 13)]
    assert "outcome: recovered" in printed
    assert "final velocity: 0.500 m/s" in printed
    assert (tmp_path / picture).stat().st_size > 10_000


def test_step_problem(tmp_path: Path) -> None:
    before, after = run(tmp_path, "01_step_problem.py").split("shoved")
    robot = sf.load_robot("paper-biped")
    gait = sf.nominal_gait(robot, (0.5, 0.0))
    nominal = (
        "step {:+.3f} {:+.3f} m".format(*gait.step(sf.Side.RIGHT))
        + f", tau {gait.growth:.3f}, T {gait.step_duration:.3f} s, "
        + "offset {:+.4f} {:+.4f} m, OK".format(*gait.dcm_offset(sf.Side.RIGHT))
    )
    assert before.count(nominal) == len(before.splitlines()) == 4
    assert nominal not in after
    durations = [float(t) for t in re.findall(r"T ([\d.]+) s", after)]
    assert len(durations) > 1
    assert max(durations) < gait.step_duration
    assert after.endswith("landed\n")
    residuals = [float(r) for r in re.findall(r"residual (\S+)", before + after)]
    assert len(residuals) == 4 + len(durations)
    assert max(residuals) < 1e-9

"""The examples run as a newcomer runs them, print what their page shows, and obey its laws."""

from __future__ import annotations

import io
import math
import re
import runpy
import subprocess
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from itertools import pairwise
from pathlib import Path

import pytest

import surefoot as sf

ROOT = Path(__file__).parents[1]
EXAMPLES, PAGE = sorted((ROOT / "examples").glob("*.py")), ROOT / "docs" / "examples.md"
NUMBER = r"[-+]?\d+\.?\d*(?:e-?\d+)?"
ROUNDING = re.compile(r"\b\d+e-\d+\b")
"""Numbers that are rounding errors, which differ between processors."""


def blocks() -> dict[str, str]:
    """What the page shows of every example."""
    block = re.compile(r"\(\.\./examples/(\w+)\.py\)\n\n```text\n(.*?)```", re.DOTALL)
    return dict(block.findall(PAGE.read_text("utf-8")))


def numbers(pattern: str, printed: str) -> list[float]:
    """The numbers in the place of {} of a pattern; a space in it is one or more."""
    literal = re.escape(pattern).replace(r"\{\}", f"({NUMBER})").replace(r"\ ", " +")
    return [float(found) for found in re.findall(literal, printed)]


def comparable(printed: str, physics: bool) -> str:
    """What is the same on every machine: of a body in physics and of a clock, the words."""
    lines = [
        re.sub(NUMBER, "N", line) if physics or line.startswith("this machine") else line
        for line in printed.splitlines()
    ]
    return ROUNDING.sub("N", "\n".join(lines))


def walk_and_push(printed: str) -> None:
    assert "pushed with 35.2 N s, 0.52 m/s, forward" in printed
    decided = re.findall(r"^ +\d+ .* (planned|online)$", printed, re.MULTILINE)
    assert decided == ["online" if step == 3 else "planned" for step in range(1, 13)]
    assert "outcome: recovered" in printed
    assert "final velocity: 0.500 m/s" in printed


def step_problem(printed: str) -> None:
    before, after = printed.split("disturbed")
    robot = sf.load_robot("paper-biped")
    gait = sf.nominal_gait(robot, (0.5, 0.0))
    nominal = (
        "step {:+.3f} {:+.3f} m".format(*gait.step(sf.Side.RIGHT))
        + f", tau {gait.growth:.3f}, T {gait.step_duration:.3f} s, "
        + "offset {:+.4f} {:+.4f} m, OK".format(*gait.dcm_offset(sf.Side.RIGHT))
    )
    assert before.count(nominal) == len(before.splitlines()) == 4
    assert nominal not in after
    durations = numbers("T {} s", after)
    assert len(durations) > 1
    assert max(durations) < gait.step_duration
    assert after.endswith("landed\n")
    residuals = numbers("residual {}", before + after)
    assert len(residuals) == 4 + len(durations)
    assert max(residuals) < 1e-9


def own_robot(printed: str) -> None:
    assert numbers("omega = sqrt(g / h) = {} 1/s", printed) == [round(math.sqrt(9.80665 / 0.55), 3)]
    # No faster than its longest step in its shortest time.
    assert numbers("up to {} m/s", printed)[0] <= 0.35 / 0.25
    (length,), (duration,) = numbers("steps of {} m", printed), numbers("in {} s\n", printed)
    assert length / duration == pytest.approx(0.3, abs=2e-3)
    survived, failed = numbers("limit, {} N s", printed)
    assert failed / survived == pytest.approx(1.05 / 0.95, abs=2e-3)
    assert re.findall(r"N s: (\w+)", printed) == ["recovered", "fell"]


def own_controller(printed: str) -> None:
    assert printed.startswith("outcome: recovered\n")
    steps = re.findall(r"step \d: (\S+ \S+) m, compiled (\S+ \S+) m", printed)
    assert len(steps) == 5
    assert all(own == compiled for own, compiled in steps)
    left, right = "+0.250 -0.200", "+0.250 +0.200"
    assert [own for own, _ in steps] == [left, steps[1][0], left, right, left]
    # Pushed forward and to the left, the third foot lands further forward and to the left.
    forward, across = map(float, steps[1][0].split())
    assert forward > 0.3
    assert across > 0.25


def real_time_loop(printed: str) -> None:
    assert printed.startswith("2001 cycles and 4 steps in 2.0 s")
    assert printed.count(": True\n") == 2
    # Lateness does not add up: what the last cycles were late by is all.
    elapsed, decided = numbers("this machine: {} s", printed)[0], numbers("took {} us", printed)[0]
    assert elapsed >= 2.0
    assert 0.0 < decided < 1000.0


def push_study(printed: str) -> None:
    impulses, speeds = (
        numbers("at {} N s", printed),
        numbers("s, {} m/s", printed),
    )
    shares = numbers("survives {}%", printed)
    assert len(impulses) == len(speeds) == len(shares) == 12
    mass = sf.load_robot("paper-biped").mass
    assert speeds == [pytest.approx(impulse / mass, abs=6e-3) for impulse in impulses]
    fixed_times, own_times, anticipating = impulses[:4], impulses[4:8], impulses[8:]
    assert all(a < b < c for a, b, c in zip(fixed_times, own_times, anticipating, strict=True))
    assert max(shares) <= 100.0
    assert min(shares[8:]) >= 98.0


def batch(printed: str) -> None:
    fallen = numbers("{}% fell", printed)
    assert len(fallen) == 5
    assert fallen == sorted(fallen)
    assert fallen[0] == 0.0
    assert fallen[-1] > 90.0
    assert "to the bit: True" in printed


def footholds(printed: str) -> None:
    assert printed.startswith("outcome: recovered\n")
    assert numbers("at {} s", printed) == [0.6, 1.1, 1.8, 2.3, 2.9, 3.4]
    assert numbers("stone by {} mm", printed) == [0.0] * 6
    longest = sf.load_robot("paper-biped").gait.step_x[1]
    assert numbers("to {} m in x", printed) == [longest]
    assert numbers("got {} m", printed)[0] > longest


def log(printed: str) -> None:
    assert "HybridController, recovered" in printed
    assert "half of the file: cut short" in printed
    assert printed.count(": True\n") == 3


def decision_margins(printed: str) -> None:
    rows = printed.splitlines()[1:]
    margins = numbers("{} mm", printed)
    assert len(margins) == len(rows) == 8
    assert margins == sorted(margins, reverse=True)
    assert [margin < 0.0 for margin in margins] == ["fell" in row for row in rows]
    assert [margin < 0.0 for margin in margins] == ["LOST" in row for row in rows]
    assert rows[0].endswith("walked     none")


def body_with_noise(printed: str) -> None:
    assert re.findall(r": (\w+), \d+ steps", printed) == ["walked"] * 3
    assert numbers("speed {} m/s", printed) == [pytest.approx(0.3, rel=0.2)] * 3
    for errors in numbers("by {} mm forward", printed), numbers("forward, {} mm", printed):
        assert 0.0 < errors[0] < errors[1] < errors[2] < 10.0


def turn_on_a_circle(printed: str) -> None:
    assert printed.startswith("outcome: walked")
    (wanted,), (radius,) = numbers("turn = {} m", printed), numbers("walked: {} m", printed)
    assert radius == pytest.approx(wanted, rel=0.05)
    assert numbers("left by {} degrees", printed) == [pytest.approx(360.0, abs=20.0)]
    assert numbers("course by {} mm", printed)[0] < 40.0
    assert numbers("off by {} degrees", printed)[0] < 8.0


def why_it_fell(printed: str) -> None:
    assert re.findall(r"^\S.*: (\w+)$", printed, re.MULTILINE) == ["recovered", *["fell"] * 3]
    assert re.findall(r"cause: ([\w ]+),", printed) == ["slip", "leg too slow", "trip"]
    began, ended = numbers(", at {} s", printed), numbers("end: at {} s", printed)
    assert all(begin < end for begin, end in zip(began, ended, strict=True))
    ice, *pushed = began
    assert ice < 2.5
    assert all(begin >= 2.5 for begin in pushed)


def late_sensors(printed: str) -> None:
    rows = re.findall(r"(\d+) ms +(\d+) N s +(\d+) N s", printed)
    late, without, predicted = (list(map(int, column)) for column in zip(*rows, strict=True))
    assert late == [0, 10, 20, 40]
    assert without[0] == predicted[0]
    for falls_at in without, predicted:
        assert all(more > less for more, less in pairwise(falls_at))
    assert all(p > w for p, w in zip(predicted[1:], without[1:], strict=True))


def law_of(example: str) -> Callable[[str], None]:
    """The function above that is named as the example, without its number."""
    return globals()[example.partition("_")[2]]


PICTURES = {
    "00_walk_and_push": "walk.png",
    "07_footholds": "footholds.png",
    "11_turn_on_a_circle": "circle.png",
}


def test_every_example_has_a_law_and_a_place_on_the_page() -> None:
    names = [path.stem for path in EXAMPLES]
    page = PAGE.read_text("utf-8")
    assert list(blocks()) == names
    assert all(callable(law_of(name)) for name in names)
    assert re.findall(r"^\| \[(\w+)\]", page, re.MULTILINE) == names


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_is_short_and_uses_public_names(path: Path) -> None:
    text = path.read_text("utf-8")
    assert 20 <= text.count("\n") <= 60
    assert "import surefoot as sf\n" in text
    assert re.findall(r"^\s*(?:from surefoot|import surefoot\.)", text, re.MULTILINE) == []
    assert set(re.findall(r"\bsf\.(\w+)", text)) <= set(sf.__all__)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_prints_what_its_page_shows(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.setattr(sys, "argv", [str(path)])
    with redirect_stdout(io.StringIO()) as output:
        runpy.run_path(str(path), run_name="__main__")
    printed = output.getvalue()
    law_of(path.stem)(printed)
    physics = "simulate_body" in path.read_text("utf-8")
    assert comparable(printed, physics) == comparable(blocks()[path.stem], physics)
    if path.stem in PICTURES:
        assert (tmp_path / PICTURES[path.stem]).stat().st_size > 10_000


def test_runs_by_itself_and_draws_where_it_is_told(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, EXAMPLES[0], "mine.svg"], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("picture: mine.svg\n")
    assert (tmp_path / "mine.svg").stat().st_size > 10_000

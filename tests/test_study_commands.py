"""Commands of studies: they measure once, show, write all files, and refuse what makes no sense."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import polars
import pytest
from click.testing import CliRunner, Result

from surefoot.cli import main
from surefoot.studies.engine import study as engine_study


class Asked(NamedTuple):
    """A command, what it prints and writes, the rows of its table, and where its JSON has what."""

    words: str
    shown: tuple[str, ...]
    files: tuple[str, ...]
    rows: int
    place: tuple[Any, ...] = ("rows",)
    table: str = ""
    entries: int = 0


BODY = "compare --simulator mujoco"
ASKED = {
    "compare": Asked(
        "compare --mass 70 --method tracking --method capture-point --directions 4 --phases 1 "
        "--step 25",
        ("capture-point stepping", "2 methods", "8 scans of pushes"),
        ("compare.html", "compare.md", "pictures/map-3.png", "pictures/shares.png"), 8,
    ),
    "budget": Asked(
        "compare --mass 70 --method tracking --disturbance delay-10ms --disturbance late-touchdown "
        "--directions 1 --phases 1 --step 10",
        ("undisturbed", "delay 10 ms", "touchdown 30 ms late", "DCM tracking"),
        ("budget.html", "budget.md", "budget.png"), 3, table="compare",
    ),
    "pushes": Asked(
        f"{BODY} --method tracking --phases 1 --grid 50",
        ("8 before the push", "1 method ", "worst of 1 phase and 2 feet"),
        ("pushes.html", "pushes.md", "paper-biped/pushes.png"), 8, ("robots", 0, "rows"),
        "paper-biped/pushes",
    ),
    "walks": Asked(
        f"{BODY} --disturbance bumps-10mm --seeds 1 --duration 1.5",
        ("usual noise", "bumps of 10 mm", "1 of 1", "DCM", "[mm]", "[mrad]", "walks.md"),
        ("walks.html", "walks.md", "walks.png"), 2, ("robots", 0, "rows"), "paper-biped/walks",
    ),
    "push-map": Asked(
        "push-map --controller hybrid --directions 4 --phases 2 --step 20", ("forward",),
        ("push-map.html", "push-map.md", "push-map.png", "push-map-polar.png"), 8, ("cells",),
    ),
    "gentleness": Asked(
        "gentleness --impulse 10 --leg-speed 3", ("Leg speed 3 m/s", "16 of 16"),
        ("gentleness.html", "gentleness.md"), 32, ("gentleness",), entries=1,
    ),
}  # fmt: skip


def surefoot(words: str, out: Path) -> Result:
    return CliRunner().invoke(main, [*words.split(), "--workers", "1", "--out", str(out)])


@pytest.fixture(scope="module", params=ASKED)
def done(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A command that has run, its folder, and what it printed."""
    asked, folder = ASKED[request.param], tmp_path_factory.mktemp("command") / "out"
    result = surefoot(asked.words, folder)
    assert result.exit_code == 0, result.output
    return request.param, asked, folder, " ".join(result.output.split())


def test_it_shows_and_writes_all(done: Any) -> None:
    name, asked, folder, output = done
    for words in (*asked.shown, asked.files[0]):
        assert words in output
    table = f"{asked.table or name}.parquet"
    files = {str(path.relative_to(folder)) for path in folder.rglob("*.*")}
    kept = {file for file in files if "shards" in file or file.endswith("run.json")}
    assert files - kept == {*asked.files, table}
    assert all((folder / file).stat().st_size > 0 for file in files)
    assert len(polars.read_parquet(folder / table)) == asked.rows


def test_the_same_command_measures_nothing_twice_and_prints_json(done: Any) -> None:
    name, asked, folder, _ = done
    before = sorted(folder.rglob("shards/*"))
    assert before
    again = surefoot(f"{asked.words} --json", folder)
    assert again.exit_code == 0, again.output
    rows = told = json.loads(again.stdout)
    for key in asked.place:
        rows = rows[key]
    assert len(rows) == (asked.entries or asked.rows)
    assert sorted(folder.rglob("shards/*")) == before
    table = folder / f"{asked.table or name}.parquet"
    notes = polars.read_parquet_metadata(table)
    for key in ("methods", "disturbances", "conditions"):
        if f"surefoot.{key}" in notes and key in told:
            assert json.loads(notes[f"surefoot.{key}"]) == told[key]


OTHER = {
    "compare": ("--disturbance delay-10ms", "a folder of the same study (must_settle: False)"),
    "pushes": ("--grid 40", "a folder of the same study (step: 40.0)"),
    "walks": ("--duration 2", "a folder of the same study (duration: 2.0)"),
    "push-map": ("--leg-speed 2.5", "choose another folder, or delete this one"),
}
"""By the command: more of its words, and what is said of its folder."""


@pytest.mark.parametrize("done", OTHER, indirect=True)
def test_another_question_needs_another_folder(done: Any) -> None:
    name, asked, folder, _ = done
    more, message = OTHER[name]
    wrong = surefoot(f"{asked.words} {more}", folder)
    assert wrong.exit_code == 2
    assert message in wrong.stderr


MISUSE = [
    ("compare --method lqr", "expected a method (tracking,"),
    ("compare --disturbance fog", "expected a disturbance (none, dcm-noise-1mm,"),
    ("compare --estimate", "--estimate with --simulator mujoco"),
    ("compare --explain", "--explain with --simulator mujoco"),
    ("compare --robot h1 --robot g1", "one --robot with --simulator lipm"),
    ("compare --duration 2", "--duration with --simulator mujoco and --disturbance"),
    (f"{BODY} --mass 70", "--mass with --simulator lipm"),
    (f"{BODY} --leg-speed 3", "--leg-speed with --simulator lipm"),
    (f"{BODY} --method lqr", "a method for a body (tracking, "),
    (f"{BODY} --robot paper-table2", "a robot with a [body] table"),
    (f"{BODY} --robot g1 --robot g1", "every --robot once"),
    (f"{BODY} --grid 0", "`step` above 0 [N s]"),
    (f"{BODY} --phases 0", "`phases` as a whole number"),
    (f"{BODY} --seeds 2", "no --disturbance"),
    (f"{BODY} --disturbance fog", "a disturbance of a body (usual-noise"),
    (f"{BODY} --disturbance all --phases 2", "--phases without"),
    (f"{BODY} --disturbance all --explain", "--explain without"),
    (f"{BODY} --disturbance all --mass 9", "--simulator lipm"),
    (f"{BODY} --disturbance all --seeds 0", "`seeds` as a whole"),
    ("push-map --full --coarse 40", "expected `--coarse` or `--full`; got both"),
    ("push-map --controller luck", "a method ("),
    ("push-map --step 20 --coarse 30", "`coarse` as 1 to 200 times the step of 20 N s; got 30 N s"),
    ("push-map --leg-speed 1", "a leg of at least"),
    ("gentleness --leg-speed 0", "`leg_speeds` above 0"),
]


@pytest.mark.parametrize(("words", "message"), MISUSE)
def test_misuse_is_refused_and_leaves_nothing(words: str, message: str, tmp_path: Path) -> None:
    wrong = surefoot(words, tmp_path / "out")
    assert wrong.exit_code == 2, wrong.output
    assert message in " ".join(wrong.stderr.split())
    assert not (tmp_path / "out").exists()


def test_nobody_measures_without_workers(tmp_path: Path) -> None:
    words = ["gentleness", "--workers", "0", "--out", str(tmp_path / "out")]
    wrong = CliRunner().invoke(main, words)
    assert wrong.exit_code == 2
    assert "a number of workers; got 0" in wrong.stderr


def test_a_command_that_is_stopped_says_what_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(engine_study, "measure_missing", stopped)
    done = surefoot(ASKED["gentleness"].words, tmp_path / "out")
    assert done.exit_code == 130
    assert "the same command goes on there" in done.stderr

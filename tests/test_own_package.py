"""Somebody else's package brings a control method: everything sees it, with no edit in Surefoot."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import polars
import pytest

import surefoot as sf
from surefoot.robot.robot import preset_text

SOURCE = Path(sf.__file__).parents[1]
OWN = Path(__file__).parent / "own_method.py"
WHEEL = "leaning_robots-1.0-py3-none-any.whl"
INFO = {
    "METADATA": "Metadata-Version: 2.1\nName: leaning-robots\nVersion: 1.0\n",
    "WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    "entry_points.txt": "[surefoot.methods]\nleaning = leaning_robots.control:Leaning\n"
    "[surefoot.robots]\ntall = leaning_robots.robots:TALL\n"
    "[surefoot.commands]\nlean = leaning_robots.command:lean\n",
}
FILES = ("leaning_robots/__init__.py", "leaning_robots/control.py")
OTHERS = {
    "robots.py": "from pathlib import Path\nTALL = Path(__file__).with_name('tall.toml')\n",
    "tall.toml": preset_text("paper-biped").split("[body]")[0].replace("paper-biped", "tall"),
    "command.py": "import click\n@click.command()\ndef lean():\n    'Lean.'\n    print('leans')\n",
}

LIVE = """
import json
from surefoot.cli.live import live_menu, make_walk
from surefoot.dcm.pushes import Push
from surefoot.live.run import Choice, LiveRun
from surefoot.worlds.steering import Steering
choice = Choice(controller="leaning")
run = LiveRun(make_walk, choice, Steering((0.3, 0.0)))
run.advance(3.0)
offered = live_menu(choice).controllers["lipm"]
print(json.dumps([run.walk.fallen, run.walk.controller.gain, offered]))
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package, as pip installs its wheel; nothing is fetched."""
    folder = tmp_path_factory.mktemp("own")
    with zipfile.ZipFile(folder / WHEEL, "w") as wheel:
        wheel.writestr(FILES[0], "")
        wheel.writestr(FILES[1], OWN.read_text("utf-8"))
        for name, text in OTHERS.items():
            wheel.writestr(f"leaning_robots/{name}", text)
        for name, text in INFO.items():
            wheel.writestr(f"leaning_robots-1.0.dist-info/{name}", text)
        wheel.writestr("leaning_robots-1.0.dist-info/RECORD", "")
    site = folder / "site"
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps"]
    subprocess.run(
        [*pip, "--disable-pip-version-check", "--target", str(site), str(folder / WHEEL)],
        check=True, capture_output=True,
    )  # fmt: skip
    return site


def python(site: Path, *arguments: str, **variables: str) -> str:
    environment = os.environ | {"PYTHONPATH": f"{site}{os.pathsep}{SOURCE}"} | variables
    done = subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def surefoot(site: Path, *words: str) -> str:
    return python(site, "-c", "from surefoot.cli import main; main()", *words)


def test_walk_lists_it_and_walks_with_it(installed: Path) -> None:
    assert "leaning" in surefoot(installed, "walk", "--help")
    push = ("--push", "60,0@1.1+0.2", "--duration", "4", "--json")
    told = json.loads(surefoot(installed, "walk", "--controller", "leaning", *push))
    assert told["outcome"] == "recovered"
    assert told["controller"] == "Leaning"
    place = "leaning_robots.control:Leaning"
    again = json.loads(surefoot(installed, "walk", "--controller", place, *push))
    del told["decision_time"], again["decision_time"]
    assert again == told


def test_the_live_page_offers_it_and_walks_with_it(installed: Path) -> None:
    fallen, gain, offered = json.loads(python(installed, "-c", LIVE))
    assert not fallen
    assert gain == pytest.approx(0.857, abs=0.001)
    assert "leaning" in offered


def test_it_is_compared_and_drawn(installed: Path, tmp_path: Path) -> None:
    asked = ("--method", "leaning", "--method", "tracking", "--directions", "1", "--phases", "1")
    told = surefoot(
        installed, "compare", "--mass", "70", *asked, "--step", "25", "--workers", "1",
        "--out", str(tmp_path / "out"),
    )  # fmt: skip
    assert "tracking that steps" in told
    rows = polars.read_parquet(tmp_path / "out" / "compare.parquet")
    assert set(rows["method"]) == {"leaning", "tracking"}
    assert "tracking that steps" in (tmp_path / "out" / "compare.html").read_text("utf-8")


def test_a_study_sets_it_and_tuning_searches_it(installed: Path) -> None:
    code = (
        "from surefoot.studies.tune.question import usual_parameters\n"
        "from surefoot.studies.sweep.parameters import parameters\n"
        "print([(one.name, one.low, one.high) for one in usual_parameters('leaning')])\n"
        "print('controller.gain' in parameters('leaning'))"
    )
    assert python(installed, "-c", code).splitlines() == ["[('gain', 0.2, 3.0)]", "True"]


def test_it_is_put_through_the_conformance_suite(installed: Path, tmp_path: Path) -> None:
    suite = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", str(tmp_path))
    told = python(installed, *suite, "--pyargs", "surefoot.conformance", SUREFOOT_METHODS="leaning")
    assert told.count(".") > 30


def test_its_robot_walks_and_its_command_runs(installed: Path) -> None:
    told = json.loads(surefoot(installed, "walk", "--robot", "tall", "--duration", "2", "--json"))
    assert told["outcome"] == "walked"
    assert told["robot"] == "tall"
    assert "tall" in surefoot(installed, "robots")
    assert surefoot(installed, "lean") == "leans\n"
    assert re.search(r"\n  lean +Lean\.\n", surefoot(installed, "--help"))


def test_its_kernels_are_compiled_anew_when_its_package_changes(installed: Path) -> None:
    code = (
        "import surefoot as sf, leaning_robots.control as own\n"
        "controller = own.Leaning(sf.load_robot('paper-biped'), (0.5, 0.0))\n"
        "seen = controller.first_observation()\n"
        "seen = seen.replace(dcm=seen.dcm + 0.01)\n"
        "command, _ = controller.step(controller.start(seen), seen)\n"
        "print(command.step_location[0] - seen.support_foot[0] - controller.gait.step_length)"
    )
    file = installed / FILES[1]
    before = float(python(installed, "-c", code))
    assert before == pytest.approx(0.005, abs=1e-6)
    text = file.read_text("utf-8")
    # The constant moves to another file, so that the file of the kernel changes only once.
    file.write_text(text.replace("SHARE = 0.5", "from leaning_robots import SHARE"), "utf-8")
    try:
        for share in (0.5, 0.25):
            (installed / FILES[0]).write_text(f"SHARE = {share}\n", "utf-8")
            assert float(python(installed, "-c", code)) == pytest.approx(0.01 * share, abs=1e-6)
    finally:
        file.write_text(text, "utf-8")

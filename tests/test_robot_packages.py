"""Robots that other packages bring, by the entry point group `surefoot.robots`."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

import surefoot as sf
from surefoot.cli import main
from surefoot.plugins import places
from surefoot.robot.robot import preset_text

Install = Callable[..., Path]


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Puts a package with robot files on the path, as pip would; its folder of robots."""

    def installed(name: str, *robots: str, package: str | None = None) -> Path:
        folder = tmp_path / name / "robots"
        folder.mkdir(parents=True)
        for home in (folder.parent, folder):
            (home / "__init__.py").write_text("raise RuntimeError('listing imports nothing')\n")
        (folder.parent / "__init__.py").write_text("")
        for robot in robots:
            text = preset_text("paper-biped").replace('"paper-biped"', f'"{robot}"', 1)
            (folder / f"{robot}.toml").write_text(text.replace("mass = 68.0", "mass = 40.0"))
        about = tmp_path / f"{name}-1.0.dist-info"
        about.mkdir()
        (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (about / "entry_points.txt").write_text(
            f"[surefoot.robots]\n{name} = {package or f'{name}.robots'}\n"
        )
        places.cache_clear()
        return folder

    monkeypatch.syspath_prepend(tmp_path)
    yield installed
    sys.modules.pop("their_robots", None)
    places.cache_clear()


def test_a_robot_of_a_package_is_loaded_and_listed_by_name(install: Install) -> None:
    shipped = sf.preset_names()
    install("their_robots", "tall", "small")
    assert sf.preset_names() == sorted([*shipped, "tall", "small"])
    robot = sf.load_robot("tall")
    assert (robot.name, robot.mass) == ("tall", 40.0)
    listed = json.loads(CliRunner().invoke(main, ["robots", "--json"]).stdout)["robots"]
    assert {one["name"] for one in listed} == {*shipped, "tall", "small"}
    assert CliRunner().invoke(main, ["robots", "--show", "tall"]).stdout == preset_text("tall")


def test_its_model_lies_beside_its_file(install: Install) -> None:
    folder = install("their_robots", "tall")
    path = folder / "tall.toml"
    path.write_text(path.read_text().replace('model = "paper-biped"', 'model = "tall.xml"'))
    body = sf.load_robot("tall").body
    assert body is not None
    assert body.model == str((folder / "tall.xml").resolve())


def test_two_robots_of_one_name_are_refused(install: Install) -> None:
    install("their_robots", "tall", "paper-biped")
    with pytest.raises(sf.RobotError, match=r"one robot of the name .*their_robots"):
        sf.load_robot("paper-biped")
    assert sf.load_robot("tall").mass == 40.0


def test_an_entry_point_without_a_package_is_refused(install: Install) -> None:
    install("their_robots", "tall", package="nowhere.robots")
    with pytest.raises(
        sf.RobotError, match=r"entry point 'their_robots'.*'nowhere.robots'; repair"
    ):
        sf.preset_names()

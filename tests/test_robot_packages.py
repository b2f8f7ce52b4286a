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
    """Puts a package with robot files on the path, as pip would; its folder."""

    def installed(*robots: str) -> Path:
        folder, about = tmp_path / "their_robots", tmp_path / "their_robots-1.0.dist-info"
        folder.mkdir()
        about.mkdir()
        places_of, lines = ["from pathlib import Path"], ["[surefoot.robots]"]
        for number, robot in enumerate(robots):
            text = preset_text("paper-biped").replace('"paper-biped"', f'"{robot}"', 1)
            (folder / f"{robot}.toml").write_text(text.replace("mass = 68.0", "mass = 40.0"))
            places_of.append(f"R{number} = Path(__file__).with_name('{robot}.toml')")
            lines.append(f"{robot} = their_robots:R{number}")
        (folder / "__init__.py").write_text("\n".join(places_of))
        (about / "METADATA").write_text("Metadata-Version: 2.1\nName: their-robots\nVersion: 1.0\n")
        (about / "entry_points.txt").write_text("\n".join(lines))
        places.cache_clear()
        return folder

    monkeypatch.syspath_prepend(tmp_path)
    yield installed
    sys.modules.pop("their_robots", None)
    places.cache_clear()


def test_a_robot_of_a_package_is_loaded_and_listed_by_name(install: Install) -> None:
    shipped = sf.preset_names()
    install("tall", "small")
    assert sf.preset_names() == sorted([*shipped, "tall", "small"])
    robot = sf.load_robot("tall")
    assert (robot.name, robot.mass) == ("tall", 40.0)
    listed = json.loads(CliRunner().invoke(main, ["robots", "--json"]).stdout)["robots"]
    assert {one["name"] for one in listed} == {*shipped, "tall", "small"}
    assert CliRunner().invoke(main, ["robots", "--show", "tall"]).stdout == preset_text("tall")


def test_its_model_lies_beside_its_file(install: Install) -> None:
    folder = install("tall")
    path = folder / "tall.toml"
    path.write_text(path.read_text().replace('model = "paper-biped"', 'model = "tall.xml"'))
    body = sf.load_robot("tall").body
    assert body is not None
    assert body.model == str((folder / "tall.xml").resolve())


def test_a_second_robot_of_a_shipped_name_is_refused(install: Install) -> None:
    install("tall", "paper-biped")
    with pytest.raises(sf.RobotError, match=r"one robot of the name 'paper-biped'.*their_robots"):
        sf.load_robot("paper-biped")
    assert sf.load_robot("tall").mass == 40.0


def test_a_file_that_is_not_there_is_named(install: Install) -> None:
    (install("tall") / "tall.toml").unlink()
    with pytest.raises(sf.RobotError, match=r"readable robot file.*tall\.toml"):
        sf.load_robot("tall")

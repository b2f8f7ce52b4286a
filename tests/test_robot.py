"""Robots from presets, files, and packages of the entry point group `surefoot.robots`."""

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
from surefoot.robot.robot import Robot, parse_robot, preset_text

GOOD = preset_text("paper-biped")


def test_presets_hold_the_tables_of_the_paper() -> None:
    biped, table2 = sf.load_robot("paper-biped"), sf.load_robot("paper-table2")
    assert (biped.mass, biped.hip) == (68.0, 0.2)
    assert (table2.mass, table2.hip) == (70.0, 0.01)
    for robot in (biped, table2):
        assert robot.com_height == 0.8
        assert robot.gait.step_duration == (0.2, 0.8)
        assert robot.gait.step_x == (-0.5, 0.5)
        assert robot.gait.step_y == (-0.2, 0.3)
        assert robot.gait.dcm_offset == (0.1, 0.05)
        assert (robot.foot.length, robot.foot.width) == (0.2, 0.11)
        assert robot.omega == pytest.approx(3.5018, abs=5e-5)


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(GOOD.replace('"paper-biped"', '"mine"', 1).replace("68.0", "51"))
    robot = sf.load_robot(path)
    assert (robot.name, robot.mass) == ("mine", 51.0)


def test_replace_checks_like_a_file() -> None:
    robot = sf.load_robot("paper-biped")
    assert robot.replace(mass=70.0).mass == 70.0
    assert robot.mass == 68.0
    with pytest.raises(sf.RobotError, match="`mass` of the robot to be positive"):
        robot.replace(mass=-1.0)
    with pytest.raises(sf.RobotError, match="got weight"):
        robot.replace(weight=70.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mass =", "mas =", r"unknown key `mas` in test.toml; did you mean `mass`\?"),
        ("width =", "widht =", r"unknown key `foot.widht` .* did you mean `foot.width`\?"),
        ("[swing]", "[sving]", r"unknown key `sving` .* did you mean `swing`\?"),
        ("68.0", '"68"', r"Expected `float`, got `str` - at `\$.mass`"),
        ("68.0", "-68.0", r"`mass` of the robot to be positive and finite; got -68.0 in test.toml"),
        ("68.0", "nan", r"`mass` of the robot to be positive and finite; got nan"),
        ("hip = 0.2 ", "hip = 0.0 ", r"`hip` of the robot to be positive"),
        ("hip = 0.2 ", "", r"missing required field `hip`"),
        ("[0.2, 0.8]", "[0.8, 0.2]", r"`step_duration` as \[min, max\] .* got \[0.8, 0.2\]"),
        ("[0.2, 0.8]", "[0.0, 0.8]", r"`step_duration` to begin above 0"),
        ("[0.2, 0.8]", "[0.2]", r"length 2, got 1 - at `\$.gait.step_duration`"),
        ("[-0.5, 0.5]", "[0.1, 0.5]", r"`step_x` to contain 0"),
        ("[-0.5, 0.5]", "[0.5, 0.5]", r"`step_x` as \[min, max\] with min < max"),
        ("[-0.2, 0.3]", "[0.1, 0.3]", r"`step_y` to contain 0"),
        ("[0.1, 0.05]", "[0.1, 0.0]", r"`dcm_offset` as two positive bounds"),
        ("length = 0.2", "length = inf", r"`length` of the foot to be positive and finite"),
        ("max_speed = inf", "max_speed = 0.0", r"`max_speed` of the swing to be positive"),
        ("height = 0.05", "landing_velocity = -1", r"`landing_velocity` of the swing to be 0 or"),
        ("mass = 68.0", "mass = ", r"a TOML document; got test.toml: "),
    ],
)
def test_every_mistake_in_a_file_is_named(old: str, new: str, message: str) -> None:
    assert old in GOOD
    with pytest.raises(sf.RobotError, match=message):
        parse_robot(GOOD.replace(old, new, 1), "test.toml")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("atlas", "got 'atlas'; run `surefoot robots`"),
        ("none.toml", r"readable robot file.*none\.toml.*check the path"),
        ("binary.toml", "readable robot file"),
    ],
)
def test_a_file_that_cannot_be_read(tmp_path: Path, monkeypatch, name: str, message: str) -> None:
    monkeypatch.chdir(tmp_path)
    Path("binary.toml").write_bytes(b"\xff\xfe\x00mass")
    with pytest.raises(sf.RobotError, match=message):
        sf.load_robot(name)


def test_the_lateral_box_is_mirrored_with_the_foot() -> None:
    robot = sf.load_robot("paper-biped")
    low_right, high_right = robot.gait.step_box(sf.Side.RIGHT, robot.hip)
    low_left, high_left = robot.gait.step_box(sf.Side.LEFT, robot.hip)
    # Outward is +0.3 beyond the hip width, inward -0.2.
    assert (low_right[1], high_right[1]) == pytest.approx((0.0, 0.5))
    assert (low_left[1], high_left[1]) == pytest.approx((-0.5, 0.0))
    assert (low_right[0], high_right[0]) == (low_left[0], high_left[0]) == (-0.5, 0.5)


def test_gravity_counts() -> None:
    moon = sf.load_robot("paper-biped").replace(gravity=1.62)
    assert moon.omega == pytest.approx((1.62 / 0.8) ** 0.5)


def test_a_robot_is_a_value() -> None:
    robot = sf.load_robot("paper-biped")
    assert robot == sf.load_robot("paper-biped")
    assert isinstance(hash(robot), int)
    with pytest.raises(AttributeError):
        robot.mass = 1.0
    assert Robot.__struct_fields__[0] == "name"


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


def test_a_file_of_a_package_that_is_not_there_is_named(install: Install) -> None:
    (install("tall") / "tall.toml").unlink()
    with pytest.raises(sf.RobotError, match=r"readable robot file.*tall\.toml"):
        sf.load_robot("tall")

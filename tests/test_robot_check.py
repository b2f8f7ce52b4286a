"""`surefoot robots`: what is missing, and what a check finds."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from matplotlib import image

import surefoot as sf
from small_biped import write_small_biped
from surefoot.cli import main
from surefoot.errors import DisplayError
from surefoot.robot.check import Finding, check_robot
from surefoot.robot.legs import measure_pose
from surefoot.robot.model_file import DATA_PACKAGES, how_to_install, missing_packages
from surefoot.robot.multibody import load_multibody
from surefoot.robot.robot import preset_text
from surefoot.show.robot import draw_robot
from surefoot.worlds.body.gait import walking_robot

PRESETS = [
    name
    for name in sf.preset_names()
    if sf.load_robot(name).body is not None and not missing_packages(sf.load_robot(name))
]


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, ["robots", *map(str, arguments)])


def findings(robot: sf.Robot) -> dict[str, Finding]:
    mechanism = load_multibody(robot, any_mass=True)
    return {
        found.check: found
        for found in check_robot(mechanism, measure_pose(mechanism), walking_robot(mechanism))
    }


def changed(path: Path, *changes: tuple[str, str]) -> Path:
    text = path.read_text()
    for before, after in changes:
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", PRESETS)
def test_presets_have_no_problem(name: str) -> None:
    found = findings(sf.load_robot(name))
    assert len(found) == 20
    bad = {check: finding.verdict for check, finding in found.items() if finding.verdict != "ok"}
    assert not bad


DEFECTS = [
    ("mass = 30.0", "mass = 20.0", "mass", "problem", "write mass = 30.00"),
    ("mass = 30.0", "mass = 29.5", "mass", "warning", "write mass = 30.00"),
    ("com_height = 0.635", "com_height = 0.65", "CoM height", "warning", "write com_height = 0.63"),
    ("com_height = 0.635", "com_height = 0.8", "CoM height", "problem", "change body.posture"),
    ('"left_foot", "right_foot"', '"right_foot", "left_foot"', "hip", "problem",
     "exchange the two names in body.feet"),
    ("hip = 0.16", "hip = 0.18", "hip", "problem", "write hip = 0.1600"),
    ("-0.06]", "-0.04]", "soles' height", "problem", "write -0.0600 as z of body.sole"),
    ("-0.06]", "-0.07]", "soles' height", "warning", "write -0.0600 as z of body.sole"),
    ("length = 0.16", "length = 0.19", "sole size", "warning", "measure foot.length"),
    ("width = 0.09", "width = 0.14", "sole size", "problem", "measure foot.length"),
    ('pitch" = -0.388', 'pitch" = -0.2', "soles flat", "problem", "add up to the sole's angle"),
    ('"*_knee"', '"left_knee"', "soles level", "problem", "patterns in body.posture"),
    ('"*_knee"', '"left_knee"', "symmetry", "problem", "posture, torque and speed"),
    ('"*_knee" = 0.84', '"*_knee" = -0.1', "joint ranges", "problem", "correct body.posture"),
    ('locked = ["*_arm"]', "", "joints", "warning", "add them to body.locked"),
    ('["*_arm"]', '["*_arm", "*_hip_yaw"]', "joints", "problem", "or lock a joint"),
    ('roll = "actuated"', 'roll = "passive"\ntorque."*_knee" = inf', "torque limits", "problem",
     "give them in [body.torque]"),
    ("[body.posture]", "[body.speed]\n'left_*' = inf\n[body.posture]", "speed limits", "problem",
     "give them in [body.speed]"),
    ("[body.posture]", "[body.torque]\n'*_knee' = 40\n[body.posture]", "standing torque",
     "warning", "bend the knees less"),
    ("[body.posture]", "[body.torque]\n'*_knee' = 20\n[body.posture]", "standing torque",
     "problem", "bend the knees less"),
    ("[body.posture]", "[body.torque]\n'*_ankle_pitch' = 20\n[body.posture]", "ankles",
     "warning", "shorten foot.length"),
    ("[body.posture]", "[body.torque]\n'left_*' = 50\n[body.posture]", "symmetry", "problem",
     "posture, torque and speed"),
    ("[-0.05, 0.2]", "[-0.1, 0.2]", "step width", "warning", "write -0.050 as the first"),
    ("[-0.25, 0.35]", "[-0.25, 0.6]", "step length", "warning", "shorten step_x"),
    ("", "", "shapes", "warning", "convert them"),
]  # fmt: skip


@pytest.mark.parametrize(("before", "after", "check", "verdict", "remedy"), DEFECTS)
def test_every_defect_is_found(
    tmp_path: Path, before: str, after: str, check: str, verdict: str, remedy: str
) -> None:
    path = write_small_biped(tmp_path)
    sound = findings(sf.load_robot(path))[check]
    assert sound.verdict == "ok" or check == "shapes"
    found = findings(sf.load_robot(changed(path, (before, after)) if before else path))[check]
    assert found.verdict == verdict, found
    assert remedy in found.remedy
    assert found.expected
    assert found.got


def test_straight_knees_are_a_problem(tmp_path: Path) -> None:
    changes = [('pitch" = -0.452', 'pitch" = 0.0'), ("0.84", "0.0"), ("-0.388", "0.0")]
    found = findings(sf.load_robot(changed(write_small_biped(tmp_path), *changes)))
    assert found["knees"].verdict == "problem"
    assert "bend the knees" in found["knees"].remedy
    assert found["step length"].verdict == "warning"


@pytest.mark.parametrize("lean", [-0.1, 0.08])
def test_the_remedy_for_a_leaning_robot_brings_its_com_over_its_soles(
    tmp_path: Path, lean: float
) -> None:
    def leaning(angle: float, folder: str) -> Finding:
        path = write_small_biped(tmp_path / folder)
        changes = [("-0.452", f"{-0.452 + angle}"), ("-0.388", f"{-0.388 - angle}")]
        return findings(sf.load_robot(changed(path, *changes)))["CoM over soles"]

    found = leaning(lean, "first")
    assert found.verdict == "problem"
    correction = float(found.remedy.split("add about ")[1].split()[0])
    assert leaning(lean + correction, "second").verdict == "ok"


def test_a_heavier_link_breaks_the_symmetry(tmp_path: Path) -> None:
    path = write_small_biped(tmp_path)
    changed(
        path.parent / "model" / "small.urdf",
        ('<link name="left_shank"><inertial><origin xyz="0 0 -0.1"/><mass value="1.5"/>',
         '<link name="left_shank"><inertial><origin xyz="0 0 -0.1"/><mass value="2.5"/>'),
    )  # fmt: skip
    found = findings(sf.load_robot(path))["symmetry"]
    assert found.verdict == "problem"
    assert found.got == "left_shank and right_shank weigh 2.500 and 1.500 kg"


def test_the_check_as_a_table(tmp_path: Path) -> None:
    path = changed(write_small_biped(tmp_path), ("mass = 30.0", "mass = 33.0"))
    result = run("check", path)
    assert result.exit_code == 2
    lines = result.stdout.splitlines()
    (place,) = [i for i, line in enumerate(lines) if line.startswith("problem")]
    assert lines[place].split(maxsplit=2)[1:] == ["mass", "expected mass = 33 kg, as the file "
                                                  "says, to 1 %"]  # fmt: skip
    assert lines[place + 1].strip() == "got 30.00 kg"
    assert lines[place + 2].strip().startswith("do this: write mass = 30.00")
    assert lines[-1] == "small: 1 problem and 1 warning"


def test_the_check_as_json(tmp_path: Path) -> None:
    found = json.loads(run("check", write_small_biped(tmp_path), "--json").stdout)
    assert (found["robot"], found["good"]) == ("small", True)
    assert {"check", "verdict", "expected", "got", "remedy"} == set(found["checks"][0])


@pytest.mark.parametrize(
    ("before", "after", "check", "got"),
    [
        ("mass =", "mas =", "file", "unknown key `mas`"),
        ('base = "pelvis"', 'base = "hips"', "model", "'hips'"),
        ("small.urdf", "tall.urdf", "model", "no file "),
    ],
)
def test_what_cannot_be_loaded_is_a_finding(
    tmp_path: Path, before: str, after: str, check: str, got: str
) -> None:
    result = run("check", changed(write_small_biped(tmp_path), (before, after)), "--json")
    assert result.exit_code == 2
    (found,) = json.loads(result.stdout)["checks"]
    assert (found["check"], found["verdict"]) == (check, "problem")
    assert got in found["got"]


def test_a_point_mass_is_a_warning_and_no_problem(tmp_path: Path) -> None:
    result = run("check", "paper-table2", "--picture", tmp_path / "no.png")
    assert result.exit_code == 0
    assert "is a point mass only" in result.stdout
    assert "no picture" in result.stderr
    assert not (tmp_path / "no.png").exists()


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of the small biped; drawn by a process of its own, since OpenGL is chosen at import."""
    path = tmp_path_factory.mktemp("picture") / "small.png"
    robot = write_small_biped(path.parent)
    code = "from surefoot.cli import main; main()"
    command = [sys.executable, "-c", code, "robots", "check", robot, "--picture", path]
    done = subprocess.run(command, capture_output=True, text=True)
    if "expected OpenGL that draws without a screen" in done.stderr:
        pytest.skip("no OpenGL on this machine")
    assert done.returncode == 0, done.stderr
    return path


def test_the_picture_shows_the_robot_on_white(picture: Path) -> None:
    pixels = image.imread(picture)[..., :3]
    assert pixels.shape[0] == 1120
    assert pixels.shape[1] > 1500
    white = (pixels > 0.99).all(axis=-1)
    assert 0.7 < white.mean() < 0.97
    grey = (abs(pixels - pixels.mean(axis=-1, keepdims=True)).max(axis=-1) < 0.05) & ~white
    assert grey[200:1000, 100:700].mean() > 0.05


def test_a_picture_needs_a_place_and_opengl(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "a path ending in .png, .pdf, .svg" in run("check", "h1", "--picture", "a.gif").stderr

    def refuse(*_: object) -> None:
        raise ImportError("no EGL here")

    monkeypatch.setattr("surefoot.show.scene._gl_context", lambda: refuse)
    mechanism = load_multibody(sf.load_robot("paper-biped"))
    with pytest.raises(DisplayError, match=r"ImportError: no EGL here; install Mesa .*MUJOCO_GL"):
        draw_robot(mechanism, measure_pose(mechanism), tmp_path / "a.png")
    result = run("check", "paper-biped", "--picture", tmp_path / "a.png")
    assert result.exit_code == 2
    assert "paper-biped: all is well" in result.stdout
    assert "error: expected OpenGL" in result.stderr


def test_the_list_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("surefoot.robot.model_file._is_installed", lambda package: False)
    printed = run().stdout
    assert "point mass only" in printed
    assert "For g1, h1, talos in physics:\n    pip install 'surefoot[robots]'" in printed
    found = {robot["name"]: robot for robot in json.loads(run("--json").stdout)["robots"]}
    assert set(found) == set(sf.preset_names())
    assert found["talos"]["missing"] == ["example-robot-data"]
    assert found["paper-biped"]["missing"] == []
    assert found["paper-table2"]["point_mass_only"]


def test_the_list_and_a_clear_word_without_mujoco() -> None:
    code = "import sys; sys.modules['mujoco'] = None; from surefoot.cli import main; main()"

    def without(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", code, "robots", *arguments]
        return subprocess.run(command, capture_output=True, text=True)

    listed = without()
    assert listed.returncode == 0, listed.stderr
    assert "missing: mujoco" in " ".join(listed.stdout.split())
    found = listed.stdout.split(" in physics:\n    pip install 'surefoot[mujoco]'")[0]
    assert "paper-biped" in found.splitlines()[-1]
    checked = without("check", "paper-biped")
    assert checked.returncode == 2
    assert 'do this: run: pip install "surefoot[mujoco]"' in checked.stdout
    assert without("check", "paper-table2").returncode == 0


def test_the_list_loads_no_physics() -> None:
    code = "import sys; from surefoot.cli import main; main(standalone_mode=False); "
    code += "sys.exit('mujoco' in sys.modules)"
    assert (
        subprocess.run([sys.executable, "-c", code, "robots"], capture_output=True).returncode == 0
    )


def test_how_to_install_names_as_little_as_will_do() -> None:
    assert how_to_install(["mujoco"]) == "pip install 'surefoot[mujoco]'"
    assert how_to_install(["mujoco", DATA_PACKAGES[0]]) == "pip install 'surefoot[robots]'"
    assert how_to_install(["my-robot-data"]) == "pip install my-robot-data"


def test_show_still_prints_a_preset() -> None:
    assert run("--show", "h1").stdout == preset_text("h1")

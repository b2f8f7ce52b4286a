from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import surefoot as sf
from invoked import numbers, refused, run

PUSH = ["--push", "176,0@1.1+0.2"]


def test_walk_tells_what_happened() -> None:
    result = run("walk", *PUSH)
    assert result.exit_code == 0
    assert "paper-biped (68 kg) walks at (0.5, 0) m/s with UnifiedController" in result.output
    assert "pushed with (176, 0) N from 1.1 s to 1.3 s: 35.2 N s, 0.518 m/s" in result.output
    assert "recovered: back on the nominal gait" in result.output
    assert "smallest margin" in result.output
    (third,) = [line for line in result.output.splitlines() if line.strip().startswith("3 ")]
    assert "online" in third


def test_walk_json_holds_what_was_promised() -> None:
    told = numbers("walk", *PUSH)
    assert told["outcome"] == "recovered"
    for name in ("side", "location", "duration", "dcm_offset"):
        assert name in told["steps"][2]
    assert told["pushes"][0]["impulse"] == pytest.approx([35.2, 0.0])
    assert told["pushes"][0]["delta_v"] == pytest.approx([35.2 / 68.0, 0.0])
    assert told["largest_dcm_error"] > 0.1
    assert told["largest_zmp_excess"] == 0.0
    assert told["final_velocity"] == pytest.approx([0.5, 0.0], abs=1e-5)
    assert 0.0 < told["decision_time"]["p50"] <= told["decision_time"]["p99"]
    assert told["fall"] is None


@pytest.mark.parametrize(
    ("name", "make"),
    [
        ((), sf.UnifiedController),
        (("--controller", "hybrid"), sf.HybridController),
    ],
    ids=["default", "hybrid"],
)
def test_json_agrees_with_the_library(name: tuple[str, ...], make: type) -> None:
    told = numbers("walk", *name, *PUSH)
    controller = make(sf.load_robot("paper-biped"), (0.5, 0.0))
    assert told["controller"] == make.__name__
    rollout = sf.simulate(controller, 6.0, [sf.Push(1.1, 0.2, (176.0, 0.0))])
    assert [step["duration"] for step in told["steps"]] == [s.duration for s in rollout.footsteps]


def test_a_fall_exits_with_1_and_its_evidence() -> None:
    result = run("walk", "--push", "1300,0@1.1+0.2")
    assert result.exit_code == 1
    assert "fell forward at 1.9" in result.output
    assert "nothing could save it from 1.2" in result.output
    told = numbers("walk", "--push", "1300,0@1.1+0.2")
    assert told["fall"]["limit"] == "forward"


def test_several_pushes_and_an_endless_one() -> None:
    told = numbers("walk", "--push", "5,5@0+inf", "--push", "-1e2,.5@1.0+0.1", *PUSH)
    assert [push["force"] for push in told["pushes"]] == [[5.0, 5.0], [-100.0, 0.5], [176.0, 0.0]]
    assert told["pushes"][0]["duration"] is None


def test_a_new_velocity_on_the_way() -> None:
    told = numbers("walk", "--then", "0.2,0.1@2.0")
    assert told["velocity"] == [0.2, 0.1]
    assert told["final_velocity"] == pytest.approx([0.2, 0.1], abs=1e-3)


def test_the_other_options(tmp_path: Path) -> None:
    robot = tmp_path / "mine.toml"
    robot.write_text(run("robots", "--show", "paper-table2").output)
    path = tmp_path / "walk.npz"
    result = run(
        "walk", "--robot", str(robot), "--velocity", "-0.2", "0.05", "--controller", "tracking",
        "--unprojected", "--leg-speed", "4", "--leg-acceleration", "60", "--duration", "2.5",
        "--save", str(path),
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    rollout = sf.load_rollout(path)
    assert rollout.controller == "DcmTracking"
    assert "project_zmp=False" in rollout.controller_parameters
    swing = rollout.robot.swing
    assert (swing.max_speed, swing.max_acceleration) == (4.0, 60.0)
    assert rollout.robot.hip == 0.01
    assert rollout.velocity == (-0.2, 0.05)


def test_plot_draws(tmp_path: Path) -> None:
    path = tmp_path / "walk.png"
    assert run("walk", *PUSH, "--duration", "3", "--plot", str(path)).exit_code == 0
    assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["--push", "176"],
            "expected --push FX,FY@START+DURATION in newtons and seconds; got '176'",
        ),
        (["--push", "176,0@1.1"], "write for example --push 176,0@1.1+0.2"),
        (["--push", "a,b@c+d"], "got 'a,b@c+d'"),
        (["--push", "176,0@1.1+0"], "positive duration"),
        (["--push", "nan,0@1.1+0.2"], "got 'nan,0@1.1+0.2'"),
        (["--then", "0.5@1"], "expected --then VX,VY@TIME"),
        (["--then", "7,0@1"], "expected at most 2.5000 m/s"),
        (["--velocity", "9", "0"], "expected at most 2.5000 m/s in the direction of (9.0, 0.0)"),
        (["--velocity", "nan", "0"], "two finite numbers"),
        (["--robot", "atlas"], "expected a preset (g1, h1, paper-biped, paper-table2, talos)"),
        (["--robot", "none.toml"], "readable robot file"),
        (["--duration", "-1"], "`duration` above 0 [s]"),
        (["--duration", "long"], "not a valid float"),
        (["--controller", "mpc"], "expected a method (tracking, tracking-stiff, "),
        (["--leg-speed", "0"], "`max_speed` of the swing to be positive"),
        (["--save", "walk.xyz"], "a path ending in .npz"),
        (["--save", "no/such/place/walk.npz"], "a directory that exists; got no/such/place"),
        (["--plot", "no/such/place/walk.png"], "a directory that exists; got no/such/place"),
        (["--plot", "walk.bmp"], "a path ending in .png"),
        (["--plot", "/proc/walk.png"], "a file that can be written"),
        (["--plot", "w" * 300 + ".png"], "a file that can be written"),
    ],
)
def test_misuse_exits_with_2_and_says_what_to_do(arguments: list[str], message: str) -> None:
    # Ten million seconds: had the walk begun before the mistake was told, this would not end.
    assert message in refused("walk", "--duration", "1e7", *arguments)


CSV = "side,x,y,time\nleft,0,0.1,0\nright,0,-0.1,0\nleft,0.25,0.1,0.5\nright,0.25,-0.1,1.0\n"


def test_footholds_are_walked_over(tmp_path: Path) -> None:
    path = tmp_path / "steps.csv"
    path.write_text(CSV)
    told = numbers("walk", "--footholds", str(path), "--double-support", "0.2")
    assert told["controller"] == "FootholdTracking"
    assert told["steps"][0]["location"] == pytest.approx([0.25, 0.1])
    assert told["steps"][1]["location"] == pytest.approx([0.25, -0.1])
    assert told["outcome"] == "walked"


@pytest.mark.parametrize(
    ("times", "arguments", "messages"),
    [
        ("1.0", ["--velocity", "0.1", "0"], ["--footholds alone: they say where and when to step"]),
        ("1.0", ["--then", "0.1,0@1"], ["got --then too"]),
        ("1.0", ["--controller", "hybrid"], ["got --controller too"]),
        ("0.4", [], ["times that run forward", "line 5"]),
    ],
)
def test_footholds_are_in_order_and_alone(
    tmp_path: Path, times: str, arguments: list[str], messages: list[str]
) -> None:
    path = tmp_path / "steps.csv"
    path.write_text(CSV.replace(",1.0\n", f",{times}\n"))
    said = refused("walk", "--footholds", str(path), *arguments)
    assert all(message in said for message in messages)


def test_reproduce_writes_its_report(tmp_path: Path) -> None:
    result = run("reproduce", "--out", str(tmp_path / "paper"))
    assert result.exit_code == 0, result.output
    assert "Fig. 9" in result.output
    page = (tmp_path / "paper" / "paper.html").read_text()
    assert "85 N s" in page
    assert page.count("data:image/png;base64,") >= 7
    assert (tmp_path / "paper" / "paper.md").exists()
    refused("reproduce", "--out", str(tmp_path / "no" / "such"))


def test_robots_lists_the_presets() -> None:
    result = run("robots")
    assert result.exit_code == 0
    for name in sf.preset_names():
        assert name in result.output
    refused("robots", "--show", "atlas")


def test_limits_prints_the_viable_offsets() -> None:
    assert "-0.4929 .. +0.4929 m" in run("limits").output
    told = numbers("limits", "--robot", "paper-biped")
    assert told["omega"] == pytest.approx(3.5018, abs=5e-5)
    assert told["largest_speed"]["forward"] == pytest.approx(2.5)
    assert told["viable_offset"]["point_foot"]["y"] == pytest.approx([-0.3294, 0.1635], abs=5e-5)
    assert told["viable_offset"]["finite_foot"]["x"][1] == pytest.approx(0.5929, abs=5e-5)


def test_limits_prints_the_largest_survivable_pushes() -> None:
    printed = run("limits", "--phases", "5").output
    assert "Theoretical limit: the largest push that can be survived" in printed
    assert "A leg of at most 3 m/s" in printed
    unlimited = printed.split("An unlimited leg")[1]
    rows = [line for line in unlimited.split("A leg of")[0].splitlines() if " 0.10 " in line]
    point, point_share, sole, _ = rows
    assert point_share.split()[1:] == ["100", "%"] * 8
    assert "95 %" in unlimited.split("A leg of")[0]
    robot = sf.load_robot("paper-biped")
    for row, reach in ((point, (0.0, 0.0)), (sole, robot.foot.half)):
        printed_limits = row.split()[1:]
        assert len(printed_limits) == 16
        for place, direction in ((0, (1.0, 0.0)), (6, (-1.0, 1.0)), (14, (1.0, -1.0))):
            limit = sf.push_limit(robot, direction, zmp_reach=reach)
            told = [f"{limit.impulse:.0f}", f"{limit.delta_v:.2f}"]
            assert printed_limits[place : place + 2] == told
    assert "Computed again" not in printed


def test_limits_json_holds_the_pushes_and_their_check() -> None:
    told = numbers(
        "limits", "--velocity", "0.3", "0", "--push-duration", "0.1", "--leg-speed", "4",
        "--phases", "2", "--check",
    )["push_limit"]  # fmt: skip
    assert told["velocity"] == [0.3, 0.0]
    assert [leg["leg_speed"] for leg in told["legs"]] == [4.0]
    robot = sf.load_robot("paper-biped")
    robot = robot.with_leg(max_speed=4.0)
    limit = sf.push_limit(
        robot, (0.0, -1.0), velocity=(0.3, 0.0), elapsed=told["elapsed"][1], duration=0.1,
        zmp_reach=robot.foot.half,
    )  # fmt: skip
    inward = told["legs"][0]["finite_foot"]["inward"]
    assert inward["impulse"][1] == pytest.approx(limit.impulse)
    assert inward["delta_v"][1] == pytest.approx(limit.delta_v)
    assert told["legs"][0]["fixed_steps"]["forward"]["impulse"][0] > 0.0
    assert told["check"]["fraction"] < 0.01


def test_limits_of_many_legs_hips_and_durations() -> None:
    told = numbers(
        "limits", "--hip", "0.1", "--velocity", "0.8", "0", "--leg-speed", "2", "--leg-speed", "4",
        "--leg-acceleration", "60", "--push-duration", "0.005", "--push-duration", "0.5",
        "--phases", "1",
    )["push_limit"]  # fmt: skip
    slow, _, brief, long = told["legs"]
    assert told["hip"] == 0.1
    assert "max_speed" in slow["refused"]
    assert (brief["leg_speed"], brief["leg_acceleration"]) == (4.0, 60.0)
    assert (brief["duration"], long["duration"]) == (0.005, 0.5)
    robot = sf.load_robot("paper-biped").replace(hip=0.1)
    robot = robot.with_leg(max_speed=4.0, max_acceleration=60.0)
    for name, direction in told["directions"].items():
        limit = sf.push_limit(
            robot, tuple(direction), velocity=(0.8, 0.0), elapsed=0.0, duration=0.5
        )  # fmt: skip
        assert long["point_foot"][name]["impulse"] == [pytest.approx(limit.impulse)]
    assert len(told["directions"]) == 8
    refused("limits", "--velocity", "0.8", "0", "--leg-speed", "2")
    mixed = run("limits", "--velocity", "0.8", "0", "--leg-speed", "2", "--leg-speed", "3",
                "--phases", "1").output  # fmt: skip
    assert "No limit: it cannot swing as the gait wants" in mixed


def test_limits_of_a_slow_robot_are_printed_too(tmp_path: Path) -> None:
    slow = run("robots", "--show", "paper-biped").output.replace("[-0.5, 0.5]", "[-0.05, 0.05]")
    (tmp_path / "slow.toml").write_text(slow)
    assert "walk at (0.25, 0) m/s" in run("limits", "--robot", str(tmp_path / "slow.toml")).output


def test_the_installed_command_answers() -> None:
    command = Path(sys.executable).with_name("surefoot")
    done = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    assert sf.__version__ in done.stdout

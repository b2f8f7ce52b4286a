"""A log holds the rollout to the bit, standard readers understand it, and a part of it is a part
of the walk."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from dataclasses import fields, replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
from rich.console import Console
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

import surefoot as sf
from surefoot.cli import main
from surefoot.geometry import quaternions, rotation_matrix
from surefoot.rollout import mcap_log as rollout_log
from surefoot.rollout.ros_messages import DEFINITIONS, definition, full_name, push_forces
from surefoot.show.summary import print_walk, walk_summary
from surefoot.show.words import title
from surefoot.worlds.body.recording import roll_pitch_yaw

ROBOT = sf.load_robot("paper-biped")
STANDARD = get_typestore(Stores.ROS2_JAZZY)


def plain() -> sf.Rollout:
    return sf.simulate(
        sf.HybridController(ROBOT, (0.5, 0.0)), 0.7, [sf.Push(0.2, 0.1, (50.0, 9.0))]
    )


def fallen() -> sf.Rollout:
    push = sf.Push(0.1, float("inf"), (1300.0, 0.0))
    return sf.simulate(sf.HybridController(ROBOT, (0.5, 0.0)), 6.0, [push])


def disturbed() -> sf.Rollout:
    noise = sf.Disturbance(dcm_noise=0.002, com_offset=(0.01, 0.0), landing_error=0.01, seed=3)
    controller = sf.HybridController(ROBOT, (0.3, 0.1))
    return sf.simulate(
        controller, 1.5, velocity_changes=[(0.8, (0.2, 0.0))], disturbance=noise,
        estimator=sf.Estimator(ROBOT, filter_time=0.01),
    )  # fmt: skip


@pytest.fixture(scope="module")
def walks(body_control: sf.BodyControl) -> dict[str, sf.Rollout]:
    boards = sf.Surroundings(bumps=0.005)
    pushes = [sf.Push(0.1, 0.1, (60.0, 20.0))]
    point = plain()
    observations = point.observations.copy()
    observations["com_velocity"][5] = (np.nan, -0.0)
    return {
        "plain": point,
        "fallen": fallen(),
        "disturbed": disturbed(),
        "not a number": replace(point, observations=observations, seen=point.observations),
        "body": sf.simulate_body(body_control, 0.5, pushes),
        "body told the truth": sf.simulate_body(
            body_control, 0.4, surroundings=boards, estimator="truth"
        ),
    }


KINDS = ("plain", "fallen", "disturbed", "not a number", "body", "body told the truth")


def bits(rollout: sf.Rollout) -> dict[str, tuple]:
    """Every array of a rollout, down to those that `==` does not look at."""
    owners = [rollout] if rollout.body is None else [rollout, rollout.body]
    return {
        f"{type(owner).__name__}.{item.name}": (value.dtype, value.shape, value.tobytes())
        for owner in owners
        for item in fields(owner)
        if isinstance(value := getattr(owner, item.name), np.ndarray)
    }


@pytest.mark.parametrize("ending", [".mcap", ".MCAP", ".npz", ".NPZ"])
@pytest.mark.parametrize("kind", KINDS)
def test_what_is_loaded_is_what_was_saved(walks, kind: str, ending: str, tmp_path: Path) -> None:
    walk, path = walks[kind], tmp_path / f"walk{ending}"
    walk.save(path)
    loaded = sf.load_rollout(path)
    assert loaded == walk
    assert bits(loaded) == bits(walk)
    assert loaded.outcome is walk.outcome
    assert loaded.footsteps == walk.footsteps
    assert (loaded.disturbance is None) == (kind != "disturbed")
    assert ("filter_time=0.01" in loaded.estimator) == (kind == "disturbed")
    assert (loaded.seen is loaded.observations) == (walk.seen is walk.observations)
    loaded.save(tmp_path / "again.mcap")
    assert sf.load_rollout(tmp_path / "again.mcap") == walk


def test_rollouts_differ_by_a_bit(walks) -> None:
    walk = walks["not a number"]
    assert walk == replace(walk, observations=walk.observations.copy())
    assert walk == replace(walk, decision_time=walk.decision_time + 1.0)
    other = walk.observations.copy()
    other["com_velocity"][5, 1] = 0.0
    assert walk != replace(walk, observations=other)
    assert walk != replace(walk, version="0")
    assert walk != replace(walk, lost_cycles=1)
    assert walk != walks["body"]
    assert walk != "walk"


# --- what other programs read ---------------------------------------------------------------------


@pytest.mark.parametrize("kind", [kind for kind in DEFINITIONS if "Time" not in kind])
def test_definitions_are_the_standard_ones(kind: str) -> None:
    assert definition(kind) == STANDARD.generate_msgdef(full_name(kind), ros_version=2)[0]


def read_by_rosbags(path: Path) -> dict[str, list]:
    """Messages by topic, decoded by the definitions of ROS 2 Jazzy, not by those of the file."""
    with Reader(path) as reader:
        messages: dict[str, list] = {connection.topic: [] for connection in reader.connections}
        for connection, _, data in reader.messages():
            messages[connection.topic].append(STANDARD.deserialize_cdr(data, connection.msgtype))
    return messages


def read_by_mcap(path: Path) -> dict[str, list]:
    messages: dict[str, list] = {}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for _, channel, _, message in reader.iter_decoded_messages():
            messages.setdefault(channel.topic, []).append(message)
    return messages


READERS = [read_by_rosbags, read_by_mcap]


def xyz(vectors: list) -> np.ndarray:
    return np.array([(vector.x, vector.y, vector.z) for vector in vectors])


def wxyz(turns: list) -> np.ndarray:
    return np.array([(turn.w, turn.x, turn.y, turn.z) for turn in turns])


def stamps(messages: list) -> np.ndarray:
    at = [message.header.stamp for message in messages]
    assert {message.header.frame_id for message in messages} == {"world"}
    return np.array([stamp.sec + 1e-9 * stamp.nanosec for stamp in at])


@pytest.mark.parametrize("read", READERS)
def test_other_readers_see_a_point_mass(walks, read: Callable, tmp_path: Path) -> None:
    walk = walks["plain"]
    walk.save(tmp_path / "walk.mcap")
    topics = read(tmp_path / "walk.mcap")
    assert {len(messages) for messages in topics.values()} == {len(walk.time)}
    assert set(topics) == {
        "/com", "/dcm", "/dcm_plan", "/zmp", "/step_target", "/push", "/left_foot/pose",
        "/right_foot/pose", "/surefoot/observation", "/surefoot/command", "/surefoot/decision_time",
    }  # fmt: skip
    for name in ("com", "dcm", "dcm_plan", "zmp"):
        places = xyz([message.point for message in topics[f"/{name}"]])
        assert (places[:, :2] == getattr(walk, name)).all(), name
        assert stamps(topics[f"/{name}"]) == pytest.approx(walk.time, abs=1e-9)
    assert xyz([m.point for m in topics["/com"]])[0, 2] == ROBOT.com_height
    feet = {side: topics[f"/{side}_foot/pose"] for side in ("left", "right")}
    for foot, side in (("left", sf.Side.LEFT), ("right", sf.Side.RIGHT)):
        places = xyz([message.pose.position for message in feet[foot]])
        stands = walk.support_side == side
        assert (places[stands, :2] == walk.support_foot[stands]).all()
        assert (places[~stands] == walk.swing_foot[~stands]).all()
    pushed = xyz([message.wrench.force for message in topics["/push"]])
    acting = (walk.time >= 0.2) & (walk.time < 0.2 + 0.1)
    assert (pushed == np.where(acting[:, None], (50.0, 9.0, 0.0), 0.0)).all()
    first = topics["/surefoot/observation"][0]
    names = first.layout.dim[0].label.split()
    assert len(names) == len(first.data) == first.layout.dim[0].size
    exact = np.array([message.data for message in topics["/surefoot/observation"]])
    assert (exact[:, names.index("time")] == walk.time).all()
    assert (exact[:, names.index("swing_foot.z")] == walk.swing_foot[:, 2]).all()
    assert (exact[:, names.index("support_side")] == walk.support_side).all()


@pytest.mark.parametrize("read", READERS)
def test_other_readers_see_a_body(walks, read: Callable, tmp_path: Path) -> None:
    walk = walks["body"]
    body = walk.body
    walk.save(tmp_path / "walk.mcap")
    topics = read(tmp_path / "walk.mcap")
    assert {len(messages) for messages in topics.values()} == {len(walk.time)}
    joints = topics["/joint_states"]
    assert tuple(joints[0].name) == body.joints
    assert (np.array([joint.position for joint in joints]) == body.joint_angles).all()
    assert (np.array([joint.velocity for joint in joints]) == body.joint_velocities).all()
    assert (np.array([joint.effort for joint in joints]) == body.torque).all()
    assert (xyz([message.point for message in topics["/com"]]) == body.com).all()
    poses = [message.pose for message in topics["/base/pose"]]
    assert (xyz([pose.position for pose in poses]) == body.position[:, :3]).all()
    assert (wxyz([pose.orientation for pose in poses]) == body.position[:, 3:7]).all()
    for foot, name in enumerate(("left", "right")):
        poses = [message.pose for message in topics[f"/{name}_foot/pose"]]
        assert (xyz([pose.position for pose in poses]) == body.sole_position[:, foot]).all()
        forces = [message.wrench.force for message in topics[f"/{name}_foot/floor_force"]]
        assert (xyz(forces) == body.sole_force[:, foot]).all()
    names = topics["/surefoot/body"][0].layout.dim[0].label.split()
    exact = np.array([message.data for message in topics["/surefoot/body"]])
    column = exact[:, names.index("sole_force.right.z")]
    assert (column == body.sole_force[:, 1, 2]).all()


def test_quaternions_turn_as_the_angles_say() -> None:
    turns = np.random.default_rng(1).uniform(-1.5, 1.5, (50, 3))
    matrices = np.zeros((50, 3, 3))
    for turn, matrix in zip(quaternions(turns), matrices, strict=True):
        rotation_matrix(turn, matrix)
    assert roll_pitch_yaw(matrices.reshape(-1, 9)) == pytest.approx(turns, abs=1e-12)


def test_pushes_add_up() -> None:
    pushes = [sf.Push(0.1, 0.2, (10.0, 0.0)), sf.Push(0.2, float("inf"), (1.0, 2.0))]
    forces = push_forces(pushes, np.array([0.0, 0.1, 0.25, 0.5]))
    assert forces.tolist() == [[0.0, 0.0], [10.0, 0.0], [11.0, 2.0], [1.0, 2.0]]


# --- files that are not whole ---------------------------------------------------------------------


def loaded_part(path: Path) -> tuple[sf.Rollout | None, str]:
    """The rollout, or None if there is not one cycle; and what was said."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            rollout = sf.load_rollout(path)
        except sf.FileError as error:
            return None, str(error)
    return rollout, " ".join(str(warning.message) for warning in said)


def assert_is_beginning(part: sf.Rollout, whole: sf.Rollout) -> None:
    cycles = len(part.time)
    assert 0 < cycles == len(whole.time) - part.lost_cycles
    for name in ("observations", "seen", "commands", "decision_time"):
        assert getattr(part, name).tobytes() == getattr(whole, name)[:cycles].tobytes()
    if not part.lost_cycles:
        assert part == whole
        return
    assert part.outcome is sf.Outcome.CUT_SHORT
    assert not part.fallen
    assert part.fall is None
    if whole.body is not None:
        assert part.body is not None
        assert part.body.fate == 0
        assert part.body.torque.tobytes() == whole.body.torque[:cycles].tobytes()
        assert part.body.sole_turn.tobytes() == whole.body.sole_turn[:cycles].tobytes()
        assert part.body.boards.tobytes() == whole.body.boards.tobytes()


@pytest.fixture(scope="module")
def small_chunks(tmp_path_factory: pytest.TempPathFactory, walks):
    """Logs whose pieces are small, so that many of them are whole in a part; by kind."""
    folder = tmp_path_factory.mktemp("logs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rollout_log, "CHUNK", 16 * 1024)
        for kind in KINDS:
            walks[kind].save(folder / f"{kind}.mcap")
    return {kind: (folder / f"{kind}.mcap").read_bytes() for kind in KINDS}


@pytest.mark.parametrize("kind", ["plain", "body"])
def test_of_a_log_that_is_cut_anywhere_the_beginning_is_read(
    walks, small_chunks, kind: str, tmp_path: Path
) -> None:
    whole, path = small_chunks[kind], tmp_path / "part.mcap"
    cuts = {*range(0, 2000, 97), *range(0, len(whole), len(whole) // 50)}
    cuts |= {*range(len(whole) - 40, len(whole), 3), len(whole) - 2000}
    lengths = []
    for cut in sorted(cuts):
        path.write_bytes(whole[:cut])
        part, said = loaded_part(path)
        if part is None:
            assert "run the walk again" in said
            lengths.append(0)
            continue
        assert "is not whole (its end is missing" in said
        assert_is_beginning(part, walks[kind])
        lengths.append(len(part.time))
    assert lengths == sorted(lengths)
    assert lengths[0] == 0
    assert lengths[-1] == len(walks[kind].time)
    assert len(set(lengths)) > 20


@settings(max_examples=100)
@given(data=st.data())
def test_a_damaged_log_is_a_beginning_or_an_error(
    walks, small_chunks, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    kind = data.draw(st.sampled_from(["plain", "fallen", "body told the truth"]))
    file = bytearray(small_chunks[kind])
    at = data.draw(st.integers(0, len(file) - 1))
    dirt = data.draw(st.binary(min_size=1, max_size=16))
    file[at : at + len(dirt)] = dirt
    del file[data.draw(st.integers(at, len(file))) :]
    path = tmp_path_factory.getbasetemp() / "damaged.mcap"
    path.write_bytes(file)
    part, said = loaded_part(path)
    if part is None:
        assert "expected" in said
    else:
        assert_is_beginning(part, walks[kind])


def test_a_fall_that_is_lost_is_told_and_stays_lost(walks, small_chunks, tmp_path: Path) -> None:
    assert walks["fallen"].outcome is sf.Outcome.FELL
    whole = small_chunks["fallen"]
    (tmp_path / "part.mcap").write_bytes(whole[: len(whole) // 2])
    with pytest.warns(UserWarning, match=r"which ended with a fall, there are the first \d+ of"):
        part = sf.load_rollout(tmp_path / "part.mcap")
    assert part.outcome is sf.Outcome.CUT_SHORT
    assert part.lost_cycles == len(walks["fallen"].time) - len(part.time)
    for name in ("again.npz", "again.mcap"):
        part.save(tmp_path / name)
        again = sf.load_rollout(tmp_path / name)
        assert again == part
        assert again.outcome is sf.Outcome.CUT_SHORT


@pytest.mark.parametrize("kind", ["plain", "body"])
def test_a_walk_without_its_end_is_never_called_a_success(walks, kind: str) -> None:
    part = replace(walks[kind], lost_cycles=7)
    assert walk_summary(part)["outcome"] == "cut short"
    assert "its end is lost" in " ".join(title(part))
    console = Console(record=True, width=200, file=StringIO())
    measures = None if part.body is None else sf.measure_body(part, part.body)
    print_walk(part, console, measures=measures)
    printed = console.export_text()
    assert "cut short" in printed
    assert "recovered" not in printed


# --- files of another kind ------------------------------------------------------------------------


def rewritten(source: Path, target: Path, change: Callable[[dict[str, str]], None]) -> Path:
    """A log with other metadata."""
    with target.open("wb") as out, source.open("rb") as file:
        writer, reader = Writer(out), make_reader(file)
        writer.start(profile="ros2")
        for metadata in reader.iter_metadata():
            change(metadata.metadata)
            writer.add_metadata(metadata.name, metadata.metadata)
        channels: dict[int, int] = {}
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            assert schema is not None
            if channel.id not in channels:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, "cdr", number)
            stamp = message.log_time
            writer.add_message(channels[channel.id], stamp, message.data, stamp, message.sequence)
        writer.finish()
    return target


def described(text: str) -> Callable[[dict[str, str]], None]:
    checksum = str(rollout_log.zlib.crc32(text.encode()))
    return lambda metadata: metadata.update(description=text, crc32=checksum)


def test_a_log_that_another_program_wrote_anew_is_the_same(walks, tmp_path: Path) -> None:
    path = tmp_path / "walk.mcap"
    walks["body"].save(path)
    assert sf.load_rollout(rewritten(path, tmp_path / "new.mcap", lambda _: None)) == walks["body"]


def test_files_of_another_kind(walks, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good, bad = tmp_path / "walk.mcap", tmp_path / "bad.mcap"
    walks["plain"].save(good)
    with pytest.raises(sf.FileError, match=r"a log of layout 1; got .* with layout '9'"):
        sf.load_rollout(rewritten(good, bad, lambda metadata: metadata.update(layout="9")))
    with pytest.raises(sf.FileError, match=r"a log that Rollout\.save wrote"):
        sf.load_rollout(rewritten(good, bad, lambda metadata: metadata.update(crc32="0")))
    with pytest.raises(sf.FileError, match=r"a log of something else"):
        sf.load_rollout(rewritten(good, bad, dict.clear))
    for text in ("[]", "{}", '{"about": 3}', "null", "not JSON"):
        with pytest.raises(sf.FileError, match="a complete description of the walk"):
            sf.load_rollout(rewritten(good, bad, described(text)))
    with monkeypatch.context() as patch:
        patch.setattr(rollout_log, "_labels", lambda columns: "other names")
        walks["plain"].save(bad)
    with pytest.raises(sf.FileError, match=r"the records of this version.*written by version"):
        sf.load_rollout(bad)


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"garbage" * 99, b"PK\x03\x04" * 50])
def test_files_that_are_no_logs(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "walk.mcap"
    path.write_bytes(content)
    with pytest.raises(sf.FileError, match=r"a log that Rollout\.save wrote.*run the walk again"):
        sf.load_rollout(path)


def test_places_without_a_log(walks, tmp_path: Path) -> None:
    with pytest.raises(sf.FileError, match="a log that can be read"):
        sf.load_rollout(tmp_path / "none.mcap")
    (tmp_path / "folder.mcap").mkdir()
    with pytest.raises(sf.FileError, match="a log that can be read"):
        sf.load_rollout(tmp_path / "folder.mcap")
    with pytest.raises(sf.FileError, match="a directory that exists"):
        walks["plain"].save(tmp_path / "none" / "walk.mcap")
    if Path("/dev/full").exists():
        (tmp_path / "full.mcap").symlink_to("/dev/full")
        with pytest.raises(sf.FileError, match="a file that can be written"):
            walks["plain"].save(tmp_path / "full.mcap")


# --- the command line and the extra ---------------------------------------------------------------


@pytest.mark.parametrize(
    "options", [["--duration", "1"], ["--simulator", "mujoco", "--truth", "--duration", "0.3"]]
)
def test_the_command_line_saves_logs(options: list[str], tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    result = CliRunner().invoke(main, ["walk", *options, "--save", str(path)])
    assert result.exit_code == 0, result.output
    assert (sf.load_rollout(path).body is not None) == ("mujoco" in options)


@pytest.mark.parametrize("module", ["mcap", "mcap_ros2"])
@pytest.mark.parametrize(
    "code",
    [
        "surefoot.load_rollout('walk.mcap')",
        "main(['walk', '--duration', '1e7', '--save', 'walk.mcap'])",
        "main(['walk', '--simulator', 'mujoco', '--duration', '1e7', '--save', 'walk.mcap'])",
    ],
)
def test_the_missing_extra_is_named_before_the_walk(module: str, code: str, tmp_path: Path) -> None:
    start = f"import sys; sys.modules['{module}'] = None\nimport surefoot\n"
    done = subprocess.run(
        [sys.executable, "-c", f"{start}from surefoot.cli import main\n{code}"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        timeout=120,
    )
    assert done.returncode in (1, 2)
    assert 'run: pip install "surefoot[log]"' in done.stderr
    assert not (tmp_path / "walk.mcap").exists()

"""Messages of ROS 2 in bulk: all that a topic says in a walk, as rows of bytes; and what is drawn.

What viewers draw of a rollout (`drawn_topics`) is in the frame `world`: places, poses, joints and
forces. None of it is read back: the exact numbers are elsewhere in the log, see `rollout.mcap_log`.

A topic's messages differ in their numbers only. The library encodes one of them, with marks in
place of the numbers; where the marks come to lie, NumPy writes the numbers of all the others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import optional_module
from surefoot.dcm.pushes import Push, acting_force
from surefoot.geometry import quaternions
from surefoot.robot.feet import FEET, Side
from surefoot.rollout.trace import BodyTrace

Array = NDArray[Any]

WORLD = "world"
"""The frame of everything."""

DEFINITIONS = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "std_msgs/MultiArrayDimension": "string label\nuint32 size\nuint32 stride\n",
    "std_msgs/MultiArrayLayout": "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset\n",
    "std_msgs/Float32MultiArray": "std_msgs/MultiArrayLayout layout\nfloat32[] data\n",
    "std_msgs/Float64MultiArray": "std_msgs/MultiArrayLayout layout\nfloat64[] data\n",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n",
    "geometry_msgs/PointStamped": "std_msgs/Header header\ngeometry_msgs/Point point\n",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    "geometry_msgs/WrenchStamped": "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\n"
        "float64[] position\nfloat64[] velocity\nfloat64[] effort\n"
    ),
}
"""The standard definitions of the types that are used."""

SIDES = (Side.LEFT, Side.RIGHT)
"""In the order of `FEET`."""

SECOND, NANOSECOND = 1_000_000_007, 1_000_000_009
"""Marks of a stamp."""


def definition(kind: str) -> str:
    """The text of a type with those of all types in it, as logs hold it."""
    rule = 80 * "=" + "\n"
    first, *others = _needed(kind, [])
    return DEFINITIONS[first] + "".join(
        f"{rule}MSG: {other}\n{DEFINITIONS[other]}" for other in others
    )


def _needed(kind: str, known: list[str]) -> list[str]:
    if kind not in known:
        known.append(kind)
        for line in DEFINITIONS[kind].splitlines():
            part = line.split()[0].removesuffix("[]")
            if "/" in part:
                _needed(part, known)
    return known


def full_name(kind: str) -> str:
    """The name of a type as logs hold it."""
    package, name = kind.split("/")
    return f"{package}/msg/{name}"


@dataclass(frozen=True)
class Topic:
    """A topic and all it says.

    Attributes:
        name: with its slashes.
        kind: type of its messages, a key of `DEFINITIONS`.
        model: a message with the marks of `marks` in place of its numbers.
        values: the numbers of all messages, shape (n, k), float64 or float32.
    """

    name: str
    kind: str
    model: dict[str, Any]
    values: Array

    def rows(self, nanoseconds: NDArray[np.int64]) -> Iterator[bytes]:
        """Every message in CDR, at its time."""
        code = _encoded(self.kind, self.model)
        # Numbers lie at multiples of their size after the first four bytes.
        head, body = code[:4], code[4:]
        row = np.zeros(-(-len(body) // 8) * 8, np.uint8)
        row[: len(body)] = np.frombuffer(body, np.uint8)
        rows = np.tile(row, (len(self.values), 1))
        kind = self.values.dtype
        rows.view(kind)[:, _places(row.view(kind), marks(self.values))] = self.values
        words = rows.view("<u4")
        for mark, stamp in zip(
            (SECOND, NANOSECOND), divmod(nanoseconds, 1_000_000_000), strict=True
        ):
            for place in np.flatnonzero(row.view("<u4") == mark):
                words[:, place] = stamp
        size, length, whole = rows.shape[1], len(body), rows.tobytes()
        for start in range(0, len(whole), size):
            yield head + whole[start : start + length]


def marks(values: Array) -> list[float]:
    """A number for each of a message's, unlike all others and exact in float32."""
    return [2.0**20 + 0.5 + i for i in range(values.shape[1])]


def _places(words: Array, wanted: list[float]) -> list[int]:
    return [int(np.flatnonzero(words == mark)[0]) for mark in wanted]


def _encoded(kind: str, message: dict[str, Any]) -> bytes:
    """One message in CDR, by the library: what it writes to a log, read back."""
    log = BytesIO()
    writer = optional_module("mcap_ros2.writer", "logs", "log").Writer(log)
    schema = writer.register_msgdef(full_name(kind), definition(kind))
    writer.write_message("/model", schema, message, log_time=0)
    writer.finish()
    log.seek(0)
    reader = optional_module("mcap.reader", "logs", "log").make_reader(log)
    ((_, _, written),) = reader.iter_messages()
    return written.data


def header() -> dict[str, Any]:
    """Time and frame."""
    return {"stamp": {"sec": SECOND, "nanosec": NANOSECOND}, "frame_id": WORLD}


def point(name: str, places: Array) -> Topic:
    """Points, shape (n, 3), or (n, 2) on the ground [m]."""
    values = in_space(places)
    x, y, z = marks(values)
    model = {"header": header(), "point": {"x": x, "y": y, "z": z}}
    return Topic(name, "geometry_msgs/PointStamped", model, values)


def pose(name: str, places: Array, turns: Array) -> Topic:
    """Places, shape (n, 3) [m], and unit quaternions (w, x, y, z), shape (n, 4)."""
    values = np.concatenate([places, turns], axis=1).astype("<f8")
    x, y, z, qw, qx, qy, qz = marks(values)
    turn = {"x": qx, "y": qy, "z": qz, "w": qw}
    model = {
        "header": header(),
        "pose": {"position": {"x": x, "y": y, "z": z}, "orientation": turn},
    }
    return Topic(name, "geometry_msgs/PoseStamped", model, values)


def force(name: str, forces: Array) -> Topic:
    """Forces without a moment, shape (n, 3), or (n, 2) if horizontal [N]."""
    values = in_space(forces)
    x, y, z = marks(values)
    none = {"x": 0.0, "y": 0.0, "z": 0.0}
    model = {"header": header(), "wrench": {"force": {"x": x, "y": y, "z": z}, "torque": none}}
    return Topic(name, "geometry_msgs/WrenchStamped", model, values)


def joints(
    name: str,
    names: Sequence[str],
    angles: Array,
    rates: Array,
    torques: Array,
) -> Topic:
    """Angles, rates and torques of joints, each of shape (n, m) [rad, rad/s, N m]."""
    values = np.concatenate([angles, rates, torques], axis=1).astype("<f8")
    count, numbers = len(names), marks(values)
    model = {
        "header": header(),
        "name": list(names),
        "position": numbers[:count],
        "velocity": numbers[count : 2 * count],
        "effort": numbers[2 * count :],
    }
    return Topic(name, "sensor_msgs/JointState", model, values)


def named_array(name: str, labels: str, values: Array) -> Topic:
    """Arrays of numbers, shape (n, k), float64 or float32, with their names in the layout."""
    count = values.shape[1]
    dimension = {"label": labels, "size": count, "stride": count}
    model = {"layout": {"dim": [dimension], "data_offset": 0}, "data": marks(values)}
    kind = f"std_msgs/Float{8 * values.itemsize}MultiArray"
    return Topic(name, kind, model, values)


def in_space(vectors: Array) -> NDArray[np.float64]:
    """Vectors with three components: on the ground if there are but two."""
    values = np.zeros((len(vectors), 3), "<f8")
    values[:, : vectors.shape[1]] = vectors
    return values


def drawn_topics(values: Mapping[str, Any]) -> list[Topic]:
    """Topics of a walk, a message a cycle.

    Args:
        values: fields of a `Rollout` by name.
    """
    observations, commands, body = values["observations"], values["commands"], values["body"]
    com, zmp = observations["com"], commands["zmp"]
    if body is None:
        height = np.full((len(com), 1), values["robot"].com_height)
        com = np.concatenate([com, height], axis=1)
    else:
        com, zmp = body.com, body.zmp
    topics = [
        point("/com", com),
        point("/dcm", observations["dcm"]),
        point("/dcm_plan", commands["dcm_plan"]),
        point("/zmp", zmp),
        point("/step_target", commands["step_location"]),
    ]
    if values["pushes"]:
        topics.append(force("/push", push_forces(values["pushes"], observations["time"])))
    return topics + (_feet(observations) if body is None else _body(body))


def push_forces(pushes: Sequence[Push], time: Array) -> Array:
    """The sum of the pushes that act, shape (n, 2) [N]."""
    forces = [acting_force(pushes, now) for now in time.tolist()]
    return np.array(forces, np.float64).reshape(-1, 2)


def _feet(observations: Array) -> list[Topic]:
    """Soles of a point mass: they stay level."""
    topics = []
    for name, side in zip(FEET, SIDES, strict=True):
        stands = observations["support_side"] == side
        place = observations["swing_foot"].copy()
        place[stands, :2], place[stands, 2] = observations["support_foot"][stands], 0.0
        turn = np.zeros((len(place), 3))
        turn[:, 2] = np.where(stands, observations["support_yaw"], observations["swing_yaw"])
        topics.append(pose(f"/{name}_foot/pose", place, quaternions(turn)))
    return topics


def _body(body: BodyTrace) -> list[Topic]:
    topics = [
        pose("/base/pose", body.position[:, :3], body.position[:, 3:7]),
        joints("/joint_states", body.joints, body.joint_angles, body.joint_velocities, body.torque),
    ]
    for foot, name in enumerate(FEET):
        turns = quaternions(body.sole_turn[:, foot])
        topics.append(pose(f"/{name}_foot/pose", body.sole_position[:, foot], turns))
        topics.append(force(f"/{name}_foot/floor_force", body.sole_force[:, foot]))
    return topics

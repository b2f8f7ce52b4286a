"""A rollout as a log of ROS 2 in one MCAP file, that standard viewers open.

What cannot be drawn is said in front, as JSON. Then cycle after cycle what viewers draw, and the
exact numbers as named arrays, of which the rollout is made again. Whatever is lost of the end of
such a file, the cycles before it are whole.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from itertools import product
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import optional_module
from surefoot.errors import FileError
from surefoot.robot.feet import FEET
from surefoot.rollout.files import RECORDS, Arrays, Parts, other_records, without_end
from surefoot.rollout.ros_messages import (
    Topic,
    definition,
    drawn_topics,
    full_name,
    named_array,
)
from surefoot.rollout.trace import ROWS

CHUNK = 128 * 1024
"""Size of the pieces that are compressed by themselves [B]; at most one is lost with its end."""

DESCRIPTION = "surefoot"
"""Name of the metadata that say what cannot be drawn."""

LAYOUT = 1
"""Version of what the metadata and the arrays are like."""

ROOT = "/surefoot/"
"""In front of the names of the arrays' topics."""

BODY64, BODY32, TIMES = "body", "body_float32", "decision_time"
NAMES_OF = {"observations": "observation", "commands": "command", "seen": "seen"}

WORDS: dict[tuple[int, ...], tuple[Sequence[str], ...]] = {
    (2,): ("xy",),
    (3,): ("xyz",),
    (2, 3): (FEET, "xyz"),
}
"""Names of the numbers in a row of such a shape; of others they are counted."""

Columns = dict[str, tuple[str, tuple[int, ...]]]
"""Of every field its dtype, and the shape of a row."""


def check_logging() -> None:
    """Tell early that logs can be neither written nor read.

    Raises:
        MissingExtraError: the extra `log` is not installed.
    """
    for module in ("mcap", "mcap_ros2", "zstandard"):
        optional_module(module, "logs", "log")


def write_log(path: Path, parts: Parts, values: Mapping[str, Any]) -> None:
    """Write the parts of a rollout.

    Args:
        path: file to write.
        parts: of the rollout.
        values: its fields by name, for what viewers draw.

    Raises:
        FileError: the file cannot be written.
        MissingExtraError: the extra `log` is not installed.
    """
    check_logging()
    topics, description = _exact_topics(parts)
    topics += drawn_topics(values)
    try:
        with path.open("wb") as file:
            _write(file, description, topics, parts.arrays["observations"]["time"])
    except OSError as error:
        raise FileError(
            "a file that can be written", f"{path}: {error}", "choose another place"
        ) from error


def _write(
    file: BinaryIO, description: dict[str, Any], topics: list[Topic], time: NDArray[np.float64]
) -> None:
    library = optional_module("mcap.writer", "logs", "log")
    writer = library.Writer(file, chunk_size=CHUNK)
    writer.start(profile="ros2")
    text = json.dumps(description)
    checksum = str(zlib.crc32(text.encode()))
    metadata = {"layout": str(LAYOUT), "description": text, "crc32": checksum}
    writer.add_metadata(DESCRIPTION, metadata)
    schemas: dict[str, int] = {}
    channels = []
    for topic in topics:
        if topic.kind not in schemas:
            text = definition(topic.kind).encode()
            schemas[topic.kind] = writer.register_schema(full_name(topic.kind), "ros2msg", text)
        channels.append(writer.register_channel(topic.name, "cdr", schemas[topic.kind]))
    stamps = np.maximum(np.rint(1e9 * time), 0.0).astype(np.int64)
    cycles = zip(*(topic.rows(stamps) for topic in topics), strict=True)
    for sequence, (stamp, messages) in enumerate(zip(stamps.tolist(), cycles, strict=True)):
        for channel, message in zip(channels, messages, strict=True):
            writer.add_message(channel, stamp, message, stamp, sequence)
    writer.finish()


def _exact_topics(parts: Parts) -> tuple[list[Topic], dict[str, Any]]:
    """All numbers of all cycles, and the description with what is left."""
    arrays, cycles = parts.arrays, len(parts.arrays["observations"])
    topics = []
    for name, rows in arrays.items():
        if name in NAMES_OF:
            columns = {field: rows[field] for field in rows.dtype.names or ()}
            topics.append(_packed(NAMES_OF[name], columns, "<f8"))
    times, constant, wide, narrow = {TIMES: arrays["decision_time"]}, {}, {}, {}
    for name, rows in parts.of_body.items():
        if name not in ROWS or len(rows) != cycles:
            constant[name] = [rows.dtype.str, list(rows.shape), rows.ravel().tolist()]
        elif rows.dtype == np.float32:
            narrow[name] = rows
        else:
            wide[name] = rows
    topics.append(_packed(TIMES, times, "<f8"))
    description = {
        "about": parts.about,
        "cycles": cycles,
        "seen": "seen" in arrays,
        "constant": constant,
        "columns": {BODY64: _columns(wide), BODY32: _columns(narrow)},
    }
    for name, columns, kind in ((BODY64, wide, "<f8"), (BODY32, narrow, "<f4")):
        if columns:
            topics.append(_packed(name, columns, kind))
    return topics, description


def _columns(arrays: Arrays) -> Columns:
    return {name: (rows.dtype.str, rows.shape[1:]) for name, rows in arrays.items()}


def _packed(name: str, arrays: Arrays, kind: str) -> Topic:
    """Arrays side by side; whole numbers up to 2^53 keep their value in float64."""
    rows = [array.reshape(len(array), -1).astype(kind) for array in arrays.values()]
    labels = _labels(_columns(arrays))
    return named_array(ROOT + name, labels, np.concatenate(rows, axis=1))


def _labels(columns: Columns) -> str:
    """Names of all numbers in a row: "time com.x com.y"."""
    names = []
    for name, (_, shape) in columns.items():
        words = WORDS.get(shape) or [map(str, range(size)) for size in shape]
        names += [".".join([name, *word]) for word in product(*words)]
    return " ".join(names)


@dataclass
class _Found:
    """What there is in a file: its description, data by topic, and what ended the reading."""

    metadata: dict[str, str] = field(default_factory=dict)
    data: dict[str, list[bytes]] = field(default_factory=dict)
    trouble: str = ""


def read_log(path: Path) -> tuple[Parts, str]:
    """The parts of a rollout, and what is to be said of the file; nothing if it is whole.

    Raises:
        FileError: there is no such file, there is no whole cycle in it, or something else.
        MissingExtraError: the extra `log` is not installed.
    """
    check_logging()
    try:
        found = _find(path.read_bytes())
    except OSError as error:
        raise FileError("a log that can be read", f"{path}: {error}", "name another file") from None
    try:
        description = _description(path, found)
        parts = _assembled(path, description, found)
        lost = int(description["cycles"]) - len(parts.arrays["observations"])
        if lost < 0:
            raise ValueError(f"{-lost} cycles too many")
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FileError(
            "a complete description of the walk", f"{path}: {error!r}", "run the walk again"
        ) from error
    remark = _remark(path, parts, lost, found.trouble)
    return (without_end(parts, lost) if lost else parts), remark


def _remark(path: Path, parts: Parts, lost: int, trouble: str) -> str:
    if not lost and not trouble:
        return ""
    state = f"{path} is not whole ({trouble or 'messages are missing'})"
    if not lost:
        return f"{state}, but all cycles of the walk are; save it again for viewers"
    time = parts.arrays["observations"]["time"]
    fell = ", which ended with a fall," if parts.about.get("fallen") else ""
    return (
        f"{state}: of the walk{fell} there are the first {len(time)} of {len(time) + lost} cycles, "
        f"up to {time[-1]:.3f} s; run it again for the rest"
    )


def _find(file: bytes) -> _Found:
    """Everything up to the end, or up to where the file is cut or damaged."""
    reading = optional_module("mcap.stream_reader", "logs", "log")
    records = optional_module("mcap.records", "logs", "log")
    errors = optional_module("mcap.exceptions", "logs", "log")
    compression = optional_module("zstandard", "logs", "log")
    cut = (errors.EndOfFile, errors.RecordLengthLimitExceeded, struct.error)
    damaged = (
        errors.McapError, compression.ZstdError, ValueError, KeyError, OverflowError, MemoryError
    )  # fmt: skip
    found, topics = _Found(), {}
    # No record is longer than its file: a damaged length asks for no memory.
    reader = reading.StreamReader(BytesIO(file), validate_crcs=True, record_size_limit=len(file))
    try:
        for record in reader.records:
            if isinstance(record, records.Message):
                found.data[topics[record.channel_id]].append(record.data)
            elif isinstance(record, records.Channel):
                topics[record.id] = record.topic
                found.data.setdefault(record.topic, [])
            elif isinstance(record, records.Metadata) and record.name == DESCRIPTION:
                found.metadata = record.metadata
    except cut:
        found.trouble = "its end is missing"
    except damaged as error:
        found.trouble = f"{type(error).__name__}: {error}"
    return found


def _description(path: Path, found: _Found) -> dict[str, Any]:
    text = found.metadata.get("description", "")
    if str(zlib.crc32(text.encode())) != found.metadata.get("crc32"):
        raise FileError(
            "a log that Rollout.save wrote",
            f"{path}: {found.trouble or 'a log of something else'}",
            "the file may be cut short: run the walk again with --save",
        )
    if found.metadata.get("layout") != str(LAYOUT):
        raise FileError(
            f"a log of layout {LAYOUT}",
            f"{path} with layout {found.metadata.get('layout')!r}",
            "read it with the version of Surefoot that wrote it",
        )
    return json.loads(text)


def _assembled(path: Path, description: dict[str, Any], found: _Found) -> Parts:
    """The parts of all cycles that are whole."""
    about = description["about"]
    names = [name for name in NAMES_OF if name != "seen" or description["seen"]]
    wanted: dict[str, Columns] = {NAMES_OF[name]: _of_records(RECORDS[name]) for name in names}
    wanted[TIMES] = {TIMES: ("<f8", ())}
    for name, columns in description["columns"].items():
        if columns:
            wanted[name] = {key: (kind, tuple(shape)) for key, (kind, shape) in columns.items()}
    cycles = min(len(found.data.get(ROOT + name, ())) for name in wanted)
    if not cycles:
        raise FileError(
            "at least one whole cycle", f"{path} with none", "run the walk again with --save"
        )
    got = {}
    for name, columns in wanted.items():
        kind = "<f4" if name == BODY32 else "<f8"
        got[name] = _unpacked(found.data[ROOT + name][:cycles], columns, kind)
        if got[name] is None:
            raise other_records(about, path)
    arrays = {}
    for name in names:
        arrays[name] = np.zeros(cycles, RECORDS[name])
        for key, rows in got[NAMES_OF[name]].items():
            arrays[name][key] = rows
    of_body = {
        name: np.array(flat, kind).reshape(shape)
        for name, (kind, shape, flat) in description["constant"].items()
    }
    of_body |= got.get(BODY64, {}) | got.get(BODY32, {})
    return Parts(about, {**arrays, "decision_time": got[TIMES][TIMES]}, of_body)


def _of_records(kind: np.dtype[np.void]) -> Columns:
    fields = kind.fields or {}
    return {name: (part[0].base.str, part[0].shape) for name, part in fields.items()}


def _unpacked(messages: list[bytes], columns: Columns, kind: str) -> Arrays | None:
    """The arrays that `_packed` laid side by side; None if these are others."""
    ros = optional_module("mcap_ros2.decoder", "logs", "log")
    records = optional_module("mcap.records", "logs", "log")
    of_kind = "std_msgs/Float32MultiArray" if kind == "<f4" else "std_msgs/Float64MultiArray"
    schema = records.Schema(1, definition(of_kind).encode(), "ros2msg", full_name(of_kind))
    first = ros.DecoderFactory().decoder_for("cdr", schema)(messages[0])
    count = len(first.data)
    if first.layout.dim[0].label != _labels(columns) or len(set(map(len, messages))) > 1:
        return None
    # The numbers are the last of a message.
    size = count * np.dtype(kind).itemsize
    tails = b"".join(message[-size:] for message in messages)
    rows, arrays, start = np.frombuffer(tails, kind).reshape(len(messages), count), {}, 0
    for name, (dtype, shape) in columns.items():
        width = int(np.prod(shape, dtype=int))
        part = rows[:, start : start + width].reshape(len(messages), *shape)
        arrays[name], start = np.ascontiguousarray(part, dtype), start + width
    return arrays

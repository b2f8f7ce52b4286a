"""The file of a rollout: what JSON can say of a walk and arrays, as a NumPy archive or a log.

A log for ROS 2 is the matter of `rollout.mcap_log`, which is loaded when one is read or written;
likewise `rollout.trace` with the walk of a body.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_writable
from surefoot.dcm.pushes import Push
from surefoot.errors import FileError, SurefootError
from surefoot.interface import COMMAND, OBSERVATION
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance

ARCHIVE, LOG = ".npz", ".mcap"
"""Endings."""

OF_BODY = "body_"
"""In front of the names of a body's arrays."""

PLAIN, DISTURBED, BODY, CUT = 1, 2, 3, 4
"""Versions of what there is to say: the least; with what a controller saw that was not the truth;
with a body; of a walk whose end is lost. A reader refuses what it does not know."""

OLD_SETTLED_ERROR = 0.01
"""Largest DCM error of a settled step where a file does not say it: once it was that of all [m]."""

RECORDS = {"observations": OBSERVATION, "seen": OBSERVATION, "commands": COMMAND}
"""Arrays of records, and what those are."""

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Parts:
    """A rollout taken apart.

    Attributes:
        about: what JSON can hold.
        arrays: observations, commands and decision_time, a row a cycle; also what was seen, if
            that was not the truth.
        of_body: likewise those of a body's trace, some of which are not of cycles.
    """

    about: dict[str, Any]
    arrays: Arrays
    of_body: Arrays


def parts_of(values: Mapping[str, Any]) -> Parts:
    """The fields of a `Rollout` by name, taken apart."""
    arrays: Arrays = {name: values[name] for name in ("observations", "commands", "decision_time")}
    if values["seen"] is not values["observations"]:
        arrays["seen"] = values["seen"]
    body, of_body = ({}, {}) if values["body"] is None else values["body"].parts()
    disturbance = values["disturbance"]
    about = {
        "format": _format(values),
        "version": values["version"],
        "robot": msgspec.to_builtins(values["robot"]),
        "controller": values["controller"],
        "controller_parameters": values["controller_parameters"],
        "velocities": values["velocities"],
        "pushes": [(push.start, push.duration, push.force) for push in values["pushes"]],
        "fallen": values["fallen"],
        "lost_cycles": values["lost_cycles"],
        "disturbance": None if disturbance is None else asdict(disturbance),
        "estimator": values["estimator"],
        "settled_error": values["settled_error"],
        "body": body,
    }
    return Parts(about, arrays, of_body)


def _format(values: Mapping[str, Any]) -> int:
    if values["lost_cycles"]:
        return CUT
    if values["body"] is not None:
        return BODY
    plain = values["disturbance"] is None and values["seen"] is values["observations"]
    return PLAIN if plain else DISTURBED


def values_of(parts: Parts, path: Path) -> dict[str, Any]:
    """The fields that `parts_of` took apart.

    Raises:
        FileError: something is missing or of another kind, or another version wrote it.
    """
    about, arrays = parts.about, parts.arrays
    if about.get("format") not in (PLAIN, DISTURBED, BODY, CUT):
        raise FileError(
            f"a rollout of format {PLAIN} to {CUT}",
            f"{path} with format {about.get('format')!r}",
            "read it with the version of Surefoot that wrote it",
        )
    if any(rows.dtype != RECORDS.get(name, rows.dtype) for name, rows in arrays.items()):
        raise other_records(about, path)
    try:
        return _values(parts)
    except (KeyError, TypeError, ValueError, msgspec.ValidationError, SurefootError) as error:
        raise FileError(
            "a complete description of the walk", f"{path}: {error!r}", "run the walk again"
        ) from error


def other_records(about: dict[str, Any], path: Path) -> FileError:
    """What to raise where the records are not those of this version."""
    return FileError(
        "the records of this version of Surefoot",
        f"{path}, written by version {about.get('version')!r}",
        "read it with that version",
    )


def _values(parts: Parts) -> dict[str, Any]:
    about = parts.about
    disturbance = about.get("disturbance")
    if disturbance is not None:
        offset = _pair(disturbance["com_offset"])
        disturbance = Disturbance(**{**disturbance, "com_offset": offset})
    return {
        "robot": msgspec.convert(about["robot"], Robot),
        "controller": about["controller"],
        "controller_parameters": about["controller_parameters"],
        "velocities": tuple((float(time), _pair(v)) for time, v in about["velocities"]),
        "pushes": tuple(
            Push(start, duration, _pair(force)) for start, duration, force in about["pushes"]
        ),
        "fallen": bool(about["fallen"]),
        "lost_cycles": int(about.get("lost_cycles", 0)),
        "disturbance": disturbance,
        "estimator": about.get("estimator", ""),
        "version": about["version"],
        "settled_error": float(about.get("settled_error", OLD_SETTLED_ERROR)),
        "body": _trace(parts) if about.get("body") else None,
        **parts.arrays,
    }


def _trace(parts: Parts) -> Any:
    trace = import_module("surefoot.rollout.trace")
    return trace.trace_of(parts.about["body"], parts.of_body)


def without_end(parts: Parts, lost: int) -> Parts:
    """The parts of a walk whose last cycles are lost, and with them whether and how it fell."""
    about = dict(parts.about)
    about["lost_cycles"] = int(about.get("lost_cycles", 0)) + lost
    about["format"], about["fallen"] = CUT, False
    if about.get("body"):
        about["body"] = {**about["body"], "fate": 0}
    return replace(parts, about=about)


def _pair(values: Any) -> tuple[float, float]:
    x, y = values
    return float(x), float(y)


def write_archive(path: Path, parts: Parts, beside: Arrays) -> None:
    """Write the parts of a rollout, and other arrays.

    Raises:
        FileError: the file cannot be written.
    """
    of_body = {OF_BODY + name: rows for name, rows in parts.of_body.items()}
    rows: dict[str, Any] = {**parts.arrays, **of_body, **beside}
    try:
        # Opened here, since np.savez would add an ending to "walk.NPZ".
        with path.open("wb") as file:
            np.savez_compressed(file, about=np.array(json.dumps(parts.about)), **rows)
    except OSError as error:
        raise FileError(
            "a file that can be written", f"{path}: {error}", "choose another place"
        ) from error


def read_archive(path: Path) -> Parts:
    """The parts of a rollout.

    Raises:
        FileError: there is no such file, it is cut short or damaged.
    """
    try:
        # Opened here, since np.load leaves its file open when it fails.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            about = json.loads(str(archive["about"]))
            if not isinstance(about, dict):
                raise ValueError(f"about is {about!r}")
            arrays = {name: archive[name] for name in ("observations", "commands", "decision_time")}
            if "seen" in archive:
                arrays["seen"] = archive["seen"]
            of_body = {
                name.removeprefix(OF_BODY): archive[name]
                for name in archive.files
                if name.startswith(OF_BODY)
            }
    except (OSError, zipfile.BadZipFile, EOFError, KeyError, ValueError) as error:
        raise FileError(
            "a rollout that Rollout.save wrote",
            f"{path}: {error}",
            "the file may be cut short: run the walk again with --save",
        ) from error
    return Parts(about, arrays, of_body)


def check_rollout_path(path: Path) -> None:
    """Refuse a file that no rollout could be written to, before the walk.

    Raises:
        FileError: another ending, or the file cannot be written.
        MissingExtraError: a log, and the extra `log` is not installed.
    """
    check_writable(path, (ARCHIVE, LOG))
    if _is_log(path):
        _log().check_logging()


def write_rollout(path: Path, values: Mapping[str, Any], beside: Arrays) -> None:
    """Write the fields of a `Rollout`; other arrays go into an archive only.

    Raises:
        FileError: another ending, or the file cannot be written.
        MissingExtraError: a log, and the extra `log` is not installed.
    """
    check_rollout_path(path)
    if _is_log(path):
        _log().write_log(path, parts_of(values), values)
    else:
        write_archive(path, parts_of(values), beside)


def read_rollout(path: Path) -> tuple[dict[str, Any], str]:
    """The fields of a `Rollout`, and what is to be said of the file; nothing if it is whole.

    Raises:
        FileError: there is no such file, it is damaged, or another version wrote it.
        MissingExtraError: a log, and the extra `log` is not installed.
    """
    parts, remark = _log().read_log(path) if _is_log(path) else (read_archive(path), "")
    return values_of(parts, path), remark


def _is_log(path: Path) -> bool:
    return path.suffix.lower() == LOG


def _log() -> Any:
    return import_module("surefoot.rollout.mcap_log")


def same_bits(one: Any, other: Any) -> bool:
    """Whether two fields are equal; arrays to the bit, so that NaN equals NaN."""
    if not isinstance(one, np.ndarray) or not isinstance(other, np.ndarray):
        return bool(one == other)
    alike = one.dtype == other.dtype and one.shape == other.shape
    return alike and one.tobytes() == other.tobytes()

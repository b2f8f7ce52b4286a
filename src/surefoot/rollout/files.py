"""The file of a rollout, of the kind that its ending names: a NumPy archive or a log for ROS 2."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from surefoot.checks import check_writable
from surefoot.rollout.archive import read_archive, write_archive
from surefoot.rollout.mcap_log import check_logging, read_log, write_log
from surefoot.rollout.parts import parts_of, values_of

ARCHIVE, LOG = ".npz", ".mcap"
"""Endings."""


def check_rollout_path(path: Path) -> None:
    """Refuse a file that no rollout could be written to, before the walk.

    Raises:
        FileError: another ending, or the file cannot be written.
        MissingExtraError: a log, and the extra `log` is not installed.
    """
    check_writable(path, (ARCHIVE, LOG))
    if _is_log(path):
        check_logging()


def write_rollout(path: Path, values: Mapping[str, Any]) -> None:
    """Write the fields of a `Rollout`.

    Raises:
        FileError: another ending, or the file cannot be written.
        MissingExtraError: a log, and the extra `log` is not installed.
    """
    check_rollout_path(path)
    if _is_log(path):
        write_log(path, parts_of(values), values)
    else:
        write_archive(path, parts_of(values))


def read_rollout(path: Path) -> tuple[dict[str, Any], str]:
    """The fields of a `Rollout`, and what is to be said of the file; nothing if it is whole.

    Raises:
        FileError: there is no such file, it is damaged, or another version wrote it.
        MissingExtraError: a log, and the extra `log` is not installed.
    """
    parts, remark = read_log(path) if _is_log(path) else (read_archive(path), "")
    return values_of(parts, path), remark


def _is_log(path: Path) -> bool:
    return path.suffix.lower() == LOG

"""A rollout as a NumPy archive of its arrays, with what else there is to say as JSON."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.errors import FileError
from surefoot.rollout.parts import Parts

OF_BODY = "body_"
"""In front of the names of a body's arrays."""


def write_archive(path: Path, parts: Parts) -> None:
    """Write the parts of a rollout.

    Raises:
        FileError: the file cannot be written.
    """
    of_body = {OF_BODY + name: rows for name, rows in parts.of_body.items()}
    rows: dict[str, Any] = {**parts.arrays, **of_body}
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

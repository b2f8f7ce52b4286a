"""The file of a rollout: a NumPy archive of its arrays, and what else there is to say as JSON."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.errors import FileError

PLAIN, DISTURBED, BODY = 1, 2, 3
"""Versions of the file layout: the least; with what a controller saw that was not the truth; with
a body. A reader refuses what it does not know."""

OF_BODY = "body_"
"""In front of the names of a body's arrays."""

Arrays = dict[str, NDArray[Any]]


def write_archive(path: Path, about: dict[str, Any], arrays: Arrays, of_body: Arrays) -> None:
    """Write the parts of a rollout.

    Raises:
        FileError: the file cannot be written.
    """
    rows: dict[str, Any] = {**arrays, **{OF_BODY + name: rows for name, rows in of_body.items()}}
    try:
        # Opened here, since np.savez would add an ending to "walk.NPZ".
        with path.open("wb") as file:
            np.savez_compressed(file, about=np.array(json.dumps(about)), **rows)
    except OSError as error:
        raise FileError(
            "a file that can be written", f"{path}: {error}", "choose another place"
        ) from error


def read_archive(path: Path) -> tuple[dict[str, Any], Arrays, Arrays]:
    """What else there is to say, the arrays, and those of a body.

    Raises:
        FileError: there is no such file, it is cut short or damaged, or another version wrote it.
    """
    try:
        # Opened here, since np.load leaves its file open when it fails.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            about = json.loads(str(archive["about"]))
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
    if not isinstance(about, dict) or about.get("format") not in (PLAIN, DISTURBED, BODY):
        found = about.get("format") if isinstance(about, dict) else about
        raise FileError(
            f"a rollout of format {PLAIN} to {BODY}",
            f"{path} with format {found!r}",
            "read it with the version of Surefoot that wrote it",
        )
    return about, arrays, of_body

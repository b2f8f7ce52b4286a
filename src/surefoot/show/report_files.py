"""Write the files of a report, or say where they cannot be written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from surefoot.errors import FileError


def write_files(
    files: Mapping[str, bytes], folder: Path, subfolders: Iterable[str] = ()
) -> list[Path]:
    """Write contents by name.

    Args:
        files: content by path inside the folder.
        folder: where to write; it exists, unless there are subfolders.
        subfolders: that are made first, with what leads to them.

    Returns:
        The files, in the order given.

    Raises:
        FileError: the folder cannot be written to.
    """
    try:
        for name in subfolders:
            (folder / name).mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            (folder / name).write_bytes(content)
    except OSError as error:
        raise FileError(
            "a folder that can be written to", f"{folder}: {error.strerror}", "choose another place"
        ) from error
    return [folder / name for name in files]

"""What every table says of itself to be made again: sources, libraries, machine and day."""

from __future__ import annotations

import hashlib
import platform
from datetime import date
from importlib import metadata
from pathlib import Path

from surefoot.compiling import source_stamp


def sources_stamp(*names: str) -> str:
    """All sources that a row depends on, as a hash: the kernels, and what asks the questions.

    Args:
        *names: of the files of this folder that ask.
    """
    digest = hashlib.sha256(source_stamp().encode())
    for name in names:
        digest.update((Path(__file__).parent / f"{name}.py").read_bytes())
    return digest.hexdigest()


def installed_version(name: str) -> str:
    """The version of a library, or "none"."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return "none"


def made_with(*libraries: str) -> dict[str, str]:
    """What a study was made with, where and when.

    Args:
        *libraries: whose versions matter.
    """
    return {
        "python": platform.python_version(),
        **{name: installed_version(name) for name in libraries},
        "machine": f"{platform.system()} {platform.machine()}",
        "date": date.today().isoformat(),
    }

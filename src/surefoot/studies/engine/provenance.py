"""What every table says of itself to be made again: sources, libraries, machine and day."""

from __future__ import annotations

import hashlib
import platform
from datetime import date
from importlib import metadata
from pathlib import Path

from surefoot.compiled import source_stamp


def sources_stamp(*folders: str) -> str:
    """All sources that a row depends on, as a hash: the kernels, the engine, and what asks.

    Args:
        *folders: of the studies that ask.
    """
    digest = hashlib.sha256(source_stamp().encode())
    studies = Path(__file__).parents[1]
    for folder in ("engine", *folders):
        for path in sorted((studies / folder).glob("*.py")):
            digest.update(f"{folder}/{path.name}".encode() + path.read_bytes())
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

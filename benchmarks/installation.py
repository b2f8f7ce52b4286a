"""How much room the core and all it needs take on a disk."""

from __future__ import annotations

import re
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

import surefoot
from figures import Figure, Report


def installation_figure(report: Report) -> Figure:
    """The installed size of Surefoot without extras and of everything it requires."""
    sizes = {name: _size(found) for name, found in _closure("surefoot").items()}
    # An editable installation records a link only: the package itself is where it is imported from.
    home = Path(surefoot.__file__).parent
    sizes["surefoot"] = sum(
        path.stat().st_size
        for path in home.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    )
    largest = sorted(sizes, key=lambda name: -sizes[name])
    report.facts["core installation"] = ", ".join(
        f"{name} {sizes[name] / 1e6:.3g} MB" for name in largest
    )
    report.extra["installed_bytes"] = sizes
    return Figure("core installation with all it requires", sum(sizes.values()) / 1e6, "MB")


def _closure(name: str) -> dict[str, Distribution]:
    """A package and what it requires without extras, as far as it is installed here."""
    found: dict[str, Distribution] = {}
    waiting = [name]
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        try:
            found[name] = distribution(name)
        except PackageNotFoundError:
            continue  # A requirement of another system or another Python.
        waiting += [
            _normalised(requirement)
            for requirement in found[name].requires or ()
            if not re.search(r"\bextra\s*==", requirement)
        ]
    return found


def _normalised(requirement: str) -> str:
    """The name in front of a requirement, as package indices spell it."""
    name = re.match(r"[A-Za-z0-9._-]+", requirement.strip())
    return re.sub(r"[-_.]+", "-", name.group() if name else "").lower()


def _size(found: Distribution) -> int:
    """The bytes of all files that a package has installed."""
    paths = [Path(str(found.locate_file(file))) for file in found.files or ()]
    return sum(path.stat().st_size for path in paths if path.is_file())

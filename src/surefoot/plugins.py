"""What packages bring to Surefoot by entry points, this one included: methods, commands, pictures.

An entry point is a name and a place, `module:object`; it is listed without an import.
"""

from __future__ import annotations

import hashlib
import tomllib
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from surefoot.errors import ParameterError

PACKAGE = Path(__file__).resolve().parent
"""The folder of Surefoot."""

PROJECT = PACKAGE.parents[1] / "pyproject.toml"
"""Of a checkout; an installed package has none there."""


@cache
def places(group: str) -> dict[str, str]:
    """The places `module:object` of a group of entry points, by name, sorted.

    In a checkout, Surefoot's own are those of `pyproject.toml`: the metadata of an editable
    installation are as old as the installation.

    Args:
        group: such as "surefoot.methods".
    """
    # Surefoot's own last: no other package takes a name of theirs.
    known = sorted((_is_own(one.value), one.name, one.value) for one in entry_points(group=group))
    found = {name: place for _, name, place in known}
    if PROJECT.is_file():
        project = tomllib.loads(PROJECT.read_text("utf-8")).get("project", {})
        if project.get("name") == "surefoot":
            own = project.get("entry-points", {}).get(group, {})
            others = {name: place for name, place in found.items() if not _is_own(place)}
            found = {**others, **own}
    return dict(sorted(found.items()))


def _is_own(place: str) -> bool:
    return place.partition(":")[0].split(".")[0] == "surefoot"


def load(place: str) -> Any:
    """The object at `module:object`.

    Raises:
        ParameterError: there is no such module, or no such object in it. A mistake inside the
            module is not hidden.
    """
    module, _, name = place.partition(":")
    if not all(part.isidentifier() for part in (*module.split("."), name)):
        raise ParameterError(
            "MODULE:OBJECT", repr(place), "write for example my_package.control:MyController"
        )
    try:
        home = import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise
        raise ParameterError(
            "MODULE:OBJECT of a module that can be imported",
            f"{place!r}, and there is no module {error.name!r}",
            "install its package, or set PYTHONPATH to its folder",
        ) from error
    if not hasattr(home, name):
        raise ParameterError(
            f"MODULE:OBJECT of an object in {module}", repr(place), "check its name"
        )
    return getattr(home, name)


@cache
def foreign_stamp(file: str) -> str:
    """The content of the package that a file belongs to, as a hash; "" for a file of Surefoot.

    Args:
        file: of the package, or a module on its own.
    """
    home = Path(file).resolve()
    if home.is_relative_to(PACKAGE) or not home.is_file():
        return ""
    while (home.parent / "__init__.py").is_file():
        home = home.parent
    return content(home.parent, [home])


def content(root: Path, homes: list[Path]) -> str:
    """The names and the content of files and of all Python files in folders, as a hash.

    Args:
        root: names count from here.
        homes: the files and folders.
    """
    digest = hashlib.sha256()
    for home in homes:
        for path in [home] if home.is_file() else sorted(home.rglob("*.py")):
            digest.update(str(path.relative_to(root)).encode() + path.read_bytes())
    return digest.hexdigest()

"""What packages bring to Surefoot by entry points, this one included: methods, commands, pictures.

An entry point is a name and a place, `module:object`; it is listed without an import.
"""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from surefoot.errors import ParameterError

PROJECT = Path(__file__).parents[2] / "pyproject.toml"
"""Of a checkout; an installed package has none there."""


@cache
def places(group: str) -> dict[str, str]:
    """The places `module:object` of a group of entry points, by name, sorted.

    In a checkout, Surefoot's own are those of `pyproject.toml`: the metadata of an editable
    installation are as old as the installation.

    Args:
        group: such as "surefoot.methods".
    """
    found = {one.name: one.value for one in entry_points(group=group)}
    if PROJECT.is_file():
        project = tomllib.loads(PROJECT.read_text("utf-8")).get("project", {})
        if project.get("name") == "surefoot":
            own = project.get("entry-points", {}).get(group, {})
            others = {name: place for name, place in found.items() if not _is_own(place)}
            found = {**own, **others}
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

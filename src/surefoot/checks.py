"""Refuse wrong arguments early, with a message that helps."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Sequence
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

from surefoot.errors import FileError, MissingExtraError, ParameterError

LARGEST_RATIO = 1e12
"""Of two weights of one cost: a double has 16 digits, and an answer should have some."""

LARGEST_WEIGHT = 1e100
"""And its inverse: products of weights beyond these are infinite, or 0."""


def optional_module(name: str, purpose: str, extra: str) -> Any:
    """Import a module that only an extra installs.

    Args:
        name: of the module, with dots if it is in a package.
        purpose: what it is needed for, for the message.
        extra: which extra of Surefoot installs it.

    Raises:
        MissingExtraError: it is not installed. An import that fails inside it is not hidden.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name != name.partition(".")[0]:
            raise
        raise MissingExtraError(purpose, extra) from error


def closest(name: str, known: Iterable[str], otherwise: str) -> str:
    """What to do about a name that is not known: the one that was perhaps meant, or `otherwise`."""
    close = difflib.get_close_matches(name, known, n=1)
    return f"did you mean `{close[0]}`?" if close else otherwise


def check_number(
    name: str,
    value: float,
    least: float,
    unit: str,
    *,
    above: bool = False,
    endless: bool = False,
) -> None:
    """Refuse a parameter that is no number, not finite, or too small; see also `check_most`.

    Args:
        name: what the caller calls it.
        value: what the caller gave.
        least: smallest value allowed.
        unit: of the value, for the message.
        above: whether `least` itself is refused too.
        endless: whether infinity is allowed.

    Raises:
        ParameterError: the value is not allowed.
    """
    good = isinstance(value, (int, float)) and (math.isfinite(value) or value == math.inf)
    if not good or value < least or (above and value == least) or not (endless or value < math.inf):
        bound = f"{'above' if above else 'of at least'} {least:g} "
        raise ParameterError(
            f"`{name}` {'' if least == -math.inf else bound}[{unit}]"
            f"{'' if endless else ', finite' if least == -math.inf else ' and finite'}",
            repr(value),
            "leave it out for the default",
        )


def check_most(name: str, value: float, most: float, unit: str, why: str) -> None:
    """Refuse a number, or its negative, that is larger than makes sense.

    Args:
        name: what the caller calls it.
        value: what the caller gave.
        most: largest value allowed.
        unit: of the value, for the message.
        why: more is refused.

    Raises:
        ParameterError: the value is too large.
    """
    if abs(value) > most:
        raise ParameterError(
            f"`{name}` of at most {most:g} [{unit}]: {why}", f"{value:g}", "choose a smaller one"
        )


def check_pair(name: str, value: tuple[float, float], least: float, unit: str) -> None:
    """Refuse a parameter that is no pair (x, y) of numbers of at least `least`.

    Raises:
        ParameterError: the value is not allowed.
    """
    if not isinstance(value, tuple) or len(value) != 2:
        raise ParameterError(
            f"`{name}` as a pair (x, y) [{unit}]", repr(value), "write for example (1.0, 1.0)"
        )
    for component in value:
        check_number(name, component, least, unit)


def check_weights(**weights: float | tuple[float, ...] | None) -> None:
    """Refuse weights of one cost that differ so much that the smaller ones are lost in rounding.

    Args:
        **weights: by name; each has been checked, and 0 and None are no weight.

    Raises:
        ParameterError: the largest is more than `LARGEST_RATIO` times the smallest.
    """
    every = {
        name: [each for each in (value if isinstance(value, tuple) else (value,)) if each]
        for name, value in weights.items()
    }
    known = [(each, name) for name, values in every.items() for each in values]
    if not known:
        return
    (least, small), (most, large) = min(known), max(known)
    if most > LARGEST_RATIO * least or not 1.0 / LARGEST_WEIGHT <= most <= LARGEST_WEIGHT:
        raise ParameterError(
            f"weights within a factor {LARGEST_RATIO:g} of each other",
            f"`{large}` {most:g} beside `{small}` {least:g}",
            "only their ratios matter: leave them out for the defaults, or bring them together",
        )


def check_seed(seed: int) -> None:
    """Refuse a seed of random numbers that is no whole number, negative or too large.

    Raises:
        ParameterError: the seed is not allowed.
    """
    whole = isinstance(seed, int) and not isinstance(seed, bool)
    if not whole or not 0 <= seed < 2**63:
        raise ParameterError(
            "`seed` as a whole number from 0 to 2^63 - 1", repr(seed), "0 is usual"
        )


def check_writable(path: Path, suffixes: Sequence[str]) -> None:
    """Refuse a file that could not be written, before the work whose result it is to hold.

    Nothing is created and nothing is changed.

    Args:
        path: the file.
        suffixes: the endings that are understood, each with its dot.

    Raises:
        FileError: another ending, no such directory, a directory of that name, or no permission.
    """
    if path.suffix.lower() not in suffixes:
        raise FileError(f"a path ending in {', '.join(suffixes)}", str(path), "rename the file")
    folder = path.parent
    if not folder.is_dir():
        raise FileError("a directory that exists", str(folder), "make it first, or choose another")
    try:
        is_folder = path.is_dir()
        if path.exists() and not is_folder:
            # Opened to append, and closed again: it can be replaced, and is unchanged.
            path.open("ab").close()
        elif not is_folder:
            # A file without a name proves that the directory can be written to, even to root.
            TemporaryFile(dir=folder).close()
    except OSError as error:
        raise FileError(
            "a file that can be written", f"{path}: {error.strerror}", "choose another place"
        ) from error
    if is_folder:
        raise FileError("a file", f"the directory {path}", "add a file name")


def check_folder(path: Path) -> None:
    """Refuse a folder that files could not be written into; it is made if only it is missing.

    Raises:
        FileError: its parent is missing too, it is a file, or there is no permission.
    """
    if not path.parent.is_dir():
        raise FileError(
            "a directory to make the folder in",
            str(path.parent),
            "make it first, or choose another",
        )
    try:
        path.mkdir(exist_ok=True)
        TemporaryFile(dir=path).close()
    except OSError as error:
        raise FileError(
            "a folder that can be written into", f"{path}: {error.strerror}", "choose another place"
        ) from error

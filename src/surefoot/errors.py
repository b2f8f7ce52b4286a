"""What Surefoot raises when the caller made a mistake: expected, got, do this.

A fall is not an error: it is the outcome of a rollout. Inside a control cycle nothing raises.
"""

from __future__ import annotations

import math


class SurefootError(Exception):
    """A mistake of the caller, told as what was expected, what came, and what to do.

    Args:
        expected: what would have been right.
        got: what came instead.
        remedy: what the caller can do about it.
    """

    def __init__(self, expected: str, got: str, remedy: str) -> None:
        self.expected, self.got, self.remedy = expected, got, remedy
        super().__init__(f"expected {expected}; got {got}; {remedy}")


class RobotError(SurefootError, ValueError):
    """A robot description is wrong: a file, a key, a type or a range."""


class VelocityError(SurefootError, ValueError):
    """A commanded velocity is not a pair of numbers or cannot be walked."""


class ParameterError(SurefootError, ValueError):
    """An argument of a controller, a problem, a push or a simulation is out of range."""


class FileError(SurefootError, OSError):
    """A file cannot be written, or what it holds cannot be read."""


class MissingExtraError(SurefootError, ImportError):
    """An optional part of Surefoot is not installed."""

    def __init__(self, purpose: str, extra: str) -> None:
        super().__init__(
            f"the extra '{extra}' for {purpose}",
            "an installation without it",
            f'run: pip install "surefoot[{extra}]"',
        )


def check_number(name: str, value: float, least: float, unit: str, *, above: bool = False) -> None:
    """Refuse a parameter that is no number, NaN, or too small; infinity is allowed.

    Args:
        name: what the caller calls it.
        value: what the caller gave.
        least: smallest value allowed.
        unit: of the value, for the message.
        above: whether `least` itself is refused too.

    Raises:
        ParameterError: the value is not allowed.
    """
    good = isinstance(value, (int, float)) and not math.isnan(value)
    if not good or value < least or (above and value == least):
        raise ParameterError(
            f"`{name}` {'above' if above else 'of at least'} {least:g} [{unit}]",
            repr(value),
            "leave it out for the default",
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

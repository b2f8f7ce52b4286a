"""The parameters of a control method by name: their defaults, their check, and a file of them.

A file of settings is TOML: `controller = "unified"`, and a table `[parameters]` of what is not as
by default. A pair is written as a list.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, get_args, get_type_hints

from surefoot.checks import closest
from surefoot.control.fields import search_intervals
from surefoot.control.registry import find_method, methods, settable
from surefoot.errors import FileError, ParameterError, SurefootError
from surefoot.interface import Controller
from surefoot.robot.robot import Robot

KEYS = ("controller", "parameters")
"""Of a file of settings."""


@dataclass(frozen=True)
class Settings:
    """A control method with parameters of one's own.

    Args:
        controller: key of the method, see `surefoot compare`.
        parameters: by name, those that are not as by default.

    Raises:
        ParameterError: no such method or parameter, or a value of another type.
    """

    controller: str
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        values = checked_settings(self.controller, self.parameters)
        object.__setattr__(self, "parameters", MappingProxyType(values))

    def make(self, robot: Robot, velocity: tuple[float, float]) -> Controller:
        """The controller for a robot and a velocity [m/s].

        Raises:
            SurefootError: its class refuses a value; the message names the parameter.
        """
        return with_settings(self.controller, robot, velocity, self.parameters)


def settings(key: str) -> dict[str, Any]:
    """What can be set in a control method, with its defaults.

    Raises:
        ParameterError: no such method.
    """
    one = find_method(key)
    return {**settable(one.make), **one.parameters}


def searched(key: str) -> dict[str, tuple[float, float]]:
    """Where `surefoot tune` searches the settings of a method, by name, as its fields say.

    A component of a pair has `.x` or `.y` behind.

    Raises:
        ParameterError: no such method.
    """
    return search_intervals(find_method(key).make)


def with_settings(
    key: str, robot: Robot, velocity: tuple[float, float], values: Mapping[str, Any]
) -> Controller:
    """The controller of a method with some parameters that are not as by default.

    Args:
        key: of the method.
        robot: whose gait it is.
        velocity: commanded (v_x, v_y) [m/s].
        values: by name; a pair may be a list, and a whole number stands for a float.

    Raises:
        ParameterError: no such method or parameter, or a value of another type.
        SurefootError: its class refuses a value; the message names the parameter.
    """
    return find_method(key).controller(robot, velocity, **checked_settings(key, values))


def checked_settings(key: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Values as the class of a method takes them.

    Raises:
        ParameterError: no such method or parameter, or a value of another type.
    """
    known, kinds = settings(key), get_type_hints(find_method(key).make)
    for name in values:
        if name not in known:
            raise ParameterError(
                f"a parameter of {key} ({', '.join(known)})",
                f"`{name}`",
                closest(name, known, "leave it out"),
            )
    return {name: _converted(name, value, kinds[name]) for name, value in values.items()}


def load_settings(path: str | Path) -> Settings:
    """Read a file of settings, such as `surefoot tune` writes.

    Args:
        path: of the TOML file.

    Raises:
        FileError: it cannot be read, or is no TOML.
        ParameterError: an unknown key, method or parameter, or a value of another type; the
            message names the file.
    """
    path = Path(path)
    try:
        table = tomllib.loads(path.read_text("utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(
            "a readable file of settings", f"{path}: {error}", "check the path and its permissions"
        ) from error
    except tomllib.TOMLDecodeError as error:
        raise FileError(
            "a TOML document", f"{path}: {error}", "correct the line that is named"
        ) from error
    try:
        return _parsed(table)
    except SurefootError as error:
        raise ParameterError(error.expected, f"{error.got} in {path}", error.remedy) from error


def settings_text(chosen: Settings, notes: Iterable[str] = ()) -> str:
    """A file of settings, with notes as comments above."""
    lines = [f"# {note}".rstrip() for note in notes]
    lines += [f'controller = "{chosen.controller}"', "", "[parameters]"]
    lines += [f"{name} = {_written(value)}" for name, value in chosen.parameters.items()]
    return "\n".join(lines) + "\n"


def _parsed(table: dict[str, Any]) -> Settings:
    for name in table:
        if name not in KEYS:
            # A parameter that stands outside its table is the usual slip.
            usual = name in {known for one in methods() for known in settings(one.key)}
            raise ParameterError(
                'the keys `controller = "unified"` and a table [parameters]',
                f"unknown key `{name}`",
                "put it below [parameters]" if usual else closest(name, KEYS, "remove it"),
            )
    key, values = table.get("controller"), table.get("parameters", {})
    if not isinstance(key, str):
        raise ParameterError(
            '`controller` as the name of a method, for example "unified"',
            "none" if key is None else repr(key),
            'write controller = "unified" above [parameters]',
        )
    if not isinstance(values, dict):
        raise ParameterError(
            "`parameters` as a table", repr(values), "write [parameters] on a line of its own"
        )
    return Settings(key, values)


def _converted(name: str, value: Any, kind: Any) -> Any:
    """A value of the type that the class has for it.

    Raises:
        ParameterError: it is of another type, or not a number.
    """
    kinds = get_args(kind)
    if type(None) in kinds:
        if value is None:
            return None
        (kind,) = [one for one in kinds if one is not type(None)]
        kinds = ()
    if kinds:
        if not isinstance(value, (list, tuple)) or len(value) != len(kinds):
            numbers = ", ".join("1.0" for _ in kinds)
            raise ParameterError(
                f"`{name}` as a list of {len(kinds)} numbers", repr(value), f"write [{numbers}]"
            )
        return tuple(
            _converted(f"{name}[{place}]", one, of)
            for place, (one, of) in enumerate(zip(value, kinds, strict=True))
        )
    if kind is bool:
        if not isinstance(value, bool):
            raise ParameterError(f"`{name}` as true or false", repr(value), "write true or false")
        return value
    good = (int,) if kind is int else (int, float)
    if isinstance(value, bool) or not isinstance(value, good) or math.isnan(value):
        what = "a whole number" if kind is int else "a number"
        raise ParameterError(f"`{name}` as {what}", repr(value), "leave it out for the default")
    return kind(value)


def _written(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(_written(one) for one in value)}]"
    # TOML's booleans are lower case; its floats and infinity are Python's.
    return str(value).lower() if isinstance(value, bool) else repr(value)

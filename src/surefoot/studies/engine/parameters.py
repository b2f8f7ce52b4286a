"""The numbers that a study can vary, with the unit and the range that their owner has.

Of a control method these stand on its fields (`control.fields.setting`); of a robot, its gait and a
disturbance in the documentation of their class, as `name: words [unit].`
"""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, is_dataclass
from typing import Any

from surefoot.checks import check_number
from surefoot.control.fields import declared
from surefoot.control.registry import find_method
from surefoot.control.settings import settings
from surefoot.errors import ParameterError

PAIR = ("x", "y")
"""Names of the components of a pair."""

_ENTRY = re.compile(r"^ {4}(\w+): (.*(?:\n {8}.*)*)", re.MULTILINE)
_UNIT = re.compile(r"\[([^\]]+)\]")


@dataclass(frozen=True)
class Parameter:
    """A number that can be varied, or a pair of them.

    Attributes:
        name: of its owner's; a component has its own name behind a dot.
        unit: of its values; empty if none is known, as of a whole number.
        parts: names of the components of a pair, none of a single value.
        whole: whether it is a whole number.
        low: smallest value [unit].
        high: largest value [unit].
    """

    name: str
    unit: str = ""
    parts: tuple[str, ...] = ()
    whole: bool = False
    low: float = -math.inf
    high: float = math.inf

    @property
    def log(self) -> bool:
        """Whether factors count rather than differences: in a range of positive values."""
        return self.low > 0.0


def method_parameters(key: str) -> dict[str, Parameter]:
    """What can be set in a control method, by name; pairs as wholes.

    Raises:
        ParameterError: no such method.
    """
    make = find_method(key).make
    known = declared(make) if is_dataclass(make) else {}
    found = {}
    for name, usual in settings(key).items():
        pair = isinstance(usual, tuple) and len(usual) == len(PAIR)
        unit = known[name].unit if name in known else ""
        found[name] = Parameter(name, unit, PAIR if pair else ())
    return found


def documented_parameters(owner: type) -> dict[str, Parameter]:
    """The numbers and pairs of a class by name, as its documentation describes them.

    Args:
        owner: its docstring has a line `name: words [unit].` for each.
    """
    entries = dict(_ENTRY.findall(inspect.getdoc(owner) or ""))
    found = {}
    for name, kind in inspect.get_annotations(owner).items():
        if kind in ("float", "int", "tuple[float, float]"):
            unit = (_UNIT.findall(entries.get(name, "")) or [""])[-1]
            pair = PAIR if kind.startswith("tuple") else ()
            found[name] = Parameter(name, unit, pair, whole=kind == "int")
    return found


def component(values: Mapping[str, Any], name: str) -> float:
    """A value by its name, or half of a pair, which has `.x` or `.y` behind its name."""
    whole, _, part = name.partition(".")
    return float(values[whole][PAIR.index(part)] if part else values[whole])


def chosen_values(
    room: str, known: Mapping[str, Parameter], given: Mapping[str, Any], usual: Mapping[str, Any]
) -> dict[str, Any]:
    """The values that are given; of a pair of which a half is given both.

    Args:
        room: what the parameters belong to, for messages.
        known: the parameters by name.
        given: values by name; half of a pair has the name of that part behind a dot.
        usual: of pairs, where a half is not given.

    Raises:
        ParameterError: a pair is none, or a half is no finite number.
    """
    found = {}
    for name, one in known.items():
        if any(f"{name}.{part}" in given for part in one.parts):
            found[name] = chosen_pair(room, one, given, usual[name])
        elif name in given:
            value = given[name]
            found[name] = tuple(value) if isinstance(value, list) else value
    return found


def chosen_pair(
    room: str, one: Parameter, given: Mapping[str, Any], usual: Any
) -> tuple[float, float]:
    """A pair that is given as a whole or by halves; see `chosen_values`."""
    name, pair = f"{room}.{one.name}", given.get(one.name, usual)
    if not isinstance(pair, (list, tuple)) or len(pair) != 2:
        raise ParameterError(f"`{name}` as a pair", repr(pair), "write [0.5, 0.0]")
    x, y = (given.get(f"{one.name}.{part}", own) for part, own in zip(one.parts, pair, strict=True))
    for half in (x, y):
        check_number(name, half, -math.inf, one.unit)
    return float(x), float(y)

"""The numbers that a study can vary, with the unit and the range that their owner has.

Of a control method these stand on its fields (`control.fields.setting`); of a robot, its gait and a
disturbance in the documentation of their class, as `name: words [unit].`
"""

from __future__ import annotations

import inspect
import math
import re
from dataclasses import dataclass, is_dataclass

from surefoot.control.fields import declared
from surefoot.control.registry import find_method
from surefoot.control.settings import settings

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

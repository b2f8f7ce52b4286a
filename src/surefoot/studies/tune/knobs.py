"""The knobs of a control method: which of its parameters are searched, and how far.

A component of a pair is a knob of its own, `offset_weight.x`. Of weights that only count by their
ratios one is left alone: the first on the step vector.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from surefoot.control.registry import methods
from surefoot.control.settings import searched, settings, with_settings
from surefoot.errors import ParameterError
from surefoot.robot.robot import Robot, load_robot

DIGITS = 3
"""A value that is tried is rounded to these digits: it is to be read and copied."""

OF_THE_QUESTION = ("step_duration", "period")
"""Parameters that change what is measured rather than how well it is answered."""

COMPONENTS = ("x", "y")

VELOCITY = (0.5, 0.0)
"""At which the paper's biped walks, if defaults are asked for without a robot [m/s]."""


@dataclass(frozen=True)
class Knob:
    """A parameter of a method, or a component of one, with the range in which it is searched.

    Attributes:
        name: of the parameter; a component of a pair has `.x` or `.y` behind.
        low: smallest value; the range is logarithmic if it is positive [unit of the parameter].
        high: largest value [unit of the parameter].
    """

    name: str
    low: float
    high: float

    @property
    def log(self) -> bool:
        """Whether factors count rather than differences."""
        return self.low > 0.0

    def read(self, parameters: Mapping[str, Any]) -> float:
        """Its value in the parameters of a method."""
        name, _, component = self.name.partition(".")
        value = parameters[name]
        return float(value[COMPONENTS.index(component)] if component else value)


def usual_knobs(key: str) -> tuple[Knob, ...]:
    """What is searched in a method unless one is told otherwise: what its fields say.

    Raises:
        ParameterError: no such method.
    """
    return tuple(Knob(name, *ends) for name, ends in searched(key).items())


def knobs_of(
    key: str,
    asked: Iterable[str] = (),
    robot: Robot | None = None,
    velocity: tuple[float, float] = VELOCITY,
) -> tuple[Knob, ...]:
    """The knobs that are to be searched.

    Args:
        key: of the method.
        asked: `NAME` or `NAME=LOW:HIGH`; only these are searched. The usual ones if none.
        robot: whose defaults count; the paper's biped if None.
        velocity: of its gait [m/s].

    Raises:
        ParameterError: a method without knobs, an unknown one, or a range that is none or leaves
            out the default.
    """
    usual = {knob.name: knob for knob in usual_knobs(key)}
    texts = list(asked)
    if not usual:
        able = [one.key for one in methods() if usual_knobs(one.key)]
        raise ParameterError(
            f"a compiled method with gains ({', '.join(able)})",
            repr(key),
            "choose one of these; a slow method takes too long to be tried often",
        )
    if not texts:
        return tuple(usual.values())
    defaults = _defaults(key, robot, velocity)
    possible = [*usual, *(name for name in _settable(defaults) if name not in usual)]
    knobs = [_knob(text, usual, possible) for text in texts]
    names = [knob.name for knob in knobs]
    if len(set(names)) < len(names):
        raise ParameterError("every --knob once", ", ".join(names), "leave the second one out")
    for knob in knobs:
        value = knob.read(defaults)
        if not knob.low <= value <= knob.high:
            raise ParameterError(
                f"a range of `{knob.name}` with its default {value:g} in it, where the search "
                "begins",
                f"{knob.low:g}:{knob.high:g}",
                "widen the range",
            )
    return tuple(knobs)


def parameters_of(
    key: str,
    knobs: Iterable[Knob],
    values: Mapping[str, float],
    robot: Robot | None = None,
    velocity: tuple[float, float] = VELOCITY,
) -> dict[str, float | tuple[float, ...]]:
    """The parameters of a method that differ from its defaults, with knobs at these values.

    Robot and velocity as for `knobs_of`.
    """
    defaults = _defaults(key, robot, velocity)
    changed: dict[str, Any] = {}
    for knob in knobs:
        if values[knob.name] == knob.read(defaults):
            continue
        name, _, component = knob.name.partition(".")
        if component:
            pair = list(changed.get(name, defaults[name]))
            pair[COMPONENTS.index(component)] = values[knob.name]
            changed[name] = tuple(pair)
        else:
            changed[name] = values[knob.name]
    return changed


def defaults_of(
    key: str,
    knobs: Iterable[Knob],
    robot: Robot | None = None,
    velocity: tuple[float, float] = VELOCITY,
) -> dict[str, float]:
    """The default of every knob; robot and velocity as for `knobs_of`."""
    defaults = _defaults(key, robot, velocity)
    return {knob.name: knob.read(defaults) for knob in knobs}


def _defaults(key: str, robot: Robot | None, velocity: tuple[float, float]) -> dict[str, Any]:
    """What a method has where nothing is set: some of it follows from the robot and its gait."""
    made = with_settings(key, robot or load_robot("paper-biped"), velocity, {})
    return {name: getattr(made, name) for name in settings(key)}


def rounded(value: float) -> float:
    """A value with as many digits as one wants to read."""
    return float(f"{value:.{DIGITS}g}")


def _settable(defaults: Mapping[str, Any]) -> list[str]:
    """The names of everything that is a number, and no part of the question."""
    names = []
    for name, value in defaults.items():
        if name in OF_THE_QUESTION:
            continue
        if isinstance(value, tuple) and len(value) == len(COMPONENTS):
            names += [f"{name}.{component}" for component in COMPONENTS]
        elif isinstance(value, float):
            names.append(name)
    return names


def _knob(text: str, usual: Mapping[str, Knob], possible: list[str]) -> Knob:
    name, given, ends = text.partition("=")
    if name not in possible:
        close = difflib.get_close_matches(name, possible, n=1)
        raise ParameterError(
            f"a knob ({', '.join(possible)})",
            repr(name),
            f"did you mean `{close[0]}`?" if close else "choose one of these",
        )
    if not given:
        if name in usual:
            return usual[name]
        raise ParameterError(
            f"a range for `{name}`, which has none of its own",
            repr(text),
            f"write --knob {name}=LOW:HIGH",
        )
    low, high = _range(text, ends)
    return Knob(name, low, high)


def _range(text: str, ends: str) -> tuple[float, float]:
    try:
        low, high = (float(end) for end in ends.split(":"))
    except ValueError:
        low = high = math.nan
    if not (math.isfinite(low) and math.isfinite(high) and 0.0 <= low < high):
        raise ParameterError(
            "NAME=LOW:HIGH with two numbers, 0 <= LOW < HIGH",
            repr(text),
            "write for example --knob dcm_gain=1:30",
        )
    return low, high

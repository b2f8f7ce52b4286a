"""The parameters of a control method that are searched, and how far: what its fields say.

A component of a pair is a parameter of its own, `offset_weight.x`. Of weights that only count by
their ratios one is left alone: the first on the step vector.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from surefoot.checks import closest
from surefoot.control.registry import methods
from surefoot.control.settings import searched, settings, with_settings
from surefoot.errors import ParameterError
from surefoot.robot.robot import Robot
from surefoot.studies.engine.parameters import PAIR, Parameter, method_parameters

DIGITS = 3
"""A value that is tried is rounded to these digits: it is to be read and copied."""

OF_THE_QUESTION = ("step_duration", "period")
"""Settings that change what is measured rather than how well it is answered."""


def usual_parameters(key: str) -> tuple[Parameter, ...]:
    """What is searched in a method unless another choice is made.

    Raises:
        ParameterError: no such method.
    """
    return tuple(_within(key, name, *ends) for name, ends in searched(key).items())


def _within(key: str, name: str, low: float, high: float) -> Parameter:
    """A setting of a method, or a component of one, with the interval in which it is searched."""
    known = method_parameters(key)[name.partition(".")[0]]
    return replace(known, name=name, parts=(), low=low, high=high)


def chosen_parameters(
    key: str, asked: Iterable[str], robot: Robot, velocity: tuple[float, float]
) -> tuple[Parameter, ...]:
    """The parameters that are to be searched.

    Args:
        key: of the method.
        asked: `NAME` or `NAME=LOW:HIGH`; only these are searched. The usual ones if none.
        robot: whose defaults count.
        velocity: of its gait [m/s].

    Raises:
        ParameterError: a method without parameters to search, an unknown one, or a range that is
            none or leaves out the default.
    """
    usual = {one.name: one for one in usual_parameters(key)}
    texts = list(asked)
    if not usual:
        able = [one.key for one in methods() if usual_parameters(one.key)]
        raise ParameterError(
            f"a compiled method with gains ({', '.join(able)})",
            repr(key),
            "choose one of these; a slow method takes too long to be tried often",
        )
    if not texts:
        return tuple(usual.values())
    defaults = default_settings(key, robot, velocity)
    possible = [*usual, *(name for name in _numbers(defaults) if name not in usual)]
    found = [_parsed(key, text, usual, possible) for text in texts]
    names = [one.name for one in found]
    if len(set(names)) < len(names):
        raise ParameterError("every --knob once", ", ".join(names), "leave the second one out")
    for one in found:
        value = read(one, defaults)
        if not one.low <= value <= one.high:
            raise ParameterError(
                f"a range of `{one.name}` with its default {value:g} in it, where the search "
                "begins",
                f"{one.low:g}:{one.high:g}",
                "widen the range",
            )
    return tuple(found)


def default_settings(key: str, robot: Robot, velocity: tuple[float, float]) -> dict[str, Any]:
    """What a method has where nothing is set: some of it follows from the robot and its gait.

    Raises:
        SurefootError: the method cannot control this robot.
    """
    made = with_settings(key, robot, velocity, {})
    return {name: getattr(made, name) for name in settings(key)}


def read(parameter: Parameter, values: Mapping[str, Any]) -> float:
    """The value of a parameter in the settings of a method."""
    name, _, component = parameter.name.partition(".")
    return float(values[name][PAIR.index(component)] if component else values[name])


def changed_settings(
    parameters: Iterable[Parameter], values: Mapping[str, float], defaults: Mapping[str, Any]
) -> dict[str, float | tuple[float, ...]]:
    """The settings of a method that differ from its defaults, with parameters at these values."""
    changed: dict[str, Any] = {}
    for one in parameters:
        if values[one.name] == read(one, defaults):
            continue
        name, _, component = one.name.partition(".")
        if component:
            pair = list(changed.get(name, defaults[name]))
            pair[PAIR.index(component)] = values[one.name]
            changed[name] = tuple(pair)
        else:
            changed[name] = values[one.name]
    return changed


def rounded(value: float) -> float:
    """A value with as many digits as one wants to read."""
    return float(f"{value:.{DIGITS}g}")


def _numbers(defaults: Mapping[str, Any]) -> list[str]:
    """The names of everything that is a number, and no part of the question."""
    names = []
    for name, value in defaults.items():
        if name in OF_THE_QUESTION:
            continue
        if isinstance(value, tuple) and len(value) == len(PAIR):
            names += [f"{name}.{component}" for component in PAIR]
        elif isinstance(value, float):
            names.append(name)
    return names


def _parsed(key: str, text: str, usual: Mapping[str, Parameter], possible: list[str]) -> Parameter:
    name, given, ends = text.partition("=")
    if name not in possible:
        raise ParameterError(
            f"a knob ({', '.join(possible)})",
            repr(name),
            closest(name, possible, "choose one of these"),
        )
    if given:
        return _within(key, name, *_interval(text, ends))
    if name not in usual:
        raise ParameterError(
            f"a range for `{name}`, which has none of its own",
            repr(text),
            f"write --knob {name}=LOW:HIGH",
        )
    return usual[name]


def _interval(text: str, ends: str) -> tuple[float, float]:
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

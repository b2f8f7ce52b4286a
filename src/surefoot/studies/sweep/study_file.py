"""A sweep's TOML file: which parameters take which values, and what is measured.

    measure = "push-limit"
    controller = "unified"
    sampling = "grid"

    [set]
    robot.swing.max_speed = 3.0

    [vary]
    controller.dcm_gain = { from = 1.0, to = 30.0, count = 8, scale = "log" }
    push.angle = [0.0, 90.0, 180.0, 270.0]

A parameter is named by what it belongs to and its own name: `robot.mass`, `gait.step_x.max`,
`controller.dcm_gain`, `push.impulse`, `disturbance.dcm_noise`, and `plant.mass` for the robot that
is really moved. A pair is set as a list, or one half by `.x` or `.y`, that of a range by `.min` or
`.max`.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec

from surefoot.errors import FileError, ParameterError
from surefoot.robot.robot import load_robot
from surefoot.studies.sweep.parameters import check_parameter
from surefoot.studies.sweep.question import Normal, Quantity, Range, Sampling, Sweep, Values

USUAL_SAMPLES = 100


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True, rename={"fixed": "set"}):
    vary: dict[str, Any]
    title: str = ""
    measure: Quantity = "walk"
    robot: str = "paper-biped"
    controller: str = "unified"
    sampling: Sampling = "grid"
    samples: int | None = None
    seed: int = 0
    step: float = 1.0
    fixed: dict[str, Any] = {}


def load_study(path: str | Path) -> Sweep:
    """Read a study from a TOML file.

    Raises:
        FileError: it cannot be read, or is no TOML.
        RobotError: the robot cannot be read.
        ParameterError: an unknown key or parameter, or values that make no sense; the message
            names the file.
    """
    path = Path(path)
    try:
        text = path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(
            "a readable study", f"{path}: {error}", "check the path and its permissions"
        ) from error
    try:
        return parse_study(text, str(path))
    except tomllib.TOMLDecodeError as error:
        raise FileError(
            "a TOML document", f"{path}: {error}", "correct the line that is named"
        ) from error


def parse_study(text: str, origin: str = "the study") -> Sweep:
    """A study from TOML text.

    Args:
        text: the document.
        origin: its path, or what to call it in messages; a robot's file lies beside it.

    Raises:
        TOMLDecodeError: it is no TOML.
        ParameterError: see `load_study`.
    """
    table = tomllib.loads(text)
    for key in ("set", "vary"):
        if isinstance(table.get(key), dict):
            table[key] = _flat_names(table[key])
    try:
        file = msgspec.convert(table, _File)
    except msgspec.ValidationError as error:
        keys = ", ".join("set" if name == "fixed" else name for name in _File.__struct_fields__)
        raise ParameterError(
            f"a study of the keys {keys}, each with its type",
            f"{origin}: {error}",
            "compare with the example in docs/sweeps.md",
        ) from error
    problem = _problem(file)
    if problem is not None:
        raise ParameterError(problem[0], f"{problem[1]} in {origin}", problem[2])
    vary = {name: _values(name, value, origin) for name, value in file.vary.items()}
    for name, values in vary.items():
        _check_for(file.sampling, name, values, origin)
    for name in (*file.fixed, *vary):
        check_parameter(file.controller, name, origin)
    source = file.robot
    if source.endswith(".toml"):
        source = str(Path(origin).parent / source)
    return Sweep(
        robot=load_robot(source),
        source=source,
        title=file.title or Path(origin).stem,
        measures=file.measure,
        controller=file.controller,
        sampling=file.sampling,
        samples=USUAL_SAMPLES if file.samples is None else file.samples,
        seed=file.seed,
        step=file.step,
        fixed=file.fixed,
        vary=vary,
    )


def _flat_names(table: Mapping[str, Any], path: str = "") -> dict[str, Any]:
    """Nested TOML tables by dotted name, down to values, ranges and distributions."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        name = f"{path}{key}"
        if (
            isinstance(value, dict)
            and value
            and not {"from", "to", "mean", "deviation"} & set(value)
        ):
            flat |= _flat_names(value, f"{name}.")
        else:
            flat[name] = value
    return flat


def _problem(file: _File) -> tuple[str, str, str] | None:
    if not file.vary:
        return "at least one parameter in [vary]", "none", "name one, such as push.impulse"
    both = sorted(set(file.vary) & set(file.fixed))
    if both:
        return "a parameter in [set] or in [vary]", f"{both[0]} in both", "leave one out"
    if file.sampling == "grid" and file.samples is not None:
        return "no `samples` of a grid", f"{file.samples}", "give each range a `count`"
    if file.samples is not None and file.samples < 1:
        return "`samples` of at least 1", f"{file.samples}", "100 is usual"
    if file.measure == "push-limit" and "push.impulse" in (*file.fixed, *file.vary):
        return "no `push.impulse`, since a push limit tries them all", "one", "remove it"
    if not 0 <= file.seed < 2**63:
        return "`seed` from 0 to 2^63 - 1", f"{file.seed}", "0 is usual"
    if not (math.isfinite(file.step) and file.step > 0.0):
        return "`step` above 0 [N s]", f"{file.step}", "1 is usual"
    return None


def _values(name: str, value: Any, origin: str) -> Values:
    """A list, a range or a normal distribution.

    Raises:
        ParameterError: it is none of these, or makes no sense.
    """
    if isinstance(value, list):
        if not value or any(one in value[:place] for place, one in enumerate(value)):
            raise ParameterError(
                f"`{name}` as a list of different values", f"{value} in {origin}", "name some"
            )
        if len(set(map(_kind, value))) > 1 or _kind(value[0]) == "":
            raise ParameterError(
                f"`{name}` as a list of numbers, of pairs of numbers, or of true and false",
                f"{value} in {origin}",
                "give all of them the same kind",
            )
        return value
    try:
        kind = Normal if isinstance(value, dict) and "mean" in value else Range
        made = msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        raise ParameterError(
            f"`{name}` as a list, {{ from = 1.0, to = 2.0 }} or {{ mean = 1.0, deviation = 0.1 }}",
            f"{value!r} in {origin}: {error}",
            "write one of these",
        ) from error
    problem = made.problem()
    if problem:
        raise ParameterError(f"`{name}` with {problem}", f"{value} in {origin}", "correct it")
    return made


def _kind(value: Any) -> str:
    """Of what kind a value of a list is, nothing if a parameter has no such values."""
    if isinstance(value, bool):
        return "truth"
    if isinstance(value, (int, float)):
        return "number"
    if isinstance(value, list) and len(value) == 2:
        return "pair" if all(_kind(one) == "number" for one in value) else ""
    return ""


def _check_for(sampling: Sampling, name: str, values: Values, origin: str) -> None:
    if sampling == "grid":
        if isinstance(values, Normal):
            raise ParameterError(
                f"`{name}` as a list or a range, since a grid draws nothing",
                f"a distribution in {origin}",
                'write sampling = "monte-carlo", or a list',
            )
        if isinstance(values, Range) and values.count is None:
            raise ParameterError(
                f"`{name}` with a `count`, since a grid has so many of its values",
                f"none in {origin}",
                "add count = 5",
            )
    elif isinstance(values, Range) and values.count is not None:
        raise ParameterError(
            f"`{name}` without a `count`, since it is drawn",
            f"{values.count} in {origin}",
            'remove it, or write sampling = "grid"',
        )

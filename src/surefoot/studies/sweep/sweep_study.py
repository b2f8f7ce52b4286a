"""What a sweep asks, read from a TOML file: which parameters take which values, what is measured.

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
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import msgspec

from surefoot.errors import FileError, ParameterError
from surefoot.studies.sweep.sweep_parameters import check_parameter, flat_names

USUAL_SAMPLES = 100


class Range(msgspec.Struct, frozen=True, forbid_unknown_fields=True, rename={"low": "from"}):
    """Values between two ends.

    Attributes:
        low: `from` in a file.
        to: the other end.
        count: of a grid, both ends included.
        scale: even steps, or even factors.
    """

    low: float
    to: float
    count: int | None = None
    scale: Literal["linear", "log"] = "linear"

    def problem(self) -> str:
        """What is wrong with it, or nothing."""
        if not (math.isfinite(self.low) and math.isfinite(self.to) and self.low < self.to):
            return "`from` below `to`, both finite"
        if self.scale == "log" and self.low <= 0.0:
            return '`from` above 0 with scale = "log"'
        if self.count is not None and self.count < 2:
            return "a `count` of at least 2"
        return ""


class Normal(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Values that are drawn around a mean."""

    mean: float
    deviation: float

    def problem(self) -> str:
        """What is wrong with it, or nothing."""
        good = math.isfinite(self.mean) and math.isfinite(self.deviation) and self.deviation > 0.0
        return "" if good else "a finite `mean` and a `deviation` above 0"


Values = list[Any] | Range | Normal

Sampling = Literal["grid", "latin-hypercube", "monte-carlo"]
Measured = Literal["walk", "push-limit"]


@dataclass(frozen=True)
class Study:
    """A sweep as its file says it, checked.

    Attributes:
        title: for tables and pictures.
        measure: one walk of each cell, or the smallest failing push.
        robot: preset, or a file; relative to the study's own.
        controller: key of a method.
        sampling: how values are combined.
        samples: how many cells, of what is drawn.
        seed: of what is drawn.
        step: of the scan for the smallest failing push [N s].
        fixed: parameters that all cells have, by name.
        vary: parameters that differ, by name.
    """

    title: str
    measure: Measured
    robot: str
    controller: str
    sampling: Sampling
    samples: int
    seed: int
    step: float
    fixed: dict[str, Any]
    vary: dict[str, Values]


class _File(msgspec.Struct, frozen=True, forbid_unknown_fields=True, rename={"fixed": "set"}):
    vary: dict[str, Any]
    title: str = ""
    measure: Measured = "walk"
    robot: str = "paper-biped"
    controller: str = "unified"
    sampling: Sampling = "grid"
    samples: int | None = None
    seed: int = 0
    step: float = 1.0
    fixed: dict[str, Any] = {}


def load_study(path: str | Path) -> Study:
    """Read a study from a TOML file.

    Raises:
        FileError: it cannot be read, or is no TOML.
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
        study = parse_study(text, str(path))
    except tomllib.TOMLDecodeError as error:
        raise FileError(
            "a TOML document", f"{path}: {error}", "correct the line that is named"
        ) from error
    if study.robot.endswith(".toml"):
        beside = str(path.parent / study.robot)
        study = Study(**{**_fields(study), "robot": beside})
    return study


def parse_study(text: str, origin: str = "the study") -> Study:
    """A study from TOML text.

    Args:
        text: the document.
        origin: what to call it in messages.

    Raises:
        TOMLDecodeError: it is no TOML.
        ParameterError: see `load_study`.
    """
    table = tomllib.loads(text)
    for key in ("set", "vary"):
        if isinstance(table.get(key), dict):
            table[key] = flat_names(table[key])
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
    return Study(
        title=file.title or Path(origin).stem,
        measure=file.measure,
        robot=file.robot,
        controller=file.controller,
        sampling=file.sampling,
        samples=USUAL_SAMPLES if file.samples is None else file.samples,
        seed=file.seed,
        step=file.step,
        fixed=file.fixed,
        vary=vary,
    )


def _fields(study: Study) -> dict[str, Any]:
    return {name: getattr(study, name) for name in Study.__dataclass_fields__}


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

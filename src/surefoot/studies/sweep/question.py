"""What a sweep asks: which parameters take which values, and which cells that makes."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import product
from typing import Any, ClassVar, Literal

import msgspec
import numpy as np
from msgspec import to_builtins
from numpy.typing import NDArray

from surefoot.checks import optional_module
from surefoot.control.registry import find_method
from surefoot.errors import RobotError, VelocityError
from surefoot.interface import Controller
from surefoot.studies.engine.study import Study
from surefoot.studies.engine.table import Row
from surefoot.studies.sweep.measure import FAILED, empty_row, measure_cells
from surefoot.studies.sweep.parameters import parameter, situation


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
        """What must be corrected, empty if nothing."""
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
        """What must be corrected, empty if nothing."""
        good = math.isfinite(self.mean) and math.isfinite(self.deviation) and self.deviation > 0.0
        return "" if good else "a finite `mean` and a `deviation` above 0"


Values = list[Any] | Range | Normal

Sampling = Literal["grid", "latin-hypercube", "monte-carlo"]
Quantity = Literal["walk", "push-limit"]

AT_ONCE = 64
"""Walks of one task: enough that sending it is nothing beside walking."""


@dataclass(frozen=True)
class Cell:
    """One combination of values, in the order of `Sweep.vary`."""

    values: tuple[Any, ...]


@dataclass(frozen=True)
class Sweep(Study):
    """A sweep as its file says it, checked.

    Attributes:
        robot: as its file says.
        source: the preset or the file that it is from.
        title: for tables and pictures.
        measures: one walk of each cell, or the smallest failing push.
        controller: key of a method.
        sampling: how values are combined.
        samples: how many cells, of what is drawn.
        seed: of what is drawn.
        step: of the scan for the smallest failing push [N s].
        fixed: parameters that all cells have, by name.
        vary: parameters that differ, by name.
    """

    source: str
    title: str
    measures: Quantity
    controller: str
    sampling: Sampling
    samples: int
    seed: int
    step: float
    fixed: dict[str, Any]
    vary: dict[str, Values]

    NAME: ClassVar = "sweep"

    def cells(self) -> Iterator[Cell]:
        """Every combination of a grid, or what is drawn; the same for the same seed.

        Raises:
            MissingExtraError: scipy is not installed, and something is to be drawn.
        """
        varied = [
            (values, one is not None and one.whole)
            for name, values in self.vary.items()
            for one in [parameter(self.controller, name)]
        ]
        if self.sampling == "grid":
            every = product(*(_grid_values(values, whole) for values, whole in varied))
            return map(Cell, every)
        points = _unit_samples(self).T
        columns = [_drawn(*one, column) for one, column in zip(varied, points, strict=True)]
        return map(Cell, zip(*columns, strict=True))

    def columns(self, cell: Cell) -> Row:
        """The value of each parameter that differs."""
        return dict(zip(self.vary, cell.values, strict=True))

    def measure_many(self, cells: Sequence[Cell]) -> list[Row | str]:
        """See `measure.measure_cells`."""
        return [*measure_cells(self, cells)]

    def at_once(self) -> int:
        """A batch of compiled walks; a scan, or a walk in Python, is work enough."""
        if self.measures == "walk" and self._usual().kernel is not None:
            return AT_ONCE
        return 1

    def check(self) -> None:
        """Refuse a method that cannot be used at all, and what is set for all cells if it makes no
        sense, rather than cell by cell.

        Raises:
            ParameterError: a value has another type, or is out of range.
            MissingExtraError: the library of the method is not installed.
        """
        # What varies may be what makes a robot or a velocity possible.
        with contextlib.suppress(RobotError, VelocityError):
            situation(self.robot, self.controller, self.fixed)
        self._usual()

    def failed(self, cell: Cell, error: str) -> Row:
        """A cell that could not be measured is a row too."""
        lines = error.strip().splitlines()
        why = {"outcome": FAILED, "error": lines[-1] if lines else error}
        return self.columns(cell) | empty_row(self) | why

    def as_numbers(self) -> dict[str, Any]:
        """Everything that the file says, by its keys."""
        asked = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "robot"}
        return to_builtins(
            {"robot": asked.pop("source"), "measure": asked.pop("measures"), **asked}
        )

    def notes(self, rows: Sequence[Row]) -> dict[str, Any]:
        """What was asked, for readers of the table."""
        return {"study": self.as_numbers()}

    def common(self) -> dict[str, Any]:
        """Everything but which values are taken."""
        names = ("measure", "controller", "step", "fixed")
        asked = self.as_numbers()
        return {name: asked[name] for name in names} | {"varied": list(self.vary)}

    def provenance(self) -> dict[str, str]:
        """Who walks, and how values were combined."""
        return {
            "controller": self.controller,
            "sampling": self.sampling,
            "seed": str(self.seed),
        }

    def _usual(self) -> Controller:
        return find_method(self.controller).controller(self.robot, (0.0, 0.0))


def _grid_values(values: Values, whole: bool) -> list[Any]:
    if not isinstance(values, Range):
        assert isinstance(values, list)
        return values
    count = values.count or 2
    if values.scale == "log":
        found = np.geomspace(values.low, values.to, count)
    else:
        found = np.linspace(values.low, values.to, count)
    if whole:
        return sorted({round(one) for one in found})
    # The file says 0.3, not 0.30000000000000004.
    return [float(f"{one:.12g}") for one in found]


def _unit_samples(study: Sweep) -> NDArray[np.float64]:
    """Points of the unit cube, shape (samples, parameters)."""
    shape = study.samples, len(study.vary)
    if study.sampling == "monte-carlo":
        return np.random.default_rng(study.seed).random(shape)
    qmc = optional_module("scipy.stats", "Latin hypercubes", "study").qmc
    return qmc.LatinHypercube(shape[1], rng=np.random.default_rng(study.seed)).random(shape[0])


def _drawn(values: Values, whole: bool, column: NDArray[np.float64]) -> list[Any]:
    """Values by their share of the distribution, 0 to 1."""
    if whole and not isinstance(values, list):
        return [round(one) for one in _drawn(values, False, column)]
    if isinstance(values, Normal):
        norm = optional_module("scipy.stats", "normal distributions", "study").norm
        return norm.ppf(column, values.mean, values.deviation).tolist()
    if isinstance(values, Range):
        if values.scale == "log":
            low, high = math.log(values.low), math.log(values.to)
            return np.exp(low + (high - low) * column).tolist()
        return (values.low + (values.to - values.low) * column).tolist()
    return [values[int(share * len(values))] for share in column]

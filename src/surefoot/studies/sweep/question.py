"""What a sweep asks: which parameters take which values, and which cells that makes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from typing import Any, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import optional_module
from surefoot.robot.robot import Robot, load_robot
from surefoot.studies.sweep.parameters import parameter


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
class Sweep:
    """A sweep as its file says it, checked.

    Attributes:
        title: for tables and pictures.
        measures: one walk of each cell, or the smallest failing push.
        robot: preset, or a file.
        controller: key of a method.
        sampling: how values are combined.
        samples: how many cells, of what is drawn.
        seed: of what is drawn.
        step: of the scan for the smallest failing push [N s].
        fixed: parameters that all cells have, by name.
        vary: parameters that differ, by name.
    """

    title: str
    measures: Measured
    robot: str
    controller: str
    sampling: Sampling
    samples: int
    seed: int
    step: float
    fixed: dict[str, Any]
    vary: dict[str, Values]
    body: Robot = field(init=False, repr=False)

    def __post_init__(self) -> None:
        # Here and not where it is measured: the file of a robot may be on this machine only.
        object.__setattr__(self, "body", load_robot(self.robot))


@dataclass(frozen=True)
class SweepCell:
    """One combination of values.

    Attributes:
        values: in the order of the study's [vary].
    """

    values: tuple[Any, ...]


def cell_key(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Values as a key; floats rounded, so that they survive a file."""
    return tuple(
        cell_key(tuple(value)) if isinstance(value, (list, tuple))
        else float(f"{value:.12g}") if isinstance(value, float) else value
        for value in values
    )  # fmt: skip


def sweep_cells(study: Sweep) -> Iterator[SweepCell]:
    """The cells of a study; the same for the same seed.

    Raises:
        MissingExtraError: scipy is not installed, and something is to be drawn.
    """
    if study.sampling == "grid":
        every = [_grid_values(one, _whole(study, name)) for name, one in study.vary.items()]
        for values in product(*every):
            yield SweepCell(values)
        return
    columns = [
        _drawn(values, column, _whole(study, name))
        for (name, values), column in zip(study.vary.items(), _unit_samples(study).T, strict=True)
    ]
    for values in zip(*columns, strict=True):
        yield SweepCell(values)


def _whole(study: Sweep, name: str) -> bool:
    declared = parameter(study.controller, name)
    return declared is not None and declared.whole


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
    # 0.30000000000000004 is 0.3 to whoever wrote the file.
    return [float(f"{one:.12g}") for one in found]


def _unit_samples(study: Sweep) -> NDArray[np.float64]:
    """Points of the unit cube, shape (samples, parameters)."""
    shape = study.samples, len(study.vary)
    if study.sampling == "monte-carlo":
        return np.random.default_rng(study.seed).random(shape)
    qmc = optional_module("scipy.stats", "Latin hypercubes", "study").qmc
    return qmc.LatinHypercube(shape[1], rng=np.random.default_rng(study.seed)).random(shape[0])


def _drawn(values: Values, column: NDArray[np.float64], whole: bool) -> list[Any]:
    """Values by their share of the distribution, 0 to 1."""
    if whole and not isinstance(values, list):
        return [round(one) for one in _drawn(values, column, False)]
    if isinstance(values, Normal):
        norm = optional_module("scipy.stats", "normal distributions", "study").norm
        return norm.ppf(column, values.mean, values.deviation).tolist()
    if isinstance(values, Range):
        if values.scale == "log":
            low, high = math.log(values.low), math.log(values.to)
            return np.exp(low + (high - low) * column).tolist()
        return (values.low + (values.to - values.low) * column).tolist()
    return [values[int(share * len(values))] for share in column]

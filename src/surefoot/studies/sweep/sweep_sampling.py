"""Which cells a sweep has: every combination of a grid, or values that are drawn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import optional_module
from surefoot.studies.sweep.sweep_parameters import WHOLE
from surefoot.studies.sweep.sweep_study import Normal, Range, Study, Values


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


def sweep_cells(study: Study) -> Iterator[SweepCell]:
    """The cells of a study; the same for the same seed.

    Raises:
        MissingExtraError: scipy is not installed, and something is to be drawn.
    """
    if study.sampling == "grid":
        for values in product(*(_grid_values(*item) for item in study.vary.items())):
            yield SweepCell(values)
        return
    columns = [
        _drawn(name, values, column)
        for (name, values), column in zip(study.vary.items(), _unit_samples(study).T, strict=True)
    ]
    for values in zip(*columns, strict=True):
        yield SweepCell(values)


def _grid_values(name: str, values: Values) -> list[Any]:
    if not isinstance(values, Range):
        assert isinstance(values, list)
        return values
    count = values.count or 2
    if values.scale == "log":
        found = np.geomspace(values.low, values.to, count)
    else:
        found = np.linspace(values.low, values.to, count)
    if name in WHOLE:
        return sorted({round(one) for one in found})
    # 0.30000000000000004 is 0.3 to whoever wrote the file.
    return [float(f"{one:.12g}") for one in found]


def _unit_samples(study: Study) -> NDArray[np.float64]:
    """Points of the unit cube, shape (samples, parameters)."""
    shape = study.samples, len(study.vary)
    if study.sampling == "monte-carlo":
        return np.random.default_rng(study.seed).random(shape)
    qmc = optional_module("scipy.stats", "Latin hypercubes", "study").qmc
    return qmc.LatinHypercube(shape[1], rng=np.random.default_rng(study.seed)).random(shape[0])


def _drawn(name: str, values: Values, column: NDArray[np.float64]) -> list[Any]:
    """Values by their share of the distribution, 0 to 1."""
    if name in WHOLE and not isinstance(values, list):
        return [round(one) for one in _drawn("", values, column)]
    if isinstance(values, Normal):
        norm = optional_module("scipy.stats", "normal distributions", "study").norm
        return norm.ppf(column, values.mean, values.deviation).tolist()
    if isinstance(values, Range):
        if values.scale == "log":
            low, high = math.log(values.low), math.log(values.to)
            return np.exp(low + (high - low) * column).tolist()
        return (values.low + (values.to - values.low) * column).tolist()
    return [values[int(share * len(values))] for share in column]

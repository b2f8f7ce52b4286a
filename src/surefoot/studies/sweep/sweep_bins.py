"""What many drawn cells say together: bins of a parameter, their share or median, and how sure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.studies.sweep.sweep_columns import Column

CONFIDENCE = 1.959964
"""Standard deviations on each side of a 95 % interval."""

MOST_VALUES = 8
"""A parameter with no more values than these has a bin for each."""

MOST_BINS, IN_A_BIN = 10, 8
"""There are no more bins than the first, and no more than give each so many cells."""


@dataclass(frozen=True)
class Bin:
    """The cells of a range of values.

    Attributes:
        place: where it is drawn.
        members: which cells are in it.
    """

    place: float
    members: NDArray[np.bool_]


def bins(one: Column, usable: NDArray[np.bool_]) -> list[Bin]:
    """The bins of a parameter: equally many cells in each, or one for each of few values.

    Args:
        one: the parameter.
        usable: which cells have a number; at least one.
    """
    if not one.numeric or len(one.values) <= MOST_VALUES:
        made = [Bin(float(value), usable & (one.places == value)) for value in one.values]
        return [each for each in made if each.members.any()]
    order = np.flatnonzero(usable)[np.argsort(one.places[usable], kind="stable")]
    count = min(MOST_BINS, max(3, len(order) // IN_A_BIN))
    made = []
    for part in np.array_split(order, count):
        if len(part):
            members = np.zeros(len(usable), bool)
            members[part] = True
            made.append(Bin(float(np.median(one.places[part])), members))
    return made


def wilson(successes: int, count: int) -> tuple[float, float]:
    """The 95 % interval of a share after Wilson: sound for few trials, and near 0 and 1.

    Args:
        successes: of `count` trials.
        count: at least 1.
    """
    z2 = CONFIDENCE**2 / count
    share = successes / count
    middle = (share + 0.5 * z2) / (1.0 + z2)
    half = math.sqrt(z2 * share * (1.0 - share) + 0.25 * z2**2) / (1.0 + z2)
    return max(0.0, middle - half), min(1.0, middle + half)

"""One decision about the next landing, and its answer, as records."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.errors import ParameterError
from surefoot.interface import Status
from surefoot.record import Record, fill, set_array

OFFSET_WEIGHT = (20000.0, 1000.0)
"""Default (a4, a5) [1/m^2]. Forward, a large push drives the step to its limit, and only the timing
is left to bring the offset back: this a4 keeps it within a millimetre of nominal there."""

OFFSET_PENALTY = 1e6
"""Default weight of half the squared violation of the offset bounds [1/m^2]."""

STEP_PROBLEM = np.dtype(
    [
        ("growth", "f8", (2,)),
        ("nominal_step", "f8", (2,)),
        ("nominal_tau", "f8"),
        ("nominal_offset", "f8", (2,)),
        ("step_min", "f8", (2,)),
        ("step_max", "f8", (2,)),
        ("tau_min", "f8"),
        ("tau_max", "f8"),
        ("offset_min", "f8", (2,)),
        ("offset_max", "f8", (2,)),
        ("step_weight", "f8", (2,)),
        ("tau_weight", "f8"),
        ("offset_weight", "f8", (2,)),
        ("offset_penalty", "f8"),
    ],
)

STEP_SOLUTION = np.dtype(
    [
        ("step", "f8", (2,)),
        ("tau", "f8"),
        ("offset", "f8", (2,)),
        ("multiplier", "f8", (2,)),
        ("violation", "f8"),
        ("status", "i8"),
        ("iterations", "i8"),
    ],
)


_PAIRS = frozenset(name for name in STEP_PROBLEM.names or () if STEP_PROBLEM[name].shape)
_FIRST_WEIGHT = STEP_PROBLEM.fields["step_weight"][1] // 8  # type: ignore[index]


class StepProblem(Record):
    """One decision about the next landing.

    Args:
        growth: (A, B) = (dcm - p) e^(-omega t) [m].
        nominal_step: (X_nom, Y_nom + s hip) [m].
        nominal_tau: e^(omega T_nom).
        nominal_offset: d_nom of the NEXT foot (x, y) [m].
        step_min, step_max: box of the step vector (x, y) [m].
        tau_min, tau_max: interval of tau; tau_min also holds e^(omega t).
        offset_min, offset_max: soft bounds on d (x, y) [m].
        step_weight: (a1, a2) [1/m^2].
        tau_weight: a3 [-].
        offset_weight: (a4, a5) [1/m^2].
        offset_penalty: rho, on half the squared violation [1/m^2].

    An empty interval is not an error: see `solve_step` for its answer.

    Raises:
        ParameterError: a value is no pair where it should be, not finite, or a negative weight.
    """

    __slots__ = ()
    DTYPE = STEP_PROBLEM

    def __init__(
        self,
        *,
        growth: tuple[float, float],
        nominal_step: tuple[float, float],
        nominal_tau: float,
        nominal_offset: tuple[float, float],
        step_min: tuple[float, float],
        step_max: tuple[float, float],
        tau_min: float,
        tau_max: float,
        offset_min: tuple[float, float],
        offset_max: tuple[float, float],
        step_weight: tuple[float, float] = (1.0, 1.0),
        tau_weight: float = 1.0,
        offset_weight: tuple[float, float] = OFFSET_WEIGHT,
        offset_penalty: float = OFFSET_PENALTY,
    ) -> None:
        given = locals()
        numbers = _flat(given)
        if numbers is None:
            # Something is wrong: look at one value after the other, to say which.
            shapes = {name: STEP_PROBLEM[name].shape for name in STEP_PROBLEM.names or ()}
            fill(self, {name: _checked(name, given[name], shapes[name]) for name in shapes})
        else:
            set_array(self, numbers.view(STEP_PROBLEM))

    def replace(self, **changes: Any) -> StepProblem:
        """A copy with some values changed, checked like a new problem."""
        return super().replace(
            **{name: _checked(name, changes[name], STEP_PROBLEM[name].shape) for name in changes}
        )


class StepSolution(Record):
    """The answer to a `StepProblem`.

    Attributes:
        step: (X, Y) from the support foot to the landing [m].
        tau: e^(omega T).
        offset: d at landing (x, y) [m].
        multiplier: of the equalities X + d_x = A tau and Y + d_y = B tau [1/m].
        violation: largest violation of the soft bounds on d [m].
        status: `Status` flags.
        iterations: evaluations of the derivative, at most `MAX_ITERATIONS`.
    """

    __slots__ = ()
    DTYPE = STEP_SOLUTION
    step: NDArray[np.float64]
    tau: float
    offset: NDArray[np.float64]
    multiplier: NDArray[np.float64]
    violation: float
    iterations: int

    @property
    def status(self) -> Status:
        """What the decision could not keep."""
        return Status(int(self.array["status"][0]))


def _flat(given: dict[str, Any]) -> NDArray[np.float64] | None:
    """All numbers of a problem in the order of its record, or None if one of them is wrong."""
    flat: list[Any] = []
    try:
        for name in STEP_PROBLEM.names or ():
            if name in _PAIRS:
                x, y = given[name]
                flat += (x, y)
            else:
                flat.append(given[name])
        numbers = np.array(flat, np.float64)
        values = numbers.tolist()
        good = all(map(math.isfinite, values)) and min(values[_FIRST_WEIGHT:]) >= 0.0
    except (TypeError, ValueError):
        return None
    return numbers if good else None


def _checked(name: str, value: Any, shape: tuple[int, ...]) -> NDArray[np.float64]:
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array(math.nan)
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise ParameterError(
            f"`{name}` to be {'a pair of finite numbers (x, y)' if shape else 'a finite number'}",
            repr(value),
            "see the docstring of StepProblem for units",
        )
    if name.endswith(("weight", "penalty")) and (numbers < 0.0).any():
        raise ParameterError(
            f"`{name}` not to be negative", repr(value), "use 0 for a term that does not matter"
        )
    return numbers

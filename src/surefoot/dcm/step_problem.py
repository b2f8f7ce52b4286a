"""One decision about the next landing and its answer, as records, and how good an answer it is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.nominal_gait import NominalGait
from surefoot.errors import ParameterError
from surefoot.interface import Status
from surefoot.record import Record, Vector2, field
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

OFFSET_WEIGHT = (20000.0, 1000.0)
"""Default (a4, a5) [1/m^2]. Forward, a large push drives the step to its limit, and only the timing
is left to bring the offset back: this a4 keeps it within a millimetre of nominal there."""

OFFSET_PENALTY = 1e6
"""Default weight of half the squared violation of the offset bounds [1/m^2]."""


class StepProblem(Record):
    """One decision about the next landing.

    An empty interval is not an error: see `solve_step` for its answer.

    Raises:
        ParameterError: a value is no pair where it should be, not finite, or a negative weight.
    """

    growth: Vector2 = field("m", "(A, B) = (dcm - p) e^(-omega t)")
    nominal_step: Vector2 = field("m", "(X_nom, Y_nom + s hip)")
    nominal_tau: float = field("-", "e^(omega T_nom)")
    nominal_offset: Vector2 = field("m", "d_nom of the NEXT foot (x, y)")
    step_min: Vector2 = field("m", "lower end of the box of the step vector (x, y)")
    step_max: Vector2 = field("m", "its upper end")
    tau_min: float = field("-", "lower end of the interval of tau, which also holds e^(omega t)")
    tau_max: float = field("-", "its upper end")
    offset_min: Vector2 = field("m", "lower soft bound on d (x, y)")
    offset_max: Vector2 = field("m", "upper soft bound on d (x, y)")
    step_weight: Vector2 = field("1/m^2", "(a1, a2)", default=(1.0, 1.0))
    tau_weight: float = field("-", "a3", default=1.0)
    offset_weight: Vector2 = field("1/m^2", "(a4, a5)", default=OFFSET_WEIGHT)
    offset_penalty: float = field(
        "1/m^2", "rho, on half the squared violation", default=OFFSET_PENALTY
    )

    @classmethod
    def _made_of(cls, row: tuple[Any, ...]) -> NDArray[np.void]:
        numbers = _flat(row)
        if numbers is not None:
            return numbers.view(cls.DTYPE)
        # Something is wrong: look at one value after the other, to say which.
        return super()._made_of(tuple(map(_checked, cls.FIELDS, row)))

    def replace(self, **changes: Any) -> StepProblem:
        """A copy with some values changed, checked like a new problem."""
        return super().replace(**{name: _checked(name, changes[name]) for name in changes})


_PAIR = [it.shape == (2,) for it in StepProblem.FIELDS.values()]
_FIRST_WEIGHT = StepProblem.DTYPE.fields["step_weight"][1] // 8  # type: ignore[index]


class StepSolution(Record):
    """The answer to a `StepProblem`."""

    step: Vector2 = field("m", "(X, Y) from the support foot to the landing")
    tau: float = field("-", "e^(omega T)")
    offset: Vector2 = field("m", "d at landing (x, y)")
    multiplier: Vector2 = field("1/m", "of the equalities X + d_x = A tau and Y + d_y = B tau")
    violation: float = field("m", "largest violation of the soft bounds on d")
    status: Status = field("", "what the decision could not keep", default=Status.OK)
    iterations: int = field("", "evaluations of the derivative, at most `MAX_ITERATIONS`")


STEP_PROBLEM, STEP_SOLUTION = StepProblem.DTYPE, StepSolution.DTYPE
"""The same for kernels, which know no classes."""


def _flat(row: tuple[Any, ...]) -> NDArray[np.float64] | None:
    """All numbers of a problem in the order of its record, or None if one of them is wrong."""
    flat: list[Any] = []
    try:
        for is_pair, value in zip(_PAIR, row, strict=True):
            if is_pair:
                x, y = value
                flat += (x, y)
            else:
                flat.append(value)
        numbers = np.array(flat, np.float64)
        values = numbers.tolist()
        good = all(map(math.isfinite, values)) and min(values[_FIRST_WEIGHT:]) >= 0.0
    except (TypeError, ValueError):
        return None
    return numbers if good else None


def _checked(name: str, value: Any) -> NDArray[np.float64]:
    shape = StepProblem.FIELDS[name].shape
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


def gait_problem(
    robot: Robot,
    gait: NominalGait,
    support_side: Side,
    offset_bounds: tuple[tuple[float, float], tuple[float, float]],
    growth: tuple[float, float] | None = None,
    elapsed: float = 0.0,
    *,
    step_weight: tuple[float, float],
    tau_weight: float,
    offset_weight: tuple[float, float],
    offset_penalty: float,
) -> StepProblem:
    """The step problem of a step in a gait.

    The offset bounds are widened where needed so that they hold the nominal offset: a fast gait
    must not be pulled away from itself.

    Args:
        robot: whose limits hold.
        gait: what is nominal.
        support_side: foot on the ground.
        offset_bounds: least and largest d (x, y) [m].
        growth: (A, B), the nominal gait if None [m].
        elapsed: t, time since touchdown [s].
        step_weight: (a1, a2) [1/m^2].
        tau_weight: a3 [-].
        offset_weight: (a4, a5) [1/m^2].
        offset_penalty: rho, on half the squared violation [1/m^2].
    """
    d_nom, (lower, upper) = gait.dcm_offset(support_side), offset_bounds
    step_min, step_max = robot.gait.step_box(support_side, robot.hip)
    shortest, longest = robot.gait.step_duration
    shortest = max(shortest, elapsed)
    return StepProblem(
        growth=gait.start_offset(support_side) if growth is None else growth,
        nominal_step=gait.step(support_side),
        nominal_tau=gait.growth,
        nominal_offset=d_nom,
        step_min=step_min,
        step_max=step_max,
        tau_min=math.exp(robot.omega * shortest),
        tau_max=math.exp(robot.omega * longest),
        offset_min=(min(lower[0], d_nom[0]), min(lower[1], d_nom[1])),
        offset_max=(max(upper[0], d_nom[0]), max(upper[1], d_nom[1])),
        step_weight=step_weight,
        tau_weight=tau_weight,
        offset_weight=offset_weight,
        offset_penalty=offset_penalty,
    )


@dataclass(frozen=True)
class KktResidual:
    """How far a solution is from optimal; both parts are zero at the optimum.

    Attributes:
        stationarity: largest |v - clip(v - gradient of the Lagrangian, low, high)| over the
            variables v, where a gradient counts relative to the largest term in it (or to 1).
        primal: largest violation of an equality or of a hard interval [m or -].
    """

    stationarity: float
    primal: float

    @property
    def largest(self) -> float:
        """The larger of the two."""
        return max(self.stationarity, self.primal)


def kkt_residual(problem: StepProblem, solution: StepSolution) -> KktResidual:
    """Judge a solution by the conditions of Karush, Kuhn and Tucker, with no code of the solver's.

    L = cost - sum_i lambda_i (step_i + d_i - growth_i tau), with the intervals of step and tau as
    bounds and the offset bounds as a penalty in the cost. An empty interval stands for what
    `solve_step` makes of it: its middle for the step, its lower end for tau.

    Args:
        problem: what was to be solved.
        solution: the answer.

    Returns:
        The residual.
    """
    tau = solution.tau
    timing = problem.tau_weight * (tau - problem.nominal_tau)
    tau_terms = [timing]
    stationarity, primal = [], []
    for i in range(2):
        step, d, force = solution.step[i], solution.offset[i], solution.multiplier[i]
        low, high = problem.step_min[i], problem.step_max[i]
        if low > high:
            low = high = 0.5 * (low + high)
        pull = problem.step_weight[i] * (step - problem.nominal_step[i])
        stationarity.append(_natural(step, (pull, -force), low, high))
        stationarity.append(
            _relative(
                (
                    problem.offset_weight[i] * (d - problem.nominal_offset[i]),
                    problem.offset_penalty * max(d - problem.offset_max[i], 0.0),
                    -problem.offset_penalty * max(problem.offset_min[i] - d, 0.0),
                    -force,
                )
            )
        )
        tau_terms.append(problem.growth[i] * force)
        primal += [abs(step + d - problem.growth[i] * tau), low - step, step - high]
    tau_high = max(problem.tau_min, problem.tau_max)
    stationarity.append(_natural(tau, tuple(tau_terms), problem.tau_min, tau_high))
    primal += [problem.tau_min - tau, tau - tau_high]
    return KktResidual(float(max(stationarity)), float(max(primal)))


def _relative(terms: tuple[float, ...]) -> float:
    return abs(sum(terms)) / max(1.0, *map(abs, terms))


def _natural(value: float, terms: tuple[float, ...], low: float, high: float) -> float:
    """|v - clip(v - g, low, high)|: zero where the gradient is, or where it presses on a bound."""
    gradient = sum(terms) / max(1.0, *map(abs, terms))
    return abs(value - min(max(value - gradient, low), high))

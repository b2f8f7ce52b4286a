"""Judge a solution of the step problem by the conditions of Karush, Kuhn and Tucker.

It shares no code with the solver: it reads the problem, the solution and the multipliers only.
"""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.dcm.step_problem import StepProblem, StepSolution


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
    """The KKT residual of a solution.

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

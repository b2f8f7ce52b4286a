"""The same step problem through general QP libraries, each called as fast as it can be from Python.

All take the variables (X, Y, tau, d_x, d_y) with the two equalities X + d_x = A tau and
Y + d_y = B tau, whose Hessian is diagonal and never changes. Eliminating d_x and d_y makes three
variables of five, but a dense Hessian that changes with A and B; that was slower in all three.
The soft bounds are rows d_min <= d + s <= d_max with a signed slack s and the cost rho s^2 / 2;
daqp has soft bounds of its own, which are the same problem.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import daqp
import numpy as np
import piqp
import quadprog
from numpy.typing import NDArray

import surefoot as sf
from rounds import Task, time_calls

AGREEMENT = 1e-6
"""Largest difference to our solution, in every component, relative to it where it exceeds 1."""

_PIQP_TOLERANCE = 1e-12
"""The default leaves errors of 1e-5 where a bound is nearly active; the price is one iteration."""

Vector = NDArray[np.float64]
Solver = Callable[["QpProblem"], Vector]


class QpProblem:
    """A `StepProblem` as the numbers that a QP library is given.

    Attributes:
        growth: (A, B) [m].
        weights: of (X, Y, tau, d_x, d_y).
        nominal: of the same.
        low, high: hard bounds of (X, Y, tau).
        offset_low, offset_high: soft bounds of (d_x, d_y) [m].
        penalty: rho, on half the squared violation [1/m^2].
        side: which foot stands; all but A, B and the bound on tau depends on it alone.
    """

    def __init__(self, problem: sf.StepProblem) -> None:
        p = problem
        self.growth = float(p.growth[0]), float(p.growth[1])
        self.weights = np.array([*p.step_weight, p.tau_weight, *p.offset_weight])
        self.nominal = np.array([*p.nominal_step, p.nominal_tau, *p.nominal_offset])
        self.low = np.array([*p.step_min, p.tau_min])
        self.high = np.array([*p.step_max, p.tau_max])
        self.tau_min = float(p.tau_min)
        self.offset_low, self.offset_high = np.array(p.offset_min), np.array(p.offset_max)
        self.penalty = float(p.offset_penalty)
        self.side = 1 if self.nominal[1] > 0.0 else -1


class Quadprog:
    """Goldfarb and Idnani's dual active set; the Hessian is given factorised."""

    def __init__(self, problem: QpProblem) -> None:
        diagonal = np.concatenate((problem.weights, [problem.penalty] * 2))
        self.factor = np.diag(1.0 / np.sqrt(diagonal))
        self.linear = np.concatenate((problem.weights * problem.nominal, np.zeros(2)))
        self.columns, self.bounds = self._constraints(problem)

    @staticmethod
    def _constraints(problem: QpProblem) -> tuple[Vector, Vector]:
        """One column for each equality, and one for each one-sided bound."""
        columns = np.zeros((7, 12), order="F")
        columns[0, 0] = columns[3, 0] = columns[1, 1] = columns[4, 1] = 1.0
        columns[2, 0], columns[2, 1] = -problem.growth[0], -problem.growth[1]
        for i in range(3):
            columns[i, 2 + i], columns[i, 5 + i] = 1.0, -1.0
        for i in range(2):
            columns[3 + i, 8 + i] = columns[5 + i, 8 + i] = 1.0
            columns[3 + i, 10 + i] = columns[5 + i, 10 + i] = -1.0
        return columns, np.concatenate(
            (np.zeros(2), problem.low, -problem.high, problem.offset_low, -problem.offset_high)
        )

    def solve(self, problem: QpProblem) -> Vector:
        """With everything prepared but A, B and the bound on tau."""
        self.columns[2, 0], self.columns[2, 1] = -problem.growth[0], -problem.growth[1]
        self.bounds[4] = problem.tau_min
        return quadprog.solve_qp(self.factor, self.linear, self.columns, self.bounds, 2, True)[0]

    @staticmethod
    def assemble_and_solve(problem: QpProblem) -> Vector:
        """From the numbers of the problem."""
        fresh = Quadprog(problem)
        return quadprog.solve_qp(fresh.factor, fresh.linear, fresh.columns, fresh.bounds, 2, True)[
            0
        ]


class Daqp:
    """Dual active set of Arnström et al.; starts from the active set of the decision before."""

    def __init__(self, problem: QpProblem) -> None:
        self.rows = np.zeros((2, 5))
        self.rows[0, 0] = self.rows[0, 3] = self.rows[1, 1] = self.rows[1, 4] = 1.0
        self.rows[0, 2], self.rows[1, 2] = -problem.growth[0], -problem.growth[1]
        self.low = np.concatenate((problem.low, problem.offset_low, np.zeros(2)))
        self.high = np.concatenate((problem.high, problem.offset_high, np.zeros(2)))
        self.model = daqp.Model()
        self.model.settings = {"primal_tol": 1e-9}
        soft, equality = 8, 5
        self.model.setup(
            np.diag(problem.weights),
            -problem.weights * problem.nominal,
            self.rows,
            self.high,
            self.low,
            np.array([0, 0, 0, soft, soft, equality, equality], np.int32),
        )
        softness = np.full(7, 1.0 / problem.penalty)
        self.model.soft_weights(rho_l=softness, rho_u=softness)

    def solve(self, problem: QpProblem) -> Vector:
        """With everything prepared but A, B and the bound on tau."""
        self.rows[0, 2], self.rows[1, 2] = -problem.growth[0], -problem.growth[1]
        self.low[2] = problem.tau_min
        self.model.update(None, None, self.rows, self.high, self.low)
        return self.model.solve()[0]

    @staticmethod
    def assemble_and_solve(problem: QpProblem) -> Vector:
        """From the numbers of the problem."""
        return Daqp(problem).model.solve()[0]


class Piqp:
    """Proximal interior point of Schwan et al., dense."""

    def __init__(self, problem: QpProblem) -> None:
        free = np.full(4, np.inf)
        self.rows = np.zeros((2, 7), order="F")
        self.rows[0, 0] = self.rows[0, 3] = self.rows[1, 1] = self.rows[1, 4] = 1.0
        self.rows[0, 2], self.rows[1, 2] = -problem.growth[0], -problem.growth[1]
        self.low = np.concatenate((problem.low, -free))
        soft = np.zeros((2, 7), order="F")
        soft[0, 3] = soft[0, 5] = soft[1, 4] = soft[1, 6] = 1.0
        self.solver = piqp.DenseSolver()
        settings = self.solver.settings
        settings.eps_abs = settings.eps_rel = _PIQP_TOLERANCE
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = _PIQP_TOLERANCE
        self.solver.setup(
            np.asfortranarray(np.diag(np.concatenate((problem.weights, [problem.penalty] * 2)))),
            np.concatenate((-problem.weights * problem.nominal, np.zeros(2))),
            self.rows,
            np.zeros(2),
            soft,
            problem.offset_low,
            problem.offset_high,
            self.low,
            np.concatenate((problem.high, free)),
        )

    def solve(self, problem: QpProblem) -> Vector:
        """With everything prepared but A, B and the bound on tau."""
        self.rows[0, 2], self.rows[1, 2] = -problem.growth[0], -problem.growth[1]
        self.low[2] = problem.tau_min
        self.solver.update(A=self.rows, x_l=self.low)
        self.solver.solve()
        return self.solver.result.x

    @staticmethod
    def assemble_and_solve(problem: QpProblem) -> Vector:
        """From the numbers of the problem."""
        fresh = Piqp(problem)
        fresh.solver.solve()
        return fresh.solver.result.x


LIBRARIES = (Quadprog, Daqp, Piqp)


def library_tasks(problems: Sequence[sf.StepProblem]) -> tuple[list[Task], float]:
    """Time every library on problems of ONE robot and velocity, after checking its answers.

    Args:
        problems: in the order of a walk, so that a warm start helps.

    Returns:
        The tasks, prepared ones first, and the largest difference to our solutions.
    """
    given = [QpProblem(problem) for problem in problems]
    ours = np.array([[*s.step, s.tau, *s.offset] for s in map(sf.solve_step, problems)])
    prepared, assembled, differences = [], [], []
    for library in LIBRARIES:
        name = library.__name__.lower()
        by_side = {side: library(_first(given, side)) for side in (1, -1)}

        def solve(problem: QpProblem, by_side: dict = by_side) -> Vector:
            return by_side[problem.side].solve(problem)

        solvers = (
            (f"{name} from Python, prepared", solve, prepared),
            (f"{name} from Python, with assembly", library.assemble_and_solve, assembled),
        )
        for what, solver, tasks in solvers:
            differences.append(_largest_difference(what, solver, given, ours))
            tasks.append(_task(what, solver, given))
    return prepared + assembled, max(differences)


def _task(what: str, solver: Solver, given: list[QpProblem]) -> Task:
    return Task(what, lambda: time_calls(solver, given), has_tail=True)


def _first(given: list[QpProblem], side: int) -> QpProblem:
    return next(problem for problem in given if problem.side == side)


def _largest_difference(what: str, solver: Solver, given: list[QpProblem], ours: Vector) -> float:
    """How far the library is from us.

    Raises:
        RuntimeError: further than `AGREEMENT`: a comparison of speed would not be honest.
    """
    # A copy: a library may return a view of memory that its next solve overwrites.
    theirs = np.array([np.array(solver(problem)[:5]) for problem in given])
    difference = float((np.abs(theirs - ours) / np.maximum(1.0, np.abs(ours))).max())
    if not difference <= AGREEMENT:
        raise RuntimeError(f"{what} differs from our solution by {difference:.1e}")
    return difference

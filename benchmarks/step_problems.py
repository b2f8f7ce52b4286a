"""Step problems to solve: around real walks, and the hardest of many random ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

import surefoot as sf
from surefoot.dcm.step_problem import STEP_SOLUTION
from surefoot.dcm.step_solver import MAX_ITERATIONS, solve_step_record

ROBOT = "paper-biped"

VELOCITIES = ((0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (-0.3, 0.0), (0.3, 0.1))
"""Commands of the walks [m/s]."""

DCM_NOISE = 0.02
"""Standard deviation of what is added to a visited DCM to make more states of it [m]."""


@dataclass(frozen=True)
class StepProblems:
    """Many decisions that share a few `StepProblem` records.

    Attributes:
        table: `STEP_PROBLEM` records, shape (m,).
        inputs: row of the table, A [m], B [m] and e^(omega t) of each decision, shape (n, 4).
    """

    table: NDArray[np.void]
    inputs: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.inputs)

    def take(self, rows: NDArray[np.int64] | slice) -> StepProblems:
        """Some of the decisions."""
        return StepProblems(self.table, np.ascontiguousarray(self.inputs[rows]))

    def problems(self) -> list[sf.StepProblem]:
        """Each decision as a value of its own."""
        problems = []
        for row, growth_x, growth_y, tau_now in self.inputs:
            record = self.table[int(row) : int(row) + 1].copy()
            record["growth"] = growth_x, growth_y
            record["tau_min"] = max(float(record["tau_min"][0]), tau_now)
            problems.append(sf.StepProblem.of(record))
        return problems


@njit
def solve_block(table, inputs, solution):
    """Solve one decision after the other; returns a sum, so that the compiler keeps every solve."""
    total = 0.0
    for i in range(inputs.shape[0]):
        problem = table[int(inputs[i, 0])]
        solve_step_record(problem, inputs[i, 1], inputs[i, 2], inputs[i, 3], solution[0])
        total += solution[0].tau + solution[0].step[0] + solution[0].offset[1]
    return total


@njit
def count_iterations(table, inputs, iterations, violations):
    """Write how often each solve evaluated the derivative, and how far its offset is out [m]."""
    solution = np.zeros(1, STEP_SOLUTION)[0]
    for i in range(inputs.shape[0]):
        problem = table[int(inputs[i, 0])]
        solve_step_record(problem, inputs[i, 1], inputs[i, 2], inputs[i, 3], solution)
        iterations[i], violations[i] = solution.iterations, solution.violation


def iterations_of(problems: StepProblems) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Iterations and violation [m] of every decision, each of shape (n,)."""
    iterations, violations = np.zeros(len(problems), np.int64), np.zeros(len(problems))
    count_iterations(problems.table, problems.inputs, iterations, violations)
    if iterations.max() > MAX_ITERATIONS:
        raise RuntimeError(f"{iterations.max()} iterations, but at most {MAX_ITERATIONS} promised")
    return iterations, violations


def walk_problems(count: int, rng: np.random.Generator) -> StepProblems:
    """Decisions around pushed walks at several velocities, in no order.

    Every walk decides its steps in every cycle and is pushed once, in any direction. Each state
    that it visits counts as it is, and again with noise on the DCM until there are enough.
    """
    table, visited = [], []
    for velocity in VELOCITIES:
        controller = sf.HybridController(sf.load_robot(ROBOT), velocity, threshold=0.0)
        first = len(table)
        table += [controller.step_problem(side).array for side in (sf.Side.RIGHT, sf.Side.LEFT)]
        for _ in range(2):
            angle, force = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(50.0, 180.0)
            push = (force * math.cos(angle), 0.5 * force * math.sin(angle))
            visited.append(_decisions(controller, sf.Push(rng.uniform(1.0, 1.5), 0.2, push), first))
    inputs = np.concatenate(visited)
    repeated = inputs[np.arange(count) % len(inputs)]
    noise = rng.normal(0.0, DCM_NOISE, (count, 2))
    noise[: len(inputs)] = 0.0
    repeated[:, 1:3] += noise / repeated[:, 3:4]
    return StepProblems(np.concatenate(table), repeated[rng.permutation(count)])


def pushed_decisions(velocity: tuple[float, float], push: sf.Push) -> StepProblems:
    """The decisions of one pushed walk, in its order: the second before the push and two after."""
    controller = sf.HybridController(sf.load_robot(ROBOT), velocity, threshold=0.0)
    table = [controller.step_problem(side).array for side in (sf.Side.RIGHT, sf.Side.LEFT)]
    inputs = _decisions(controller, push, 0, push.start + 2.0)
    rows = slice(int((push.start - 1.0) / controller.period), None)
    return StepProblems(np.concatenate(table), np.ascontiguousarray(inputs[rows]))


def hardest_problems(
    count: int, rng: np.random.Generator, draws: int = 500, shapes: int = 512
) -> StepProblems:
    """Of `draws` times as many random decisions those that need the most iterations.

    Weights are zero to a million, boxes wide to narrow, DCMs near to far: bounds meet, offsets are
    violated, and Newton's method needs several kinks.
    """
    table = np.concatenate([_random_problem(rng).array for _ in range(shapes)])
    number = count * draws
    inputs = np.column_stack(
        (
            rng.integers(0, shapes, number).astype(np.float64),
            rng.normal(0.0, 0.2, number),
            rng.normal(0.0, 0.2, number),
            np.exp(rng.uniform(0.0, 2.0, number)),
        )
    )
    iterations, _ = iterations_of(StepProblems(table, inputs))
    most = np.argsort(-iterations, kind="stable")[:count]
    return StepProblems(table, np.ascontiguousarray(inputs[rng.permutation(most)]))


def _decisions(
    controller: sf.HybridController, push: sf.Push, first: int, duration: float = 3.0
) -> NDArray[np.float64]:
    """The inputs of all decisions of a walk; the rows of the table begin at `first`."""
    walk = sf.simulate(controller, duration, [push])
    tau_now = np.exp(controller.robot.omega * walk.observations["elapsed"])
    growth = (walk.dcm - walk.support_foot) / tau_now[:, None]
    rows = np.where(walk.support_side > 0, float(first), first + 1.0)
    return np.column_stack((rows, growth, tau_now))


def _random_problem(rng: np.random.Generator) -> sf.StepProblem:
    """A random step problem, unlike that of a robot."""
    step_min, offset_min = rng.uniform(-0.6, 0.2, 2), rng.uniform(-0.15, 0.05, 2)
    tau_min = math.exp(rng.uniform(0.3, 1.5))
    weights = np.where(rng.random(5) < 0.15, 0.0, 10.0 ** rng.uniform(-2.0, 6.0, 5))
    return sf.StepProblem(
        growth=(0.0, 0.0),
        nominal_step=tuple(rng.uniform(-0.5, 0.5, 2)),
        nominal_tau=math.exp(rng.uniform(0.5, 2.5)),
        nominal_offset=tuple(rng.uniform(-0.1, 0.1, 2)),
        step_min=tuple(step_min),
        step_max=tuple(step_min + 10.0 ** rng.uniform(-3.0, 0.0, 2)),
        tau_min=tau_min,
        tau_max=tau_min + math.exp(rng.uniform(-3.0, 3.0)),
        offset_min=tuple(offset_min),
        offset_max=tuple(offset_min + 10.0 ** rng.uniform(-3.0, -0.5, 2)),
        step_weight=tuple(weights[:2]),
        tau_weight=weights[2],
        offset_weight=tuple(weights[3:]),
        offset_penalty=10.0 ** rng.uniform(3.0, 7.0),
    )

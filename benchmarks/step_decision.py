"""How long one step decision takes: compiled, and from Python."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numba import njit
from numba.core.runtime import _nrt_python  # type: ignore[attr-defined]
from numba.core.runtime.nrt import rtsys
from numpy.typing import NDArray

import surefoot as sf
from figures import Report
from rounds import Task, time_blocks
from step_problems import StepProblems, iterations_of, solve_block
from surefoot.dcm.step_problem import STEP_SOLUTION
from surefoot.dcm.step_solver import MAX_ITERATIONS
from surefoot.record import new_array

BLOCK = 256
"""Solves between two readings of the clock, so that a call from Python counts little."""

PYTHON_BLOCK = 32
"""The same for calls from Python, which take ten times as long."""


def compiled_task(what: str, problems: StepProblems, target: float | None = None) -> Task:
    """Every decision once, in a compiled loop."""
    solution = new_array(STEP_SOLUTION)
    blocks = [problems.inputs[i : i + BLOCK] for i in range(0, len(problems) - BLOCK + 1, BLOCK)]

    def run(block: NDArray[np.float64]) -> None:
        solve_block(problems.table, block, solution)

    return Task(what, lambda: time_blocks(run, blocks, BLOCK), target=target)


def python_tasks(problems: StepProblems) -> list[Task]:
    """`solve_step` on prepared records, on records with new numbers, and on new problems."""
    prepared = problems.problems()
    numbers = [(tuple(problem.growth), problem.tau_min) for problem in prepared]
    whole = [
        {name: _python(getattr(problem, name)) for name in problem.DTYPE.names or ()}
        for problem in prepared
    ]
    pairs = list(zip(prepared, numbers, strict=True))

    def solve(block: Sequence[sf.StepProblem]) -> None:
        for problem in block:
            sf.solve_step(problem)

    def change(block: Sequence[tuple[sf.StepProblem, tuple[tuple[float, ...], float]]]) -> None:
        for problem, (growth, tau_min) in block:
            sf.solve_step(problem.replace(growth=growth, tau_min=tau_min))

    def build(block: Sequence[dict[str, Any]]) -> None:
        for values in block:
            sf.solve_step(sf.StepProblem(**values))

    return [
        Task(
            "step decision from Python: solve_step",
            lambda: time_blocks(solve, _blocks(prepared), PYTHON_BLOCK),
            target=1e-6,
        ),
        Task(
            "  after StepProblem.replace(growth, tau_min)",
            lambda: time_blocks(change, _blocks(pairs), PYTHON_BLOCK),
        ),
        Task(
            "  after StepProblem(...) with all its checks",
            lambda: time_blocks(build, _blocks(whole), PYTHON_BLOCK),
        ),
    ]


def report_iterations(report: Report, name: str, problems: StepProblems) -> None:
    """Report iterations of these problems, and how many of them violate an offset."""
    iterations, violations = iterations_of(problems)
    report.facts[f"iterations, {name}"] = (
        f"{len(problems)} problems, mean {iterations.mean():.2f}, most {iterations.max()} of "
        f"{MAX_ITERATIONS} allowed; {100.0 * (violations > 1e-6).mean():.1f} % violate an offset"
    )
    report.extra[f"iterations_{name.replace(' ', '_')}"] = np.bincount(
        iterations, minlength=MAX_ITERATIONS + 1
    ).tolist()


def report_allocations(report: Report, problems: StepProblems) -> None:
    """Count allocations: one solve against all of them, and a loop that does allocate."""
    _nrt_python.memsys_enable_stats()
    solution = new_array(STEP_SOLUTION)
    one = _allocations(solve_block, problems.table, problems.inputs[:1], solution)
    many = _allocations(solve_block, problems.table, problems.inputs, solution)
    control = _allocations(_allocating_loop, problems.inputs)
    if many != one or control < len(problems):
        raise RuntimeError(f"allocations: {one} in one solve, {many} in all, control {control}")
    report.facts["allocations"] = (
        f"{many - one} more in {len(problems)} solves than in one "
        f"({control} in a loop that allocates an array each time: the counter counts)"
    )


@njit
def _allocating_loop(inputs):
    total = 0.0
    for i in range(inputs.shape[0]):
        total += np.full(int(inputs[i, 0]) + 1, inputs[i, 1]).sum()
    return total


def _allocations(run: Callable[..., object], *arguments: object) -> int:
    """How often a call of a compiled function allocates; called once before, to be compiled."""
    run(*arguments)
    before = rtsys.get_allocation_stats().alloc
    run(*arguments)
    return rtsys.get_allocation_stats().alloc - before


def _blocks(items: list) -> list[list]:
    """Full blocks of items for calls from Python."""
    starts = range(0, len(items) - PYTHON_BLOCK + 1, PYTHON_BLOCK)
    return [items[i : i + PYTHON_BLOCK] for i in starts]


def _python(value: object) -> object:
    """A pair as a tuple of floats, a number as it is."""
    return tuple(value.tolist()) if isinstance(value, np.ndarray) else value

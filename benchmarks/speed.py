"""Measure how fast Surefoot is: `python benchmarks/speed.py [--quick] [--json FILE]`.

Everything in one run, because only figures of one run can be compared. See README.md beside this
file for what each row means.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

try:
    import daqp  # noqa: F401
    import piqp  # noqa: F401
    import quadprog  # noqa: F401
except ModuleNotFoundError as error:
    sys.exit(f'{error.name} is missing: pip install "surefoot[bench]"')

import numpy as np
from rich.console import Console

import surefoot as sf
from batch_walks import batch_figures
from controller_step import controller_tasks, report_timer
from figures import Report
from installation import installation_figure
from qp_libraries import AGREEMENT, library_tasks
from rounds import Task, measure, timer_overhead
from start_up import start_up_figures
from step_decision import compiled_task, python_tasks, report_allocations, report_iterations
from step_problems import hardest_problems, pushed_decisions, walk_problems

SEED = 20251122

PUSHES = (
    sf.Push(start=1.1, duration=0.2, force=(176.0, 60.0)),
    sf.Push(start=1.1, duration=0.2, force=(0.0, -120.0)),
)
"""Of the walks whose decisions go through the QP libraries; the second violates offset bounds."""


def main() -> None:
    """Run, print the table, and write the file."""
    parser = argparse.ArgumentParser(description="How fast Surefoot is, as figures of one run.")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there, too")
    parser.add_argument("--quick", action="store_true", help="a short run to see that it runs")
    arguments = parser.parse_args()
    console, report = Console(), Report()
    if not console.is_terminal:
        console = Console(width=120)
    console.print("Measuring; please leave the machine alone …")
    report.extra["quick"], report.extra["seed"] = arguments.quick, SEED
    yardstick = measure_decisions(report, arguments.quick)
    report.figures += batch_figures(
        report,
        rounds=1 if arguments.quick else 7,
        duration=2.0 if arguments.quick else 5.0,
        yardstick=yardstick,
    )
    report.figures += start_up_figures(report, console, repeats=1 if arguments.quick else 5)
    report.figures.append(installation_figure(report))
    report.show(console)
    if arguments.json:
        report.write(arguments.json)


def measure_decisions(report: Report, quick: bool) -> Task:
    """Decisions, QP libraries and controller steps, in turns; returns our compiled solve."""
    rng = np.random.default_rng(SEED)
    around_walks = walk_problems(20_000 if quick else 120_000, rng)
    hardest = hardest_problems(2048, rng, draws=50 if quick else 500)
    compared = [
        problem
        for push in PUSHES
        for problem in pushed_decisions((0.5, 0.0), push).take(slice(None, None, 10)).problems()
    ]
    report_iterations(report, "around walks", around_walks)
    report_iterations(report, "hardest", hardest)
    report_allocations(report, around_walks)
    violated = sum(sf.solve_step(problem).violation > 1e-6 for problem in compared)
    libraries, difference = library_tasks(compared)
    report.facts["agreement"] = (
        f"{len(compared)} problems, {violated} of them violating an offset; all libraries within "
        f"{difference:.0e} of our solution (at most {AGREEMENT:.0e} allowed)"
    )
    tasks = [
        compiled_task("step decision, compiled: around walks", around_walks, target=0.15e-6),
        compiled_task("step decision, compiled: the hardest of random ones", hardest),
        *python_tasks(around_walks.take(slice(2048))),
        *libraries,
        *controller_tasks(duration=2.0 if quick else 6.0),
    ]
    report.figures += measure(tasks, rounds=2 if quick else 20)
    report_timer(report, timer_overhead())
    return tasks[0]


if __name__ == "__main__":
    main()

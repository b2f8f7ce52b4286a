"""How long a new process takes: to its first decision, to its first walk, to its help text."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter

import numpy as np
from rich.console import Console

from figures import Figure, Report

HEAVY = ("numpy", "numba", "llvmlite", "scipy", "matplotlib", "msgspec", "click", "rich")
"""Modules that are named if `import surefoot` loads them."""

DECISION = """
import surefoot as sf
controller = sf.HybridController(sf.load_robot("paper-biped"), velocity=(0.5, 0.0))
observation = controller.gait.observation(sf.Side.RIGHT)
controller.step(controller.start(observation), observation)
"""

WALK = """
import surefoot as sf
controller = sf.HybridController(sf.load_robot("paper-biped"), velocity=(0.5, 0.0))
print(sf.simulate(controller, duration=2.0).outcome)
"""

WITHOUT_OPTIONAL = """
import sys
for name in ("scipy", "coverage", "yaml"):
    sys.modules[name] = None  # As if it were not installed.
"""
"""Numba imports these if they are installed; an installation of the core has none of them."""

IMPORT = """
import sys
from time import perf_counter
before = perf_counter()
import surefoot
print(perf_counter() - before, *(name for name in %r if name in sys.modules))
"""


def start_up_figures(report: Report, console: Console, repeats: int) -> list[Figure]:
    """Wall times of new processes, the interpreter's own start included.

    Args:
        report: gets what was not measured.
        console: prints what takes long.
        repeats: processes of each kind; with fewer than three, no compile cache is emptied.
    """
    python = [sys.executable, "-c"]
    run([*python, WALK])
    figures = [
        _timed("interpreter alone: python -c pass", [*python, "pass"], repeats),
        _timed("first decision, warm compile cache", [*python, DECISION], repeats, 1.0),
        _timed(
            "  the same without what the core does not install",
            [*python, WITHOUT_OPTIONAL + DECISION],
            repeats,
            1.0,
        ),
        _timed("first walk of 2 s, warm compile cache", [*python, WALK], repeats),
    ]
    if repeats < 3:
        report.facts["empty compile cache"] = "skipped in a quick run"
    else:
        console.print("Compiling every kernel into an empty cache, twice …")
        for what, code in (("first decision", DECISION), ("first walk of 2 s", WALK)):
            with tempfile.TemporaryDirectory() as folder:
                empty = {"NUMBA_CACHE_DIR": folder}
                figures.append(
                    _timed(f"{what}, EMPTY compile cache", [*python, code], 1, 15.0, empty)
                )
    return figures + _command_line(report, repeats) + _import(report, repeats)


def run(command: Sequence[str], variables: Mapping[str, str] | None = None) -> tuple[float, str]:
    """Wall time [s] and output of a process.

    Raises:
        RuntimeError: it fails.
    """
    environment = {**os.environ, **(variables or {})}
    before = perf_counter()
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    elapsed = perf_counter() - before
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} fails:\n{done.stderr}")
    return elapsed, done.stdout


def _timed(
    what: str,
    command: Sequence[str],
    repeats: int,
    target: float | None = None,
    variables: Mapping[str, str] | None = None,
) -> Figure:
    """The median wall time of a process.

    Not judged where the wall time misses the target but the processor time does not.
    """
    walls, processors = [], []
    for _ in range(repeats):
        before = os.times()
        walls.append(run(command, variables)[0])
        after = os.times()
        processors.append(
            after.children_user
            - before.children_user
            + after.children_system
            - before.children_system
        )
    judged = target is None or float(np.median(processors)) > target
    return Figure(what, float(np.median(walls)), target=target, judged=judged)


def _command_line(report: Report, repeats: int) -> list[Figure]:
    """`surefoot --help`, if the command is installed beside this interpreter."""
    command = Path(sys.executable).with_name("surefoot")
    if not command.exists():
        report.facts["surefoot --help"] = f"skipped, there is no {command.name} command"
        return []
    return [_timed("surefoot --help", [str(command), "--help"], 2 * repeats, 0.15)]


def _import(report: Report, repeats: int) -> list[Figure]:
    """`import surefoot`, without the start of the interpreter, and what it loads."""
    outputs = [run([sys.executable, "-c", IMPORT % (HEAVY,)])[1].split() for _ in range(repeats)]
    loaded = outputs[0][1:]
    report.facts["import surefoot loads"] = ", ".join(loaded) or "none of " + ", ".join(HEAVY)
    report.extra["import_loads"] = loaded
    return [Figure("import surefoot", float(np.median([float(out[0]) for out in outputs])))]

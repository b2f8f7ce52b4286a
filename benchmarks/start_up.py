"""How long a new process takes: to its first decision, to its first walk, to its help text."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

import numpy as np
from rich.console import Console

from figures import Figure, Report

HEAVY = ("numpy", "numba", "llvmlite", "scipy", "matplotlib", "msgspec", "click", "rich")
"""Modules worth naming if `import surefoot` loads them."""

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

WITHOUT_GUESTS = """
import sys
for name in ("scipy", "coverage", "yaml"):
    sys.modules[name] = None  # As if it were not installed.
"""
"""Numba imports these if they are there; an installation of the core has none of them."""

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
        report: where what cannot be measured is said.
        console: for the line that says what takes so long.
        repeats: processes of each kind; with fewer than three, no compile cache is emptied.
    """
    python = [sys.executable, "-c"]
    run([*python, WALK])
    figures = [
        Figure("interpreter alone: python -c pass", _median([*python, "pass"], repeats)),
        Figure("first decision, warm compile cache", _median([*python, DECISION], repeats),
               target=1.0),
        Figure("  the same without what the core does not install",
               _median([*python, WITHOUT_GUESTS + DECISION], repeats), target=1.0),
        Figure("first walk of 2 s, warm compile cache", _median([*python, WALK], repeats)),
    ]  # fmt: skip
    if repeats < 3:
        report.facts["empty compile cache"] = "skipped in a quick run"
    else:
        console.print("Compiling every kernel into an empty cache, twice …")
        figures += [
            Figure("first decision, EMPTY compile cache", _empty_cache(DECISION), target=15.0),
            Figure("first walk of 2 s, EMPTY compile cache", _empty_cache(WALK), target=15.0),
        ]
    return figures + _command_line(report, repeats) + _import(report, repeats)


def run(command: Sequence[str], **variables: str) -> tuple[float, str]:
    """Wall time [s] and output of a process.

    Raises:
        RuntimeError: it fails.
    """
    before = perf_counter()
    done = subprocess.run(
        command, env={**os.environ, **variables}, capture_output=True, text=True, check=False
    )
    elapsed = perf_counter() - before
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} fails:\n{done.stderr}")
    return elapsed, done.stdout


def _median(command: Sequence[str], repeats: int) -> float:
    return float(np.median([run(command)[0] for _ in range(repeats)]))


def _empty_cache(code: str) -> float:
    with tempfile.TemporaryDirectory() as folder:
        return run([sys.executable, "-c", code], NUMBA_CACHE_DIR=folder)[0]


def _command_line(report: Report, repeats: int) -> list[Figure]:
    """`surefoot --help`, if the command is installed beside this interpreter."""
    command = Path(sys.executable).with_name("surefoot")
    if not command.exists():
        report.facts["surefoot --help"] = f"skipped, there is no {command.name} command"
        return []
    times = _median([str(command), "--help"], 2 * repeats)
    return [Figure("surefoot --help", times, target=0.15)]


def _import(report: Report, repeats: int) -> list[Figure]:
    """`import surefoot`, without the start of the interpreter, and what it loads."""
    outputs = [run([sys.executable, "-c", IMPORT % (HEAVY,)])[1].split() for _ in range(repeats)]
    loaded = outputs[0][1:]
    report.facts["import surefoot loads"] = ", ".join(loaded) or "none of " + ", ".join(HEAVY)
    report.extra["import_loads"] = loaded
    return [Figure("import surefoot", float(np.median([float(out[0]) for out in outputs])))]

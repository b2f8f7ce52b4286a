"""Share of the causal limit that the unified controller survives, on random robots.

    python benchmarks/push_shares.py [--cells 300] [--first 0] [--acceleration] [--all-methods]

Every cell is a robot, a gait and a push, drawn by its number (`tests/random_cells.py`). The
impulse is scanned upwards in steps of 2 % of the causal limit (the largest that can be survived
without knowing when the push will end). The result is the largest below which all are survived.
"""

from __future__ import annotations

import argparse
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

import surefoot as sf
from surefoot.control.registry import methods
from surefoot.errors import SurefootError

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from random_cells import RandomCell, random_cell

SHARES = np.arange(0.02, 1.001, 0.02)

GROWTHS = (0.0, 3.0, 5.0, 9.0, 15.0, np.inf)
"""Bins of tau_nom = e^(omega T_nom), by which the cells are grouped."""


def survived(cell: RandomCell, controller: sf.Controller, limit: float) -> float:
    """The largest share below which all are survived."""
    settled = cell.settles(controller, SHARES, limit)
    return float(SHARES[-1] if settled.all() else np.insert(SHARES, 0, 0.0)[np.argmin(settled)])


def other_methods(cell: RandomCell, limit: float) -> dict[str, float]:
    """The same of every other compiled method that walks on this leg with this sole."""
    found = {}
    for method in methods():
        if method.key == "unified" or method.slow:
            continue
        given = {**method.compared, "step_duration": cell.step_duration}
        try:
            controller = method.controller(cell.robot, cell.velocity, **given)
        except SurefootError:
            continue
        if controller.kernel is not None:
            found[method.key] = survived(cell, controller, limit)
    return found


def row(name: str, shares: NDArray[np.float64]) -> tuple[str, ...]:
    """A line of the table."""
    if not len(shares):
        return name, "0", "", "", "", ""
    counts = (int((shares < below - 1e-9).sum()) for below in (0.98, 0.95))
    return name, str(len(shares)), f"{shares.mean():.3f}", f"{shares.min():.2f}", *map(str, counts)


def main() -> None:
    """Measure the cells and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="number of the first cell")
    parser.add_argument("--acceleration", action="store_true", help="limit the leg's, 20-200 m/s^2")
    parser.add_argument("--all-methods", action="store_true", help="measure the other methods too")
    asked = parser.parse_args()
    shares, growths, others, beaten = [], [], {}, 0
    for seed in range(asked.first, asked.first + asked.cells):
        cell = random_cell(seed, acceleration=asked.acceleration)
        limit = cell.causal_limit().impulse
        if limit <= 0.0:
            continue
        shares.append(survived(cell, cell.controller(), limit))
        growths.append(cell.gait.growth)
        if shares[-1] < 0.98:
            print(f"cell {seed}: {shares[-1]:.2f}", flush=True)
        if asked.all_methods and cell.whole_sole:
            found = other_methods(cell, limit)
            for key, share in found.items():
                others.setdefault(key, []).append(share)
            best = max(found, key=lambda key: found[key], default="")
            if best and found[best] > shares[-1] + 1e-9:
                beaten += 1
                print(
                    f"cell {seed}: {best} {found[best]:.2f}, unified {shares[-1]:.2f}", flush=True
                )
    table = Table("tau_nom", "cells", "mean", "worst", "below 0.98", "below 0.95")
    every, growth = np.array(shares), np.array(growths)
    for low, high in pairwise(GROWTHS):
        table.add_row(*row(f"{low:g} to {high:g}", every[(low <= growth) & (growth < high)]))
    table.add_row(*row("all", every))
    for key, found in others.items():
        table.add_row(*row(key, np.array(found)))
    Console().print(table)
    if asked.all_methods:
        print(f"another method survives more in {beaten} cells")


if __name__ == "__main__":
    main()

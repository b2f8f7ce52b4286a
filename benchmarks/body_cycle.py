"""Time of one control cycle of a body: `python benchmarks/body_cycle.py [--quick]`.

Three walks of the paper's biped take turns of a few cycles each, so that a slow moment of the
machine affects all of them: on the true state, and on an estimate from perfect and from noisy
sensors. The last one walks every other turn with its parts timed. See README.md beside this file.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from time import perf_counter_ns
from typing import Any

try:
    import daqp
    import mujoco  # noqa: F401
except ModuleNotFoundError as error:
    sys.exit(f'{error.name} is missing: pip install "surefoot[bench,mujoco]"')

import numpy as np
from rich.console import Console
from rich.table import Table

import surefoot as sf
from surefoot.control.unified.controller import UnifiedController
from surefoot.rollout.trace import WALKING
from surefoot.worlds.body.estimator import BodyEstimator
from surefoot.worlds.body.interface import JointCommand
from surefoot.worlds.body.inverse_dynamics import InverseDynamics
from surefoot.worlds.body.mechanics import Mechanics
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.sensors import BodyNoise, BodySensors

ROBOT, VELOCITY, TURN = "paper-biped", (0.3, 0.0), 20
"""The robot; its velocity [m/s]; cycles of a walk in one turn."""

TARGET = 150.0
"""Of the median cycle on an estimate from noisy sensors [µs]."""

WARM_UP = 5
"""Turns that compile the kernels and are not counted."""

TRUTH, PERFECT, NOISY = "true state", "estimate, perfect sensors", "estimate, noisy sensors"
WALKS = {TRUTH: (None, False), PERFECT: (None, True), NOISY: (BodyNoise(), True)}
"""Noise of the sensors, and whether the state is an estimate."""

WHOLE, REST = "the whole cycle, with the parts timed", "everything else"
MAPPING, UPDATE, SOLVE = "inverse dynamics", "quadratic program into DAQP", "DAQP's solution"
TIMED = {
    "state from the sensors": (BodyEstimator, "step"),
    "mechanism: inertia, Jacobians, momentum": (Mechanics, "update"),
    "controller: landing and ZMP": (UnifiedController, "step"),
    "new velocity, at a touchdown": (UnifiedController, "with_velocity"),
    MAPPING: (InverseDynamics, "joints"),
}
"""Parts of a cycle: class and method."""

Times = dict[str, list[float]]


class Walk:
    """A walk in physics that advances a few cycles at a time.

    Args:
        noise: of the sensors.
        estimated: whether the state is an estimate.
    """

    def __init__(self, noise: BodyNoise | None, estimated: bool) -> None:
        multibody = sf.load_multibody(sf.load_robot(ROBOT))
        controller = sf.body_controller("unified", sf.walking_robot(multibody), VELOCITY)
        self.control = sf.body_control(controller, multibody)
        self.plant = BodyPlant(multibody)
        estimator = BodyEstimator(multibody) if estimated else None
        self.sensors = BodySensors(self.plant, noise, estimator)
        self.state = self.control.start()
        self.command = JointCommand(len(multibody.motors), multibody.model.nv)

    def turn(self) -> Iterator[tuple[str, float]]:
        """Some cycles: kind (stand, step or touchdown) and time [µs] of each."""
        for _ in range(TURN):
            steps = self.state.walk["steps"][0]
            took = self.cycle()
            walk = self.state.walk[0]
            landed = steps and walk["steps"] != steps
            about = "touchdown" if landed else "step"
            yield about if walk["phase"] == WALKING else "stand", took

    def cycle(self) -> float:
        """Time of state, controller and inverse dynamics, without sensors and physics [µs]."""
        time, steering = self.plant.time, sf.Steering(VELOCITY)
        readings = self.sensors.measure(first=self.plant.cycle == 0)
        began = perf_counter_ns()
        body = self.sensors.estimate(readings, self.state, self.command)
        self.command, self.state = self.control.step(self.state, time, *body, steering)
        took = perf_counter_ns() - began
        self.plant.act(self.command)
        return 1e-3 * took


@contextmanager
def timed(owner: Any, name: str, times: list[float]) -> Iterator[None]:
    """Time a method of a class for a while [µs]."""
    method = getattr(owner, name)

    def timing(*arguments: Any, **named: Any) -> Any:
        began = perf_counter_ns()
        result = method(*arguments, **named)
        times.append(1e-3 * (perf_counter_ns() - began))
        return result

    setattr(owner, name, timing)
    yield
    setattr(owner, name, method)


def open_solver(iterations: list[int]) -> type:
    """DAQP's solver as a class whose methods can be timed; it appends its iterations."""

    class Solver(daqp.Model):
        def update(self, **changes: Any) -> Any:
            return super().update(**changes)

        def solve(self) -> Any:
            result = super().solve()
            iterations.append(result[3]["iterations"])
            return result

    return Solver


def walk_in_turns(turns: int) -> tuple[dict[str, Times], Times, list[str]]:
    """Cycles of every walk by kind; parts of the noisy one; lines about what was counted."""
    cycles: dict[str, Times] = {name: defaultdict(list) for name in WALKS}
    iterations: dict[str, list[int]] = {name: [] for name in WALKS}
    parts: Times = defaultdict(list)
    walks, solvers, plain = {}, {}, daqp.Model
    for name, (noise, estimated) in WALKS.items():
        daqp.Model = solvers[name] = open_solver(iterations[name])
        walks[name] = Walk(noise, estimated)
    daqp.Model = plain
    for number in range(turns + WARM_UP):
        for name, walk in walks.items():
            for about, took in walk.turn():
                if number >= WARM_UP:
                    cycles[name][about].append(took)
        with ExitStack() as stack:
            kept = parts if number >= WARM_UP else defaultdict(list)
            for name, (owner, method) in TIMED.items():
                stack.enter_context(timed(owner, method, kept[name]))
            stack.enter_context(timed(solvers[NOISY], "update", kept[UPDATE]))
            stack.enter_context(timed(solvers[NOISY], "solve", kept[SOLVE]))
            kept[WHOLE] += [took for _, took in walks[NOISY].turn()]
    counted = [
        f"{name}: DAQP iterations {np.mean(counts):.2f} a cycle, at most {max(counts)}"
        for name, counts in iterations.items()
    ]
    return cycles, parts, [*counted, calls_of(walks[NOISY])]


def calls_of(walk: Walk) -> str:
    """How many functions one more cycle calls."""
    counts = {"call": 0, "c_call": 0}

    def count(_frame: Any, event: str, _argument: Any) -> None:
        if event in counts:
            counts[event] += 1

    sys.setprofile(count)
    walk.cycle()
    sys.setprofile(None)
    return f"a cycle calls {counts['call']} functions of Python and {counts['c_call']} others"


def show(cycles: dict[str, Times], parts: Times, counted: list[str]) -> None:
    """Print times of cycles and of their parts, and the counted lines."""
    console = Console(width=110)
    table = Table("walk", "cycles", "number", "p50 [µs]", "p99 [µs]", "longest [µs]", "p50 / truth")
    yardstick = float(np.median(cycles[TRUTH]["step"]))
    for name, kinds in cycles.items():
        every = {"all": [one for took in kinds.values() for one in took], **kinds}
        for about, took in every.items():
            p50, p99 = np.percentile(took, (50, 99))
            table.add_row(
                name, about, str(len(took)), f"{p50:.0f}", f"{p99:.0f}", f"{max(took):.0f}",
                f"{p50 / yardstick:.2f}",
            )  # fmt: skip
    console.print(table)
    median = {name: float(np.median(took)) for name, took in parts.items()}
    whole = median[WHOLE]
    # In most cycles no velocity is new.
    rows = {name: median[name] for name in TIMED if len(parts[name]) > 0.5 * len(parts[WHOLE])}
    rows[REST] = whole - sum(rows.values())
    rows[f"of {MAPPING}: {UPDATE}"] = median[UPDATE]
    rows[f"of {MAPPING}: {SOLVE}"] = median[SOLVE]
    table = Table("part of a cycle, noisy sensors", "p50 [µs]", "of the cycle")
    for name, took in rows.items():
        table.add_row(name, f"{took:.1f}", f"{took / whole:.0%}")
    console.print(table)
    for line in counted:
        console.print(line)
    p50 = float(np.median([one for took in cycles[NOISY].values() for one in took]))
    verdict = "met" if p50 <= TARGET else "missed"
    console.print(f"{NOISY}: median {p50:.0f} µs, target {TARGET:.0f} µs {verdict}")


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description="What one cycle of walking a body takes.")
    parser.add_argument("--quick", action="store_true", help="a short run to see that it runs")
    show(*walk_in_turns(150 if parser.parse_args().quick else 500))


if __name__ == "__main__":
    main()

"""Time of the mappings to torques: `python benchmarks/body_mappings.py [--quick]`.

Every robot that is installed walks at 0.3 m/s on its true state with each mapping; the walks take
turns of a few cycles, so that a slow moment of the machine affects all of them. Timed is `joints`
alone: what it needs of the mechanism is computed before, by the same `Mechanics` for all.
"""

from __future__ import annotations

import argparse
from time import perf_counter_ns
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import surefoot as sf
from surefoot.worlds.body.gait import body_control, body_controller, walking_robot
from surefoot.worlds.body.interface import JointCommand
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.sensors import BodySensors

ROBOTS = ("paper-biped", "g1", "talos", "h1")
MAPPINGS = ("inverse-dynamics", "balance-force")
VELOCITY, TURN, WARM_UP = (0.3, 0.0), 20, 100
"""Of the walks [m/s]; cycles in a turn; turns that are not counted: stand and first steps."""


class Walk:
    """A walk in physics whose mapping is timed.

    Args:
        robot: preset.
        mapping: its name.
    """

    def __init__(self, robot: str, mapping: str) -> None:
        multibody = sf.load_multibody(sf.load_robot(robot))
        controller = body_controller("unified", walking_robot(multibody), VELOCITY)
        self.control = body_control(controller, multibody, mapping)
        self.plant = BodyPlant(multibody)
        self.sensors = BodySensors(self.plant, None, None)
        self.state = self.control.start()
        self.command = JointCommand(len(multibody.motors), multibody.model.nv)
        self.times: list[float] = []
        joints = self.control.mapping.joints

        def timing(*arguments: Any) -> Any:
            began = perf_counter_ns()
            result = joints(*arguments)
            self.times.append(1e-3 * (perf_counter_ns() - began))
            return result

        object.__setattr__(self.control.mapping, "joints", timing)

    def turn(self) -> None:
        """Some cycles."""
        steering = sf.Steering(VELOCITY)
        for _ in range(TURN):
            readings = self.sensors.measure(first=self.plant.cycle == 0)
            body = self.sensors.estimate(readings, self.state, self.command)
            time = self.plant.time
            self.command, self.state = self.control.step(self.state, time, *body, steering)
            self.plant.act(self.command)


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description="What a mapping to torques takes.")
    parser.add_argument("--quick", action="store_true", help="a short run to see that it runs")
    turns = 30 if parser.parse_args().quick else 300
    table = Table("robot", "joints", *(f"{name}: p50, p99 [µs]" for name in MAPPINGS), "ratio")
    for robot in ROBOTS:
        walks = [Walk(robot, mapping) for mapping in MAPPINGS]
        for number in range(WARM_UP + turns):
            for walk in walks:
                if number == WARM_UP:
                    walk.times.clear()
                walk.turn()
        p50, p99 = (np.percentile([walk.times for walk in walks], q, axis=1) for q in (50, 99))
        cells = [f"{half:.0f}, {most:.0f}" for half, most in zip(p50, p99, strict=True)]
        motors = len(walks[0].control.multibody.motors)
        table.add_row(robot, str(motors), *cells, f"{p50[1] / p50[0]:.2f}")
    Console(width=110).print(table)


if __name__ == "__main__":
    main()

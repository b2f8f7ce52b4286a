"""A push map's question: what becomes of a robot under every impulse, from any side at any time.

In each cell, a direction and a phase, the impulse goes from zero to the first above the theoretical
limit. The push is in the first step of the walk: the gait is periodic, so the answer is that of any
later step, two steps sooner.

There are two ways. All impulses can be walked. Or, much faster, every tenth or so first, and then
every one between two of which one was survived and the other not: what that misses is a hole
narrower than the coarse step, a failure between two neighbours that were both survived.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.dcm.push_limit import check_leg
from surefoot.dcm.pushes import push_direction
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.plugins import foreign_stamp
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import describe
from surefoot.studies.engine.pushed_walk import check_count
from surefoot.studies.engine.study import Study
from surefoot.studies.engine.table import Row
from surefoot.studies.push_map.measure import measure_cells

COARSE_STEPS = 10
"""How many steps of the scan the fast way takes at once."""

MAX_STRIDE = 200
"""The coarse step is at most so many steps of the scan."""


@dataclass(frozen=True)
class Cell:
    """Pushes of all impulses at one time in one direction.

    Attributes:
        phase: when they begin, as a fraction of the step.
        angle: from forward towards the swing foot [deg].
    """

    phase: float
    angle: float


@dataclass(frozen=True)
class PushMap(Study):
    """Pushes in the first step of a walk, each cell with all impulses up to its limit.

    Args:
        controller: what decides; its robot and velocity are those of the map.
        directions: how many, evenly around; the first is forward, a quarter on is towards the
            swing foot.
        phases: how many, evenly over a step; the first is at its touchdown.
        step: distance between neighbouring impulses [N s].
        coarse: what the fast way looks at first: every impulse that is a multiple of this, and then
            every one between two of which one is survived and the other not. Equal to `step`:
            everything is walked. Ten steps if None [N s].
        push_duration: how long a push lasts [s].
        support_side: the foot that stands when it comes.
        label: of the controller, in words; the name of its class if empty.

    Raises:
        ParameterError: an argument is out of range, or `coarse` no whole number of steps.
    """

    robot: Robot = field(init=False, repr=False)
    controller: Controller
    directions: int = 72
    phases: int = 20
    step: float = 1.0
    coarse: float | None = None
    push_duration: float = 0.2
    support_side: Side = Side.RIGHT
    label: str = ""

    NAME: ClassVar = "push-map"

    def __post_init__(self) -> None:
        object.__setattr__(self, "robot", self.controller.robot)
        check_count("directions", self.directions, 72)
        check_count("phases", self.phases, 20)
        check_number("step", self.step, 0.0, "N s", above=True)
        check_number("push_duration", self.push_duration, 0.0, "s", above=True)
        if self.coarse is None:
            object.__setattr__(self, "coarse", COARSE_STEPS * self.step)
        check_number("coarse", self.coarse or 0.0, 0.0, "N s", above=True)
        stride = self.stride
        if not 1 <= stride <= MAX_STRIDE or not math.isclose(stride * self.step, self.coarse or 0):
            raise ParameterError(
                f"`coarse` as 1 to {MAX_STRIDE} times the step of {self.step:g} N s",
                f"{self.coarse:g} N s",
                f"give {COARSE_STEPS * self.step:g}, or {self.step:g} to walk everything",
            )

    @property
    def stride(self) -> int:
        """The coarse step, counted in steps of the scan."""
        return round((self.coarse or self.step) / self.step)

    @property
    def angles(self) -> list[float]:
        """The directions [deg]."""
        return [360.0 * number / self.directions for number in range(self.directions)]

    @property
    def fractions(self) -> list[float]:
        """The phases, as fractions of the step."""
        return [number / self.phases for number in range(self.phases)]

    def cells(self) -> Iterator[Cell]:
        """All directions at one phase after the other."""
        return (Cell(phase, angle) for phase in self.fractions for angle in self.angles)

    def measure(self, cell: Cell) -> Row:
        """See `measure.cell_row`."""
        return measure_cells(self, [cell])[0]

    def measure_many(self, cells: Sequence[Cell]) -> list[Row | str]:
        """All walks of some cells are one batch."""
        return [*measure_cells(self, cells)]

    def at_once(self) -> int:
        """A phase, or a part of one if there are many directions."""
        return min(self.directions, 24)

    def check(self) -> None:
        """Refuse a leg that is too weak for its gait.

        Raises:
            VelocityError: it is.
        """
        check_leg(self.robot, self.controller.gait)

    def direction(self, angle: float) -> tuple[float, float]:
        """The unit vector (x, y) of a direction [deg] in the world."""
        return push_direction(angle, self.support_side)

    def start(self, cell: Cell) -> float:
        """When the pushes of a cell begin [s]."""
        return cell.phase * self.controller.gait.step_duration

    def count(self, limit: float) -> int:
        """How many impulses a cell has: from 0 to the first above its limit [N s]."""
        return math.floor(limit / self.step) + 2

    def first_look(self, count: int) -> NDArray[np.int64]:
        """Which of so many impulses are walked first: the last two among them, to see that the
        limit is one."""
        multiples = np.arange(0, count, self.stride)
        return np.unique(np.append(multiples, np.arange(max(count - 2, 0), count)))

    def grid(self) -> dict[str, Any]:
        """Which pushes, as plain values."""
        names = ("directions", "phases", "step", "coarse", "push_duration")
        side = self.support_side.name.lower()
        return {name: getattr(self, name) for name in names} | {"support_side": side}

    def foreign_sources(self) -> dict[str, str]:
        """See `Study`."""
        kind = type(self.controller)
        return {kind.__name__: foreign_stamp(inspect.getfile(kind))}

    def common(self) -> dict[str, Any]:
        """The pushes, and who answers them."""
        return {
            **self.grid(),
            "velocity": list(self.controller.gait.velocity),
            "controller": f"{type(self.controller).__name__}({describe(self.controller)})",
        }

    def notes(self, rows: Sequence[Row]) -> dict[str, Any]:
        """The pushes, for readers of the table."""
        return {"grid": self.grid()}

    def provenance(self) -> dict[str, str]:
        """Who was pushed, and how."""
        velocity = self.controller.gait.velocity
        return {
            "mass": f"{self.robot.mass:g} kg",
            "leg speed": f"{self.robot.swing.max_speed:g} m/s",
            "velocity": f"{velocity[0]:g}, {velocity[1]:g} m/s",
            "controller": self.label or type(self.controller).__name__,
            "parameters": describe(self.controller),
            "step": f"{self.step:g} N s",
            "coarse step": f"{self.coarse:g} N s"
            if self.stride > 1
            else "none: all impulses walked",
            "push": f"{self.push_duration:g} s",
        }

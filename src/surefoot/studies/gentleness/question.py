"""How gently a push is answered: how far ZMP, landing and timing leave the nominal gait.

A method that survives large pushes must not be nervous about small ones. So the same pushes, in all
directions and phases, go to two methods, and what each does with them is compared cell by cell.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any, ClassVar

from surefoot.control.registry import find_method
from surefoot.studies.engine.cells import Row
from surefoot.studies.engine.push_answer import answer
from surefoot.studies.engine.pushed_walk import PushCell, PushedWalk, check_sizes, push_cells
from surefoot.studies.engine.study import Study

IMPULSES, LEG_SPEEDS = (5.0, 10.0, 20.0), (3.0, float("inf"))
"""Of the usual table [N s], [m/s]."""

DIRECTIONS, PHASES = 4, 4
"""How many of each."""


@dataclass(frozen=True)
class Cell:
    """One push.

    Attributes:
        leg_speed: limit of the swing foot; inf for none [m/s].
        impulse: of the push [N s].
        method: key of who answers it.
        angle: of the push [deg].
        phase: when it begins, as a fraction of the step.
        push_duration: how long it lasts [s].
    """

    leg_speed: float
    impulse: float
    method: str
    angle: float
    phase: float
    push_duration: float


@dataclass(frozen=True)
class Gentleness(Study):
    """The same pushes to two methods: 0.2 s long, four directions, four phases of a step.

    A row has a cell and what its method did, see `Answer`.

    Args:
        robot: who is pushed; its leg speed is replaced.
        velocity: commanded (v_x, v_y) [m/s].
        impulses: [N s].
        leg_speeds: limits of the swing foot; inf for none [m/s].
        methods: two keys of `control.registry`.

    Raises:
        ParameterError: no such method, or a number is out of range.
        VelocityError: the velocity cannot be walked, or not on the slowest of the legs.
    """

    velocity: tuple[float, float] = (0.5, 0.0)
    impulses: tuple[float, ...] = IMPULSES
    leg_speeds: tuple[float, ...] = LEG_SPEEDS
    methods: tuple[str, str] = ("unified", "hybrid")

    NAME: ClassVar[str] = "gentleness"

    def __post_init__(self) -> None:
        for key in self.methods:
            find_method(key)
        check_sizes("impulses", self.impulses, "N s")
        check_sizes("leg_speeds", self.leg_speeds, "m/s", endless=True)
        for leg_speed in self.leg_speeds:
            self.walk.on_leg(leg_speed).check_leg()

    @property
    def walk(self) -> PushedWalk:
        """What is pushed."""
        return PushedWalk(self.robot, self.velocity)

    def cells(self) -> Iterator[Cell]:
        """See `Study`."""
        for leg_speed, impulse, key, push in product(
            self.leg_speeds, self.impulses, self.methods, push_cells(DIRECTIONS, PHASES)
        ):
            yield Cell(leg_speed, impulse, key, push.angle, push.phase, push.push_duration)

    def measure(self, cell: Cell) -> Row:
        """See `Study`."""
        push = self.walk.push(PushCell(cell.angle, cell.phase, cell.push_duration), cell.impulse)
        return asdict(answer(self.walk.on_leg(cell.leg_speed).controller(cell.method), push))

    def common(self) -> dict[str, Any]:
        """See `Study`."""
        return {"velocity": list(self.velocity)}

    def provenance(self) -> dict[str, str]:
        """See `Study`."""
        vx, vy = self.velocity
        return {"mass": f"{self.robot.mass:g} kg", "velocity": f"{vx:g}, {vy:g} m/s"}

    def check(self) -> None:
        """See `Study`. A method that cannot control this robot is refused."""
        for key in self.methods:
            self.walk.on_leg(self.leg_speeds[0]).controller(key)

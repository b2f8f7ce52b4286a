"""How gently a push is answered: how far ZMP, landing and timing leave the nominal gait.

A method that survives large pushes must not be nervous about small ones. So the same pushes, in all
directions and phases, go to two methods, and what each does with them is compared cell by cell.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import product
from typing import ClassVar

from surefoot.studies.engine.pushed_walk import (
    PushCell,
    PushedStudy,
    answer,
    check_sizes,
    push_cells,
)
from surefoot.studies.engine.table import Row

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
class Gentleness(PushedStudy):
    """The same pushes to two methods: 0.2 s long, four directions, four phases of a step.

    A row has a cell and what its method did, see `Answer`.

    Args, beside those of `PushedStudy`:
        methods: two of them.
        impulses: [N s].
    """

    methods: tuple[str, str] = ("unified", "hybrid")
    leg_speeds: tuple[float, ...] = LEG_SPEEDS
    impulses: tuple[float, ...] = IMPULSES

    NAME: ClassVar[str] = "gentleness"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_sizes("impulses", self.impulses, "N s")

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

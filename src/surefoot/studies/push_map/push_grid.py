"""Which pushes a push map asks about: directions, phases of a step, impulses to the limit."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.dcm.pushes import push_direction
from surefoot.errors import ParameterError
from surefoot.robot.feet import Side

COARSE_STEPS = 10
"""How many steps of the scan the fast way takes at once."""

MOST_STEPS = 200
"""The coarse step is at most so many steps of the scan."""


@dataclass(frozen=True)
class PushGrid:
    """Pushes in the first step of a walk, each cell with all impulses up to its limit.

    Args:
        directions: how many, evenly around; the first is forward, a quarter on is towards the
            swing foot.
        phases: how many, evenly over a step; the first is at its touchdown.
        step: distance between neighbouring impulses [N s].
        coarse: what the fast way looks at first: every impulse that is a multiple of this, and then
            every one between two of which one is survived and the other not. Equal to `step`:
            everything is walked. Ten steps if None [N s].
        push_duration: how long a push lasts [s].
        support_side: the foot that stands when it comes.

    Raises:
        ParameterError: an argument is out of range, or `coarse` no whole number of steps.
    """

    directions: int = 72
    phases: int = 20
    step: float = 1.0
    coarse: float | None = None
    push_duration: float = 0.2
    support_side: Side = Side.RIGHT

    def __post_init__(self) -> None:
        for name, usual in (("directions", 72), ("phases", 20)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < 1:
                raise ParameterError(
                    f"`{name}` as a whole number of at least 1", repr(value), f"{usual} is usual"
                )
        check_number("step", self.step, 0.0, "N s", above=True)
        check_number("push_duration", self.push_duration, 0.0, "s", above=True)
        if self.coarse is None:
            object.__setattr__(self, "coarse", COARSE_STEPS * self.step)
        check_number("coarse", self.coarse or 0.0, 0.0, "N s", above=True)
        stride = self.stride
        if not 1 <= stride <= MOST_STEPS or not math.isclose(stride * self.step, self.coarse or 0):
            raise ParameterError(
                f"`coarse` as 1 to {MOST_STEPS} times the step of {self.step:g} N s",
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

    def direction(self, angle: float) -> tuple[float, float]:
        """The unit vector (x, y) of a direction [deg] in the world."""
        return push_direction(angle, self.support_side)

    def count(self, limit: float) -> int:
        """How many impulses a cell has: from 0 to the first above its limit [N s]."""
        return math.floor(limit / self.step) + 2

    def first_look(self, count: int) -> NDArray[np.int64]:
        """Which of so many impulses are walked first: the last two among them, to see that the
        limit is one."""
        multiples = np.arange(0, count, self.stride)
        return np.unique(np.append(multiples, np.arange(max(count - 2, 0), count)))

    def as_numbers(self) -> dict[str, Any]:
        """What a file says of it."""
        return asdict(self) | {"support_side": self.support_side.name.lower()}

"""Why a body fell: the first trouble.

Each kind of trouble shows as a sign in the trace (`rollout.fall_signs`). From the
fall backwards, sign follows sign until there was none for a while: the first one of that chain is
the cause.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surefoot.robot.robot import STANDARD_GRAVITY
from surefoot.rollout.fall_signs import SIGNS, FallCause, FallenWalk, Sign

if TYPE_CHECKING:
    from surefoot.rollout.trace import BodyTrace

Array = NDArray[Any]

QUIET = 2.8
"""A time without a sign of trouble: what happened before it has nothing to do with the fall, in
1 / omega."""

CROSSED = 1
"""The fate of a body whose legs met."""

ENDINGS = {
    CROSSED: "its legs met",
    2: "another part than a sole touched the floor",
    3: "its trunk leaned too far",
    4: "it sank too low",
}
"""How a fall ends; keys as in `worlds.body.plant`."""


@dataclass(frozen=True, kw_only=True)
class BodyFall(Sign):
    """Why a body fell: the first sign of trouble, and the end.

    Attributes:
        end: when it was down [s].
        ending: how that showed.
    """

    end: float
    ending: str

    @property
    def sentence(self) -> str:
        """For people: cause, when, what was seen, and the end."""
        if self.cause is FallCause.CROSSING:
            return f"{self.cause.value} at {self.time:.2f} s: {self.words}"
        return (
            f"{self.cause.value} at {self.time:.2f} s: {self.words}; "
            f"at {self.end:.2f} s {self.ending}"
        )


def find_fall(observations: Array, commands: Array, trace: BodyTrace) -> BodyFall:
    """The cause of a fall.

    Args:
        observations, commands: of the rollout that ended with it.
        trace: of its body.
    """
    weight = trace.robot.mass * STANDARD_GRAVITY
    walk = FallenWalk(observations["time"], observations, commands, trace, weight)
    end = float(walk.time[-1]) + walk.period
    signs = sorted((sign for find in SIGNS for sign in find(walk)), key=lambda sign: sign.time)
    chain: list[Sign] = []
    quiet = QUIET * walk.own.time
    for sign in reversed(signs):
        if sign.time < (chain[-1].time if chain else end) - quiet:
            break
        chain.append(sign)
    first = chain[-1] if chain else None
    if first is None and trace.fate == CROSSED:
        first = Sign(FallCause.CROSSING, end, "one leg met the other")
    sign = first or _fallen_over(walk, end)
    return BodyFall(**vars(sign), end=end, ending=ENDINGS.get(trace.fate, "it was down"))


def _fallen_over(walk: FallenWalk, end: float) -> Sign:
    """Without another sign: it fell about the feet that it stood on."""
    if not walk.trace.walking[-1]:
        return Sign(FallCause.IN_A_STAND, end, "its legs did not hold it")
    away = walk.seen["dcm"][-1] - walk.seen["support_foot"][-1]
    distance = float(np.hypot(*away))
    words = f"the DCM ran {100.0 * distance:.0f} cm away from the standing foot"
    return Sign(FallCause.OUT_OF_REACH, end, words, "", {"distance": distance})

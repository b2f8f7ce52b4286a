"""Words that reports of studies share: the rule of recovery, and numbers as people read them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from surefoot.dcm.pushes import DIRECTIONS
from surefoot.rollout.outcome import (
    RECOVERY_STEPS,
    RECOVERY_TIME,
    SETTLED_ROOM,
    SETTLED_VELOCITY,
)

TIME_WORDS = (
    f"{RECOVERY_TIME:g}/ω (8 s on the paper's biped), or {RECOVERY_STEPS:g} steps where these take "
    "longer,"
)
"""How long a push is looked after."""

RECOVERED_WORDS = (
    f"Recovered means that the robot never falls and that within {TIME_WORDS} it is back on its "
    f"gait: the DCM error of a whole step is below {100.0 * SETTLED_ROOM:g} % of what the gait has "
    "room for (1 cm on the paper's biped), and the mean velocity is within "
    f"{100.0 * SETTLED_VELOCITY:g} % of the command."
)
"""The rule of `rollout.outcome`."""


def speed_words(leg_speed: float) -> str:
    """How fast the swing foot may be."""
    return "unlimited leg speed" if math.isinf(leg_speed) else f"leg speed {leg_speed:g} m/s"


def angle_words(angle: float) -> str:
    """A direction, by its name if it has one."""
    names = {value: name for name, value in DIRECTIONS.items()}
    return names.get(angle, f"{angle:g}°")


def count_words(count: int, what: str, several: str = "") -> str:
    """How many of something there are: "1 method", "2 methods"."""
    return f"{count} {what}" if count == 1 else f"{count} {several or what + 's'}"


def percent(fraction: float) -> str:
    """A fraction of the limit, – where there is none."""
    return "–" if math.isnan(fraction) else f"{100.0 * fraction:.0f} %"


def time_words(seconds: float) -> str:
    """A time with the unit in which it is short, – where it is not known."""
    if math.isnan(seconds):
        return "–"
    for unit, scale in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= scale:
            return f"{seconds / scale:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def list_words(values: Sequence[float]) -> str:
    """Numbers one after the other."""
    texts = [f"{value:g}" for value in values]
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} and {texts[-1]}"

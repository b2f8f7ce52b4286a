"""How close it was, in words and numbers: the smallest margin, and what was at its limit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.control.unified.problem import Limit
from surefoot.rollout.rollout import Rollout

LIMIT_WORDS = {
    Limit.ZMP_X: "ZMP in x",
    Limit.ZMP_Y: "ZMP in y",
    Limit.STEP_X: "step box in x",
    Limit.STEP_Y: "step box in y",
    Limit.LEG_X: "leg in x",
    Limit.LEG_Y: "leg in y",
    Limit.SHORTEST: "shortest step",
    Limit.LONGEST: "longest step",
    Limit.RESERVE: "reserve",
    Limit.LOST: "lost, if it lasts",
}
"""A name for each limit, in the order in which they are shown."""

_NO_CLOSER = 1e-6
"""Margins that differ by less are the same: the first of them counts [m]."""


def closest_call(rollout: Rollout, decided: NDArray[np.void]) -> dict[str, Any]:
    """The cycle in which least could be saved, or the first in which nothing could.

    Args:
        rollout: the walk.
        decided: its decisions (`surefoot.decisions`).

    Returns:
        `margin` [m], negative if it was too late; `time` [s]; `limits`, the names of those that
        were active, as of `Limit`.
    """
    margin = decided["margin"]
    lost = np.flatnonzero(margin < 0.0)
    near = lost if len(lost) else np.flatnonzero(margin <= margin.min() + _NO_CLOSER)
    cycle = int(near[0])
    return {
        "margin": float(margin[cycle]),
        "time": float(rollout.time[cycle]),
        "limits": [limit.name for limit in LIMIT_WORDS if decided["active"][cycle] & limit],
    }


def margin_sentence(call: dict[str, Any]) -> str:
    """A `closest_call` as a sentence."""
    names = [LIMIT_WORDS[Limit[name]] for name in call["limits"] if name not in ("RESERVE", "LOST")]
    held = f"at their limits: {', '.join(names)}" if names else "no limit was reached"
    if call["margin"] < 0.0:
        return f"nothing could save it from {call['time']:.3f} s on; {held}"
    return f"smallest margin {1e3 * call['margin']:.1f} mm at {call['time']:.3f} s; {held}"

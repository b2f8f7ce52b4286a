"""A walk in plain words: titles, commands, pushes, the fall, and what was at its limit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.control.unified.problem import Limit
from surefoot.dcm.pushes import Push
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout
from surefoot.show.stances import Commanded, acting_pushes, commanded, walks_on_footholds

DIRECTIONS = (
    "forward", "forward left", "left", "backward left",
    "backward", "backward right", "right", "forward right",
)  # fmt: skip
"""Eight of them, counter-clockwise."""

STAND = "stand"
"""The command of a body to come to a stand."""

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

_ENDINGS = {
    Outcome.WALKED: "walked on",
    Outcome.RECOVERED: "recovered",
    Outcome.UNSETTLED: "not settled when the run ended",
    Outcome.FELL: "fell",
    Outcome.CUT_SHORT: "its end is lost",
}


def title(rollout: Rollout) -> list[str]:
    """Robot, velocity, controller, pushes and outcome, each in its own words."""
    parts = [
        f"{rollout.robot.name}, {_course(rollout)}",
        rollout.controller,
        _pushes(rollout),
        _ENDINGS[rollout.outcome],
    ]
    return [part for part in parts if part]


def fall_evidence(rollout: Rollout) -> str:
    """When and how it fell, and when it was lost; empty if it did not fall."""
    fall = rollout.fall
    if fall is None:
        return ""
    if rollout.body_fall is not None:
        return f"fell: {rollout.body_fall.sentence}"
    words = (
        f"fell {_towards(fall.limit)} at {fall.time:.2f} s, "
        f"the DCM {fall.distance:.2f} m from the support foot"
    )
    if fall.lost_time is not None and fall.lost_margin is not None:
        words += (
            f"; lost at the touchdown at {fall.lost_time:.2f} s, the DCM offset "
            f"{-1e3 * fall.lost_margin:.0f} mm outside what further steps can save"
        )
        before = "it was {:.0f} mm inside at the touchdown before, at {:.2f} s"
    else:
        before = "further steps could save it by {:.0f} mm at the last touchdown, at {:.2f} s"
    if fall.last_viable_time is not None and fall.last_margin is not None:
        words += "; " + before.format(1e3 * fall.last_margin, fall.last_viable_time)
    return words


def push_label(push: Push) -> str:
    """Force, duration and impulse: "176 N × 0.2 s = 35.2 N s"."""
    force = math.hypot(*push.force)
    if math.isinf(push.duration):
        return f"{_number(force)} N from {_number(push.start)} s on"
    return f"{_number(force)} N × {_number(push.duration)} s = {_number(force * push.duration)} N s"


def velocity_words(velocity: tuple[float, float]) -> str:
    """A velocity in words: "0.3 m/s forward, 0.15 m/s left"."""
    names = (("forward", "backward"), ("left", "right"))
    words = [
        f"{_number(abs(speed))} m/s {positive if speed > 0.0 else negative}"
        for speed, (positive, negative) in zip(velocity, names, strict=True)
        if speed != 0.0
    ]
    return ", ".join(words) or "in place"


def command_words(command: Commanded) -> str:
    """A command in words: "0.3 m/s forward, turning +0.2 rad/s", counter-clockwise, or "stand"."""
    if command.standing:
        return STAND
    turning = f", turning {command.turning:+.2g} rad/s" if command.turning else ""
    return velocity_words(command.velocity) + turning


def command_label(command: Commanded) -> str:
    """A command for a plot in which there is little room: "0.3, 0 m/s, +0.2 rad/s"."""
    if command.standing:
        return STAND
    x, y = command.velocity
    return f"{x:g}, {y:g} m/s" + (f", {command.turning:+g} rad/s" if command.turning else "")


def direction_words(angle: float) -> str:
    """An angle, counter-clockwise from forward [rad], as the nearest of eight directions."""
    return DIRECTIONS[round(angle / (0.25 * math.pi)) % 8]


def finite(value: float) -> float | None:
    """A number for machines, None if it is infinite or NaN."""
    return float(value) if math.isfinite(value) else None


def counted(count: int, noun: str) -> str:
    """A number of things, "1 step" or "2 steps"; of a noun whose plural ends in s."""
    return f"{count} {noun}{'s' * (count != 1)}"


def _course(rollout: Rollout) -> str:
    if walks_on_footholds(rollout):
        return "on footholds"
    commands = [command_words(command) for command in commanded(rollout)]
    if len(commands) > 2:
        if commands[-1] == STAND:
            return f"{len(commands) - 1} commanded velocities, then {STAND}"
        return f"{len(commands)} commanded velocities, the last {commands[-1]}"
    return ", then ".join(commands)


def _pushes(rollout: Rollout) -> str:
    pushes = acting_pushes(rollout)
    if not pushes:
        return ""
    if len(pushes) == 1 and math.isinf(pushes[0].duration):
        push = pushes[0]
        return (
            f"pushed {_direction(push.force)} by {_number(math.hypot(*push.force))} N without end"
        )
    # What acted within the run, since the impulse of a force without end is no number.
    impulse = sum(_impulse_within(push, rollout) for push in pushes)
    words = f"{_number(impulse)} N s ({_number(impulse / rollout.mass, 3)} m/s)"
    if len(pushes) > 1:
        return f"{len(pushes)} pushes of {words} in all"
    return f"pushed {_direction(pushes[0].force)} with {words}"


def _impulse_within(push: Push, rollout: Rollout) -> float:
    """The size of the impulse that acted before the run ended [N s]."""
    seconds = min(push.end, rollout.time[-1]) - max(push.start, rollout.time[0])
    return math.hypot(*push.force) * float(seconds)


def _direction(vector: tuple[float, float]) -> str:
    return direction_words(math.atan2(vector[1], vector[0]))


def _towards(limit: str) -> str:
    return limit if limit in ("forward", "backward") else f"to the {limit}"


def _number(value: float, digits: int = 4) -> str:
    """A few significant digits, as people write them."""
    return f"{value:.{digits}g}" if abs(value) < 1000.0 else f"{value:.0f}"


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

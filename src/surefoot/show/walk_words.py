"""A walk in plain words: the title of a picture, and what stands beside a push."""

from __future__ import annotations

import math

from surefoot.dcm.pushes import Push
from surefoot.rollout.outcome import Outcome
from surefoot.rollout.rollout import Rollout
from surefoot.show.stances import acting_pushes

DIRECTIONS = (
    "forward", "forward left", "left", "backward left",
    "backward", "backward right", "right", "forward right",
)  # fmt: skip
"""Eight of them, counter-clockwise."""

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
        f"{rollout.robot.name}, {_velocities(rollout)}",
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


def _velocities(rollout: Rollout) -> str:
    commanded = [velocity for _, velocity in rollout.velocities]
    if len(commanded) > 2:
        return f"{len(commanded)} commanded velocities, the last {velocity_words(commanded[-1])}"
    return ", then ".join(map(velocity_words, commanded))


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
    """The direction of a vector to the nearest of eight."""
    return DIRECTIONS[round(math.atan2(vector[1], vector[0]) / (0.25 * math.pi)) % 8]


def _towards(limit: str) -> str:
    return limit if limit in ("forward", "backward") else f"to the {limit}"


def _number(value: float, digits: int = 4) -> str:
    """A few significant digits, as people write them."""
    return f"{value:.{digits}g}" if abs(value) < 1000.0 else f"{value:.0f}"

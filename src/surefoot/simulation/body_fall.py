"""Why a body fell: what went wrong first.

Each kind of trouble has a sign that can be seen in the trace. From the fall backwards, sign follows
sign until there was none for a while: the first one of that chain is the cause.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.models.footsteps import Side
from surefoot.models.interfaces import Status
from surefoot.models.lipm import STANDARD_GRAVITY
from surefoot.models.motors import torque_range
from surefoot.models.plane import rotated_by
from surefoot.models.viability import viable_offsets
from surefoot.simulation.body_trace import FEET, BodyTrace

Array = NDArray[Any]

QUIET = 0.8
"""Without a sign of trouble, before which what happened had nothing to do with the fall [s]."""

SLIP_WAY, SLIP_SPEED, SLIP_TIME = 0.03, 0.2, 0.04
"""A standing sole has slipped that is this far from where it came to rest [m], or moves at this
speed [m/s] for that long [s]."""

LOADED = 0.2
"""A sole stands that carries at least this part of the weight [-]."""

FLAT = 0.1
"""A sole that is tilted further rolls over an edge rather than slips [rad]."""

REST_TIME = 0.05
"""From touchdown until the sole is at rest [s]."""

AT_LIMIT, LIMIT_TIME, LIMIT_PART = 0.98, 0.1, 0.8
"""A motor is at its limit that gives this part of what it can [-], for most [-] of so long [s]."""

OFF_TARGET = 0.06
"""A foot that lands so far from its target was too slow [m]."""

UNREACHABLE_TIME = 0.02
"""For so long the leg must be told to be too slow [s]."""

TRIP_SPEED, TRIP_PART, LIFT_TIME = 0.3, 0.8, 0.1
"""A swinging sole trips that meets the floor at this speed [m/s] before this part of its step [-],
but for the time in which it leaves the ground [s]."""

TOUCH = 0.03
"""A sole touches the ground that carries this part of the weight [-]."""

LATE = 0.08
"""A foot that has not landed so long after its time has missed the ground [s]."""

CROSSED = 1
"""The fate of a body whose legs met."""

ENDINGS = {
    CROSSED: "its legs met",
    2: "another part than a sole touched the floor",
    3: "its trunk leaned too far",
    4: "it sank too low",
}
"""What the plant saw in the end; keys as in `simulation.body_plant`."""


class FallCause(Enum):
    """What went wrong first."""

    SLIP = "slip"
    """The standing sole slid."""
    TORQUE_LIMIT = "torque limit"
    """A motor gave all it could for a tenth of a second."""
    LEG_TOO_SLOW = "leg too slow"
    """The swing foot could not be at its target in time."""
    CROSSING = "crossing"
    """The legs met."""
    TRIP = "trip"
    """The swing foot met the floor on its way."""
    MISSED_GROUND = "missed ground"
    """The swing foot did not land in time."""
    OUT_OF_REACH = "out of reach"
    """The DCM was where no step within the limits could catch it."""


@dataclass(frozen=True)
class Sign:
    """A sign of trouble.

    Attributes:
        cause: of which kind.
        time: when it began [s].
        words: what was seen.
        part: of the body that it was seen at.
        evidence: numbers, SI.
    """

    cause: FallCause
    time: float
    words: str
    part: str = ""
    evidence: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class BodyFall:
    """Why a body fell.

    Attributes:
        cause: what went wrong first.
        time: when that began [s].
        words: what was seen of it.
        part: of the body that it was seen at; may be empty.
        evidence: numbers, SI.
        end: when it was down [s].
        ending: how that showed.
    """

    cause: FallCause
    time: float
    words: str
    part: str
    evidence: dict[str, float]
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


@dataclass(frozen=True)
class _Walk:
    """What the signs are looked for in."""

    time: Array
    seen: Array
    commands: Array
    trace: BodyTrace
    weight: float

    @property
    def period(self) -> float:
        return float(self.time[1] - self.time[0]) if len(self.time) > 1 else 0.001

    def stances(self) -> Iterator[tuple[int, int, int]]:
        """First row, one past the last row and foot of every time that one foot carries."""
        trace = self.trace
        key = np.where(trace.walking, trace.steps, -1)
        cuts = [0, *(np.flatnonzero(np.diff(key)) + 1).tolist(), len(key)]
        for first, last in pairwise(cuts):
            if trace.walking[first]:
                yield first, last, int(trace.support[first])


def find_fall(observations: Array, commands: Array, trace: BodyTrace) -> BodyFall:
    """The cause of a fall.

    Args:
        observations, commands: of the rollout that ended with it.
        trace: of its body.
    """
    weight = trace.robot.mass * STANDARD_GRAVITY
    walk = _Walk(observations["time"], observations, commands, trace, weight)
    end = float(walk.time[-1]) + walk.period
    signs = sorted((sign for look in _SIGNS for sign in look(walk)), key=lambda sign: sign.time)
    chain: list[Sign] = []
    for sign in reversed(signs):
        if sign.time < (chain[-1].time if chain else end) - QUIET:
            break
        chain.append(sign)
    first = chain[-1] if chain else None
    if first is None and trace.fate == CROSSED:
        first = Sign(FallCause.CROSSING, end, "one leg met the other")
    sign = first or _last_resort(walk, end)
    return BodyFall(
        sign.cause, sign.time, sign.words, sign.part, sign.evidence, end,
        ENDINGS.get(trace.fate, "it was down"),
    )  # fmt: skip


def _lasting(flags: Array, rows: int, part: float = 1.0) -> list[int]:
    """First rows of spells of `rows` rows of which at least a part is set, one a spell."""
    if len(flags) < rows:
        return []
    count = np.convolve(flags.astype(float), np.ones(rows), "valid")
    full = count >= part * rows - 1e-9
    starts = np.flatnonzero(full & ~np.concatenate(([False], full[:-1])))
    return starts.tolist()


def _slips(walk: _Walk) -> Iterator[Sign]:
    trace, rest = walk.trace, round(REST_TIME / walk.period)
    rows = round(SLIP_TIME / walk.period)
    for first, last, foot in walk.stances():
        span = slice(first + rest, last)
        place = trace.sole_position[span, foot, :2]
        if len(place) < 2:
            continue
        stands = trace.sole_force[span, foot, 2] > LOADED * walk.weight
        stands &= np.abs(trace.sole_turn[span, foot, :2]).max(axis=1) < FLAT
        speed = np.hypot(*np.gradient(place, walk.period, axis=0).T)
        way = np.hypot(*(place - place[0]).T)
        fast = _lasting(stands & (speed > SLIP_SPEED), rows)
        far = np.flatnonzero(stands & (way > SLIP_WAY))[:1].tolist()
        if fast or far:
            at = min(fast + far)
            most, top = float(way.max()), float(speed[at:].max())
            yield Sign(
                FallCause.SLIP,
                float(walk.time[span][at]),
                f"the {FEET[foot]} sole slid by {100.0 * most:.0f} cm while it stood",
                FEET[foot],
                {"way": most, "speed": top},
            )


def _torque_limits(walk: _Walk) -> Iterator[Sign]:
    trace, rows = walk.trace, round(LIMIT_TIME / walk.period)
    most = np.minimum(trace.torque_limit, 1e9)
    fastest = np.minimum(trace.speed_limit, 1e9)
    speed = trace.joint_velocities.astype(float)
    least, largest = np.vectorize(torque_range)(most, speed, fastest)
    given = trace.torque
    # The float32 of the trace is off by a ten-millionth of the torque.
    at_limit = (given >= AT_LIMIT * largest) | (given <= AT_LIMIT * least)
    at_limit &= np.abs(given) > 0.05 * most
    for motor, name in enumerate(trace.joints):
        for at in _lasting(at_limit[:, motor], rows, LIMIT_PART):
            torque = float(np.abs(given[at : at + rows, motor]).max())
            yield Sign(
                FallCause.TORQUE_LIMIT,
                float(walk.time[at]),
                f"{name} gave all it could, {torque:.0f} N m",
                name,
                {"torque": torque, "limit": float(trace.torque_limit[motor])},
            )


def _slow_legs(walk: _Walk) -> Iterator[Sign]:
    trace, rows = walk.trace, round(UNREACHABLE_TIME / walk.period)
    told = (walk.commands["status"] & Status.UNREACHABLE) != 0
    for first, last, foot in walk.stances():
        swing = 1 - foot
        spells = _lasting(told[first:last], rows)
        if spells:
            yield Sign(
                FallCause.LEG_TOO_SLOW,
                float(walk.time[first + spells[0]]),
                f"the {FEET[swing]} foot could not be at its landing in time",
                FEET[swing],
            )
        if last < len(walk.time):
            target = walk.commands["step_location"][last - 1]
            off = float(np.hypot(*(trace.sole_position[last, swing, :2] - target)))
            if off > OFF_TARGET:
                yield Sign(
                    FallCause.LEG_TOO_SLOW,
                    float(walk.time[last]),
                    f"the {FEET[swing]} foot landed {100.0 * off:.0f} cm from its target",
                    FEET[swing],
                    {"distance": off},
                )


def _trips(walk: _Walk) -> Iterator[Sign]:
    trace = walk.trace
    for first, last, foot in walk.stances():
        swing, elapsed = 1 - foot, walk.time[first:last] - walk.time[first]
        place = trace.sole_position[first:last, swing, :2]
        if len(place) < 2:
            continue
        speed = np.hypot(*np.gradient(place, walk.period, axis=0).T)
        early = (elapsed > LIFT_TIME) & (
            elapsed < TRIP_PART * walk.commands["step_duration"][first:last]
        )
        meets = trace.sole_force[first:last, swing, 2] > TOUCH * walk.weight
        # The floor stops the foot: how fast it came shows before.
        before = np.maximum.accumulate(np.where(elapsed > LIFT_TIME, speed, 0.0))
        at = np.flatnonzero(early & meets & (before > TRIP_SPEED))
        if len(at):
            fast = float(before[at[0]])
            yield Sign(
                FallCause.TRIP,
                float(walk.time[first + at[0]]),
                f"the {FEET[swing]} foot met the floor on its way, at {fast:.1f} m/s",
                FEET[swing],
                {"speed": fast},
            )


def _missed_grounds(walk: _Walk) -> Iterator[Sign]:
    for first, last, foot in walk.stances():
        elapsed = walk.time[first:last] - walk.time[first]
        late = np.flatnonzero(elapsed > walk.commands["step_duration"][first:last] + LATE)
        if len(late):
            swing = 1 - foot
            height = float(walk.trace.clearance[first + late[0], swing])
            yield Sign(
                FallCause.MISSED_GROUND,
                float(walk.time[first + late[0]]),
                f"the {FEET[swing]} foot was {100.0 * height:.0f} cm above the floor "
                f"{1e3 * LATE:.0f} ms after its time",
                FEET[swing],
                {"height": height},
            )


def _out_of_reach(walk: _Walk) -> Iterator[Sign]:
    """The DCM is where no landing, however early or late, leaves one that can be saved.

    From the standing foot it may be as far as the furthest step and the largest viable offset after
    it, less what it still grows until then.
    """
    believed = walk.trace.believed
    half, times = np.array(believed.foot.half), believed.gait.step_duration
    for first, last, foot in walk.stances():
        seen, side = walk.seen[first:last], Side(2 * foot - 1)
        away = rotated_by(seen["dcm"] - seen["support_foot"], -seen["support_yaw"])
        boxes = zip(believed.gait.step_box(side, believed.hip), _offsets(walk, side), strict=True)
        low, high = (np.add(step, offset) for step, offset in boxes)
        left = [np.maximum(time - seen["elapsed"], 0.0)[:, None] for time in times]
        soon, late = (np.exp(-walk.trace.omega * time) for time in left)
        past = away - np.maximum(high * soon, high * late) - half * (1.0 - soon)
        before = np.minimum(low * soon, low * late) - half * (1.0 - soon) - away
        beyond = np.maximum(past, before).max(axis=1)
        at = np.flatnonzero(beyond > 0.0)[:1]
        if len(at):
            distance, most = float(np.hypot(*away[at[0]])), float(beyond[at[0] :].max())
            yield Sign(
                FallCause.OUT_OF_REACH,
                float(walk.time[first + at[0]]),
                f"the DCM was {100.0 * distance:.0f} cm from the {FEET[foot]} foot, where no step "
                "could save it",
                "",
                {"distance": distance, "beyond": most},
            )


def _offsets(walk: _Walk, side: Side) -> tuple[tuple[float, float], tuple[float, float]]:
    """Least and largest viable offset at the end of a step."""
    viable = viable_offsets(walk.trace.believed, side, walk.trace.believed.foot.half)
    return viable.lower, viable.upper


_SIGNS: tuple[Callable[[_Walk], Iterator[Sign]], ...] = (
    _slips,
    _torque_limits,
    _slow_legs,
    _trips,
    _missed_grounds,
    _out_of_reach,
)


def _last_resort(walk: _Walk, end: float) -> Sign:
    """Nothing else was seen: it fell about the feet that it stood on."""
    away = walk.seen["dcm"][-1] - walk.seen["support_foot"][-1]
    distance = float(np.hypot(*away))
    words = f"the DCM ran {100.0 * distance:.0f} cm away from the standing foot"
    if not walk.trace.walking[-1]:
        words = "it fell while it stood on both feet"
    return Sign(FallCause.OUT_OF_REACH, end, words, "", {"distance": distance})

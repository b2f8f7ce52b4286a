"""Signs of trouble in a walk of a body: each kind of it as it shows in the trace."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.viability import viable_offsets
from surefoot.geometry import rotated_by
from surefoot.interface import Status
from surefoot.robot.feet import FEET, Side
from surefoot.robot.motors import torque_range
from surefoot.robot.own_units import OwnUnits

if TYPE_CHECKING:
    from surefoot.rollout.trace import BodyTrace

Array = NDArray[Any]

SLIP_WAY, SLIP_SPEED, SLIP_TIME = 0.0375, 0.0714, 0.14
"""A standing sole has slipped that is this far from where it came to rest, or moves at this speed
for that long; in `OwnUnits`, as all lengths, times and speeds of this file: heights of the CoM,
1 / omega, sqrt(g h)."""

LOADED = 0.2
"""A sole stands that carries at least this part of the weight [-]."""

FLAT = 0.1
"""A sole that is tilted further rolls over an edge rather than slips [rad]."""

REST_TIME = 0.175
"""From touchdown until the sole is at rest."""

AT_LIMIT, LIMIT_TIME, LIMIT_PART = 0.98, 0.35, 0.8
"""A motor is at its limit that gives this part of what it can [-], for most [-] of so long."""

OFF_TARGET = 0.075
"""A foot that lands so far from its target was too slow."""

UNREACHABLE_TIME = 0.07
"""For so long the status of the decision must be `UNREACHABLE`."""

TRIP_SPEED, TRIP_PART, LIFT_TIME = 0.107, 0.8, 0.35
"""A swinging sole trips that meets the floor at this speed before this part of its step [-], but
for the time in which it leaves the ground."""

TOUCH = 0.03
"""A sole touches the ground that carries this part of the weight [-]."""

LATE = 0.28
"""A foot that has not landed so long after its time has missed the ground."""


class FallCause(Enum):
    """The first trouble."""

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
    IN_A_STAND = "in a stand"
    """It stood on both feet, with no step under way, and did not stay up."""


@dataclass(frozen=True)
class Sign:
    """A sign of trouble.

    Attributes:
        cause: of which kind.
        time: when it began [s].
        words: what happened.
        part: of the body where it shows; may be empty.
        evidence: numbers, SI.
    """

    cause: FallCause
    time: float
    words: str
    part: str = ""
    evidence: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class FallenWalk:
    """The walk whose signs are found."""

    time: Array
    seen: Array
    commands: Array
    trace: BodyTrace
    weight: float

    @property
    def period(self) -> float:
        """Of control [s]."""
        return float(self.time[1] - self.time[0]) if len(self.time) > 1 else 0.001

    @cached_property
    def own(self) -> OwnUnits:
        """What the robot's lengths, times and speeds are measured in."""
        return OwnUnits.of(self.trace.robot)

    def rows(self, time: float) -> int:
        """In how many cycles a time passes, at least one [1 / omega]."""
        return max(round(time * self.own.time / self.period), 1)

    def stances(self) -> Iterator[tuple[int, int, int]]:
        """First row, one past the last row and foot of every time that one foot carries."""
        trace = self.trace
        key = np.where(trace.walking, trace.steps, -1)
        cuts = [0, *(np.flatnonzero(np.diff(key)) + 1).tolist(), len(key)]
        for first, last in pairwise(cuts):
            if trace.walking[first]:
                yield first, last, int(trace.support[first])


def _lasting(flags: Array, rows: int, part: float = 1.0) -> list[int]:
    """First rows of spells of `rows` rows of which at least a part is set, one a spell."""
    if len(flags) < rows:
        return []
    count = np.convolve(flags.astype(float), np.ones(rows), "valid")
    full = count >= part * rows - 1e-9
    starts = np.flatnonzero(full & ~np.concatenate(([False], full[:-1])))
    return starts.tolist()


def _slips(walk: FallenWalk) -> Iterator[Sign]:
    trace, rest = walk.trace, walk.rows(REST_TIME)
    rows = walk.rows(SLIP_TIME)
    for first, last, foot in walk.stances():
        span = slice(first + rest, last)
        place = trace.sole_position[span, foot, :2]
        if len(place) < 2:
            continue
        stands = trace.sole_force[span, foot, 2] > LOADED * walk.weight
        stands &= np.abs(trace.sole_turn[span, foot, :2]).max(axis=1) < FLAT
        speed = np.hypot(*np.gradient(place, walk.period, axis=0).T)
        way = np.hypot(*(place - place[0]).T)
        fast = _lasting(stands & (speed > SLIP_SPEED * walk.own.speed), rows)
        far = np.flatnonzero(stands & (way > SLIP_WAY * walk.own.length))[:1].tolist()
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


def _torque_limits(walk: FallenWalk) -> Iterator[Sign]:
    trace, rows = walk.trace, walk.rows(LIMIT_TIME)
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


def _slow_legs(walk: FallenWalk) -> Iterator[Sign]:
    trace, rows = walk.trace, walk.rows(UNREACHABLE_TIME)
    slow = (walk.commands["status"] & Status.UNREACHABLE) != 0
    for first, last, foot in walk.stances():
        swing = 1 - foot
        spells = _lasting(slow[first:last], rows)
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
            if off > OFF_TARGET * walk.own.length:
                yield Sign(
                    FallCause.LEG_TOO_SLOW,
                    float(walk.time[last]),
                    f"the {FEET[swing]} foot landed {100.0 * off:.0f} cm from its target",
                    FEET[swing],
                    {"distance": off},
                )


def _trips(walk: FallenWalk) -> Iterator[Sign]:
    trace, lift = walk.trace, LIFT_TIME * walk.own.time
    for first, last, foot in walk.stances():
        swing, elapsed = 1 - foot, walk.time[first:last] - walk.time[first]
        place = trace.sole_position[first:last, swing, :2]
        if len(place) < 2:
            continue
        speed = np.hypot(*np.gradient(place, walk.period, axis=0).T)
        load = trace.sole_force[first:last, swing, 2]
        early = (elapsed > lift) & (
            elapsed < TRIP_PART * walk.commands["step_duration"][first:last]
        )
        # The floor stops the foot: how fast it came shows in the last cycle without a force.
        free = np.maximum.accumulate(np.where(load > 0.0, 0, np.arange(len(load))))
        came = np.maximum(speed, np.where(elapsed[free] > lift, speed[free], 0.0))
        at = np.flatnonzero(
            early & (load > TOUCH * walk.weight) & (came > TRIP_SPEED * walk.own.speed)
        )[:1]
        if len(at):
            row = first + int(at[0])
            fast, high = float(came[at[0]]), float(trace.sole_position[row, swing, 2])
            yield Sign(
                FallCause.TRIP,
                float(walk.time[row]),
                f"the {FEET[swing]} foot met the floor on its way, at {fast:.1f} m/s, the middle "
                f"of its sole {100.0 * high:.0f} cm high",
                FEET[swing],
                {"speed": fast, "height": high},
            )


def _missed_grounds(walk: FallenWalk) -> Iterator[Sign]:
    late_by = LATE * walk.own.time
    for first, last, foot in walk.stances():
        elapsed = walk.time[first:last] - walk.time[first]
        late = np.flatnonzero(elapsed > walk.commands["step_duration"][first:last] + late_by)
        if len(late):
            swing = 1 - foot
            height = float(walk.trace.clearance[first + late[0], swing])
            yield Sign(
                FallCause.MISSED_GROUND,
                float(walk.time[first + late[0]]),
                f"the {FEET[swing]} foot was {100.0 * height:.0f} cm above the floor "
                f"{1e3 * late_by:.0f} ms after its time",
                FEET[swing],
                {"height": height},
            )


def _out_of_reach(walk: FallenWalk) -> Iterator[Sign]:
    """The DCM is where no landing, however early or late, leaves one that can be saved.

    From the standing foot it may be as far as the longest step and the largest viable offset after
    it, less what it still grows until then about the edge of the sole.
    """
    believed = walk.trace.believed
    half, times = sole_edge(walk.trace), believed.gait.step_duration
    for first, last, foot in walk.stances():
        seen, side = walk.seen[first:last], Side(2 * foot - 1)
        away = rotated_by(seen["dcm"] - seen["support_foot"], -seen["support_yaw"])
        boxes = zip(believed.gait.step_box(side, believed.hip), _offsets(walk, side), strict=True)
        low, high = (np.add(step, offset) for step, offset in boxes)
        left = [np.maximum(time - seen["elapsed"], 0.0)[:, None] for time in times]
        parts = np.exp(-walk.trace.omega * left[0]), np.exp(-walk.trace.omega * left[1])
        past, before = away - max_dcm(high, half, parts), -away - max_dcm(-low, half, parts)
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


def sole_edge(trace: BodyTrace) -> Array:
    """How far the ZMP can be from the middle of a sole, ahead and across [m].

    To the edge of the real sole, though the controller keeps away from it; across no further than
    the controller believes if the ankle cannot push there.
    """
    ahead, across = trace.robot.foot.half
    body = trace.robot.body
    if body is not None and body.ankle_roll == "passive":
        across = trace.believed.foot.half[1]
    return np.array([ahead, across])


def max_dcm(most: Array, edge: Array, parts: tuple[Array, Array]) -> Array:
    """How far the DCM may be to one side [m], for a landing that leaves it no further than `most`.

    With the ZMP at the edge e of the sole, DCM(T) = e + (DCM - e) e^(omega T) <= most, so
    DCM <= e + (most - e) e^(-omega T). The best T is one of the ends: the soonest landing if `most`
    is beyond the edge, and else the latest one.

    Args:
        most: from the standing foot, when the other one lands [m].
        edge: of the standing sole, to that side [m].
        parts: e^(-omega T) of the soonest and of the latest landing.
    """
    soon, late = parts
    return edge + np.maximum((most - edge) * soon, (most - edge) * late)


def _tips(walk: FallenWalk) -> Iterator[Sign]:
    """In its last stand, from when on the DCM was not over its feet, nor between them."""
    walking, foot = walk.trace.walking, walk.trace.robot.foot
    if walking[-1]:
        return
    first = int(np.flatnonzero(walking)[-1]) + 1 if walking.any() else 0
    centres, yaw = walk.trace.sole_position[first:, :, :2], walk.trace.sole_turn[first:, :, 2]
    # Along and across the first foot's heading, from the middle of both.
    heading = yaw[:, 0]
    spread = np.abs(rotated_by(centres[:, 0] - centres[:, 1], -heading))
    away = rotated_by(walk.seen["dcm"][first:] - centres.mean(axis=1), -heading)
    outside = (np.abs(away) - 0.5 * spread - np.array(foot.half)).max(axis=1)
    inside = np.flatnonzero(outside <= 0.0)
    begin = int(inside[-1]) + 1 if len(inside) else 0
    if begin < len(outside):
        most = float(outside[begin:].max())
        yield Sign(
            FallCause.IN_A_STAND,
            float(walk.time[first + begin]),
            f"the DCM left the feet, by {100.0 * most:.0f} cm in the end",
            "",
            {"beyond": most},
        )


def _offsets(walk: FallenWalk, side: Side) -> tuple[tuple[float, float], tuple[float, float]]:
    """Least and largest viable offset at the end of a step."""
    x, y = sole_edge(walk.trace)
    viable = viable_offsets(walk.trace.believed, side, (float(x), float(y)))
    return viable.lower, viable.upper


SIGNS: tuple[Callable[[FallenWalk], Iterator[Sign]], ...] = (
    _slips,
    _torque_limits,
    _slow_legs,
    _trips,
    _missed_grounds,
    _out_of_reach,
    _tips,
)
"""All kinds; each finds its signs in a walk."""

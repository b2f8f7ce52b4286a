"""The largest discounted displacement that steps of a leg of limited speed can still bring about.

From the DCM e relative to the support foot, e' = omega (e - p), follows the value of a landing at l
after a time T: e^(-omega T) (l + Z(l)), where Z(l) is the value of all that comes after it. The
swing foot then starts |l| behind, at rest, and takes a time t(d) for a way d, so Z depends on the
step just taken:

    x:  Z(L)   = max over l of e^(-omega T) (l + Z(l)),      T = max(T_min, t(|l + L|))
    y:  Z_p(w) = max over l of e^(-omega T) (l + Z_m(l)),    T = max(T_min, t(|l - w|))
        Z_m(w) = max over l of e^(-omega T) (-l + Z_p(l))

With the leg's speed V and acceleration A, t(d) = sqrt(2 d / A), past V^2 / (2 A) it is
d / V + V / (2 A): see `dcm.leg`. y and the widths w, l count towards the swing foot, whose side
alternates; Z_p holds what is outward, Z_m what is inward, and backward steps have a table of their
own. Where l + Z(l) is negative the robot has to wait instead, T = T_max: see `dcm.viability`,
whose bounds these are for V = A = inf. An offset e is viable if -Z_m(w) <= e <= Z_p(w); a ZMP that
reaches c widens both ends by exactly c. Own derivation; the viable set without a leg is that of
[Khadiv2016].
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from surefoot.compiled import njit
from surefoot.dcm.leg import arrival, furthest
from surefoot.errors import RobotError
from surefoot.record import Array, Record, Vector2, field
from surefoot.robot.robot import Robot, Swing

NODES = 101
"""Landings at which a displacement is kept, evenly over the step box: errors of 1e-5."""

TOLERANCE = 1e-13
"""The fixed point has been found when no value moves further than this part of the box [-]."""

_ROUNDS = 20
"""How often the values follow the same landings before these are chosen again."""

BEHIND = (-1.0, 1.0)
"""Where a step l leaves the new swing foot, per l, in the frame of its own step: x, y."""

_SLACK = 1e-12
"""Fraction of a time limit that rounding may exceed."""


@njit(forceinline=True)
def interpolate(values, low: float, spacing: float, landing: float) -> float:
    """A table on even nodes, linear between them and constant beyond its ends.

    Args:
        values: at low, low + spacing, ... [m].
        low, spacing: of the nodes [m].
        landing: where to read [m].
    """
    last = values.shape[0] - 1
    place = min(max((landing - low) / spacing, 0.0), 1.0 * last)
    node = min(int(place), last - 1)
    return values[node] + (place - node) * (values[node + 1] - values[node])


@njit(forceinline=True)
def value_after(values, low, spacing, place):
    """Z after a landing, and its slope there: linear between nodes, and beyond the last ones.

    Args:
        values: Z at low, low + spacing, ... [m].
        low, spacing: of the nodes [m].
        place: of the landing [m].
    """
    part = (place - low) / spacing
    node = min(max(int(part), 0), values.shape[0] - 2)
    left = values[node]
    slope = (values[node + 1] - left) / spacing
    return left + slope * (place - low - node * spacing), slope


@njit
def landing_value(tables, after, axis, sign, swing, times, landing) -> float:
    """The value of one landing now, e^(-omega T) (sign l + Z(l)) [m]; -inf if out of reach.

    Args:
        tables, after, axis, sign, swing, times: as of `displacement_to_come`.
        landing: l [m].
    """
    (foot, velocity), (earliest, latest) = swing, times
    speed, acceleration, omega = tables.max_speed, tables.max_acceleration, tables.omega
    time = arrival(landing - foot, velocity, earliest, speed, acceleration)
    if time > latest * (1.0 + _SLACK):
        return -math.inf
    value = sign * landing + interpolate(after, tables.low[axis], tables.spacing[axis], landing)
    if value > 0.0:
        return value * math.exp(-omega * time)
    late = arrival(landing - foot, velocity, latest, speed, acceleration)
    # A fast foot that will run past the place has to land before.
    return value * math.exp(-omega * (latest if late <= latest * (1.0 + _SLACK) else time))


@njit
def displacement_to_come(tables, after, axis, sign, swing, times) -> tuple[float, float]:
    """The best landing of the step under way, and its value now.

    The maximum over l of e^(-omega T) (sign l + Z(l)) for the piecewise linear Z: at a node, at a
    corner of the reach, or where the derivative is zero. With an unlimited acceleration its
    logarithm is concave where it counts, so the maximum lies beside the best node; otherwise to
    land at once and to come up to speed first may both be good, and every interval is searched.

    Args:
        tables: a `ViableDisplacement` record, of which the nodes and the leg count.
        after: Z at its nodes, the table of what comes AFTER the landing [m].
        axis: 0 for x, 1 for y.
        sign: +1 for a displacement along the axis, -1 against it.
        swing: swing foot and its velocity, in the axis of the landings [m, m/s].
        times: least and largest time from now to the landing [s].

    Returns:
        The displacement [m] and the landing [m]; -inf if no landing can be reached in time.
    """
    last, low, spacing = after.shape[0] - 1, tables.low[axis], tables.spacing[axis]
    speed, acceleration = tables.max_speed, tables.max_acceleration
    (foot, velocity), (earliest, latest) = swing, times
    landing = min(max(foot, low), low + last * spacing)
    best = landing_value(tables, after, axis, sign, swing, times, landing)
    nearest = min(int((landing - low) / spacing), last)
    for node in range(last + 1):
        place = low + node * spacing
        value = landing_value(tables, after, axis, sign, swing, times, place)
        if value > best:
            best, landing, nearest = value, place, node
    if speed == math.inf and acceleration == math.inf:
        return best, landing
    first, final = max(nearest - 1, 0), min(nearest + 1, last - 1)
    if acceleration < math.inf:
        first, final = 0, last - 1
    for way in (-1.0, 1.0):
        corners = (
            foot + way * furthest(way * velocity, earliest, speed, acceleration),
            foot + way * furthest(way * velocity, latest, speed, acceleration),
        )
        for node in range(first, final + 1):
            start = low + node * spacing
            slope = sign + (after[node + 1] - after[node]) / spacing
            level = sign * start + after[node]
            still = _stationary(
                level, slope, foot - start, velocity, way, speed, acceleration, tables.omega
            )
            for k in range(5):
                place = corners[k] if k < 2 else start + still[k - 2]
                if abs(place - start - 0.5 * spacing) > spacing:
                    continue
                place = min(max(place, start), start + spacing)
                value = landing_value(tables, after, axis, sign, swing, times, place)
                if value > best:
                    best, landing = value, place
    return best, landing


@njit
def _stationary(level, slope, foot, velocity, way, speed, acceleration, omega):
    """Where e^(-omega T) (level + slope l) has no derivative in T, l being as far as the foot gets.

    At the speed limit l moves by way V, before by v + way A T. `foot` and the places found are
    relative to the place of `level`; a NaN for each that there is not.
    """
    none = math.nan
    if slope == 0.0:
        return none, none, none
    coasting = way * speed / omega - level / slope if speed < math.inf else none
    if acceleration == math.inf:
        return coasting, none, none
    # (v + way A T) = omega (level / slope + foot + v T + way A T^2 / 2), over way A
    half = 1.0 / omega - way * velocity / acceleration
    rest = way * (level / slope + foot - velocity / omega) / acceleration
    root = half * half - 2.0 * rest
    if root < 0.0:
        return coasting, none, none
    early, late = half - math.sqrt(root), half + math.sqrt(root)
    return (
        coasting,
        foot + early * (velocity + 0.5 * way * acceleration * early),
        foot + late * (velocity + 0.5 * way * acceleration * late),
    )


@njit
def _fixed_point(axis, tolerance, tables):
    """Find both tables of an axis of a `ViableDisplacement`, to a tolerance [m].

    Every landing at its best, then some rounds with these landings kept, until nothing moves: each
    round is a contraction by at least e^(-omega T_min), so it ends.
    """
    low, spacing, values = tables.low[axis], tables.spacing[axis], tables.values[axis]
    times = (tables.step_duration[0], tables.step_duration[1])
    landings = np.empty_like(values)
    change = math.inf
    while change > tolerance:
        change = 0.0
        for kept in range(_ROUNDS):
            for k in range(2):
                # Across, the next foot's inward is this foot's outward: the sides alternate.
                after, sign = values[k] if axis == 0 else values[1 - k], 1.0 - 2.0 * k
                for node in range(values.shape[1]):
                    # At rest, where the step just taken has left it.
                    swing = (BEHIND[axis] * (low + node * spacing), 0.0)
                    if kept:
                        values[k, node] = landing_value(
                            tables, after, axis, sign, swing, times, landings[k, node]
                        )
                        continue
                    value, landings[k, node] = displacement_to_come(
                        tables, after, axis, sign, swing, times
                    )
                    change = max(change, abs(value - values[k, node]))
                    values[k, node] = value


class ViableDisplacement(Record):
    """The tables Z of a robot, on evenly spaced steps."""

    low: Vector2 = field("m", "the first step (x, y), in y as a width towards the swing foot")
    spacing: Vector2 = field("m", "between neighbouring steps (x, y)")
    values: Array = field(
        "m",
        "Z by axis x or y, then along the axis or against it (forward, backward; outward, inward), "
        "then the step just taken",
        shape=(2, 2, NODES),
    )
    step_duration: Vector2 = field("s", "T_min, T_max")
    max_speed: float = field("m/s", "V, may be inf")
    max_acceleration: float = field("m/s^2", "A, may be inf")
    omega: float = field("1/s", "natural frequency")

    def after_step(self, axis: int, sign: int, step: float) -> float:
        """Z: the largest viable offset `sign` e right after a step, for a point foot [m].

        Args:
            axis: 0 for x; 1 for y, towards the swing foot of the foot that has just landed.
            sign: +1 along the axis, -1 against it.
            step: the step just taken, in y its width [m].
        """
        table = self.values[axis, 0 if sign > 0 else 1]
        return float(interpolate(table, float(self.low[axis]), float(self.spacing[axis]), step))

    def in_step(
        self, axis: int, sign: int, foot: float, elapsed: float, foot_velocity: float = 0.0
    ) -> float:
        """The largest viable offset `sign` e in the middle of a step, for a point foot [m].

        Args:
            axis: 0 for x; 1 for y, towards the swing foot.
            sign: +1 along the axis, -1 against it.
            foot: the swing foot, relative to the support foot [m].
            elapsed: t, time since touchdown [s].
            foot_velocity: of the swing foot, likewise; it counts where A is finite [m/s].

        Returns:
            The offset; -inf if the foot cannot land inside the step box in time.
        """
        against = 0 if sign > 0 else 1
        after = self.values[axis, against if axis == 0 else 1 - against]
        shortest, longest = (float(time) for time in self.step_duration)
        earliest = max(shortest - elapsed, 0.0)
        value, _ = displacement_to_come(
            self.array[0], after, axis, float(sign), (float(foot), float(foot_velocity)),
            (earliest, max(longest - elapsed, earliest)),
        )  # fmt: skip
        return float(value)


@lru_cache(maxsize=64)
def viable_displacement(robot: Robot) -> ViableDisplacement:
    """The tables Z of a robot for its own leg, `robot.swing`.

    Raises:
        RobotError: the leg cannot bring the foot back into the step box within T_max.
    """
    backward, forward = robot.gait.step_x
    swing, longest = robot.swing, robot.gait.step_duration[1]
    _check_way_back(swing, abs(forward + backward), longest)
    width = (forward - backward, robot.gait.step_y[1] - robot.gait.step_y[0])
    tables = ViableDisplacement(
        low=(backward, robot.hip + robot.gait.step_y[0]),
        spacing=(width[0] / (NODES - 1), width[1] / (NODES - 1)),
        values=0.0,
        step_duration=robot.gait.step_duration,
        max_speed=swing.max_speed,
        max_acceleration=swing.max_acceleration,
        omega=robot.omega,
    )
    for axis in range(2):
        _fixed_point(axis, TOLERANCE * width[axis], tables.array[0])
    return tables


def _check_way_back(swing: Swing, way: float, time: float) -> None:
    """Refuse a leg that takes longer than this from the longest step to the other end of the box.

    Raises:
        RobotError: it does.
    """
    why = "or no step in the box can follow on the longest one in time"
    if swing.max_speed < way / time:
        raise RobotError(
            f"`max_speed` of the swing of at least {way / time:.4g} [m/s], {why}",
            f"{swing.max_speed}",
            "give the leg its true speed",
        )
    if furthest(0.0, time, swing.max_speed, swing.max_acceleration) < way:
        raise RobotError(
            f"a larger `max_acceleration` of the swing [m/s^2], {why}",
            f"{swing.max_acceleration}",
            "give the leg its true acceleration",
        )

"""The largest discounted displacement that steps of a leg of limited speed can still bring about.

From the DCM e relative to the support foot, e' = omega (e - p), follows what a landing at l after
a time T is worth now: e^(-omega T) (l + Z(l)), where Z(l) is worth all that comes after it. The
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
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.dcm.leg import arrival, furthest
from surefoot.errors import RobotError
from surefoot.robot.robot import Robot, Swing

NODES = 101
"""Landings at which a displacement is kept, evenly over the step box: errors of 1e-5."""

TOLERANCE = 1e-13
"""The fixed point has been found when no value moves further than this part of the box [-]."""

_ROUNDS = 20
"""How often the values follow the same landings before these are chosen again."""

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


@njit
def landing_worth(
    values, low: float, spacing: float, sign: float, foot: float, velocity: float,
    earliest: float, latest: float, speed: float, acceleration: float, omega: float, landing: float,
) -> float:  # fmt: skip
    """What one landing is worth now, e^(-omega T) (sign l + Z(l)) [m]; -inf if out of reach.

    Arguments as of `displacement_to_come`.
    """
    time = arrival(landing - foot, velocity, earliest, speed, acceleration)
    if time > latest * (1.0 + _SLACK):
        return -math.inf
    worth = sign * landing + interpolate(values, low, spacing, landing)
    if worth > 0.0:
        return worth * math.exp(-omega * time)
    late = arrival(landing - foot, velocity, latest, speed, acceleration)
    # A fast foot that will run past the place has to land before.
    return worth * math.exp(-omega * (latest if late <= latest * (1.0 + _SLACK) else time))


@njit
def displacement_to_come(
    values, low: float, spacing: float, sign: float, foot: float, velocity: float,
    earliest: float, latest: float, speed: float, acceleration: float, omega: float,
) -> tuple[float, float]:  # fmt: skip
    """The best landing of the step under way, and what it is worth now.

    The maximum over l of e^(-omega T) (sign l + Z(l)) for the piecewise linear Z: at a node, at a
    corner of the reach, or where the derivative is zero. With an unlimited acceleration its
    logarithm is concave where it counts, so the maximum lies beside the best node; otherwise to
    land at once and to come up to speed first may both be good, and every interval is searched.

    Args:
        values: Z at evenly spaced landings, the table of what comes AFTER the landing [m].
        low, spacing: of the landings [m].
        sign: +1 for a displacement along the axis, -1 against it.
        foot, velocity: of the swing foot [m, m/s], in the axis of the landings.
        earliest, latest: least and largest time from now to the landing [s].
        speed, acceleration: V and A, limits of the swing foot, may be inf [m/s, m/s^2].
        omega: natural frequency [1/s].

    Returns:
        The displacement [m] and the landing [m]; -inf if no landing can be reached in time.
    """
    last = values.shape[0] - 1
    landing = min(max(foot, low), low + last * spacing)
    best = landing_worth(
        values, low, spacing, sign, foot, velocity,
        earliest, latest, speed, acceleration, omega, landing,
    )  # fmt: skip
    nearest = min(int((landing - low) / spacing), last)
    for node in range(last + 1):
        place = low + node * spacing
        worth = landing_worth(
            values, low, spacing, sign, foot, velocity,
            earliest, latest, speed, acceleration, omega, place,
        )  # fmt: skip
        if worth > best:
            best, landing, nearest = worth, place, node
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
            slope = sign + (values[node + 1] - values[node]) / spacing
            level = sign * start + values[node]
            still = _stationary(
                level, slope, foot - start, velocity, way, speed, acceleration, omega
            )  # fmt: skip
            for k in range(5):
                place = corners[k] if k < 2 else start + still[k - 2]
                if abs(place - start - 0.5 * spacing) > spacing:
                    continue
                place = min(max(place, start), start + spacing)
                worth = landing_worth(
                    values, low, spacing, sign, foot, velocity,
                    earliest, latest, speed, acceleration, omega, place,
                )  # fmt: skip
                if worth > best:
                    best, landing = worth, place
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
def _fixed_point(
    values, low, spacing, behind, earliest, latest, speed, acceleration, omega, tolerance
):  # fmt: skip
    """Find both tables of an axis, in place; step l leaves the swing foot at `behind` l, at rest.

    Every landing at its best, then some rounds with these landings kept, until nothing moves: each
    round is a contraction by at least e^(-omega T_min), so it ends.
    """
    landings = np.empty_like(values)
    change = math.inf
    while change > tolerance:
        change = 0.0
        for kept in range(_ROUNDS):
            for k in range(2):
                # Across, the next foot's inward is this foot's outward: the sides alternate.
                after, sign = values[k] if behind < 0.0 else values[1 - k], 1.0 - 2.0 * k
                for node in range(values.shape[1]):
                    foot = behind * (low + node * spacing)
                    if kept:
                        values[k, node] = landing_worth(
                            after, low, spacing, sign, foot, 0.0,
                            earliest, latest, speed, acceleration, omega, landings[k, node],
                        )  # fmt: skip
                        continue
                    worth, landings[k, node] = displacement_to_come(
                        after, low, spacing, sign, foot, 0.0,
                        earliest, latest, speed, acceleration, omega,
                    )  # fmt: skip
                    change = max(change, abs(worth - values[k, node]))
                    values[k, node] = worth


@dataclass(frozen=True)
class ViableDisplacement:
    """The tables Z of a robot, on evenly spaced steps.

    Attributes:
        low: the first step (x, y), in y as a width towards the swing foot [m].
        spacing: between neighbouring steps (x, y) [m].
        values: Z, shape (2, 2, NODES) [m]: axis x or y, then along the axis or against it (forward,
            backward; outward, inward), then the step just taken. Read-only.
        step_duration: T_min, T_max [s].
        max_speed: V [m/s].
        max_acceleration: A [m/s^2].
        omega: natural frequency [1/s].
    """

    low: tuple[float, float]
    spacing: tuple[float, float]
    values: NDArray[np.float64]
    step_duration: tuple[float, float]
    max_speed: float
    max_acceleration: float
    omega: float

    def after_step(self, axis: int, sign: int, step: float) -> float:
        """Z: the largest viable offset `sign` e right after a step, for a point foot [m].

        Args:
            axis: 0 for x; 1 for y, towards the swing foot of the foot that has just landed.
            sign: +1 along the axis, -1 against it.
            step: the step just taken, in y its width [m].
        """
        table = self.values[axis, 0 if sign > 0 else 1]
        return float(interpolate(table, self.low[axis], self.spacing[axis], step))

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
        shortest, longest = self.step_duration
        earliest = max(shortest - elapsed, 0.0)
        worth, _ = displacement_to_come(
            after, self.low[axis], self.spacing[axis], float(sign), foot, foot_velocity,
            earliest, max(longest - elapsed, earliest),
            self.max_speed, self.max_acceleration, self.omega,
        )  # fmt: skip
        return float(worth)


@lru_cache(maxsize=64)
def viable_displacement(robot: Robot) -> ViableDisplacement:
    """The tables Z of a robot for its own leg, `robot.swing`.

    Raises:
        RobotError: the leg cannot bring the foot back into the step box within T_max.
    """
    backward, forward = robot.gait.step_x
    swing, longest = robot.swing, robot.gait.step_duration[1]
    _check_way_back(swing, abs(forward + backward), longest)
    low = (backward, robot.hip + robot.gait.step_y[0])
    width = (forward - backward, robot.gait.step_y[1] - robot.gait.step_y[0])
    spacing = (width[0] / (NODES - 1), width[1] / (NODES - 1))
    values = np.zeros((2, 2, NODES))
    for axis, behind in enumerate((-1.0, 1.0)):
        _fixed_point(
            values[axis], low[axis], spacing[axis], behind, *robot.gait.step_duration,
            swing.max_speed, swing.max_acceleration, robot.omega, TOLERANCE * width[axis],
        )  # fmt: skip
    values.flags.writeable = False
    return ViableDisplacement(
        low, spacing, values, robot.gait.step_duration,
        swing.max_speed, swing.max_acceleration, robot.omega,
    )  # fmt: skip


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

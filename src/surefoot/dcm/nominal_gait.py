"""The nominal gait for a commanded velocity: Eqs. (10)-(19) of [OnlineGait].

Two corrections: the bracket of Eq. (18) is misplaced, and the offset at the END of a step belongs
to the next foot, so the sign of s flips there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.viable_displacement import viable_displacement
from surefoot.errors import ParameterError, VelocityError
from surefoot.interface import Observation
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

QUINTIC_PEAK = 1.875
"""Largest speed of a quintic from rest to rest, over its mean speed."""

QUINTIC_ACCELERATION = 10.0 / math.sqrt(3.0)
"""Its largest acceleration, times duration over mean speed."""

EDGE = 1e-7
"""How far a nominal step keeps from the end of its box, as a fraction of it. A gait on the very end
has no step left that takes back an error forward, and rounding grows by e^(omega T) in each."""

ROUNDING = 1e-9
"""A velocity that is faster than the largest one by this fraction is the largest one."""


@dataclass(frozen=True)
class NominalGait:
    """The periodic gait that walks at the commanded velocity.

    Attributes:
        velocity: mean velocity (v_x, v_y) [m/s].
        step_duration: T_nom [s].
        step_length: X_nom [m].
        lateral_step: Y_nom, the sideways step beside the alternating hip width [m].
        hip: lateral distance of the sole centres [m].
        omega: natural frequency [1/s].
    """

    velocity: tuple[float, float]
    step_duration: float
    step_length: float
    lateral_step: float
    hip: float
    omega: float

    @property
    def growth(self) -> float:
        """G = tau_nom = e^(omega T_nom), the growth of the DCM over one step."""
        return math.exp(self.omega * self.step_duration)

    @property
    def swing_speed(self) -> float:
        """Largest speed along an axis of the smooth way from foothold to foothold [m/s]."""
        return QUINTIC_PEAK * self._stride / self.step_duration

    @property
    def swing_acceleration(self) -> float:
        """Likewise the largest acceleration along an axis [m/s^2]."""
        return QUINTIC_ACCELERATION * self._stride / self.step_duration**2

    @property
    def _stride(self) -> float:
        """Way of the swing foot along the longer axis [m]: the hips of two steps cancel."""
        return 2.0 * max(abs(self.step_length), abs(self.lateral_step))

    def step(self, support_side: Side) -> tuple[float, float]:
        """Step vector (X_nom, Y_nom + s hip) in the given support, Eqs. (15)-(16) [m]."""
        return self.step_length, self.lateral_step + support_side * self.hip

    def start_offset(self, support_side: Side) -> tuple[float, float]:
        """DCM relative to the foot that begins to stand, Eqs. (17)-(19), corrected.

        d_start = (X_nom / (G - 1), s hip / (1 + G) + Y_nom / (G - 1)).

        Returns:
            Offset (x, y) [m].
        """
        growth = self.growth
        return (
            self.step_length / (growth - 1.0),
            support_side * self.hip / (1.0 + growth) + self.lateral_step / (growth - 1.0),
        )

    def dcm_offset(self, support_side: Side) -> tuple[float, float]:
        """d_nom = dcm(T) - p_next at the end of a step in the given support (x, y) [m]."""
        return self.start_offset(Side(support_side).other)

    def com_offset(self, support_side: Side) -> tuple[float, float]:
        """CoM relative to the foot that begins to stand, on the periodic gait.

        The convergent component x - x'/omega decays by 1/G in a step, so its periodic value is
        -X G / (G - 1) in the direction of travel and s hip G / (1 + G) across; the CoM is the
        mean of both components.

        Returns:
            Offset (x, y) [m].
        """
        growth = self.growth
        dcm_x, dcm_y = self.start_offset(support_side)
        convergent_x = -self.step_length * growth / (growth - 1.0)
        convergent_y = support_side * self.hip * growth / (
            1.0 + growth
        ) - self.lateral_step * growth / (growth - 1.0)
        return 0.5 * (dcm_x + convergent_x), 0.5 * (dcm_y + convergent_y)

    def observation(self, support_side: Side) -> Observation:
        """What a robot on this gait observes at the touchdown that begins a step.

        The feet stand at both sides of the x axis, the support foot at x = 0; time is 0.
        """
        foot = np.array([0.0, -0.5 * support_side * self.hip])
        dcm = foot + self.start_offset(support_side)
        com = foot + self.com_offset(support_side)
        return Observation(
            time=0.0,
            elapsed=0.0,
            com=com,
            com_velocity=self.omega * (dcm - com),
            dcm=dcm,
            support_foot=foot,
            support_side=support_side,
            swing_foot=(*(foot - self.step(Side(support_side).other)), 0.0),
        )


def nominal_gait(
    robot: Robot, velocity: tuple[float, float], step_duration: float | None = None
) -> NominalGait:
    """Plan the periodic gait from a velocity, Eqs. (10)-(19) of [OnlineGait].

    T_nom is the middle of the durations at which both steps X = v_x T and Y = v_y T fit their
    limits. Feet alternate, so a sideways step is outward for one foot and inward for the other:
    the smaller of the two limits counts.

    Args:
        robot: whose limits hold.
        velocity: (v_x, v_y) [m/s], x forward, y to the left.
        step_duration: T_nom if it is not to be chosen [s].

    Returns:
        The gait.

    Raises:
        VelocityError: not two finite numbers, or faster than the limits allow; the message names
            the largest speed in that direction.
        ParameterError: `step_duration` outside what the limits and the velocity allow.
    """
    v_x, v_y = _checked_velocity(velocity)
    shortest, longest = robot.gait.step_duration
    upper = min(longest, _duration_for_reach(robot, v_x, v_y))
    if upper < shortest * (1.0 - ROUNDING):
        limit = _floor(largest_speed(robot, (v_x, v_y)))
        raise VelocityError(
            f"at most {limit} m/s in the direction of ({v_x}, {v_y})",
            f"{math.hypot(v_x, v_y):.4g} m/s",
            f"slow down, or widen step_x, step_y or step_duration of robot '{robot.name}'",
        )
    upper = max(upper, shortest)
    if step_duration is None:
        duration = 0.5 * (shortest + upper)
    else:
        check_number("step_duration", step_duration, 0.0, "s", above=True)
        duration = float(step_duration)
        if not shortest <= duration <= upper:
            raise ParameterError(
                f"a step duration in [{shortest:.4g}, {upper:.4g}] s at this velocity",
                f"{step_duration}",
                "leave it out to have it chosen",
            )
    return NominalGait(
        velocity=(v_x, v_y),
        step_duration=duration,
        step_length=_inside(v_x * duration, _forward_limit(robot, v_x)),
        lateral_step=_inside(v_y * duration, _sideways_limit(robot)),
        hip=robot.hip,
        omega=robot.omega,
    )


def largest_speed(robot: Robot, direction: tuple[float, float]) -> float:
    """The largest speed that the limits allow in a direction [m/s].

    Args:
        robot: whose limits hold.
        direction: (x, y), of any length but zero.

    Raises:
        VelocityError: the direction is none.
    """
    x, y = _checked_velocity(direction)
    length = math.hypot(x, y)
    if length == 0.0:
        raise VelocityError("a direction of some length", f"{direction}", "write (1.0, 0.0)")
    return _duration_for_reach(robot, x / length, y / length) / robot.gait.step_duration[0]


def gait_room(
    robot: Robot, gait: NominalGait, zmp_reach: tuple[float, float] = (0.0, 0.0)
) -> float:
    """R: how far the nominal offsets are from what can be saved after a nominal step [m].

    The length by which a robot measures what is much and what is little: an error of R along its
    weakest axis is a fall.

    Args:
        robot: whose limits hold, those of its leg included.
        gait: the gait that it walks.
        zmp_reach: how far the ZMP can move from the centre of the foot (x, y) [m].

    Raises:
        RobotError: the leg is too slow to step at all.
    """
    tables, rooms = viable_displacement(robot), []
    for axis, side in product(range(2), Side):
        # Across, a step counts towards its swing foot, and its offset towards the next one.
        step = gait.step(side)[axis] * (1 if axis == 0 else side)
        offset = gait.dcm_offset(side)[axis] * (1 if axis == 0 else -side)
        for sign in (1, -1):
            value = tables.after_step(axis, sign, step)
            rooms.append(value + zmp_reach[axis] - sign * offset)
    return min(rooms)


def _duration_for_reach(robot: Robot, v_x: float, v_y: float) -> float:
    """The longest step duration at which X = v_x T and Y = v_y T fit their limits [s]."""
    return min(
        _forward_limit(robot, v_x) / abs(v_x) if v_x != 0.0 else math.inf,
        _sideways_limit(robot) / abs(v_y) if v_y != 0.0 else math.inf,
    )


def _forward_limit(robot: Robot, v_x: float) -> float:
    """How long a step may be in the direction of travel [m]."""
    return robot.gait.step_x[1] if v_x > 0.0 else -robot.gait.step_x[0]


def _sideways_limit(robot: Robot) -> float:
    """How far a step may go sideways, outward and inward alike [m]."""
    return min(-robot.gait.step_y[0], robot.gait.step_y[1])


def _inside(step: float, limit: float) -> float:
    """A nominal step, kept off the end of its box by `EDGE`."""
    return math.copysign(min(abs(step), (1.0 - EDGE) * limit), step)


def _checked_velocity(velocity: tuple[float, float]) -> tuple[float, float]:
    try:
        v_x, v_y = (float(component) for component in velocity)
    except (TypeError, ValueError):
        v_x = v_y = math.nan
    if not (math.isfinite(v_x) and math.isfinite(v_y)):
        raise VelocityError(
            "a velocity (v_x, v_y) of two finite numbers [m/s]",
            f"{velocity!r}",
            "write for example velocity=(0.5, 0.0)",
        )
    return v_x, v_y


def _floor(speed: float) -> str:
    """Four decimals, rounded down, so that the speed named can be walked."""
    return f"{math.floor(speed * 1e4) / 1e4:.4f}"

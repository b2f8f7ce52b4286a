"""The decision about ZMP, landing place and landing time together, as records.

Per axis, relative to the support foot, y towards the swing foot: X the landing, tau = e^(omega T)
for the landing time T, k = tau e^(-omega t) the growth of the DCM offset e until then, c how far
the ZMP reaches. The problem is to find X and tau that minimise

    1/2 a1 (X - X_ref)^2 + 1/2 a3 (tau - tau_ref)^2          stay with the gait,
    + 1/2 a4 [|e k - d_ref - X| - c_g (k - 1) - delta]+^2     land where the DCM goes, but for
                                                              what the ZMP can take,
    + 1/2 w_v [v]+^2                                          keep what comes after possible,
    + 1/2 w_m [v + rho]+^2                                    and not only just,
    + 1/2 w_g [v + (c - c_g) (k - 1) + rho]+^2                and with a ZMP within c_g,

v = (a - c) k + b - X - Z_along(X) and its mirror image -(a + c) k - b + X - Z_against(X). There
a k + b is the DCM offset at the landing: with the anticipated e' a = e' and b = 0 along a push,
which goes on; and a = e + f, b = -f e^(omega t_c) against it, where it ends as soon as the
landing cannot be taken back any more (`anticipation`). Z is what later steps can still save
(`dcm.viable_displacement`): v > 0 is a fall. c_g <= c is how far the ZMP moves while nothing is
in danger. X lies in the step box and within reach of the leg, tau between its bounds.

X + Z grows with X, Z is concave but for a little where a slow leg begins to need more than T_min,
ln tau is concave, the rest is linear. The two axes share nothing but tau. The weights have no
units: lengths count in R, the room of the gait (`dcm.nominal_gait.gait_room`), and tau in
tau_ref. Own formulation, in place of the quadratic program of [Khadiv2016].
"""

from __future__ import annotations

import math
from enum import IntFlag

import numpy as np
from numpy.typing import ArrayLike

from surefoot.compiled import njit
from surefoot.dcm.viable_displacement import NODES, value_after, viable_displacement
from surefoot.errors import ParameterError
from surefoot.record import Array, Record, Vector2, field
from surefoot.robot.robot import Robot

LOST_WEIGHT = 1e8
"""w_v R^2, on half the squared distance beyond what can be saved [-]."""

RESERVE_WEIGHT = 1e6
"""w_m R^2, on half the squared distance that the reserve rho is short of [-]."""

GENTLE_WEIGHT = 1e4
"""w_g R^2, on the same for a ZMP within c_g [-]. Where the reserve itself is short this must not
count: it would spare the ZMP at the cost of what can still be saved."""

TOLERANCE = 4e-3
"""Fraction of R. A leg that gets this little further is at its limit, and what is this little
outside of what can be saved is not lost: soft limits give way as much."""


class LandingParameters(Record):
    """What is the same in all decisions of a controller."""

    omega: float = field("1/s", "natural frequency")
    step_weight: Vector2 = field("1/m^2", "a1")
    tau_weight: float = field("-", "a3")
    offset_weight: Vector2 = field("1/m^2", "a4")
    lost_weight: float = field("1/m^2", "w_v")
    reserve_weight: float = field("1/m^2", "w_m")
    gentle_weight: float = field("1/m^2", "w_g")
    reserve: Vector2 = field("m", "rho")
    tolerance: float = field("m", "what counts as nothing beside R")
    commitment: float = field(
        "-", "e^(omega t_c), growth of the DCM in the time before a landing in which it stands"
    )
    zmp_reach: Vector2 = field("m", "c")
    gentle_zmp: Vector2 = field("m", "c_g")
    gentle_offset: Vector2 = field("m", "delta")
    max_speed: float = field("m/s", "of the leg")
    max_acceleration: float = field("m/s^2", "of the leg")
    shortest: float = field("s", "T_min")
    longest: float = field("s", "T_max")
    step_min: Vector2 = field("m", "where the step box begins, and the first node of Z is")
    step_max: Vector2 = field("m", "where it ends")
    spacing: Vector2 = field("m", "of the nodes of Z")
    saved: Array = field(
        "m", "Z on its nodes, by axis, for an offset along it and against it of the step that is "
        "decided; across, where the next step counts towards the other side, the two have changed "
        "places", shape=(2, 2, NODES),
    )  # fmt: skip


class Situation(Record):
    """What is different in each decision."""

    elapsed: float = field("s", "t")
    earliest: float = field("s", "least time from now to the landing")
    latest: float = field("s", "largest time from now to the landing")
    offset: Vector2 = field("m", "e")
    force: Vector2 = field("m", "f")
    anticipated: Vector2 = field("m", "e'")
    rate: Array = field("m", "a, by axis and side", shape=(2, 2))
    shift: Array = field("m", "b, by axis and side", shape=(2, 2))
    foot: Vector2 = field("m", "the swing foot")
    foot_velocity: Vector2 = field("m/s", "its velocity")
    step_ref: Vector2 = field("m", "X_ref")
    offset_ref: Vector2 = field("m", "d_ref")
    tau_ref: float = field("-", "of the plan")
    tau_min: float = field("-", "at least e^(omega t)")
    tau_max: float = field("-", "at least tau_min")


class Limit(IntFlag):
    """Which limits shaped a decision; several can at once."""

    NONE = 0
    ZMP_X = 1
    """The ZMP is at the edge of the foot, forward or backward."""
    ZMP_Y = 2
    """The ZMP is at the edge of the foot, to a side."""
    STEP_X = 4
    """The landing is at the end of the step box, forward or backward."""
    STEP_Y = 8
    """The landing is at the end of the step box, to a side."""
    LEG_X = 16
    """The landing is as far as the leg gets in time, forward or backward."""
    LEG_Y = 32
    """The landing is as far as the leg gets in time, to a side."""
    SHORTEST = 64
    """The step cannot end sooner."""
    LONGEST = 128
    """The step cannot last longer."""
    RESERVE = 256
    """After this landing less than the reserve is left, if the push goes on as anticipated or if it
    ends just before."""
    LOST = 512
    """After this landing nothing would survive a push that goes on as anticipated, or one that ends
    just before."""


class Decision(Record):
    """What the unified controller decided in a cycle, and how close it was."""

    step: Vector2 = field(
        "m", "X, the landing relative to the support foot; y towards the swing foot"
    )
    tau: float = field("", "e^(omega T)")
    zmp: Vector2 = field("m", "relative to the support foot, y as before")
    force: Vector2 = field("m", "F / (m omega^2), the push as observed, in the world")
    margin: float = field(
        "m",
        "displacement of the DCM that could still be saved, all at once and in the worst direction "
        "along the axes; negative if it is too late",
    )
    share: float = field(
        "", "how much of the push that is anticipated can still be saved, at most 1"
    )
    active: Limit = field("", "the limits that shaped it")
    iterations: int = field("", "how often the problem was evaluated")


DECISION = Decision.DTYPE


def landing_parameters(
    robot: Robot,
    zmp_reach: ArrayLike,
    gentle_zmp: ArrayLike,
    gentle_offset: ArrayLike,
    *,
    room: float,
    tau_ref: float,
    step_weight: tuple[float, float] = (1e-3, 1e-3),
    tau_weight: float = 0.25,
    offset_weight: tuple[float, float] = (1.0, 1.0),
    reserve: float,
    commitment: float = 0.0,
) -> LandingParameters:
    """The parameters of a robot.

    Args:
        robot: whose limits hold.
        zmp_reach: c (x, y) [m].
        gentle_zmp: c_g, of which the ZMP makes use before the landing moves (x, y) [m].
        gentle_offset: delta, what may be left to the next step (x, y) [m].
        room: R, how far the gait itself is from what cannot be saved [m].
        tau_ref: of the gait.
        step_weight, tau_weight, offset_weight: a1 R^2, a3 tau_ref^2, a4 R^2 [-].
        reserve: rho, of which half of R counts at most [m].
        commitment: how long before a landing it cannot be taken back any more [s].

    Raises:
        RobotError: the leg cannot step at all; see `viable_displacement`.
        ParameterError: the gait has no room.
    """
    tables = viable_displacement(robot)
    if not room > 0.0:
        raise ParameterError(
            "a gait whose steps this leg can follow by others for ever",
            f"one that is {-room:.3g} m beyond that",
            "walk more slowly, or give the leg its true speed and acceleration",
        )
    per_area = 1.0 / room**2
    shortest, longest = robot.gait.step_duration
    return LandingParameters(
        omega=robot.omega,
        step_weight=np.multiply(step_weight, per_area),
        tau_weight=tau_weight / tau_ref**2,
        offset_weight=np.multiply(offset_weight, per_area),
        lost_weight=LOST_WEIGHT * per_area,
        reserve_weight=RESERVE_WEIGHT * per_area,
        gentle_weight=GENTLE_WEIGHT * per_area,
        reserve=np.full(2, min(reserve, 0.5 * room)),
        tolerance=TOLERANCE * room,
        commitment=math.exp(robot.omega * commitment),
        zmp_reach=zmp_reach,
        gentle_zmp=gentle_zmp,
        gentle_offset=gentle_offset,
        max_speed=robot.swing.max_speed,
        max_acceleration=robot.swing.max_acceleration,
        shortest=shortest,
        longest=longest,
        step_min=tables.low,
        step_max=np.add(tables.low, np.multiply(tables.spacing, NODES - 1)),
        spacing=tables.spacing,
        # Across, what is along the step that is decided is against the next one.
        saved=[tables.values[0], tables.values[1, ::-1]],
    )


@njit(forceinline=True)
def saved_after(landing, axis, row, place):
    """Z after a landing, and its slope there: linear between nodes, and beyond the last ones."""
    return value_after(
        landing.saved[axis, row], landing.step_min[axis], landing.spacing[axis], place
    )


@njit(forceinline=True)
def outside(landing, axis, place):
    """How far a landing is outside of the step box, which a fast foot may run past [m]."""
    low, high = landing.step_min[axis], landing.step_max[axis]
    return min(place - low, 0.0) + max(place - high, 0.0)


@njit(forceinline=True)
def soft_error(landing, situation, axis, growth, place):
    """What ZMP and next step cannot take of the error at landing: beyond the dead zone [m]."""
    error = situation.offset[axis] * growth - situation.offset_ref[axis] - place
    zone = landing.gentle_zmp[axis] * (growth - 1.0) + landing.gentle_offset[axis]
    return error - zone if error > zone else (error + zone if error < -zone else 0.0)


@njit(forceinline=True)
def excess(landing, situation, axis, growth, place, along, against):
    """v of both sides: how far a landing is outside of what can be saved after it [m].

    Args:
        along, against: Z there, for an offset along the axis and against it [m].
    """
    rate, shift, zmp = situation.rate, situation.shift, landing.zmp_reach[axis]
    return (
        (rate[axis, 0] - zmp) * growth + shift[axis, 0] - place - along,
        -(rate[axis, 1] + zmp) * growth - shift[axis, 1] + place - against,
    )


@njit(forceinline=True)
def excess_at(landing, situation, axis, growth, place):
    """v of both sides at a landing [m]."""
    along, _ = saved_after(landing, axis, 0, place)
    against, _ = saved_after(landing, axis, 1, place)
    return excess(landing, situation, axis, growth, place, along, against)


@njit(forceinline=True)
def reserved(landing, axis, growth):
    """How far v has to stay below 0 for a ZMP within c_g: rho, and what it leaves [m]."""
    spare = landing.zmp_reach[axis] - landing.gentle_zmp[axis]
    return landing.reserve[axis] + spare * (growth - 1.0)

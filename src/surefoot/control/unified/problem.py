"""The decision about ZMP, landing place and landing time together, as records.

Per axis, relative to the support foot, y towards the swing foot: X the landing, tau = e^(omega T)
for the landing time T, k = tau e^(-omega t) the growth of the DCM offset e until then, c how far
the ZMP reaches. The problem is to find X and tau that minimise

    1/2 a1 (X - X_ref)^2 + 1/2 a3 (tau - tau_ref)^2          stay with the gait,
    + 1/2 a4 [|e k - d_ref - X| - c_g (k - 1) - delta]+^2     land where the DCM wants it, but for
                                                              what the ZMP can take,
    + 1/2 w_v [v]+^2                                          keep what comes after possible,
    + 1/2 w_m [v + rho]+^2                                    and not only just,
    + 1/2 w_g [v + (c - c_g) (k - 1) + rho]+^2                and with a ZMP within c_g,

v = (a - c) k + b - X - Z_along(X) and its mirror image -(a + c) k - b + X - Z_against(X). There
a k + b is the DCM offset at the landing: with the anticipated e' a = e' and b = 0 along a push,
which goes on; and a = e + f, b = -f e^(omega t_c) against it, where it ends as soon as the
landing cannot be taken back any more (`anticipation`). Z is what later steps are worth
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
from numpy.typing import ArrayLike, NDArray

from surefoot.dcm.viable_displacement import NODES, viable_displacement
from surefoot.errors import ParameterError
from surefoot.record import Record, Vector2, field, new_array
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

LANDING = np.dtype(
    [
        ("omega", "f8"),
        ("step_weight", "f8", (2,)),
        ("tau_weight", "f8"),
        ("offset_weight", "f8", (2,)),
        ("lost_weight", "f8"),
        ("reserve_weight", "f8"),
        ("gentle_weight", "f8"),
        ("reserve", "f8", (2,)),
        ("tolerance", "f8"),
        ("commitment", "f8"),
        ("zmp_reach", "f8", (2,)),
        ("gentle_zmp", "f8", (2,)),
        ("gentle_offset", "f8", (2,)),
        ("max_speed", "f8"),
        ("max_acceleration", "f8"),
        ("shortest", "f8"),
        ("longest", "f8"),
        ("step_min", "f8", (2,)),
        ("step_max", "f8", (2,)),
        ("spacing", "f8", (2,)),
        ("worth", "f8", (2, 2, NODES)),
    ],
)
"""What is the same in all decisions of a controller: omega; a1, a3, a4, w_v, w_m, w_g and rho; what
counts as nothing beside R [m]; e^(omega t_c), by which the DCM grows in the time before a landing
in which it cannot be taken back; c, c_g and delta [m]; limits of the leg [m/s, m/s^2]; T_min and
T_max [s]; the step box, and Z on it [m]. `worth` is by axis, then Z for an offset along it or
against it of the step that is decided, so that across, where the next step counts towards the other
side, they have changed places."""

SITUATION = np.dtype(
    [
        ("elapsed", "f8"),
        ("earliest", "f8"),
        ("latest", "f8"),
        ("offset", "f8", (2,)),
        ("force", "f8", (2,)),
        ("anticipated", "f8", (2,)),
        ("rate", "f8", (2, 2)),
        ("shift", "f8", (2, 2)),
        ("foot", "f8", (2,)),
        ("foot_velocity", "f8", (2,)),
        ("step_ref", "f8", (2,)),
        ("offset_ref", "f8", (2,)),
        ("tau_ref", "f8"),
        ("tau_min", "f8"),
        ("tau_max", "f8"),
    ],
)
"""What is different in each: t, and the least and largest time to the landing [s]; e, f and e' [m];
a and b by axis and side, see above [m]; swing foot, its velocity [m/s], X_ref and d_ref [m];
tau_ref and the bounds of tau, tau_min >= e^(omega t)."""


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
) -> NDArray[np.void]:
    """The `LANDING` record of a robot, shape (1,).

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
    parameters = new_array(LANDING)
    record, tables = parameters[0], viable_displacement(robot)
    record["omega"] = robot.omega
    if not room > 0.0:
        raise ParameterError(
            "a gait whose steps this leg can follow by others for ever",
            f"one that is {-room:.3g} m beyond that",
            "walk more slowly, or give the leg its true speed and acceleration",
        )
    per_area = 1.0 / room**2
    record["step_weight"] = np.multiply(step_weight, per_area)
    record["tau_weight"] = tau_weight / tau_ref**2
    record["offset_weight"] = np.multiply(offset_weight, per_area)
    record["lost_weight"] = LOST_WEIGHT * per_area
    record["reserve_weight"] = RESERVE_WEIGHT * per_area
    record["gentle_weight"] = GENTLE_WEIGHT * per_area
    record["tolerance"] = TOLERANCE * room
    record["commitment"] = math.exp(robot.omega * commitment)
    record["zmp_reach"] = zmp_reach
    record["gentle_zmp"], record["gentle_offset"] = gentle_zmp, gentle_offset
    record["max_speed"] = robot.swing.max_speed
    record["max_acceleration"] = robot.swing.max_acceleration
    record["shortest"], record["longest"] = robot.gait.step_duration
    record["step_min"], record["spacing"] = tables.low, tables.spacing
    record["step_max"] = np.add(tables.low, np.multiply(tables.spacing, NODES - 1))
    record["reserve"] = min(reserve, 0.5 * room)
    # Across, what is along the step that is decided is against the next one.
    record["worth"][0], record["worth"][1] = tables.values[0], tables.values[1, ::-1]
    return parameters

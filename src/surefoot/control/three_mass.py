"""The capture point of a robot with heavy legs, optimised in every cycle ([Kim2019]).

What a leg with mass does to the CoM while it swings is known before it does: see the pendulum of
`dcm.three_mass`. Its capture point xi = c + c' / omega' is, with the ZMP at u for the rest R of the
step,

    xi(T) = u + (xi - u) e^(omega' R) + kappa integral of omega' e^(omega' (T - t)) f''(t) dt,

and the foot flies on the quintic from where it is to its landing s, so the last term is affine in
s. The ZMP and the landing are those of least cost, along each axis by itself,

    minimise  (e^(omega' R) - 1) u^2 + end_weight |xi(T) - s - xi_nom|^2
              + step_weight |s - s_nom|^2,

within the sole, the box of steps and the reach of the leg. xi_nom is that of the periodic gait,
legs included, in which the ZMP rests at the centre of the foot. On massless legs the pendulum is
the LIPM.

In the source a program makes the capture point follow a trajectory of the three-mass model. The
cost above is the choice of this implementation: a large `end_weight` captures the robot with this
step where that can be, and `step_weight` prefers the ZMP to the step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.compiled import njit
from surefoot.control.base import CompiledController
from surefoot.control.cycle import end_cycle, side_index
from surefoot.control.fields import weight
from surefoot.control.registry import method
from surefoot.control.tracking import (
    EDGE_TOLERANCE,
    Tracking,
    TrackingState,
    plan_step,
    tracking_parameters,
)
from surefoot.control.validation import validate
from surefoot.dcm.leg import reach
from surefoot.dcm.support import nearest_under_foot
from surefoot.dcm.swing_foot import quintic
from surefoot.dcm.three_mass import three_mass
from surefoot.geometry import length
from surefoot.interface import Mode, Status
from surefoot.record import Array, Record, field
from surefoot.robot.feet import Side

_ADAPTING = int(Mode.ADAPTING)
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)
_ZMP_AT_EDGE = int(Status.ZMP_AT_EDGE)

_NODES, _SHARES = (tuple(map(float, one)) for one in np.polynomial.legendre.leggauss(6))


class ThreeMassParameters(Record):
    """A robot with heavy legs, and its nominal gait by support side, right first."""

    omega: float = field("1/s", "natural frequency omega' of its pendulum")
    foot_gain: float = field("s^2", "kappa, see `dcm.three_mass`")
    end_weight: float = field("-", "of the cost")
    step_weight: float = field("-", "likewise")
    offset: Array = field("m", "capture point from the foot at a touchdown", shape=(2, 2))
    tracking: Tracking = field("", "of the plan")


@njit
def flight_share(omega, duration, away, velocity, acceleration):
    """Integral of omega e^(omega (T - t)) f''(t) over the rest of a flight, along one axis [m/s^2].

    By Gauss's rule with six nodes, which for omega T <= 3 is exact to 1e-10, and in the last cycles
    of a flight too, where the closed form loses its digits.

    Args:
        omega: natural frequency [1/s].
        duration: T, of the flight from now on [s].
        away: from the foot to its landing [m].
        velocity, acceleration: of the foot now [m/s, m/s^2].
    """
    total = 0.0
    for k in range(len(_NODES)):
        left = 0.5 * (1.0 - _NODES[k]) * duration
        _, _, change = quintic(0.0, velocity, acceleration, away, 0.0, duration, duration - left)
        total += _SHARES[k] * change * math.exp(omega * left)
    return 0.5 * omega * duration * total


@njit
def least_cost(costs, error, by_zmp, by_step, bounds):
    """The u and s in a box that minimise a u^2 + b (error + by_zmp u + by_step s)^2 + c s^2.

    The cost is convex, so if its least is not inside it is on an edge.

    Args:
        costs: a, b, c.
        error: for u = s = 0 [m].
        by_zmp, by_step: its derivatives.
        bounds: of s from below and above, and of |u| [m].

    Returns:
        u and s [m].
    """
    hold, end, step = costs
    low, high, half = bounds
    # The normal equations; `hold` and `step` are positive.
    uu, us, ss = hold + end * by_zmp**2, end * by_zmp * by_step, step + end * by_step**2
    u0, s0 = -end * by_zmp * error, -end * by_step * error
    det = uu * ss - us * us
    u, s = (u0 * ss - us * s0) / det, (uu * s0 - us * u0) / det
    if abs(u) <= half and low <= s <= high:
        return u, s
    best_u, best_s, best = 0.0, 0.0, math.inf
    for edge in range(4):
        if edge < 2:
            u = half if edge == 0 else -half
            s = min(max((s0 - us * u) / ss, low), high)
        else:
            s = low if edge == 2 else high
            u = min(max((u0 - us * s) / uu, -half), half)
        cost = 0.5 * (uu * u * u + ss * s * s) + us * u * s - u0 * u - s0 * s
        if cost < best:
            best_u, best_s, best = u, s, cost
    return best_u, best_s


@njit
def optimise(parameters, state, new_step, next_state):
    """Write ZMP, landing and timing of the command; `next_state` already has the plan."""
    tracking, omega = parameters.tracking, parameters.omega
    observation, command = next_state.validated.observation, next_state.command
    foot, half = observation.support_foot, tracking.half_foot
    row, swing = side_index(observation.support_side), tracking.swing
    left = next_state.plan.step_duration - observation.elapsed
    command.mode, command.status = _ADAPTING, 0 if left >= 0.0 else _NO_TIME_LEFT
    # The ZMP that is commanded now acts for a period, however little of the step is left.
    left = max(left, swing.period)
    growth = math.exp(omega * left)
    by_landing = parameters.foot_gain * flight_share(omega, left, 1.0, 0.0, 0.0)
    costs = growth - 1.0, parameters.end_weight, parameters.step_weight
    for i in range(2):
        nominal, velocity = next_state.plan.step[i], observation.swing_foot_velocity[i]
        away = observation.swing_foot[i] - foot[i] - nominal
        acceleration = 0.0 if new_step else state.command.swing_foot_acceleration[i]
        share = flight_share(omega, left, -away, velocity, acceleration)
        point = observation.com[i] + observation.com_velocity[i] / omega - foot[i]
        offset = point * growth + parameters.foot_gain * share - nominal
        behind, ahead = reach(away, velocity, left, swing.max_speed, swing.max_acceleration)
        low, high = tracking.step_min[row, i] - nominal, tracking.step_max[row, i] - nominal
        low, high = min(max(low, behind), high), max(min(high, ahead), low)
        zmp, step = least_cost(
            costs, offset - parameters.offset[1 - row, i], 1.0 - growth, by_landing - 1.0,
            (low, high, half[i]),
        )  # fmt: skip
        command.zmp[i] = zmp
        command.step_location[i] = foot[i] + nominal + step
        command.dcm_offset[i] = offset + (1.0 - growth) * zmp + (by_landing - 1.0) * step
    zmp, tolerance = command.zmp, EDGE_TOLERANCE * swing.reach
    x, y = nearest_under_foot(zmp[0], zmp[1], half[0], half[1], observation.support_yaw)
    at_edge = abs(zmp[0]) > half[0] - tolerance or abs(zmp[1]) > half[1] - tolerance
    if at_edge or length(x - zmp[0], y - zmp[1]) > tolerance:
        command.status |= _ZMP_AT_EDGE
    zmp[0], zmp[1] = foot[0] + x, foot[1] + y
    command.step_duration = max(next_state.plan.step_duration, observation.elapsed)


@njit
def three_mass_cycle(parameters, state, observation, next_state):
    """One cycle of `ThreeMassCapture` over records."""
    if validate(parameters.tracking.gate, state, observation, next_state):
        new_step, _ = plan_step(parameters.tracking, state, next_state)
        optimise(parameters, state, new_step, next_state)
        in_the_air = 0.0, next_state.command.step_duration
        end_cycle(parameters.tracking, in_the_air, new_step, state, next_state)


@method(
    "three-mass",
    label="capture point of three masses",
    source="Kim, Han, Hong 2019",
    adapts="ZMP, step location",
    cannot="steps at fixed times",
    cites=("Kim2019",),
    order=45,
)
@dataclass(frozen=True)
class ThreeMassCapture(
    CompiledController,
    cycle=three_mass_cycle,
    parameters=ThreeMassParameters,
    state=TrackingState,
):
    """Captures a robot with heavy legs: the ZMP first, then the next landing, at fixed times.

    The legs count if they are `heavy`, see `Robot.with_heavy_legs`, and nobody else moves the ZMP
    for them.

    Raises:
        VelocityError: the velocity cannot be walked.
        ParameterError: another argument is out of range.
    """

    end_weight: float = weight(
        1e3, "-", "on the capture point from the nominal one at the touchdown", above=0.0
    )
    step_weight: float = weight(10.0, "-", "on the step vector from the nominal one", above=0.0)

    def make_parameters(self) -> ThreeMassParameters:
        """Those of the robot's legs, and of its periodic gait on them."""
        pendulum, time = three_mass(self.robot, compensated=True), self.gait.step_duration
        omega = math.sqrt(self.robot.gravity / pendulum.height)
        growth = math.exp(omega * time)
        sides = Side.RIGHT, Side.LEFT
        steps = np.array([self.gait.step(side) for side in sides])
        # Each foot flies both steps: d_R e^(omega' T) + L = s_R + d_L, and so for the other side.
        flight = pendulum.foot_gain * flight_share(omega, time, 1.0, 0.0, 0.0) * steps.sum(axis=0)
        offset = np.linalg.solve([[growth, -1.0], [-1.0, growth]], steps - flight)
        return ThreeMassParameters(
            omega=omega,
            foot_gain=pendulum.foot_gain,
            end_weight=self.end_weight,
            step_weight=self.step_weight,
            offset=offset,
            tracking=tracking_parameters(self),
        )

"""Real-time optimisation of the capture point on the three-mass pendulum ([Kim2019]).

The legs of a robot have mass, and what they do to the CoM while one of them swings is known before
it does. With the pendulum of `dcm.three_mass` and its capture point xi = c + c' / omega',

    xi(T) = u + (xi - u) e^(omega' R) + omega' kappa integral of e^(omega' (T - t)) f''(t) dt

for a ZMP that stays at u for the rest R of the step. The foot flies on the quintic from its state
now to the landing s, so the last term is L_0 + L_1 s. In every cycle the ZMP and the landing are
those that cost least, along each axis by itself,

    minimise  r |u|^2 + 2 |xi(T) - s - xi_nom|^2 + w |s - s_nom|^2,     r = e^(omega' R) - 1,

under a sole, a box of steps and the reach of the leg; 2 |xi|^2 is what the error at the touchdown
costs the ZMP for ever after, in the units of r. xi_nom is the periodic one, legs included, whose
ZMP rests at the centre of the foot. The cost, and that the flight is replanned from where the foot
is, are choices of this implementation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.control.base import CompiledController
from surefoot.control.belief import hold, look
from surefoot.control.cycle import side_index
from surefoot.control.fields import setting
from surefoot.control.registry import method
from surefoot.control.tracking import (
    NO_GAIN,
    TRACKING,
    TRACKING_STATE,
    end_cycle,
    plan_step,
    tracking_parameters,
)
from surefoot.dcm.leg import furthest
from surefoot.dcm.support import nearest_under_foot
from surefoot.dcm.swing_foot import quintic
from surefoot.dcm.three_mass import three_mass
from surefoot.geometry import length
from surefoot.interface import Mode, Status
from surefoot.record import new_array
from surefoot.robot.feet import Side

THREE_MASS = np.dtype(
    [
        ("tracking", TRACKING),
        ("omega", "f8"),
        ("foot_gain", "f8"),
        ("step_weight", "f8"),
        ("end_weight", "f8"),
        ("offset", "f8", (2, 2)),
        ("step", "f8", (2, 2)),
    ]
)

_ADAPTING = int(Mode.ADAPTING)
_NO_TIME_LEFT = int(Status.NO_TIME_LEFT)
_ZMP_AT_EDGE = int(Status.ZMP_AT_EDGE)
EDGE = 1e-9
_NODES, _SHARES = (tuple(map(float, one)) for one in np.polynomial.legendre.leggauss(6))


@njit
def flight_share(omega, duration, away, velocity, acceleration):
    """Integral of omega e^(omega (T - t)) f''(t) over the rest of a flight, one axis [1/s * m/s].

    By Gauss's rule, which keeps its digits for the last cycles of a flight too, where the closed
    form does not; for omega T <= 3 it is exact to 1e-10.

    Args:
        omega: natural frequency [1/s].
        duration: T, of the flight from now on [s].
        away: from the foot to its landing [m].
        velocity, acceleration: of the foot now [m/s, m/s^2].
    """
    total = 0.0
    for k in range(len(_NODES)):
        node = 0.5 + 0.5 * _NODES[k]
        _, _, change = quintic(0.0, velocity, acceleration, away, 0.0, duration, node * duration)
        total += _SHARES[k] * change * math.exp(omega * duration * (1.0 - node))
    return 0.5 * omega * duration * total


@njit
def _least(hold_cost, end_cost, step_cost, offset, by_zmp, by_step, low, high, half):
    """u and s that minimise hold u^2 + end (offset + by_zmp u + by_step s)^2 + step s^2 in a box.

    A convex program of two unknowns: its solution is inside, or on an edge.
    """
    best_u = best_s = 0.0
    best = math.inf
    for kind in range(5):
        if kind == 0:
            a = hold_cost + end_cost * by_zmp * by_zmp
            b = end_cost * by_zmp * by_step
            c = step_cost + end_cost * by_step * by_step
            f, g = -end_cost * by_zmp * offset, -end_cost * by_step * offset
            det = a * c - b * b
            u, s = (f * c - b * g) / det, (a * g - b * f) / det
            if abs(u) > half or s < low or s > high:
                continue
        elif kind < 3:
            u = half if kind == 1 else -half
            s = -end_cost * by_step * (offset + by_zmp * u) / (step_cost + end_cost * by_step**2)
            s = min(max(s, low), high)
        else:
            s = low if kind == 3 else high
            u = -end_cost * by_zmp * (offset + by_step * s) / (hold_cost + end_cost * by_zmp**2)
            u = min(max(u, -half), half)
        end = offset + by_zmp * u + by_step * s
        cost = hold_cost * u * u + end_cost * end * end + step_cost * s * s
        if cost < best:
            best, best_u, best_s = cost, u, s
    return best_u, best_s


@njit
def optimise(parameters, observation, plan, previous, new_step, command):
    """Write ZMP, landing and timing."""
    tracking, omega = parameters.tracking, parameters.omega
    foot, half = observation.support_foot, tracking.half_foot
    row = side_index(observation.support_side)
    left = plan.step_duration - observation.elapsed
    command.mode, command.status = _ADAPTING, 0 if left >= 0.0 else _NO_TIME_LEFT
    left = max(left, tracking.swing.period)
    growth = math.exp(omega * left)
    speed, hardest = tracking.swing.max_speed, tracking.swing.max_acceleration
    for i in range(2):
        nominal = parameters.step[row, i]
        swing = observation.swing_foot[i] - foot[i]
        velocity = observation.swing_foot_velocity[i]
        acceleration = 0.0 if new_step else previous.swing_foot_acceleration[i]
        gain = parameters.foot_gain
        none = gain * flight_share(omega, left, 0.0 - swing, velocity, acceleration)
        by_landing = gain * flight_share(omega, left, 1.0, 0.0, 0.0)
        away = observation.com[i] + observation.com_velocity[i] / omega - foot[i]
        free = away * growth + none + by_landing * nominal - nominal
        free -= parameters.offset[1 - row, i]
        low = tracking.step_min[row, i] - nominal
        high = tracking.step_max[row, i] - nominal
        if speed < math.inf or hardest < math.inf:
            ahead = swing + furthest(velocity, left, speed, hardest) - nominal
            behind = swing - furthest(-velocity, left, speed, hardest) - nominal
            low, high = min(max(low, behind), ahead), max(min(high, ahead), behind)
        u, s = _least(
            growth - 1.0, parameters.end_weight, parameters.step_weight, free, 1.0 - growth, by_landing - 1.0,
            low, high, half[i],
        )
        command.zmp[i] = u
        command.step_location[i] = s + nominal
        command.dcm_offset[i] = free + (1.0 - growth) * u + (by_landing - 1.0) * s
        command.dcm_offset[i] += parameters.offset[1 - row, i]
    zmp_x, zmp_y = nearest_under_foot(
        command.zmp[0], command.zmp[1], half[0], half[1], observation.support_yaw
    )
    if abs(command.zmp[0]) >= half[0] * (1.0 - EDGE) or abs(command.zmp[1]) >= half[1] * (1.0 - EDGE):
        command.status |= _ZMP_AT_EDGE
    command.zmp[0], command.zmp[1] = foot[0] + zmp_x, foot[1] + zmp_y
    command.step_duration = max(plan.step_duration, observation.elapsed)
    for i in range(2):
        command.step_location[i] += foot[i]


@njit
def three_mass_cycle(parameters, state, observation, next_state):
    if look(parameters.tracking.gate, state, observation, next_state):
        hold(state, next_state)
        return
    new_step, _ = plan_step(parameters.tracking, state, next_state)
    command = next_state.command
    optimise(parameters, next_state.belief.seen, next_state.plan, state.command, new_step, command)
    end_cycle(parameters.tracking, (0.0, command.step_duration), new_step, state, next_state)


@njit
def _step(parameters, state, observation, next_state):
    three_mass_cycle(parameters[0], state[0], observation[0], next_state[0])


@method(
    "three-mass",
    label="capture point, three masses",
    source="Kim, Han, Hong 2019",
    adapts="ZMP, step location",
    cannot="steps at fixed times",
    cites=("Pratt2006",),
    order=45,
    nearness=0.05,
)
@dataclass(frozen=True)
class ThreeMassCapture(
    CompiledController, cycle=three_mass_cycle, arrays=_step, parameters=THREE_MASS,
    state=TRACKING_STATE,
):
    """x"""

    step_weight: float = setting(1e-2, "-", "on steps", above=0.0)
    end_weight: float = setting(2.0, "-", "on end", above=0.0)

    def make_parameters(self) -> NDArray[np.void]:
        parameters = new_array(THREE_MASS)
        record = parameters[0]
        record["tracking"] = tracking_parameters(self.robot, self.gait, NO_GAIN, True, 0.0, self.period)[0]
        pendulum = three_mass(self.robot, compensated=True)
        omega = math.sqrt(self.robot.gravity / pendulum.height)
        record["omega"], record["foot_gain"] = omega, pendulum.foot_gain
        record["step_weight"] = self.step_weight
        record["end_weight"] = self.end_weight
        time = self.gait.step_duration
        growth = math.exp(omega * time)
        flight = pendulum.foot_gain * flight_share.py_func(omega, time, 1.0, 0.0, 0.0)
        for i in range(2):
            right, left = self.gait.step(Side.RIGHT)[i], self.gait.step(Side.LEFT)[i]
            both = flight * (right + left)
            # d_R e + L = s_R + d_L and d_L e + L = s_L + d_R.
            d = np.linalg.solve([[growth, -1.0], [-1.0, growth]], [right - both, left - both])
            for side, value, step in ((Side.RIGHT, d[0], right), (Side.LEFT, d[1], left)):
                row = side_index.py_func(side)
                record["offset"][row, i], record["step"][row, i] = value, step
        return parameters

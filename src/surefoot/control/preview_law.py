"""The law of ZMP preview control and its gains: optimal tracking of a ZMP known ahead of time.

The cart on a table of [Kajita2003], one axis, with the jerk u of the CoM as its input:

    x = (com, com', com''),   x(k+1) = A x(k) + B u(k),   zmp(k) = C x(k) = com - com'' / omega^2

and the input that minimises the sum of Q_e e^2 + dx^T Q_x dx + R du^2 for ever, where e is the
error of the ZMP, and dx and du are the changes from sample to sample:

    u(k) = -G_i sum_{i<=k} e(i) - G_x x(k) + sum_{l=1..N} G_p(l) zmp_ref(k + l).

The kernels are relative to the support foot: what the regulator asks for, and the twin it walks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.control.cycle import LAST_CYCLE, SwingParameters, side_index
from surefoot.control.plausibility import Gate
from surefoot.control.tracking import EDGE_TOLERANCE
from surefoot.control.validation import Validated
from surefoot.dcm.pendulum import com_flow
from surefoot.dcm.support import nearest_under_foot
from surefoot.errors import ParameterError
from surefoot.interface import Command
from surefoot.record import Array, Record, Vector2, Vector3, field, new_array

DOUBLINGS = 60
"""No horizon is longer than 2^60 samples."""

CONVERGED = 1e-14
"""Relative change of the cost matrix by a doubling that is rounding."""


@dataclass(frozen=True)
class PreviewGains:
    """The gains of one axis, in SI units of jerk over position, velocity, acceleration.

    Attributes:
        integral: G_i [1/s^3].
        state: G_x, shape (3,) [1/s^3, 1/s^2, 1/s].
        preview: G_p(1) ... G_p(N), shape (N,) [1/s^3].
        cost: P, the solution of the Riccati equation for (e, dx), shape (4, 4).
    """

    integral: float
    state: NDArray[np.float64]
    preview: NDArray[np.float64]
    cost: NDArray[np.float64]


def cart_table(
    omega: float, sample_time: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """A (3, 3), B (3, 1) and C (1, 3) of the cart on a table, exact for a jerk that is held.

    Args:
        omega: natural frequency [1/s].
        sample_time: from sample to sample [s].
    """
    t = sample_time
    a = np.array([[1.0, t, 0.5 * t * t], [0.0, 1.0, t], [0.0, 0.0, 1.0]])
    b = np.array([[t**3 / 6.0], [0.5 * t * t], [t]])
    return a, b, np.array([[1.0, 0.0, -1.0 / omega**2]])


def error_system(
    omega: float, sample_time: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A (4, 4) and B (4, 1) of (e, dx), driven by du: the cart with the integral of its error."""
    a, b, c = cart_table(omega, sample_time)
    whole = np.zeros((4, 4))
    whole[0, 0], whole[0, 1:], whole[1:, 1:] = 1.0, (c @ a)[0], a
    return whole, np.vstack([c @ b, b])


def preview_gains(
    omega: float,
    sample_time: float,
    samples: int,
    error_weight: float,
    state_weight: tuple[float, float, float],
    input_weight: float,
) -> PreviewGains:
    """The optimal gains of [Kajita2003], for a reference that is known N samples ahead.

    Args:
        omega: natural frequency [1/s].
        sample_time: from sample to sample [s].
        samples: N, how far ahead the reference is known.
        error_weight: Q_e [1/m^2].
        state_weight: the diagonal of Q_x [1/m^2, s^2/m^2, s^4/m^2].
        input_weight: R [s^6/m^2].

    Raises:
        ParameterError: rounding leaves no stable gains of these weights.
    """
    # In units of 1 / omega, to some digits, so that similar robots have the same gains to the bit.
    a, b = error_system(1.0, _digits(omega * sample_time))
    weights = (
        error_weight,
        state_weight[0],
        _digits(state_weight[1] * omega**2),
        _digits(state_weight[2] * omega**4),
    )
    effort = _digits(input_weight * omega**6)
    unsolved = ParameterError(
        "weights of preview control with which its Riccati equation can be solved",
        f"Q = diag{(error_weight, *state_weight)}, R = {input_weight}",
        "leave them out for the defaults",
    )
    try:
        p = _riccati(a, b, np.diag(weights), effort)
    except np.linalg.LinAlgError as error:
        raise unsolved from error
    inverse = 1.0 / (effort + (b.T @ p @ b).item())
    gain = inverse * (b.T @ p @ a)
    closed = a - b @ gain
    if not (np.isfinite(closed).all() and np.abs(np.linalg.eigvals(closed)).max() < 1.0):
        raise unsolved
    preview, costate = np.empty(samples), p[:, 0].copy()
    for k in range(samples):
        preview[k] = inverse * (b[:, 0] @ costate)
        costate = closed.T @ costate
    units = np.array([1.0, 1.0, 1.0 / omega, 1.0 / omega**2])
    gain, jerk = gain[0] * units, omega**3
    return PreviewGains(
        jerk * float(gain[0]), jerk * gain[1:], jerk * preview, units[:, None] * p * units
    )


def _digits(value: float) -> float:
    return float(f"{value:.13g}")


def _riccati(
    a: NDArray[np.float64], b: NDArray[np.float64], q: NDArray[np.float64], r: float
) -> NDArray[np.float64]:
    """The stabilising solution of P = A^T P (I + B B^T P / r)^-1 A + Q.

    Value iteration of which every pass doubles the horizon. The time constant of a pendulum is some
    hundred samples, so that one sample at a time would take thousands of passes.
    """
    eye, g, p = np.eye(len(a)), b @ b.T / r, q
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(DOUBLINGS):
            shrink = np.linalg.inv(eye + g @ p)
            step = a.T @ p @ shrink @ a
            g, p, a = g + a @ shrink @ g @ a.T, p + 0.5 * (step + step.T), a @ shrink @ a
            if np.abs(step).max() <= CONVERGED * np.abs(p).max():
                break
    return p


MAX_SAMPLES = 2000
"""The longest preview, in control periods."""


class PreviewPlan(Record):
    """The undisturbed twin, relative to the support foot, and the step under way."""

    com: Vector2 = field("m", "of the twin")
    com_velocity: Vector2 = field("m/s", "of the twin")
    zmp: Vector2 = field("m", "of the twin, from now on")
    zmp_sum: Vector2 = field("m", "of the errors of the twin's ZMP")
    measured_sum: Vector2 = field("m", "of those of the robot's own")
    step: Vector2 = field("m", "from the support foot to the landing")
    step_duration: float = field("s", "of the step under way")
    elapsed: float = field("s", "time of the step up to which the twin has walked")
    phase: Vector3 = field("-, 1/s, 1/s^2", "of the swing foot's flight, with its derivatives")
    support_side: int = field("", "which foot is on the ground")


class PreviewParameters(Record):
    """Of preview control; the first index of a table is the support side, see `side_index`."""

    omega: float = field("1/s", "natural frequency")
    period: float = field("s", "control period, and sample of the regulator")
    half_foot: Vector2 = field("m", "half the sole")
    integral_gain: float = field("1/s^3", "G_i")
    state_gain: Vector3 = field("1/s^3, 1/s^2, 1/s", "G_x")
    step_gain: Array = field(
        "1/s^3", "what a step counts that is taken n samples from now: the sum of G_p(l), l > n",
        shape=MAX_SAMPLES + 1,
    )  # fmt: skip
    samples: int = field("", "N")
    step_duration: float = field("s", "of the gait")
    step: Array = field("m", "step vectors", shape=(2, 2))
    landing_yaw: float = field("rad", "heading with which the foot lands", default=0.0)
    swing: SwingParameters = field("", "of the swing foot")
    gate: Gate = field("", "of observations")
    start: Array = field(
        "", "the periodic plan at touchdown", shape=2, kind=PreviewPlan,
        default=new_array(PreviewPlan.DTYPE),
    )  # fmt: skip
    start_zmp: Array = field(
        "m", "ZMP just before that, relative to the new support foot", shape=(2, 2), default=0.0
    )
    end_offset: Array = field(
        "m", "DCM offset of the periodic gait at the end of a step", shape=(2, 2), default=0.0
    )


class PreviewState(Record):
    """What preview control remembers."""

    plan: PreviewPlan = field("", "of the step under way")
    validated: Validated = field("", "the observation")
    command: Command = field("", "of the last cycle")


@njit
def preview_steps(parameters, plan, elapsed):
    """The part of the jerk that the steps ahead ask for (x, y) [m/s^3].

    The reference is constant from step to step, so that each step counts with the sum of all gains
    behind it. A touchdown between two samples counts in proportion.
    """
    ahead_x, ahead_y = 0.0, 0.0
    step_x, step_y, side = plan.step[0], plan.step[1], plan.support_side
    lead = max(plan.step_duration - elapsed, 0.0) / parameters.period
    while lead < parameters.samples:
        n = int(lead)
        share = lead - n
        gain = (1.0 - share) * parameters.step_gain[n] + share * parameters.step_gain[n + 1]
        ahead_x, ahead_y = ahead_x + gain * step_x, ahead_y + gain * step_y
        side = -side
        row = side_index(side)
        step_x, step_y = parameters.step[row, 0], parameters.step[row, 1]
        lead += parameters.step_duration / parameters.period
    return ahead_x, ahead_y


@njit
def _asked_zmp(parameters, com, com_velocity, zmp, zmp_sum, ahead):
    """The ZMP that the regulator asks for, one axis, relative to the support foot [m]."""
    t, per_omega = parameters.period, 1.0 / (parameters.omega * parameters.omega)
    gain = parameters.state_gain
    acceleration = (com - zmp) / per_omega
    jerk = ahead - parameters.integral_gain * zmp_sum
    jerk -= gain[0] * com + gain[1] * com_velocity + gain[2] * acceleration
    next_com = com + t * (com_velocity + t * (0.5 * acceleration + t * jerk / 6.0))
    return next_com - (acceleration + t * jerk) * per_omega


@njit
def regulate(parameters, plan, yaw, elapsed, com, com_velocity, zmp, zmp_sum):
    """One sample of the regulator; everything is relative to the support foot.

    Args:
        parameters: a `PreviewParameters` record.
        plan: the footsteps, a `PreviewPlan` record.
        yaw: heading of the sole [rad].
        elapsed: time since touchdown [s].
        com, com_velocity: now (x, y) [m, m/s].
        zmp: what acted until now (x, y), and what acts from now on: written [m].
        zmp_sum: of the errors of the ZMP so far (x, y), written [m].

    Returns:
        Whether the sole limits the ZMP.
    """
    half = parameters.half_foot
    ahead_x, ahead_y = preview_steps(parameters, plan, elapsed)
    # Under the foot that has just landed, the ZMP is where it was, or as near as the sole allows.
    zmp[0], zmp[1] = nearest_under_foot(zmp[0], zmp[1], half[0], half[1], yaw)
    sum_x, sum_y = zmp_sum[0] + zmp[0], zmp_sum[1] + zmp[1]
    asked_x = _asked_zmp(parameters, com[0], com_velocity[0], zmp[0], sum_x, ahead_x)
    asked_y = _asked_zmp(parameters, com[1], com_velocity[1], zmp[1], sum_y, ahead_y)
    zmp[0], zmp[1] = nearest_under_foot(asked_x, asked_y, half[0], half[1], yaw)
    tolerance = EDGE_TOLERANCE * parameters.swing.reach
    cut_x = abs(zmp[0] - asked_x) > tolerance
    cut_y = abs(zmp[1] - asked_y) > tolerance
    if not cut_x:
        zmp_sum[0] = sum_x
    if not cut_y:
        zmp_sum[1] = sum_y
    return cut_x or cut_y


@njit
def regulate_plan(parameters, yaw, plan):
    """One sample of the twin."""
    regulate(
        parameters, plan, yaw, plan.elapsed, plan.com, plan.com_velocity, plan.zmp, plan.zmp_sum
    )


@njit
def walk_plan(parameters, until, yaw, plan):
    """Walk the twin on within the step, in cycles like the robot's, also those that were missed."""
    until = min(until, plan.step_duration)
    while until - plan.elapsed > LAST_CYCLE * parameters.period:
        time = until - plan.elapsed
        if time > (1.0 + LAST_CYCLE) * parameters.period:
            time = parameters.period
        for i in range(2):
            plan.com[i], plan.com_velocity[i] = com_flow(
                plan.com[i], plan.com_velocity[i], plan.zmp[i], parameters.omega, time
            )
        plan.elapsed += time
        if plan.step_duration - plan.elapsed > LAST_CYCLE * parameters.period:
            regulate_plan(parameters, yaw, plan)


@njit
def land_plan(parameters, support_side, plan):
    """The twin lands where it was to land; from there its next step is the nominal one."""
    for i in range(2):
        plan.com[i] -= plan.step[i]
        plan.zmp[i] -= plan.step[i]
        plan.step[i] = parameters.step[side_index(support_side), i]
    plan.step_duration, plan.elapsed = parameters.step_duration, 0.0
    plan.support_side = support_side

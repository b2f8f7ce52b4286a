"""The gains of ZMP preview control: optimal tracking of a ZMP that is known ahead of time.

The cart on a table of [Kajita2003], one axis, with the jerk u of the CoM as its input:

    x = (com, com', com''),   x(k+1) = A x(k) + B u(k),   zmp(k) = C x(k) = com - com'' / omega^2

and the input that minimises the sum of Q_e e^2 + dx^T Q_x dx + R du^2 for ever, where e is the
error of the ZMP, and dx and du are the changes from sample to sample:

    u(k) = -G_i sum_{i<=k} e(i) - G_x x(k) + sum_{l=1..N} G_p(l) zmp_ref(k + l).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.errors import ParameterError

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

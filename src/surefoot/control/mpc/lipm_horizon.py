"""What the CoM does over a horizon on which the ZMP is constant interval by interval.

The prediction of linear MPC for walking ([Wieber2006], [Herdt2010]), with the ZMP itself as the
input: with the CoM's jerk as the input the ZMP cannot jump from foot to foot, so between the
samples around a touchdown it would lie where no foot is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

NEXT_NODE = 1e-9
"""A node this fraction of a sample ahead is now."""


@dataclass(frozen=True)
class Horizon:
    """Intervals of a horizon, seen from one moment of a step.

    Nodes lie at multiples of the sample since touchdown, so a touchdown is one of them; only the
    first interval is shorter.

    Attributes:
        lengths: of the intervals [s], shape (n,).
        feet: which foot stands in each: 0 the present one, 1 the next one, ..., shape (n,).
    """

    lengths: NDArray[np.float64]
    feet: NDArray[np.int64]


def horizon(elapsed: float, sample: float, samples: int, samples_per_step: int) -> Horizon:
    """The horizon from `elapsed` since touchdown on.

    Args:
        elapsed: now, in [0, sample * samples_per_step) [s].
        sample: distance of the nodes [s].
        samples: how many intervals.
        samples_per_step: a step lasts so many samples.
    """
    node = math.floor(elapsed / sample + NEXT_NODE)
    lengths = np.full(samples, sample)
    lengths[0] = (node + 1) * sample - elapsed
    return Horizon(lengths, (node + np.arange(samples)) // samples_per_step)


def velocity_response(
    omega: float, lengths: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The CoM velocity at the end of each interval, for a state whose convergent part is nought.

        velocity = from_dcm dcm + from_zmp zmp

    by the exact flow of the LIPM, see `dcm.pendulum`; there, com = dcm / 2.

    Args:
        omega: natural frequency [1/s].
        lengths: of the intervals [s], shape (n,).

    Returns:
        from_dcm (n,) [1/s]; from_zmp (n, n) [1/s].
    """
    count = len(lengths)
    inputs, from_zmp = np.zeros((2, count)), np.empty((count, count))
    for i, length in enumerate(lengths):
        cosh, sinh = math.cosh(omega * length), math.sinh(omega * length)
        inputs = np.array([[cosh, sinh / omega], [omega * sinh, cosh]]) @ inputs
        inputs[:, i] = 1.0 - cosh, -omega * sinh
        from_zmp[i] = inputs[1]
    return 0.5 * omega * np.exp(omega * np.cumsum(lengths)), from_zmp


def push_response(
    from_zmp: NDArray[np.float64], lengths: NDArray[np.float64], lasting: float
) -> NDArray[np.float64]:
    """The CoM velocity at the end of each interval under a push that goes on for a time.

    A force F moves the CoM as a ZMP does that is F / (m omega^2) further back.

    Args:
        from_zmp: of `velocity_response`, shape (n, n) [1/s].
        lengths: of the intervals [s], shape (n,).
        lasting: how much longer it pushes [s].

    Returns:
        Velocity per F / (m omega^2) (n,) [1/s].
    """
    begins = np.cumsum(lengths) - lengths
    return -from_zmp @ np.clip((lasting - begins) / lengths, 0.0, 1.0)


def lean_response(
    inertia: float, lengths: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lean of the trunk, and its rate, at the end of each interval under constant hip torques.

        (lean, rate) = from_state (lean, rate) + from_torque torque

    Args:
        inertia: of the trunk [kg m^2].
        lengths: of the intervals [s], shape (n,).

    Returns:
        from_state (n, 2, 2); from_torque (n, 2, n) [rad/(N m)] and [rad/(s N m)].
    """
    count = len(lengths)
    state, inputs = np.eye(2), np.zeros((2, count))
    from_state, from_torque = np.empty((count, 2, 2)), np.empty((count, 2, count))
    for i, length in enumerate(lengths):
        flow = np.array([[1.0, length], [0.0, 1.0]])
        state, inputs = flow @ state, flow @ inputs
        inputs[:, i] = 0.5 * length * length / inertia, length / inertia
        from_state[i], from_torque[i] = state, inputs
    return from_state, from_torque

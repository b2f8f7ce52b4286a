"""Online footstep optimisation: the next landing by the value of what comes after ([Feng2016]).

A CoM planner regulates the LIPM about the motion over the desired footsteps. With the state
x = (c, c' / omega) and the ZMP p, as deviations, and times in 1 / omega,

    minimise  integral of  com_weight c^2 + velocity_weight (c')^2 + zmp_weight p^2,

it has the value function V(x) = x' S x, with S of the algebraic Riccati equation, here in closed
form. The receding-horizon program has the same cost up to one step ahead, V for all that comes
after it, and beside the ZMPs only ONE landing as an unknown. CoM errors count from the foot that
stands by then, so a landing that is moved takes later footsteps with it.

The source plans the CoM with a quadratic value function over given footsteps, and optimises the
next one of them against it. The LIPM in closed form, five intervals a step, and that a push is
expected to go on as in `mpc.placement` are choices of this implementation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefoot.control.fields import filled, setting, weight
from surefoot.control.mpc.horizon import Horizon
from surefoot.control.mpc.placement import FootPlacementMpc
from surefoot.control.registry import method

COM_WEIGHT = 0.1
"""Default weight of CoM and of velocity over omega, beside a weight of 1 on a ZMP [1/m^2]."""


def value_matrix(com_weight: float, velocity_weight: float, zmp_weight: float) -> np.ndarray:
    """S of V(x) = x' S x for the state (c, c' / omega) and times in 1 / omega, shape (2, 2).

    With A = ((0, 1), (1, 0)) and B = (0, -1)', A'S + SA - SBB'S / r + Q = 0 is three equations for
    S = ((a, b), (b, d)): 2 b - b^2 / r + q_1 = 0, 2 b - d^2 / r + q_2 = 0, a + d = b d / r.

    Args:
        com_weight: q_1, on the CoM [1/m^2].
        velocity_weight: q_2, on its velocity over omega [1/m^2].
        zmp_weight: r, positive [1/m^2].
    """
    r = zmp_weight
    b = r + math.sqrt(r * (r + com_weight))
    d = math.sqrt(r * (2.0 * b + velocity_weight))
    return np.array([[b * d / r - d, b], [b, d]])


@method(
    "footstep-optimisation",
    label="online footstep optimisation",
    source="Feng, Xinjilefu, Atkeson, Kim 2016",
    adapts="ZMP, step location",
    cannot="steps at fixed times; one landing ahead",
    cites=("Feng2016", "Arnstrom2022"),
    order=55,
)
@dataclass(frozen=True)
class FootstepOptimisation(FootPlacementMpc):
    """The ZMP and the next landing, by the value function of a CoM planner.

    Raises:
        VelocityError: the velocity cannot be walked, or not on this leg.
        RobotError: the leg is too slow to step at all.
        ParameterError: another argument is out of range.
        MissingExtraError: DAQP is not installed.
    """

    samples: int = setting(5, "", "intervals of the horizon, a step")
    com_weight: float = weight(
        COM_WEIGHT, "1/m^2", "on the deviation of the CoM from the nominal gait"
    )
    velocity_weight: float | None = weight(
        None, "s^2/m^2", "on the deviation of its velocity; 0.1 / omega^2 if None",
        own=lambda mpc: COM_WEIGHT / mpc.robot.omega**2,
    )  # fmt: skip

    def make_program(self, ahead: Horizon) -> tuple[NDArray[np.float64], ...]:
        """Hessian, gain, rows and row_state of one control cycle."""
        omega, steps = self.gait.omega, self.steps_ahead
        times, costs = omega * ahead.lengths, (self.com_weight, filled(self.velocity_weight))
        # On (c, c') in SI, where the value function has (c, c' / omega).
        units = np.array([1.0, 1.0 / omega])
        weights = times[:, None, None] * np.diag(costs)
        value = value_matrix(costs[0], omega**2 * costs[1], self.zmp_weight)
        weights[-1] = value * np.outer(units, units)
        from_unknown, from_state = self.responses(ahead)
        own = np.append(self.zmp_weight * times, np.full(steps, self.step_weight))
        hessian = np.einsum("ika,kij,jkb->ab", from_unknown, weights, from_unknown)
        gain = np.einsum("ika,kij,jkb->ab", from_unknown, weights, from_state)
        none = np.zeros((0, self.samples + steps))
        return hessian + np.diag(own), gain, none, none[:, :2]

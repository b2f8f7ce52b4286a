"""What the quadratic programs of torque-controlled bodies share: ground, motors, arrays, solver."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.record import new_array
from surefoot.robot.legs import find_knees
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.tasks import GROUND, JOINTS, MOMENT_ARM

EQUALITY, SOFT = 5, 8
"""Kinds of constraints, to the solver."""


def believed_ground(
    multibody: Multibody, friction: float, sole_part: float, max_force: float
) -> NDArray[np.void]:
    """What a mapping relies upon, a `GROUND` record.

    Args:
        multibody: that stands on it.
        friction: coefficient [-].
        sole_part: fraction of the sole in which the ZMP is kept [-].
        max_force: largest vertical force on one sole, in weights [-].
    """
    ground = new_array(GROUND)
    ground["friction"], ground["max_force"] = friction, max_force
    ground["half"] = np.array(multibody.robot.foot.half) * sole_part
    ground["arm"] = MOMENT_ARM * multibody.robot.com_height
    ground["mass"] = multibody.mass
    ground["gravity"] = -multibody.model.opt.gravity[2]
    ground["rolls"] = len(multibody.passive_dofs) > 6
    return ground


def motor_limits(multibody: Multibody, knee_guard: float) -> NDArray[np.void]:
    """Limits of the joints with motors, `JOINTS` records, shape (n,).

    Args:
        multibody: whose joints.
        knee_guard: least bend of the knees [rad].
    """
    model = multibody.model
    joints = np.zeros(len(multibody.motors), JOINTS)
    joints["dof"], joints["position"] = multibody.motor_dofs, multibody.motor_positions
    joints["nominal"] = multibody.nominal[multibody.motor_positions]
    limited = model.jnt_limited[multibody.motors].astype(bool)
    ranges = model.jnt_range[multibody.motors]
    joints["low"] = np.where(limited, ranges[:, 0], -1e9)
    joints["high"] = np.where(limited, ranges[:, 1], 1e9)
    for joint in find_knees(multibody):
        row = joints[joint]
        if row["nominal"] > 0.0:
            joints["low"][joint] = max(row["low"], knee_guard)
        else:
            joints["high"][joint] = min(row["high"], -knee_guard)
    joints["torque"] = np.minimum(multibody.torque, 1e9)
    joints["speed"] = np.minimum(multibody.speed, 1e9)
    return joints


@njit
def squares(rows, right, count, n, hessian, slope):
    """Write R'R and -R'b; most rows are zero for most unknowns."""
    hessian[:, :] = 0.0
    slope[:] = 0.0
    for r in range(count):
        for i in range(n):
            value = rows[r, i]
            if value != 0.0:
                slope[i] -= value * right[r]
                for j in range(i + 1):
                    hessian[i, j] += value * rows[r, j]
    for i in range(n):
        for j in range(i):
            hessian[j, i] = hessian[i, j]


class Program:
    """The arrays of one contact situation, and the solver that warm-starts from its last answer.

    Args:
        n: unknowns.
        m: constraints, beside the bounds of the unknowns.
        equalities: how many of these come first and are equalities.
        soft: those that yield if they must, as indices among bounds and constraints.
    """

    def __init__(self, n: int, m: int, equalities: int, soft: NDArray[np.int64]) -> None:
        self.hessian, self.slope = np.zeros((n, n)), np.zeros(n)
        self.matrix = np.zeros((m, n))
        self.low, self.high = np.zeros(n + m), np.zeros(n + m)
        self.kinds = np.zeros(n + m, np.int32)
        self.kinds[n : n + equalities] = EQUALITY
        self.kinds[soft] = SOFT
        self.solver: Any = None

    def solve(self, make: Any) -> tuple[NDArray[np.float64], int, Any]:
        """The solution, its status (1 or 2 is success) and what else the solver returns.

        Args:
            make: a solver, see `daqp.Model`.
        """
        if self.solver is None:
            self.solver = make()
            self.solver.setup(
                self.hessian, self.slope, self.matrix, self.high, self.low, self.kinds
            )
        else:
            self.solver.update(
                H=self.hessian, f=self.slope, A=self.matrix, bupper=self.high, blower=self.low
            )
        solution, _, status, about = self.solver.solve()
        if status < 1:
            # From the last active set it can cycle; from scratch it has not been seen to.
            self.solver.setup(
                self.hessian, self.slope, self.matrix, self.high, self.low, self.kinds
            )
            solution, _, status, about = self.solver.solve()
        return solution, status, about

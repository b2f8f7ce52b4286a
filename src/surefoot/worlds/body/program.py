"""What the quadratic programs of torque-controlled bodies share: ground, motors and solver."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.record import new_array
from surefoot.robot.legs import find_knees
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.tasks import GROUND, MOMENT_ARM, MOTOR, WRENCH, Program

EQUALITY, SOFT = 5, 8
"""Kinds of constraints, to the solver."""


def believed_ground(
    multibody: Multibody, friction: float, sole_part: float, max_force: float
) -> NDArray[np.void]:
    """What a mapping relies upon, a `Ground` record.

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
    """The joints with motors and their limits, `Motor` records, shape (n,).

    Args:
        multibody: whose joints.
        knee_guard: least bend of the knees [rad].
    """
    model = multibody.model
    motors = np.zeros(len(multibody.motors), MOTOR)
    motors["dof"], motors["position"] = multibody.motor_dofs, multibody.motor_positions
    motors["nominal"] = multibody.nominal[multibody.motor_positions]
    limited = model.jnt_limited[multibody.motors].astype(bool)
    ranges = model.jnt_range[multibody.motors]
    motors["low"] = np.where(limited, ranges[:, 0], -1e9)
    motors["high"] = np.where(limited, ranges[:, 1], 1e9)
    for joint in find_knees(multibody):
        row = motors[joint]
        if row["nominal"] > 0.0:
            motors["low"][joint] = max(row["low"], knee_guard)
        else:
            motors["high"][joint] = min(row["high"], -knee_guard)
    motors["torque"] = np.minimum(multibody.torque, 1e9)
    motors["speed"] = np.minimum(multibody.speed, 1e9)
    return motors


@njit
def wrench_rows(ground, sole, out):
    """Write the Jacobian of a carrying sole in its own axes, in units of the unknowns."""
    weight = ground.mass * ground.gravity
    for i in range(WRENCH):
        unit = weight if i < 3 else weight * ground.arm
        block = 3 * (i // 3)
        for c in range(sole.jacobian.shape[1]):
            total = 0.0
            for j in range(3):
                total += sole.axes[j, i % 3] * sole.jacobian[block + j, c]
            out[i, c] = unit * total


@njit
def squares(tasks, count, n, program):
    """Write R'R and -R'b; most rows are zero for most unknowns."""
    rows, hessian, slope = tasks.rows, program.hessian, program.slope
    hessian[:, :] = 0.0
    slope[:] = 0.0
    for r in range(count):
        for i in range(n):
            value = rows[r, i]
            if value != 0.0:
                slope[i] -= value * tasks.right[r]
                for j in range(i + 1):
                    hessian[i, j] += value * rows[r, j]
    for i in range(n):
        for j in range(i):
            hessian[j, i] = hessian[i, j]


class Solver:
    """The program of one contact situation, and DAQP, which starts from its last answer.

    Args:
        make: one of DAQP.
        n: unknowns.
        m: constraints, beside the bounds of the unknowns.
        equalities: how many of these come first and are equalities.
        soft: those that yield if they must, as indices among bounds and constraints.
    """

    def __init__(
        self, make: Callable[[], Any], n: int, m: int, equalities: int, soft: NDArray[np.int64]
    ) -> None:
        self.program = Program(
            np.zeros((n, n)), np.zeros(n), np.zeros((m, n)), np.zeros(n + m), np.zeros(n + m)
        )
        self._kinds = np.zeros(n + m, np.int32)
        self._kinds[n : n + equalities] = EQUALITY
        self._kinds[soft] = SOFT
        self._make = make
        self._solver: Any = None

    def solve(self) -> tuple[NDArray[np.float64], int, Any]:
        """The solution, its status (1 or 2 is success) and what else DAQP returns."""
        hessian, slope, matrix, low, high = self.program
        if self._solver is None:
            self._solver = self._make()
            self._solver.setup(hessian, slope, matrix, high, low, self._kinds)
        else:
            self._solver.update(H=hessian, f=slope, A=matrix, bupper=high, blower=low)
        solution, _, status, about = self._solver.solve()
        if status < 1:
            # From the last active set it can cycle; from scratch it has not been seen to.
            self._solver.setup(hessian, slope, matrix, high, low, self._kinds)
            solution, _, status, about = self._solver.solve()
        return solution, status, about

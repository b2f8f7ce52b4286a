"""What mappings to torques share: ground, motors, rows, solver and the class of their settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.control.fields import check_fields, described, documented, setting
from surefoot.record import new_array
from surefoot.robot.legs import find_knees
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.interface import JointMemory
from surefoot.worlds.body.tasks import GROUND, MOMENT_ARM, MOTOR, WRENCH, Program

EQUALITY, SOFT = 5, 8
"""Kinds of constraints, to the solver."""


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


@njit
def factor_and_solve(square, sums):
    """Replace B by the X of S X = B, S positive definite, by Cholesky; whether it was.

    Only the lower half of S is read, and overwritten. A few dozen unknowns take longer in a
    library's call than here.
    """
    n = square.shape[0]
    for i in range(n):
        for j in range(i + 1):
            total = square[i, j]
            for k in range(j):
                total -= square[i, k] * square[j, k]
            if j < i:
                square[i, j] = total / square[j, j]
            elif total > 0.0:
                square[i, i] = math.sqrt(total)
            else:
                return False
    for c in range(sums.shape[1]):
        for i in range(n):
            for k in range(i):
                sums[i, c] -= square[i, k] * sums[k, c]
            sums[i, c] /= square[i, i]
        for i in range(n - 1, -1, -1):
            for k in range(i + 1, n):
                sums[i, c] -= square[k, i] * sums[k, c]
            sums[i, c] /= square[i, i]
    return math.isfinite(sums.sum())


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


@documented
@dataclass(frozen=True)
class TorqueMapping:
    """From a reference to torques by a program a cycle; a leaf gives its workspace and `joints`.

    Weights are on squared errors: the larger the weight, the less the task yields.
    """

    multibody: Multibody = field(metadata=described("the mechanism"))
    friction: float = setting(0.7, "-", "coefficient that is relied upon; a pyramid", above=0.0)
    sole_part: float = setting(0.9, "-", "fraction of the sole in which the ZMP is kept", above=0.0)
    max_force: float = setting(
        2.5, "-", "largest vertical force on one sole, in weights", above=0.0
    )
    knee_guard: float = setting(
        0.12, "rad",
        "least bend of the joints whose nominal pose is bent, so that legs never lock", least=0.0,
    )  # fmt: skip
    weights: Mapping[str, float] = field(
        default_factory=dict, metadata=described("changes of single weights, by name, in SI")
    )
    stiffnesses: Mapping[str, float] = field(
        default_factory=dict, metadata=described("likewise of stiffnesses")
    )
    _workspace: Any = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_fields(self)
        object.__setattr__(self, "_workspace", self.make_workspace())

    def make_workspace(self) -> Any:
        """What it computes with, and what it found last."""
        raise NotImplementedError(f"{type(self).__name__}.make_workspace")

    def start(self) -> JointMemory:
        """Nothing that its answer depends on."""
        return {}

    def fresh(self) -> Self:
        """The same with a solver that remembers nothing."""
        return replace(self)

    def ground(self) -> NDArray[np.void]:
        """What it relies upon, a `Ground` record."""
        multibody, ground = self.multibody, new_array(GROUND)
        ground["friction"], ground["max_force"] = self.friction, self.max_force
        ground["half"] = np.array(multibody.robot.foot.half) * self.sole_part
        ground["arm"] = MOMENT_ARM * multibody.robot.com_height
        ground["mass"] = multibody.mass
        ground["gravity"] = -multibody.model.opt.gravity[2]
        ground["rolls"] = len(multibody.passive_dofs) > 6
        return ground

    def motors(self) -> NDArray[np.void]:
        """The joints with motors and their limits, `Motor` records, shape (n,)."""
        multibody, model = self.multibody, self.multibody.model
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
                motors["low"][joint] = max(row["low"], self.knee_guard)
            else:
                motors["high"][joint] = min(row["high"], -self.knee_guard)
        motors["torque"] = np.minimum(multibody.torque, 1e9)
        motors["speed"] = np.minimum(multibody.speed, 1e9)
        return motors


def wrench_units(ground: np.void) -> NDArray[np.float64]:
    """One of each unknown of a wrench, a `Ground` record given, shape (6,) [N, N m]."""
    weight = float(ground["mass"] * ground["gravity"])
    return weight * np.array([1.0] * 3 + [float(ground["arm"])] * 3)

"""Whole-body inverse dynamics: joint torques from one quadratic program a cycle.

The tasks are those of `inverse_dynamics_rows`. With one foot on the ground the program places the
ZMP itself, rather than a CoM acceleration that would have to make up for what the swinging leg does
to the angular momentum: the pendulum that the controllers steer then is the robot's own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple, Self

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number, optional_module
from surefoot.compiled import entry_point, njit
from surefoot.robot.motors import torque_range
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand
from surefoot.worlds.body.mechanics import MOTION, Mechanics
from surefoot.worlds.body.program import Program, believed_ground, motor_limits, squares
from surefoot.worlds.body.tasks import (
    FREE,
    GROUND,
    JOINTS,
    STIFFNESSES,
    WEIGHTS,
    WRENCH,
    WRENCH_ROWS,
    com_rows,
    filled,
    ground_rows,
    motion_rows,
    posture_and_bounds,
    stand_rows,
    swing_rows,
    trunk_rows,
    usual_stiffnesses,
    usual_weights,
    wrench_columns,
    zmp_rows,
)

MAX_TASK_ROWS = 24


@njit
def assemble(
    weights, stiffness, ground, joints, passive, base_dof, reference,
    inertia, bias, position, velocity, jacobians, motion,
    wrenches, rows, right, error, hessian, slope, matrix, low, high,
):  # fmt: skip
    """Write the quadratic program of one cycle.

    Its arrays have the robot's length, which no record holds, and MuJoCo's are read where they lie.

    Args:
        weights, stiffness, ground, reference: arrays of one record.
        joints: `JOINTS` records of the motors.
        passive: degrees of freedom without a motor.
        base_dof: first degree of freedom of the base.
        inertia, bias, position, velocity, jacobians, motion: as in `Mechanics`.
        wrenches, rows, right, error: scratch.
        hessian, slope, matrix, low, high: of the program, written.
    """
    w, k, g, ref = weights[0], stiffness[0], ground[0], reference[0]
    nv, count = inertia.shape[0], ref.stands[0] + ref.stands[1]
    places, soles = motion[0].sole_position, motion[0].sole_axes
    speeds, drifts = motion[0].sole_velocity, motion[0].sole_drift
    n = nv + WRENCH * count
    rows[:, :n] = 0.0
    r, carrying = 0, 0
    for side in range(2):
        if ref.stands[side] == 1:
            r = stand_rows(w, k, jacobians[side], speeds[side], drifts[side], rows, right, r)
            wrench_columns(g, soles[side], jacobians[side], wrenches, WRENCH * carrying)
            if count == 1:
                r = zmp_rows(w, g, ref, places[side], soles[side], nv, rows, right, r)
            carrying += 1
        else:
            r = swing_rows(
                w, k, g.rolls, ref, jacobians[side], speeds[side], drifts[side], places[side],
                soles[side], error, rows, right, r,
            )  # fmt: skip
    if count == 2:
        r = com_rows(w, g, ref, soles, nv, rows, right, r)
    turning = velocity[base_dof + 3 : base_dof + 6]
    r = trunk_rows(w, k, ref, motion[0].base_axes, turning, base_dof + 3, error, rows, right, r)
    squares(rows, right, r, n, hessian, slope)
    for i in range(n):
        hessian[i, i] += w.turning if i < nv else w.wrench
        low[i], high[i] = -FREE, FREE
    for i in range(base_dof, base_dof + 3):
        hessian[i, i] += w.acceleration - w.turning
    posture_and_bounds(w, k, joints, position, velocity, hessian, slope, low, high)
    matrix[:] = 0.0
    r = 0
    for j in range(passive.shape[0]):
        motion_rows(passive[j], inertia, wrenches, n - nv, matrix[r])
        low[n + r] = high[n + r] = -bias[passive[j]]
        r += 1
    for j in range(joints.shape[0]):
        dof = joints[j].dof
        motion_rows(dof, inertia, wrenches, n - nv, matrix[r])
        least, most = torque_range(joints[j].torque, velocity[dof], joints[j].speed)
        low[n + r], high[n + r] = least - bias[dof], most - bias[dof]
        r += 1
    ground_rows(g, count, nv, n, matrix, low, high, r)


@njit
def joint_torques(joints, passive, bias, velocity, inertia, matrix, solution, torque):
    """Write what the motors have to give: M a + h - J' f, within what they can.

    What no motor moves obeys its equations of motion to rounding, not just to the accuracy of a
    solver whose cost weighs contacts a million times as much as rest: its accelerations are mended
    first, which changes them in the eighth digit.
    """
    count, n = passive.shape[0], solution.shape[0]
    rest, block = np.empty(count), np.empty((count, count))
    for i in range(count):
        rest[i] = -bias[passive[i]]
        for c in range(n):
            rest[i] -= matrix[i, c] * solution[c]
        for j in range(count):
            block[i, j] = inertia[passive[i], passive[j]]
    change = np.linalg.solve(block, rest)
    for i in range(count):
        solution[passive[i]] += change[i]
    for j in range(joints.shape[0]):
        dof = joints[j].dof
        total = bias[dof]
        for c in range(n):
            total += matrix[count + j, c] * solution[c]
        least, most = torque_range(joints[j].torque, velocity[dof], joints[j].speed)
        torque[j] = min(max(total, least), most)


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    whole = np.dtype(np.int64)
    return (
        entry_point(
            assemble, WEIGHTS, STIFFNESSES, GROUND, JOINTS, whole, numba.int64, BODY_REFERENCE,
            matrix, vector, vector, vector, cube, MOTION, matrix, matrix, vector, vector,
            matrix, vector, matrix, vector, vector,
        ),
        entry_point(
            joint_torques, JOINTS, whole, vector, vector, matrix, matrix, vector, vector
        ),
    )  # fmt: skip


class Answer(NamedTuple):
    """What a program of inverse dynamics was answered.

    Attributes:
        acceleration: generalised, shape (nv,).
        wrenches: of the soles that carry, left before right, each in its own axes: force and
            moment, shape (count, 6) [N, N m].
        multipliers: of the constraints: bounds of the unknowns, then motion of what no motor
            moves, torques of the motors, and ten rows for each sole. One that is not 0 binds.
    """

    acceleration: NDArray[np.float64]
    wrenches: NDArray[np.float64]
    multipliers: NDArray[np.float64]


@dataclass(frozen=True)
class InverseDynamics:
    """Torques that carry out a reference, within friction, soles, torques and joint limits.

    Weights are on squared errors: the larger the weight, the less the task yields.

    Args:
        multibody: the mechanism.
        friction: coefficient that is relied upon; a pyramid [-].
        sole_part: fraction of the sole in which the ZMP is kept [-].
        max_force: largest vertical force on one sole, in weights [-].
        knee_guard: least bend of the joints whose nominal pose is bent, so that legs never lock
            [rad].
        weights, stiffnesses: changes of single values of `WEIGHTS` and `STIFFNESSES`, by name.

    Raises:
        MissingExtraError: daqp is not installed.
        ParameterError: a value is out of range.
    """

    multibody: Multibody
    friction: float = 0.7
    sole_part: float = 0.9
    max_force: float = 2.5
    knee_guard: float = 0.12
    weights: dict[str, float] = field(default_factory=dict)
    stiffnesses: dict[str, float] = field(default_factory=dict)
    _workspace: dict[str, Any] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("friction", "sole_part", "max_force"):
            check_number(name, getattr(self, name), 0.0, "-", above=True)
        check_number("knee_guard", self.knee_guard, 0.0, "rad")
        multibody = self.multibody
        nv = multibody.model.nv
        soft = multibody.motor_dofs
        passive = len(multibody.passive_dofs)
        object.__setattr__(
            self,
            "_workspace",
            {
                "weights": filled(WEIGHTS, usual_weights(multibody.robot), self.weights),
                "stiffness": filled(
                    STIFFNESSES, usual_stiffnesses(multibody.robot), self.stiffnesses
                ),
                "ground": believed_ground(multibody, self.friction, self.sole_part, self.max_force),
                "joints": motor_limits(multibody, self.knee_guard),
                "passive": multibody.passive_dofs.astype(np.int64),
                "base": multibody.base_dof,
                "wrenches": np.zeros((2 * WRENCH, nv)),
                "rows": np.zeros((MAX_TASK_ROWS, nv + 2 * WRENCH)),
                "right": np.zeros(MAX_TASK_ROWS),
                "error": np.zeros(3),
                "make": optional_module("daqp", "inverse dynamics", "mujoco").Model,
                "programs": {count: {} for count in (1, 2)},
                "command": JointCommand(len(multibody.motors), nv),
                "assemble": _compiled()[0],
                "torques": _compiled()[1],
                "new": lambda count: Program(
                    nv + WRENCH * count, nv + WRENCH_ROWS * count, passive, soft
                ),
            },
        )

    def start(self) -> None:
        """It remembers nothing that its answer depends on."""

    def joints(
        self,
        mechanics: Mechanics,
        reference: NDArray[np.void],
        forces: NDArray[np.float64],
        memory: None = None,
    ) -> tuple[JointCommand, None]:
        """The torques for one cycle, and the accelerations that they are expected to cause.

        What the ground pushes is decided here, and `forces` not asked for.
        """
        s, m = self._workspace, mechanics
        left, right = reference["stands"][0].tolist()
        key = left + 2 * right
        programs = s["programs"][left + right]
        program = programs.get(key)
        if program is None:
            program = programs[key] = s["new"](left + right)
        s["assemble"](
            s["weights"], s["stiffness"], s["ground"], s["joints"], s["passive"], s["base"],
            reference, m.inertia, m.bias, m.position, m.velocity, m.sole_jacobian, m.motion,
            s["wrenches"], s["rows"], s["right"], s["error"],
            program.hessian, program.slope, program.matrix, program.low, program.high,
        )  # fmt: skip
        solution, status, about = program.solve(s["make"])
        command: JointCommand = s["command"]
        command.status = status
        if status >= 1:
            s["torques"](
                s["joints"], s["passive"], m.bias, m.velocity, m.inertia, program.matrix, solution,
                command.torque,
            )  # fmt: skip
            command.acceleration[:] = solution[: len(command.acceleration)]
            s["solution"], s["about"], s["count"] = solution, about, left + right
        return command, None

    def fresh(self) -> Self:
        """The same with a solver that remembers nothing."""
        return replace(self)

    @property
    def joint_limits(self) -> NDArray[np.void]:
        """Limits of the joints with motors, a copy of `JOINTS` records, shape (n,)."""
        return self._workspace["joints"].copy()

    @property
    def stiffness(self) -> NDArray[np.void]:
        """What tasks and limits answer an error with, a copy of a `STIFFNESSES` record."""
        return self._workspace["stiffness"].copy()

    def answer(self) -> Answer:
        """The last program that was solved; zeros before the first."""
        s, nv, ground = self._workspace, self.multibody.model.nv, self._workspace["ground"]
        count = s.get("count", 0)
        solution = s.get("solution", np.zeros(nv))
        weight = float(ground["mass"][0] * ground["gravity"][0])
        units = weight * np.array([1.0] * 3 + [float(ground["arm"][0])] * 3)
        multipliers = s["about"]["lam"] if "about" in s else np.zeros(0)
        return Answer(
            acceleration=solution[:nv].copy(),
            wrenches=solution[nv:].reshape(count, WRENCH) * units,
            multipliers=np.array(multipliers),
        )

"""Whole-body inverse dynamics: joint torques from one quadratic program a cycle.

The tasks are those of `worlds.body.tasks`. With one foot on the ground the program places the
ZMP itself, rather than a CoM acceleration that would have to make up for what the swinging leg does
to the angular momentum: the pendulum that the controllers steer then is the robot's own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import optional_module
from surefoot.compiled import entry_point, njit
from surefoot.control.fields import documented
from surefoot.robot.motors import torque_range
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand, JointMemory
from surefoot.worlds.body.mechanics import MOTION, Mechanics
from surefoot.worlds.body.program import (
    Solver,
    TorqueMapping,
    squares,
    wrench_rows,
    wrench_units,
)
from surefoot.worlds.body.tasks import (
    FREE,
    GROUND,
    MOTOR,
    STIFFNESSES,
    WEIGHTS,
    WRENCH,
    WRENCH_ROWS,
    Program,
    Sole,
    Tasks,
    com_rows,
    ground_rows,
    motion_rows,
    posture_and_bounds,
    stand_rows,
    swing_rows,
    task_stiffnesses,
    task_weights,
    trunk_rows,
    zmp_rows,
)

MAX_TASK_ROWS = 24


class _Robot(NamedTuple):
    """What is fixed: arrays of one record, `Motor` records, degrees of freedom without a motor, and
    the first one of the base."""

    weights: NDArray[np.void]
    stiffness: NDArray[np.void]
    ground: NDArray[np.void]
    motors: NDArray[np.void]
    passive: NDArray[np.int64]
    base_dof: int


class _State(NamedTuple):
    """Arrays of `Mechanics`, which are read where they lie."""

    inertia: NDArray[np.float64]
    bias: NDArray[np.float64]
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    sole_jacobian: NDArray[np.float64]
    motion: NDArray[np.void]


@njit
def assemble(robot, state, reference, tasks, program):
    """Write the quadratic program of one cycle; the tasks are scratch."""
    w, k, g, ref = robot.weights[0], robot.stiffness[0], robot.ground[0], reference[0]
    inertia, bias, velocity, motion = state.inertia, state.bias, state.velocity, state.motion[0]
    low, high, matrix, hessian = program.low, program.high, program.matrix, program.hessian
    base_dof, motors, passive = robot.base_dof, robot.motors, robot.passive
    nv, count = inertia.shape[0], ref.stands[0] + ref.stands[1]
    n = nv + WRENCH * count
    tasks.rows[:, :n] = 0.0
    r, carrying = 0, 0
    for side in range(2):
        sole = Sole(
            state.sole_jacobian[side], motion.sole_velocity[side], motion.sole_drift[side],
            motion.sole_position[side], motion.sole_axes[side],
        )  # fmt: skip
        if ref.stands[side] == 1:
            r = stand_rows(w, k, sole, tasks, r)
            wrench_rows(g, sole, tasks.wrenches[WRENCH * carrying :])
            if count == 1:
                r = zmp_rows(w, g, ref, sole, tasks, r)
            carrying += 1
        else:
            r = swing_rows(w, k, g, ref, sole, tasks, r)
    if count == 2:
        r = com_rows(w, g, ref, motion.sole_axes, nv, tasks, r)
    turning = velocity[base_dof + 3 : base_dof + 6]
    r = trunk_rows(w, k, ref, motion.base_axes, turning, base_dof + 3, tasks, r)
    squares(tasks, r, n, program)
    for i in range(n):
        hessian[i, i] += w.turning if i < nv else w.wrench
        low[i], high[i] = -FREE, FREE
    for i in range(base_dof, base_dof + 3):
        hessian[i, i] += w.acceleration - w.turning
    posture_and_bounds(w, k, motors, state.position, velocity, program)
    matrix[:] = 0.0
    r = 0
    for j in range(passive.shape[0]):
        motion_rows(passive[j], inertia, tasks.wrenches, n - nv, matrix[r])
        low[n + r] = high[n + r] = -bias[passive[j]]
        r += 1
    for j in range(motors.shape[0]):
        dof = motors[j].dof
        motion_rows(dof, inertia, tasks.wrenches, n - nv, matrix[r])
        least, most = torque_range(motors[j].torque, velocity[dof], motors[j].speed)
        low[n + r], high[n + r] = least - bias[dof], most - bias[dof]
        r += 1
    ground_rows(g, count, nv, program, r)


@njit
def joint_torques(robot, state, matrix, solution, torque):
    """Write what the motors have to give: M a + h - J' f, within what they can.

    What no motor moves obeys its equations of motion to rounding, not just to the accuracy of a
    solver whose cost weighs contacts a million times as much as rest: its accelerations are mended
    first, which changes them in the eighth digit.
    """
    passive, motors, bias = robot.passive, robot.motors, state.bias
    count, n = passive.shape[0], solution.shape[0]
    rest, block = np.empty(count), np.empty((count, count))
    for i in range(count):
        rest[i] = -bias[passive[i]]
        for c in range(n):
            rest[i] -= matrix[i, c] * solution[c]
        for j in range(count):
            block[i, j] = state.inertia[passive[i], passive[j]]
    change = np.linalg.solve(block, rest)
    for i in range(count):
        solution[passive[i]] += change[i]
    for j in range(motors.shape[0]):
        dof = motors[j].dof
        total = bias[dof]
        for c in range(n):
            total += matrix[count + j, c] * solution[c]
        least, most = torque_range(motors[j].torque, state.velocity[dof], motors[j].speed)
        torque[j] = min(max(total, least), most)


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    named = numba.types.NamedTuple
    weights, stiffness, ground, motors, motion = (
        numba.types.Array(numba.from_dtype(kind), 1, "C")
        for kind in (WEIGHTS, STIFFNESSES, GROUND, MOTOR, MOTION)
    )
    fixed = (weights, stiffness, ground, motors, numba.int64[::1], numba.int64)
    robot = named(fixed, _Robot)
    state = named((matrix, vector, vector, vector, cube, motion), _State)
    tasks = named((matrix, vector, matrix, vector), Tasks)
    program = named((matrix, vector, matrix, vector, vector), Program)
    return (
        entry_point(assemble, robot, state, BODY_REFERENCE, tasks, program),
        entry_point(joint_torques, robot, state, matrix, vector, vector),
    )


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


class _Workspace:
    """What a mapping computes with, and what it found last."""

    def __init__(self, mapping: InverseDynamics) -> None:
        multibody = mapping.multibody
        nv = multibody.model.nv
        self.robot = _Robot(
            task_weights(multibody.robot, mapping.weights),
            task_stiffnesses(multibody.robot, mapping.stiffnesses),
            mapping.ground(),
            mapping.motors(),
            multibody.passive_dofs.astype(np.int64),
            multibody.base_dof,
        )
        self.tasks = Tasks(
            np.zeros((MAX_TASK_ROWS, nv + 2 * WRENCH)), np.zeros(MAX_TASK_ROWS),
            np.zeros((2 * WRENCH, nv)), np.zeros(3),
        )  # fmt: skip
        self.make = optional_module("daqp", "inverse dynamics", "mujoco").Model
        self.solvers: dict[tuple[int, int], Solver] = {}
        self.command = JointCommand(len(multibody.motors), nv)
        self.assemble, self.torques = _compiled()
        self.solution, self.multipliers, self.count = np.zeros(nv), np.zeros(0), 0

    def solver(self, count: int) -> Solver:
        """For a number of soles that carry."""
        nv = len(self.command.acceleration)
        n, m = nv + WRENCH * count, nv + WRENCH_ROWS * count
        return Solver(self.make, n, m, len(self.robot.passive), self.robot.motors["dof"])


@documented
@dataclass(frozen=True)
class InverseDynamics(TorqueMapping):
    """Torques that carry out a reference, within friction, soles, torques and joint limits.

    Weights are on squared errors: the larger the weight, the less the task yields.

    Raises:
        MissingExtraError: daqp is not installed.
        ParameterError: a value is out of range.
    """

    _workspace: _Workspace = field(init=False, repr=False, compare=False)

    def make_workspace(self) -> _Workspace:
        """What it computes with, and what it found last."""
        return _Workspace(self)

    def joints(
        self,
        mechanics: Mechanics,
        reference: NDArray[np.void],
        forces: NDArray[np.float64],
        memory: JointMemory,
    ) -> tuple[JointCommand, JointMemory]:
        """The torques for one cycle, and what they should cause; `forces` are not asked for."""
        s, m = self._workspace, mechanics
        left, right = reference["stands"][0].tolist()
        solver = s.solvers.get((left, right))
        if solver is None:
            solver = s.solvers[left, right] = s.solver(left + right)
        state = _State(m.inertia, m.bias, m.position, m.velocity, m.sole_jacobian, m.motion)
        s.assemble(s.robot, state, reference, s.tasks, solver.program)
        solution, status, about = solver.solve()
        s.command.status = status
        if status >= 1:
            s.torques(s.robot, state, solver.program.matrix, solution, s.command.torque)
            s.command.acceleration[:] = solution[: len(m.velocity)]
            s.solution, s.multipliers, s.count = solution, about["lam"], left + right
        return s.command, memory

    @property
    def joint_limits(self) -> NDArray[np.void]:
        """Limits of the joints with motors, a copy of `Motor` records, shape (n,)."""
        return self._workspace.robot.motors.copy()

    @property
    def stiffness(self) -> NDArray[np.void]:
        """What tasks and limits answer an error with, a copy of a `Stiffnesses` record."""
        return self._workspace.robot.stiffness.copy()

    def answer(self) -> Answer:
        """The last program that was solved; zeros before the first."""
        s, nv = self._workspace, self.multibody.model.nv
        return Answer(
            acceleration=s.solution[:nv].copy(),
            wrenches=s.solution[nv:].reshape(s.count, WRENCH) * wrench_units(s.robot.ground[0]),
            multipliers=np.array(s.multipliers),
        )

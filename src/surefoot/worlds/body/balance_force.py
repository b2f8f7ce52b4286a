r"""Dynamic balance force control: contact forces for CoM and momentum, torques through Jacobians.

After [Stephens2010]. A reference is first turned into accelerations a_d of all joints: of the CoM,
of the trunk, and of the soles through the legs' Jacobians (`balance_motion`). One recursion of
Newton and Euler gives the forces that they need, tau_d = M a_d + h, without the joint-space inertia
M itself. The six rows of the floating base, moved to the CoM c, are the force and moment that the
ground has to give,

    sum_i f_i = m (a_c + g e_z),    sum_i (p_i - c) x f_i + n_i = dH/dt,

the momentum of the leg that swings included in dH/dt. A small quadratic program finds the wrenches
(f_i, n_i) of the soles that carry, in their own axes and as in `tasks`. It minimises weighted
squares of what is missed: of all six rows with two feet on the ground; with one, the ZMP stands for
the horizontal force, as in `inverse_dynamics`. Friction, soles, passive ankle rolls (which can
carry no moment) and the motors' torques are constraints. Then

    tau = tau_d - sum_i J_i^T (f_i, n_i)

in the rows of the motors. No acceleration is unknown: where a constraint keeps the ground from
giving what is needed, the torques are still those of a_d, and the body moves otherwise. That is
what the method saves, and where it is weaker than inverse dynamics.

Own choices: with one foot, a_d of the CoM is the pendulum's about the ZMP z, (c - z) (g + a_z) / h.
A joint near a limit is pushed off it in a_d, by a virtual spring and damper. A knee that carries
would not yield to that, so its bend is guarded by a row of the program: what the wrenches give
beyond the need accelerates one rigid body, of the constant composite inertia of the nominal pose,
which turns over the sole. Where [Stephens2010] adds the forces of tasks (virtual model control),
a_d has the tasks.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot import record
from surefoot.checks import optional_module
from surefoot.compiled import entry_point, njit
from surefoot.control.fields import documented
from surefoot.robot.motors import torque_range
from surefoot.worlds.body.balance_motion import (
    BALANCE,
    STIFFNESSES,
    BalanceRobot,
    BalanceState,
    BalanceStiffnesses,
    Plan,
    given_wrenches,
    knee_row,
    leg_dofs,
    needed_wrench,
    nominal_balance,
    plan_motion,
)
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
    WRENCH,
    WRENCH_ROWS,
    Program,
    Sole,
    Tasks,
    com_rows,
    ground_rows,
    task_stiffnesses,
    task_weights,
    zmp_rows,
)


class BalanceWeights(record.Record):
    """What the squared error of a task counts, where the error is 1 in `OwnUnits`.

    The units are those of the errors.
    """

    zmp: float = record.field("m", "place of the ZMP", default=1.0e4)
    com: float = record.field("m/s^2", "acceleration of the CoM", default=1.0e3)
    height: float = record.field("m/s^2", "likewise, vertical", default=1.0e3)
    moment: float = record.field("N m", "about the CoM, roll and pitch", default=1.0e4)
    moment_yaw: float = record.field("N m", "likewise about the vertical", default=200.0)
    wrench: float = record.field("-", "any wrench, in parts of the weight", default=1.0e-4)


WEIGHTS = BalanceWeights.DTYPE

MAX_TASK_ROWS = 6


@njit
def _task_rows(w, g, ref, state, plan, tasks):
    """Write the rows of the ground's tasks; how many there are."""
    r, count, m = 0, ref.stands[0] + ref.stands[1], state.motion[0]
    n, rows, right = WRENCH * count, tasks.rows, tasks.right
    rows[:, :n] = 0.0
    if count == 2:
        r = com_rows(w, g, ref, m.sole_axes, 0, tasks, r)
    else:
        side = 0 if ref.stands[0] == 1 else 1
        # No accelerations are unknown: the columns of the wrenches are the first.
        sole = Sole(
            state.sole_jacobian[side, :, :0], m.sole_velocity[side], m.sole_drift[side],
            m.sole_position[side], m.sole_axes[side],
        )  # fmt: skip
        r = zmp_rows(w, g, ref, sole, tasks, r)
    for i in range(3):
        root = math.sqrt(w.moment if i < 2 else w.moment_yaw)
        for c in range(n):
            rows[r, c] = root * plan.totals[3 + i, c]
        right[r] = root * plan.needed[3 + i]
        r += 1
    return r


@njit
def _carries(ref, legs, dof):
    for side in range(2):
        for c in range(legs.shape[1]):
            if ref.stands[side] == 1 and legs[side, c] == dof:
                return True
    return False


@njit
def assemble(robot, state, reference, plan, tasks, program):
    """Write the quadratic program of one cycle; the tasks are scratch but for the wrenches."""
    b, g, ref, m = robot.balance[0], robot.ground[0], reference[0], state.motion[0]
    forces, wrenches, needed = plan.forces, tasks.wrenches, plan.needed
    matrix, low, high = program.matrix, program.low, program.high
    needed_wrench(b, m, state.position, forces, needed)
    n = given_wrenches(g, ref, m, plan.totals)
    count = _task_rows(robot.weights[0], g, ref, state, plan, tasks)
    squares(tasks, count, n, program)
    for i in range(n):
        program.hessian[i, i] += robot.weights[0].wrench
        low[i], high[i] = -FREE, FREE
    matrix[:] = 0.0
    weight, r, first = g.mass * g.gravity, 0, 0
    for side in range(2):
        if ref.stands[side] == 1:
            sole = Sole(
                state.sole_jacobian[side], m.sole_velocity[side], m.sole_drift[side],
                m.sole_position[side], m.sole_axes[side],
            )  # fmt: skip
            wrench_rows(g, sole, wrenches[first:])
            first += WRENCH
    for side in range(2):
        roll = b.rolls[side]
        if ref.stands[side] == 1 and roll >= 0:
            for c in range(n):
                matrix[r, c] = wrenches[c, roll] / weight
            low[n + r] = high[n + r] = forces[roll] / weight
            r += 1
    for j in range(robot.motors.shape[0]):
        motor, dof = robot.motors[j], robot.motors[j].dof
        if _carries(ref, robot.legs, dof):
            least, most = torque_range(motor.torque, state.velocity[dof], motor.speed)
            for c in range(n):
                matrix[r, c] = -wrenches[c, dof] / weight
            low[n + r], high[n + r] = (least - forces[dof]) / weight, (most - forces[dof]) / weight
            r += 1
    for side in range(2):
        if ref.stands[side] == 1:
            knee = plan.knees[side]
            rest = knee_row(b, g, m, knee, state.position, needed, plan.totals, matrix[r])
            matrix[r] /= g.gravity
            low[n + r], high[n + r] = (knee[7] - rest) / g.gravity, (knee[8] - rest) / g.gravity
            r += 1
    ground_rows(g, ref.stands[0] + ref.stands[1], 0, program, r)


@njit
def joint_torques(motors, velocity, forces, wrenches, solution, torque):
    """Write tau_d - J' f, within what the motors can give."""
    for j in range(motors.shape[0]):
        motor = motors[j]
        total = forces[motor.dof]
        for c in range(solution.shape[0]):
            total -= wrenches[c, motor.dof] * solution[c]
        least, most = torque_range(motor.torque, velocity[motor.dof], motor.speed)
        torque[j] = min(max(total, least), most)


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None], Callable[..., None]]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    named = numba.types.NamedTuple
    weights, stiffness, balance, ground, motors, motion = (
        numba.types.Array(numba.from_dtype(kind), 1, "C")
        for kind in (WEIGHTS, STIFFNESSES, BALANCE, GROUND, MOTOR, MOTION)
    )
    fixed = (weights, stiffness, balance, ground, motors, numba.int64[:, ::1])
    robot = named(fixed, BalanceRobot)
    state = named((vector, vector, cube, motion), BalanceState)
    plan = named((vector, vector, matrix, vector, matrix), Plan)
    tasks = named((matrix, vector, matrix, vector), Tasks)
    program = named((matrix, vector, matrix, vector, vector), Program)
    return (
        entry_point(plan_motion, robot, state, BODY_REFERENCE, vector, plan),
        entry_point(assemble, robot, state, BODY_REFERENCE, plan, tasks, program),
        entry_point(joint_torques, MOTOR, vector, vector, matrix, vector, vector),
    )


class BalanceAnswer(NamedTuple):
    """What a program of balance forces was answered.

    Attributes:
        needed: force that the planned accelerations need, and moment about the CoM, in the world,
            shape (6,) [N, N m].
        given: what the soles are to give instead, likewise.
        wrenches: of the soles that carry, left before right, each in its own axes, shape
            (count, 6) [N, N m].
        multipliers: of the constraints: bounds of the unknowns, then passive ankles, torques of
            the legs that carry, their knees, and ten rows for each sole. One that is not 0 binds.
    """

    needed: NDArray[np.float64]
    given: NDArray[np.float64]
    wrenches: NDArray[np.float64]
    multipliers: NDArray[np.float64]


class _Workspace:
    """What a mapping computes with, and what it found last."""

    def __init__(self, mapping: BalanceForce) -> None:
        multibody = mapping.multibody
        nv = multibody.model.nv
        self.robot = BalanceRobot(
            task_weights(multibody.robot, mapping.weights, BalanceWeights),
            task_stiffnesses(multibody.robot, mapping.stiffnesses, BalanceStiffnesses),
            nominal_balance(multibody),
            mapping.ground(),
            mapping.motors(),
            leg_dofs(multibody),
        )
        self.plan = Plan(
            np.zeros(nv), np.zeros(nv), np.zeros((2, 9)), np.zeros(6), np.zeros((6, 2 * WRENCH))
        )
        self.tasks = Tasks(
            np.zeros((MAX_TASK_ROWS, 2 * WRENCH)), np.zeros(MAX_TASK_ROWS),
            np.zeros((2 * WRENCH, nv)), np.zeros(3),
        )  # fmt: skip
        self.make = optional_module("daqp", "balance force control", "mujoco").Model
        self.solvers: dict[tuple[int, int], Solver] = {}
        self.command = JointCommand(len(multibody.motors), nv)
        self.plan_motion, self.assemble, self.torques = _compiled()
        self.solution, self.multipliers = np.zeros(0), np.zeros(0)

    def solver(self, left: int, right: int) -> Solver:
        """For the soles that carry."""
        carry = [side for side, stands in enumerate((left, right)) if stands]
        rolls = sum(int(self.robot.balance["rolls"][0, side] >= 0) for side in carry)
        soft = sum(int((self.robot.legs[side] >= 0).sum()) + 1 for side in carry)
        n, m = WRENCH * len(carry), rolls + soft + WRENCH_ROWS * len(carry)
        return Solver(self.make, n, m, rolls, np.arange(n + rolls, n + rolls + soft))


@documented
@dataclass(frozen=True)
class BalanceForce(TorqueMapping):
    """Torques that carry out a reference through the forces of the ground, see this module.

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
        """The torques for one cycle, and the accelerations that they were planned for.

        What the ground pushes is decided here, and `forces` not asked for.
        """
        s, m = self._workspace, mechanics
        left, right = reference["stands"][0].tolist()
        solver = s.solvers.get((left, right))
        if solver is None:
            solver = s.solvers[left, right] = s.solver(left, right)
        state = BalanceState(m.position, m.velocity, m.sole_jacobian, m.motion)
        s.plan_motion(s.robot, state, reference, s.tasks.error, s.plan)
        m.forces(s.plan.acceleration, s.plan.forces)
        s.assemble(s.robot, state, reference, s.plan, s.tasks, solver.program)
        solution, status, about = solver.solve()
        s.command.status = status
        if status >= 1:
            s.torques(
                s.robot.motors, m.velocity, s.plan.forces, s.tasks.wrenches, solution,
                s.command.torque,
            )  # fmt: skip
            s.command.acceleration[:] = s.plan.acceleration
            s.solution, s.multipliers = solution, about["lam"]
        return s.command, memory

    def answer(self) -> BalanceAnswer:
        """The last program that was solved; zeros before the first."""
        s = self._workspace
        return BalanceAnswer(
            needed=s.plan.needed.copy(),
            given=s.plan.totals[:, : len(s.solution)] @ s.solution,
            wrenches=s.solution.reshape(-1, WRENCH) * wrench_units(s.robot.ground[0]),
            multipliers=np.array(s.multipliers),
        )

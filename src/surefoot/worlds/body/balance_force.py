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
from surefoot.robot.own_units import OwnUnits
from surefoot.worlds.body.balance_motion import (
    BALANCE,
    STIFFNESSES,
    given_wrenches,
    knee_row,
    leg_dofs,
    needed_wrench,
    nominal_balance,
    plan_motion,
)
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand
from surefoot.worlds.body.mechanics import MOTION, Mechanics
from surefoot.worlds.body.program import Program, believed_ground, motor_limits, squares
from surefoot.worlds.body.tasks import (
    FREE,
    GROUND,
    JOINTS,
    WRENCH,
    WRENCH_ROWS,
    com_rows,
    filled,
    ground_rows,
    usual_stiffnesses,
    wrench_columns,
    zmp_rows,
)

WEIGHTS = np.dtype(
    [
        ("zmp", "f8"),
        ("com", "f8"),
        ("height", "f8"),
        ("moment", "f8"),
        ("moment_yaw", "f8"),
        ("wrench", "f8"),
    ]
)
"""On squared errors: of the ZMP [m^-2], of the CoM's acceleration and its height's [(m/s^2)^-2], of
the moment about the CoM, to the sides and about the vertical [(N m)^-2]; and on the squared
wrench, in parts of the weight [-]."""

_OWN_WEIGHTS = {
    "zmp": ("m", 1.0e4),
    "com": ("m/s^2", 1.0e3),
    "height": ("m/s^2", 1.0e3),
    "moment": ("N m/rad", 1.0e4),
    "moment_yaw": ("N m/rad", 200.0),
    "wrench": ("-", 1.0e-4),
}
"""Of errors in `OwnUnits`: accelerations in g, moments in m g h, the ZMP in heights of the CoM."""

_OWN_TRUNK = 4.88
"""Stiffness of the trunk in omega^2, 0.4 of that in `inverse_dynamics`: if it is to turn faster
than the ground lets it, the torques of the legs are those of another motion."""

MAX_TASK_ROWS = 6


@njit
def _task_rows(w, g, ref, m, needed, totals, rows, right):
    """Write the rows of the ground's tasks; how many there are."""
    n = totals.shape[1]
    r, count = 0, ref.stands[0] + ref.stands[1]
    rows[:, :n] = 0.0
    if count == 2:
        r = com_rows(w, g, ref, m.sole_axes, 0, rows, right, r)
    else:
        side = 0 if ref.stands[0] == 1 else 1
        place, axes = m.sole_position[side], m.sole_axes[side]
        r = zmp_rows(w, g, ref, place, axes, 0, rows, right, r)
    for i in range(3):
        root = math.sqrt(w.moment if i < 2 else w.moment_yaw)
        for c in range(n):
            rows[r, c] = root * totals[3 + i, c]
        right[r] = root * needed[3 + i]
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
def assemble(
    weights, balance, ground, joints, legs, reference, forces, position, velocity, jacobians,
    motion, knees, wrenches, totals, needed, rows, right, hessian, slope, matrix, low, high,
):  # fmt: skip
    """Write the quadratic program of one cycle.

    Its arrays have the robot's length, which no record holds, and MuJoCo's are read where they lie.

    Args:
        weights, balance, ground, reference: arrays of one record.
        joints, legs, position, velocity, jacobians, motion, knees: as in `plan_motion`.
        forces: M a + h of the planned accelerations.
        wrenches: J' of the unit wrenches of the soles that carry, written, shape (12, nv).
        totals, needed: what these give and the body needs about the CoM, written.
        rows, right: scratch.
        hessian, slope, matrix, low, high: of the program, written.
    """
    w, b, g, ref, m = weights[0], balance[0], ground[0], reference[0], motion[0]
    needed_wrench(b, m, position, forces, needed)
    n = given_wrenches(g, ref, m, totals)
    count = _task_rows(w, g, ref, m, needed, totals[:, :n], rows, right)
    squares(rows, right, count, n, hessian, slope)
    for i in range(n):
        hessian[i, i] += w.wrench
        low[i], high[i] = -FREE, FREE
    matrix[:] = 0.0
    weight, r, first = g.mass * g.gravity, 0, 0
    for side in range(2):
        if ref.stands[side] == 1:
            wrench_columns(g, m.sole_axes[side], jacobians[side], wrenches, first)
            first += WRENCH
    for side in range(2):
        roll = b.rolls[side]
        if ref.stands[side] == 1 and roll >= 0:
            for c in range(n):
                matrix[r, c] = wrenches[c, roll] / weight
            low[n + r] = high[n + r] = forces[roll] / weight
            r += 1
    for j in range(joints.shape[0]):
        dof = joints[j].dof
        if _carries(ref, legs, dof):
            least, most = torque_range(joints[j].torque, velocity[dof], joints[j].speed)
            for c in range(n):
                matrix[r, c] = -wrenches[c, dof] / weight
            low[n + r], high[n + r] = (least - forces[dof]) / weight, (most - forces[dof]) / weight
            r += 1
    for side in range(2):
        if ref.stands[side] == 1:
            knee = knees[side]
            rest = knee_row(b, g, m, knee, position, needed, totals, matrix[r])
            matrix[r] /= g.gravity
            low[n + r], high[n + r] = (knee[7] - rest) / g.gravity, (knee[8] - rest) / g.gravity
            r += 1
    ground_rows(g, ref.stands[0] + ref.stands[1], 0, n, matrix, low, high, r)


@njit
def joint_torques(joints, velocity, forces, wrenches, solution, torque):
    """Write tau_d - J' f, within what the motors can give."""
    for j in range(joints.shape[0]):
        dof = joints[j].dof
        total = forces[dof]
        for c in range(solution.shape[0]):
            total -= wrenches[c, dof] * solution[c]
        least, most = torque_range(joints[j].torque, velocity[dof], joints[j].speed)
        torque[j] = min(max(total, least), most)


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None], Callable[..., None]]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    table = numba.int64[:, ::1]
    return (
        entry_point(
            plan_motion, STIFFNESSES, BALANCE, GROUND, JOINTS, table, BODY_REFERENCE, vector,
            vector, cube, MOTION, matrix, vector,
        ),
        entry_point(
            assemble, WEIGHTS, BALANCE, GROUND, JOINTS, table, BODY_REFERENCE, vector, vector,
            vector, cube, MOTION, matrix, matrix, matrix, vector, matrix, vector,
            matrix, vector, matrix, vector, vector,
        ),
        entry_point(joint_torques, JOINTS, vector, vector, matrix, vector, vector),
    )  # fmt: skip


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


@dataclass(frozen=True)
class BalanceForce:
    """Torques that carry out a reference through the forces of the ground, see this module.

    Weights are on squared errors: the larger the weight, the less the task yields.

    Args:
        multibody: the mechanism.
        friction: coefficient that is relied upon; a pyramid [-].
        sole_part: fraction of the sole in which the ZMP is kept [-].
        max_force: largest vertical force on one sole, in weights [-].
        knee_guard: least bend of the knees, so that legs never lock [rad].
        weights, stiffnesses: changes of single values of `WEIGHTS`, and of `STIFFNESSES` in
            `balance_motion`, by name.

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
        multibody, own = self.multibody, OwnUnits.of(self.multibody.robot)
        nv, motors = multibody.model.nv, len(multibody.motors)
        weights = {name: value / own.one(unit) ** 2 for name, (unit, value) in _OWN_WEIGHTS.items()}
        usual = usual_stiffnesses(multibody.robot)
        stiffness = {name: usual[name] for name in STIFFNESSES.names or ()}
        stiffness["trunk"] = _OWN_TRUNK * own.one("1/s^2")
        plan, make_program, torques = _compiled()
        workspace = {
            "weights": filled(WEIGHTS, weights, self.weights),
            "stiffness": filled(STIFFNESSES, stiffness, self.stiffnesses),
            "balance": nominal_balance(multibody),
            "ground": believed_ground(multibody, self.friction, self.sole_part, self.max_force),
            "joints": motor_limits(multibody, self.knee_guard),
            "legs": leg_dofs(multibody),
            "knees": np.zeros((2, 9)),
            "acceleration": np.zeros(nv),
            "forces": np.zeros(nv),
            "wrenches": np.zeros((2 * WRENCH, nv)),
            "totals": np.zeros((6, 2 * WRENCH)),
            "needed": np.zeros(6),
            "rows": np.zeros((MAX_TASK_ROWS, 2 * WRENCH)),
            "right": np.zeros(MAX_TASK_ROWS),
            "make": optional_module("daqp", "balance force control", "mujoco").Model,
            "programs": {},
            "command": JointCommand(motors, nv),
            "plan": plan,
            "assemble": make_program,
            "torques": torques,
        }
        object.__setattr__(self, "_workspace", workspace)

    def start(self) -> None:
        """It remembers nothing that its answer depends on."""

    def joints(
        self,
        mechanics: Mechanics,
        reference: NDArray[np.void],
        forces: NDArray[np.float64],
        memory: None = None,
    ) -> tuple[JointCommand, None]:
        """The torques for one cycle, and the accelerations that they were planned for.

        What the ground pushes is decided here, and `forces` not asked for.
        """
        s, m = self._workspace, mechanics
        stands = tuple(reference["stands"][0].tolist())
        program = s["programs"].get(stands)
        if program is None:
            program = s["programs"][stands] = self._program(*stands)
        s["plan"](
            s["stiffness"], s["balance"], s["ground"], s["joints"], s["legs"], reference,
            m.position, m.velocity, m.sole_jacobian, m.motion, s["knees"], s["acceleration"],
        )  # fmt: skip
        m.forces(s["acceleration"], s["forces"])
        s["assemble"](
            s["weights"], s["balance"], s["ground"], s["joints"], s["legs"], reference,
            s["forces"], m.position, m.velocity, m.sole_jacobian, m.motion, s["knees"],
            s["wrenches"], s["totals"], s["needed"], s["rows"], s["right"],
            program.hessian, program.slope, program.matrix, program.low, program.high,
        )  # fmt: skip
        solution, status, about = program.solve(s["make"])
        command: JointCommand = s["command"]
        command.status = status
        if status >= 1:
            s["torques"](
                s["joints"], m.velocity, s["forces"], s["wrenches"], solution, command.torque
            )
            command.acceleration[:] = s["acceleration"]
            s["solution"], s["about"] = solution, about
        return command, None

    def _program(self, left: int, right: int) -> Program:
        """The arrays for the soles that carry."""
        s, count = self._workspace, left + right
        carry = [side for side, stands in enumerate((left, right)) if stands]
        rolls = sum(int(s["balance"]["rolls"][0, side] >= 0) for side in carry)
        yielding = sum(int((s["legs"][side] >= 0).sum()) for side in carry) + count
        n, first = WRENCH * count, WRENCH * count + rolls
        return Program(
            n, rolls + yielding + WRENCH_ROWS * count, rolls, np.arange(first, first + yielding)
        )

    def fresh(self) -> Self:
        """The same with a solver that remembers nothing."""
        return replace(self)

    def answer(self) -> BalanceAnswer:
        """The last program that was solved; zeros before the first."""
        s, ground = self._workspace, self._workspace["ground"]
        solution = s.get("solution", np.zeros(0))
        weight = float(ground["mass"][0] * ground["gravity"][0])
        units = weight * np.array([1.0] * 3 + [float(ground["arm"][0])] * 3)
        return BalanceAnswer(
            needed=s["needed"].copy(),
            given=s["totals"][:, : len(solution)] @ solution,
            wrenches=solution.reshape(-1, WRENCH) * units,
            multipliers=np.array(s["about"]["lam"] if "about" in s else []),
        )

r"""Joint positions for servos: the CoM Jacobian resolved with an embedded ZMP and CoM controller.

After [Choi2007]. The velocity that is asked of the CoM feeds both errors back,

    u = \dot c_d - k_p (p_d - p) + k_c (c_d - c),    0 < k_p < omega < k_c,

with the CoM c and the measured ZMP p. It yields to a force that is felt under the soles, which is
what a stiff robot lacks. `resolved_velocity` finds joint velocities that move the CoM by u with the
motion of feet and trunk embedded; they are added up to the positions that `servos` are sent. So an
error that is measured moves the servos on until it is gone.

The desired CoM is a pendulum under the acceleration of the reference, which the controller of the
DCM decides anew in every cycle, from what it measures:

    \ddot c_d = \omega^2 (c - p_d) + k_f (\dot c - \dot c_d),   and c_d is moved on by
    \dot c_d + k_f (c - c_d).

Alone it would drift away, so it follows the estimated CoM at the rate k_f. That is our choice: in
[Choi2007] c_d is planned in advance. Upwards there is no ZMP to yield to: c_d goes to the height of
the reference as fast as `HEIGHT_RATE` and is followed at k_c.

The ZMP error is smoothed, and so is what is decided: a servo would follow every jump of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple, Self

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import entry_point, njit
from surefoot.errors import ParameterError
from surefoot.record import Record, Vector2, Vector3, copy_array, new_array
from surefoot.record import field as value
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.multibody import Multibody
from surefoot.robot.own_units import OwnUnits
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand
from surefoot.worlds.body.mechanics import MOTION, Mechanics
from surefoot.worlds.body.resolved_velocity import LEG, ROWS, find_leg_joints, resolve
from surefoot.worlds.body.servos import (
    EXPECT,
    MOVING,
    POSTURE,
    SENT,
    SERVO,
    find_servos,
    move_servos,
    servo_torques,
    torques_at_rest,
    zmp_error,
)

BASE = 6
"""Degrees of freedom of the base."""

MAX_ERROR = 0.2
"""Of the ZMP, in heights of the CoM: a larger one is of a touchdown, and answered as this one."""

HEIGHT_RATE, MAX_LIFT = 1.8, 0.8
"""At which the desired height goes to that of the reference, in omega, and how it is accelerated at
most, in g."""

SHIFT_RATE = 30.0
"""At which a servo takes the load of its leg into account after a touchdown, in omega."""

MAX_ACCELERATION = 40.0
"""Of a joint that the estimator is given to expect, in omega^2."""

_OWN = MappingProxyType(
    {
        "stiffness": ("N m/rad", 30.0),
        "zmp_rate": ("1/s", 0.65),
        "com_rate": ("1/s", 1.3),
        "follow_rate": ("1/s", 11.0),
        "smoothing": ("1/s", 32.0),
        "trunk_rate": ("1/s", 0.4),
        "swing_rate": ("1/s", 1.35),
        "level_rate": ("1/s", 3.5),
    }
)
"""Units of the parameters that follow from the robot, and their defaults in `OwnUnits`."""


class Law(Record):
    """What errors are answered with."""

    zmp: float = value("1/s", "k_p")
    com: float = value("1/s", "k_c")
    follow: float = value("1/s", "k_f")
    smoothing: float = value("1/s", "of the ZMP error")
    max_error: float = value("m", "largest ZMP error that is answered")
    height: float = value("1/s", "of the desired height towards that of the reference")
    max_lift: float = value("m/s^2", "largest vertical acceleration")
    shift: float = value("1/s", "of the loads that the servos take into account")
    max_acceleration: float = value("rad/s^2", "largest of a joint that is expected")
    weight: float = value("N", "of the robot")
    period: float = value("s", "of control")


class Desired(Record):
    """What evolves beside the servos."""

    com: Vector3 = value("m", "c_d")
    com_velocity: Vector3 = value("m/s", "likewise")
    zmp_error: Vector2 = value("m", "p_d - p as measured last")
    smoothed: Vector2 = value("m", "likewise, smoothed")
    shares: Vector2 = value("-", "of the weight on both soles that the servos account for")
    velocity: Vector3 = value("m/s", "u, of the CoM, that was asked for last")


LAW, DESIRED = Law.DTYPE, Desired.DTYPE
"""The same for kernels, which know no classes."""


class ServoMemory(NamedTuple):
    """What a `ComJacobian` remembers; a value.

    Attributes:
        sent: of the servos, shape (4, n), see `servos.POSTURE`.
        desired: a `Desired` record, shape (1,).
    """

    sent: NDArray[np.float64]
    desired: NDArray[np.void]


@njit
def com_velocity(law, reference, com, velocity, desired):
    """Write u, and move the desired CoM on by one period.

    Args:
        law: a `Law` record.
        reference: a `BODY_REFERENCE` record.
        com, velocity: of the CoM, estimated [m, m/s].
        desired: a `Desired` record whose ZMP error is of now; changed.
    """
    share, dt = min(law.smoothing * law.period, 1.0), law.period
    for i in range(2):
        error = min(max(desired.zmp_error[i], -law.max_error), law.max_error)
        desired.smoothed[i] += share * (error - desired.smoothed[i])
        speed = desired.com_velocity[i]
        follow = law.follow * (velocity[i] - speed)
        desired.com_velocity[i] = speed + dt * (reference.com_acceleration[i] + follow)
        follow = law.follow * (com[i] - desired.com[i])
        desired.com[i] += dt * (desired.com_velocity[i] + follow)
        back = law.com * (desired.com[i] - com[i])
        desired.velocity[i] = desired.com_velocity[i] - law.zmp * desired.smoothed[i] + back
    k = law.height
    lift = k * k * (reference.com[2] - desired.com[2]) - 2.0 * k * desired.com_velocity[2]
    desired.com_velocity[2] += dt * min(max(lift, -law.max_lift), law.max_lift)
    desired.com[2] += dt * desired.com_velocity[2]
    desired.velocity[2] = desired.com_velocity[2] + law.com * (desired.com[2] - com[2])


@njit
def _cycle(
    law, rows, legs, servos, passive, base, reference, motion, position, velocity, jacobians,
    com_jacobian, bias, forces, hessian, torque, solution, desired, sent,
):  # fmt: skip
    """Measure the ZMP, decide u, resolve it, and move the servos; NaN in `solution` if it fails.

    Its arrays have the robot's length, which no record holds, and MuJoCo's are read where they lie;
    `hessian`, `torque` and `solution` are scratch, `desired` and `sent` are changed.
    """
    k, ref, m, d = law[0], reference[0], motion[0], desired[0]
    servo_torques(servos, sent, position, velocity, torque)
    zmp_error(k.weight, legs, forces, m, jacobians, torque, ref.zmp, d.zmp_error)
    com_velocity(k, ref, m.com, m.com_velocity, d)
    if not resolve(
        rows[0], legs, passive, base, ref, m, position, velocity, jacobians, com_jacobian,
        d.velocity, hessian, torque, solution,
    ):  # fmt: skip
        solution[:] = math.nan
        return
    share, total = min(k.shift * k.period, 1.0), ref.stands[0] + ref.stands[1]
    for side in range(2):
        d.shares[side] += share * (ref.stands[side] / total - d.shares[side])
    rolls = passive.shape[0] > 0
    torques_at_rest(k.weight, rolls, d.shares, ref, m, bias, jacobians, torque)
    move_servos(k.period, k.max_acceleration, servos, position, solution, torque, sent)


@cache
def _compiled() -> Callable[..., None]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    return entry_point(
        _cycle, LAW, ROWS, LEG, SERVO, np.dtype(np.int64), numba.int64, BODY_REFERENCE, MOTION,
        vector, vector, cube, matrix, vector, vector, matrix, vector, vector, DESIRED, matrix,
    )  # fmt: skip


@dataclass(frozen=True)
class ComJacobian:
    """Servo positions that carry out a reference, with ZMP and CoM fed back.

    What is None follows from the robot, see `OwnUnits`.

    Args:
        multibody: the mechanism.
        stiffness: of every servo; 30 m g h [N m/rad].
        damping_ratio: likewise, with the inertia that its joint has in the nominal pose [-].
        zmp_rate: k_p, at which a ZMP error moves the CoM, below omega; 0.65 omega [1/s].
        com_rate: k_c, likewise an error of the CoM, above omega; 1.3 omega [1/s].
        follow_rate: k_f, of the desired CoM towards the estimated one; 11 omega [1/s].
        smoothing: of the ZMP error; 32 omega [1/s].
        trunk_rate: of the trunk's lean and heading; 0.4 omega [1/s].
        swing_rate: of the swinging sole's place and lean; 1.35 omega [1/s].
        level_rate: of the lean of a sole that carries; 3.5 omega [1/s].
        knee_guard: least bend of the knees [rad].
        period: of control [s].

    Raises:
        ParameterError: a value is out of range, or the rates are not those of [Choi2007].
        RobotError: a leg has no knee, or its foot does not pitch and roll.
    """

    multibody: Multibody
    stiffness: float | None = None
    damping_ratio: float = 0.7
    zmp_rate: float | None = None
    com_rate: float | None = None
    follow_rate: float | None = None
    smoothing: float | None = None
    trunk_rate: float | None = None
    swing_rate: float | None = None
    level_rate: float | None = None
    knee_guard: float = 0.03
    period: float = TIME_STEP
    _workspace: dict[str, Any] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name, unit in (("damping_ratio", "-"), ("knee_guard", "rad"), ("period", "s")):
            check_number(name, getattr(self, name), 0.0, unit, above=name == "period")
        multibody, own = self.multibody, OwnUnits.of(self.multibody.robot)
        values = own.fill(self, _OWN)
        check_number("stiffness", values["stiffness"], 0.0, "N m/rad", above=True)
        _check_rates(values["zmp_rate"], values["com_rate"], own.rate)
        nv, legs = multibody.model.nv, find_leg_joints(multibody)
        knees = tuple((legs["straight"] + legs["sign"] * self.knee_guard).tolist())
        servos = find_servos(
            multibody, values["stiffness"], self.damping_ratio, knees, self.period
        )  # fmt: skip
        command = JointCommand(len(servos), nv)
        command.stiffness[:], command.damping[:] = servos["stiffness"], servos["damping"]
        passive = multibody.passive_dofs[BASE:].astype(np.int64)
        rows = new_array(ROWS)
        rows["height"], rows["rolls"] = own.length, len(passive) > 0
        for name in ("trunk", "swing", "level"):
            rows[name] = values[f"{name}_rate"]
        law = self._law(own, values)
        workspace = {
            "cycle": _compiled(),
            "fixed": (law, rows, legs, servos, passive, multibody.base_dof),
            "scratch": (np.zeros((nv, nv)), np.zeros(nv), np.zeros(nv)),
            "com_jacobian": np.zeros((3, nv)),
            "command": command,
        }
        object.__setattr__(self, "_workspace", workspace)

    def _law(self, own: OwnUnits, values: dict[str, float]) -> NDArray[np.void]:
        law = new_array(LAW)
        for name in ("zmp", "com", "follow"):
            law[name] = values[f"{name}_rate"]
        law["smoothing"], law["period"] = values["smoothing"], self.period
        law["max_error"] = MAX_ERROR * own.length
        law["height"], law["max_lift"] = HEIGHT_RATE * own.rate, MAX_LIFT * own.acceleration
        law["shift"] = SHIFT_RATE * own.rate
        law["max_acceleration"] = MAX_ACCELERATION * own.rate**2
        law["weight"] = self.multibody.mass * self.multibody.robot.gravity
        return law

    def fresh(self) -> Self:
        """The same with room of its own to work in."""
        return replace(self)

    def start(self) -> None:
        """Nothing: the servos begin where the joints are."""

    def joints(
        self,
        mechanics: Mechanics,
        reference: NDArray[np.void],
        forces: NDArray[np.float64],
        memory: ServoMemory | None,
    ) -> tuple[JointCommand, ServoMemory]:
        """Positions and velocities of the servos, one period on; they rest if there are none."""
        s, m = self._workspace, mechanics
        if memory is None:
            memory = self._begin(m)
        sent, desired = memory.sent.copy(), copy_array(memory.desired)
        m.com_jacobian(s["com_jacobian"])
        s["cycle"](
            *s["fixed"], reference, m.motion, m.position, m.velocity, m.sole_jacobian,
            s["com_jacobian"], m.bias, forces, *s["scratch"], desired, sent,
        )  # fmt: skip
        command: JointCommand = s["command"]
        command.status = int(np.isfinite(s["scratch"][-1][0]))
        if not command.status:
            sent, desired = memory.sent.copy(), memory.desired
            sent[MOVING:] = 0.0
        command.position[:], command.velocity[:] = sent[SENT], sent[MOVING]
        command.acceleration[self.multibody.motor_dofs] = sent[EXPECT]
        return command, ServoMemory(sent, desired)

    def _begin(self, mechanics: Mechanics) -> ServoMemory:
        sent, desired = np.zeros((4, len(self.multibody.motors))), new_array(DESIRED)
        sent[[POSTURE, SENT]] = mechanics.position[self.multibody.motor_positions]
        desired["com"], desired["com_velocity"] = mechanics.com, mechanics.com_velocity
        desired["shares"] = 0.5
        return ServoMemory(sent, desired)


def _check_rates(zmp: float, com: float, omega: float) -> None:
    if not (0.0 < zmp < omega < com):
        raise ParameterError(
            f"0 < zmp_rate < omega < com_rate, omega = {omega:.4g} 1/s",
            f"zmp_rate {zmp:.4g} and com_rate {com:.4g} 1/s",
            "choose one below and one above omega: else the errors of ZMP and CoM may grow",
        )

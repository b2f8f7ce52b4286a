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
from typing import Self

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.control.fields import check_fields, described, documented, fill_shares, setting
from surefoot.errors import ParameterError
from surefoot.record import Record, Vector2, Vector3, copy_array, new_array
from surefoot.record import field as value
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.multibody import Multibody
from surefoot.robot.own_units import OwnUnits
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand, JointMemory
from surefoot.worlds.body.mechanics import MOTION, Mechanics
from surefoot.worlds.body.resolved_velocity import (
    LEG,
    ROWS,
    Rows,
    find_leg_joints,
    resolve,
)
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


class _Workspace:
    """What a mapping computes with; nothing of it is remembered."""

    def __init__(self, mapping: ComJacobian) -> None:
        multibody, legs = mapping.multibody, find_leg_joints(mapping.multibody)
        nv, passive = multibody.model.nv, multibody.passive_dofs[BASE:].astype(np.int64)
        knees = tuple((legs["straight"] + legs["sign"] * mapping.knee_guard).tolist())
        self.cycle = _compiled()
        self.servos = find_servos(
            multibody, mapping.stiffness, mapping.damping_ratio, knees, mapping.period
        )
        rows = Rows(
            trunk=mapping.trunk_rate,
            swing=mapping.swing_rate,
            level=mapping.level_rate,
            knee=mapping.com_rate,
            guard=mapping.knee_guard,
            height=multibody.robot.com_height,
            rolls=len(passive) > 0,
        ).array
        self.fixed = (_law(mapping), rows, legs, self.servos, passive, multibody.base_dof)
        self.solution, self.com_jacobian = np.zeros(nv), np.zeros((3, nv))
        self.scratch = (np.zeros((nv, nv)), np.zeros(nv), self.solution)
        self.command = JointCommand(len(self.servos), nv)
        self.command.stiffness[:] = self.servos["stiffness"]
        self.command.damping[:] = self.servos["damping"]


def _law(mapping: ComJacobian) -> NDArray[np.void]:
    multibody, own = mapping.multibody, OwnUnits.of(mapping.multibody.robot)
    return Law(
        zmp=mapping.zmp_rate,
        com=mapping.com_rate,
        follow=mapping.follow_rate,
        smoothing=mapping.smoothing,
        max_error=MAX_ERROR * own.length,
        height=HEIGHT_RATE * own.rate,
        max_lift=MAX_LIFT * own.acceleration,
        shift=SHIFT_RATE * own.rate,
        max_acceleration=MAX_ACCELERATION * own.rate**2,
        weight=multibody.mass * multibody.robot.gravity,
        period=mapping.period,
    ).array


def _check_rates(mapping: ComJacobian) -> None:
    omega, zmp, com = mapping.multibody.robot.omega, mapping.zmp_rate, mapping.com_rate
    if not (0.0 < zmp < omega < com):
        raise ParameterError(
            f"0 < zmp_rate < omega < com_rate, omega = {omega:.4g} 1/s",
            f"zmp_rate {zmp:.4g} and com_rate {com:.4g} 1/s",
            "choose one below and one above omega: else the errors of ZMP and CoM may grow",
        )


@documented
@dataclass(frozen=True)
class ComJacobian:
    """Servo positions that carry out a reference, with ZMP and CoM fed back.

    Raises:
        ParameterError: a value is out of range, or the rates are not those of [Choi2007].
        RobotError: a leg has no knee, or its foot does not pitch and roll.
    """

    multibody: Multibody = field(metadata=described("the mechanism"))
    stiffness: float = setting(None, "N m/rad", "of every servo", share=30.0, above=0.0)
    damping_ratio: float = setting(
        0.7, "-", "likewise, with the inertia that its joint has in the nominal pose", least=0.0
    )
    zmp_rate: float = setting(
        None, "1/s", "k_p, at which a ZMP error moves the CoM, below omega", share=0.65
    )
    com_rate: float = setting(None, "1/s", "k_c, likewise of the CoM, above omega", share=1.3)
    follow_rate: float = setting(
        None, "1/s", "k_f, of the desired CoM towards the estimated one", share=11.0
    )
    smoothing: float = setting(None, "1/s", "of the ZMP error", share=32.0)
    trunk_rate: float = setting(None, "1/s", "of the trunk's lean and heading", share=0.4)
    swing_rate: float = setting(None, "1/s", "of the swinging sole's place and lean", share=1.35)
    level_rate: float = setting(None, "1/s", "of the lean of a sole that carries", share=3.5)
    knee_guard: float = setting(0.03, "rad", "least bend of the knees", least=0.0)
    period: float = setting(TIME_STEP, "s", "of control", above=0.0)
    _workspace: _Workspace = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        fill_shares(self, self.multibody.robot)
        check_fields(self)
        _check_rates(self)
        object.__setattr__(self, "_workspace", _Workspace(self))

    @property
    def servos(self) -> NDArray[np.void]:
        """Ranges, limits and gains of the servos, a copy of `Servo` records, shape (n,)."""
        return self._workspace.servos.copy()

    def fresh(self) -> Self:
        """The same with room of its own to work in."""
        return replace(self)

    def start(self) -> JointMemory:
        """Nothing: the servos begin where the joints are.

        After the first cycle it is `sent`, of the servos, shape (4, n), see `servos.POSTURE`, and
        `desired`, a `Desired` as an array, shape (1,).
        """
        return {}

    def joints(
        self,
        mechanics: Mechanics,
        reference: NDArray[np.void],
        forces: NDArray[np.float64],
        memory: JointMemory,
    ) -> tuple[JointCommand, JointMemory]:
        """Positions and velocities of the servos, one period on; they rest if there are none."""
        s, m = self._workspace, mechanics
        before = memory or self._begin(m)
        sent, desired = before["sent"].copy(), copy_array(before["desired"])
        m.com_jacobian(s.com_jacobian)
        s.cycle(
            *s.fixed, reference, m.motion, m.position, m.velocity, m.sole_jacobian,
            s.com_jacobian, m.bias, forces, *s.scratch, desired, sent,
        )  # fmt: skip
        command = s.command
        command.status = int(np.isfinite(s.solution[0]))
        if not command.status:
            sent, desired = before["sent"].copy(), before["desired"]
            sent[MOVING:] = 0.0
        command.position[:], command.velocity[:] = sent[SENT], sent[MOVING]
        command.acceleration[self.multibody.motor_dofs] = sent[EXPECT]
        return command, {"sent": sent, "desired": desired}

    def _begin(self, mechanics: Mechanics) -> JointMemory:
        sent, desired = np.zeros((4, len(self.multibody.motors))), new_array(DESIRED)
        sent[[POSTURE, SENT]] = mechanics.position[self.multibody.motor_positions]
        desired["com"], desired["com_velocity"] = mechanics.com, mechanics.com_velocity
        desired["shares"] = 0.5
        return {"sent": sent, "desired": desired}

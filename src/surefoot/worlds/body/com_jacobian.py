r"""Joint positions for servos: the CoM Jacobian resolved with an embedded ZMP and CoM controller.

After [Choi2007]. The velocity of the CoM that is asked of the joints feeds both errors back,

    u = \dot c_d - k_p (p_d - p) + k_c (c_d - c),    0 < k_p < omega < k_c,

with the CoM c and the measured ZMP p. It yields to a force that is felt under the soles, which is
what a stiff robot lacks. The joints move the CoM by u, and with the same breath what is embedded:
soles that carry rest, the swinging one and the trunk follow their references. All are rows of one
least-squares problem for the generalised velocity,

    J_c v = u,   J_s v = 0,   J_f v = \dot x_f + k_f (x_f - x),   R_b v = k_t e(R_b),

and the motors' part of it is added up to the positions of the servos. So an error that is measured
moves a servo on until it is gone, whatever the servo yields to its load. Where [Choi2007] solves
for the leg that carries first, all rows are solved at once here, which is the same as long as they
can be met.

Near a straight knee they cannot: the height hardly depends on the knee any more. As in
[Faraji2017] the straight knee is not avoided, but the vertical task yields. The knee's velocity is
weighted against the height, more so the straighter the knee is (`YIELDING`), so what is lost is
height and never the feet or the horizontal CoM; far from it nothing is weighted, and all rows are
met. That source solves for positions; the weights are our choice.

The CoM that is desired is a pendulum under the reference's acceleration, which the controller of
the DCM decides anew in every cycle from what it measures. Alone it would drift off, so it follows
the estimated CoM at the rate `follow`; that is our choice too.

The ZMP is measured as a robot with position servos can: the load on each sole, and the torques of
its ankles, which follow from how far the servos are off what they were sent:

    tau = K (q_sent - q) + D (\dot q_sent - \dot q),   a . ((p - a_0) x f) = -tau,

for each axis a of an ankle through a_0, with the force f on its sole, whose line passes through the
CoM. An ankle that rolls passively pushes nowhere sideways, so the CoM falls there as a pendulum
does, the measured roll is embedded, and the row of the CoM across is left out.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple, Self

import mujoco
import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import entry_point, njit
from surefoot.errors import ParameterError
from surefoot.record import Record, Vector2, Vector3, copy_array, new_array
from surefoot.record import field as one
from surefoot.robot.floor import TIME_STEP
from surefoot.robot.legs import find_knees
from surefoot.robot.multibody import Multibody
from surefoot.robot.own_units import OwnUnits
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand
from surefoot.worlds.body.mechanics import MOTION, Mechanics
from surefoot.worlds.body.resolved_velocity import LEG, RATES, find_leg_joints, resolve

TOUCHING, CARRIED = 0.03, 0.2
"""Parts of the weight: a sole with less does not count for the ZMP, and with less on both there is
none."""

LARGEST = 0.08
"""Error of the ZMP that is answered, in heights of the CoM: at a touchdown it is half a step."""

MOST_DAMPED = 0.6
"""Of a servo's damping, over what would stop its joint within one period: a sampled one that damps
more is unstable."""

LARGEST_ACCELERATION = 40.0
"""Of a joint, that the estimator is told to expect, in omega^2."""

EXPECTED = 0.5
"""Share of the newest in the average of the joints' accelerations."""

_OWN = MappingProxyType(
    {
        "stiffness": ("N m/rad", 40.0),
        "zmp_rate": ("1/s", 0.6),
        "com_rate": ("1/s", 1.5),
        "follow": ("1/s", 3.0),
        "smoothing": ("1/s", 60.0),
        "trunk_rate": ("1/s", 5.0),
        "swing_rate": ("1/s", 10.0),
        "level_rate": ("1/s", 10.0),
    }
)
"""Units of the parameters that follow from the robot, and their defaults in `OwnUnits`."""


class Servo(Record):
    """A joint with a motor that is held by a servo."""

    dof: int = one("", "its degree of freedom")
    position: int = one("", "index of its angle")
    low: float = one("rad", "least angle")
    high: float = one("rad", "largest")
    torque: float = one("N m", "limit")
    stiffness: float = one("N m/rad", "of the servo")
    damping: float = one("N m s/rad", "likewise")


class Desired(Record):
    """What evolves beside the servos' positions."""

    com: Vector3 = one("m", "desired")
    com_velocity: Vector3 = one("m/s", "likewise")
    zmp: Vector2 = one("m", "measured, smoothed")
    velocity: Vector3 = one("m/s", "u, of the CoM, that was asked for last")


SERVO, DESIRED = Servo.DTYPE, Desired.DTYPE
"""The same for kernels, which know no classes."""

BASE = 6
"""Degrees of freedom of the base."""

SENT, MOVING, EXPECT = 0, 1, 2
"""Rows of what the servos were sent: positions [rad], velocities [rad/s], and the accelerations
that are expected of them [rad/s^2]."""


class ServoMemory(NamedTuple):
    """What a `ComJacobian` remembers; a value.

    Attributes:
        sent: to the servos in the last cycle, shape (3, n), see `SENT`.
        desired: a `Desired` record, shape (1,).
    """

    sent: NDArray[np.float64]
    desired: NDArray[np.void]


@njit
def servo_torques(servos, sent, position, velocity, torque):
    """Write what the servos must be giving, by joint: they are off what they were sent."""
    torque[:] = 0.0
    for j in range(servos.shape[0]):
        servo = servos[j]
        given = servo.stiffness * (sent[SENT, j] - position[servo.position])
        given += servo.damping * (sent[MOVING, j] - velocity[servo.dof])
        torque[servo.dof] = min(max(given, -servo.torque), servo.torque)


@njit
def centre_of_pressure(leg, load, line, place, jacobian, torque, out):
    """Write where the force on a sole acts, from the torques of its ankle [m].

    Args:
        leg: a `LegJoints` record.
        load: vertical force [N].
        line: direction of the force, its vertical part 1.
        place: centre of the sole [m].
        jacobian: of that, shape (6, nv).
        torque: by degree of freedom [N m].
        out: (x, y), written.
    """
    m, r = np.empty((2, 2)), np.empty(2)
    for k in range(2):
        dof = leg.ankle[k]
        ax, ay, az = jacobian[3, dof], jacobian[4, dof], jacobian[5, dof]
        m[k, 0], m[k, 1] = line[1] * az - ay, ax - line[0] * az
        r[k] = -torque[dof] / load
        for i in range(3):
            r[k] -= line[i] * jacobian[i, dof]
    scale = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    # Of a level sole it is 1 or -1; axes that coincide tell nothing.
    if abs(scale) > 0.1:
        out[0] = place[0] + (r[0] * m[1, 1] - m[0, 1] * r[1]) / scale
        out[1] = place[1] + (m[0, 0] * r[1] - r[0] * m[1, 0]) / scale
    else:
        out[0], out[1] = place[0], place[1]


@njit
def measure_zmp(rates, legs, forces, motion, jacobians, torque, desired):
    """Take the force on both soles into the measured ZMP, if they carry the robot."""
    point, line, total, x, y = np.empty(2), np.ones(3), 0.0, 0.0, 0.0
    for side in range(2):
        load, place = forces[side], motion.sole_position[side]
        if not load > TOUCHING * rates.weight:
            continue
        for i in range(2):
            line[i] = (motion.com[i] - desired.zmp[i]) / max(motion.com[2] - place[2], 1e-3)
        centre_of_pressure(legs[side], load, line, place, jacobians[side], torque, point)
        total += load
        x += load * point[0]
        y += load * point[1]
    if total > CARRIED * rates.weight:
        share = min(rates.smoothing * rates.period, 1.0)
        desired.zmp[0] += share * (x / total - desired.zmp[0])
        desired.zmp[1] += share * (y / total - desired.zmp[1])


@njit
def com_velocity(rates, reference, com, velocity, desired):
    """Write u, and move the desired CoM on by one period."""
    most = LARGEST * rates.height
    for i in range(3):
        off = reference.com_acceleration[i] + rates.follow * (velocity[i] - desired.com_velocity[i])
        desired.com_velocity[i] += off * rates.period
        speed = desired.com_velocity[i] + rates.follow * (com[i] - desired.com[i])
        desired.com[i] += speed * rates.period
        u = desired.com_velocity[i] + rates.com * (desired.com[i] - com[i])
        if i < 2:
            u -= rates.zmp * min(max(reference.zmp[i] - desired.zmp[i], -most), most)
        desired.velocity[i] = u


@njit
def _move_servos(rates, servos, position, velocity, sent):
    """Move the servos on by one period, no further than their torque and range reach."""
    for j in range(servos.shape[0]):
        servo, speed = servos[j], velocity[servos[j].dof]
        change = (speed - sent[MOVING, j]) / rates.period
        change = min(max(change, -rates.most), rates.most)
        sent[EXPECT, j] += EXPECTED * (change - sent[EXPECT, j])
        angle, room = position[servo.position], servo.torque / servo.stiffness
        place = min(max(sent[SENT, j] + speed * rates.period, angle - room), angle + room)
        sent[SENT, j] = min(max(place, servo.low), servo.high)
        sent[MOVING, j] = speed


@njit
def _cycle(
    rates, legs, servos, passive, base, reference, motion, position, velocity, jacobians,
    com_jacobian, forces, hessian, torque, solution, desired, sent,
):  # fmt: skip
    """Measure the ZMP, decide u, resolve it, and move the servos; they rest if that fails.

    Its arrays have the robot's length, which no record holds, and MuJoCo's are read where they lie;
    `hessian`, `torque` and `solution` are scratch, `desired` and `sent` are changed.
    """
    r, ref, m, d = rates[0], reference[0], motion[0], desired[0]
    servo_torques(servos, sent, position, velocity, torque)
    measure_zmp(r, legs, forces, m, jacobians, torque, d)
    com_velocity(r, ref, m.com, m.com_velocity, d)
    if not resolve(
        r, legs, passive, base, ref, m, position, velocity, jacobians, com_jacobian, d.velocity,
        hessian, torque, solution,
    ):  # fmt: skip
        solution[:] = math.nan
        return
    _move_servos(r, servos, position, solution, sent)


@cache
def _compiled() -> Callable[..., None]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    return entry_point(
        _cycle, RATES, LEG, SERVO, np.dtype(np.int64), numba.int64, BODY_REFERENCE, MOTION, vector,
        vector, cube, matrix, vector, matrix, vector, vector, DESIRED, matrix,
    )  # fmt: skip


@dataclass(frozen=True)
class ComJacobian:
    """Servo positions that carry out a reference, with ZMP and CoM fed back.

    What is None follows from the robot, see `OwnUnits`.

    Args:
        multibody: the mechanism.
        stiffness: of every servo; 40 m g h [N m/rad].
        damping_ratio: likewise, with the inertia that its joint has in the nominal pose [-].
        zmp_rate: k_p, at which a ZMP error moves the CoM, below omega; 0.6 omega [1/s].
        com_rate: k_c, likewise of the CoM, above omega; 1.5 omega [1/s].
        follow: rate at which the desired CoM follows the estimated one; 3 omega [1/s].
        smoothing: of the measured ZMP; 60 omega [1/s].
        trunk_rate: of the trunk's lean and heading; 5 omega [1/s].
        swing_rate: of the swinging sole; 10 omega [1/s].
        level_rate: of the lean of a sole that carries; 10 omega [1/s].
        knee_guard: least bend of the knees [rad].
        period: control period [s].

    Raises:
        ParameterError: a value is out of range, or the rates are not those of [Choi2007].
        RobotError: a leg has no knee, or its ankle does not pitch and roll.
    """

    multibody: Multibody
    stiffness: float | None = None
    damping_ratio: float = 0.8
    zmp_rate: float | None = None
    com_rate: float | None = None
    follow: float | None = None
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
        nv, legs, rates = multibody.model.nv, find_leg_joints(multibody), new_array(RATES)
        for name in ("zmp", "com", "trunk", "swing", "level"):
            rates[name] = values[f"{name}_rate"]
        rates["follow"], rates["smoothing"] = values["follow"], values["smoothing"]
        rates["height"], rates["weight"] = own.length, multibody.mass * multibody.robot.gravity
        rates["period"], rates["most"] = self.period, LARGEST_ACCELERATION * own.rate**2
        rates["rolls"] = len(multibody.passive_dofs) > BASE
        servos = self._servos(legs)
        command = JointCommand(len(servos), nv)
        command.stiffness[:], command.damping[:] = servos["stiffness"], servos["damping"]
        com_jacobian, solution = np.zeros((3, nv)), np.zeros(nv)
        workspace = {
            "cycle": _compiled(),
            "fixed": (
                rates, legs, servos, multibody.passive_dofs[BASE:].astype(np.int64),
                multibody.base_dof,
            ),
            "scratch": (np.zeros((nv, nv)), np.zeros(nv), solution),
            "com_jacobian": com_jacobian,
            "solution": solution,
            "command": command,
        }  # fmt: skip
        object.__setattr__(self, "_workspace", workspace)

    def _servos(self, legs: NDArray[np.void]) -> NDArray[np.void]:
        multibody, model = self.multibody, self.multibody.model
        servos, inertia = np.zeros(len(multibody.motors), SERVO), np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, multibody.data(), inertia)
        own = np.diag(inertia)[multibody.motor_dofs]
        servos["dof"], servos["position"] = multibody.motor_dofs, multibody.motor_positions
        limited = model.jnt_limited[multibody.motors].astype(bool)
        ranges = model.jnt_range[multibody.motors]
        servos["low"] = np.where(limited, ranges[:, 0], -1e9)
        servos["high"] = np.where(limited, ranges[:, 1], 1e9)
        for joint, leg in zip(find_knees(multibody), legs, strict=True):
            least, servo = leg["straight"] + leg["sign"] * self.knee_guard, servos[joint]
            side, tighter = ("low", max) if leg["sign"] > 0.0 else ("high", min)
            servos[side][joint] = tighter(float(servo[side]), float(least))
        servos["torque"] = np.minimum(multibody.torque, 1e9)
        servos["stiffness"] = self.stiffness
        damping = 2.0 * self.damping_ratio * np.sqrt(servos["stiffness"] * own)
        servos["damping"] = np.minimum(damping, MOST_DAMPED * own / self.period)
        return servos

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
            s["com_jacobian"], forces, *s["scratch"], desired, sent,
        )  # fmt: skip
        command: JointCommand = s["command"]
        command.status = int(np.isfinite(s["solution"][0]))
        if not command.status:
            sent, desired = memory.sent.copy(), memory.desired
            sent[MOVING:] = 0.0
        command.position[:], command.velocity[:] = sent[SENT], sent[MOVING]
        command.acceleration[self.multibody.motor_dofs] = sent[EXPECT]
        return command, ServoMemory(sent, desired)

    def _begin(self, mechanics: Mechanics) -> ServoMemory:
        sent, desired = np.zeros((3, len(self.multibody.motors))), new_array(DESIRED)
        sent[SENT] = mechanics.position[self.multibody.motor_positions]
        desired["com"], desired["com_velocity"] = mechanics.com, mechanics.com_velocity
        desired["zmp"] = mechanics.com[:2]
        return ServoMemory(sent, desired)


def _check_rates(zmp: float, com: float, omega: float) -> None:
    if not (0.0 < zmp < omega < com):
        raise ParameterError(
            f"0 < zmp_rate < omega < com_rate, omega = {omega:.4g} 1/s",
            f"zmp_rate {zmp:.4g} and com_rate {com:.4g} 1/s",
            "choose them on either side of omega: both errors vanish only then",
        )

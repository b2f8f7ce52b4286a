"""Inverse kinematics: joint angles and velocities that put body and feet where they are to be.

For playback. One damped least-squares step a cycle ([Buss2004]): the error left is smaller than a
control cycle's motion, so one is enough. What it cannot do: it knows no forces, so friction, torque
limits and the ZMP are kept only as far as the reference's CoM keeps them. Servos that follow it do
not walk in physics without a stabiliser; see docs/body.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from types import MappingProxyType
from typing import Any, Self

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import entry_point, njit
from surefoot.robot.multibody import Multibody
from surefoot.robot.own_units import OwnUnits
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand
from surefoot.worlds.body.mechanics import MOTION, Mechanics
from surefoot.worlds.body.tasks import rotation_error

DAMPING = 1.56e-4
"""Of the least squares: what a joint's velocity costs, where a sole's has 1, in squared heights of
the CoM."""

TURN = 1.25
"""What an error of 1 rad counts, where soles and CoM have 1, in heights of the CoM."""

_OWN = MappingProxyType({"stiffness": ("N m/rad", 3.75), "damping": ("N m s/rad", 0.394)})
"""Units of the servos' parameters, and their defaults in `OwnUnits`."""

TASK_ROWS = 18
"""Two soles of six rows, CoM and trunk of three."""


@njit
def _solve(
    reference, motion, sole_jacobian, com_jacobian, base_dof, targets, weights, gain, period,
    damping, rows, velocity,
):  # fmt: skip
    """Write the generalised velocity that is nearest to all tasks.

    Its arrays have the robot's length, which no record holds, and MuJoCo's are read where they lie.
    """
    ref, m, error, right = reference[0], motion[0], np.empty(3), np.zeros(TASK_ROWS)
    rows[:, :] = 0.0
    nv, r = rows.shape[1], 0
    for side in range(2):
        stands = ref.stands[side] == 1
        for i in range(3):
            goal = targets[side, i] if stands else ref.swing_foot[i]
            right[r + i] = gain * (goal - m.sole_position[side, i])
            if not stands:
                right[r + i] += ref.swing_foot_velocity[i]
        yaw = targets[side, 3] if stands else ref.swing_yaw
        rotation_error(m.sole_axes[side], 0.0, 0.0, yaw, error)
        for i in range(3):
            right[r + 3 + i] = gain * error[i]
        if not stands:
            right[r + 5] += ref.swing_yaw_rate
        for i in range(6):
            for c in range(nv):
                rows[r + i, c] = sole_jacobian[side, i, c]
        r += 6
    for i in range(3):
        right[r + i] = ref.com_velocity[i] + ref.com_acceleration[i] * period
        right[r + i] += gain * (ref.com[i] - m.com[i])
        for c in range(nv):
            rows[r + i, c] = com_jacobian[i, c]
    # The height has no velocity of its own: it follows the CoM's place.
    right[r + 2] = gain * (ref.com[2] - m.com[2])
    r += 3
    rotation_error(m.base_axes, ref.trunk[0], ref.trunk[1], ref.trunk[2], error)
    for i in range(3):
        right[r + i] = gain * error[i]
        for c in range(3):
            rows[r + i, base_dof + 3 + c] = m.base_axes[i, c]
    right[r + 2] += ref.trunk_yaw_rate
    for i in range(TASK_ROWS):
        rows[i] *= weights[i]
        right[i] *= weights[i]
    square = rows.T @ rows
    for c in range(nv):
        square[c, c] += damping
    velocity[:] = np.linalg.solve(square, rows.T @ right)


@cache
def _compiled() -> Callable[..., None]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    real = numba.float64
    return entry_point(
        _solve, BODY_REFERENCE, MOTION, cube, matrix, numba.int64, matrix, vector, real, real,
        real, matrix, vector,
    )  # fmt: skip


@dataclass(frozen=True)
class InverseKinematics:
    """Joint angles and velocities that carry out a reference, for servos and for playback.

    Args:
        multibody: the mechanism.
        rate: at which errors of place are removed; a fifth in a cycle, of any robot [1/s].
        stiffness: of the servos; 3.75 m g h if None [N m/rad].
        damping: likewise; 0.394 m g h / omega [N m s/rad].
        trunk_weight: of the trunk's orientation, where that of a sole has 1 [-].
        period: control period [s].

    Raises:
        ParameterError: a value is out of range.
    """

    multibody: Multibody
    rate: float = 200.0
    stiffness: float | None = None
    damping: float | None = None
    trunk_weight: float = 0.3
    period: float = 0.001
    _workspace: dict[str, Any] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name, unit in (
            ("rate", "1/s"),
            ("trunk_weight", "-"),
            ("period", "s"),
        ):
            check_number(name, getattr(self, name), 0.0, unit, above=True)
        nv, model = self.multibody.model.nv, self.multibody.model
        own = OwnUnits.of(self.multibody.robot)
        servos = own.fill(self, _OWN)
        for name, value in servos.items():
            check_number(name, value, 0.0, _OWN[name][0], above=True)
        weights = np.ones(TASK_ROWS)
        weights[[3, 4, 5, 9, 10, 11]] = TURN * own.length
        weights[-3:] = TURN * own.length * self.trunk_weight
        motors = self.multibody.motors
        limited = model.jnt_limited[motors].astype(bool)
        ranges = model.jnt_range[motors]
        command = JointCommand(len(motors), nv)
        command.stiffness, command.damping = servos["stiffness"], servos["damping"]
        workspace = {
            "solve": _compiled(),
            "com_jacobian": np.zeros((3, nv)),
            "targets": np.zeros((2, 4)),
            "stood": [0, 0],
            "weights": weights,
            "least": DAMPING * own.length**2,
            "rows": np.zeros((TASK_ROWS, nv)),
            "velocity": np.zeros(nv),
            "low": np.where(limited, ranges[:, 0], -np.inf),
            "high": np.where(limited, ranges[:, 1], np.inf),
            "command": command,
        }
        object.__setattr__(self, "_workspace", workspace)

    def fresh(self) -> Self:
        """The same with room of its own to work in."""
        return replace(self)

    def velocity(self, mechanics: Mechanics, reference: NDArray[np.void]) -> NDArray[np.float64]:
        """Generalised velocity that carries out the reference, shape (nv,); overwritten each time.

        A sole that stands stays where it was when it came to stand.
        """
        s, m = self._workspace, mechanics
        for side in range(2):
            stands = int(reference["stands"][0, side])
            if stands and not s["stood"][side]:
                axes = m.sole_axes[side]
                s["targets"][side, :3] = m.sole_position[side]
                s["targets"][side, 3] = math.atan2(axes[1, 0], axes[0, 0])
            s["stood"][side] = stands
        m.com_jacobian(s["com_jacobian"])
        s["solve"](
            reference, m.motion, m.sole_jacobian, s["com_jacobian"], self.multibody.base_dof,
            s["targets"], s["weights"], self.rate, self.period, s["least"], s["rows"],
            s["velocity"],
        )  # fmt: skip
        return s["velocity"]

    def joints(self, mechanics: Mechanics, reference: NDArray[np.void]) -> JointCommand:
        """Angles and velocities of the servos, one period on, within the joints' ranges."""
        s, multibody = self._workspace, self.multibody
        velocity = self.velocity(mechanics, reference)[multibody.motor_dofs]
        command: JointCommand = s["command"]
        angles = mechanics.position[multibody.motor_positions]
        np.clip(angles + velocity * self.period, s["low"], s["high"], out=command.position)
        command.velocity[:] = velocity
        return command

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
from typing import Self

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.control.fields import check_fields, described, documented, fill_shares, setting
from surefoot.record import Record
from surefoot.record import field as value
from surefoot.robot.multibody import Multibody
from surefoot.worlds.body.interface import BODY_REFERENCE, JointCommand
from surefoot.worlds.body.mechanics import MOTION, Mechanics
from surefoot.worlds.body.tasks import rotation_error

DAMPING = 1.56e-4
"""Of the least squares: what a joint's velocity costs, where a sole's has 1, in squared heights of
the CoM."""

TURN = 1.25
"""What an error of 1 rad counts, where soles and CoM have 1, in heights of the CoM."""

TASK_ROWS = 18
"""Two soles of six rows, CoM and trunk of three."""


class _Gains(Record):
    """What the least squares of a cycle know beforehand."""

    rate: float = value("1/s", "at which errors of place are removed")
    period: float = value("s", "of control")
    damping: float = value("m^2", "what a joint's velocity costs")
    base_dof: int = value("", "first degree of freedom of the base")


@njit
def _solve(gains, reference, motion, jacobians, targets, weights, rows, velocity):
    """Write the generalised velocity that is nearest to all tasks.

    `jacobians` are those of the soles and of the CoM; `targets` place and heading of the standing
    ones, shape (2, 4); `rows` is scratch, shape (TASK_ROWS, nv).
    """
    gain, period, base_dof = gains[0].rate, gains[0].period, gains[0].base_dof
    sole_jacobian, com_jacobian = jacobians
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
        square[c, c] += gains[0].damping
    velocity[:] = np.linalg.solve(square, rows.T @ right)


@cache
def _compiled() -> Callable[..., None]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    jacobians = numba.types.Tuple((cube, matrix))
    return entry_point(
        _solve, _Gains, BODY_REFERENCE, MOTION, jacobians, matrix, vector, matrix, vector
    )


class _Workspace:
    """What a mapping computes with; where each sole came to stand, and whether it does."""

    def __init__(self, mapping: InverseKinematics) -> None:
        multibody = mapping.multibody
        nv, model, motors = multibody.model.nv, multibody.model, multibody.motors
        height = multibody.robot.com_height
        self.solve = _compiled()
        self.gains = _Gains(
            rate=mapping.rate,
            period=mapping.period,
            damping=DAMPING * height**2,
            base_dof=multibody.base_dof,
        ).array
        self.weights = np.ones(TASK_ROWS)
        self.weights[[3, 4, 5, 9, 10, 11]] = TURN * height
        self.weights[-3:] = TURN * height * mapping.trunk_weight
        self.com_jacobian, self.velocity = np.zeros((3, nv)), np.zeros(nv)
        self.rows, self.targets, self.stood = np.zeros((TASK_ROWS, nv)), np.zeros((2, 4)), [0, 0]
        limited, ranges = model.jnt_limited[motors].astype(bool), model.jnt_range[motors]
        self.low = np.where(limited, ranges[:, 0], -np.inf)
        self.high = np.where(limited, ranges[:, 1], np.inf)
        self.command = JointCommand(len(motors), nv)
        self.command.stiffness, self.command.damping = mapping.stiffness, mapping.damping


@documented
@dataclass(frozen=True)
class InverseKinematics:
    """Joint angles and velocities that carry out a reference, for servos and for playback.

    Raises:
        ParameterError: a value is out of range.
    """

    multibody: Multibody = field(metadata=described("the mechanism"))
    rate: float = setting(
        200.0, "1/s", "at which errors of place are removed; a fifth in a cycle, of any robot",
        above=0.0,
    )  # fmt: skip
    stiffness: float = setting(None, "N m/rad", "of the servos", share=3.75, above=0.0)
    damping: float = setting(None, "N m s/rad", "likewise", share=0.394, above=0.0)
    trunk_weight: float = setting(
        0.3, "-", "of the trunk's orientation, where that of a sole has 1", above=0.0
    )
    period: float = setting(0.001, "s", "control period", above=0.0)
    _workspace: _Workspace = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        fill_shares(self, self.multibody.robot)
        check_fields(self)
        object.__setattr__(self, "_workspace", _Workspace(self))

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
            if stands and not s.stood[side]:
                axes = m.sole_axes[side]
                s.targets[side, :3] = m.sole_position[side]
                s.targets[side, 3] = math.atan2(axes[1, 0], axes[0, 0])
            s.stood[side] = stands
        m.com_jacobian(s.com_jacobian)
        jacobians = m.sole_jacobian, s.com_jacobian
        s.solve(s.gains, reference, m.motion, jacobians, s.targets, s.weights, s.rows, s.velocity)
        return s.velocity

    def joints(self, mechanics: Mechanics, reference: NDArray[np.void]) -> JointCommand:
        """Angles and velocities of the servos, one period on, within the joints' ranges."""
        s, multibody = self._workspace, self.multibody
        velocity = self.velocity(mechanics, reference)[multibody.motor_dofs]
        angles = mechanics.position[multibody.motor_positions]
        np.clip(angles + velocity * self.period, s.low, s.high, out=s.command.position)
        s.command.velocity[:] = velocity
        return s.command

"""What the mechanism of a robot does at a state: inertia, momentum, soles and their Jacobians.

MuJoCo computes it; nothing here simulates. One workspace is filled anew for every state, since
nothing may be allocated within a control cycle.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import mujoco
import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.record import new_array
from surefoot.robot.multibody import Multibody

MOTION = np.dtype(
    [
        ("com", "f8", (3,)),
        ("com_velocity", "f8", (3,)),
        ("angular_momentum", "f8", (3,)),
        ("sole_position", "f8", (2, 3)),
        ("sole_axes", "f8", (2, 3, 3)),
        ("sole_velocity", "f8", (2, 6)),
        ("sole_drift", "f8", (2, 6)),
        ("base_axes", "f8", (3, 3)),
    ]
)
"""What is of the same size for every mechanism; see `Mechanics`."""


@njit
def _move(
    sites, base, velocity, jacobian, rate, places, axes, frames, com, speed, momentum, motion
):  # fmt: skip
    """Write the `MOTION` record, and nothing else.

    The other arguments are arrays of MuJoCo's, which are read where they lie.
    """
    out = motion[0]
    for i in range(3):
        out.com[i], out.com_velocity[i] = com[base, i], speed[base, i]
        out.angular_momentum[i] = momentum[base, i]
        for k in range(3):
            out.base_axes[i, k] = frames[base, 3 * i + k]
    for side in range(2):
        site = sites[side]
        for i in range(3):
            out.sole_position[side, i] = places[site, i]
            for k in range(3):
                out.sole_axes[side, i, k] = axes[site, 3 * i + k]
        for i in range(6):
            v = drift = 0.0
            for c in range(velocity.shape[0]):
                v += jacobian[side, i, c] * velocity[c]
                drift += rate[side, i, c] * velocity[c]
            out.sole_velocity[side, i], out.sole_drift[side, i] = v, drift


@njit
def _turn_rate(velocity, axis, out):
    """Write the rate of an axis of rotation that moves with a body, both about the same point."""
    w, v = velocity[:3], velocity[3:]
    r, m = axis[:3], axis[3:]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = w[j] * r[k] - w[k] * r[j]
        out[3 + i] = (w[j] * m[k] - w[k] * m[j]) + (v[j] * r[k] - v[k] * r[j])


@njit
def _differentiate(chain, axes, rates, speeds, com, place, foot, jacobian, rate):
    """Write J and dJ/dt of a point of a foot, from the axes of motion of the joints above it.

    Both are what `mj_jacSite` and `mj_jacDot` give, to the bit and in a fifth of the time. Most
    arguments are arrays of MuJoCo's, which are read where they lie.
    """
    c, own, point, out = speeds[foot], np.empty(6), np.empty(3), np.empty(3)
    for i in range(3):
        out[i] = place[i] - com[i]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        point[i] = c[3 + i] - (out[j] * c[k] - out[k] * c[j])
    for n in range(chain.shape[0]):
        dof, turns_with = chain[n, 0], chain[n, 1]
        axis = axes[dof]
        own[:] = rates[dof]
        if turns_with >= 0:
            _turn_rate(speeds[turns_with], axis, own)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            jacobian[3 + i, dof], rate[3 + i, dof] = axis[i], own[i]
            jacobian[i, dof] = axis[3 + i] + (axis[j] * out[k] - axis[k] * out[j])
            rate[i, dof] = (
                own[3 + i]
                + (own[j] * out[k] - own[k] * out[j])
                + (axis[j] * point[k] - axis[k] * point[j])
            )


@njit
def _describe(
    sites, feet, left, right, base, velocity, jacobian, rate,
    axes, rates, speeds, places, frames, turns, com, speed, momentum, motion,
):  # fmt: skip
    """Write the motion of base and soles.

    Most arguments are arrays of MuJoCo's, which are read where they lie.
    """
    for side in range(2):
        _differentiate(
            left if side == 0 else right, axes, rates, speeds, com[base], places[sites[side]],
            feet[side], jacobian[side], rate[side],
        )  # fmt: skip
    _move(
        sites, base, velocity, jacobian, rate, places, frames, turns, com, speed, momentum, motion
    )  # fmt: skip


@cache
def _compiled() -> Callable[..., None]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    whole, table = np.dtype(np.int64), numba.int64[:, ::1]
    return entry_point(
        _describe, whole, whole, table, table, numba.int64, vector, cube, cube, *[matrix] * 9,
        MOTION,
    )  # fmt: skip


def _chain(model: mujoco.MjModel, foot: int) -> NDArray[np.int64]:
    """Degrees of freedom that move a foot, from the foot up, each with the body whose turning its
    axis follows (-1 for an axis whose rate MuJoCo knows), shape (n, 2)."""
    while model.body_dofnum[foot] == 0:
        foot = model.body_parentid[foot]
    dof, rows = model.body_dofadr[foot] + model.body_dofnum[foot] - 1, []
    while dof >= 0:
        joint = model.dof_jntid[dof]
        # The rotations of a free joint are about axes of the body itself.
        turns = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE and (
            dof >= model.jnt_dofadr[joint] + 3
        )
        rows.append((dof, model.dof_bodyid[dof] if turns else -1))
        dof = model.dof_parentid[dof]
    return np.array(rows, np.int64)


class Mechanics:
    """The quantities of a mechanism that control works with, all in world axes.

    Args:
        multibody: the mechanism.

    Attributes:
        position, velocity: generalised, as of the last `update`, shapes (nq,), (nv,).
        inertia: joint-space inertia M, shape (nv, nv).
        bias: forces h that the motors and the ground have to hold against: gravity, Coriolis and
            centrifugal forces, less springs and dampers, shape (nv,).
        sole_jacobian: J of the centres of the soles, linear then angular, shape (2, 6, nv).
        motion: a `MOTION` record, shape (1,); the rest are views on its fields:
        sole_position: shape (2, 3) [m].
        sole_axes: axes of the soles as columns, shape (2, 3, 3).
        sole_velocity: J v, shape (2, 6) [m/s, rad/s].
        sole_drift: dJ/dt v, shape (2, 6) [m/s^2, rad/s^2].
        com, com_velocity: centre of mass, shape (3,) [m, m/s].
        angular_momentum: angular momentum about the CoM, shape (3,) [kg m^2/s].
        base_axes: axes of the base as columns, shape (3, 3).
    """

    def __init__(self, multibody: Multibody) -> None:
        model = multibody.model
        self.multibody, self._data = multibody, mujoco.MjData(model)
        data, nv = self._data, model.nv
        self.position, self.velocity = data.qpos, data.qvel
        self.inertia, self.bias = np.zeros((nv, nv)), np.zeros(nv)
        self.sole_jacobian, rate = np.zeros((2, 6, nv)), np.zeros((2, 6, nv))
        self.motion = new_array(MOTION)
        for name in MOTION.names or ():
            setattr(self, name, self.motion[name][0])
        self._passive, self._rotors = data.qfrc_passive, np.zeros(nv)
        left, right = (_chain(model, foot) for foot in multibody.feet)
        self._arguments = (
            np.array(multibody.soles, np.int64), np.array(multibody.feet, np.int64), left, right,
            multibody.base, data.qvel, self.sole_jacobian, rate,
            data.cdof, data.cdof_dot, data.cvel, data.site_xpos, data.site_xmat, data.xmat,
            data.subtree_com, data.subtree_linvel, data.subtree_angmom, self.motion,
        )  # fmt: skip
        self._describe = _compiled()
        self.update(multibody.nominal, np.zeros(nv))

    com: NDArray[np.float64]
    com_velocity: NDArray[np.float64]
    angular_momentum: NDArray[np.float64]
    sole_position: NDArray[np.float64]
    sole_axes: NDArray[np.float64]
    sole_velocity: NDArray[np.float64]
    sole_drift: NDArray[np.float64]
    base_axes: NDArray[np.float64]

    def update(self, position: NDArray[np.float64], velocity: NDArray[np.float64]) -> None:
        """Compute everything at another state.

        Args:
            position: generalised positions, shape (nq,).
            velocity: generalised velocities, shape (nv,).
        """
        model, data = self.multibody.model, self._data
        self.position[:] = position
        self.velocity[:] = velocity
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_fullM(model, data, self.inertia)
        mujoco.mj_comVel(model, data)
        mujoco.mj_subtreeVel(model, data)
        mujoco.mj_passive(model, data)
        mujoco.mj_rne(model, data, 0, self.bias)
        np.subtract(self.bias, self._passive, out=self.bias)
        self._describe(*self._arguments)

    def forces(self, acceleration: NDArray[np.float64], out: NDArray[np.float64]) -> None:
        """Write M a + h at the state of the last `update`, by Newton and Euler, without M.

        Args:
            acceleration: generalised, a, shape (nv,).
            out: generalised forces, shape (nv,).
        """
        data, model = self._data, self.multibody.model
        data.qacc[:] = acceleration
        mujoco.mj_rne(model, data, 1, out)
        np.subtract(out, self._passive, out=out)
        # The recursion knows links, and no rotors.
        np.multiply(model.dof_armature, acceleration, out=self._rotors)
        np.add(out, self._rotors, out=out)

    def com_jacobian(self, out: NDArray[np.float64]) -> None:
        """Write the Jacobian of the CoM at the state of the last `update`, shape (3, nv)."""
        mujoco.mj_jacSubtreeCom(self.multibody.model, self._data, out, self.multibody.base)

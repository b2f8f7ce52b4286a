"""What the mechanism of a robot does at a state: inertia, momentum, soles and their Jacobians.

MuJoCo computes it; nothing here simulates. One workspace is filled anew for every state, since
nothing may be allocated within a control cycle.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import mujoco
import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.record import Array, Record, Vector3, field, new_array
from surefoot.robot.multibody import Multibody


class Motion(Record):
    """The part of a mechanism's motion that has the same size for every robot, in world axes."""

    com: Vector3 = field("m", "centre of mass")
    com_velocity: Vector3 = field("m/s", "its velocity")
    angular_momentum: Vector3 = field("kg m^2/s", "about the CoM")
    sole_position: Array = field("m", "centres of the soles, left and right", shape=(2, 3))
    sole_axes: Array = field("-", "axes of the soles as columns", shape=(2, 3, 3))
    sole_velocity: Array = field("m/s, rad/s", "J v, linear then angular", shape=(2, 6))
    sole_drift: Array = field("m/s^2, rad/s^2", "dJ/dt v", shape=(2, 6))
    base_axes: Array = field("-", "axes of the base as columns", shape=(3, 3))


MOTION = Motion.DTYPE


class _Sources(NamedTuple):
    """Arrays of MuJoCo's, which are read where they lie; its names."""

    cdof: NDArray[np.float64]
    cdof_dot: NDArray[np.float64]
    cvel: NDArray[np.float64]
    site_xpos: NDArray[np.float64]
    site_xmat: NDArray[np.float64]
    xmat: NDArray[np.float64]
    subtree_com: NDArray[np.float64]
    subtree_linvel: NDArray[np.float64]
    subtree_angmom: NDArray[np.float64]


class _Legs(NamedTuple):
    """Sites of the soles and bodies of the feet, shape (2,); `_chain` of each foot; the base."""

    soles: NDArray[np.int64]
    feet: NDArray[np.int64]
    left: NDArray[np.int64]
    right: NDArray[np.int64]
    base: int


@njit
def _move(legs, sources, velocity, jacobian, rate, motion):
    """Write the `Motion`, and nothing else."""
    base = legs.base
    for i in range(3):
        motion.com[i] = sources.subtree_com[base, i]
        motion.com_velocity[i] = sources.subtree_linvel[base, i]
        motion.angular_momentum[i] = sources.subtree_angmom[base, i]
        for k in range(3):
            motion.base_axes[i, k] = sources.xmat[base, 3 * i + k]
    for side in range(2):
        site = legs.soles[side]
        for i in range(3):
            motion.sole_position[side, i] = sources.site_xpos[site, i]
            for k in range(3):
                motion.sole_axes[side, i, k] = sources.site_xmat[site, 3 * i + k]
        for i in range(6):
            v = drift = 0.0
            for c in range(velocity.shape[0]):
                v += jacobian[side, i, c] * velocity[c]
                drift += rate[side, i, c] * velocity[c]
            motion.sole_velocity[side, i], motion.sole_drift[side, i] = v, drift


@njit
def _rotate_rate(velocity, axis, out):
    """Write the rate of an axis of rotation that moves with a body, both about the same point."""
    w, v = velocity[:3], velocity[3:]
    r, m = axis[:3], axis[3:]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = w[j] * r[k] - w[k] * r[j]
        out[3 + i] = (w[j] * m[k] - w[k] * m[j]) + (v[j] * r[k] - v[k] * r[j])


@njit
def _differentiate(chain, sources, base, site, foot, jacobian, rate):
    """Write J and dJ/dt of a point of a foot, from the axes of motion of the joints above it.

    Both are what `mj_jacSite` and `mj_jacDot` give, to the bit and in a fifth of the time.
    """
    place, com, speeds = sources.site_xpos[site], sources.subtree_com[base], sources.cvel
    c, own, point, out = speeds[foot], np.empty(6), np.empty(3), np.empty(3)
    for i in range(3):
        out[i] = place[i] - com[i]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        point[i] = c[3 + i] - (out[j] * c[k] - out[k] * c[j])
    for n in range(chain.shape[0]):
        dof, rotates_with = chain[n, 0], chain[n, 1]
        axis = sources.cdof[dof]
        own[:] = sources.cdof_dot[dof]
        if rotates_with >= 0:
            _rotate_rate(speeds[rotates_with], axis, own)
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
def _describe(legs, sources, velocity, jacobian, rate, motion):
    """Write the Jacobians of the soles, their rates, and the motion of base and soles."""
    for side in range(2):
        chain = legs.left if side == 0 else legs.right
        site, foot = legs.soles[side], legs.feet[side]
        _differentiate(chain, sources, legs.base, site, foot, jacobian[side], rate[side])
    _move(legs, sources, velocity, jacobian, rate, motion[0])


@cache
def _compiled() -> Callable[..., None]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    whole, table = numba.int64[::1], numba.int64[:, ::1]
    legs = numba.types.NamedTuple((whole, whole, table, table, numba.int64), _Legs)
    sources = numba.types.NamedUniTuple(matrix, len(_Sources._fields), _Sources)
    return entry_point(_describe, legs, sources, vector, cube, cube, MOTION)


def _chain(model: mujoco.MjModel, foot: int) -> NDArray[np.int64]:
    """Degrees of freedom that move a foot, from the foot up, each with the body whose turning its
    axis follows (-1 for an axis whose rate MuJoCo knows), shape (n, 2)."""
    while model.body_dofnum[foot] == 0:
        foot = model.body_parentid[foot]
    dof, rows = model.body_dofadr[foot] + model.body_dofnum[foot] - 1, []
    while dof >= 0:
        joint = model.dof_jntid[dof]
        # The rotations of a free joint are about axes of the body itself.
        rotates = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE and (
            dof >= model.jnt_dofadr[joint] + 3
        )
        rows.append((dof, model.dof_bodyid[dof] if rotates else -1))
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
        motion: a `Motion` as an array, shape (1,); its fields are attributes too.
    """

    com: NDArray[np.float64]
    com_velocity: NDArray[np.float64]
    angular_momentum: NDArray[np.float64]
    sole_position: NDArray[np.float64]
    sole_axes: NDArray[np.float64]
    sole_velocity: NDArray[np.float64]
    sole_drift: NDArray[np.float64]
    base_axes: NDArray[np.float64]

    def __init__(self, multibody: Multibody) -> None:
        model = multibody.model
        self.multibody, self._data = multibody, mujoco.MjData(model)
        data, nv = self._data, model.nv
        self.position, self.velocity = data.qpos, data.qvel
        self.inertia, self.bias = np.zeros((nv, nv)), np.zeros(nv)
        self.sole_jacobian, self.motion = np.zeros((2, 6, nv)), new_array(MOTION)
        for name in Motion.FIELDS:
            setattr(self, name, self.motion[name][0])
        self._passive, self._rotors = data.qfrc_passive, np.zeros(nv)
        soles, feet = np.array(multibody.soles, np.int64), np.array(multibody.feet, np.int64)
        left, right = (_chain(model, foot) for foot in multibody.feet)
        self._arguments = (
            _Legs(soles, feet, left, right, multibody.base),
            _Sources(*(getattr(data, name) for name in _Sources._fields)),
            data.qvel, self.sole_jacobian, np.zeros((2, 6, nv)), self.motion,
        )  # fmt: skip
        self._describe = _compiled()
        self.update(multibody.nominal, np.zeros(nv))

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

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

from surefoot.compiling import entry_point, njit
from surefoot.models.multibody import Multibody
from surefoot.models.record import new_array

MOTION = np.dtype(
    [
        ("com", "f8", (3,)),
        ("com_velocity", "f8", (3,)),
        ("spin", "f8", (3,)),
        ("sole_position", "f8", (2, 3)),
        ("sole_axes", "f8", (2, 3, 3)),
        ("sole_velocity", "f8", (2, 6)),
        ("sole_drift", "f8", (2, 6)),
        ("base_axes", "f8", (3, 3)),
    ]
)
"""What is of the same size for every mechanism; see `Mechanics`."""


@njit
def _move(sites, base, velocity, jacobian, rate, places, axes, frames, com, speed, spin, motion):
    """Write the `MOTION` record, and nothing else."""
    out = motion[0]
    for i in range(3):
        out.com[i], out.com_velocity[i], out.spin[i] = com[base, i], speed[base, i], spin[base, i]
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


@cache
def _compiled() -> Callable[..., None]:
    vector, matrix, cube = numba.float64[::1], numba.float64[:, ::1], numba.float64[:, :, ::1]
    whole = np.dtype(np.int64)
    return entry_point(
        _move, whole, numba.int64, vector, cube, cube, *[matrix] * 6, MOTION
    )  # fmt: skip


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
        spin: angular momentum about the CoM, shape (3,) [kg m^2/s].
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
        self._soles = [
            (
                site,
                foot,
                data.site_xpos[site],
                self.sole_jacobian[side, :3],
                self.sole_jacobian[side, 3:],
                rate[side, :3],
                rate[side, 3:],
            )
            for side, (site, foot) in enumerate(zip(multibody.soles, multibody.feet, strict=True))
        ]
        self._passive = data.qfrc_passive
        self._arguments = (
            np.array(multibody.soles, np.int64), multibody.base, data.qvel, self.sole_jacobian,
            rate, data.site_xpos, data.site_xmat, data.xmat, data.subtree_com,
            data.subtree_linvel, data.subtree_angmom, self.motion,
        )  # fmt: skip
        self._move = _compiled()
        self.update(multibody.nominal, np.zeros(nv))

    com: NDArray[np.float64]
    com_velocity: NDArray[np.float64]
    spin: NDArray[np.float64]
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
        for site, foot, place, linear, angular, linear_rate, angular_rate in self._soles:
            mujoco.mj_jacSite(model, data, linear, angular, site)
            mujoco.mj_jacDot(model, data, linear_rate, angular_rate, place, foot)
        self._move(*self._arguments)

    def com_jacobian(self, out: NDArray[np.float64]) -> None:
        """Write the Jacobian of the CoM at the state of the last `update`, shape (3, nv)."""
        mujoco.mj_jacSubtreeCom(self.multibody.model, self._data, out, self.multibody.base)

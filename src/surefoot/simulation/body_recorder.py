"""Takes down what a body in physics does while it does it: copies into arrays, nothing computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.models.interfaces import COMMAND, OBSERVATION
from surefoot.models.joint_command import JointCommand
from surefoot.models.walker import WalkerState
from surefoot.simulation.body_plant import BodyPlant


@dataclass(frozen=True)
class Record:
    """Rows of a walk, cut to its length.

    Attributes:
        state: arrays by name, as they were before each cycle of physics.
        effect: likewise of the cycle itself.
        told: what the walker was told and what it did, likewise.
        clock: wall clock at the beginning, after the senses, the walker and the physics,
            shape (n, 4) [ns].
    """

    state: dict[str, NDArray[Any]]
    effect: dict[str, NDArray[Any]]
    told: dict[str, NDArray[Any]]
    clock: NDArray[np.int64]


class BodyRecorder:
    """Rows for every cycle of a walk, ready to be filled.

    Args:
        plant: whose walk it is.
        state: of the walker at the start; says what a row of its own looks like.
        estimates: whether the walker is told something else than the truth.
        cycles: how many rows there are at most.
    """

    def __init__(self, plant: BodyPlant, state: WalkerState, estimates: bool, cycles: int) -> None:
        data, multibody = plant.data, plant.multibody
        self._plant, self._base, self._estimates = plant, multibody.base, estimates
        left, right = multibody.soles
        first, second = multibody.feet
        sources = {
            "position": (data.qpos, "f4"),
            "velocity": (data.qvel, "f4"),
            "com": (data.subtree_com[multibody.base], "f8"),
            "com_velocity": (data.subtree_linvel[multibody.base], "f8"),
            "spin": (data.subtree_angmom[multibody.base], "f8"),
            "left_sole": (data.site_xpos[left], "f8"),
            "right_sole": (data.site_xpos[right], "f8"),
            "left_axes": (data.site_xmat[left], "f8"),
            "right_axes": (data.site_xmat[right], "f8"),
            "base_axes": (data.xmat[multibody.base], "f8"),
        }
        effects = {
            "torque": (plant.torque, "f4"),
            "left_wrench": (data.cfrc_ext[first], "f8"),
            "right_wrench": (data.cfrc_ext[second], "f8"),
        }
        self._state = {n: np.zeros((cycles, len(v)), kind) for n, (v, kind) in sources.items()}
        self._effect = {n: np.zeros((cycles, len(v)), kind) for n, (v, kind) in effects.items()}
        self._before = [(self._state[name], view) for name, (view, _) in sources.items()]
        self._after = [(self._effect[name], view) for name, (view, _) in effects.items()]
        rows = cycles if estimates else 0
        self._told = {
            "told_position": np.zeros((rows, multibody.model.nq), "f4"),
            "told_velocity": np.zeros((rows, multibody.model.nv), "f4"),
            "walk": np.zeros(cycles, state.walk.dtype),
            "observation": np.zeros(cycles, OBSERVATION),
            "command": np.zeros(cycles, COMMAND),
            "course": np.zeros((cycles, 3)),
            "solver": np.zeros(cycles, "i2"),
        }
        self._course: tuple[Any, tuple[float, float, float]] = (None, (0.0, 0.0, 0.0))
        self._clock = np.zeros((cycles, 4), np.int64)

    def see(self, row: int, position: NDArray[np.float64], velocity: NDArray[np.float64]) -> None:
        """Before a cycle of physics: the truth, and what the walker is told of it."""
        mujoco.mj_subtreeVel(self._plant.model, self._plant.data)
        for rows, view in self._before:
            rows[row] = view
        if self._estimates:
            self._told["told_position"][row] = position
            self._told["told_velocity"][row] = velocity

    def hear(self, row: int, state: WalkerState, command: JointCommand) -> None:
        """What the walker has decided."""
        told, here = self._told, slice(row, row + 1)
        told["walk"][here] = state.walk
        told["observation"][here] = state.observation.array
        told["command"][here] = state.command.array
        told["solver"][row] = command.status
        if state.course is not self._course[0]:
            x, y = state.course.place
            self._course = (state.course, (x, y, state.course.heading))
        told["course"][row] = self._course[1]

    def feel(self, row: int, clock: tuple[int, int, int, int]) -> None:
        """After the cycle: motors, forces of the floor, and how long all of it took."""
        for rows, view in self._after:
            rows[row] = view
        self._clock[row] = clock

    def record(self, cycles: int) -> Record:
        """All rows so far."""
        return Record(
            _cut(self._state, cycles),
            _cut(self._effect, cycles),
            _cut(self._told, cycles),
            self._clock[:cycles],
        )


def _cut(rows: dict[str, NDArray[Any]], cycles: int) -> dict[str, NDArray[Any]]:
    return {name: array[:cycles] for name, array in rows.items()}

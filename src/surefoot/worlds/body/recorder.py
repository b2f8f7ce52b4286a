"""Takes down what a body in physics does while it does it: copies into arrays, nothing computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.interface import COMMAND, OBSERVATION
from surefoot.worlds.body.joint_command import JointCommand
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.walker import WalkerState


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


class _Numbers:
    """Arrays side by side in one row a cycle: one copy is faster than many.

    Args:
        sources: the arrays by name, or how long one is that comes later; and how it is kept.
        cycles: how many rows there are.
    """

    def __init__(self, sources: dict[str, tuple[Any, str]], cycles: int) -> None:
        self.views = [view for view, _ in sources.values() if not isinstance(view, int)]
        self._columns, width = {}, 0
        for name, (view, kind) in sources.items():
            first, width = width, width + (view if isinstance(view, int) else len(view))
            self._columns[name] = (slice(first, width), kind)
        # Written to now: np.zeros would have the system find the memory in the middle of a cycle.
        self.rows = np.full((cycles, width), np.nan)

    def arrays(self, spans: list[slice]) -> dict[str, NDArray[Any]]:
        """Every array by itself, the rows of these spans one after the other."""
        return {
            name: np.concatenate([self.rows[span, columns] for span in spans]).astype(kind)
            for name, (columns, kind) in self._columns.items()
        }


class BodyRecorder:
    """Rows for every cycle of a walk, ready to be filled.

    Args:
        plant: whose walk it is.
        state: of the walker at the start; says what a row of its own looks like.
        estimates: whether the walker is told something else than the truth.
        cycles: how many rows are kept, the last ones.
    """

    def __init__(self, plant: BodyPlant, state: WalkerState, estimates: bool, cycles: int) -> None:
        data, multibody = plant.data, plant.multibody
        self._plant, self._estimates, self.cycles = plant, estimates, cycles
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
        told = {
            "told_position": (multibody.model.nq, "f4"),
            "told_velocity": (multibody.model.nv, "f4"),
        }
        self._state, self._effect = _Numbers(sources, cycles), _Numbers(effects, cycles)
        self._told = _Numbers(told, cycles if estimates else 0)
        kinds = {"walk": state.walk.dtype, "observation": OBSERVATION, "command": COMMAND}
        self._records = {n: (kind, bytearray(cycles * kind.itemsize)) for n, kind in kinds.items()}
        # No row may leave an object behind: they would have garbage collected every few cycles.
        self._solver, self._course = np.ones(cycles, "i2"), np.ones((cycles, 3))
        self._clock = np.ones((cycles, 4), np.int64)

    def see(self, row: int, position: NDArray[np.float64], velocity: NDArray[np.float64]) -> None:
        """Before a cycle of physics: the truth, and what the walker is told of it."""
        mujoco.mj_subtreeVel(self._plant.model, self._plant.data)
        row %= self.cycles
        np.concatenate(self._state.views, out=self._state.rows[row])
        if self._estimates:
            np.concatenate((position, velocity), out=self._told.rows[row])

    def hear(self, row: int, state: WalkerState, command: JointCommand) -> None:
        """What the walker has decided."""
        row %= self.cycles
        self._keep("walk", row, state.walk)
        self._keep("observation", row, state.observation.array)
        self._keep("command", row, state.command.array)
        self._solver[row] = command.status
        self._course[row] = (*state.course.place, state.course.heading)

    def _keep(self, name: str, row: int, record: NDArray[np.void]) -> None:
        """A record by its bytes: NumPy would copy it field by field, fifty times slower."""
        kind, rows = self._records[name]
        rows[row * kind.itemsize : (row + 1) * kind.itemsize] = record.tobytes()

    def feel(self, row: int, clock: tuple[int, int, int, int]) -> None:
        """After the cycle: motors, forces of the floor, and how long all of it took."""
        row %= self.cycles
        np.concatenate(self._effect.views, out=self._effect.rows[row])
        self._clock[row] = clock

    def record(self, end: int, begin: int = 0) -> Record:
        """The rows from `begin` to before `end`, as far as they are still kept."""
        begin = max(begin, end - self.cycles)
        first, length = begin % self.cycles, end - begin
        spans = [slice(first, min(first + length, self.cycles))]
        if first + length > self.cycles:
            spans.append(slice(0, first + length - self.cycles))
        told: dict[str, NDArray[Any]] = {
            **self._told.arrays(spans if self._estimates else [slice(0, 0)]),
            "course": np.concatenate([self._course[span] for span in spans]),
            "solver": np.concatenate([self._solver[span] for span in spans]),
        }
        for name, (kind, rows) in self._records.items():
            size = kind.itemsize
            kept = [rows[span.start * size : span.stop * size] for span in spans]
            told[name] = np.frombuffer(b"".join(map(bytes, kept)), kind)
        clock = np.concatenate([self._clock[span] for span in spans])
        return Record(self._state.arrays(spans), self._effect.arrays(spans), told, clock)

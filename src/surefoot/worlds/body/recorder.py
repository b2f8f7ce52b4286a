"""Records what a body in physics does while it does it: copies into arrays, nothing computed."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.interface import COMMAND, OBSERVATION
from surefoot.worlds.body.interface import JointCommand
from surefoot.worlds.body.plant import BodyPlant

Array = NDArray[Any]


@dataclass(frozen=True)
class Record:
    """Rows of a walk, cut to its length.

    Attributes:
        state: arrays by name, as they were before each cycle of physics.
        effect: likewise of the cycle itself.
        decision: what the controller was given and what it answered, likewise.
        clock: wall clock at the beginning, after the estimate, the decision and the physics,
            shape (n, 4) [ns].
    """

    state: dict[str, Array]
    effect: dict[str, Array]
    decision: dict[str, Array]
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

    def fork(self, sources: dict[str, tuple[Any, str]]) -> _Numbers:
        """The same rows, which go on with other arrays."""
        other = copy.copy(self)
        other.views, other.rows = [view for view, _ in sources.values()], self.rows.copy()
        return other

    def arrays(self, spans: list[slice]) -> dict[str, Array]:
        """Every array by itself, the rows of these spans one after the other."""
        return {
            name: np.concatenate([self.rows[span, columns] for span in spans]).astype(kind)
            for name, (columns, kind) in self._columns.items()
        }


def _state_sources(plant: BodyPlant) -> dict[str, tuple[Any, str]]:
    """What is recorded before a cycle of physics: views of the plant's arrays, and their kinds."""
    data, multibody = plant.data, plant.multibody
    left, right = multibody.soles
    return {
        "position": (data.qpos, "f4"),
        "velocity": (data.qvel, "f4"),
        "com": (data.subtree_com[multibody.base], "f8"),
        "com_velocity": (data.subtree_linvel[multibody.base], "f8"),
        "angular_momentum": (data.subtree_angmom[multibody.base], "f8"),
        "left_sole": (data.site_xpos[left], "f8"),
        "right_sole": (data.site_xpos[right], "f8"),
        "left_axes": (data.site_xmat[left], "f8"),
        "right_axes": (data.site_xmat[right], "f8"),
        "base_axes": (data.xmat[multibody.base], "f8"),
    }


def _effect_sources(plant: BodyPlant) -> dict[str, tuple[Any, str]]:
    """Likewise of the cycle itself."""
    first, second = plant.multibody.feet
    return {
        "torque": (plant.torque, "f4"),
        "left_wrench": (plant.data.cfrc_ext[first], "f8"),
        "right_wrench": (plant.data.cfrc_ext[second], "f8"),
    }


class BodyRecorder:
    """Rows for every cycle of a walk, ready to be filled.

    Args:
        plant: whose walk it is.
        state: of what walks the body at the start; says what a row of its own looks like.
        estimates: whether that is given something else than the truth.
        cycles: how many rows are retained, the last ones.
    """

    def __init__(self, plant: BodyPlant, state: Any, estimates: bool, cycles: int) -> None:
        multibody = plant.multibody
        self._plant, self._estimates, self.cycles = plant, estimates, cycles
        given = {
            "told_position": (multibody.model.nq, "f4"),
            "told_velocity": (multibody.model.nv, "f4"),
        }
        self._state = _Numbers(_state_sources(plant), cycles)
        self._effect = _Numbers(_effect_sources(plant), cycles)
        self._given = _Numbers(given, cycles if estimates else 0)
        kinds = {"walk": state.walk.dtype, "observation": OBSERVATION, "command": COMMAND}
        self._records = {n: (kind, bytearray(cycles * kind.itemsize)) for n, kind in kinds.items()}
        # No row may leave an object behind: they would have garbage collected every few cycles.
        self._solver, self._course = np.ones(cycles, "i2"), np.ones((cycles, 3))
        self._clock = np.ones((cycles, 4), np.int64)

    def record_state(
        self, row: int, position: NDArray[np.float64], velocity: NDArray[np.float64]
    ) -> None:
        """Before a cycle of physics: the true state, and the one that the controller is given."""
        mujoco.mj_subtreeVel(self._plant.model, self._plant.data)
        row %= self.cycles
        np.concatenate(self._state.views, out=self._state.rows[row])
        if self._estimates:
            np.concatenate((position, velocity), out=self._given.rows[row])

    def record_decision(self, row: int, state: Any, command: JointCommand) -> None:
        """What was decided."""
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

    def record_effect(self, row: int, clock: tuple[int, int, int, int]) -> None:
        """After the cycle: motors, forces of the floor, and how long all of it took."""
        row %= self.cycles
        np.concatenate(self._effect.views, out=self._effect.rows[row])
        self._clock[row] = clock

    def fork(self, plant: BodyPlant) -> BodyRecorder:
        """A copy that goes on with another plant, in the same state."""
        other = copy.copy(self)
        other._plant = plant
        other._state = self._state.fork(_state_sources(plant))
        other._effect = self._effect.fork(_effect_sources(plant))
        other._given = self._given.fork({})
        other._records = {n: (kind, bytearray(rows)) for n, (kind, rows) in self._records.items()}
        other._solver, other._course = self._solver.copy(), self._course.copy()
        other._clock = self._clock.copy()
        return other

    def record(self, end: int, begin: int = 0) -> Record:
        """The rows from `begin` to before `end`, as far as they are retained."""
        begin = max(begin, end - self.cycles)
        first, length = begin % self.cycles, end - begin
        spans = [slice(first, min(first + length, self.cycles))]
        if first + length > self.cycles:
            spans.append(slice(0, first + length - self.cycles))
        decision: dict[str, Array] = {
            **self._given.arrays(spans if self._estimates else [slice(0, 0)]),
            "course": np.concatenate([self._course[span] for span in spans]),
            "solver": np.concatenate([self._solver[span] for span in spans]),
        }
        for name, (kind, rows) in self._records.items():
            size = kind.itemsize
            kept = [rows[span.start * size : span.stop * size] for span in spans]
            decision[name] = np.frombuffer(b"".join(map(bytes, kept)), kind)
        clock = np.concatenate([self._clock[span] for span in spans])
        return Record(self._state.arrays(spans), self._effect.arrays(spans), decision, clock)

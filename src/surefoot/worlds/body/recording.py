"""Records what a body in physics does while it does it, and makes a rollout of that.

In a cycle arrays are copied and nothing is computed. Afterwards everything is put into the world's
frame: a body's controller works in a frame that turns with its steps, so what it was given and what
it answered are rotated back. The DCM goes with the angular momentum L about the standing sole, as
the controller's does:

    xi = c + L x e_z / (m h omega).
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from surefoot.geometry import rotated_by, wrapped
from surefoot.interface import COMMAND, OBSERVATION
from surefoot.robot.floor import board_numbers
from surefoot.robot.legs import find_knees
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout, describe
from surefoot.rollout.trace import ROWS, TRUTH, WALKING, BodyTrace
from surefoot.version import VERSION
from surefoot.worlds.body.estimator import BodyEstimator
from surefoot.worlds.body.interface import BodyController, JointCommand
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.sensors import SensorNoise
from surefoot.worlds.steering import Steering

Array = NDArray[Any]

Record = dict[str, Array]
"""Rows of a walk by name: the state before each cycle of physics, what was decided, its effect; and
`clock`, wall clock at the beginning, after the estimate and the decision, and the time that physics
took, shape (n, 4) [ns]."""

MIN_FORCE = 1.0
"""Of the floor, below which there is no ZMP [N]."""


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
    """What is recorded before a cycle of physics: views of the plant's arrays, and their types."""
    data, multibody = plant.data, plant.multibody
    left, right = multibody.soles
    return {
        "position": (data.qpos, ROWS["position"]),
        "velocity": (data.qvel, ROWS["velocity"]),
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
        "torque": (plant.torque, ROWS["torque"]),
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
            "told_position": (multibody.model.nq, ROWS["told_position"]),
            "told_velocity": (multibody.model.nv, ROWS["told_velocity"]),
        }
        self._state = _Numbers(_state_sources(plant), cycles)
        self._effect = _Numbers(_effect_sources(plant), cycles)
        self._given = _Numbers(given, cycles if estimates else 0)
        kinds = {"walk": state.walk.dtype, "observation": OBSERVATION, "command": COMMAND}
        self._records = {n: (kind, bytearray(cycles * kind.itemsize)) for n, kind in kinds.items()}
        # No row may leave an object behind: they would have garbage collected every few cycles.
        self._solver, self._course = np.ones(cycles, ROWS["solver"]), np.ones((cycles, 3))
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
        rows: Record = {
            **self._state.arrays(spans),
            **self._effect.arrays(spans),
            **self._given.arrays(spans if self._estimates else [slice(0, 0)]),
            "course": np.concatenate([self._course[span] for span in spans]),
            "solver": np.concatenate([self._solver[span] for span in spans]),
            "clock": np.concatenate([self._clock[span] for span in spans]),
        }
        for name, (kind, stored) in self._records.items():
            size = kind.itemsize
            kept = [stored[span.start * size : span.stop * size] for span in spans]
            rows[name] = np.frombuffer(b"".join(map(bytes, kept)), kind)
        return rows


def sensors_words(estimator: BodyEstimator | None, noise: SensorNoise | None) -> str:
    """Where the state comes from: `TRUTH`, or the parameters of the estimator and of the noise."""
    return TRUTH if estimator is None else f"{describe(estimator)}; noise: {noise!r}"


def make_rollout(
    control: BodyController,
    plant: BodyPlant,
    record: Record,
    fate: int,
    route: Sequence[tuple[float, Steering]],
    sensors: str,
    first: int = 0,
) -> Rollout:
    """The rollout of a record.

    Args:
        control: what walked.
        plant: what it walked.
        record: as `BodyRecorder.record` gives it.
        fate: how the robot fell, see `worlds.body.plant`.
        route: (time, command) in order of time [s], from the start on.
        sensors: where the state comes from, in words; see `sensors_words`.
        first: number of the cycle that the record begins with.
    """
    believed, multibody, clock = control.controller.robot, control.multibody, record["clock"]
    # Numbers of the plant's clock, which counts cycles.
    time = np.arange(first, first + len(clock)) * plant.model.opt.timestep
    truth = true_observations(record, time, believed, multibody.mass)
    if first:
        before = [to for at, to in route if at <= time[0]]
        route = [(float(time[0]), before[-1]), *((at, to) for at, to in route if at > time[0])]
    still = Steering().velocity
    velocities = [(at, still if to.standing else to.velocity) for at, to in route]
    rows = {**record, **_trace_rows(record)}
    trace = BodyTrace(
        robot=multibody.robot,
        believed=believed,
        omega=believed.omega,
        surroundings=repr(plant.surroundings),
        senses=sensors,
        steering=tuple((max(at, 0.0), to.velocity, to.turning, to.standing) for at, to in route),
        fate=fate,
        joints=multibody.joint_names,
        knees=find_knees(multibody),
        motor_positions=multibody.motor_positions,
        motor_dofs=multibody.motor_dofs,
        torque_limit=multibody.torque,
        speed_limit=multibody.speed,
        boards=board_numbers(plant.surroundings.boards),
        mass=float(plant.model.body_mass.sum()),
        **{name: rows[name].astype(kind, copy=False) for name, kind in ROWS.items()},
    )
    return Rollout(
        robot=multibody.robot,
        controller=type(control.controller).__name__,
        controller_parameters=describe(control.controller),
        velocities=tuple((max(at, 0.0), to) for at, to in velocities),
        pushes=tuple(push for push in plant.pushes if not first or push.end > time[0]),
        fallen=fate != 0,
        observations=truth,
        commands=commands_in_world(record, truth),
        decision_time=1e-9 * np.subtract(clock[:, 2], clock[:, 1]).astype(np.float64),
        seen=given_observations(record, truth),
        estimator="" if sensors == TRUTH else sensors,
        body=trace,
        version=VERSION,
    )


def _trace_rows(record: Record) -> Record:
    """The rows of a `BodyTrace` that a record does not hold as they are."""
    walk, clock = record["walk"], record["clock"]
    wrenches = np.stack([record["left_wrench"], record["right_wrench"]], axis=1)
    soles = np.stack([record["left_sole"], record["right_sole"]], axis=1)
    support, _ = carrying_foot(walk)
    plan = walk["swing_foot"].copy()
    walking = walk["phase"] == WALKING
    plan[walking, 2] += soles[walking, support[walking], 2]
    turns = [roll_pitch_yaw(record[f"{side}_axes"]) for side in ("left", "right")]
    return {
        "zmp": floor_zmp(record["com"], wrenches),
        "sole_position": soles,
        "sole_turn": np.stack(turns, axis=1),
        "sole_force": wrenches[:, :, 3:],
        "base_turn": roll_pitch_yaw(record["base_axes"]),
        "phase": walk["phase"],
        "support": support,
        "steps": walk["steps"],
        "swing_plan": plan,
        "sense_time": (clock[:, 1] - clock[:, 0]) * 1e-9,
        "physics_time": clock[:, 3] * 1e-9,
    }


def roll_pitch_yaw(axes: Array) -> Array:
    """Angles about x, y and z, shape (n, 3) [rad], of rotation matrices by rows, shape (n, 9)."""
    m = axes.reshape(-1, 3, 3)
    roll = np.arctan2(m[:, 2, 1], m[:, 2, 2])
    pitch = -np.arcsin(np.clip(m[:, 2, 0], -1.0, 1.0))
    return np.stack([roll, pitch, np.arctan2(m[:, 1, 0], m[:, 0, 0])], axis=-1)


def floor_zmp(com: Array, wrenches: Array) -> Array:
    """Where the floor's forces have no horizontal moment, NaN in the air, shape (n, 2) [m].

    Args:
        com: the point that the moments are about, shape (n, 3) [m].
        wrenches: moment and force on both feet, shape (n, 2, 6) [N m, N].
    """
    total = wrenches.sum(axis=1)
    moment, force = total[:, :3], total[:, 3:]
    up = np.where(force[:, 2] > MIN_FORCE, force[:, 2], np.nan)
    height = com[:, 2]
    x = com[:, 0] - (moment[:, 1] + height * force[:, 0]) / up
    y = com[:, 1] + (moment[:, 0] - height * force[:, 1]) / up
    return np.stack([x, y], axis=-1)


def carrying_foot(walk: Array) -> tuple[Array, Array]:
    """Foot on the ground and time of its touchdown; while both stand, those of the next step.

    After the last step they stay.
    """
    walking = walk["phase"] == WALKING
    support, began = walk["support"].copy(), walk["began"].copy()
    if walking.any():
        first = int(np.argmax(walking))
        support[:first], began[:first] = support[first], began[first]
    return support, began


def true_observations(record: Record, time: Array, believed: Robot, mass: float) -> Array:
    """The true observations of a walk, records of `OBSERVATION`, shape (n,)."""
    walk = record["walk"]
    support, began = carrying_foot(walk)
    rows = np.arange(len(time))
    soles = np.stack([record["left_sole"], record["right_sole"]], axis=1)
    yaws = np.stack([roll_pitch_yaw(record[f"{s}_axes"])[:, 2] for s in ("left", "right")], axis=1)
    seen = np.zeros(len(time), OBSERVATION)
    seen["time"], seen["elapsed"] = time, np.maximum(time - began, 0.0)
    com, velocity, momentum = record["com"], record["com_velocity"], record["angular_momentum"]
    foot, swing = soles[rows, support], soles[rows, 1 - support]
    seen["com"], seen["com_velocity"] = com[:, :2], velocity[:, :2]
    away, height = com - foot, believed.com_height
    twist = np.stack([momentum[:, 1], -momentum[:, 0]], axis=1) / mass
    about_foot = twist + away[:, 2:] * velocity[:, :2] - away[:, :2] * velocity[:, 2:]
    seen["dcm"] = com[:, :2] + about_foot / (height * believed.omega)
    seen["support_foot"], seen["swing_foot"] = foot[:, :2], swing
    if len(time) > 1:
        speed = np.gradient(soles, time, axis=0)
        seen["swing_foot_velocity"] = speed[rows, 1 - support]
    seen["support_yaw"], seen["swing_yaw"] = yaws[rows, support], yaws[rows, 1 - support]
    base = roll_pitch_yaw(record["base_axes"])
    seen["trunk_lean"] = rotated_by(np.stack([base[:, 1], -base[:, 0]], axis=1), base[:, 2])
    seen["support_side"] = 2 * support - 1
    return seen


def given_observations(record: Record, truth: Array) -> Array:
    """What the controller was given, in the world; the truth while it was given nothing."""
    walk = record["walk"]
    walking, heading = walk["phase"] == WALKING, walk["heading"]
    given = truth.copy()
    inner = record["observation"]
    for name in ("elapsed", "swing_foot", "swing_foot_velocity"):
        given[name][walking] = inner[name][walking]
    for name in ("com", "com_velocity", "dcm", "support_foot", "swing_foot", "swing_foot_velocity"):
        rotated = rotated_by(inner[name][..., :2], heading)
        given[name][walking, :2] = rotated[walking]
    for name in ("support_yaw", "swing_yaw"):
        given[name][walking] = wrapped(inner[name] + heading)[walking]
    return given


def commands_in_world(record: Record, truth: Array) -> Array:
    """What the controller answered, in the world; while both feet stand, what there is of it."""
    walk = record["walk"]
    walking, heading = walk["phase"] == WALKING, walk["heading"]
    inner = record["command"]
    commands = inner.copy()
    for name in (
        "zmp", "dcm_plan", "step_location", "dcm_offset", "swing_foot", "swing_foot_velocity",
        "swing_foot_acceleration", "hip_torque",
    ):  # fmt: skip
        commands[name][..., :2] = rotated_by(inner[name][..., :2], heading)
    commands["swing_yaw"] = wrapped(inner["swing_yaw"] + heading)
    still = ~walking
    # A stand has no plan of its DCM, and no step; its ZMP is in the world's frame already.
    commands["zmp"][still] = inner["zmp"][still]
    commands["dcm_plan"][still] = truth["dcm"][still]
    commands["step_location"][still] = truth["swing_foot"][still, :2]
    commands["swing_foot"][still] = truth["swing_foot"][still]
    for name in ("step_duration", "swing_foot_velocity", "swing_foot_acceleration", "dcm_offset"):
        commands[name][still] = 0.0
    commands["double_support"][still] = 1
    commands["mode"][still] = commands["status"][still] = 0
    return commands

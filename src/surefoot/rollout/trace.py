"""What a body in physics did, cycle by cycle: all that a picture, a film or a verdict needs.

It is plain arrays: it can be read, saved and loaded where MuJoCo is not installed.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from itertools import product
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefoot.geometry import rotated_by
from surefoot.robot.floor import FloorHeight, laid_boards
from surefoot.robot.robot import Robot

WALKING = 2
"""The phase of a body's walk in which one foot carries; in all others both do."""

Array = NDArray[Any]

FEET = ("left", "right")
"""Order of all arrays with an entry for each foot."""

TRUTH = "truth"
"""In place of an estimator: the walker is told the true state of its body."""

MEASURED = ("sense_time", "physics_time")
"""What no comparison looks at."""


TIMELESS = ("motor_positions", "motor_dofs", "torque_limit", "speed_limit", "boards")
"""Arrays without a row a cycle."""


@dataclass(frozen=True, eq=False, repr=False)
class BodyTrace:
    """Arrays of a walk in physics: time-first, SI, world frame; rows as in `Rollout.time`.

    Attributes:
        robot: with its `[body]`.
        believed: the point mass that its controller believes in.
        omega: natural frequency of that [1/s].
        surroundings: floor, payload and masses, as text.
        senses: what its walker was told: "truth", or the parameters of estimator and noise.
        steering: (time, (v_x, v_y), turning rate, standing) of every command
            [s, m/s, rad/s].
        fate: what became of it, 0 if it stands; see `worlds.body.plant`.
        joints: names of the motors' joints, in order, shape (m,).
        knees: which of them are the left and the right knee.
        motor_positions: indices of their angles in `position`, shape (m,).
        motor_dofs: likewise of their rates in `velocity`.
        torque_limit, speed_limit: of the motors, shape (m,); may be inf [N m, rad/s].
        position, velocity: generalised, shapes (n, nq), (n, nv), float32.
        told_position, told_velocity: likewise as the walker was told; no rows if it was the truth.
        torque: what the motors gave, shape (n, m), float32 [N m].
        com, com_velocity: centre of mass, shape (n, 3) [m, m/s].
        zmp: of all forces of the floor, NaN where there are none, shape (n, 2) [m].
        sole_position: centres of the soles, left and right, shape (n, 2, 3) [m].
        sole_turn: their roll, pitch and yaw, shape (n, 2, 3) [rad].
        sole_force: of the floor on each of them, shape (n, 2, 3) [N].
        base_turn: roll, pitch and yaw of the base, shape (n, 3) [rad].
        phase: 2 while one foot carries, shape (n,); else both do.
        support: 0 or 1 for the left or right foot on the ground, shape (n,).
        steps: number of the step, shape (n,).
        swing_plan: reference of the swinging sole, shape (n, 3) [m].
        course: where the robot should be, x, y and heading, shape (n, 3) [m, rad].
        solver: status of the mapping to joints, 1 or more if it succeeded, shape (n,).
        sense_time, physics_time: wall clock of a cycle, shape (n,) [s], of the estimate from what
            the sensors told, and of physics; how long the walker took is `Rollout.decision_time`.
        boards: that lie on the floor, shape (k, 6): x, y and half the sides [m], heading [rad],
            height [m].
        mass: of all links and the payload [kg]; None in files of before it was kept.
    """

    robot: Robot
    believed: Robot
    omega: float
    surroundings: str
    senses: str
    steering: tuple[tuple[float, tuple[float, float], float, bool], ...]
    fate: int
    joints: tuple[str, ...]
    knees: tuple[int, int]
    motor_positions: Array
    motor_dofs: Array
    torque_limit: Array
    speed_limit: Array
    position: Array
    velocity: Array
    told_position: Array
    told_velocity: Array
    torque: Array
    com: Array
    com_velocity: Array
    zmp: Array
    sole_position: Array
    sole_turn: Array
    sole_force: Array
    base_turn: Array
    phase: Array
    support: Array
    steps: Array
    swing_plan: Array
    course: Array
    solver: Array
    sense_time: Array
    physics_time: Array
    boards: Array = field(default_factory=lambda: np.zeros((0, 6)))
    mass: float | None = None

    @property
    def walking(self) -> NDArray[np.bool_]:
        """Whether one foot carries, shape (n,)."""
        return self.phase == WALKING

    @property
    def joint_angles(self) -> Array:
        """Of the motors' joints, shape (n, m) [rad]."""
        return self.position[:, self.motor_positions]

    @property
    def joint_velocities(self) -> Array:
        """Likewise, shape (n, m) [rad/s]."""
        return self.velocity[:, self.motor_dofs]

    @property
    def torque_part(self) -> Array:
        """Of its limit that each motor gives, shape (n, m) [-]."""
        return np.abs(self.torque) / self.torque_limit

    @cached_property
    def clearance(self) -> Array:
        """Height of the lowest corner of each sole over the floor, shape (n, 2) [m].

        Where boards lie it is the least of corners, edges and middle over what is below them.
        """
        half_x, half_y = self.robot.foot.half
        roll, pitch = self.sole_turn[..., 0], self.sole_turn[..., 1]
        if not len(self.boards):
            drop = half_x * np.abs(np.sin(pitch)) + half_y * np.abs(np.sin(roll) * np.cos(pitch))
            return self.sole_position[..., 2] - drop
        floor, yaw = FloorHeight(laid_boards(self.boards)), self.sole_turn[..., 2]
        least = np.full(yaw.shape, np.inf)
        for x, y in product((-half_x, 0.0, half_x), (-half_y, 0.0, half_y)):
            away = np.stack([np.full(yaw.shape, x), np.full(yaw.shape, y)], axis=-1)
            place = self.sole_position[..., :2] + rotated_by(away, yaw)
            rise = y * np.sin(roll) * np.cos(pitch) - x * np.sin(pitch)
            least = np.minimum(least, self.sole_position[..., 2] + rise - floor.at(place))
        return least

    def __repr__(self) -> str:
        return f"BodyTrace({self.robot.name!r}, {len(self.phase)} cycles, fate={self.fate})"

    def __eq__(self, other: object) -> bool:
        return type(other) is BodyTrace and all(
            np.array_equal(ours, theirs, equal_nan=True)
            if isinstance(ours := getattr(self, item.name), np.ndarray)
            else ours == theirs
            for item in fields(self)
            if item.name not in MEASURED
            for theirs in [getattr(other, item.name)]
        )

    __hash__ = None  # type: ignore[assignment]


def trace_parts(trace: BodyTrace) -> tuple[dict[str, Any], dict[str, Array]]:
    """A trace as what JSON can hold, and arrays."""
    values = {item.name: getattr(trace, item.name) for item in fields(trace)}
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
    about = {name: value for name, value in values.items() if name not in arrays}
    for name in ("robot", "believed"):
        about[name] = msgspec.to_builtins(about[name])
    return about, arrays


def trace_of(about: dict[str, Any], arrays: dict[str, Array]) -> BodyTrace:
    """The trace that `trace_parts` took apart.

    Raises:
        KeyError, TypeError, ValueError: a part is missing or of another kind.
    """
    values = {**about, **arrays}
    for name in ("robot", "believed"):
        values[name] = msgspec.convert(values[name], Robot)
    values["joints"] = tuple(values["joints"])
    left, right = values["knees"]
    values["knees"] = (left, right)
    values["steering"] = tuple(
        (float(time), (float(v[0]), float(v[1])), float(turning), bool(standing))
        for time, v, turning, standing in values["steering"]
    )
    return BodyTrace(**values)

"""What a body in physics did, cycle by cycle: all that a picture, a film or a verdict needs.

It is plain arrays: it can be read, saved and loaded where MuJoCo is not installed.

A robot that steps but gets nowhere has not walked: one whose steps end on the noise of its soles,
say, or whose feet slide. So the verdict on a body compares its speed, and how long its steps take,
with what was commanded. Speeds are means over whole pairs of steps, since a body sways in each.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefoot.control.fields import described, documented
from surefoot.geometry import rotated_by
from surefoot.robot.floor import FloorHeight, laid_boards
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.robot import Robot
from surefoot.rollout.fall import BodyFall, find_fall
from surefoot.rollout.outcome import Outcome, has_walked_on

if TYPE_CHECKING:
    from surefoot.rollout.rollout import Rollout

WALKING = 2
"""The phase of a body's walk in which one foot carries; in all others both do."""

Array = NDArray[Any]

TRUTH = "truth"
"""In place of an estimator: the controller is given the true state of its body."""

SETTLING = 14.0
"""Before the speed that is held is measured, from the first step, a command or a push on, in
1 / omega."""

SPEED_PART, SPEED_LEAST = 0.2, 0.01
"""How far the mean velocity may be from the command: a part of it, and at least so much of
sqrt(g h). Bodies hold 0.2 to 0.5 m/s to 5 % once they are on their course, and go up to 15 % faster
until they have made up for their first steps."""

CATCHING_UP = 0.0535
"""How much more after a push, in sqrt(g h): what `BodyControl` adds to take it back."""

STEP_PART = 0.75
"""Steps that on average are over before this part of what was planned at their beginnings were not
ended by the ground."""


@dataclass(frozen=True)
class HeldSpeed:
    """How a body walked under its last command to walk, after the time in which it settles.

    Attributes:
        velocity: mean over whole pairs of steps, in its own heading (forward, to the left) [m/s].
        commanded: what it should have been [m/s].
        allowed: how far it may be from that [m/s].
        duration: mean of its steps [s].
        planned: what that was to be at their beginnings [s].
    """

    velocity: tuple[float, float]
    commanded: tuple[float, float]
    allowed: float
    duration: float
    planned: float

    @property
    def is_held(self) -> bool:
        """Whether the robot held its commanded velocity, in steps that the ground ended."""
        away = math.dist(self.velocity, self.commanded)
        return away <= self.allowed and self.duration >= STEP_PART * self.planned


def _rows(kind: str, words: str, unit: str = "") -> dict[str, Any]:
    """The metadata of a field with a row for each cycle, which are of this type of NumPy."""
    return {**described(words, unit), "kind": kind}


@documented
@dataclass(frozen=True, eq=False, repr=False)
class BodyTrace:
    """Arrays of a walk in physics: time-first, SI, world frame; rows as in `Rollout.time`."""

    robot: Robot = field(metadata=described("with its `[body]`"))
    believed: Robot = field(metadata=described("the point mass that its controller believes in"))
    omega: float = field(metadata=described("natural frequency of that", "1/s"))
    surroundings: str = field(metadata=described("floor, payload and masses, as text"))
    senses: str = field(
        metadata=described(
            'where the state came from: "truth", or parameters of estimator and noise'
        )
    )
    steering: tuple[tuple[float, tuple[float, float], float, bool], ...] = field(
        metadata=described(
            "(time, (v_x, v_y), turning rate, standing) of every command", "s, m/s, rad/s"
        )
    )
    fate: int = field(metadata=described("how it fell, 0 if it stands; see `worlds.body.plant`"))
    joints: tuple[str, ...] = field(
        metadata=described("names of the motors' joints, in order, shape (m,)")
    )
    knees: tuple[int, int] = field(
        metadata=described("which of them are the left and the right knee")
    )
    motor_positions: Array = field(
        metadata=described("indices of their angles in `position`, shape (m,)")
    )
    motor_dofs: Array = field(metadata=described("likewise of their rates in `velocity`"))
    torque_limit: Array = field(metadata=described("of the motors, shape (m,); may be inf", "N m"))
    speed_limit: Array = field(metadata=described("likewise", "rad/s"))
    position: Array = field(metadata=_rows("f4", "generalised, shape (n, nq)"))
    velocity: Array = field(metadata=_rows("f4", "likewise, shape (n, nv)"))
    told_position: Array = field(
        metadata=_rows("f4", "as the controller was given it; no rows if it was the truth")
    )
    told_velocity: Array = field(metadata=_rows("f4", "likewise"))
    torque: Array = field(metadata=_rows("f4", "what the motors gave, shape (n, m)", "N m"))
    com: Array = field(metadata=_rows("f8", "centre of mass, shape (n, 3)", "m"))
    com_velocity: Array = field(metadata=_rows("f8", "its velocity, shape (n, 3)", "m/s"))
    zmp: Array = field(
        metadata=_rows("f8", "of all forces of the floor, NaN without any, shape (n, 2)", "m")
    )
    sole_position: Array = field(
        metadata=_rows("f8", "centres of the soles, left and right, shape (n, 2, 3)", "m")
    )
    sole_turn: Array = field(
        metadata=_rows("f8", "their roll, pitch and yaw, shape (n, 2, 3)", "rad")
    )
    sole_force: Array = field(
        metadata=_rows("f8", "of the floor on each of them, shape (n, 2, 3)", "N")
    )
    base_turn: Array = field(
        metadata=_rows("f8", "roll, pitch and yaw of the base, shape (n, 3)", "rad")
    )
    phase: Array = field(metadata=_rows("i1", "2 while one foot carries, shape (n,); else both do"))
    support: Array = field(
        metadata=_rows("i1", "0 or 1 for the left or right foot on the ground, shape (n,)")
    )
    steps: Array = field(metadata=_rows("i4", "number of the step, shape (n,)"))
    swing_plan: Array = field(
        metadata=_rows("f8", "reference of the swinging sole, shape (n, 3)", "m")
    )
    course: Array = field(
        metadata=_rows("f8", "where the robot should be, x, y and heading, shape (n, 3)", "m, rad")
    )
    solver: Array = field(
        metadata=_rows("i2", "status of the mapping to joints, 1 or more if it succeeded")
    )
    sense_time: Array = field(
        metadata=_rows("f8", "wall clock of the estimate from the readings, shape (n,)", "s"),
        compare=False,
    )
    physics_time: Array = field(metadata=_rows("f8", "likewise of physics", "s"), compare=False)
    boards: Array = field(
        metadata=described(
            "on the floor, shape (k, 6): x, y and half the sides [m], heading [rad], height [m]"
        ),
        default_factory=lambda: np.zeros((0, 6)),
    )
    mass: float | None = field(
        metadata=described(
            "of all links and the payload; None in files of before it was kept", "kg"
        ),
        default=None,
    )

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

    @property
    def last_command(self) -> tuple[float, tuple[float, float], float] | None:
        """When the last command to walk began [s], its velocity [m/s], and when it ended [s]."""
        walks = (i for i, command in enumerate(self.steering) if not command[3])
        index = max(walks, default=None)
        if index is None or not self.walking.any():
            return None
        begin, commanded = self.steering[index][:2]
        end = self.steering[index + 1][0] if index + 1 < len(self.steering) else math.inf
        return begin, commanded, end

    def held_speed(self, walk: Rollout) -> HeldSpeed | None:
        """The speed that the body held, None if it did not walk for long enough.

        Args:
            walk: whose trace this is.
        """
        last, time = self.last_command, walk.time
        if last is None:
            return None
        begin, commanded, end = last
        own = OwnUnits.of(self.robot)
        # What a push does to the speed is not what is held.
        pushed = [push.end for push in walk.pushes if push.start < min(end, float(time[-1]))]
        first = float(time[np.argmax(self.walking)])
        settled = max([begin, first, *pushed]) + SETTLING * own.time
        begins = [step.start for step in walk.footsteps if settled <= step.start <= end]
        if len(begins) < 3:
            return None
        count = 2 * ((len(begins) - 1) // 2)
        starts = np.searchsorted(time, begins[: count + 1])
        rows = slice(int(starts[0]), int(starts[-1]))
        velocity = rotated_by(self.com_velocity[rows, :2], -self.base_turn[rows, 2]).mean(axis=0)
        slack = CATCHING_UP * own.speed if pushed else 0.0
        return HeldSpeed(
            velocity=(float(velocity[0]), float(velocity[1])),
            commanded=commanded,
            allowed=max(SPEED_PART * math.hypot(*commanded), SPEED_LEAST * own.speed) + slack,
            duration=(begins[count] - begins[0]) / count,
            planned=float(walk.commands["step_duration"][starts[:-1]].mean()),
        )

    def outcome(self, walk: Rollout) -> Outcome:
        """How a walk ended without a fall.

        Args:
            walk: whose trace this is.
        """
        end = float(walk.time[-1])
        begun = [push for push in walk.pushes if push.start < end]
        if walk.held_speed is not None and not walk.held_speed.is_held:
            return Outcome.UNSETTLED
        if not begun:
            return Outcome.WALKED
        on = has_walked_on(walk.robot, walk.footsteps, begun, end)
        return Outcome.RECOVERED if on else Outcome.UNSETTLED

    def fall(self, walk: Rollout) -> BodyFall:
        """Why it fell, of a walk that did.

        Args:
            walk: whose trace this is.
        """
        return find_fall(walk.observations, walk.commands, self)

    def parts(self) -> tuple[dict[str, Any], dict[str, Array]]:
        """The trace as what JSON can hold, and arrays; `trace_of` puts them together again."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
        about = {name: value for name, value in values.items() if name not in arrays}
        for name in ("robot", "believed"):
            about[name] = msgspec.to_builtins(about[name])
        return about, arrays

    def __repr__(self) -> str:
        return f"BodyTrace({self.robot.name!r}, {len(self.phase)} cycles, fate={self.fate})"

    def __eq__(self, other: object) -> bool:
        return type(other) is BodyTrace and all(
            np.array_equal(ours, theirs, equal_nan=True)
            if isinstance(ours := getattr(self, item.name), np.ndarray)
            else ours == theirs
            for item in fields(self)
            if item.compare
            for theirs in [getattr(other, item.name)]
        )

    __hash__ = None  # type: ignore[assignment]


ROWS = {of.name: of.metadata["kind"] for of in fields(BodyTrace) if "kind" in of.metadata}
"""The fields with a row for each cycle, and their types; all others have none."""


def trace_of(about: dict[str, Any], arrays: dict[str, Array]) -> BodyTrace:
    """The trace that `BodyTrace.parts` took apart.

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

"""Where a controller and a simulator (or a robot) meet: Observation in, Command out.

World frame, SI: x forward, y to the left, z up. A controller is a frozen object of parameters;
what evolves is a record that goes through `step` as a value.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum, IntFlag
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from surefoot.geometry import rotated
from surefoot.record import Record, Vector2, Vector3, copy_array, field
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot


class Mode(IntEnum):
    """Which part of a controller is at work."""

    TRACKING = 0
    """The ZMP moves inside the foot so that the DCM follows its plan."""
    ADAPTING = 1
    """Step location and timing are decided anew every cycle."""


class Status(IntFlag):
    """What a decision could not keep; several can hold at once."""

    OK = 0
    OFFSET_VIOLATED = 1
    """The DCM offset at landing leaves its soft bounds, by more than 2e-6 of the longest step."""
    NO_TIME_LEFT = 2
    """The interval of step durations is empty: the step ends now."""
    NO_STEP_LEFT = 4
    """The box of step vectors is empty: its middle is used."""
    UNREACHABLE = 8
    """The swing foot cannot be at the landing in time at its speed limit."""
    ZMP_AT_EDGE = 16
    """The ZMP that tracking asks for lies outside the foot and was projected into it."""
    HELD = 32
    """Some of the observation cannot be true: first the last safe command stands, then the method
    decides on what its model predicts instead. The landing is relative to the foot that carries."""
    NOT_CONVERGED = 64
    """A numerical solver gave no answer in time: see the controller for what it does instead."""


class Observation(Record):
    """What a controller is given in every cycle."""

    time: float = field("s", "now, of any epoch: only differences count")
    elapsed: float = field("s", "since the last touchdown")
    com: Vector2 = field("m", "centre of mass (x, y)")
    com_velocity: Vector2 = field("m/s", "its velocity (x, y)")
    dcm: Vector2 = field("m", "divergent component of motion (x, y)")
    support_foot: Vector2 = field("m", "centre of the sole on the ground (x, y)")
    swing_foot: Vector3 = field("m", "centre of the sole in the air (x, y, z over the ground)")
    swing_foot_velocity: Vector3 = field("m/s", "its velocity", default=(0.0, 0.0, 0.0))
    support_yaw: float = field(
        "rad", "heading of the sole on the ground, counter-clockwise from x", default=0.0
    )
    swing_yaw: float = field("rad", "heading of the other sole", default=0.0)
    trunk_lean: Vector2 = field(
        "rad", "how far the trunk leans towards x and y", default=(0.0, 0.0)
    )
    trunk_lean_velocity: Vector2 = field("rad/s", "and how fast", default=(0.0, 0.0))
    support_side: Side = field("", "which foot is on the ground")


class Command(Record):
    """What a controller demands of the robot until the next cycle."""

    zmp: Vector2 = field("m", "where the ground should push (x, y)")
    dcm_plan: Vector2 = field("m", "DCM of the planned, periodic gait now (x, y)")
    step_location: Vector2 = field("m", "where the swing foot should land (x, y)")
    step_duration: float = field("s", "TOTAL duration of the current step since touchdown")
    dcm_offset: Vector2 = field(
        "m", "DCM expected at landing, relative to the landing foot (x, y)", default=(0.0, 0.0)
    )
    swing_foot: Vector3 = field(
        "m",
        "where the swing foot should be one period from now, or at landing if that comes first "
        "(x, y, z)",
    )
    swing_foot_velocity: Vector3 = field("m/s", "likewise", default=(0.0, 0.0, 0.0))
    swing_foot_acceleration: Vector3 = field("m/s^2", "likewise", default=(0.0, 0.0, 0.0))
    swing_yaw: float = field("rad", "heading of the swing foot, likewise", default=0.0)
    hip_torque: Vector2 = field(
        "N m",
        "on the trunk, leaning it towards x and y; the CoM is pushed the other way",
        default=(0.0, 0.0),
    )
    double_support: int = field(
        "", "1 while the other foot is on the ground too and shares the load", default=0
    )
    mode: Mode = field("", "which part of the controller is at work", default=Mode.TRACKING)
    status: Status = field("", "what the decision could not keep", default=Status.OK)


OBSERVATION, COMMAND = Observation.DTYPE, Command.DTYPE
"""The same for kernels, which know no classes."""


def rotate_record(array: NDArray[np.void], angle: float) -> NDArray[np.void]:
    """An `OBSERVATION` or `COMMAND` record in a frame that is rotated about the origin.

    What has an x and a y is rotated counter-clockwise, and headings are.

    Args:
        array: shape (1,), not changed.
        angle: 0 leaves every bit as it is [rad].
    """
    if angle == 0.0:
        return array
    array = copy_array(array)
    for name in _VECTORS[array.dtype]:
        vector = array[name][0]
        vector[:2] = rotated(vector, angle)
    for name in _HEADINGS[array.dtype]:
        array[name][0] += angle
    return array


_FIELDS = {kind.DTYPE: kind.FIELDS for kind in (Observation, Command)}
_VECTORS = {dtype: [name for name, it in of.items() if it.shape] for dtype, of in _FIELDS.items()}
_HEADINGS = {dtype: [name for name in of if name.endswith("_yaw")] for dtype, of in _FIELDS.items()}


@runtime_checkable
class Controller(Protocol):
    """Anything that decides.

    `kernel` is the compiled function (parameters, state, observation, next_state) -> None over
    records that `step` runs, and `parameters` its first argument; the state's record has a field
    `command`. A controller that cannot be compiled has `kernel = None` and cannot run in a batch.
    """

    @property
    def robot(self) -> Robot:
        """The robot it was made for."""
        ...

    @property
    def gait(self) -> Any:
        """The nominal gait for the commanded velocity, a `dcm.nominal_gait.NominalGait`."""
        ...

    @property
    def period(self) -> float:
        """Control period [s]."""
        ...

    @property
    def kernel(self) -> Callable[..., None] | None:
        """The compiled cycle."""
        ...

    @property
    def parameters(self) -> NDArray[np.void]:
        """The record that `kernel` reads, shape (1,)."""
        ...

    def first_observation(self, support_side: Side | None) -> Observation:
        """What a robot observes that is ready to walk; the foot to stand on first may be chosen."""
        ...

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle."""
        ...

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle. Never raises."""
        ...

    def with_velocity(self, velocity: tuple[float, float]) -> Any:
        """The same controller for another velocity; the state carries over.

        The step under way ends with the new nominal DCM offset, so the plan does not jump.
        """
        ...

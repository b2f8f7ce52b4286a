"""Where a controller and a simulator (or a robot) meet: Observation in, Command out.

World frame, SI: x forward, y to the left, z up. A controller is a frozen object of parameters;
what evolves is a record that goes through `step` as a value.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum, IntFlag
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surefoot.record import Record, fill
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

OBSERVATION = np.dtype(
    [
        ("time", "f8"),
        ("elapsed", "f8"),
        ("com", "f8", (2,)),
        ("com_velocity", "f8", (2,)),
        ("dcm", "f8", (2,)),
        ("support_foot", "f8", (2,)),
        ("swing_foot", "f8", (3,)),
        ("swing_foot_velocity", "f8", (3,)),
        ("support_yaw", "f8"),
        ("swing_yaw", "f8"),
        ("trunk_lean", "f8", (2,)),
        ("trunk_lean_velocity", "f8", (2,)),
        ("support_side", "i8"),
    ],
)

COMMAND = np.dtype(
    [
        ("zmp", "f8", (2,)),
        ("dcm_plan", "f8", (2,)),
        ("step_location", "f8", (2,)),
        ("step_duration", "f8"),
        ("dcm_offset", "f8", (2,)),
        ("swing_foot", "f8", (3,)),
        ("swing_foot_velocity", "f8", (3,)),
        ("swing_foot_acceleration", "f8", (3,)),
        ("swing_yaw", "f8"),
        ("hip_torque", "f8", (2,)),
        ("double_support", "i8"),
        ("mode", "i8"),
        ("status", "i8"),
    ],
)


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
    decides on what its model predicts instead. The landing is relative to the foot believed in."""
    NOT_CONVERGED = 64
    """A numerical solver gave no answer in time: see the controller for what it does instead."""


class Observation(Record):
    """What a controller is told in every cycle.

    Args:
        time: now, of any epoch: only differences count [s].
        elapsed: since the last touchdown [s].
        com: centre of mass (x, y) [m].
        com_velocity: its velocity (x, y) [m/s].
        dcm: divergent component of motion (x, y) [m].
        support_foot: centre of the sole on the ground (x, y) [m].
        support_side: which foot that is.
        swing_foot: centre of the sole in the air (x, y, z over the ground) [m].
        swing_foot_velocity: its velocity [m/s].
        support_yaw: heading of the sole on the ground, counter-clockwise from x [rad].
        swing_yaw: heading of the other sole [rad].
        trunk_lean: how far the trunk leans towards x and y [rad].
        trunk_lean_velocity: and how fast [rad/s].
    """

    __slots__ = ()
    DTYPE = OBSERVATION
    time: float
    elapsed: float
    com: NDArray[np.float64]
    com_velocity: NDArray[np.float64]
    dcm: NDArray[np.float64]
    support_foot: NDArray[np.float64]
    swing_foot: NDArray[np.float64]
    swing_foot_velocity: NDArray[np.float64]
    support_yaw: float
    swing_yaw: float
    trunk_lean: NDArray[np.float64]
    trunk_lean_velocity: NDArray[np.float64]

    @property
    def support_side(self) -> Side:
        """Which foot is on the ground."""
        return Side(int(self.array["support_side"][0]))

    def __init__(
        self,
        *,
        time: float,
        elapsed: float,
        com: ArrayLike,
        com_velocity: ArrayLike,
        dcm: ArrayLike,
        support_foot: ArrayLike,
        support_side: Side,
        swing_foot: ArrayLike,
        swing_foot_velocity: ArrayLike = (0.0, 0.0, 0.0),
        support_yaw: float = 0.0,
        swing_yaw: float = 0.0,
        trunk_lean: ArrayLike = (0.0, 0.0),
        trunk_lean_velocity: ArrayLike = (0.0, 0.0),
    ) -> None:
        fill(self, locals())


class Command(Record):
    """What a controller wants of the robot until the next cycle.

    Attributes:
        zmp: where the ground should push (x, y) [m].
        dcm_plan: DCM of the planned, periodic gait now (x, y) [m].
        step_location: where the swing foot should land (x, y) [m].
        step_duration: TOTAL duration of the current step since touchdown [s].
        dcm_offset: DCM expected at landing, relative to the landing foot (x, y) [m].
        swing_foot: where the swing foot should be one period from now, or at landing if that
            comes first (x, y, z) [m].
        swing_foot_velocity: likewise [m/s].
        swing_foot_acceleration: likewise [m/s^2].
        swing_yaw: heading of the swing foot, likewise [rad].
        hip_torque: on the trunk, leaning it towards x and y; the CoM is pushed the other way [N m].
        double_support: 1 while the other foot is on the ground too and shares the load.
    """

    __slots__ = ()
    DTYPE = COMMAND
    zmp: NDArray[np.float64]
    dcm_plan: NDArray[np.float64]
    step_location: NDArray[np.float64]
    step_duration: float
    dcm_offset: NDArray[np.float64]
    swing_foot: NDArray[np.float64]
    swing_foot_velocity: NDArray[np.float64]
    swing_foot_acceleration: NDArray[np.float64]
    swing_yaw: float
    hip_torque: NDArray[np.float64]
    double_support: int

    @property
    def mode(self) -> Mode:
        """Which part of the controller is at work."""
        return Mode(int(self.array["mode"][0]))

    @property
    def status(self) -> Status:
        """What the decision could not keep."""
        return Status(int(self.array["status"][0]))


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

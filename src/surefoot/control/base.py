"""What controllers share: a robot, a commanded velocity, its nominal gait, and records.

A method on `CompiledController` gives its compiled cycle, the records of its parameters and of its
state, and `make_parameters`; `control/capture_point.py` is a short example.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_most
from surefoot.compiled import entry_point, over_arrays
from surefoot.control.cycle import is_usable
from surefoot.control.fields import check_fields, described, fill_in, setting
from surefoot.control.validation import accept_first
from surefoot.dcm.leg import time_to
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.errors import ParameterError, VelocityError
from surefoot.interface import Command, Observation
from surefoot.record import Record, new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot

ndarray, command_of = np.ndarray, Command.of

LEAST_CYCLES = 4
"""The shortest step has so many control cycles: every method walks with them, and few with less."""


def _check_period(controller: Any) -> None:
    shortest = controller.robot.gait.step_duration[0]
    why = f"a step lasts {shortest:g} s"
    check_most("period", controller.period, shortest / LEAST_CYCLES, "s", why)


def control_period(default: float) -> Any:
    """The setting of the period: short enough for the shortest step of the robot."""
    return setting(default, "s", "control period", above=0.0, kw_only=True, check=_check_period)


@dataclass(frozen=True)
class GaitController:
    """A controller about the nominal gait of a commanded velocity.

    A subclass gives `STATE`, whose fields `plan`, `validated` and `command` are those of
    `control.tracking.TrackingState`, has `make_parameters` and `step`, and overrides `check` as
    needed. Its own fields are made by `setting`.
    """

    STATE: ClassVar[type[Record]]
    NEEDS_LEG: ClassVar[bool] = False
    """Whether a leg that is late in every step of the gait is refused."""
    robot: Robot = field(metadata=described("whose gait it is"))
    velocity: tuple[float, float] = field(metadata=described("commanded (v_x, v_y)", "m/s"))
    _: KW_ONLY
    step_duration: float | None = setting(None, "s", "T_nom, chosen from the velocity if None")
    period: float = control_period(0.001)
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.robot, Robot):
            remedy = 'load one: surefoot.load_robot("paper-biped")'
            raise ParameterError("a Robot", repr(self.robot), remedy)
        check_fields(self)
        self.check()
        object.__setattr__(self, "gait", self.make_gait())
        object.__setattr__(self, "velocity", self.gait.velocity)
        fill_in(self)
        made = self.make_parameters()
        parameters = made.array if isinstance(made, Record) else made
        object.__setattr__(self, "parameters", parameters)

    def check(self) -> None:
        """Refuse settings for more than being outside the range of their field.

        Raises:
            SurefootError: one is refused.
        """

    def make_gait(self) -> NominalGait:
        """The nominal gait.

        Raises:
            VelocityError: the velocity cannot be walked, or not on this leg.
        """
        gait = nominal_gait(self.robot, self.velocity, self.step_duration)
        if self.NEEDS_LEG:
            check_leg(self.robot, gait)
        return gait

    def make_parameters(self) -> Record | NDArray[np.void]:
        """What a cycle reads: a record, or a table of records."""
        raise NotImplementedError(f"{type(self).__name__}.make_parameters")

    @property
    def kernel(self) -> Callable[..., None] | None:
        """None: what is no compiled cycle walks alone and not in a batch."""
        return None

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot on the nominal gait observes at a touchdown; right foot first by default."""
        return self.gait.observation(Side.RIGHT if support_side is None else support_side)

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle: on the nominal gait, standing where it is.

        Raises:
            ParameterError: the observation holds a NaN or an infinity, or no side.
        """
        check_first(observation)
        state, gait, side = new_array(self.STATE.DTYPE), self.gait, observation.support_side
        plan, command = state["plan"][0], state["command"][0]
        plan["support_side"], plan["step_duration"] = side, gait.step_duration
        plan["start_offset"], plan["growth"] = gait.start_offset(side), gait.growth
        plan["end_offset"] = command["dcm_offset"] = gait.dcm_offset(side)
        plan["step"] = gait.step(side)
        command["zmp"] = observation.support_foot
        command["dcm_plan"] = observation.dcm
        command["step_location"] = observation.support_foot + plan["step"]
        command["step_duration"] = gait.step_duration
        command["swing_foot"] = observation.swing_foot
        accept_first(observation, state)
        return state

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity; the state carries over."""
        return replace(self, velocity=velocity)


class _CompiledOnce:
    """The cycle over arrays, compiled when a class is first asked for it, and kept there."""

    def __get__(self, controller: Any, owner: Any) -> Callable[..., None]:
        cycle, arrays = owner._kernels
        kernel = over_arrays(cycle) if arrays is None else arrays
        owner.run = entry_point(kernel, owner.PARAMETERS, owner.STATE, Observation, owner.STATE)
        return owner.run


@dataclass(frozen=True)
class CompiledController(GaitController):
    """A controller whose cycle is a compiled function over records.

    Class arguments of a subclass, or none to inherit them:
        cycle: (parameters, state, observation, next_state) -> None over records.
        parameters: the class of records that it reads.
        state: that of what it remembers, with a field `command`.
        arrays: instead of `cycle`, the same over arrays; it cannot run in a batch then.
    """

    PARAMETERS: ClassVar[type[Record]]
    run: ClassVar[Any] = _CompiledOnce()
    """The cycle over arrays as it is called from Python."""
    _kernels: ClassVar[tuple[Callable[..., None] | None, Callable[..., None] | None]]
    _dtype: ClassVar[np.dtype[np.void]]
    _size: ClassVar[int]

    def __init_subclass__(
        cls,
        *,
        cycle: Callable[..., None] | None = None,
        parameters: type[Record] | None = None,
        state: type[Record] | None = None,
        arrays: Callable[..., None] | None = None,
    ) -> None:
        super().__init_subclass__()
        if parameters is not None and state is not None:
            cls.PARAMETERS, cls.STATE, cls.run = parameters, state, _CompiledOnce()
            cls._dtype, cls._size = state.DTYPE, state.DTYPE.itemsize
            # As a tuple: a compiled function in a class would become a method of its objects.
            cls._kernels = cycle, arrays

    def __post_init__(self) -> None:
        super().__post_init__()
        type(self).run  # noqa: B018 - compiled now rather than in the first control cycle

    @property
    def kernel(self) -> Callable[..., None] | None:
        """The compiled cycle over records; None if it cannot run in a batch."""
        return self._kernels[0]

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        # As `new_array`, but for the call: this runs in every cycle of a robot.
        next_state = ndarray(1, self._dtype, bytearray(self._size))
        self.run(self.parameters, state, observation.array, next_state)
        return command_of(next_state["command"]), next_state


def check_first(observation: Observation) -> None:
    """Refuse a first observation with which no walk can begin.

    Raises:
        ParameterError: it holds a NaN or an infinity, or no side.
    """
    if not is_usable(observation.array[0]):
        raise ParameterError(
            "a first observation of finite numbers and a Side",
            repr(observation),
            "wait for the estimator before starting the controller",
        )


def check_leg(robot: Robot, gait: NominalGait) -> None:
    """Refuse a leg that is late in every step of the gait, for a method that knows it.

    Raises:
        VelocityError: the leg is too slow.
    """
    swing, needed = robot.swing, 0.0
    for axis in range(2):
        stride = abs(gait.step(Side.RIGHT)[axis] + gait.step(Side.LEFT)[axis])
        needed = max(needed, time_to(stride, 0.0, swing.max_speed, swing.max_acceleration))
    if needed > gait.step_duration:
        raise VelocityError(
            f"a leg that swings in the {gait.step_duration:.3g} s of a step at {gait.velocity}",
            f"one that takes {needed:.3g} s",
            "walk more slowly, or give the leg its true speed and acceleration",
        )

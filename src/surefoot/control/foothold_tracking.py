"""Walk over given footholds: their plan, tracked by the ZMP. After [Englsberger2015].

The same cycle as `DcmTracking`, with the parameters of the step under way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.control.belief import hold, look
from surefoot.control.cycle import side_index
from surefoot.control.dcm_tracking import (
    TRACKING_STATE,
    check_tracking,
    first_plan,
    track_step,
    tracking_parameters,
)
from surefoot.control.defaults import DCM_GAIN, fill_in, filled
from surefoot.control.tracking_law import TRACKING
from surefoot.dcm.footholds import Foothold, check_footholds, plan_footholds
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.errors import ParameterError
from surefoot.interface import OBSERVATION, Command, Observation
from surefoot.record import new_array
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot


@njit
def _foothold_step(parameters, state, observation, next_state):
    """One cycle: that of tracking, with the row of the step that this observation is in."""
    if look(parameters[0].gate, state[0], observation[0], next_state[0]):
        hold(state[0], next_state[0])
        return
    plan, count = state[0].plan, parameters.shape[0]
    step = plan.steps + (1 if next_state[0].belief.seen.support_side != plan.support_side else 0)
    if step >= count:
        step = count - 2 + (step - count) % 2
    track_step(parameters[step], state[0], next_state[0])


@cache
def _compiled() -> Callable[..., None]:
    return entry_point(_foothold_step, TRACKING, TRACKING_STATE, OBSERVATION, TRACKING_STATE)


@dataclass(frozen=True)
class FootholdTracking:
    """Footholds as given; disturbances are met by the ZMP alone. Then it steps in place.

    Args:
        robot: whose limits hold.
        footholds: from `load_footholds`, or made by hand; the first two are the feet that stand.
        dcm_gain: K_f, rate at which an error decays; 0.857 omega if None [1/s].
        project_zmp: keep the ZMP inside the support polygon.
        double_support: fraction of a step for which both feet share the load.
        period: control period [s].

    Raises:
        FootholdError: the robot cannot step on them.
        ParameterError: another argument is out of range.
    """

    robot: Robot
    footholds: Sequence[Foothold]
    dcm_gain: float | None = None
    project_zmp: bool = True
    double_support: float = 0.0
    period: float = 0.001
    gait: NominalGait = field(init=False, repr=False)
    parameters: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_tracking(self.robot, self.dcm_gain, self.double_support, self.period)
        fill_in(self, dcm_gain=DCM_GAIN * self.robot.omega)
        object.__setattr__(self, "footholds", tuple(self.footholds))
        check_footholds(self.footholds, self.robot, "footholds")
        object.__setattr__(self, "gait", nominal_gait(self.robot, (0.0, 0.0)))
        object.__setattr__(self, "parameters", self._rows())
        _compiled()  # Now rather than in the first control cycle.

    def _rows(self) -> NDArray[np.void]:
        """`TRACKING` records, one for each step, and two for stepping in place for ever."""
        steps = plan_footholds(self.footholds, self.gait)
        common = tracking_parameters(
            self.robot,
            self.gait,
            filled(self.dcm_gain),
            self.project_zmp,
            self.double_support,
            self.period,
        )
        rows = np.empty(len(steps), TRACKING)
        for k, step in enumerate(steps):
            rows[k] = common[0]
            own = side_index.py_func(step.side)
            following = steps[min(k + 1, len(steps) - 1)]
            rows[k]["step_duration"] = step.duration
            rows[k]["next_step_duration"] = following.duration
            rows[k]["start_offset"][own] = step.start_offset
            rows[k]["start_offset"][1 - own] = step.end_offset
            # Footholds were checked in the axes of the feet; the box of the gait is not theirs.
            rows[k]["step_min"], rows[k]["step_max"] = -np.inf, np.inf
            rows[k]["landing_yaw"] = step.landing_yaw
        return rows

    @property
    def velocity(self) -> tuple[float, float]:
        """That of stepping in place, with which the walk ends (x, y) [m/s]."""
        return self.gait.velocity

    @property
    def kernel(self) -> None:
        """None: its parameters are a table, so it walks alone and not in a batch."""
        return

    def first_observation(self, support_side: Side | None = None) -> Observation:
        """What a robot observes that stands on the first two footholds and begins to walk.

        Raises:
            ParameterError: another foot is asked for than the footholds begin with.
        """
        lifting, standing = self.footholds[:2]
        if support_side not in (None, standing.side):
            raise ParameterError(
                f"the {standing.side.name.lower()} foot, on which these footholds begin",
                f"first_support={support_side}",
                "leave it out",
            )
        foot, other = np.array((standing.x, standing.y)), np.array((lifting.x, lifting.y))
        start = self.parameters[0]["start_offset"][side_index.py_func(standing.side)]
        dcm, com = foot + start, 0.5 * (foot + other)
        return Observation(
            time=0.0,
            elapsed=0.0,
            com=com,
            com_velocity=self.robot.omega * (dcm - com),
            dcm=dcm,
            support_foot=foot,
            support_side=standing.side,
            swing_foot=(*other, 0.0),
            support_yaw=standing.yaw,
            swing_yaw=lifting.yaw,
        )

    def start(self, observation: Observation) -> NDArray[np.void]:
        """The state before the first cycle.

        Raises:
            ParameterError: the observation is not finite.
        """
        state = new_array(TRACKING_STATE)
        first_plan(self.gait, observation, state)
        plan, first = state["plan"][0], self.parameters[0]
        plan["start_offset"] = first["start_offset"][side_index.py_func(observation.support_side)]
        plan["step_duration"] = first["step_duration"]
        plan["growth"] = np.exp(self.robot.omega * first["step_duration"])
        state["command"]["step_duration"] = first["step_duration"]
        return state

    def step(
        self, state: NDArray[np.void], observation: Observation
    ) -> tuple[Command, NDArray[np.void]]:
        """One cycle: what to do now, and the state for the next cycle."""
        next_state = new_array(TRACKING_STATE)
        _compiled()(self.parameters, state, observation.array, next_state)
        return Command.of(next_state["command"]), next_state

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """Not possible: the footholds are given.

        Raises:
            ParameterError: always.
        """
        raise ParameterError(
            "footholds that stay as they are",
            f"a velocity {velocity}",
            "use DcmTracking for speeds",
        )

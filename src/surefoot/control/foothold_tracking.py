"""Walk over given footholds: their plan, tracked by the ZMP. After [Englsberger2015].

The same cycle as `DcmTracking`, with the parameters of the step under way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import njit
from surefoot.control.base import CompiledController
from surefoot.control.cycle import side_index
from surefoot.control.defaults import dcm_gain, double_support
from surefoot.control.fields import described, documented, setting
from surefoot.control.tracking import (
    Tracking,
    TrackingState,
    plan_step,
    track_to_end,
    tracking_parameters,
)
from surefoot.control.validation import validate
from surefoot.dcm.footholds import Foothold, check_footholds, plan_footholds
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.errors import ParameterError
from surefoot.interface import Observation
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot


@njit
def _foothold_step(parameters, state, observation, next_state):
    """One cycle: that of tracking, with the row of the step that this observation is in."""
    state, next_state = state[0], next_state[0]
    if not validate(parameters[0].gate, state, observation[0], next_state):
        return
    plan, count = state.plan, parameters.shape[0]
    now = next_state.validated.observation
    step = plan.steps + (1 if now.support_side != plan.support_side else 0)
    if step >= count:
        step = count - 2 + (step - count) % 2
    new_step, _ = plan_step(parameters[step], state, next_state)
    track_to_end(parameters[step], new_step, state, next_state)


@documented
@dataclass(frozen=True)
class FootholdTracking(
    CompiledController, arrays=_foothold_step, parameters=Tracking, state=TrackingState
):
    """Footholds as given; disturbances are met by the ZMP alone. Then it steps in place.

    Its parameters are a table with a row for each step, so it walks alone and not in a batch.

    Raises:
        FootholdError: the robot cannot step on them.
        ParameterError: another argument is out of range.
    """

    robot: Robot = field(metadata=described("whose limits hold"))
    velocity: tuple[float, float] = field(init=False, repr=False)
    step_duration: float | None = field(init=False, repr=False, default=None)
    footholds: Sequence[Foothold] = field(
        metadata=described(
            "from `load_footholds`, or made by hand; the first two are the feet that stand"
        )
    )
    dcm_gain: float | None = dcm_gain("an error decays")
    project_zmp: bool = setting(True, "", "keep the ZMP inside the support polygon")
    double_support: float = double_support("fraction of a step for which both feet share the load")

    def check(self) -> None:
        """Refuse footholds on which the robot cannot step."""
        object.__setattr__(self, "footholds", tuple(self.footholds))
        check_footholds(self.footholds, self.robot, "footholds")

    def make_gait(self) -> NominalGait:
        """That of stepping in place, with which the walk ends."""
        return nominal_gait(self.robot, (0.0, 0.0))

    def make_parameters(self) -> NDArray[np.void]:
        """`Tracking` records, one for each step, and two for stepping in place for ever."""
        steps = plan_footholds(self.footholds, self.gait)
        common = tracking_parameters(
            self,
            dcm_gain=self.dcm_gain,
            project_zmp=self.project_zmp,
            double_support=self.double_support,
        )
        rows = np.repeat(common.array, len(steps))
        for k, step in enumerate(steps):
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
        """The state before the first cycle, at the first touchdown of the footholds."""
        state = super().start(observation)
        plan, first = state["plan"][0], self.parameters[0]
        plan["start_offset"] = first["start_offset"][side_index.py_func(observation.support_side)]
        plan["step_duration"] = first["step_duration"]
        plan["growth"] = np.exp(self.robot.omega * first["step_duration"])
        state["command"]["step_duration"] = first["step_duration"]
        return state

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

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
from surefoot.control.belief import hold, look
from surefoot.control.cycle import side_index
from surefoot.control.defaults import DCM_GAIN
from surefoot.control.fields import described, documented, setting
from surefoot.control.tracking import (
    TRACKING,
    TRACKING_STATE,
    check_double_support,
    check_gain,
    track_step,
    tracking_parameters,
)
from surefoot.dcm.footholds import Foothold, check_footholds, plan_footholds
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.errors import ParameterError
from surefoot.interface import Observation
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


@documented
@dataclass(frozen=True)
class FootholdTracking(
    CompiledController, arrays=_foothold_step, parameters=TRACKING, state=TRACKING_STATE
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
    dcm_gain: float | None = setting(
        None, "1/s", "K_f, rate at which an error decays; 0.857 omega if None", above=0.0
    )
    project_zmp: bool = setting(True, "", "keep the ZMP inside the support polygon")
    double_support: float = setting(
        0.0, "-", "fraction of a step for which both feet share the load", least=0.0
    )

    def check(self) -> None:
        """Refuse footholds on which the robot cannot step, and what `DcmTracking` refuses."""
        check_gain(self.dcm_gain, self.period)
        check_double_support(self.double_support)
        object.__setattr__(self, "footholds", tuple(self.footholds))
        check_footholds(self.footholds, self.robot, "footholds")

    def make_gait(self) -> NominalGait:
        """That of stepping in place, with which the walk ends."""
        return nominal_gait(self.robot, (0.0, 0.0))

    def defaults(self) -> dict[str, float]:
        """K_f."""
        return {"dcm_gain": DCM_GAIN * self.robot.omega}

    def make_parameters(self) -> NDArray[np.void]:
        """`TRACKING` records, one for each step, and two for stepping in place for ever."""
        steps = plan_footholds(self.footholds, self.gait)
        common = tracking_parameters(
            self.robot,
            self.gait,
            self.dcm_gain,
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

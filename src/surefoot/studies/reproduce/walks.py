"""The walks that [OnlineGait] shows, as it describes them, and what it claims of them.

What the paper leaves out is named here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.control.hybrid import HybridController
from surefoot.control.tracking import DcmTracking
from surefoot.dcm.pushes import Push
from surefoot.interface import Command
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.worlds.point.plant import LipmSimulator
from surefoot.worlds.point.simulate import simulate

REPRODUCED = "reproduced"
UNDER_ASSUMPTIONS = "reproduced under stated assumptions"
NOT_REPRODUCED = "not reproduced"
"""Verdicts."""

VELOCITY = (0.5, 0.0)
"""Of every walk but the second of Fig. 4 [m/s]."""

SECOND_VELOCITY = (1.0, 0.1)
"""Of the second walk of Fig. 4; the paper does not print its two velocities [m/s]."""

DOUBLE_SUPPORT = 0.2
"""Fraction of the step; the paper does not print it [-]."""

SMALL_FORCE = (8.0, 5.0)
"""The small constant push of Figs. 9 and 10; the paper does not print it [N]."""

SMALL_OFFSET_WEIGHT = (100.0, 100.0)
"""The smaller weight on d of Figs. 11 and 12; the paper does not print it [1/m^2]."""

FIG_5_PUSH = Push(0.5, 0.8, (40.0, 0.0))
FIG_8_PUSH = Push(1.0, 0.2, (142.0, 0.0))
FIG_9_PUSH = Push(1.1, 0.2, (176.0, 0.0))
FIG_11_PUSH = Push(1.1, 0.2, (411.6, 0.0))
HEADLINE_PUSH = Push(1.1, 0.2, (425.0, 0.0))
REPLAY_PUSH = Push(1.0, 0.1, (1.0, 0.0))
"""The small push under which the open-loop replay is told apart from numerical noise."""

AXES = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0), "+y": (0.0, 1.0), "-y": (0.0, -1.0)}
"""Directions of pushes as the paper names them; forward is +x, the left +y."""

REPLAY_DURATION = 20.0
"""How long the plan is replayed at most [s]."""


@dataclass(frozen=True)
class Claim:
    """One statement of the paper and what became of it.

    Attributes:
        figure: where the paper makes it.
        text: the situation.
        paper: what the paper reports.
        ours: what is measured.
        verdict: `REPRODUCED`, `UNDER_ASSUMPTIONS` or `NOT_REPRODUCED`.
        why: the assumptions, or the reason for a difference.
    """

    figure: str
    text: str
    paper: str
    ours: str
    verdict: str
    why: str


@cache
def paper_walk(robot: Robot, name: str) -> Rollout:
    """A walk of the paper's figures, by the name of its figure.

    Args:
        robot: the paper's, with the mass that is to be pushed.
        name: of the figure, such as "fig-9".
    """
    method, velocity, duration, pushes, parameters = _WALKS[name]
    return simulate(method(robot, velocity, **parameters), duration, pushes)


_PLANNED: dict[str, Any] = {"project_zmp": False, "double_support": DOUBLE_SUPPORT}
_PROJECTED, _LIGHTER = {"double_support": DOUBLE_SUPPORT}, {"offset_weight": SMALL_OFFSET_WEIGHT}
_SMALL_PUSH = Push(0.0, math.inf, SMALL_FORCE)

_Walk = tuple[type, tuple[float, float], float, tuple[Push, ...], dict[str, Any]]

_WALKS: dict[str, _Walk] = {
    "fig-4a": (DcmTracking, VELOCITY, 4.0, (), _PLANNED),
    "fig-4b": (DcmTracking, SECOND_VELOCITY, 4.0, (), _PLANNED),
    "fig-5": (DcmTracking, VELOCITY, 4.0, (FIG_5_PUSH,), _PLANNED),
    "fig-8": (DcmTracking, VELOCITY, 4.0, (FIG_8_PUSH,), _PLANNED),
    "fig-8-projected": (DcmTracking, VELOCITY, 4.0, (FIG_8_PUSH,), _PROJECTED),
    "fig-9": (HybridController, VELOCITY, 4.0, (FIG_9_PUSH, _SMALL_PUSH), {}),
    "fig-9-without-small-pushes": (HybridController, VELOCITY, 4.0, (FIG_9_PUSH,), {}),
    "fig-11": (HybridController, VELOCITY, 6.0, (FIG_11_PUSH,), _LIGHTER),
    "headline": (HybridController, VELOCITY, 9.3, (HEADLINE_PUSH,), {}),
}
"""Controller, velocity [m/s], duration [s], pushes and settings of every walk."""


@cache
def replay_fall(robot: Robot, double_support: float, pushes: tuple[Push, ...] = ()) -> float:
    """How long the robot stands when the planned ZMP is replayed without feedback.

    The plan is that of an undisturbed walk: zmp_plan = zmp - (1 + K_f / omega) (dcm - dcm_plan),
    the tracking law without its feedback.

    Args:
        robot: that walks.
        double_support: fraction of the step; without it the ZMP rests between touchdowns, so that
            holding it for a control period is exact.
        pushes: forces on the CoM.

    Returns:
        Time of the fall, inf if there is none within `REPLAY_DURATION` [s].
    """
    controller = DcmTracking(robot, VELOCITY, project_zmp=False, double_support=double_support)
    plan = simulate(controller, REPLAY_DURATION)
    gain = float(controller.parameters["zmp_gain"][0])
    commands = plan.commands.copy()
    commands["zmp"] = _planned_zmp(plan, gain)
    simulator = LipmSimulator(robot, controller.period, pushes)
    world = simulator.start(controller.gait.observation(Side.RIGHT))
    for index in range(len(commands) - 1):
        observation, world = simulator.step(world, Command.of(commands[index : index + 1]))
        if world["fallen"][0]:
            return float(observation.time)
    return math.inf


def _planned_zmp(plan: Rollout, gain: float) -> NDArray[np.float64]:
    zmp = plan.zmp - gain * plan.dcm_error
    single = plan.commands["double_support"] == 0
    # Outside transitions the plan rests at the centre of the foot, to the last bit.
    return np.where(single[:, None], plan.support_foot, zmp)

"""Settings that several methods share, and what they are if they are left out.

Then they are given in the robot's own units, so that similar robots decide alike: lengths as parts
of R, see `dcm.nominal_gait.gait_room`, rates as multiples of omega. For the paper's biped at
0.5 m/s R is 0.248 m, tau_nom 5.76 and omega 3.50 1/s, and the values are those of [OnlineGait].
"""

from __future__ import annotations

import math
from typing import Any

from surefoot.checks import check_most
from surefoot.control.fields import Interval, setting, weight
from surefoot.dcm.nominal_gait import NominalGait, gait_room
from surefoot.errors import ParameterError
from surefoot.robot.robot import STANDARD_GRAVITY, Robot

DCM_GAIN = 3.0 / math.sqrt(STANDARD_GRAVITY / 0.8)
"""K_f / omega, 0.857: the paper's 3 1/s on its own biped, whose CoM is at 0.8 m."""

THRESHOLD = 0.1
"""The DCM error at which steps are decided anew, as a part of R: 0.025 m for the paper's biped."""

TAU_WEIGHT = 540.0
"""Weight of (tau - tau_nom)^2 per (R / tau_nom)^2, beside a step weight of 1 [1/m^2]: so the whole
of tau costs as much as 23 R of the step. It is 1 for the paper's biped."""

LEAST_ROOM = 0.01
"""R is taken as no less than this part of the CoM's height; a gait at its limits has none left."""

MAX_DOUBLE_SUPPORT = 0.6
"""The largest fraction of a step for which both feet may share the load."""


def natural_length(robot: Robot, gait: NominalGait) -> float:
    """R with the whole sole, the length by which a robot measures what is much and little [m].

    Raises:
        RobotError: the leg is too slow to step at all.
    """
    return max(gait_room(robot, gait, robot.foot.half), LEAST_ROOM * robot.com_height)


def dcm_gain(effect: str, search: Interval | None = None) -> Any:
    """The setting K_f; `effect` is what happens at that rate."""

    def check(controller: Any) -> None:
        if controller.dcm_gain is not None:
            why = "an error is gone within a period then"
            check_most("dcm_gain", controller.dcm_gain, 1.0 / controller.period, "1/s", why)

    return setting(
        None, "1/s", f"K_f, rate at which {effect}; 0.857 omega if None", above=0.0,
        search=search, own=lambda controller: DCM_GAIN * controller.robot.omega, check=check,
    )  # fmt: skip


def double_support(words: str) -> Any:
    """The setting of how long both feet share the load."""

    def check(controller: Any) -> None:
        if controller.double_support > MAX_DOUBLE_SUPPORT:
            raise ParameterError(
                f"`double_support` of at most {MAX_DOUBLE_SUPPORT} of the step",
                f"{controller.double_support}",
                "people walk with about 0.2",
            )

    return setting(0.0, "-", words, least=0.0, check=check)


def threshold(steps: str, search: Interval | None = None) -> Any:
    """The setting of the DCM error past which steps are decided."""
    words = (
        f"DCM error at which the {steps} decided anew; 0 always, inf never, a tenth of the room of "
        "the gait if None"
    )

    def own(controller: Any) -> float:
        return THRESHOLD * natural_length(controller.robot, controller.gait)

    return setting(None, "m", words, least=0.0, endless=True, search=search, own=own)


def tau_weight(symbol: str, of: str, share: float, search: Interval | None = None) -> Any:
    """The setting a3: it weighs tau by what it is of tau_nom, and a length by what it is of R.

    Args:
        symbol: its words begin with it.
        of: the end of its words.
        share: a3 tau_nom^2 / R^2 [1/m^2].
        search: see `fields.Setting`.
    """

    def own(controller: Any) -> float:
        room = natural_length(controller.robot, controller.gait)
        return share * (room / controller.gait.growth) ** 2

    words = f"{symbol}; {share:g} (R / tau_nom)^2 if None{of}"
    return weight(None, "-", words, own=own, search=search)

"""The unified controller with the landing's time fixed, or its place: what each freedom is worth.

Both are the same controller within a narrower box of steps, so that its idea of what can be saved
is that of the narrower box too.
"""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from typing import Any, Self

import msgspec

from surefoot.control.unified.controller import UnifiedController
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.robot.gait import GaitLimits
from surefoot.robot.robot import Robot

TIME_ROOM, PLACE_ROOM = 0.005, 0.005
"""To either side of the nominal landing: a box has to have some room [s, m]."""


def with_fixed_timing(robot: Robot, gait: NominalGait) -> Robot:
    """The robot whose steps last as long as in a gait, and land where they like.

    Args:
        robot: whose other limits hold.
        gait: the nominal one.
    """
    nominal = gait.step_duration
    limits = msgspec.structs.replace(
        robot.gait, step_duration=(nominal - TIME_ROOM, nominal + TIME_ROOM)
    )
    return robot.replace(gait=limits)


def with_fixed_place(robot: Robot, gait: NominalGait) -> Robot:
    """The robot that steps where a gait does, whenever it likes.

    A step sideways is outward for one foot and inward for the other, so across the box has both.

    Args:
        robot: whose other limits hold.
        gait: the nominal one.
    """
    length, across = gait.step_length, abs(gait.lateral_step) + PLACE_ROOM
    limits: GaitLimits = copy.copy(robot.gait)
    # A file must have room for steps in place; this box is made anew for every velocity.
    msgspec.structs.force_setattr(limits, "step_x", (length - PLACE_ROOM, length + PLACE_ROOM))
    msgspec.structs.force_setattr(limits, "step_y", (-across, across))
    return robot.replace(gait=limits)


@dataclass(frozen=True)
class FixedPlace(UnifiedController):
    """The unified controller of a robot made by `with_fixed_place`: another velocity gets a box of
    its own.
    """

    def with_velocity(self, velocity: tuple[float, float]) -> Self:
        """The same controller for another velocity, with the box around the steps of that."""
        old = self.gait
        duration = old.step_duration
        gait = NominalGait(
            velocity, duration, velocity[0] * duration, velocity[1] * duration, old.hip, old.omega
        )
        return replace(self, robot=with_fixed_place(self.robot, gait), velocity=velocity)


def fixed_timing(
    robot: Robot, velocity: tuple[float, float], **parameters: Any
) -> UnifiedController:
    """The unified controller that cannot choose when it steps.

    Args:
        robot: with all its limits.
        velocity: commanded [m/s].
        **parameters: of `UnifiedController`.

    Raises:
        SurefootError: as `UnifiedController`.
    """
    gait = nominal_gait(robot, velocity)
    return UnifiedController(with_fixed_timing(robot, gait), velocity, **parameters)


def fixed_place(robot: Robot, velocity: tuple[float, float], **parameters: Any) -> FixedPlace:
    """The unified controller that cannot choose where it steps.

    Args:
        robot: with all its limits.
        velocity: commanded [m/s].
        **parameters: of `UnifiedController`.

    Raises:
        SurefootError: as `UnifiedController`.
    """
    gait = nominal_gait(robot, velocity)
    box = with_fixed_place(robot, gait)
    return FixedPlace(box, velocity, step_duration=gait.step_duration, **parameters)

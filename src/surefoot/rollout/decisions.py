"""What a controller had in mind in every cycle of a walk, found out by deciding it all again.

A rollout keeps what was seen and commanded, not why. But states are values and controllers are
deterministic: what was seen gives the same states again, to the bit. So the decisions of a walk
that was saved long ago can still be had, and a walk costs no memory for what nobody asks.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from surefoot.control.unified.problem import DECISION, Decision
from surefoot.errors import ParameterError
from surefoot.interface import Controller, Observation
from surefoot.record import stack
from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout


@runtime_checkable
class Decider(Controller, Protocol):
    """A controller that tells what it decided."""

    def decision(self, state: NDArray[np.void]) -> Decision:
        """What was decided in the cycle that led to this state."""
        ...


def decisions(controller: Controller, rollout: Rollout) -> NDArray[np.void]:
    """The `Decision` of every cycle of a walk.

    Args:
        controller: that walked, made with the same arguments, for the first of its velocities.
        rollout: the walk, fresh or loaded.

    Returns:
        Records with the fields of `Decision`, shape (n,), one for each instant of `rollout.time`;
        `active` holds the bits of `Limit`. Read-only.

    Raises:
        ParameterError: the controller keeps no decisions, or it is not the one that walked: its
            commands differ.
    """
    state = controller.start(controller.first_observation(Side(int(rollout.support_side[0]))))
    if not isinstance(controller, Decider):
        raise ParameterError(
            "a controller that keeps its decisions (UnifiedController)",
            type(controller).__name__,
            "walk with that one",
        )
    pending = list(rollout.velocities[1:])
    found = []
    for cycle, time in enumerate(rollout.time):
        while pending and time >= pending[0][0]:
            controller = controller.with_velocity(pending.pop(0)[1])
        seen = Observation.of(rollout.seen[cycle : cycle + 1])
        command, state = controller.step(state, seen)
        if command.array.tobytes() != rollout.commands[cycle : cycle + 1].tobytes():
            raise ParameterError(
                f"the controller that walked, {rollout.controller}({rollout.controller_parameters})"
                f" at {rollout.velocities[0][1]} m/s",
                f"one that decides otherwise at {time:.3f} s",
                "make it with the same robot, velocity and parameters",
            )
        found.append(controller.decision(state).array)
    return stack(found, DECISION)

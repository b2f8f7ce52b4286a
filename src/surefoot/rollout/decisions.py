"""What a controller decided in every cycle of a walk: taken down on the way, or decided again.

A rollout keeps what was seen and commanded, not why. A `DecisionLog` that watches a walk keeps the
decisions as they are made. And states are values and controllers are
deterministic: what was seen gives the same states again, to the bit. So `decisions` finds those of
a walk that was saved long ago, and a walk costs no memory for decisions that are not needed.
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
    """A controller that keeps its decision in its state."""

    def decision(self, state: NDArray[np.void]) -> Decision:
        """What was decided in the cycle that led to this state."""
        ...


class Deciding(Protocol):
    """What is watched: the world of a walk."""

    @property
    def controller(self) -> Controller:
        """What decides."""
        ...

    @property
    def state(self) -> NDArray[np.void]:
        """The controller's, after its last decision."""
        ...


class DecisionLog:
    """Takes down the `Decision` of every cycle: `simulate(controller, watch=DecisionLog())`."""

    def __init__(self) -> None:
        self._found: list[NDArray[np.void]] = []

    def __call__(self, world: Deciding) -> None:
        """Take down the decision that led to the state of now."""
        decision = getattr(world.controller, "decision", None)
        if decision is not None:
            self._found.append(decision(world.state).array)

    @property
    def records(self) -> NDArray[np.void]:
        """As of `decisions`; empty for a controller that keeps none."""
        return stack(self._found, DECISION)


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
    decider: Decider = controller
    pending = list(rollout.velocities[1:])
    found = []
    for cycle, time in enumerate(rollout.time):
        while pending and time >= pending[0][0]:
            decider = decider.with_velocity(pending.pop(0)[1])
        seen = Observation.of(rollout.seen[cycle : cycle + 1])
        command, state = decider.step(state, seen)
        if command.array.tobytes() != rollout.commands[cycle : cycle + 1].tobytes():
            raise ParameterError(
                f"the controller that walked, {rollout.controller}({rollout.controller_parameters})"
                f" at {rollout.velocities[0][1]} m/s",
                f"one that decides otherwise at {time:.3f} s",
                "make it with the same robot, velocity and parameters",
            )
        found.append(decider.decision(state).array)
    return stack(found, DECISION)

"""The last steps of a walk that fell: kept while it walks, dumped, and walked again to the bit."""

from __future__ import annotations

from collections import deque

from surefoot.errors import ParameterError
from surefoot.rollout.dump import Checkpoint, Dump
from surefoot.rollout.rollout import Rollout, describe
from surefoot.worlds.world import Route, World


class LastSteps:
    """Keeps the states of the last one or two steps, and ends the walk at the first NaN.

    Args:
        world: at the start.
    """

    def __init__(self, world: World) -> None:
        self._kept: deque[tuple[float, Checkpoint, Route]] = deque(maxlen=2)
        self._keep(world)

    def __call__(self, world: World) -> bool:
        """Take in a cycle, and say whether the walk is to end."""
        if world.time - self._kept[-1][0] >= world.controller.gait.step_duration:
            self._keep(world)
        return world.is_nan()

    def _keep(self, world: World) -> None:
        self._kept.append((world.time, world.checkpoint(), world.plan))

    def walked_again(self, world: World, until: float) -> Dump:
        """The earliest state that is kept, and the walk from there on.

        Args:
            world: another one for the same walk, at its start.
            until: when to end [s].
        """
        _, checkpoint, world.plan = self._kept[0]
        world.resume(checkpoint)
        world.run(until, lambda again: again.is_nan())
        world.finish()
        return Dump(world.rollout(), checkpoint)


def walk_again(dump: Dump, world: World) -> Rollout:
    """Walk a dump again, from its first state on.

    Args:
        dump: as `rollout.dump.load_dump` reads it.
        world: made as that of the walk.

    Returns:
        The cycles of `dump.rollout`, to the bit.

    Raises:
        ParameterError: it is not the controller that walked: its commands differ.
    """
    walk, name = dump.rollout, type(world.controller).__name__
    decides = describe(world.controller)
    if name == walk.controller:
        world.resume(dump.checkpoint)
        for _ in walk.time[1:]:
            world.step()
        world.finish()
        found = world.rollout()
        if found.commands.tobytes() == walk.commands.tobytes():
            return found
    raise ParameterError(
        f"the controller that walked, {walk.controller}({walk.controller_parameters})",
        f"one that decides otherwise, {name}({decides})",
        "make it with the same robot, parameters and estimator",
    )

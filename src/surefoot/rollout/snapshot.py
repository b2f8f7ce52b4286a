"""One instant of a walk, as much as a picture of it needs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.dcm.pushes import acting_force
from surefoot.robot.feet import Side
from surefoot.rollout.rollout import Rollout


@dataclass(frozen=True)
class Snapshot:
    """An instant, in the world's frame.

    Attributes:
        observation: an `OBSERVATION` record: what the world did.
        command: the `COMMAND` record that answered it.
        com_height: of the centre of mass over the ground [m].
        force: of all pushes (x, y) [N].
        both_feet: whether the other foot carries too.
        decision_time: how long the answer took [s].
        zmp: of the floor's forces if that is not what was commanded (x, y), NaN in the air [m].
        position: generalised, of a body, shape (nq,); None of a point mass.
    """

    observation: Any
    command: Any
    com_height: float
    force: tuple[float, float]
    both_feet: bool
    decision_time: float
    zmp: tuple[float, float] | None = None
    position: NDArray[np.float64] | None = None

    @property
    def time(self) -> float:
        """When it is [s]."""
        return float(self.observation["time"])

    @property
    def support(self) -> Side:
        """The foot that carries."""
        return Side(int(self.observation["support_side"]))

    @property
    def floor_zmp(self) -> tuple[float, float]:
        """Where the ground pushes (x, y) [m]."""
        x, y = self.command["zmp"] if self.zmp is None else self.zmp
        return float(x), float(y)

    def soles(self) -> NDArray[np.float64]:
        """Centre and heading of both soles, left and right, shape (2, 4) [m, rad]."""
        seen = self.observation
        carrying = (*seen["support_foot"], 0.0, seen["support_yaw"])
        other = (*seen["swing_foot"], seen["swing_yaw"])
        return np.array([carrying, other] if self.support is Side.LEFT else [other, carrying])


def snapshot_of(rollout: Rollout, cycle: int) -> Snapshot:
    """An instant of a finished walk.

    Args:
        rollout: of a point mass or a body.
        cycle: which.
    """
    body, now = rollout.body, float(rollout.time[cycle])
    return Snapshot(
        observation=rollout.observations[cycle],
        command=rollout.commands[cycle],
        com_height=rollout.robot.com_height if body is None else float(body.com[cycle, 2]),
        force=acting_force(rollout.pushes, now),
        both_feet=bool(rollout.commands["double_support"][cycle]),
        decision_time=float(rollout.decision_time[cycle]),
        zmp=None if body is None else (float(body.zmp[cycle, 0]), float(body.zmp[cycle, 1])),
        position=None if body is None else body.position[cycle].astype(np.float64),
    )

"""A finished walk as scenes at equal distances in time, with a sentence and a sample for each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.dcm.frame_turn import rotated
from surefoot.dcm.nominal_gait import NominalGait, nominal_gait
from surefoot.errors import SurefootError
from surefoot.live.sample import SAMPLING, Sample, sample_of
from surefoot.live.story import Story
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot, snapshot_of
from surefoot.show.stances import acting_pushes, gait_at


@dataclass(frozen=True)
class Scenes:
    """A walk from its first cycle to its last, every 20 ms.

    Attributes:
        rollout: the walk.
        robot: the point mass that its controller believed in.
        cycles: of the scenes, shape (n,).
        sentences: what happens, one for each scene.
        samples: for the charts, likewise.
    """

    rollout: Rollout
    robot: Robot
    cycles: np.ndarray
    sentences: tuple[str, ...]
    samples: tuple[Sample, ...]

    def snapshot(self, scene: int) -> Snapshot:
        """What there is to see."""
        return snapshot_of(self.rollout, int(self.cycles[scene]))

    def at(self, time: float) -> int:
        """The last scene that is not later [s]."""
        times = self.rollout.time[self.cycles]
        return max(int(np.searchsorted(times, time + 1e-9, side="right")) - 1, 0)

    def gait(self, scene: int) -> NominalGait:
        """Nominal, for the velocity that was commanded then."""
        return _gait(self.rollout, self.robot, float(self.rollout.time[self.cycles[scene]]))


def scenes_of(rollout: Rollout) -> Scenes:
    """The scenes of a walk, the last cycle among them."""
    robot = rollout.robot if rollout.body is None else rollout.body.believed
    times = np.arange(rollout.time[0], rollout.time[-1], SAMPLING)
    cycles = np.unique(np.append(np.searchsorted(rollout.time, times), len(rollout.time) - 1))
    first = float(rollout.time[0])
    story = Story(_gait(rollout, robot, first), rollout.robot, _velocity(rollout, first))
    pending = sorted(acting_pushes(rollout), key=lambda push: push.start)
    sentences, samples, before = [], [], 0
    for cycle in cycles:
        snapshot = snapshot_of(rollout, int(cycle))
        while pending and pending[0].start <= snapshot.time:
            push = pending.pop(0)
            then = snapshot_of(rollout, max(int(np.searchsorted(rollout.time, push.start)) - 1, 0))
            yaw = float(then.observation["support_yaw"])
            story.pushed(push, math.atan2(push.force[1], push.force[0]) - yaw, then)
        now = snapshot.time
        story.watch(snapshot, _gait(rollout, robot, now), _velocity(rollout, now))
        if rollout.fallen and cycle == cycles[-1]:
            story.fell(rollout)
        sentences.append(story.sentence)
        slowest = float(rollout.decision_time[before : cycle + 1].max())
        samples.append(sample_of(snapshot, slowest))
        before = int(cycle)
    return Scenes(rollout, robot, cycles, tuple(sentences), tuple(samples))


def _gait(rollout: Rollout, robot: Robot, time: float) -> NominalGait:
    if rollout.body is None and _heading(rollout, time) == 0.0:
        return gait_at(rollout, time) or nominal_gait(robot, (0.0, 0.0))
    try:
        return nominal_gait(robot, _velocity(rollout, time))
    except SurefootError:
        return nominal_gait(robot, (0.0, 0.0))


def _velocity(rollout: Rollout, time: float) -> tuple[float, float]:
    """The one that was commanded last, in the robot's own heading [m/s].

    That of a point mass that turns is kept in the world's frame.
    """
    commanded = [velocity for start, velocity in rollout.velocities if start <= time]
    velocity = commanded[-1] if commanded else rollout.velocities[0][1]
    heading = _heading(rollout, time)
    if rollout.body is not None or heading == 0.0:
        return velocity
    x, y = rotated(velocity, -heading)
    return round(x, 6), round(y, 6)


def _heading(rollout: Rollout, time: float) -> float:
    """Of the standing sole [rad]."""
    cycle = int(np.searchsorted(rollout.time, time, side="right")) - 1
    return float(rollout.observations["support_yaw"][max(cycle, 0)])

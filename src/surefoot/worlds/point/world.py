"""A point mass on two feet as a world: sensors, controller and exact motion, cycle by cycle."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from time import perf_counter_ns
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.control.estimator import Estimator
from surefoot.dcm.pushes import Push, acting_force
from surefoot.geometry import rotated
from surefoot.interface import COMMAND, OBSERVATION, Command, Controller, Observation, rotate_record
from surefoot.record import copy_array, new_array, stack
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.rollout.dump import Checkpoint
from surefoot.rollout.outcome import settled_error
from surefoot.rollout.rollout import Rollout, describe
from surefoot.rollout.snapshot import Snapshot
from surefoot.version import VERSION
from surefoot.worlds.point.plant import LipmSimulator
from surefoot.worlds.point.sensors import PointSensors
from surefoot.worlds.steering import Steering
from surefoot.worlds.world import World


class _Row(NamedTuple):
    """A cycle: records of shape (1,), and the time that the answer took [ns]."""

    truth: NDArray[np.void]
    measured: NDArray[np.void]
    answer: NDArray[np.void]
    took: int


class PointWorld(World):
    """A point mass with its controller.

    Turning gives the controller another frame, and a new memory, at every touchdown.

    Args:
        controller: what decides.
        plant: the robot that is moved, if it is not the one that the controller believes in.
        disturbance: of what is measured, and of the landings.
        estimator: between what is measured and the controller.
        start: the first observation; that of the nominal gait if None.
        first_support: the foot that stands in that, the controller's choice if None.
        retained: how much of the past is retained [s].

    Attributes:
        state: of the controller, a record of shape (1,).
        record: of the world, likewise, a `LipmWorld`.
        command: its last one, in the world's frame.

    Raises:
        ParameterError: the delay is no whole number of control periods.
    """

    def __init__(
        self,
        controller: Controller,
        plant: Robot | None = None,
        disturbance: Disturbance | None = None,
        estimator: Estimator | None = None,
        *,
        start: Observation | None = None,
        first_support: Side | None = None,
        retained: float = 60.0,
    ) -> None:
        check_number("retained", retained, 0.0, "s", endless=True)
        plant = plant or controller.robot
        self.robot, self.controller, self._heading = plant, controller, 0.0
        self._about = type(controller).__name__, describe(controller)
        self._disturbance, self._estimator = disturbance, estimator
        self.steering = Steering(controller.gait.velocity)
        self._simulator = LipmSimulator(plant, controller.period, (), disturbance, controller.robot)
        self._sensors = PointSensors(controller, plant, disturbance, estimator)
        observation = start or controller.first_observation(first_support)
        self.record = self._simulator.start(observation)
        self._memory, self._measured = self._sensors.start(), observation
        self.state = controller.start(observation)
        self.command = Command.of(new_array(COMMAND))
        self._took = 0
        self._rows: deque[_Row] = deque(
            maxlen=None if retained == math.inf else math.ceil(retained / controller.period)
        )
        self._velocities = [(0.0, controller.gait.velocity)]

    def _set_pushes(self, pushes: tuple[Push, ...]) -> None:
        self._simulator = replace(self._simulator, pushes=pushes)

    def push_with(self, records: NDArray[np.void]) -> None:
        """Push with `PUSH` records, shape (pushes,), which are not part of a rollout."""
        self._simulator = self._simulator.pushed_by(records)

    @property
    def time(self) -> float:
        """Now [s]."""
        return float(self.record["observation"]["time"][0])

    @property
    def first_time(self) -> float:
        """Of the first cycle that is retained [s]."""
        return float(self._rows[0].truth["time"][0]) if self._rows else 0.0

    @property
    def fallen(self) -> bool:
        """Whether the DCM is out of all reach."""
        return bool(self.record["fallen"][0])

    @property
    def decision_time(self) -> float:
        """How long the last decision took, wall clock [s]."""
        return 1e-9 * self._took

    def has_reached(self, time: float) -> bool:
        """Whether it is this time, or later."""
        return self.time >= time

    def follow(self, steering: Steering, since: float | None = None) -> None:
        """Walk elsewhere, see `World.follow`; a stand is a walk in place."""
        velocity = (0.0, 0.0) if steering.standing else steering.velocity
        if velocity != self.controller.gait.velocity:
            self.controller = self.controller.with_velocity(velocity)
            since = self.time if since is None else since
        if since is not None:
            self._note_velocity(since)
        self.steering = steering

    def observe(self) -> None:
        """Measure the world, and estimate its state."""
        self._measured, self._memory = self._sensors.step(self._memory, self.record, self.command)

    def answer(self) -> None:
        """What the controller answers, in a frame that turns with the steps."""
        observation = Observation.of(rotate_record(self._measured.array, -self._heading))
        before = perf_counter_ns()
        command, self.state = self.controller.step(self.state, observation)
        self._took = perf_counter_ns() - before
        self.command = Command.of(self._in_world(command.array))
        truth = self.record["observation"]
        self._rows.append(_Row(truth, self._measured.array, self.command.array, self._took))

    def act(self) -> None:
        """Move the point mass, exactly."""
        _, self.record = self._simulator.step(self.record, self.command)
        if self.record["observation"]["elapsed"][0] == 0.0:
            self._turn()

    def _in_world(self, command: NDArray[np.void]) -> NDArray[np.void]:
        """The answer in the world, with a foot that turns to the next heading while it swings."""
        answer = rotate_record(command, self._heading)
        if self.steering.turning != 0.0:
            turn = self._turn_of_a_step()
            elapsed = self.record["observation"]["elapsed"][0] + self.controller.period
            part = min(elapsed / max(command["step_duration"][0], self.controller.period), 1.0)
            answer = copy_array(answer)
            answer["swing_yaw"] = self._heading + turn * (2.0 * part - 1.0)
        return answer

    def _turn_of_a_step(self) -> float:
        return self.steering.turning * self.controller.gait.step_duration

    def _turn(self) -> None:
        if self.steering.turning == 0.0 or self.fallen:
            return
        self._heading = float(self.record["observation"]["support_yaw"][0])
        # Its memory is of another frame; at a touchdown it holds little that is needed.
        observation = rotate_record(self.record["observation"], -self._heading)
        self.state = self.controller.start(Observation.of(observation))
        self._note_velocity(self.time)

    def _note_velocity(self, since: float) -> None:
        velocity = rotated(self.controller.gait.velocity, self._heading)
        self._velocities = [*self._retained_velocities(), (since, velocity)]

    def _retained_velocities(self) -> list[tuple[float, tuple[float, float]]]:
        """(time, velocity) in the world, from the first cycle on that is retained [s, m/s]."""
        first = self.first_time
        if first <= 0.0:
            return self._velocities
        before = [velocity for at, velocity in self._velocities if at <= first]
        return [(first, before[-1]), *(one for one in self._velocities if one[0] > first)]

    def finish(self) -> None:
        """The last instant is observed and answered, and the answer is not carried out."""
        self.decide()

    def is_nan(self) -> bool:
        """Whether a number of the last command, or of what came of it, is NaN."""
        records = self.command.array, self.record["observation"]
        return any(np.isnan(one[name]).any() for one in records for name in one.dtype.names or ())

    def checkpoint(self) -> Checkpoint:
        """All that evolves, see `World.checkpoint`: numbers, and records of shape (1,)."""
        return {
            "heading": np.array(self._heading),
            "steering": self.steering.array,
            "velocity": np.array(self.controller.gait.velocity),
            "world": self.record,
            "measured": self._memory,
            "state": self.state,
            "command": self.command.array,
        }

    def resume(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint, see `World.resume`."""
        self._rows.clear()
        self._heading = float(checkpoint["heading"])
        self.steering = Steering.of(checkpoint["steering"])
        self.record, self._memory = checkpoint["world"], checkpoint["measured"]
        self.state, self.command = checkpoint["state"], Command.of(checkpoint["command"])
        v_x, v_y = checkpoint["velocity"].tolist()
        if (v_x, v_y) != self.controller.gait.velocity:
            self.controller = self.controller.with_velocity((v_x, v_y))
        velocity = rotated(self.controller.gait.velocity, self._heading)
        self._velocities = [(self.time, velocity)]

    def _separate(self, recorded: bool) -> None:
        self._rows = self._rows.copy() if recorded else deque(maxlen=0)

    def snapshot(self) -> Snapshot:
        """What a picture of the last cycle needs; an IndexError if none is retained."""
        truth, _, answer, took = self._rows[-1]
        return Snapshot(
            observation=truth[0],
            command=answer[0],
            com_height=self.robot.com_height,
            force=acting_force(self._pushes, float(truth["time"][0])),
            both_feet=bool(answer["double_support"][0]),
            decision_time=1e-9 * took,
        )

    def rollout(self) -> Rollout:
        """The walk so far, or as much of its end as is retained."""
        truth, measured, answers, took = zip(*self._rows, strict=True)
        name, about = self._about
        return Rollout(
            robot=self.robot,
            controller=name,
            controller_parameters=about,
            velocities=tuple(self._retained_velocities()),
            pushes=tuple(push for push in self._pushes if push.end > self.first_time),
            fallen=self.fallen,
            observations=stack(truth, OBSERVATION),
            commands=stack(answers, COMMAND),
            decision_time=np.array(took) * 1e-9,
            seen=stack(measured if self._sensors.active else [], OBSERVATION),
            disturbance=self._disturbance,
            estimator="" if self._estimator is None else describe(self._estimator),
            version=VERSION,
            settled_error=settled_error(self.controller),
        )

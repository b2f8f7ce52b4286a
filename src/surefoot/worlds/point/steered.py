"""A point mass that walks on and on: steered, pushed and looked at while it goes."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter_ns
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.control.estimator import Estimator
from surefoot.dcm.frame_turn import rotated, turned
from surefoot.dcm.pushes import Push
from surefoot.interface import COMMAND, OBSERVATION, Command, Controller, Observation
from surefoot.record import copy_array, new_array, stack
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.description import describe
from surefoot.rollout.disturbance import Disturbance
from surefoot.rollout.outcome import settled_error
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Glimpse, acting_force
from surefoot.version import VERSION
from surefoot.worlds.point.plant import LipmSimulator
from surefoot.worlds.point.sensors import Senses
from surefoot.worlds.steering import Steering

Velocity = tuple[float, tuple[float, float]]
"""When [s], and (v_x, v_y) from then on [m/s]."""


class _Row(NamedTuple):
    """A cycle: records of shape (1,), and the time that the answer took [ns]."""

    truth: NDArray[np.void]
    told: NDArray[np.void]
    answer: NDArray[np.void]
    took: int


class SteeredPoint:
    """The walk of a point mass, cycle by cycle.

    As long as it does not turn it is the walk of `simulate`, to the bit. Turning gives the
    controller another frame, and a new memory, at every touchdown.

    Args:
        controller: what decides.
        plant: the robot that is moved, if it is not the one that the controller believes in.
        disturbance: of what it is told, and of its landings.
        estimator: between what is measured and the controller.
        pushes: that are known beforehand.
        first_support: the foot that stands in the first step, the controller's choice if None.
        kept: how much of the past is kept [s].

    Attributes:
        steering: where it is to go.

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
        pushes: Sequence[Push] = (),
        first_support: Side | None = None,
        kept: float = 60.0,
    ) -> None:
        check_number("kept", kept, 0.0, "s", above=True, endless=True)
        plant = plant or controller.robot
        self._controller, self._heading = controller, 0.0
        self._about = type(controller).__name__, describe(controller)
        self._disturbance, self._estimator = disturbance, estimator
        self.steering = Steering(controller.gait.velocity)
        self._simulator = LipmSimulator(
            plant, controller.period, pushes, disturbance, controller.robot
        )
        self._senses = Senses(controller, plant, disturbance, estimator)
        observation = controller.first_observation(first_support)
        self._world, self._sensed = self._simulator.start(observation), self._senses.start()
        self._state = controller.start(observation)
        self._command = Command.of(new_array(COMMAND))
        self._rows: deque[_Row] = deque(
            maxlen=None if kept == math.inf else math.ceil(kept / controller.period)
        )
        self._pushes = list(pushes)
        self._velocities = [(0.0, controller.gait.velocity)]

    @property
    def robot(self) -> Robot:
        """The one that walks."""
        return self._simulator.robot

    @property
    def controller(self) -> Controller:
        """What decides, for the velocity of now."""
        return self._controller

    @property
    def time(self) -> float:
        """Now [s]."""
        return float(self._world["observation"]["time"][0])

    @property
    def fallen(self) -> bool:
        """Whether the DCM is out of all reach."""
        return bool(self._world["fallen"][0])

    @property
    def decision_time(self) -> float:
        """How long the last answer took [s]."""
        return 1e-9 * self._rows[-1].took if self._rows else 0.0

    def steer(self, steering: Steering) -> None:
        """Walk elsewhere from now on; a stand is a walk in place.

        Raises:
            VelocityError: so fast it cannot walk; it goes on as before.
        """
        velocity = (0.0, 0.0) if steering.standing else steering.velocity
        if velocity != self._controller.gait.velocity:
            self._controller = self._controller.with_velocity(velocity)
            self._note_velocity()
        self.steering = steering

    def push(self, push: Push) -> None:
        """Push it; what has begun in the past acts from now on."""
        oldest = float(self._rows[0].truth["time"][0]) if self._rows else 0.0
        self._pushes = [*(one for one in self._pushes if one.end > oldest), push]
        acting = [one for one in self._pushes if one.end > self.time]
        self._simulator = replace(self._simulator, pushes=acting)

    def step(self) -> None:
        """One cycle; nothing happens to one that has fallen."""
        if not self.fallen:
            self.decide()
            self.move()

    def decide(self) -> None:
        """The first half of a cycle: what it sees, and what it answers."""
        seen, self._sensed = self._senses.step(self._sensed, self._world, self._command)
        told = Observation.of(turned(seen.array, -self._heading))
        before = perf_counter_ns()
        command, self._state = self._controller.step(self._state, told)
        took = perf_counter_ns() - before
        self._command = Command.of(self._in_world(command.array))
        self._rows.append(_Row(self._world["observation"], seen.array, self._command.array, took))

    def move(self) -> None:
        """The second half: what the world does with the answer."""
        _, self._world = self._simulator.step(self._world, self._command)
        if self._world["observation"]["elapsed"][0] == 0.0:
            self._turn()

    def _in_world(self, command: NDArray[np.void]) -> NDArray[np.void]:
        """The answer in the world, with a foot that turns to the next heading while it swings."""
        turn = self._turn_of_a_step()
        answer = turned(command, self._heading)
        if turn != 0.0:
            elapsed = self._world["observation"]["elapsed"][0] + self._controller.period
            part = min(elapsed / max(command["step_duration"][0], self._controller.period), 1.0)
            answer = copy_array(answer)
            answer["swing_yaw"] = self._heading + turn * (2.0 * part - 1.0)
        return answer

    def _turn_of_a_step(self) -> float:
        return self.steering.turning * self._controller.gait.step_duration

    def _turn(self) -> None:
        turn = self._turn_of_a_step()
        if turn == 0.0 or self.fallen:
            return
        self._heading = float(self._world["observation"]["support_yaw"][0])
        # Its memory is of another frame; at a touchdown it holds little that is not seen anew.
        seen = turned(self._world["observation"], -self._heading)
        self._state = self._controller.start(Observation.of(seen))
        self._note_velocity()

    def _note_velocity(self) -> None:
        first = float(self._rows[0].truth["time"][0]) if self._rows else 0.0
        self._velocities = self._velocities_since(first)
        velocity = rotated(self._controller.gait.velocity, self._heading)
        self._velocities.append((self.time, velocity))

    def glimpse(self) -> Glimpse:
        """What there is to see of the last cycle.

        Raises:
            IndexError: there has been none.
        """
        seen, _, answer, took = self._rows[-1]
        now = float(seen["time"][0])
        return Glimpse(
            observation=seen[0],
            command=answer[0],
            com_height=self.robot.com_height,
            force=acting_force(self._simulator.pushes, now),
            both_feet=bool(answer["double_support"][0]),
            decision_time=1e-9 * took,
        )

    def rollout(self, velocities: Sequence[Velocity] | None = None) -> Rollout:
        """The walk so far, or as much of its end as is kept.

        Args:
            velocities: (time, velocity) in the world, if they are known better than from the
                cycles in which they began to hold [s, m/s].
        """
        truth, told, answers, took = zip(*self._rows, strict=True)
        first = float(truth[0]["time"][0])
        name, about = self._about
        return Rollout(
            robot=self.robot,
            controller=name,
            controller_parameters=about,
            velocities=tuple(self._velocities_since(first) if velocities is None else velocities),
            pushes=tuple(push for push in self._pushes if push.end > first),
            fallen=self.fallen,
            observations=stack(truth, OBSERVATION),
            commands=stack(answers, COMMAND),
            decision_time=np.array(took) * 1e-9,
            seen=stack(told if self._senses.active else [], OBSERVATION),
            disturbance=self._disturbance,
            estimator="" if self._estimator is None else describe(self._estimator),
            version=VERSION,
            settled_error=settled_error(self._controller),
        )

    def _velocities_since(self, first: float) -> list[Velocity]:
        before = [velocity for at, velocity in self._velocities if at <= first]
        return [(first, before[-1]), *(one for one in self._velocities if one[0] > first)]

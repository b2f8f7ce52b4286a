"""A body in physics that walks on and on: steered, pushed and looked at while it goes."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter_ns

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.pushes import Push
from surefoot.interface import Controller
from surefoot.robot.multibody import Multibody
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Glimpse, acting_force
from surefoot.rollout.trace import WALKING
from surefoot.worlds.body.estimator import BodyEstimator
from surefoot.worlds.body.plant import STANDS, BodyPlant, Surroundings
from surefoot.worlds.body.recorder import BodyRecorder
from surefoot.worlds.body.recording import make_rollout, senses_words
from surefoot.worlds.body.sensors import BodySight, SenseNoise
from surefoot.worlds.body.truth import commands_in_world, floor_zmp, true_observations
from surefoot.worlds.body.walker import Walker
from surefoot.worlds.steering import Steering


class SteeredBody:
    """The walk of a body, cycle by cycle: that of `simulate_body`, to the bit.

    Args:
        control: walks it.
        surroundings: floor, payload, masses.
        noise: of the sensors; None if they are perfect.
        estimator: makes a state of what they tell; None tells the truth.
        pushes: that are known beforehand.
        kept: how much of the past is kept [s].

    Attributes:
        cycles: how many have passed.
        steering: where it is to go.
    """

    def __init__(
        self,
        control: Walker,
        surroundings: Surroundings | None = None,
        noise: SenseNoise | None = None,
        estimator: BodyEstimator | None = None,
        *,
        pushes: Sequence[Push] = (),
        kept: float = 60.0,
    ) -> None:
        check_number("kept", kept, 0.0, "s", above=True)
        self._control, self._estimator, self._noise = control, estimator, noise
        self._plant = BodyPlant(control.multibody, surroundings, pushes)
        self._sight = BodySight(self._plant, noise, estimator)
        self._state, self._command = control.start(), None
        cycles = max(round(kept / self._plant.model.opt.timestep), 1)
        self._recorder = BodyRecorder(self._plant, self._state, estimator is not None, cycles)
        self.steering = Steering(control.controller.gait.velocity)
        self._route, self._fate, self.cycles = [(0.0, self.steering)], STANDS, 0
        self._took = 0

    @property
    def robot(self) -> Robot:
        """The one that walks."""
        return self._control.multibody.robot

    @property
    def multibody(self) -> Multibody:
        """Its mechanism."""
        return self._control.multibody

    @property
    def controller(self) -> Controller:
        """What decides, for the velocity of now."""
        return self._state.controller

    @property
    def time(self) -> float:
        """Now [s]."""
        return self._plant.time

    @property
    def fallen(self) -> bool:
        """Whether anything but the soles carries it, or its legs have met."""
        return self._fate != STANDS

    @property
    def decision_time(self) -> float:
        """How long the last answer took [s]."""
        return 1e-9 * self._took

    def steer(self, steering: Steering) -> None:
        """Walk elsewhere from the next touchdown on, or come to a stand.

        Raises:
            VelocityError: so fast it cannot walk; it goes on as before.
        """
        if not steering.standing:
            self._control.controller.with_velocity(steering.velocity)
        self.steering = steering
        oldest = self._oldest()
        while len(self._route) > 1 and self._route[1][0] <= oldest:
            self._route.pop(0)
        if self._route[-1][0] >= self.time:
            self._route.pop()
        self._route.append((self.time, steering))

    def push(self, push: Push) -> None:
        """Push its trunk; what has begun in the past acts from now on."""
        # What nobody can ask for any more is forgotten: physics looks at each of them.
        oldest = self._oldest()
        kept = (one for one in self._plant.pushes if one.end > oldest)
        self._plant.pushes = (*kept, push)

    def _oldest(self) -> float:
        """Time of the first cycle that is kept [s]."""
        return max(self.cycles - self._recorder.cycles, 0) * self._plant.model.opt.timestep

    def step(self) -> None:
        """One cycle; nothing happens to one that has fallen."""
        if self.fallen:
            return
        plant, recorder, row = self._plant, self._recorder, self.cycles
        senses = self._sight.read(first=row == 0)
        began = perf_counter_ns()
        position, velocity, forces = self._sight.see(senses, self._state, self._command)
        sensed = perf_counter_ns()
        self._command, self._state = self._control.step(
            self._state, plant.time, position, velocity, forces, self.steering
        )
        decided = perf_counter_ns()
        self._took = decided - sensed
        recorder.see(row, position, velocity)
        recorder.hear(row, self._state, self._command)
        acting = perf_counter_ns()
        plant.act(self._command)
        self._fate = plant.state()
        recorder.feel(row, (began, sensed, decided, perf_counter_ns() - acting))
        self.cycles += 1

    def glimpse(self) -> Glimpse:
        """What there is to see of the last cycle.

        Raises:
            IndexError: there has been none.
        """
        if not self.cycles:
            raise IndexError("no cycle has passed")
        believed = self._control.controller.robot
        # Two cycles: the speed of a foot is a difference.
        record = self._recorder.record(self.cycles, max(self.cycles - 2, 0))
        cycles = np.arange(self.cycles - len(record.clock), self.cycles)
        time = cycles * self._plant.model.opt.timestep
        truth = true_observations(record, time, believed, self.multibody.mass)
        now, com = float(time[-1]), record.state["com"]
        wrenches = [record.effect["left_wrench"], record.effect["right_wrench"]]
        x, y = floor_zmp(com, np.stack(wrenches, axis=1))[-1]
        return Glimpse(
            observation=truth[-1],
            command=commands_in_world(record, truth)[-1],
            com_height=float(com[-1, 2]),
            force=acting_force(self._plant.pushes, now),
            both_feet=bool(record.told["walk"]["phase"][-1] != WALKING),
            decision_time=1e-9 * float(record.clock[-1, 2] - record.clock[-1, 1]),
            zmp=(float(x), float(y)),
            position=record.state["position"][-1].astype(np.float64),
        )

    def rollout(self, route: list[tuple[float, Steering]] | None = None) -> Rollout:
        """The walk so far, or as much of its end as is kept.

        Args:
            route: (time, command) in order of time, if more was planned than has been told [s].
        """
        record = self._recorder.record(self.cycles)
        first = self.cycles - len(record.clock)
        told = senses_words(self._estimator, self._noise)
        route = self._route if route is None else route
        return make_rollout(self._control, self._plant, record, self._fate, route, told, first)

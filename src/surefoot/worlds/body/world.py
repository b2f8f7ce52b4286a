"""A body in physics as a world: sensors, estimate, control and physics, cycle by cycle."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from time import perf_counter_ns
from typing import Self

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.pushes import Push, acting_force
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.bumps import check_course
from surefoot.robot.floor import TIME_STEP
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot
from surefoot.rollout.trace import TRUTH, WALKING
from surefoot.worlds.body.estimator import BodyEstimator
from surefoot.worlds.body.interface import BodyController, JointCommand
from surefoot.worlds.body.plant import STANDS, BodyPlant, Surroundings
from surefoot.worlds.body.recorder import BodyRecorder
from surefoot.worlds.body.recording import (
    commands_in_world,
    floor_zmp,
    make_rollout,
    sensors_words,
    true_observations,
)
from surefoot.worlds.body.sensors import BodyNoise, BodySensors, SensorNoise, usual_estimator
from surefoot.worlds.steering import Steering, course_of
from surefoot.worlds.walk import Walk
from surefoot.worlds.world import Route

USUAL_NOISE = BodyNoise()
"""Stands for `BodyNoise.of` the robot that walks."""


class BodyWorld:
    """A body in physics with its controller, standing on both feet at first.

    Args:
        control: walks it.
        surroundings: floor, payload, masses.
        noise: of the sensors; None if they are perfect.
        estimator: makes a state of what they measure; with None the true state is given.
        retained: how much of the past is retained [s].

    Attributes:
        robot: the one that is moved.
        multibody: its mechanism.
        steering: where it is to go.
        plan: the commands that are to hold later.
        control: walks it.
        state: of that, after the last decision.
        fate: what has become of the robot, see `worlds.body.plant`.
        cycles: how many have passed.
    """

    def __init__(
        self,
        control: BodyController,
        surroundings: Surroundings | None = None,
        noise: SensorNoise | None = None,
        estimator: BodyEstimator | None = None,
        *,
        retained: float = 60.0,
    ) -> None:
        check_number("retained", retained, 0.0, "s")
        self.control, self._estimator, self._noise = control, estimator, noise
        self.multibody, self.robot = control.multibody, control.multibody.robot
        self._plant = BodyPlant(control.multibody, surroundings)
        self._sensors = BodySensors(self._plant, noise, estimator)
        self.state = control.start()
        motors, dofs = len(control.multibody.motors), control.multibody.model.nv
        self._command = JointCommand(motors, dofs)
        self._recorder: BodyRecorder | None = None
        if retained > 0.0:
            cycles = max(round(retained / self._plant.model.opt.timestep), 1)
            self._recorder = BodyRecorder(self._plant, self.state, estimator is not None, cycles)
        self.steering = self._first = Steering(control.controller.gait.velocity)
        self.plan: Route = ()
        self._route: Route = ()
        self.fate, self.cycles = STANDS, 0
        self._began = self._estimated = self._decided = 0

    @property
    def controller(self) -> Controller:
        """What decides, for the velocity of now."""
        return self.state.controller

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The forces on its trunk."""
        return self._plant.pushes

    @pushes.setter
    def pushes(self, pushes: tuple[Push, ...]) -> None:
        self._plant.pushes = pushes

    @property
    def time(self) -> float:
        """Now [s]."""
        return self._plant.time

    @property
    def first_time(self) -> float:
        """Of the first cycle that is retained [s]."""
        retained = self._recorder.cycles if self._recorder else 0
        return max(self.cycles - retained, 0) * self._plant.model.opt.timestep

    @property
    def fallen(self) -> bool:
        """Whether anything but the soles carries it, or its legs have met."""
        return self.fate != STANDS

    @property
    def decision_time(self) -> float:
        """How long the last decision took, wall clock [s]."""
        return 1e-9 * (self._decided - self._estimated)

    def has_reached(self, time: float) -> bool:
        """Whether it is this time, or later, to the nearest cycle."""
        return self.cycles >= round(time / self._plant.model.opt.timestep)

    def steer(self, steering: Steering, since: float | None = None) -> None:
        """Walk elsewhere from the next touchdown on, or come to a stand; see `World.steer`."""
        if not steering.standing:
            self.control.controller.with_velocity(steering.velocity)
        self.steering = steering
        before, first = self._route, self.first_time
        if since is None:
            since = self.time
            before = tuple(one for one in before if one[0] < since)
        gone = sum(time <= first for time, _ in before)
        self._route = (*before[max(gone - 1, 0) :], (since, steering))

    def observe(self) -> None:
        """Measure the body, and estimate its state."""
        readings = self._sensors.measure(first=self.cycles == 0)
        self._began = perf_counter_ns()
        self._estimate = self._sensors.estimate(readings, self.state, self._command)
        self._estimated = perf_counter_ns()

    def decide(self) -> None:
        """What the control answers."""
        position, velocity, forces = self._estimate
        self._command, self.state = self.control.step(
            self.state, self.time, position, velocity, forces, self.steering
        )
        self._decided = perf_counter_ns()
        if self._recorder is not None:
            self._recorder.record_state(self.cycles, position, velocity)
            self._recorder.record_decision(self.cycles, self.state, self._command)

    def act(self) -> None:
        """One cycle of physics."""
        acting = perf_counter_ns()
        self._plant.act(self._command)
        self.fate = self._plant.state()
        if self._recorder is not None:
            took = perf_counter_ns() - acting
            clock = (self._began, self._estimated, self._decided, took)
            self._recorder.record_effect(self.cycles, clock)
        self.cycles += 1

    def fork(self, recorded: bool = True) -> Self:
        """A copy that goes on by itself, with a solver that remembers nothing of this one's.

        A solver that starts from its last answer would make what comes of a fork depend on what was
        done before. See `World.fork`.
        """
        other = copy.copy(self)
        other._plant = self._plant.fork()
        other._sensors = self._sensors.fork(other._plant)
        other.control, other._command = self.control.fresh(), copy.deepcopy(self._command)
        other._recorder = None
        if recorded and self._recorder is not None:
            other._recorder = self._recorder.fork(other._plant)
        return other

    def snapshot(self) -> Snapshot:
        """What a picture of the last cycle needs; an IndexError if none is retained."""
        if not self.cycles or self._recorder is None:
            raise IndexError("no cycle has passed")
        believed = self.control.controller.robot
        # Two cycles: the speed of a foot is a difference.
        record = self._recorder.record(self.cycles, max(self.cycles - 2, 0))
        cycles = np.arange(self.cycles - len(record.clock), self.cycles)
        time = cycles * self._plant.model.opt.timestep
        truth = true_observations(record, time, believed, self.multibody.mass)
        now, com = float(time[-1]), record.state["com"]
        wrenches = [record.effect["left_wrench"], record.effect["right_wrench"]]
        x, y = floor_zmp(com, np.stack(wrenches, axis=1))[-1]
        return Snapshot(
            observation=truth[-1],
            command=commands_in_world(record, truth)[-1],
            com_height=float(com[-1, 2]),
            force=acting_force(self.pushes, now),
            both_feet=bool(record.decision["walk"]["phase"][-1] != WALKING),
            decision_time=1e-9 * float(record.clock[-1, 2] - record.clock[-1, 1]),
            zmp=(float(x), float(y)),
            position=record.state["position"][-1].astype(np.float64),
        )

    def rollout(self) -> Rollout:
        """The walk so far, or as much of its end as is retained; an IndexError if nothing is."""
        if self._recorder is None:
            raise IndexError("no cycle is retained")
        record = self._recorder.record(self.cycles)
        first = self.cycles - len(record.clock)
        measured = sensors_words(self._estimator, self._noise)
        route = [*self._route, *self.plan]
        if not route or route[0][0] > 0.0:
            route.insert(0, (0.0, self._first))
        return make_rollout(self.control, self._plant, record, self.fate, route, measured, first)


def simulate_body(
    control: BodyController,
    duration: float = 10.0,
    pushes: Sequence[Push] = (),
    *,
    steering: Sequence[tuple[float, Steering]] = (),
    surroundings: Surroundings | None = None,
    noise: SensorNoise | None = USUAL_NOISE,
    estimator: BodyEstimator | str | None = None,
    watch: Callable[[BodyWorld], None] | None = None,
) -> Rollout:
    """Walk a body in physics, from a stand on both feet.

    Args:
        control: what walks it.
        duration: how long [s]; a fall ends the walk early.
        pushes: forces on the base, or on `Body.trunk`, at its centre of mass.
        steering: (time, command) in order of time [s]; before the first one, and if there is none,
            the robot walks at its controller's velocity.
        surroundings: floor, bumps, payload, masses.
        noise: of the sensors, `BodyNoise.of` the robot unless given; they are perfect if None.
        estimator: makes a state of what the sensors measure; if None a `BodyEstimator` that knows
            how late and how noisy the sensors of a `BodyNoise` are. With "truth" the true state is
            given instead.
        watch: called after every decision with the world, whose `control` and `state` are those of
            that cycle.

    Returns:
        The rollout; its `body` is the trace of the mechanism.

    Raises:
        ParameterError: the duration is not positive and finite, the steering not in order, or
            there is noise but no estimator, the payload weighs more than the body, or there are
            bumps and the course leaves them.
        VelocityError: one of the velocities cannot be walked; raised before the walk begins.
    """
    check_number("duration", duration, 0.0, "s", above=True)
    plan = _plan_of(control, steering)
    if surroundings is not None and surroundings.bumps > 0.0:
        check_course(course_of(plan, duration))
    if estimator == TRUTH and noise not in (None, USUAL_NOISE):
        raise ParameterError(
            "noise with an estimator: the true state has none",
            f"estimator={TRUTH!r} and {noise!r}",
            "leave one of them out",
        )
    if noise is USUAL_NOISE:
        noise = BodyNoise.of(control.multibody.robot)
    estimates = _estimator(control, noise, estimator)
    world = BodyWorld(
        control, surroundings, None if estimates is None else noise, estimates,
        retained=(round(duration / TIME_STEP) + 1) * TIME_STEP,
    )  # fmt: skip
    walk = Walk(world, pushes, plan, watch)
    walk.run(duration)
    # The cycle that begins at the end of the duration is part of it.
    walk.step()
    return walk.rollout()


def _plan_of(
    control: BodyController, steering: Sequence[tuple[float, Steering]]
) -> list[tuple[float, Steering]]:
    """All commands from the start on, checked."""
    times = [time for time, _ in steering]
    if times != sorted(times):
        raise ParameterError("steering in order of time", f"{list(steering)!r}", "sort it")
    plan = list(steering)
    if not plan or plan[0][0] > 0.0:
        plan.insert(0, (0.0, Steering(control.controller.gait.velocity)))
    for _, command in plan:
        if not command.standing:
            control.controller.with_velocity(command.velocity)
    return plan


def _estimator(
    control: BodyController, noise: SensorNoise | None, estimator: BodyEstimator | str | None
) -> BodyEstimator | None:
    if isinstance(estimator, str) and estimator != TRUTH:
        raise ParameterError(
            f"an estimator, or {TRUTH!r} for the true state",
            repr(estimator),
            "leave it out for an estimate from the sensors",
        )
    if isinstance(estimator, str):
        return None
    return estimator or usual_estimator(control.multibody, noise)

"""A body in physics as a world: sensors, estimate, control and physics, cycle by cycle."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from pathlib import Path
from time import perf_counter_ns

import numpy as np

from surefoot.checks import check_number
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError
from surefoot.robot.floor import TIME_STEP, check_course
from surefoot.rollout.dump import Checkpoint, Dump, check_dump_path, write_dump
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.snapshot import Snapshot, snapshot_of
from surefoot.rollout.trace import TRUTH
from surefoot.worlds.body.checkpoint import (
    control_arrays,
    plant_arrays,
    sensor_arrays,
    set_control,
    set_plant,
    set_sensors,
)
from surefoot.worlds.body.controller import BodyControl
from surefoot.worlds.body.estimator import BodyEstimator
from surefoot.worlds.body.interface import BodyController, JointCommand
from surefoot.worlds.body.plant import STANDS, BodyPlant, Surroundings
from surefoot.worlds.body.recording import BodyRecorder, make_rollout, sensors_words
from surefoot.worlds.body.sensors import BodyNoise, BodySensors, SensorNoise, usual_estimator
from surefoot.worlds.last_steps import LastSteps, walk_again
from surefoot.worlds.steering import Steering, course_of
from surefoot.worlds.world import Route, World

USUAL_NOISE = BodyNoise()
"""Stands for `BodyNoise.of` the robot that walks."""


class BodyWorld(World):
    """A body in physics with its controller, standing on both feet at first.

    Args:
        control: walks it.
        surroundings: floor, payload, masses.
        noise: of the sensors; None if they are perfect.
        estimator: makes a state of what they measure; with None the true state is given.
        retained: how much of the past is retained [s].

    Attributes:
        multibody: the mechanism of the robot.
        control: walks it.
        state: of that, after the last decision.
        fate: how the robot fell, see `worlds.body.plant`.
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
        self.controller = self.state.controller
        motors, dofs = len(control.multibody.motors), control.multibody.model.nv
        self._command = JointCommand(motors, dofs)
        self._recorder: BodyRecorder | None = None
        if retained > 0.0:
            cycles = max(round(retained / self._plant.model.opt.timestep), 1)
            self._recorder = BodyRecorder(self._plant, self.state, estimator is not None, cycles)
        self.steering = self._first = Steering(control.controller.gait.velocity)
        self._route: Route = ()
        self.fate, self.cycles, self._first_cycle = STANDS, 0, 0
        self._began = self._estimated = self._decided = 0

    def _set_pushes(self, pushes: tuple[Push, ...]) -> None:
        self._plant.pushes = pushes

    @property
    def time(self) -> float:
        """Now [s]."""
        return self._plant.time

    @property
    def first_time(self) -> float:
        """Of the first cycle that is retained [s]."""
        retained = self._recorder.cycles if self._recorder else 0
        first = max(self.cycles - retained, self._first_cycle)
        return first * self._plant.model.opt.timestep

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

    def follow(self, steering: Steering, since: float | None = None) -> None:
        """Walk elsewhere from the next touchdown on, or come to a stand; see `World.follow`."""
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

    def answer(self) -> None:
        """What the control decides."""
        position, velocity, forces = self._estimate
        self._command, self.state = self.control.step(
            self.state, self.time, position, velocity, forces, self.steering
        )
        self._decided = perf_counter_ns()
        self.controller = self.state.controller
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

    def is_nan(self) -> bool:
        """Whether a torque, or what came of them, is NaN."""
        return bool(np.isnan(self._plant.torque).any() or np.isnan(self._plant.position).any())

    def checkpoint(self) -> Checkpoint:
        """All that evolves, see `World.checkpoint`; of a `BodyControl` and `BodyNoise` only."""
        return {
            "steering": self.steering.array,
            **plant_arrays(self._plant),
            **sensor_arrays(self._sensors),
            **control_arrays(self.state, self._command),
        }

    def resume(self, checkpoint: Checkpoint) -> None:
        """Go on from a checkpoint, see `World.resume`, with a solver that remembers nothing."""
        set_plant(self._plant, checkpoint)
        set_sensors(self._sensors, checkpoint)
        self.control = self.control.fresh()
        self.state = set_control(self.control.controller, self._command, checkpoint)
        self.controller = self.state.controller
        self.cycles = self._first_cycle = self._plant.cycle
        self.steering = Steering.of(checkpoint["steering"])
        self._route = ((self.time, self.steering),)

    def _separate(self, recorded: bool) -> None:
        # A solver that starts from its last answer would make what comes of a fork depend on what
        # was done before.
        self._plant = self._plant.fork()
        self._sensors = self._sensors.fork(self._plant)
        self.control, self._command = self.control.fresh(), copy.deepcopy(self._command)
        recorder, self._recorder = self._recorder, None
        if recorded and recorder is not None:
            self._recorder = recorder.fork(self._plant)

    def snapshot(self) -> Snapshot:
        """What a picture of the last cycle needs; an IndexError if none is retained."""
        # Of two cycles: the speed of a foot is a difference.
        return snapshot_of(self._rollout(2), -1)

    def rollout(self) -> Rollout:
        """The walk so far, or as much of its end as is retained; an IndexError if nothing is."""
        return self._rollout(self.cycles)

    def _rollout(self, cycles: int) -> Rollout:
        """The last cycles, as far as they are retained."""
        if self._recorder is None or self.cycles == self._first_cycle:
            raise IndexError("no cycle is retained")
        record = self._recorder.record(self.cycles, max(self.cycles - cycles, self._first_cycle))
        first = self.cycles - len(record["clock"])
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
    dump: str | Path | None = None,
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
        dump: a file, ending in .npz, that is written if the robot falls or a number is NaN: the
            last one or two steps, walked again from all states at their beginning, for
            `replay_body`. The solver remembers nothing of what was before, so in its last digits
            the end may differ from that of the walk.

    Returns:
        The rollout; its `body` is the trace of the mechanism.

    Raises:
        ParameterError: the duration is not positive and finite, the steering not in order, or
            there is noise but no estimator, the payload weighs more than the body, or there are
            bumps and the course leaves them, or control or noise are none that can be dumped.
        VelocityError: one of the velocities cannot be walked; raised before the walk begins.
        FileError: the dump cannot be written.
    """
    check_number("duration", duration, 0.0, "s", above=True)
    plan = _plan_of(control, steering)
    if surroundings is not None and surroundings.bumps > 0.0:
        check_course(course_of(plan, duration))
    noise, estimates = _sensing(control, noise, estimator)
    if dump is not None:
        check_dump_path(Path(dump))
        _check_dumped(control, noise)

    def begin() -> BodyWorld:
        retained = (round(duration / TIME_STEP) + 1) * TIME_STEP
        world = BodyWorld(control, surroundings, noise, estimates, retained=retained)
        return world.prepare(pushes, plan, watch)

    world = begin()
    steps = None if dump is None else LastSteps(world)
    world.run(duration, steps)
    # The cycle that begins at the end of the duration is part of it.
    world.finish()
    rollout = world.rollout()
    if dump is not None and steps is not None and (world.fallen or world.is_nan()):
        write_dump(Path(dump), steps.walked_again(begin().prepare(pushes), duration))
    return rollout


def replay_body(
    dump: Dump,
    control: BodyControl,
    *,
    surroundings: Surroundings | None = None,
    noise: SensorNoise | None = USUAL_NOISE,
    estimator: BodyEstimator | str | None = None,
) -> Rollout:
    """Walk a dump of a body again, from its first state on.

    Args:
        dump: as `rollout.dump.load_dump` reads it.
        control: that walked, made with the same arguments.
        surroundings, noise, estimator: as they were given to `simulate_body`.

    Returns:
        The cycles of `dump.rollout`, to the bit.

    Raises:
        ParameterError: it is not the control that walked: its commands differ.
    """
    walk, (noise, estimates) = dump.rollout, _sensing(control, noise, estimator)
    retained = (len(walk.time) + 1) * TIME_STEP
    world = BodyWorld(control, surroundings, noise, estimates, retained=retained)
    steering = () if walk.body is None else walk.body.steering
    plan = [(at, Steering(to, turning, standing)) for at, to, turning, standing in steering[1:]]
    return walk_again(dump, world.prepare(walk.pushes, plan))


def _check_dumped(control: BodyController, noise: SensorNoise | None) -> None:
    """Refuse what has a state that no dump can hold."""
    for one, kind in ((control, BodyControl), (noise, BodyNoise)):
        if one is not None and not isinstance(one, kind):
            raise ParameterError(f"a {kind.__name__}, to be dumped", repr(one), "leave `dump` out")


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


def _sensing(
    control: BodyController, noise: SensorNoise | None, estimator: BodyEstimator | str | None
) -> tuple[SensorNoise | None, BodyEstimator | None]:
    """Noise and estimator of a walk, None where there is none."""
    if estimator == TRUTH and noise not in (None, USUAL_NOISE):
        raise ParameterError(
            "noise with an estimator: the true state has none",
            f"estimator={TRUTH!r} and {noise!r}",
            "leave one of them out",
        )
    if isinstance(estimator, str) and estimator != TRUTH:
        raise ParameterError(
            f"an estimator, or {TRUTH!r} for the true state",
            repr(estimator),
            "leave it out for an estimate from the sensors",
        )
    if isinstance(estimator, str):
        return None, None
    if noise is USUAL_NOISE:
        noise = BodyNoise.of(control.multibody.robot)
    return noise, estimator or usual_estimator(control.multibody, noise)

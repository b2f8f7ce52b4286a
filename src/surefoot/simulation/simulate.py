"""Run a controller in a world and keep everything that happened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from time import perf_counter_ns
from typing import Any

import numpy as np

from surefoot.checks import check_number
from surefoot.errors import ParameterError
from surefoot.models.estimator import Estimator
from surefoot.models.footsteps import Side
from surefoot.models.interfaces import COMMAND, OBSERVATION, Command, Controller
from surefoot.models.pushes import Push
from surefoot.models.record import new_array, stack
from surefoot.models.robot import Robot
from surefoot.simulation.disturbance import Disturbance
from surefoot.simulation.lipm_simulator import LipmSimulator
from surefoot.simulation.rollout import Rollout
from surefoot.simulation.senses import Senses
from surefoot.version import VERSION


def simulate(
    controller: Controller,
    duration: float = 6.0,
    pushes: Sequence[Push] = (),
    *,
    velocity_changes: Sequence[tuple[float, tuple[float, float]]] = (),
    first_support: Side | None = None,
    plant: Robot | None = None,
    disturbance: Disturbance | None = None,
    estimator: Estimator | None = None,
) -> Rollout:
    """Walk on the linear inverted pendulum, starting on the nominal gait.

    Args:
        controller: what decides, every `controller.period`.
        duration: how long to walk [s]; a fall ends the walk early.
        pushes: forces on the CoM.
        velocity_changes: (time, (v_x, v_y)): new commands, in order of time [s, m/s].
        first_support: the foot that stands in the first step, the controller's choice if None.
        plant: the robot that is moved, if it is not the one the controller believes in. If its
            height is another one, the controller is told a DCM that is made of CoM and velocity
            with the frequency that it believes in.
        disturbance: noise, delay and offset of what the controller is told, and errors of landing.
        estimator: between what is measured and the controller.

    Returns:
        The rollout.

    Raises:
        ParameterError: the duration is not positive and finite, the changes are not in order, or
            the delay is no whole number of control periods.
        VelocityError: one of the velocities cannot be walked; told before the walk begins.
    """
    check_number("duration", duration, 0.0, "s", above=True)
    times = [time for time, _ in velocity_changes]
    if times != sorted(times):
        raise ParameterError(
            "velocity changes in order of time", f"{list(velocity_changes)!r}", "sort them"
        )
    pending = [(time, controller.with_velocity(velocity)) for time, velocity in velocity_changes]
    plant = plant or controller.robot
    simulator = LipmSimulator(plant, controller.period, pushes, disturbance)
    senses = Senses(controller, plant, disturbance, estimator)
    velocities = [(0.0, controller.gait.velocity)]
    about = describe(controller)
    name = type(controller).__name__

    observation = controller.first_observation(first_support)
    world, sensed = simulator.start(observation), senses.start()
    state, command = controller.start(observation), Command.of(new_array(COMMAND))
    truth, told, commands, decision_times = [], [], [], []
    while True:
        observation, sensed = senses.step(sensed, world, command)
        now = world["observation"]["time"][0]
        while pending and now >= pending[0][0]:
            time, controller = pending.pop(0)
            velocities.append((time, controller.gait.velocity))
        before = perf_counter_ns()
        command, state = controller.step(state, observation)
        decision_times.append(perf_counter_ns() - before)
        truth.append(world["observation"])
        told.append(observation.array)
        commands.append(command.array)
        if now >= duration or world["fallen"][0]:
            break
        _, world = simulator.step(world, command)
    return Rollout(
        robot=simulator.robot,
        controller=name,
        controller_parameters=about,
        velocities=tuple(velocities),
        pushes=tuple(pushes),
        fallen=bool(world["fallen"][0]),
        observations=stack(truth, OBSERVATION),
        commands=stack(commands, COMMAND),
        decision_time=np.array(decision_times) * 1e-9,
        seen=stack(told if senses.active else [], OBSERVATION),
        disturbance=disturbance,
        estimator="" if estimator is None else describe(estimator),
        version=VERSION,
    )


def describe(value: Any) -> str:
    """The parameters of a controller or an estimator as text, but for robot and velocity."""
    parts = []
    for parameter in fields(value):
        if parameter.init and parameter.name not in ("robot", "velocity", "multibody"):
            parts.append(f"{parameter.name}={getattr(value, parameter.name)!r}")
    return ", ".join(parts)

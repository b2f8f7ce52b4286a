"""Run a controller in a world and keep everything that happened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from time import perf_counter_ns

import numpy as np

from surefoot.checks import check_number
from surefoot.errors import ParameterError
from surefoot.models.footsteps import Side
from surefoot.models.interfaces import COMMAND, OBSERVATION, Controller
from surefoot.models.pushes import Push
from surefoot.models.record import stack
from surefoot.models.robot import Robot
from surefoot.simulation.lipm_simulator import LipmSimulator
from surefoot.simulation.rollout import Rollout
from surefoot.version import VERSION


def simulate(
    controller: Controller,
    duration: float = 6.0,
    pushes: Sequence[Push] = (),
    *,
    velocity_changes: Sequence[tuple[float, tuple[float, float]]] = (),
    first_support: Side | None = None,
    plant: Robot | None = None,
) -> Rollout:
    """Walk on the linear inverted pendulum, starting on the nominal gait.

    Args:
        controller: what decides, every `controller.period`.
        duration: how long to walk [s]; a fall ends the walk early.
        pushes: forces on the CoM.
        velocity_changes: (time, (v_x, v_y)): new commands, in order of time [s, m/s].
        first_support: the foot that stands in the first step, the controller's choice if None.
        plant: the robot that is moved, if it is not the one the controller believes in.

    Returns:
        The rollout.

    Raises:
        ParameterError: the duration is not positive and finite, or the changes are not in order.
        VelocityError: one of the velocities cannot be walked; told before the walk begins.
    """
    check_number("duration", duration, 0.0, "s", above=True)
    times = [time for time, _ in velocity_changes]
    if times != sorted(times):
        raise ParameterError(
            "velocity changes in order of time", f"{list(velocity_changes)!r}", "sort them"
        )
    pending = [(time, controller.with_velocity(velocity)) for time, velocity in velocity_changes]
    simulator = LipmSimulator(plant or controller.robot, controller.period, pushes)
    velocities = [(0.0, controller.gait.velocity)]
    about = describe(controller)
    name = type(controller).__name__

    observation = controller.first_observation(first_support)
    world = simulator.start(observation)
    state = controller.start(observation)
    observations, commands, decision_times = [], [], []
    while True:
        while pending and observation.array["time"][0] >= pending[0][0]:
            time, controller = pending.pop(0)
            velocities.append((time, controller.gait.velocity))
        before = perf_counter_ns()
        command, state = controller.step(state, observation)
        decision_times.append(perf_counter_ns() - before)
        observations.append(observation.array)
        commands.append(command.array)
        if observation.array["time"][0] >= duration or world["fallen"][0]:
            break
        observation, world = simulator.step(world, command)
    return Rollout(
        robot=simulator.robot,
        controller=name,
        controller_parameters=about,
        velocities=tuple(velocities),
        pushes=tuple(pushes),
        fallen=bool(world["fallen"][0]),
        observations=stack(observations, OBSERVATION),
        commands=stack(commands, COMMAND),
        decision_time=np.array(decision_times) * 1e-9,
        version=VERSION,
    )


def describe(controller: Controller) -> str:
    """The parameters of a controller as text: those that differ from robot and velocity."""
    parts = []
    for parameter in fields(controller):  # type: ignore[arg-type]
        if parameter.init and parameter.name not in ("robot", "velocity"):
            parts.append(f"{parameter.name}={getattr(controller, parameter.name)!r}")
    return ", ".join(parts)

"""Run a controller in a world and keep everything that happened."""

from __future__ import annotations

import math
from collections.abc import Sequence

from surefoot.checks import check_number
from surefoot.control.estimator import Estimator
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.rollout.rollout import Rollout
from surefoot.worlds.point.steered import SteeredPoint
from surefoot.worlds.steering import Steering


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
    # What cannot be walked is told before the walk begins.
    for _, velocity in velocity_changes:
        controller.with_velocity(velocity)
    walk = SteeredPoint(
        controller, plant, disturbance, estimator,
        pushes=pushes, first_support=first_support, kept=math.inf,
    )  # fmt: skip
    velocities, pending = [(0.0, controller.gait.velocity)], list(velocity_changes)
    while True:
        while pending and walk.time >= pending[0][0]:
            time, velocity = pending.pop(0)
            walk.steer(Steering(velocity))
            velocities.append((time, walk.controller.gait.velocity))
        walk.decide()
        if walk.time >= duration or walk.fallen:
            return walk.rollout(velocities)
        walk.move()

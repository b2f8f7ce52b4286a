"""Walks of a point mass from Python: from the start, and again from a dump of their last states."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

from surefoot.checks import check_number
from surefoot.control.estimator import Estimator
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.robot.robot import Robot
from surefoot.rollout.disturbance import Disturbance
from surefoot.rollout.dump import Dump, check_dump_path, write_dump
from surefoot.rollout.rollout import Rollout
from surefoot.worlds.last_steps import LastSteps, walk_again
from surefoot.worlds.point.world import PointWorld
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
    watch: Callable[[PointWorld], None] | None = None,
    dump: str | Path | None = None,
) -> Rollout:
    """Walk on the linear inverted pendulum, starting on the nominal gait.

    Args:
        controller: what decides, every `controller.period`.
        duration: how long to walk [s]; a fall ends the walk early.
        pushes: forces on the CoM.
        velocity_changes: (time, (v_x, v_y)): new commands, in order of time [s, m/s].
        first_support: the foot that stands in the first step, the controller's choice if None.
        plant: the robot that is moved, if it is not the one the controller believes in. If its
            height is another one, the controller is given a DCM that is made of CoM and velocity
            with the frequency that it believes in.
        disturbance: noise, delay and offset of what is measured, and errors of landing.
        estimator: between what is measured and the controller.
        watch: called after every decision with the world, whose `controller`, `state` and `command`
            are those of that cycle.
        dump: a file, ending in .npz, that is written if the robot falls or a number is NaN, where
            the walk ends then: the last one or two steps with all states, to be walked again by
            `replay`.

    Returns:
        The rollout.

    Raises:
        ParameterError: the duration is not positive and finite, the changes are not in order, or
            the delay is no whole number of control periods.
        VelocityError: one of the velocities cannot be walked; raised before the walk begins.
        FileError: the dump cannot be written.
    """
    check_number("duration", duration, 0.0, "s", above=True)
    times = [time for time, _ in velocity_changes]
    if times != sorted(times):
        raise ParameterError(
            "velocity changes in order of time", f"{list(velocity_changes)!r}", "sort them"
        )
    # What cannot be walked, or written, is refused before the walk begins.
    if dump is not None:
        check_dump_path(Path(dump))
    for _, velocity in velocity_changes:
        controller.with_velocity(velocity)
    plan = [(time, Steering(velocity)) for time, velocity in velocity_changes]

    def begin() -> PointWorld:
        world = PointWorld(
            controller, plant, disturbance, estimator, first_support=first_support,
            retained=math.inf,
        )  # fmt: skip
        return world.prepare(pushes, plan, watch)

    world = begin()
    steps = None if dump is None else LastSteps(world)
    world.run(duration, steps)
    world.finish()
    if dump is not None and steps is not None and (world.fallen or world.is_nan()):
        write_dump(Path(dump), steps.walked_again(begin().prepare(pushes), duration))
    return world.rollout()


def replay(dump: Dump, controller: Controller, estimator: Estimator | None = None) -> Rollout:
    """Walk a dump of a point mass again, from its first state on.

    Args:
        dump: as `rollout.dump.load_dump` reads it.
        controller: that walked, made with the same arguments, at any of its velocities.
        estimator: the one of that walk.

    Returns:
        The cycles of `dump.rollout`, to the bit.

    Raises:
        ParameterError: it is not the controller that walked: its commands differ.
    """
    walk = dump.rollout
    world = PointWorld(controller, walk.robot, walk.disturbance, estimator, retained=math.inf)
    return walk_again(
        dump, world.prepare(walk.pushes, [(at, Steering(to)) for at, to in walk.velocities[1:]])
    )

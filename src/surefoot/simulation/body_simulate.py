"""Walk a body in physics and keep everything that happened."""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter_ns
from typing import Any

import numpy as np

from surefoot.checks import check_number
from surefoot.errors import ParameterError
from surefoot.models.body_state import BodyEstimator
from surefoot.models.bumps import board_numbers
from surefoot.models.legs import find_knees
from surefoot.models.multibody import TIME_STEP
from surefoot.models.pushes import Push
from surefoot.models.steering import Steering
from surefoot.models.walker import WALKING, Walker
from surefoot.simulation.body_noise import BodyNoise
from surefoot.simulation.body_plant import BodyPlant, Surroundings
from surefoot.simulation.body_recorder import BodyRecorder, Record
from surefoot.simulation.body_senses import BodySight, SenseNoise
from surefoot.simulation.body_trace import BodyTrace
from surefoot.simulation.body_truth import (
    carrying_foot,
    commands_in_world,
    floor_zmp,
    roll_pitch_yaw,
    told_observations,
    true_observations,
)
from surefoot.simulation.rollout import Rollout
from surefoot.simulation.simulate import describe
from surefoot.version import VERSION

USUAL_NOISE = BodyNoise()
"""Of the sensors of a robot, unless it is told."""

TRUTH = "truth"
"""In place of an estimator: the walker is told the true state of its body."""


def simulate_body(
    control: Walker,
    duration: float = 10.0,
    pushes: Sequence[Push] = (),
    *,
    steering: Sequence[tuple[float, Steering]] = (),
    surroundings: Surroundings | None = None,
    noise: SenseNoise | None = USUAL_NOISE,
    estimator: BodyEstimator | str | None = None,
) -> Rollout:
    """Walk a body in physics, from a stand on both feet.

    Args:
        control: what walks it.
        duration: how long [s]; a fall ends the walk early.
        pushes: forces on the base, or on `Body.trunk`, at its centre of mass.
        steering: (time, command) in order of time [s]; before the first one, and if there is none,
            the robot walks at its controller's velocity.
        surroundings: floor, bumps, payload, masses.
        noise: of the sensors, that of usual ones unless told; they are perfect if None.
        estimator: makes a state of what the sensors tell; if None a `BodyEstimator` that knows how
            late the sensors of a `BodyNoise` are. "truth" tells the true state instead.

    Returns:
        The rollout; its `body` is the trace of the mechanism.

    Raises:
        ParameterError: the duration is not positive and finite, the steering not in order, or
            there is noise but no estimator.
        VelocityError: one of the velocities cannot be walked; told before the walk begins.
    """
    check_number("duration", duration, 0.0, "s", above=True)
    route = _route(control, steering)
    eyes = _eyes(control, noise, estimator)
    noise = None if eyes is None else noise
    plant = BodyPlant(control.multibody, surroundings, pushes)
    sight, state = BodySight(plant, noise, eyes), control.start()
    cycles = round(duration / TIME_STEP) + 1
    recorder = BodyRecorder(plant, state, eyes is not None, cycles)
    command, fate, row, pending = None, 0, 0, list(route)
    going = pending.pop(0)[1]
    while row < cycles and not fate:
        now = plant.time
        while pending and now >= pending[0][0]:
            going = pending.pop(0)[1]
        senses = sight.read(first=row == 0)
        began = perf_counter_ns()
        position, velocity, forces = sight.see(senses, state, command)
        sensed = perf_counter_ns()
        command, state = control.step(state, now, position, velocity, forces, going)
        decided = perf_counter_ns()
        recorder.see(row, position, velocity)
        recorder.hear(row, state, command)
        acting = perf_counter_ns()
        plant.act(command)
        fate = plant.state()
        recorder.feel(row, (began, sensed, decided, perf_counter_ns() - acting))
        row += 1
    told = TRUTH if eyes is None else f"{describe(eyes)}; noise: {noise!r}"
    return make_rollout(control, plant, recorder.record(row), fate, route, told)


def _route(
    control: Walker, steering: Sequence[tuple[float, Steering]]
) -> list[tuple[float, Steering]]:
    """All commands from the start on, checked."""
    times = [time for time, _ in steering]
    if times != sorted(times):
        raise ParameterError("steering in order of time", f"{list(steering)!r}", "sort it")
    route = list(steering)
    if not route or route[0][0] > 0.0:
        route.insert(0, (0.0, Steering(control.controller.gait.velocity)))
    for _, command in route:
        if not command.standing:
            control.controller.with_velocity(command.velocity)
    return route


def _eyes(
    control: Walker, noise: SenseNoise | None, estimator: BodyEstimator | str | None
) -> BodyEstimator | None:
    if isinstance(estimator, str) and estimator != TRUTH:
        raise ParameterError(
            f"an estimator, or {TRUTH!r} for the true state",
            repr(estimator),
            "leave it out for an estimate from the sensors",
        )
    if estimator == TRUTH and noise not in (None, USUAL_NOISE):
        raise ParameterError(
            "noise with an estimator: the true state has none",
            f"estimator={TRUTH!r} and {noise!r}",
            "leave one of them out",
        )
    if isinstance(estimator, str):
        return None
    late = noise.delay if isinstance(noise, BodyNoise) else 0.0
    return estimator or BodyEstimator(control.multibody, delay=late)


def make_rollout(
    control: Walker,
    plant: BodyPlant,
    record: Record,
    fate: int,
    route: list[tuple[float, Steering]],
    senses: str,
) -> Rollout:
    """What a record of a walk says, as a rollout.

    Args:
        control: what walked.
        plant: what it walked.
        record: everything that was taken down.
        fate: what became of the robot, see `simulation.body_plant`.
        route: (time, command) in order of time [s], from the start on.
        senses: what the walker was told, in words; `TRUTH` for the true state.
    """
    believed, multibody = control.controller.robot, control.multibody
    # Numbers of the plant's clock, which counts cycles.
    time = np.arange(len(record.clock)) * plant.model.opt.timestep
    truth = true_observations(record, time, believed, multibody.mass)
    still = Steering().velocity
    velocities = [(at, still if to.standing else to.velocity) for at, to in route]
    return Rollout(
        robot=multibody.robot,
        controller=type(control.controller).__name__,
        controller_parameters=describe(control.controller),
        velocities=tuple((max(at, 0.0), to) for at, to in velocities),
        pushes=plant.pushes,
        fallen=fate != 0,
        observations=truth,
        commands=commands_in_world(record, truth),
        decision_time=1e-9 * np.subtract(record.clock[:, 2], record.clock[:, 1]).astype(np.float64),
        seen=told_observations(record, truth),
        estimator="" if senses == TRUTH else senses,
        body=_trace(control, plant, record, fate, route, senses),
        version=VERSION,
    )


def _trace(
    control: Walker,
    plant: BodyPlant,
    record: Record,
    fate: int,
    route: list[tuple[float, Steering]],
    senses: str,
) -> BodyTrace:
    multibody, state, effect = control.multibody, record.state, record.effect
    walk, told = record.told["walk"], record.told
    wrenches = np.stack([effect["left_wrench"], effect["right_wrench"]], axis=1)
    soles = np.stack([state["left_sole"], state["right_sole"]], axis=1)
    support, _ = carrying_foot(walk)
    plan = walk["swing_foot"].copy()
    walking = walk["phase"] == WALKING
    plan[walking, 2] += soles[walking, support[walking], 2]
    return BodyTrace(
        robot=multibody.robot,
        believed=control.controller.robot,
        omega=control.controller.robot.omega,
        surroundings=repr(plant.surroundings),
        senses=senses,
        steering=tuple((max(at, 0.0), to.velocity, to.turning, to.standing) for at, to in route),
        fate=fate,
        joints=multibody.joint_names,
        knees=find_knees(multibody),
        motor_positions=multibody.motor_positions,
        motor_dofs=multibody.motor_dofs,
        torque_limit=multibody.torque,
        speed_limit=multibody.speed,
        com=state["com"],
        com_velocity=state["com_velocity"],
        zmp=floor_zmp(state["com"], wrenches),
        sole_position=soles,
        sole_turn=_turns(state["left_axes"], state["right_axes"]),
        sole_force=wrenches[:, :, 3:],
        base_turn=roll_pitch_yaw(state["base_axes"]),
        phase=walk["phase"].astype("i1"),
        support=support.astype("i1"),
        steps=walk["steps"].astype("i4"),
        swing_plan=plan,
        sense_time=(record.clock[:, 1] - record.clock[:, 0]) * 1e-9,
        physics_time=record.clock[:, 3] * 1e-9,
        boards=board_numbers(plant.surroundings.boards),
        **_same(state, "position", "velocity"),
        **_same(effect, "torque"),
        **_same(told, "told_position", "told_velocity", "course", "solver"),
    )


def _turns(left: Any, right: Any) -> Any:
    return np.stack([roll_pitch_yaw(left), roll_pitch_yaw(right)], axis=1)


def _same(rows: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: rows[name] for name in names}

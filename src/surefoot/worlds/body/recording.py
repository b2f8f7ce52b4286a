"""What a record of a walk in physics says, as a rollout."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.robot.floor import board_numbers
from surefoot.robot.legs import find_knees
from surefoot.rollout.description import describe
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import TRUTH, WALKING, BodyTrace
from surefoot.version import VERSION
from surefoot.worlds.body.estimator import BodyEstimator
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.recorder import Record
from surefoot.worlds.body.sensors import SenseNoise
from surefoot.worlds.body.truth import (
    carrying_foot,
    commands_in_world,
    floor_zmp,
    roll_pitch_yaw,
    told_observations,
    true_observations,
)
from surefoot.worlds.body.walker import Walker
from surefoot.worlds.steering import Steering


def senses_words(estimator: BodyEstimator | None, noise: SenseNoise | None) -> str:
    """What a walker is told: `TRUTH`, or the parameters of its estimator and of the noise."""
    return TRUTH if estimator is None else f"{describe(estimator)}; noise: {noise!r}"


def make_rollout(
    control: Walker,
    plant: BodyPlant,
    record: Record,
    fate: int,
    route: list[tuple[float, Steering]],
    senses: str,
    first: int = 0,
) -> Rollout:
    """What a record of a walk says, as a rollout.

    Args:
        control: what walked.
        plant: what it walked.
        record: everything that was taken down.
        fate: what became of the robot, see `worlds.body.plant`.
        route: (time, command) in order of time [s], from the start on.
        senses: what the walker was told, in words; `TRUTH` for the true state.
        first: number of the cycle that the record begins with.
    """
    believed, multibody = control.controller.robot, control.multibody
    # Numbers of the plant's clock, which counts cycles.
    time = np.arange(first, first + len(record.clock)) * plant.model.opt.timestep
    truth = true_observations(record, time, believed, multibody.mass)
    still = Steering().velocity
    if first:
        before = [to for at, to in route if at <= time[0]]
        route = [(float(time[0]), before[-1]), *((at, to) for at, to in route if at > time[0])]
    velocities = [(at, still if to.standing else to.velocity) for at, to in route]
    pushes = tuple(push for push in plant.pushes if not first or push.end > time[0])
    return Rollout(
        robot=multibody.robot,
        controller=type(control.controller).__name__,
        controller_parameters=describe(control.controller),
        velocities=tuple((max(at, 0.0), to) for at, to in velocities),
        pushes=pushes,
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
        mass=float(plant.model.body_mass.sum()),
        **_same(state, "position", "velocity"),
        **_same(effect, "torque"),
        **_same(told, "told_position", "told_velocity", "course", "solver"),
    )


def _turns(left: Any, right: Any) -> Any:
    return np.stack([roll_pitch_yaw(left), roll_pitch_yaw(right)], axis=1)


def _same(rows: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: rows[name] for name in names}

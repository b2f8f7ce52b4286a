"""From the record of a walk in physics to a rollout: everything in the world's frame.

A body's controller works in a
frame that turns with its steps; what it was given and what it answered are rotated back. The DCM
goes with the angular momentum L about the standing sole, as the controller's does:

    xi = c + L x e_z / (m h omega).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.geometry import rotated_by, wrapped
from surefoot.interface import OBSERVATION
from surefoot.robot.floor import board_numbers
from surefoot.robot.legs import find_knees
from surefoot.robot.robot import Robot
from surefoot.rollout.rollout import Rollout, describe
from surefoot.rollout.trace import TRUTH, WALKING, BodyTrace
from surefoot.version import VERSION
from surefoot.worlds.body.estimator import BodyEstimator
from surefoot.worlds.body.interface import BodyController
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.recorder import Record
from surefoot.worlds.body.sensors import SensorNoise
from surefoot.worlds.steering import Steering

Array = NDArray[Any]

MIN_FORCE = 1.0
"""Of the floor, below which there is no ZMP [N]."""


def sensors_words(estimator: BodyEstimator | None, noise: SensorNoise | None) -> str:
    """Where the state comes from: `TRUTH`, or the parameters of the estimator and of the noise."""
    return TRUTH if estimator is None else f"{describe(estimator)}; noise: {noise!r}"


def make_rollout(
    control: BodyController,
    plant: BodyPlant,
    record: Record,
    fate: int,
    route: Sequence[tuple[float, Steering]],
    sensors: str,
    first: int = 0,
) -> Rollout:
    """What a record of a walk says, as a rollout.

    Args:
        control: what walked.
        plant: what it walked.
        record: everything that was taken down.
        fate: what became of the robot, see `worlds.body.plant`.
        route: (time, command) in order of time [s], from the start on.
        sensors: where the state comes from, in words; see `sensors_words`.
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
        seen=given_observations(record, truth),
        estimator="" if sensors == TRUTH else sensors,
        body=_trace(control, plant, record, fate, route, sensors),
        version=VERSION,
    )


def _trace(
    control: BodyController,
    plant: BodyPlant,
    record: Record,
    fate: int,
    route: Sequence[tuple[float, Steering]],
    sensors: str,
) -> BodyTrace:
    multibody, state, effect = control.multibody, record.state, record.effect
    decision = record.decision
    walk = decision["walk"]
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
        senses=sensors,
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
        **_same(decision, "told_position", "told_velocity", "course", "solver"),
    )


def _turns(left: Array, right: Array) -> Array:
    return np.stack([roll_pitch_yaw(left), roll_pitch_yaw(right)], axis=1)


def _same(rows: dict[str, Any], *names: str) -> dict[str, Any]:
    return {name: rows[name] for name in names}


def roll_pitch_yaw(axes: Array) -> Array:
    """Angles about x, y and z, shape (n, 3) [rad], of rotation matrices by rows, shape (n, 9)."""
    m = axes.reshape(-1, 3, 3)
    roll = np.arctan2(m[:, 2, 1], m[:, 2, 2])
    pitch = -np.arcsin(np.clip(m[:, 2, 0], -1.0, 1.0))
    return np.stack([roll, pitch, np.arctan2(m[:, 1, 0], m[:, 0, 0])], axis=-1)


def floor_zmp(com: Array, wrenches: Array) -> Array:
    """Where the floor's forces have no horizontal moment, NaN in the air, shape (n, 2) [m].

    Args:
        com: the point that the moments are about, shape (n, 3) [m].
        wrenches: moment and force on both feet, shape (n, 2, 6) [N m, N].
    """
    total = wrenches.sum(axis=1)
    moment, force = total[:, :3], total[:, 3:]
    up = np.where(force[:, 2] > MIN_FORCE, force[:, 2], np.nan)
    height = com[:, 2]
    x = com[:, 0] - (moment[:, 1] + height * force[:, 0]) / up
    y = com[:, 1] + (moment[:, 0] - height * force[:, 1]) / up
    return np.stack([x, y], axis=-1)


def carrying_foot(walk: Array) -> tuple[Array, Array]:
    """Foot on the ground and time of its touchdown; while both stand, those of the next step.

    After the last step they stay.
    """
    walking = walk["phase"] == WALKING
    support, began = walk["support"].copy(), walk["began"].copy()
    if walking.any():
        first = int(np.argmax(walking))
        support[:first], began[:first] = support[first], began[first]
    return support, began


def true_observations(record: Record, time: Array, believed: Robot, mass: float) -> Array:
    """The true observations of a walk, records of `OBSERVATION`, shape (n,)."""
    state, walk = record.state, record.decision["walk"]
    support, began = carrying_foot(walk)
    rows = np.arange(len(time))
    soles = np.stack([state["left_sole"], state["right_sole"]], axis=1)
    yaws = np.stack([roll_pitch_yaw(state[f"{s}_axes"])[:, 2] for s in ("left", "right")], axis=1)
    seen = np.zeros(len(time), OBSERVATION)
    seen["time"], seen["elapsed"] = time, np.maximum(time - began, 0.0)
    com, velocity, momentum = state["com"], state["com_velocity"], state["angular_momentum"]
    foot, swing = soles[rows, support], soles[rows, 1 - support]
    seen["com"], seen["com_velocity"] = com[:, :2], velocity[:, :2]
    away, height = com - foot, believed.com_height
    twist = np.stack([momentum[:, 1], -momentum[:, 0]], axis=1) / mass
    about_foot = twist + away[:, 2:] * velocity[:, :2] - away[:, :2] * velocity[:, 2:]
    seen["dcm"] = com[:, :2] + about_foot / (height * believed.omega)
    seen["support_foot"], seen["swing_foot"] = foot[:, :2], swing
    if len(time) > 1:
        speed = np.gradient(soles, time, axis=0)
        seen["swing_foot_velocity"] = speed[rows, 1 - support]
    seen["support_yaw"], seen["swing_yaw"] = yaws[rows, support], yaws[rows, 1 - support]
    base = roll_pitch_yaw(state["base_axes"])
    seen["trunk_lean"] = rotated_by(np.stack([base[:, 1], -base[:, 0]], axis=1), base[:, 2])
    seen["support_side"] = 2 * support - 1
    return seen


def given_observations(record: Record, truth: Array) -> Array:
    """What the controller was given, in the world; the truth while it was given nothing."""
    walk = record.decision["walk"]
    walking, heading = walk["phase"] == WALKING, walk["heading"]
    given = truth.copy()
    inner = record.decision["observation"]
    for name in ("elapsed", "swing_foot", "swing_foot_velocity"):
        given[name][walking] = inner[name][walking]
    for name in ("com", "com_velocity", "dcm", "support_foot", "swing_foot", "swing_foot_velocity"):
        rotated = rotated_by(inner[name][..., :2], heading)
        given[name][walking, :2] = rotated[walking]
    for name in ("support_yaw", "swing_yaw"):
        given[name][walking] = wrapped(inner[name] + heading)[walking]
    return given


def commands_in_world(record: Record, truth: Array) -> Array:
    """What the controller answered, in the world; while both feet stand, what there is of it."""
    walk = record.decision["walk"]
    walking, heading = walk["phase"] == WALKING, walk["heading"]
    inner = record.decision["command"]
    commands = inner.copy()
    for name in (
        "zmp", "dcm_plan", "step_location", "dcm_offset", "swing_foot", "swing_foot_velocity",
        "swing_foot_acceleration", "hip_torque",
    ):  # fmt: skip
        commands[name][..., :2] = rotated_by(inner[name][..., :2], heading)
    commands["swing_yaw"] = wrapped(inner["swing_yaw"] + heading)
    still = ~walking
    # A stand has no plan of its DCM, and no step; its ZMP is in the world's frame already.
    commands["zmp"][still] = inner["zmp"][still]
    commands["dcm_plan"][still] = truth["dcm"][still]
    commands["step_location"][still] = truth["swing_foot"][still, :2]
    commands["swing_foot"][still] = truth["swing_foot"][still]
    for name in ("step_duration", "swing_foot_velocity", "swing_foot_acceleration", "dcm_offset"):
        commands[name][still] = 0.0
    commands["double_support"][still] = 1
    commands["mode"][still] = commands["status"][still] = 0
    return commands

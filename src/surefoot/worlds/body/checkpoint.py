"""All that evolves in the walk of a body, as arrays: taken between two cycles, and put back.

What a solver remembers is left out: a walk that is resumed begins with one that remembers nothing.
"""

from __future__ import annotations

import mujoco
import numpy as np

from surefoot.interface import Command, Controller, Observation
from surefoot.rollout.dump import Checkpoint
from surefoot.worlds.body.controller import BodyState
from surefoot.worlds.body.course import Course, VelocityCorrection
from surefoot.worlds.body.estimator import BodyMemory, BodyReadings
from surefoot.worlds.body.interface import JointCommand
from surefoot.worlds.body.plant import BodyPlant
from surefoot.worlds.body.sensors import BodySensors, SensorMemory

MAPPING = "mapping_"
"""In front of the names of what a mapping remembers."""

PHYSICS = mujoco.mjtState.mjSTATE_INTEGRATION
"""What MuJoCo integrates, with what its solver starts from."""


def plant_arrays(plant: BodyPlant) -> Checkpoint:
    """The state of physics, and the readings of the last cycle."""
    physics = np.empty(mujoco.mj_stateSize(plant.model, PHYSICS))
    mujoco.mj_getState(plant.model, plant.data, physics, PHYSICS)
    return {
        "physics": physics,
        "readings": plant.data.sensordata.copy(),
        "torque": plant.torque.copy(),
        "cycle": np.array(plant.cycle),
    }


def set_plant(plant: BodyPlant, arrays: Checkpoint) -> None:
    """Put back what `plant_arrays` took."""
    mujoco.mj_setState(plant.model, plant.data, arrays["physics"], PHYSICS)
    mujoco.mj_step1(plant.model, plant.data)
    plant.data.sensordata[:] = arrays["readings"]
    plant.torque[:], plant.cycle = arrays["torque"], int(arrays["cycle"])


def sensor_arrays(sensors: BodySensors) -> Checkpoint:
    """What noise and estimator remember."""
    arrays: Checkpoint = {}
    if sensors.memory is not None:
        arrays |= sensors.memory._asdict()
    if isinstance(sensors.noise_memory, SensorMemory):
        arrays["noise_cycle"] = np.array(sensors.noise_memory.cycle)
        for age, readings in enumerate(sensors.noise_memory.late):
            named = readings._asdict().items()
            arrays |= {f"late{age}_{name}": np.asarray(it) for name, it in named}
    return arrays


def set_sensors(sensors: BodySensors, arrays: Checkpoint) -> None:
    """Put back what `sensor_arrays` took."""
    if "base" in arrays:
        sensors.memory = BodyMemory(*(arrays[name] for name in BodyMemory._fields))
    if "noise_cycle" in arrays:
        late: list[BodyReadings] = []
        while f"late{len(late)}_time" in arrays:
            time, *others = (arrays[f"late{len(late)}_{name}"] for name in BodyReadings._fields)
            late.append(BodyReadings(float(time), *others))
        sensors.noise_memory = SensorMemory(int(arrays["noise_cycle"]), tuple(late))


def control_arrays(state: BodyState, command: JointCommand) -> Checkpoint:
    """The state of the control, and its last command."""
    course, correction = state.course, state.correction
    return {
        "walk": state.walk,
        "velocity": np.array(state.controller.gait.velocity),
        **({} if state.memory is None else {"memory": state.memory}),
        "observation": state.observation.array,
        "command": state.command.array,
        "course": np.array([*course.place, course.heading, course.time]),
        "correction": np.array([*correction.drift, *correction.back]),
        "slow_steps": np.array(state.slow_steps),
        **{MAPPING + name: array for name, array in state.joints.items()},
        **{f"joint_{name}": np.array(getattr(command, name)) for name in command.__slots__},
    }


def set_control(controller: Controller, command: JointCommand, arrays: Checkpoint) -> BodyState:
    """The state that `control_arrays` took, of a control with this controller; the command is
    overwritten."""
    for name in command.__slots__:
        value = arrays[f"joint_{name}"]
        setattr(command, name, value.copy() if value.ndim else value.item())
    (x, y, heading, time), (v_x, v_y) = arrays["course"].tolist(), arrays["velocity"].tolist()
    drift_x, drift_y, back_x, back_y = arrays["correction"].tolist()
    return BodyState(
        walk=arrays["walk"],
        controller=controller.with_velocity((v_x, v_y)),
        memory=arrays.get("memory"),
        observation=Observation.of(arrays["observation"]),
        command=Command.of(arrays["command"]),
        joints={
            name.removeprefix(MAPPING): array
            for name, array in arrays.items()
            if name.startswith(MAPPING)
        },
        course=Course((x, y), heading, time),
        correction=VelocityCorrection((drift_x, drift_y), (back_x, back_y)),
        slow_steps=int(arrays["slow_steps"]),
    )

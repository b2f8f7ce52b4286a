"""The state of a robot with a body from its readings: encoders, inertial unit, feet.

In a cycle readings that nothing explains are left out and the joints are filtered (`readings`), the
base follows from the inertial unit and the standing feet (`base_filter`), and what was measured
late is carried on to the present with the accelerations that the controller has asked for since.
The result is what MuJoCo calls qpos and qvel: position and quaternion of the base, then the angles;
the base's velocity in the world, its angular velocity in its own frame, then the joints'
velocities.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from dataclasses import field as attribute
from functools import cache
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from surefoot.compiled import entry_point, njit
from surefoot.control.estimator import whole_cycles
from surefoot.control.fields import (
    check_fields,
    declared,
    described,
    documented,
    fill_shares,
    setting,
)
from surefoot.errors import ParameterError
from surefoot.geometry import rotate, rotation_matrix
from surefoot.record import Record, copy_array, field, new_array
from surefoot.robot.leg_kinematics import LINK, SOLES, find_soles, leg_links
from surefoot.robot.multibody import Multibody
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.robot import STANDARD_GRAVITY
from surefoot.worlds.body.base_filter import (
    BASE,
    BaseNoise,
    carry_on,
    correct_by_feet,
    landing,
)
from surefoot.worlds.body.readings import (
    FREE,
    JOINT,
    Jerk,
    all_finite,
    begin,
    correct_joint,
    predict_joint,
    take_accelerometer,
    take_forces,
    take_gyro,
    take_joints,
)


class Settings(Record):
    """What the estimator knows of sensors, loop and robot."""

    base: BaseNoise = field("", "of the base's filter")
    rate: float = field("rad/s", "standard deviation of the joints' velocities")
    surprise: float = field("rad/s^2", "error of the expected joint accelerations")
    landing_surprise: float = field("rad/s^2", "what is added to it at touchdown")
    jerk: Jerk = field("", "what is believed at once")
    delay: int = field("-", "age of the readings in cycles")


SETTINGS = Settings.DTYPE

TOUCH = 0.06
"""Part of its load from which on a swinging sole meets the ground: joints are jolted before it is
believed to stand."""

FORCE_PART = 0.003
"""Standard deviation of the force on a sole, of the weight: load cells are chosen for the robot
that they carry, and are as exact as that part of their range."""

SETTLING = 0.105
"""Within which a foot comes to rest after touchdown, but for 1 / e of its motion, in 1 / omega."""

BIAS_WALK = 1e-5
"""How a gyroscope's offset wanders [rad/s^1.5]."""


class BodyReadings(NamedTuple):
    """What the sensors of a body measure in a cycle, arrays of float64.

    Attributes:
        time: when it was measured [s].
        joint_angles: of all hinges, shape (n,), in the model's order, passive ones too [rad].
        joint_velocities: likewise [rad/s].
        gyro: angular velocity of the base in its own frame, shape (3,) [rad/s].
        accelerometer: acceleration of the base's origin less gravity, likewise; the mean since the
            cycle before [m/s^2].
        foot_force: vertical force on the left and the right sole, shape (2,) [N].
    """

    time: float
    joint_angles: NDArray[np.float64]
    joint_velocities: NDArray[np.float64]
    gyro: NDArray[np.float64]
    accelerometer: NDArray[np.float64]
    foot_force: NDArray[np.float64]


class BodyMemory(NamedTuple):
    """What a `BodyEstimator` remembers: a value, never changed.

    Attributes:
        base: a `Base` as an array, shape (1,).
        joints: `Joint` records, shape (n,).
        expected: accelerations asked for in the last cycles, a ring, flat [m/s^2, rad/s^2].
    """

    base: NDArray[np.void]
    joints: NDArray[np.void]
    expected: NDArray[np.float64]


@njit
def _filter_base(settings, base, links, readings, angles, feet, past):
    """Base at the time of the readings; if an encoder is silent, the feet are left out."""
    noise, R, acceleration = settings.base, np.empty((3, 3)), np.empty(3)
    rotation_matrix(base.orientation, R)
    take_gyro(settings, base, readings.gyro, past)
    take_accelerometer(settings, base, readings.accelerometer, past, R, acceleration)
    carry_on(base, noise, acceleration)
    if not all_finite(angles):
        return
    soles = np.zeros(1, SOLES)[0]
    find_soles(links, angles, soles)
    correct_by_feet(base, noise, soles, feet, readings.foot_force)


@njit
def _write(base, joints, qpos, qvel):
    for i in range(3):
        qpos[i], qvel[i], qvel[3 + i] = base.position[i], base.velocity[i], base.turning[i]
    for i in range(4):
        qpos[3 + i] = base.orientation[i]
    for k in range(joints.shape[0]):
        qpos[FREE + 1 + k], qvel[FREE + k] = joints[k].angle, joints[k].velocity


@njit
def _move(qpos, qvel, acceleration, dt):
    """Carry a state on by one period."""
    turn, orientation = np.empty(3), qpos[3 : FREE + 1]
    for i in range(qvel.shape[0]):
        qvel[i] += acceleration[i] * dt
    for i in range(3):
        qpos[i] += qvel[i] * dt
        turn[i] = qvel[3 + i] * dt
    rotate(orientation, turn, orientation)
    for k in range(FREE, qvel.shape[0]):
        qpos[1 + k] += qvel[k] * dt


@njit
def _estimate(settings, links, memory, readings, feet, acceleration, qpos, qvel):
    """One cycle; the memory is changed, qpos and qvel are written."""
    known, base, joints, expected = settings[0], memory.base[0], memory.joints, memory.expected
    size, delay, noise = qvel.shape[0], known.delay, known.base
    ring, now = delay + 1, base.cycles
    here = now % ring * size
    for i in range(size):
        expected[here + i] = acceleration[i] if math.isfinite(acceleration[i]) else 0.0
    # The oldest of the ring led to these readings, the others have acted since.
    oldest = (now + 1) % ring * size
    past = expected[oldest : oldest + size]
    take_forces(known, base, readings.foot_force)
    taken = np.empty((3, joints.shape[0]))
    take_joints(known, joints, readings.joint_angles, readings.joint_velocities, past, taken)
    _filter_base(known, base, links, readings, taken[2], feet, past)
    fresh = 0.0
    for foot in range(2):
        fresh = max(fresh, landing(base, noise, foot))
    for foot in range(2):
        if feet[foot] == 0 and base.load[foot] > TOUCH * noise.load:
            fresh = 1.0
    surprise = math.sqrt(known.surprise**2 + (fresh * known.landing_surprise) ** 2)
    for k in range(joints.shape[0]):
        predict_joint(joints[k], past[FREE + k], surprise, noise.period)
        correct_joint(joints[k], taken[0, k], taken[1, k], noise.encoder, known.rate)
    _write(base, joints, qpos, qvel)
    for age in range(delay - 1, -1, -1):
        then = (now - age) % ring * size
        _move(qpos, qvel, expected[then : then + size], noise.period)
    base.cycles = now + 1


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    vector, named = numba.float64[::1], numba.types.NamedTuple
    base, joints = (numba.types.Array(numba.from_dtype(kind), 1, "C") for kind in (BASE, JOINT))
    memory = named((base, joints, vector), BodyMemory)
    readings = named((numba.float64, *[vector] * 5), BodyReadings)
    return (
        entry_point(begin, SETTINGS, LINK, memory, readings),
        entry_point(_estimate, SETTINGS, LINK, memory, readings, np.dtype(np.int64), *[vector] * 3),
    )


def _copy(joints: NDArray[np.void]) -> NDArray[np.void]:
    """Half the time of the method `copy`, which goes field by field."""
    return np.ndarray(len(joints), JOINT, bytearray(joints.tobytes()))


@documented
@dataclass(frozen=True)
class BodyEstimator:
    """Estimates the state of a robot with a body from its readings.

    It is a value like a controller: what it remembers goes through `step`. In the world's frame it
    starts between its feet, on the floor, heading along x. Encoders, tachometers and inertial units
    are the same parts in every robot, so their noise does not follow from it.

    Raises:
        ParameterError: a value is out of range, or the delay no whole number of periods.
    """

    multibody: Multibody = attribute(metadata=described("the robot's mechanism"))
    encoder: float = setting(0.001, "rad", "standard deviation of a joint's angle", above=0.0)
    rate: float = setting(0.1, "rad/s", "likewise of its velocity", above=0.0)
    gyro: float = setting(0.005, "rad/s", "likewise of the angular velocity", above=0.0)
    accelerometer: float = setting(0.1, "m/s^2", "likewise of the acceleration", above=0.0)
    gyro_bias: float = setting(
        0.005, "rad/s", "likewise of the gyroscope's constant offset, which is estimated", above=0.0
    )
    surprise: float = setting(
        None,
        "rad/s^2",
        "error of the expected joint accelerations, likewise",
        share=0.408,
        above=0.0,
    )
    landing_surprise: float = setting(
        None, "rad/s^2", "what is added to it at touchdown, and fades", share=4.89, above=0.0
    )
    slip: float = setting(
        None, "m/s^0.5", "random walk of a standing sole", share=3.34e-4, above=0.0
    )
    light_slip: float = setting(
        None, "m/s^0.5", "what is added to it when no weight is on the sole", share=0.2, above=0.0
    )
    landing_slip: float = setting(
        None, "m/s^0.5", "what is added to it at touchdown, and fades", share=0.0668, above=0.0
    )
    twist: float = setting(
        None, "rad/s^0.5", "random walk of a sole's heading while both stand", share=1.07e-4,
        above=0.0,
    )  # fmt: skip
    swing_twist: float = setting(
        None, "rad/s^0.5", "what is added to it while the other leg swings", share=0.0107, above=0.0
    )
    floor: float = setting(
        None, "m", "how uneven the floor is where a foot lands, standard deviation", share=0.0125,
        above=0.0,
    )  # fmt: skip
    force: float = setting(None, "N", "standard deviation of the force on a sole", share=FORCE_PART)
    delay: float = setting(
        0.0, "s", "age of the readings, a whole number of periods; 0 predicts nothing"
    )
    period: float = setting(0.001, "s", "control period", above=0.0)
    settings: NDArray[np.void] = attribute(init=False, repr=False, compare=False)
    links: NDArray[np.void] = attribute(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        robot = self.multibody.robot
        fill_shares(self, robot)
        check_fields(self)
        units, settings = OwnUnits.of(robot), new_array(SETTINGS)
        for record, kind in ((settings["base"], BaseNoise), (settings, Settings)):
            for name in kind.FIELDS.keys() & declared(self).keys() - {"delay"}:
                record[name] = getattr(self, name)
        settings["base"]["bias_walk"] = BIAS_WALK
        settings["base"]["load"] = 0.5 * self.multibody.mass * STANDARD_GRAVITY
        settings["base"]["settling"] = SETTLING * units.time
        for name, it in Jerk.FIELDS.items():
            time = self.period if name in ("turning", "angle") else 1.0
            settings["jerk"][name] = it.default * units.one(it.unit) * time
        settings["delay"] = whole_cycles(self.delay, self.period)
        object.__setattr__(self, "settings", settings)
        object.__setattr__(self, "links", leg_links(self.multibody))

    def start(self, readings: BodyReadings) -> BodyMemory:
        """What it remembers before the first cycle: the robot stands still on both feet.

        Raises:
            ParameterError: a reading is missing, not finite, or of another shape.
        """
        joints = self.multibody.model.nv - FREE
        shapes = ((joints,), (joints,), (3,), (3,), (2,))
        values = readings[1:]
        for name, reading, shape in zip(readings._fields[1:], values, shapes, strict=True):
            if np.shape(reading) != shape or not np.all(np.isfinite(reading)):
                raise ParameterError(
                    f"`{name}` of shape {shape}, finite, to start with",
                    repr(reading),
                    "wait until the sensors measure",
                )
        ring = (int(self.settings["delay"][0]) + 1) * (FREE + joints)
        memory = BodyMemory(new_array(BASE), np.zeros(joints, JOINT), np.zeros(ring))
        _compiled()[0](self.settings, self.links, memory, readings)
        return memory

    def step(
        self,
        memory: BodyMemory,
        readings: BodyReadings,
        feet: NDArray[np.int64],
        expected: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], BodyMemory]:
        """One cycle: generalised positions and velocities now, and what to remember.

        A reading that is not finite is left out.

        Args:
            memory: of the cycle before, or of `start`.
            readings: of now, or `delay` old.
            feet: which soles are believed to stand, left and right, shape (2,): 1 or 0.
            expected: accelerations that the controller asked for since the cycle before, shape
                (nv,) like qvel; zeros if unknown.
        """
        base, joints, expected_before = memory
        memory = BodyMemory(copy_array(base), _copy(joints), expected_before.copy())
        qpos, qvel = np.empty(FREE + 1 + len(joints)), np.empty(FREE + len(joints))
        _compiled()[1](self.settings, self.links, memory, readings, feet, expected, qpos, qvel)
        return qpos, qvel, memory

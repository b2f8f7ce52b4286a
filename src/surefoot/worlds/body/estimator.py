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
from dataclasses import dataclass, field
from functools import cache
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import entry_point, njit
from surefoot.control.estimator import whole_cycles
from surefoot.errors import ParameterError
from surefoot.geometry import rotate, rotation_matrix
from surefoot.record import copy_array, new_array
from surefoot.robot.leg_kinematics import LINK, SOLES, find_soles, leg_links
from surefoot.robot.multibody import Multibody
from surefoot.robot.own_units import OwnUnits
from surefoot.robot.robot import STANDARD_GRAVITY
from surefoot.worlds.body.base_filter import (
    BASE,
    BASE_NOISE,
    carry_on,
    landing,
    listen_to_feet,
)
from surefoot.worlds.body.readings import (
    FREE,
    JERK,
    JOINT,
    OWN_JERK,
    all_finite,
    begin,
    believe_accelerometer,
    believe_forces,
    believe_gyro,
    believe_joints,
    correct_joint,
    predict_joint,
)

SETTINGS = np.dtype(
    [
        ("base", BASE_NOISE),
        ("rate", "f8"),
        ("surprise", "f8"),
        ("landing_surprise", "f8"),
        ("jerk", JERK),
        ("delay", "i8"),
    ]
)
"""Noise of the base's filter, of the joints' velocities [rad/s], error of the expected joint
accelerations, and what is added to it at touchdown [rad/s^2]; what is believed at once, and age of
the readings in cycles."""

TOUCH = 0.06
"""Part of its load from which on a swinging sole meets the ground: joints are jolted before it is
believed to stand."""

FORCE_PART = 0.003
"""Standard deviation of the force on a sole, of the weight: load cells are chosen for the robot
that they carry, and are as exact as that part of their range."""

SETTLING = 0.105
"""Within which a foot comes to rest after touchdown, but for 1 / e of its motion, in 1 / omega."""

_OWN = MappingProxyType(
    {
        "surprise": ("rad/s^2", 0.408),
        "landing_surprise": ("rad/s^2", 4.89),
        "slip": ("m/s^0.5", 3.34e-4),
        "light_slip": ("m/s^0.5", 0.2),
        "landing_slip": ("m/s^0.5", 0.0668),
        "twist": ("rad/s^0.5", 1.07e-4),
        "swing_twist": ("rad/s^0.5", 0.0107),
        "floor": ("m", 0.0125),
        "force": ("N", FORCE_PART),
    }
)
"""Units of the parameters that follow from the robot, and their defaults in `OwnUnits`."""

BIAS_WALK = 1e-5
"""How a gyroscope's offset wanders [rad/s^1.5]."""

_NOISE = {
    "encoder": "encoder",
    "gyro": "gyro",
    "accelerometer": "accelerometer",
    "bias": "gyro_bias",
    "slip": "slip",
    "light_slip": "light_slip",
    "landing_slip": "landing_slip",
    "twist": "twist",
    "swing_twist": "swing_twist",
    "floor": "floor",
    "force": "force",
    "period": "period",
}
"""Fields of `BASE_NOISE` by the parameters they are."""

_UNITS = {
    "encoder": "rad",
    "rate": "rad/s",
    "gyro": "rad/s",
    "accelerometer": "m/s^2",
    "gyro_bias": "rad/s",
    "period": "s",
}
"""Of the parameters that sensors or the loop have, the same for every robot."""


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
        base: a record of `BASE`, shape (1,).
        joints: records of `JOINT`, shape (n,).
        expected: accelerations asked for in the last cycles, a ring, flat [m/s^2, rad/s^2].
    """

    base: NDArray[np.void]
    joints: NDArray[np.void]
    expected: NDArray[np.float64]


@njit
def _filter_base(settings, base, links, angles, gyro, accelerometer, force, feet, past):
    """Base at the time of the readings; if an encoder is silent, the feet say nothing.

    The readings come as arrays of the robot's length, which no record holds.
    """
    noise, R, acceleration = settings.base, np.empty((3, 3)), np.empty(3)
    rotation_matrix(base.orientation, R)
    believe_gyro(settings, base, gyro, past)
    believe_accelerometer(settings, base, accelerometer, past, R, acceleration)
    carry_on(base, noise, acceleration)
    if not all_finite(angles):
        return
    soles = np.zeros(1, SOLES)[0]
    find_soles(links, angles, soles)
    listen_to_feet(base, noise, soles, feet, force)


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
def _estimate(
    settings, links, base, joints, expected,
    angles, velocities, gyro, accelerometer, force, feet, acceleration, qpos, qvel,
):  # fmt: skip
    """One cycle; base, joints, expected, qpos and qvel are changed.

    Records and readings, and MuJoCo's arrays of the robot's length, which no record holds.
    """
    size, delay = qvel.shape[0], settings[0].delay
    ring, now = delay + 1, base[0].cycles
    here = now % ring * size
    for i in range(size):
        expected[here + i] = acceleration[i] if math.isfinite(acceleration[i]) else 0.0
    # The oldest of the ring led to these readings, the others have acted since.
    oldest = (now + 1) % ring * size
    past = expected[oldest : oldest + size]
    believe_forces(settings[0], base[0], force)
    believed = np.empty((3, joints.shape[0]))
    believe_joints(settings[0], joints, angles, velocities, past, believed)
    _filter_base(settings[0], base[0], links, believed[2], gyro, accelerometer, force, feet, past)
    noise, fresh = settings[0], 0.0
    for foot in range(2):
        fresh = max(fresh, landing(base[0], noise.base, foot))
    for foot in range(2):
        if feet[foot] == 0 and base[0].load[foot] > TOUCH * noise.base.load:
            fresh = 1.0
    surprise = math.sqrt(noise.surprise**2 + (fresh * noise.landing_surprise) ** 2)
    for k in range(joints.shape[0]):
        predict_joint(joints[k], past[FREE + k], surprise, noise.base.period)
        correct_joint(joints[k], believed[0, k], believed[1, k], noise.base.encoder, noise.rate)
    _write(base[0], joints, qpos, qvel)
    for age in range(delay - 1, -1, -1):
        then = (now - age) % ring * size
        _move(qpos, qvel, expected[then : then + size], settings[0].base.period)
    base[0].cycles = now + 1


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    real, whole = np.dtype(np.float64), np.dtype(np.int64)
    own = (SETTINGS, LINK, BASE, JOINT)
    return (
        entry_point(begin, *own, *[real] * 3),
        entry_point(_estimate, *own, *[real] * 6, whole, *[real] * 3),
    )


def _copy(joints: NDArray[np.void]) -> NDArray[np.void]:
    """Half the time of the method `copy`, which goes field by field."""
    return np.ndarray(len(joints), JOINT, bytearray(joints.tobytes()))


@dataclass(frozen=True)
class BodyEstimator:
    """Estimates the state of a robot with a body from its readings.

    It is a value like a controller: what it remembers goes through `step`. In the world's frame it
    starts between its feet, on the floor, heading along x.

    Encoders, tachometers and inertial units are the same parts in every robot, so their noise does
    not follow from it. What is None does: it is said in `OwnUnits`, of the height h of the CoM and
    of omega.

    Args:
        multibody: the robot's mechanism.
        encoder: standard deviation of a joint's angle [rad].
        rate: likewise of its velocity [rad/s].
        gyro: likewise of the angular velocity [rad/s].
        accelerometer: likewise of the acceleration [m/s^2].
        gyro_bias: likewise of the gyroscope's constant offset, which is estimated [rad/s].
        surprise: how wrong expected joint accelerations are, likewise; 0.408 omega^2 [rad/s^2].
        landing_surprise: what is added to it at touchdown, and fades; 4.89 omega^2 [rad/s^2].
        slip: random walk of a standing sole; 3.34e-4 h sqrt(omega) [m/s^0.5].
        light_slip: what is added to it when no weight is on the sole; 0.2 h sqrt(omega)
            [m/s^0.5].
        landing_slip: what is added to it at touchdown, and fades; 0.0668 h sqrt(omega) [m/s^0.5].
        twist: random walk of a sole's heading while both stand; 1.07e-4 sqrt(omega) [rad/s^0.5].
        swing_twist: what is added to it while the other leg swings; 0.0107 sqrt(omega)
            [rad/s^0.5].
        floor: how uneven the floor is where a foot lands, standard deviation; h / 80 [m].
        force: standard deviation of the force on a sole; 0.3 % of the weight [N].
        delay: age of the readings, a whole number of periods; 0 predicts nothing [s].
        period: control period [s].

    Raises:
        ParameterError: a value is out of range, or the delay no whole number of periods.
    """

    multibody: Multibody
    encoder: float = 0.001
    rate: float = 0.1
    gyro: float = 0.005
    accelerometer: float = 0.1
    gyro_bias: float = 0.005
    surprise: float | None = None
    landing_surprise: float | None = None
    slip: float | None = None
    light_slip: float | None = None
    landing_slip: float | None = None
    twist: float | None = None
    swing_twist: float | None = None
    floor: float | None = None
    force: float | None = None
    delay: float = 0.0
    period: float = 0.001
    settings: NDArray[np.void] = field(init=False, repr=False, compare=False)
    links: NDArray[np.void] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name, unit in _UNITS.items():
            check_number(name, getattr(self, name), 0.0, unit, above=True)
        units = OwnUnits.of(self.multibody.robot)
        for name, value in units.fill(self, _OWN).items():
            check_number(name, value, 0.0, _OWN[name][0], above=name != "force")
        settings = new_array(SETTINGS)
        for name, source in _NOISE.items():
            settings["base"][name] = getattr(self, source)
        settings["base"]["bias_walk"] = BIAS_WALK
        weight = self.multibody.mass * STANDARD_GRAVITY
        settings["base"]["load"] = 0.5 * weight
        settings["base"]["settling"] = SETTLING * units.time
        for name in ("rate", "surprise", "landing_surprise"):
            settings[name] = getattr(self, name)
        for name, (unit, value) in OWN_JERK.items():
            time = self.period if name in ("turning", "angle") else 1.0
            settings["jerk"][name] = value * units.one(unit) * time
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
                    "wait until the sensors tell something",
                )
        ring = (int(self.settings["delay"][0]) + 1) * (FREE + joints)
        memory = BodyMemory(new_array(BASE), np.zeros(joints, JOINT), np.zeros(ring))
        angles, velocities, _, accelerometer, _ = values
        start, _ = _compiled()
        start(
            self.settings, self.links, memory.base, memory.joints, angles, velocities, accelerometer
        )
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
        base, joints, past = memory
        base, joints, past = copy_array(base), _copy(joints), past.copy()
        qpos, qvel = np.empty(FREE + 1 + len(joints)), np.empty(FREE + len(joints))
        _compiled()[1](
            self.settings, self.links, base, joints, past,
            readings.joint_angles, readings.joint_velocities, readings.gyro, readings.accelerometer,
            readings.foot_force, feet, expected, qpos, qvel,
        )  # fmt: skip
        return qpos, qvel, BodyMemory(base, joints, past)

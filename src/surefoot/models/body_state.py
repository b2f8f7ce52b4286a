"""The state of a robot with a body from what it senses: encoders, inertial unit, feet.

In a cycle the joints are filtered (`joint_filter`), the base follows from the inertial unit and
the standing feet (`base_filter`), and what was measured late is carried on to the present with the
accelerations that the controller has asked for since. The result is what MuJoCo calls qpos and
qvel: position and quaternion of the base, then the angles; the base's velocity in the world, its
angular velocity in its own frame, then the joints' velocities.
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
from surefoot.compiling import entry_point, njit
from surefoot.errors import ParameterError
from surefoot.models.base_filter import (
    BASE,
    BASE_NOISE,
    BIAS,
    POSITION,
    TILT,
    VELOCITY,
    carry_on,
    landing,
    listen_to_feet,
    put_foot,
)
from surefoot.models.estimator import whole_cycles
from surefoot.models.joint_filter import JOINT, correct_joint, predict_joint
from surefoot.models.leg_kinematics import LINK, SOLES, find_soles, leg_links
from surefoot.models.lipm import STANDARD_GRAVITY
from surefoot.models.multibody import Multibody
from surefoot.models.own_units import OwnUnits
from surefoot.models.quaternion import rotation_matrix, turned
from surefoot.models.record import copy_array, new_array

FREE = 6
"""Degrees of freedom of the base, in front of those of the joints."""

JERK = np.dtype(
    [
        (name, "f8")
        for name in ("turning", "acceleration", "rate", "angle", "force", "velocity", "tilt")
    ]
)
"""How far blows and impacts take a reading from what is expected, within one cycle, as standard
deviations: of the gyroscope [rad/s], the accelerometer [m/s^2], tachometers [rad/s] and encoders
[rad]; largest force on a sole [N]; and by how much velocity [m/s] and lean [rad] are less certain,
at most, where a reading was not believed."""

_OWN_JERK = {
    "turning": ("rad/s^2", 12.0),
    "acceleration": ("m/s^2", 0.5),
    "rate": ("rad/s", 1.0),
    "angle": ("rad/s", 2.0),
    "force": ("N", 10.0),
    "velocity": ("m/s", 0.05),
    "tilt": ("-", 0.003),
}
"""Likewise in `OwnUnits`; of turning and angles per second, since they take time. The largest that
were seen are half of what is believed at once, in strong pushes of 0.2 s and in landings of five
robots. Blows of 5 ms exceed it, and are believed a few cycles later."""

TRUSTED = 4.5
"""Standard deviations beyond which a reading is not believed."""

DOUBTS = 4
"""So many readings in a row are left out, not more: what lasts is no fault of a sensor."""

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
the senses in cycles."""

TOUCH = 0.06
"""Part of its load from which on a swinging sole meets the ground: joints are jolted before it is
believed to stand."""

FORCE_PART = 0.003
"""Standard deviation of the force on a sole, of the weight: load cells are chosen for the robot
that they carry, and are as exact as that part of their range."""

NOT_NOISE, SURE = 3.0, 3.0
"""A force counts that is more than so many standard deviations, from when on those in a row add up
to `SURE` times that. Noise alone does it in 1 cycle of 4e8, the third power of 0.00135, or rarer:
once in four days of a loop of 1 kHz. A ninefold one is believed at once, a fourfold in 3 cycles."""

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
"""Of the parameters that a sensor or the loop has, whoever's they are."""


class BodySenses(NamedTuple):
    """What a robot with a body senses in a cycle, arrays of float64.

    Attributes:
        time: when it was sensed [s].
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
def _all_finite(values):
    total = 0.0
    for i in range(values.shape[0]):
        total += values[i]
    return math.isfinite(total)


@njit
def _is_doubtful(off, variance, base, channel):
    """Whether a vector is off by more than chance, blows and impacts explain, and for how long."""
    square = off[0] * off[0] + off[1] * off[1] + off[2] * off[2]
    # A comparison with infinity: a reading that is not finite does not come here.
    if square <= TRUSTED * TRUSTED * variance:
        base.doubts[channel] = 0
        return False
    base.doubts[channel] = min(base.doubts[channel] + 1, DOUBTS + 1)
    return base.doubts[channel] <= DOUBTS


@njit
def _see_turning(settings, base, gyro, past):
    """Angular velocity of the base; one that is not measured, or not believed, is as expected.

    Where readings are believed late, what they said meanwhile is made up for.
    """
    noise, jerk, off = settings.base, settings.jerk, np.zeros(3)
    for i in range(3):
        base.turning[i] += past[3 + i] * noise.period
        off[i] = gyro[i] - base.bias[i] - base.turning[i]
    if not _all_finite(gyro):
        return
    variance = 2.0 * noise.gyro**2 + jerk.turning**2
    if _is_doubtful(off, variance, base, 0):
        for i in range(3):
            base.withheld[0, i] += off[i]
            lean = min(abs(off[i]) * noise.period, jerk.tilt)
            base.covariance[TILT + i, TILT + i] += lean * lean
        return
    turn, late = np.zeros(3), base.doubts[0] > DOUBTS
    for i in range(3):
        base.turning[i] += off[i]
        turn[i] = base.withheld[0, i] * noise.period if late else 0.0
        base.withheld[0, i] = 0.0
    turned(base.orientation, turn, base.orientation)


@njit
def _see_acceleration(settings, base, accelerometer, past, R, acceleration):
    """Acceleration of the base; one that is not measured, or not believed, is as expected.

    Where it was not believed, the velocity is less certain, and where it is believed late, what it
    said meanwhile is made up for.
    """
    noise, jerk, off = settings.base, settings.jerk, np.zeros(3)
    for i in range(3):
        acceleration[i] = past[i]
        off[i] = -past[i] - (STANDARD_GRAVITY if i == 2 else 0.0)
        for k in range(3):
            off[i] += R[i, k] * accelerometer[k]
    if not _all_finite(accelerometer):
        return
    variance = noise.accelerometer**2 + jerk.acceleration**2
    if _is_doubtful(off, variance, base, 1):
        for i in range(3):
            base.withheld[1, i] += off[i]
            speed = min(abs(off[i]) * noise.period, jerk.velocity)
            base.covariance[VELOCITY + i, VELOCITY + i] += speed * speed
        return
    late = base.doubts[1] > DOUBTS
    for i in range(3):
        acceleration[i] += off[i] + (base.withheld[1, i] if late else 0.0)
        base.withheld[1, i] = 0.0


@njit
def _see_joints(settings, joints, angles, velocities, past, told):
    """Write angles and velocities of the joints that are believed; the others are not a number.

    An angle or velocity that is believed late is followed at once.

    Args:
        settings: a `SETTINGS` record.
        joints: `JOINT` records; only how often they were doubted, and covariances, are changed.
        angles, velocities: as measured.
        past: accelerations that were expected.
        told: shape (3, n), written: angles and velocities, and angles that soles follow from.
    """
    noise, jerk, dt = settings.base, settings.jerk, settings.base.period
    for k in range(joints.shape[0]):
        joint = joints[k]
        rate = joint.velocity + past[FREE + k] * dt
        angle = joint.angle + rate * dt
        told[0, k] = told[2, k] = angles[k]
        told[1, k] = velocities[k]
        for which in range(2):
            reading = angles[k] if which == 0 else velocities[k]
            if not math.isfinite(reading):
                continue
            off = reading - (angle if which == 0 else rate)
            own = (
                noise.encoder**2 + jerk.angle**2 if which == 0 else settings.rate**2 + jerk.rate**2
            )
            here = 2 * which
            if off * off <= TRUSTED * TRUSTED * (joint.covariance[here] + own):
                joint.doubts[which] = 0
                continue
            joint.doubts[which] = min(joint.doubts[which] + 1, DOUBTS + 1)
            if joint.doubts[which] > DOUBTS:
                joint.covariance[here] += off * off
            else:
                told[which, k] = math.nan
                if which == 0:
                    told[2, k] = angle


@njit
def _filter_base(settings, base, links, angles, gyro, accelerometer, force, feet, past):
    """Base at the time of the senses; if an encoder is silent, the feet say nothing."""
    noise, R, acceleration = settings.base, np.empty((3, 3)), np.empty(3)
    rotation_matrix(base.orientation, R)
    _see_turning(settings, base, gyro, past)
    _see_acceleration(settings, base, accelerometer, past, R, acceleration)
    carry_on(base, noise, acceleration)
    if not _all_finite(angles):
        return
    soles = np.zeros(1, SOLES)[0]
    find_soles(links, angles, soles)
    listen_to_feet(base, noise, soles, feet, force)


@njit
def _weigh(settings, base, force):
    """The force on each sole that noise does not explain.

    One that is not finite, or that no robot of this weight stands on, is held.
    """
    least = NOT_NOISE * settings.base.force
    for foot in range(2):
        if not math.isfinite(force[foot]):
            continue
        if abs(force[foot]) > settings.jerk.force:
            base.doubts[2 + foot] = min(base.doubts[2 + foot] + 1, DOUBTS + 1)
            if base.doubts[2 + foot] <= DOUBTS:
                continue
        else:
            base.doubts[2 + foot] = 0
        more = base.evidence[foot] + force[foot] if force[foot] > least else 0.0
        base.evidence[foot] = min(more, SURE * least)
        base.load[foot] = force[foot] if more >= SURE * least else 0.0


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
    turned(orientation, turn, orientation)
    for k in range(FREE, qvel.shape[0]):
        qpos[1 + k] += qvel[k] * dt


@njit
def _estimate(
    settings, links, base, joints, expected,
    angles, velocities, gyro, accelerometer, force, feet, acceleration, qpos, qvel,
):  # fmt: skip
    """One cycle; base, joints, expected, qpos and qvel are changed."""
    size, delay = qvel.shape[0], settings[0].delay
    ring, now = delay + 1, base[0].cycles
    here = now % ring * size
    for i in range(size):
        expected[here + i] = acceleration[i] if math.isfinite(acceleration[i]) else 0.0
    # The oldest of the ring led to these senses, the others have acted since.
    oldest = (now + 1) % ring * size
    past = expected[oldest : oldest + size]
    _weigh(settings[0], base[0], force)
    told = np.empty((3, joints.shape[0]))
    _see_joints(settings[0], joints, angles, velocities, past, told)
    _filter_base(settings[0], base[0], links, told[2], gyro, accelerometer, force, feet, past)
    noise, fresh = settings[0], 0.0
    for foot in range(2):
        fresh = max(fresh, landing(base[0], noise.base, foot))
    for foot in range(2):
        if feet[foot] == 0 and base[0].load[foot] > TOUCH * noise.base.load:
            fresh = 1.0
    surprise = math.sqrt(noise.surprise**2 + (fresh * noise.landing_surprise) ** 2)
    for k in range(joints.shape[0]):
        predict_joint(joints[k], past[FREE + k], surprise, noise.base.period)
        correct_joint(joints[k], told[0, k], told[1, k], noise.base.encoder, noise.rate)
    _write(base[0], joints, qpos, qvel)
    for age in range(delay - 1, -1, -1):
        then = (now - age) % ring * size
        _move(qpos, qvel, expected[then : then + size], settings[0].base.period)
    base[0].cycles = now + 1


@njit
def _begin(settings, links, base, joints, angles, velocities, accelerometer):
    """Both feet stand: the middle of the soles is the origin, and the base heads along x."""
    noise, soles, R = settings[0].base, np.zeros(1, SOLES)[0], np.empty((3, 3))
    state, c = base[0], base[0].covariance
    x, y, z = accelerometer[0], accelerometer[1], accelerometer[2]
    upright, level = np.array((1.0, 0.0, 0.0, 0.0)), np.array((0.0, 0.0, 0.0))
    level[1] = math.atan2(-x, math.sqrt(y * y + z * z))
    turned(upright, level, state.orientation)
    level[0], level[1] = math.atan2(y, z), 0.0
    turned(state.orientation, level, state.orientation)
    for k in range(joints.shape[0]):
        joints[k].angle, joints[k].velocity = angles[k], velocities[k]
        joints[k].covariance[0] = settings[0].base.encoder ** 2
        joints[k].covariance[2] = settings[0].rate ** 2
    find_soles(links, angles, soles)
    rotation_matrix(state.orientation, R)
    for i in range(3):
        for k in range(3):
            state.position[i] -= 0.5 * R[i, k] * (soles.position[0, k] + soles.position[1, k])
        c[BIAS + i, BIAS + i] = noise.bias**2
    _lean(c, state.position, noise.accelerometer / STANDARD_GRAVITY)
    for foot in range(2):
        put_foot(state, noise, soles, foot)


@njit
def _lean(c, arm, lean):
    """A lean that is wrong moves the base, `arm` over its soles, whose middle is known."""
    h = np.zeros((3, 2))
    h[0, 1], h[1, 0], h[2, 0], h[2, 1] = arm[2], -arm[2], arm[1], -arm[0]
    for j in range(2):
        c[TILT + j, TILT + j] = lean**2
        for i in range(3):
            c[POSITION + i, TILT + j] = c[TILT + j, POSITION + i] = h[i, j] * lean**2
            for k in range(3):
                c[POSITION + i, POSITION + k] += h[i, j] * h[k, j] * lean**2


@cache
def _compiled() -> tuple[Callable[..., None], Callable[..., None]]:
    real, whole = np.dtype(np.float64), np.dtype(np.int64)
    own = (SETTINGS, LINK, BASE, JOINT)
    return (
        entry_point(_begin, *own, *[real] * 3),
        entry_point(_estimate, *own, *[real] * 6, whole, *[real] * 3),
    )


def _copy(joints: NDArray[np.void]) -> NDArray[np.void]:
    """Half the time of the method `copy`, which goes field by field."""
    return np.ndarray(len(joints), JOINT, bytearray(joints.tobytes()))


@dataclass(frozen=True)
class BodyEstimator:
    """Estimates the state of a robot with a body from its senses.

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
        delay: age of the senses, a whole number of periods; 0 predicts nothing [s].
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
        for name, (unit, value) in _OWN_JERK.items():
            time = self.period if name in ("turning", "angle") else 1.0
            settings["jerk"][name] = value * units.one(unit) * time
        settings["delay"] = whole_cycles(self.delay, self.period)
        object.__setattr__(self, "settings", settings)
        object.__setattr__(self, "links", leg_links(self.multibody))

    def start(self, senses: BodySenses) -> BodyMemory:
        """What it remembers before the first cycle: the robot stands still on both feet.

        Raises:
            ParameterError: a reading is missing, not finite, or of another shape.
        """
        joints = self.multibody.model.nv - FREE
        shapes = ((joints,), (joints,), (3,), (3,), (2,))
        readings = senses[1:]
        for name, reading, shape in zip(senses._fields[1:], readings, shapes, strict=True):
            if np.shape(reading) != shape or not np.all(np.isfinite(reading)):
                raise ParameterError(
                    f"`{name}` of shape {shape}, finite, to start with",
                    repr(reading),
                    "wait until the sensors tell something",
                )
        ring = (int(self.settings["delay"][0]) + 1) * (FREE + joints)
        memory = BodyMemory(new_array(BASE), np.zeros(joints, JOINT), np.zeros(ring))
        angles, velocities, _, accelerometer, _ = readings
        begin, _ = _compiled()
        begin(
            self.settings, self.links, memory.base, memory.joints, angles, velocities, accelerometer
        )
        return memory

    def step(
        self,
        memory: BodyMemory,
        senses: BodySenses,
        feet: NDArray[np.int64],
        expected: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], BodyMemory]:
        """One cycle: generalised positions and velocities now, and what to remember.

        A reading that is not finite is left out.

        Args:
            memory: of the cycle before, or of `start`.
            senses: of now, or `delay` old.
            feet: which soles are believed to stand, left and right, shape (2,): 1 or 0.
            expected: accelerations that the controller asked for since the cycle before, shape
                (nv,) like qvel; zeros if unknown.
        """
        base, joints, past = memory
        base, joints, past = copy_array(base), _copy(joints), past.copy()
        qpos, qvel = np.empty(FREE + 1 + len(joints)), np.empty(FREE + len(joints))
        _compiled()[1](
            self.settings, self.links, base, joints, past,
            senses.joint_angles, senses.joint_velocities, senses.gyro, senses.accelerometer,
            senses.foot_force, feet, expected, qpos, qvel,
        )  # fmt: skip
        return qpos, qvel, BodyMemory(base, joints, past)

"""What disturbs a walk besides pushes: measurements that are off, late or noisy, and feet that land
elsewhere or at another time than planned.

Random numbers are functions of where they are used, not of what was drawn before: the number of a
seed, a step, a cycle and a channel is a hash of the four, splitmix64 (Steele, Lea, Flood 2014). So
a walk has the same noise compiled or not, alone or among others, on any number of threads, and from
any cycle on.

A plant of another mass or height is a disturbance too: `simulate` takes it as `plant`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.checks import check_seed
from surefoot.compiled import njit
from surefoot.control.estimator import MAX_CYCLES
from surefoot.control.fields import check_fields, documented, setting
from surefoot.record import Array, Record, Vector2, field


class SensorErrors(Record):
    """Parameters of what is measured: as in `Disturbance`, with the delay in cycles."""

    dcm_noise: float = field("m", "standard deviation of CoM and DCM")
    velocity_noise: float = field("m/s", "likewise of the CoM's velocity")
    com_offset: Vector2 = field("m", "constant error of CoM and DCM")
    omega: float = field("1/s", "that makes a DCM of a velocity, as the controller believes")
    delay: int = field("-", "age in cycles")
    seed: int = field("", "of the noise")


class DelayLine(Record):
    """CoM and its velocity in the last cycles, as a ring."""

    com: Array = field("m", "centre of mass", shape=(MAX_CYCLES, 2))
    com_velocity: Array = field("m/s", "its velocity", shape=(MAX_CYCLES, 2))
    count: int = field("-", "how many cycles there were")


SENSOR_ERRORS, DELAY_LINE = SensorErrors.DTYPE, DelayLine.DTYPE

_POSITION, _VELOCITY, _LANDING = range(3)

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_UNIT = 2.0**-53


@documented
@dataclass(frozen=True)
class Disturbance:
    """Errors of what is measured, and of where and when feet land.

    The pendulum's estimate (`com`, `com_velocity`, `dcm`) may be noisy, late and off. Clock, own
    feet and contact are not: encoders, gyroscopes and foot switches are fast and good.

    All of it is absolute and off by default: the noise of a sensor, the delay of a bus and the
    roughness of a floor do not shrink with the robot that meets them.

    Raises:
        ParameterError: a value is out of range.
    """

    dcm_noise: float = setting(
        0.0, "m",
        "standard deviation of what is added to CoM and DCM alike, drawn anew for each axis in "
        "every control cycle", least=0.0,
    )  # fmt: skip
    velocity_noise: float = setting(
        0.0, "m/s", "likewise of the CoM's velocity; it moves the DCM by velocity / omega",
        least=0.0,
    )  # fmt: skip
    delay: float = setting(
        0.0, "s",
        "age of the estimate, a whole number of control periods. Counted in cycles, the shorter "
        "one that a touchdown ends among them", least=0.0,
    )  # fmt: skip
    com_offset: tuple[float, float] = setting(
        (0.0, 0.0), "m", "constant error of CoM and DCM (x, y)", least=-math.inf
    )
    landing_error: float = setting(
        0.0, "m",
        "every foot comes to stand this far from where it was when it touched the ground, in a "
        "direction that is drawn for each landing", least=0.0,
    )  # fmt: skip
    touchdown_shift: float = setting(
        0.0, "s",
        "negative: the ground comes that much before the landing is due, and the foot stands where "
        "it is then; positive: that much later, and the foot waits for it at its place",
        least=-math.inf,
    )  # fmt: skip
    seed: int = setting(
        0, "", "of everything that is drawn. The same seed gives the same numbers in any cycle"
    )

    def __post_init__(self) -> None:
        check_fields(self)
        check_seed(self.seed)

    @property
    def blurs(self) -> bool:
        """Whether anything but the truth is measured."""
        noisy = self.dcm_noise > 0.0 or self.velocity_noise > 0.0
        return noisy or self.delay > 0.0 or self.com_offset != (0.0, 0.0)


@njit
def mixed(bits):
    """One output of splitmix64 from the state `bits`, all of them uint64."""
    bits = bits + _STEP
    bits = (bits ^ (bits >> _30)) * _FIRST
    bits = (bits ^ (bits >> _27)) * _SECOND
    return bits ^ (bits >> _31)


@njit
def noise_key(seed: int, steps: int, cycle: int):
    """What all channels of one control cycle have in common, a uint64.

    Args:
        seed: of the walk.
        steps: finished before this cycle.
        cycle: since the last touchdown.
    """
    return mixed(mixed(mixed(np.uint64(seed)) ^ np.uint64(steps)) ^ np.uint64(cycle))


@njit
def uniform(key, channel: int) -> float:
    """A number in (0, 1], uniformly distributed.

    Args:
        key: of `noise_key`.
        channel: which of the numbers of this cycle.
    """
    bits = mixed(key ^ np.uint64(channel))
    return (np.float64(bits >> _11) + 0.5) * _UNIT


@njit
def normal_pair(key, channel: int) -> tuple[float, float]:
    """Two independent numbers, normally distributed with mean 0 and variance 1: Box and Muller.

    Args:
        key: of `noise_key`.
        channel: which pair of this cycle; no other may use the channels 2 `channel` and the next.
    """
    radius = math.sqrt(-2.0 * math.log(uniform(key, 2 * channel)))
    angle = 2.0 * math.pi * uniform(key, 2 * channel + 1)
    return radius * math.cos(angle), radius * math.sin(angle)


@njit
def disturb(errors, world, line, measured):
    """What is measured of the world in this cycle: late, then off, then noisy.

    Until the delay has passed, the first measurement is repeated.

    Args:
        errors: `SensorErrors`.
        world: a `LipmWorld`.
        line: a `DelayLine`; moved on by a cycle if there is a delay.
        measured: an `Observation` that is a copy of the truth, changed.
    """
    if errors.delay > 0:
        _wait(errors.delay, line, measured)
    measured.com[0] += errors.com_offset[0]
    measured.com[1] += errors.com_offset[1]
    if errors.dcm_noise > 0.0 or errors.velocity_noise > 0.0:
        key = noise_key(errors.seed, world.steps, world.cycle)
        noise_x, noise_y = normal_pair(key, _POSITION)
        measured.com[0] += errors.dcm_noise * noise_x
        measured.com[1] += errors.dcm_noise * noise_y
        noise_x, noise_y = normal_pair(key, _VELOCITY)
        measured.com_velocity[0] += errors.velocity_noise * noise_x
        measured.com_velocity[1] += errors.velocity_noise * noise_y
    for i in range(2):
        measured.dcm[i] = measured.com[i] + measured.com_velocity[i] / errors.omega


@njit
def _wait(delay, line, measured):
    """Put CoM and velocity into the line, and take out those of `delay` cycles ago."""
    new = line.count % MAX_CYCLES
    for i in range(2):
        line.com[new, i] = measured.com[i]
        line.com_velocity[new, i] = measured.com_velocity[i]
    old = max(line.count - delay, 0) % MAX_CYCLES
    for i in range(2):
        measured.com[i] = line.com[old, i]
        measured.com_velocity[i] = line.com_velocity[old, i]
    line.count += 1


@njit
def misplace(error, seed, steps, observation):
    """Shift the foot that has just touched the ground, in a direction of its own [m]."""
    # A cycle of no number: what is measured has its noise from the cycles that have one.
    angle = 2.0 * math.pi * uniform(noise_key(seed, steps, -1), _LANDING)
    observation.swing_foot[0] += error * math.cos(angle)
    observation.swing_foot[1] += error * math.sin(angle)

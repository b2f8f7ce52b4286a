"""What a walk is disturbed by besides pushes: what is seen of it is wrong, late or noisy, and the
feet land elsewhere or at another time than they are to.

A plant of another mass or height is a disturbance too: `simulate` takes it as `plant`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.checks import check_number, check_pair, check_seed
from surefoot.compiled import njit
from surefoot.control.estimator import MOST_CYCLES
from surefoot.rollout.noise import noise_key, normal_pair, uniform

SIGHT = np.dtype(
    [
        ("dcm_noise", "f8"),
        ("velocity_noise", "f8"),
        ("com_offset", "f8", (2,)),
        ("omega", "f8"),
        ("delay", "i8"),
        ("seed", "i8"),
    ],
)
"""Parameters of what is seen: as in `Disturbance`, with the delay in cycles; `omega` is the natural
frequency that makes a DCM of a velocity, the one the controller believes in [1/s]."""

DELAY_LINE = np.dtype(
    [
        ("com", "f8", (MOST_CYCLES, 2)),
        ("com_velocity", "f8", (MOST_CYCLES, 2)),
        ("count", "i8"),
    ],
)
"""CoM [m] and its velocity [m/s] in the last cycles, as a ring, and how many cycles there were."""

_POSITION, _VELOCITY, _LANDING = range(3)


@dataclass(frozen=True)
class Disturbance:
    """What is wrong with what a controller sees, and with where and when its feet land.

    The pendulum's estimate (`com`, `com_velocity`, `dcm`) may be noisy, late and off. Clock, own
    feet and contact are not: encoders, gyroscopes and foot switches are fast and good.

    All of it is absolute and off by default: the noise of a sensor, the delay of a bus and the
    roughness of a floor do not shrink with the robot that meets them.

    Args:
        dcm_noise: standard deviation of what is added to CoM and DCM alike, drawn anew for each
            axis in every control cycle [m].
        velocity_noise: likewise of the CoM's velocity; it moves the DCM by velocity / omega [m/s].
        delay: age of the estimate, a whole number of control periods. Counted in cycles, the
            shorter one that a touchdown ends among them [s].
        com_offset: constant error of CoM and DCM (x, y) [m].
        landing_error: every foot comes to stand this far from where it was when it touched the
            ground, in a direction that is drawn for each landing [m].
        touchdown_shift: negative: the ground comes that much before the landing is due, and the
            foot stands where it is then; positive: that much later, and the foot waits for it at
            its place [s].
        seed: of everything that is drawn. The same seed gives the same numbers in any cycle.

    Raises:
        ParameterError: a value is out of range.
    """

    dcm_noise: float = 0.0
    velocity_noise: float = 0.0
    delay: float = 0.0
    com_offset: tuple[float, float] = (0.0, 0.0)
    landing_error: float = 0.0
    touchdown_shift: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        check_number("dcm_noise", self.dcm_noise, 0.0, "m")
        check_number("velocity_noise", self.velocity_noise, 0.0, "m/s")
        check_number("delay", self.delay, 0.0, "s")
        check_pair("com_offset", self.com_offset, -math.inf, "m")
        check_number("landing_error", self.landing_error, 0.0, "m")
        check_number("touchdown_shift", self.touchdown_shift, -math.inf, "s")
        check_seed(self.seed)

    @property
    def blurs(self) -> bool:
        """Whether a controller sees anything but the truth."""
        noisy = self.dcm_noise > 0.0 or self.velocity_noise > 0.0
        return noisy or self.delay > 0.0 or self.com_offset != (0.0, 0.0)


@njit
def look(sight, world, line, seen):
    """What is seen of the world in this cycle: late, then off, then noisy.

    Before the first cycle nothing was seen: until the delay has passed, that is what is seen.

    Args:
        sight: a `SIGHT` record.
        world: a `LIPM_WORLD` record.
        line: a `DELAY_LINE` record; moved on by a cycle if there is a delay.
        seen: an `OBSERVATION` record that is a copy of the truth, changed.
    """
    if sight.delay > 0:
        _wait(sight.delay, line, seen)
    seen.com[0] += sight.com_offset[0]
    seen.com[1] += sight.com_offset[1]
    if sight.dcm_noise > 0.0 or sight.velocity_noise > 0.0:
        key = noise_key(sight.seed, world.steps, world.cycle)
        noise_x, noise_y = normal_pair(key, _POSITION)
        seen.com[0] += sight.dcm_noise * noise_x
        seen.com[1] += sight.dcm_noise * noise_y
        noise_x, noise_y = normal_pair(key, _VELOCITY)
        seen.com_velocity[0] += sight.velocity_noise * noise_x
        seen.com_velocity[1] += sight.velocity_noise * noise_y
    for i in range(2):
        seen.dcm[i] = seen.com[i] + seen.com_velocity[i] / sight.omega


@njit
def _wait(delay, line, seen):
    """Put CoM and velocity into the line, and take out those of `delay` cycles ago."""
    new = line.count % MOST_CYCLES
    for i in range(2):
        line.com[new, i] = seen.com[i]
        line.com_velocity[new, i] = seen.com_velocity[i]
    old = max(line.count - delay, 0) % MOST_CYCLES
    for i in range(2):
        seen.com[i] = line.com[old, i]
        seen.com_velocity[i] = line.com_velocity[old, i]
    line.count += 1


@njit
def misplace(error, seed, steps, observation):
    """Shift the foot that has just touched the ground, in a direction of its own [m]."""
    # A cycle of no number: what is seen has its noise from the cycles that have one.
    angle = 2.0 * math.pi * uniform(noise_key(seed, steps, -1), _LANDING)
    observation.swing_foot[0] += error * math.cos(angle)
    observation.swing_foot[1] += error * math.sin(angle)

"""What stands between noisy, late or offset measurements and any controller, in three parts.

Each is off unless it is given its number, and works without the others. All run the pendulum's
model beside the robot, with the ZMPs that were commanded: the DCM runs away from the ZMP and the
convergent part of the motion, com - com_velocity / omega, towards it, each by itself, exactly:

    dcm <- p + (dcm - p) g,    convergent <- p + (convergent - p) / g,    g = e^(omega dt).

**Offset.** The measured DCM is m = dcm + b, with b constant. The pendulum falls about its true
ZMP, so b = m - p - m' / omega: it is observable at all times, standing or walking, if the ZMP is
known. An error of the ZMP gives the same, and a constant force too (b = -F / (m omega^2)).
The observer dcm <- dcm + k1 i, b <- b + k2 i with the innovation i = m - dcm - b has both its poles
at z = e^(-dt / bias_time) for

    k1 = (g - z)^2 / (g (g - 1)),    k1 + k2 = 1 - z^2 / g.

k2 is negative: an offset that is new looks like a DCM that runs away, so the
estimate goes the wrong way before it goes the right one, the more so the shorter `bias_time` is
against 1 / omega. After a step of the offset the error is below 10 % from about 5 bias_time on. An
innovation above `bias_limit` is a push rather than an offset; the offset stays as it is until none
has been for `bias_time`.

**Noise.** An observer of constant gain, whose error decays with `filter_time`: k = 1 - z / g for
the DCM and 1 - z g for the convergent part (not below 0: it decays by itself). A push shows that
much later.

**Delay.** What was measured `delay` ago, through the cycles since, with their own ZMPs. A push
that came since is not known.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from surefoot.checks import check_number
from surefoot.compiled import njit, record_entry_point
from surefoot.errors import ParameterError
from surefoot.interface import Command, Observation
from surefoot.record import Array, Record, Vector2, copy_array, field, new_array
from surefoot.robot.robot import Robot

MAX_CYCLES = 128
"""A delay is shorter than this many cycles."""

WHOLE = 1e-6
"""Fraction of a period by which a delay may miss a whole number of them."""

NO_TIME = 1e-6
"""A cycle that is shorter than this fraction of a period says nothing."""

BIAS_LIMIT = 0.0375
"""Largest offset, if none is given, as a fraction of the height of the CoM: 3 cm of 0.8 m."""


class EstimatorParameters(Record):
    """Of an `Estimator`."""

    omega: float = field("1/s", "natural frequency")
    weight: float = field("N", "of the robot")
    period: float = field("s", "control period")
    delay: int = field("", "in cycles")
    filter_time: float = field("s", "0 if nothing is filtered")
    bias_time: float = field("s", "0 if no offset is estimated")
    bias_limit: float = field("m", "of the offset")


class Estimate(Record):
    """What an estimator remembers; of the last cycles as a ring."""

    pivot: Array = field("m", "ZMP of a cycle", shape=(MAX_CYCLES, 2))
    duration: Array = field("s", "of a cycle", shape=MAX_CYCLES)
    growth: Array = field("-", "e^(omega duration)", shape=MAX_CYCLES)
    cycles: int = field("", "how many there were")
    started: int = field("", "1 once there was an observation")
    time: float = field("s", "of the last one")
    dcm: Vector2 = field("m", "when it was measured last")
    convergent: Vector2 = field("m", "likewise")
    bias: Vector2 = field("m", "the offset")
    bias_dcm: Vector2 = field("m", "DCM of the observer of the offset")
    calm_time: Vector2 = field("s", "until when it waits for a push to pass")


ESTIMATOR, ESTIMATE = EstimatorParameters.DTYPE, Estimate.DTYPE
"""The same for kernels, which know no classes."""


@njit
def _remember(parameters, estimate, time, command):
    """Take the cycle that has just ended into the ring."""
    here = estimate.cycles % MAX_CYCLES
    for i in range(2):
        # A torque on the trunk pushes the CoM like a ZMP that lies elsewhere.
        estimate.pivot[here, i] = command.zmp[i] + command.hip_torque[i] / parameters.weight
    estimate.duration[here] = time - estimate.time
    estimate.growth[here] = math.exp(parameters.omega * estimate.duration[here])
    estimate.cycles += 1


@njit
def _learn_offset(parameters, estimate, measured, i, cycle):
    """One cycle of the observer of the offset, one axis; `measured` is the DCM."""
    pivot, duration = estimate.pivot[cycle, i], estimate.duration[cycle]
    growth, limit = estimate.growth[cycle], parameters.bias_limit
    if duration < NO_TIME * parameters.period:
        return
    free = pivot + (estimate.bias_dcm[i] - pivot) * growth
    innovation = measured - free - estimate.bias[i]
    if abs(innovation) > limit:
        estimate.calm_time[i] = estimate.time + parameters.bias_time
    if estimate.time < estimate.calm_time[i]:
        estimate.bias_dcm[i] = measured - estimate.bias[i]
        return
    z = math.exp(-duration / parameters.bias_time)
    first = (growth - z) * (growth - z) / (growth * (growth - 1.0))
    second = 1.0 - z * z / growth - first
    estimate.bias_dcm[i] = free + first * innovation
    estimate.bias[i] = min(max(estimate.bias[i] + second * innovation, -limit), limit)


@njit
def _correct(parameters, estimate, measured, i, cycle):
    """Take one axis of a measurement in; `cycle` led to it from the one before."""
    dcm = measured.com[i] + measured.com_velocity[i] / parameters.omega
    convergent = measured.com[i] - measured.com_velocity[i] / parameters.omega
    if parameters.bias_time > 0.0:
        _learn_offset(parameters, estimate, dcm, i, cycle)
        dcm -= estimate.bias[i]
        convergent -= estimate.bias[i]
    if parameters.filter_time > 0.0:
        pivot, growth = estimate.pivot[cycle, i], estimate.growth[cycle]
        z = math.exp(-estimate.duration[cycle] / parameters.filter_time)
        model = pivot + (estimate.dcm[i] - pivot) * growth
        dcm = model + (1.0 - z / growth) * (dcm - model)
        model = pivot + (estimate.convergent[i] - pivot) / growth
        convergent = model + max(1.0 - z * growth, 0.0) * (convergent - model)
    estimate.dcm[i], estimate.convergent[i] = dcm, convergent


@njit
def _begin(parameters, estimate, measured):
    """Take the first measurement as it is."""
    estimate.started = 1
    for i in range(2):
        estimate.calm_time[i] = measured.time
        lead = measured.com_velocity[i] / parameters.omega
        estimate.dcm[i], estimate.convergent[i] = measured.com[i] + lead, measured.com[i] - lead
        estimate.bias_dcm[i] = estimate.dcm[i]


@njit
def estimate_cycle(parameters, estimate, measured, command):
    """Replace CoM, its velocity and the DCM of an observation by their estimates.

    An observation that is not finite is left as it is, and nothing is learnt from it.

    Args:
        parameters: an `EstimatorParameters` record.
        estimate: an `Estimate` record, changed.
        measured: an `Observation` record, changed.
        command: the `Command` record that was carried out since the last observation.
    """
    total = measured.time
    for i in range(2):
        total += measured.com[i] + measured.com_velocity[i]
    if not math.isfinite(total):
        return
    begins = estimate.started == 0
    if begins:
        _begin(parameters, estimate, measured)
    else:
        _remember(parameters, estimate, measured.time, command)
    estimate.time = measured.time
    # Until the delay has passed it is the first state that is measured, again and again.
    fresh = estimate.cycles - parameters.delay
    for i in range(2):
        if fresh > 0:
            _correct(parameters, estimate, measured, i, (fresh - 1) % MAX_CYCLES)
        dcm, convergent = estimate.dcm[i], estimate.convergent[i]
        for cycle in range(max(fresh, 0), estimate.cycles):
            here = cycle % MAX_CYCLES
            pivot, growth = estimate.pivot[here, i], estimate.growth[here]
            dcm = pivot + (dcm - pivot) * growth
            convergent = pivot + (convergent - pivot) / growth
        measured.com[i] = 0.5 * (dcm + convergent)
        measured.com_velocity[i] = 0.5 * parameters.omega * (dcm - convergent)
        measured.dcm[i] = dcm


@cache
def _compiled() -> Callable[..., None]:
    return record_entry_point(estimate_cycle, EstimatorParameters, Estimate, Observation, Command)


def whole_cycles(delay: float, period: float) -> int:
    """A delay as a number of control cycles.

    Raises:
        ParameterError: it is no whole number of periods, or too long.
    """
    cycles = round(delay / period)
    if abs(cycles * period - delay) > WHOLE * period or cycles >= MAX_CYCLES:
        raise ParameterError(
            f"`delay` as a whole number of periods of {period:g} s, below {MAX_CYCLES}",
            f"{delay!r} s",
            f"write for example {min(max(cycles, 1), MAX_CYCLES - 1) * period:g}",
        )
    return cycles


@dataclass(frozen=True)
class Estimator:
    """Estimates CoM and DCM for any controller from measurements that are noisy, late or offset.

    It is a value like a controller: what it remembers goes through `step`. In `simulate` it stands
    between the world, disturbances included, and the controller. Its equations are in the head of
    `control/estimator.py`.

    Args:
        robot: whose pendulum it is; that of the controller.
        delay: age of the measurements, a whole number of periods; 0 predicts nothing [s].
        filter_time: within which an error of the estimate decays by e; 0 filters nothing [s].
        bias_time: likewise for the estimate of a constant offset of CoM and DCM; 0 estimates none.
            Sensible from 1 / robot.omega on [s].
        bias_limit: the offset is no larger than this, in x and in y; 3.75 % of the height of the
            CoM if None [m].
        period: control period [s].

    Raises:
        ParameterError: a value is out of range, or the delay no whole number of periods.
    """

    robot: Robot
    delay: float = 0.0
    filter_time: float = 0.0
    bias_time: float = 0.0
    bias_limit: float | None = None
    period: float = 0.001
    parameters: NDArray[np.void] = dataclasses.field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("delay", "filter_time", "bias_time"):
            check_number(name, getattr(self, name), 0.0, "s")
        own = BIAS_LIMIT * self.robot.com_height
        limit = own if self.bias_limit is None else self.bias_limit
        check_number("bias_limit", limit, 0.0, "m", above=True)
        object.__setattr__(self, "bias_limit", limit)
        check_number("period", self.period, 0.0, "s", above=True)
        parameters = EstimatorParameters(
            omega=self.robot.omega,
            weight=self.robot.mass * self.robot.gravity,
            period=self.period,
            delay=whole_cycles(self.delay, self.period),
            filter_time=self.filter_time,
            bias_time=self.bias_time,
            bias_limit=limit,
        )
        object.__setattr__(self, "parameters", parameters.array)

    @property
    def works(self) -> bool:
        """Whether any of its parts is on."""
        return self.delay > 0.0 or self.filter_time > 0.0 or self.bias_time > 0.0

    def start(self) -> NDArray[np.void]:
        """What it remembers before the first observation: nothing."""
        return new_array(ESTIMATE)

    def step(
        self, memory: NDArray[np.void], observation: Observation, command: Command
    ) -> tuple[Observation, NDArray[np.void]]:
        """One cycle: the observation to decide on, and what to remember.

        Args:
            memory: of the cycle before, or of `start`.
            observation: as it was measured.
            command: what was carried out since the last observation; of no matter in the first.
        """
        memory, estimate = copy_array(memory), copy_array(observation.array)
        _compiled()(self.parameters, memory, estimate, command.array)
        return Observation.of(estimate), memory

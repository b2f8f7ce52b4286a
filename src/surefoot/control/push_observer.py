"""Observe the push from the motion of the DCM: no force sensor, no mass needed.

Between two cycles the DCM flows about the commanded ZMP. What it does beyond that is the push: with
f = F / (m omega^2) it is f (e^(omega dt) - 1), so f follows at once. Measured like this, noise of
the DCM counts 1 / (omega dt) times, three hundred times at 1 kHz. So beside the estimate of the
moment there are some that are smoothed, and the noise is watched: it makes estimates jump to and
fro, which a push does only when it begins and ends. The fastest estimate that stands out from its
own noise is the answer; without noise that is the one of the moment. Own derivation; in the world
frame, for the sides of the feet change places at a touchdown.
"""

from __future__ import annotations

import math

from surefoot.compiled import njit
from surefoot.control.validation import PENDULUM
from surefoot.record import Array, Record, Vector2, field

SMOOTHINGS = (0.0, 0.014, 0.056, 0.224)
"""Time constants of the estimates [1/omega]."""

NOISE_TIME = 0.35
"""Time constant with which the noise is learnt [1/omega]."""

SURE = 5.0
"""An estimate that is this many standard deviations from zero is a push."""

HARMLESS = 0.2
"""So is one whose noise, as many times, is below this part of the gait's room R: it would change
nothing."""

OUTLIER = 9.0
"""A squared jump larger than this many times the usual one is the edge of a push."""

NO_FORCE = 4e-9
"""An estimate that is no larger than this part of R is rounding."""

LONGEST_GAP = 3.5
"""A gap between two cycles counts no longer than this [1/omega]."""

SHORT = 0.2
"""A cycle shorter than this part of a period says too little of the force in it."""

_COUNT = len(SMOOTHINGS)


class Observing(Record):
    """Parameters of the observer."""

    omega: float = field("1/s", "natural frequency")
    period: float = field("s", "control period")
    follow: Array = field("-", "how much each estimate follows in a cycle", shape=_COUNT)
    learn: float = field("-", "how much the noise is learnt in one")
    harmless: float = field("m", "noise that changes nothing")
    rounding: float = field("m", "an estimate that is none")


class PushObserver(Record):
    """What it remembers."""

    force: Vector2 = field("m", "f, the answer")
    estimate: Array = field("m", "of each smoothing, by axis", shape=(2, _COUNT))
    jump: Vector2 = field("m^2", "mean square of how the estimates jump")
    time: float = field("s", "of the last cycle")
    dcm: Vector2 = field("m", "of the last cycle")
    zmp: Vector2 = field("m", "commanded in the last cycle")
    known: int = field("", "1 if that cycle was observed, 0 if there is none to compare with")


def observing(omega: float, period: float, room: float) -> Observing:
    """The parameters for a natural frequency [1/s], a control period [s] and the room R [m]."""
    step = omega * period
    return Observing(
        omega=omega,
        period=period,
        follow=[-math.expm1(-step / time) if time > 0.0 else 1.0 for time in SMOOTHINGS],
        learn=-math.expm1(-step / NOISE_TIME),
        harmless=HARMLESS * room,
        rounding=NO_FORCE * room,
    )


@njit(forceinline=True)
def _answer(parameters, observer, axis):
    """The fastest estimate that is sure."""
    for k in range(_COUNT):
        value, part = observer.estimate[axis, k], parameters.follow[k]
        # Of white noise s in the DCM a jump is (1, -2, 1) s, and an estimate has `part` of (1, -1).
        noise = part * math.sqrt(observer.jump[axis] / (3.0 * (2.0 - part)))
        if SURE * noise <= max(parameters.harmless, abs(value)):
            return 0.0 if abs(value) < parameters.rounding else value
    return 0.0


@njit(forceinline=True)
def observe_push(parameters, last, observation, observer):
    """Write the estimates of this cycle.

    Args:
        parameters: an `Observing` record.
        last: the `PushObserver` record of the last cycle.
        observation: an `Observation` record.
        observer: the record of this cycle; DCM and ZMP are for `remember` to write.
    """
    observer.jump = last.jump
    if last.known == 0:
        # What pushed before a gap may be over.
        for i in range(2):
            observer.force[i] = 0.0
            for k in range(_COUNT):
                observer.estimate[i, k] = 0.0
        return
    observer.force, observer.estimate = last.force, last.estimate
    elapsed = observation.time - last.time
    if elapsed <= SHORT * parameters.period:
        return
    growth = math.exp(min(parameters.omega * elapsed, LONGEST_GAP))
    for i in range(2):
        expected = last.zmp[i] + (last.dcm[i] - last.zmp[i]) * growth
        force = (observation.dcm[i] - expected) / (growth - 1.0)
        jump, usual = force - last.estimate[i, 0], last.jump[i]
        square = min(jump * jump, OUTLIER * usual + parameters.harmless**2)
        observer.jump[i] = usual + parameters.learn * (square - usual)
        for k in range(_COUNT):
            before = last.estimate[i, k]
            observer.estimate[i, k] = before + parameters.follow[k] * (force - before)
        observer.force[i] = _answer(parameters, observer, i)


@njit(forceinline=True)
def remember(observation, zmp, predicted, observer):
    """Keep what the next cycle compares with: when and where the DCM was, and the ZMP from now.

    Nothing pushes a pendulum that is only `predicted`: there is nothing to compare with then.
    """
    observer.time, observer.known = observation.time, 0 if predicted & PENDULUM else 1
    for i in range(2):
        observer.dcm[i], observer.zmp[i] = observation.dcm[i], zmp[i]

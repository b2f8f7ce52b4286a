"""What a controller does about one push: how far ZMP, landing and timing leave the nominal gait."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from surefoot.dcm.pushes import Push
from surefoot.interface import Controller
from surefoot.rollout.outcome import Outcome
from surefoot.studies.engine.pushed_walk import PUSHED_SIDE
from surefoot.worlds.point.simulate import simulate

SEEN = 2.5
"""How long after the beginning of a push its answer is watched [s]."""


@dataclass(frozen=True)
class Answer:
    """What a method did about one push.

    Attributes:
        zmp_peak: largest distance of the ZMP from the centre of the foot [m].
        zmp_rms: its root mean square from the push on, for `SEEN` seconds [m].
        landing: largest change of a step vector against the nominal gait [m].
        timing: largest change of a step's duration [s].
        survived: whether it did not fall.
    """

    zmp_peak: float
    zmp_rms: float
    landing: float
    timing: float
    survived: bool


def answer(controller: Controller, push: Push) -> Answer:
    """Walk, push, and measure what the controller does about it; the right foot stands first.

    Args:
        controller: what decides.
        push: one push; the walk goes on for `SEEN` seconds after its beginning.
    """
    rollout = simulate(controller, push.start + SEEN, [push], first_support=PUSHED_SIDE)
    moved = np.hypot(*(rollout.zmp - rollout.support_foot).T)[rollout.time >= push.start]
    gait = controller.gait
    pushed = [step for step in rollout.footsteps if step.start + step.duration > push.start]
    changes = [np.subtract(step.step, gait.step(step.side)) for step in pushed]
    return Answer(
        zmp_peak=float(moved.max()),
        zmp_rms=float(np.sqrt(np.mean(moved**2))),
        landing=max((float(np.hypot(*change)) for change in changes), default=0.0),
        timing=max((abs(step.duration - gait.step_duration) for step in pushed), default=0.0),
        survived=rollout.outcome is not Outcome.FELL,
    )

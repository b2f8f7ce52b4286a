"""One cell of a comparison: where a method fails, the theoretical limits, what a cycle costs."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.control.registry import find_method
from surefoot.dcm.pushes import Push
from surefoot.rollout.disturbance import Disturbance
from surefoot.studies.compare.disturbances import UNDISTURBED, named_disturbance
from surefoot.studies.engine.pushed_walk import PUSHED_SIDE, PUSHED_STEP
from surefoot.studies.engine.scan import LARGEST_BEYOND, LARGEST_SHARE, smallest_failing_push
from surefoot.studies.engine.table import Row
from surefoot.worlds.point.simulate import simulate

if TYPE_CHECKING:
    from surefoot.studies.compare.question import Cell, Comparison

TIMING_IMPULSE = 0.6
"""Decision times are taken under a push of this fraction of the smallest that fails."""

METHOD_WORDS = ("key", "label", "source", "adapts", "cannot")
"""What a table says of a method."""


def measure(study: Comparison, cell: Cell) -> Row:
    """What a row says beside its cell: the limit of a method, and the theoretical limits.

    Returns:
        `impulse` (smallest failing, in the worst of the walks of its disturbance, inf if none up to
        `scanned` does), `scanned` (the largest that was tried) and `step` of the scan [N s],
        `delta_v` [m/s], `failure` (one of `FAILURES`), `survived_mean` (over these walks, the
        largest impulse below which all were survived [N s]) and `seconds`; the limits of
        `Comparison.limits`.
    """
    before = time.perf_counter()
    walked, limits = study.measured_as(cell), study.limits(cell)
    controller = study.walk.on_leg(walked.leg_speed).controller(walked.method)
    named = named_disturbance(cell.disturbance)
    found = [
        smallest_failing_push(
            controller,
            study.walk.direction(cell.angle),
            start=_push_start(study, walked, disturbance),
            duration=cell.push_duration,
            step=study.step,
            largest=LARGEST_SHARE * limits["limit_finite"] + LARGEST_BEYOND,
            first_support=PUSHED_SIDE,
            workers=1,
            plant=named.plant(controller.robot),
            disturbance=disturbance,
            estimator=named.estimator_of(controller),
            must_settle=study.must_settle,
        )
        for disturbance in named.walks(study.seeds)
    ]
    worst = min(found, key=lambda one: one.impulse)
    survived = [one.survived for one in found]
    return {
        "impulse": worst.impulse,
        "delta_v": worst.delta_v,
        "step": worst.step,
        "scanned": worst.scanned,
        "failure": worst.failure,
        "survived_mean": math.fsum(survived) / len(survived),
        **limits,
        "seconds": time.perf_counter() - before,
    }


def _push_start(study: Comparison, walked: Cell, walk: Disturbance) -> float:
    """When the push begins in one walk: in its phase of the same step, under any disturbance."""
    nominal = study.walk.start(walked.phase)
    if walked.disturbance == UNDISTURBED:
        return nominal
    return (
        nominal
        - study.walk.start(0.0)
        + pushed_touchdown(study, walked.method, walked.leg_speed, walked.disturbance, walk)
    )


@lru_cache(maxsize=256)
def pushed_touchdown(
    study: Comparison, key: str, leg_speed: float, disturbance: str, walk: Disturbance
) -> float:
    """When the step begins that is pushed [s]: sooner or later than nominally, if the ground is.

    A robot that does not get that far is pushed when that step would begin.
    """
    nominal, named = study.walk.start(0.0), named_disturbance(disturbance)
    controller = study.walk.on_leg(leg_speed).controller(key)
    rollout = simulate(
        controller,
        1.5 * nominal,
        first_support=PUSHED_SIDE,
        plant=named.plant(controller.robot),
        disturbance=walk,
        estimator=named.estimator_of(controller),
    )
    finished = rollout.footsteps[PUSHED_STEP - 1 : PUSHED_STEP]
    return finished[0].start + finished[0].duration if finished else nominal


def method_notes(study: Comparison, rows: Sequence[Row]) -> list[dict[str, Any]]:
    """What a reader is given of each method that was measured: words, and what a cycle costs."""
    notes = []
    for key in study.methods:
        own = [row for row in rows if row["method"] == key]
        if own:
            words = {name: getattr(find_method(key), name) for name in METHOD_WORDS}
            failing = min(min(row["impulse"], row["scanned"]) for row in own)
            notes.append(words | decision_times(study, key, TIMING_IMPULSE * failing))
    return notes


def decision_times(study: Comparison, key: str, impulse: float) -> dict[str, float]:
    """How long a control cycle takes, over walks with a push; on this machine, one at a time.

    Args:
        study: the questions.
        key: of the method.
        impulse: of a push that it survives, forward [N s].

    Returns:
        `decision_p50` and `decision_p99_9` [s], and the control `period` [s].
    """
    controller = study.walk.on_leg(study.leg_speeds[0]).controller(key)
    duration = study.push_durations[0]
    push = Push(study.walk.start(0.0), duration, (impulse / duration, 0.0))
    simulate(controller, 1.0)  # the first cycles of a process load what later ones have
    times = np.concatenate([simulate(controller, 6.0, [push]).decision_time for _ in range(3)])
    middle, slowest = np.percentile(times, [50.0, 99.9])
    return {
        "decision_p50": float(middle),
        "decision_p99_9": float(slowest),
        "period": controller.period,
    }

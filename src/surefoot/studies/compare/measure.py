"""One cell of a comparison: where a method fails, where anybody would, and what a cycle costs."""

from __future__ import annotations

import math
import time
from dataclasses import asdict
from functools import lru_cache
from typing import Any

import numpy as np

from surefoot.control.registry import find_method
from surefoot.dcm.causal_limit import causal_push_limit
from surefoot.dcm.push_limit import fixed_steps_limit, push_limit
from surefoot.dcm.pushes import Push
from surefoot.interface import Controller
from surefoot.robot.feet import Side
from surefoot.rollout.disturbance import Disturbance
from surefoot.studies.compare.conditions import UNDISTURBED, condition
from surefoot.studies.compare.question import PUSHED_STEP, Cell, Protocol
from surefoot.studies.engine.scan import smallest_failing_push
from surefoot.worlds.point.world import simulate

LARGEST_SHARE, LARGEST_BEYOND = 1.25, 50.0
"""A scan gives up at this share of the limit [-], and this much more [N s]; a method with a trunk
has a freedom that the limit does not know."""


@lru_cache(maxsize=8)
def controller_of(protocol: Protocol, key: str, leg_speed: float) -> Controller:
    """The controller of a method on a leg; made once, since some take their time.

    Raises:
        SurefootError: the method cannot control this robot, or its library is not installed.
    """
    one = find_method(key)
    return one.controller(protocol.robot_with(leg_speed), protocol.velocity, **one.compared)


@lru_cache(maxsize=256)
def pushed_touchdown(
    protocol: Protocol, key: str, leg_speed: float, disturbance: str, walk: Disturbance
) -> float:
    """When the step begins that is pushed [s]: sooner or later than nominally, if the ground is.

    A robot that does not get that far is pushed when that step would begin.
    """
    nominal, wrong = protocol.push_start(0.0), condition(disturbance)
    controller = controller_of(protocol, key, leg_speed)
    rollout = simulate(
        controller,
        1.5 * nominal,
        first_support=Side.RIGHT,
        plant=wrong.plant(controller.robot),
        disturbance=walk,
        estimator=wrong.estimator_of(controller),
    )
    finished = rollout.footsteps[PUSHED_STEP - 1 : PUSHED_STEP]
    return finished[0].start + finished[0].duration if finished else nominal


def _push_start(protocol: Protocol, walked: Cell, walk: Disturbance) -> float:
    """When the push begins in one walk: in the same phase of the same step, whatever is wrong."""
    nominal = protocol.push_start(walked.phase)
    if walked.disturbance == UNDISTURBED:
        return nominal
    return (
        nominal
        - protocol.push_start(0.0)
        + pushed_touchdown(protocol, walked.method, walked.leg_speed, walked.disturbance, walk)
    )


def measure(protocol: Protocol, cell: Cell) -> dict[str, Any]:
    """One row of the table: the limit of a method in one cell, and what nobody can pass.

    Args:
        protocol: the questions.
        cell: the one to answer.

    Returns:
        The cell, `impulse` (smallest failing, in the worst of the walks of its disturbance),
        `scanned` and `step` [N s], `delta_v` [m/s], `failure` ("fell", "unsettled" or "none"),
        `survived_mean` (over these walks, the largest impulse below which all were survived [N s])
        and `seconds`; see `limits_of` for the limits.
    """
    before = time.perf_counter()
    walked, limits = protocol.walked(cell), limits_of(protocol, cell)
    controller = controller_of(protocol, walked.method, walked.leg_speed)
    wrong = condition(cell.disturbance)
    found = [
        smallest_failing_push(
            controller,
            protocol.direction(cell.angle),
            start=_push_start(protocol, walked, disturbance),
            duration=cell.push_duration,
            step=protocol.step,
            largest=LARGEST_SHARE * limits["limit_finite"] + LARGEST_BEYOND,
            first_support=Side.RIGHT,
            workers=1,
            plant=wrong.plant(controller.robot),
            disturbance=disturbance,
            estimator=wrong.estimator_of(controller),
            must_settle=protocol.must_settle,
        )
        for disturbance in wrong.walks(protocol.seeds)
    ]
    worst = min(found, key=lambda one: one.impulse)
    failure = "fell" if worst.fell else "unsettled"
    survived = [one.survived for one in found]
    return {
        **asdict(cell),
        "impulse": worst.impulse,
        "delta_v": worst.delta_v,
        "step": worst.step,
        "scanned": worst.scanned,
        "failure": failure if math.isfinite(worst.impulse) else "none",
        "survived_mean": math.fsum(survived) / len(survived),
        **limits,
        "seconds": time.perf_counter() - before,
    }


def limits_of(protocol: Protocol, cell: Cell) -> dict[str, float]:
    """What nobody can pass in a cell [N s]: `limit_point` with the ZMP at rest in the centre of
    the foot, `limit_finite` with the whole sole, `limit_causal` with it for those who do not know
    when the push ends, `limit_fixed` with it but fixed steps. They are those of the robot that is
    really pushed, whatever its controller believes."""
    robot = condition(cell.disturbance).plant(protocol.robot_with(cell.leg_speed))
    situation: dict[str, Any] = {
        "velocity": protocol.velocity,
        "elapsed": protocol.push_start(cell.phase) - protocol.push_start(0.0),
        "duration": cell.push_duration,
        "support_side": Side.RIGHT,
    }
    direction = protocol.direction(cell.angle)
    return {
        "limit_point": push_limit(robot, direction, **situation).impulse,
        "limit_finite": push_limit(
            robot, direction, zmp_reach=robot.foot.half, **situation
        ).impulse,
        "limit_causal": causal_push_limit(
            robot, direction, zmp_reach=robot.foot.half, **situation
        ).impulse,
        "limit_fixed": fixed_steps_limit(robot, direction, duration=cell.push_duration).impulse,
    }


def decision_times(protocol: Protocol, key: str, impulse: float) -> dict[str, float]:
    """How long a control cycle takes, over walks with a push; on this machine, one at a time.

    Args:
        protocol: the questions.
        key: of the method.
        impulse: of a push that it survives, forward [N s].

    Returns:
        `decision_p50` and `decision_p99_9` [s], and the control `period` [s].
    """
    controller = controller_of(protocol, key, protocol.leg_speeds[0])
    duration = protocol.push_durations[0]
    push = Push(protocol.push_start(0.0), duration, (impulse / duration, 0.0))
    simulate(controller, 1.0)  # the first cycles of a process load what later ones have
    times = np.concatenate([simulate(controller, 6.0, [push]).decision_time for _ in range(3)])
    middle, slowest = np.percentile(times, [50.0, 99.9])
    return {
        "decision_p50": float(middle),
        "decision_p99_9": float(slowest),
        "period": controller.period,
    }

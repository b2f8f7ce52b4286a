"""Walk a body in physics and keep everything that happened."""

from __future__ import annotations

from collections.abc import Sequence

from surefoot.checks import check_number
from surefoot.dcm.pushes import Push
from surefoot.errors import ParameterError
from surefoot.robot.floor import TIME_STEP, check_course
from surefoot.rollout.rollout import Rollout
from surefoot.rollout.trace import TRUTH
from surefoot.worlds.body.estimator import BodyEstimator
from surefoot.worlds.body.noise import BodyNoise
from surefoot.worlds.body.plant import Surroundings
from surefoot.worlds.body.sensors import SenseNoise, usual_estimator
from surefoot.worlds.body.steered import SteeredBody
from surefoot.worlds.body.walker import Walker
from surefoot.worlds.steering import Steering, course_of

USUAL_NOISE = BodyNoise()
"""Stands for `BodyNoise.of` the robot that walks."""


def simulate_body(
    control: Walker,
    duration: float = 10.0,
    pushes: Sequence[Push] = (),
    *,
    steering: Sequence[tuple[float, Steering]] = (),
    surroundings: Surroundings | None = None,
    noise: SenseNoise | None = USUAL_NOISE,
    estimator: BodyEstimator | str | None = None,
) -> Rollout:
    """Walk a body in physics, from a stand on both feet.

    Args:
        control: what walks it.
        duration: how long [s]; a fall ends the walk early.
        pushes: forces on the base, or on `Body.trunk`, at its centre of mass.
        steering: (time, command) in order of time [s]; before the first one, and if there is none,
            the robot walks at its controller's velocity.
        surroundings: floor, bumps, payload, masses.
        noise: of the sensors, `BodyNoise.of` the robot unless told; they are perfect if None.
        estimator: makes a state of what the sensors tell; if None a `BodyEstimator` that knows how
            late and how noisy the sensors of a `BodyNoise` are. "truth" tells the true state
            instead.

    Returns:
        The rollout; its `body` is the trace of the mechanism.

    Raises:
        ParameterError: the duration is not positive and finite, the steering not in order, or
            there is noise but no estimator, the payload weighs more than the body, or there are
            bumps and the course leaves them.
        VelocityError: one of the velocities cannot be walked; told before the walk begins.
    """
    check_number("duration", duration, 0.0, "s", above=True)
    route = _route(control, steering)
    if surroundings is not None and surroundings.bumps > 0.0:
        check_course(course_of(route, duration))
    if estimator == TRUTH and noise not in (None, USUAL_NOISE):
        raise ParameterError(
            "noise with an estimator: the true state has none",
            f"estimator={TRUTH!r} and {noise!r}",
            "leave one of them out",
        )
    if noise is USUAL_NOISE:
        noise = BodyNoise.of(control.multibody.robot)
    eyes = _eyes(control, noise, estimator)
    cycles = round(duration / TIME_STEP) + 1
    noise, kept = None if eyes is None else noise, cycles * TIME_STEP
    walk = SteeredBody(control, surroundings, noise, eyes, pushes=pushes, kept=kept)
    pending = list(route)
    while walk.cycles < cycles and not walk.fallen:
        while pending and walk.time >= pending[0][0]:
            walk.steer(pending.pop(0)[1])
        walk.step()
    return walk.rollout(route)


def _route(
    control: Walker, steering: Sequence[tuple[float, Steering]]
) -> list[tuple[float, Steering]]:
    """All commands from the start on, checked."""
    times = [time for time, _ in steering]
    if times != sorted(times):
        raise ParameterError("steering in order of time", f"{list(steering)!r}", "sort it")
    route = list(steering)
    if not route or route[0][0] > 0.0:
        route.insert(0, (0.0, Steering(control.controller.gait.velocity)))
    for _, command in route:
        if not command.standing:
            control.controller.with_velocity(command.velocity)
    return route


def _eyes(
    control: Walker, noise: SenseNoise | None, estimator: BodyEstimator | str | None
) -> BodyEstimator | None:
    if isinstance(estimator, str) and estimator != TRUTH:
        raise ParameterError(
            f"an estimator, or {TRUTH!r} for the true state",
            repr(estimator),
            "leave it out for an estimate from the sensors",
        )
    if isinstance(estimator, str):
        return None
    return estimator or usual_estimator(control.multibody, noise)

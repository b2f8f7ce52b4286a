"""`surefoot walk --simulator mujoco`: what a body can walk, and its walk in physics."""

from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from surefoot.errors import ParameterError
from surefoot.options import compiling_notice, given

if TYPE_CHECKING:
    from pathlib import Path

    from surefoot.rollout.rollout import Rollout
    from surefoot.worlds.body.controller import BodyControl
    from surefoot.worlds.steering import Steering


def check_body(asked: SimpleNamespace) -> None:
    """Refuse at once what no body can walk, not after a minute of compiling.

    Raises:
        ParameterError: options contradict each other, or a value is out of range.
        MissingExtraError: physics is not installed.
    """
    from surefoot.checks import check_number
    from surefoot.worlds.body.mapping import USUAL_MAPPING, check_mapping

    asked.mapping = USUAL_MAPPING if asked.mapping is None else asked.mapping
    check_mapping(asked.mapping)
    if asked.truth and given("delay"):
        raise ParameterError(
            "--delay without --truth: the true state is never late",
            "--delay and --truth",
            "leave one of them out",
        )
    if given("seed") and asked.truth and asked.bumps == 0.0:
        raise ParameterError(
            "--seed where something is drawn: noise of the sensors (no --truth), or --bumps",
            "--seed with --truth and without --bumps",
            "leave --seed out: the walk is the same with every one",
        )
    require_physics()
    from surefoot.worlds.body.plant import Surroundings
    from surefoot.worlds.body.sensors import BodyNoise

    check_number("duration", asked.duration, 0.0, "s", above=True)
    asked.route = _route(asked)
    check_number("mass_error", asked.mass_error, -1.0, "-", above=True)
    asked.surroundings = Surroundings(
        asked.friction, asked.payload, 1.0 + asked.mass_error, asked.bumps, asked.seed
    )
    BodyNoise(delay=asked.delay, seed=asked.seed)


def require_physics() -> None:
    """Refuse a walk in physics where it is not installed.

    Raises:
        MissingExtraError: it is not.
    """
    from surefoot.checks import optional_module

    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")


def _route(asked: SimpleNamespace) -> list[tuple[float, Steering]]:
    """The commands to a body in order of time.

    Raises:
        ParameterError: the changes are not in order, or go on after the stand.
    """
    from surefoot.worlds.steering import Steering

    times = [time for time, _ in asked.changes]
    for option, time in [*(("--then", time) for time in times), ("--stand-at", asked.stand_at)]:
        if time is not None and not time >= 0.0:
            raise ParameterError(
                f"{option} at 0 s or later", f"{time:g} s", "the walk begins with a stand at 0 s"
            )
    if times != sorted(times):
        raise ParameterError("--then in order of time", f"times {times}", "sort them")
    if asked.stand_at is not None and times and asked.stand_at <= times[-1]:
        raise ParameterError(
            "--stand-at after every --then",
            f"--stand-at {asked.stand_at:g} and --then ...@{times[-1]:g}",
            "let the robot stand last",
        )
    walking = [(0.0, asked.velocity), *asked.changes]
    route = [(time, Steering(velocity, asked.turning)) for time, velocity in walking]
    if asked.stand_at is not None:
        route.append((asked.stand_at, Steering(standing=True)))
    return route


def walk_body(asked: SimpleNamespace) -> tuple[Rollout, None]:
    """The walk; of the decisions of a body nothing is kept."""
    from surefoot.rollout.trace import TRUTH
    from surefoot.worlds.body.sensors import BodyNoise
    from surefoot.worlds.body.world import simulate_body

    def simulate(duration: float, dump: Path | None = None) -> Rollout:
        noise = BodyNoise.of(control.multibody.robot, delay=asked.delay, seed=asked.seed)
        return simulate_body(
            control, duration, asked.pushes, steering=asked.route, surroundings=asked.surroundings,
            noise=None if asked.truth else noise, estimator=TRUTH if asked.truth else None,
            dump=dump,
        )  # fmt: skip

    with compiling_notice(8.0, "a minute"):
        control = make_body_control(
            asked.robot, asked.controller, asked.velocity, asked.leg_speed, asked.leg_acceleration,
            asked.mapping, **asked.parameters,
        )  # fmt: skip
        # What a walk compiles, it compiles in its first cycles.
        simulate(0.003)
    return simulate(asked.duration, asked.dump), None


def make_body_control(
    robot: str, controller: str, velocity: tuple[float, float], leg_speed: float | None = None,
    leg_acceleration: float | None = None, mapping: str | None = None, **parameters: Any,
) -> BodyControl:  # fmt: skip
    """A controller, and what lets it walk a body.

    Args:
        robot: preset or file.
        controller: key of a method.
        velocity: where to walk first [m/s].
        leg_speed, leg_acceleration: limits of the swing foot; the robot's own if None
            [m/s, m/s^2].
        mapping: what moves its joints; the usual one if None.
        **parameters: of the controller.

    Raises:
        SurefootError: robot, controller or an extra is not there.
    """
    from surefoot.robot.multibody import load_multibody
    from surefoot.robot.robot import load_robot
    from surefoot.worlds.body.gait import body_control, body_controller, walking_robot
    from surefoot.worlds.body.mapping import USUAL_MAPPING

    multibody = load_multibody(load_robot(robot))
    point_mass = walking_robot(multibody).with_leg(
        max_speed=leg_speed, max_acceleration=leg_acceleration
    )
    chosen = body_controller(controller, point_mass, velocity, **parameters)
    return body_control(chosen, multibody, mapping or USUAL_MAPPING)

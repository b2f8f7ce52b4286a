"""`surefoot walk --simulator mujoco`: the same controllers, walking a body in physics."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from surefoot.checks import check_number
from surefoot.errors import ParameterError
from surefoot.options import compiling_notice, given

if TYPE_CHECKING:
    from surefoot.dcm.pushes import Push
    from surefoot.robot.robot import Robot
    from surefoot.rollout.rollout import Rollout
    from surefoot.worlds.body.controller import BodyControl
    from surefoot.worlds.body.plant import Surroundings
    from surefoot.worlds.body.sensors import BodyNoise
    from surefoot.worlds.steering import Steering

OF_BODY = {
    "mapping": "--mapping",
    "truth": "--truth",
    "turning": "--turning",
    "stand_at": "--stand-at",
    "friction": "--friction",
    "payload": "--payload",
    "mass_error": "--mass-error",
    "bumps": "--bumps",
    "delay": "--delay",
    "seed": "--seed",
    "video": "--video",
}
"""Options that a point mass has no use for."""

OF_POINT_MASS = {
    "footholds": "--footholds",
    "double_support": "--double-support",
    "unprojected": "--unprojected",
    "decision_plot": "--plot-decisions",
    "dump": "--dump",
}
"""Options that a body has no use for."""


@dataclass(frozen=True)
class World:
    """What the command line says of the body's world and sensors; see `cli.walk`."""

    friction: float
    payload: float
    mass_error: float
    bumps: float
    delay: float
    seed: int

    def surroundings(self) -> Surroundings:
        """Floor, payload, masses.

        Raises:
            ParameterError: a value is out of range.
        """
        from surefoot.worlds.body.plant import Surroundings

        check_number("mass_error", self.mass_error, -1.0, "-", above=True)
        return Surroundings(
            self.friction, self.payload, 1.0 + self.mass_error, self.bumps, self.seed
        )

    def check_noise(self) -> None:
        """Refuse what no sensor does, before any robot is loaded.

        Raises:
            ParameterError: a value is out of range.
        """
        from surefoot.worlds.body.sensors import BodyNoise

        BodyNoise(delay=self.delay, seed=self.seed)

    def noise(self, robot: Robot) -> BodyNoise:
        """What the sensors of a robot do."""
        from surefoot.worlds.body.sensors import BodyNoise

        return BodyNoise.of(robot, delay=self.delay, seed=self.seed)


@dataclass(frozen=True)
class BodyWalk:
    """What the command line says of a walk in physics; see `cli.walk` for the options."""

    robot: str
    controller: str
    parameters: dict[str, Any]
    velocity: tuple[float, float]
    changes: list[tuple[float, tuple[float, float]]]
    duration: float
    pushes: list[Push]
    leg_speed: float | None
    leg_acceleration: float | None
    mapping: str
    truth: bool
    turning: float
    stand_at: float | None
    world: World


def check_body_walk(walk: BodyWalk) -> None:
    """Refuse at once what cannot be walked, not after a minute of compiling.

    Raises:
        ParameterError: options contradict each other, or a value is out of range.
        MissingExtraError: physics is not installed.
    """
    from surefoot.checks import optional_module
    from surefoot.worlds.body.mapping import check_mapping

    check_mapping(walk.mapping)
    if walk.truth and given("delay"):
        raise ParameterError(
            "--delay without --truth: the true state is never late",
            "--delay and --truth",
            "leave one of them out",
        )
    if given("seed") and walk.truth and walk.world.bumps == 0.0:
        raise ParameterError(
            "--seed where something is drawn: noise of the sensors (no --truth), or --bumps",
            "--seed with --truth and without --bumps",
            "leave --seed out: the walk is the same with every one",
        )
    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    check_number("duration", walk.duration, 0.0, "s", above=True)
    route_of(walk)
    walk.world.surroundings()
    walk.world.check_noise()


def walk_body(walk: BodyWalk) -> Rollout:
    """Walk in physics."""
    with compiling_notice(8.0, "a minute"):
        control = make_control(walk)
        # What a walk compiles, it compiles in its first cycles.
        _simulate(replace(walk, duration=0.003), control)
    return _simulate(walk, control)


def make_control(walk: BodyWalk) -> BodyControl:
    """The controller of the command line, and what lets it walk a body.

    Raises:
        SurefootError: robot, controller or an extra is not there.
    """
    from surefoot.robot.multibody import load_multibody
    from surefoot.robot.robot import load_robot
    from surefoot.worlds.body.gait import body_control, body_controller, walking_robot

    multibody = load_multibody(load_robot(walk.robot))
    believed = walking_robot(multibody).with_leg(
        max_speed=walk.leg_speed, max_acceleration=walk.leg_acceleration
    )
    controller = body_controller(walk.controller, believed, walk.velocity, **walk.parameters)
    return body_control(controller, multibody, walk.mapping)


def route_of(walk: BodyWalk) -> list[tuple[float, Steering]]:
    """The commands of the walk in order of time.

    Raises:
        ParameterError: the changes are not in order, or go on after the stand.
    """
    from surefoot.worlds.steering import Steering

    times = [time for time, _ in walk.changes]
    for option, time in [*(("--then", time) for time in times), ("--stand-at", walk.stand_at)]:
        if time is not None and not time >= 0.0:
            raise ParameterError(
                f"{option} at 0 s or later", f"{time:g} s", "the walk begins with a stand at 0 s"
            )
    if times != sorted(times):
        raise ParameterError("--then in order of time", f"times {times}", "sort them")
    if walk.stand_at is not None and times and walk.stand_at <= times[-1]:
        raise ParameterError(
            "--stand-at after every --then",
            f"--stand-at {walk.stand_at:g} and --then ...@{times[-1]:g}",
            "let the robot stand last",
        )
    route = [(0.0, Steering(walk.velocity, walk.turning))]
    route += [(time, Steering(velocity, walk.turning)) for time, velocity in walk.changes]
    if walk.stand_at is not None:
        route.append((walk.stand_at, Steering(standing=True)))
    return route


def _simulate(walk: BodyWalk, control: BodyControl) -> Rollout:
    from surefoot.rollout.trace import TRUTH
    from surefoot.worlds.body.world import simulate_body

    return simulate_body(
        control,
        walk.duration,
        walk.pushes,
        steering=route_of(walk),
        surroundings=walk.world.surroundings(),
        noise=None if walk.truth else walk.world.noise(control.multibody.robot),
        estimator=TRUTH if walk.truth else None,
    )


def film_body(rollout: Rollout, path: Path) -> None:
    """Film a walk, with a bar on the error output: the other one may be read by a machine."""
    from rich.console import Console
    from rich.progress import Progress

    from surefoot.show.film import film_walk

    with Progress(console=Console(stderr=True), transient=True) as bars:
        bar = bars.add_task("filming", total=None)
        film_walk(rollout, path, lambda done, total: bars.update(bar, completed=done, total=total))

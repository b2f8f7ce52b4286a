"""`surefoot walk`: walk, get pushed, recover; report what happened."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from surefoot.cli.walk_body import (
    OF_BODY,
    OF_POINT_MASS,
    BodyWalk,
    World,
    check_body_walk,
    film_body,
    walk_body,
)
from surefoot.errors import ParameterError
from surefoot.options import (
    check_plotting,
    compiling_notice,
    controller_option,
    given,
    json_option,
    mapping_option,
    print_json,
    read_settings,
    refuse_of_other_world,
    robot_option,
    settings_option,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from surefoot.interface import Controller
    from surefoot.robot.robot import Robot
    from surefoot.rollout.rollout import Rollout

BODY_VELOCITY, BODY_DURATION = (0.3, 0.0), 10.0
"""Of a walk in physics, unless the options say another [m/s, s]."""

OPTION_OF = {"project_zmp": "--unprojected", "double_support": "--double-support"}


@click.command()
@robot_option
@click.option(
    "--velocity",
    nargs=2,
    type=float,
    default=(0.5, 0.0),
    show_default="0.5 0, of a body 0.3 0",
    metavar="VX VY",
    help="Commanded velocity [m/s]: x forward, y to the left.",
)
@click.option(
    "--then",
    "changes",
    multiple=True,
    metavar="VX,VY@TIME",
    help="Another velocity from TIME [s] on; may be repeated.",
)
@click.option(
    "--footholds",
    type=click.Path(path_type=Path),
    metavar="FILE.csv|.toml",
    help="Walk over these footholds instead of at a velocity, by tracking; then step in place.",
)
@controller_option
@settings_option
@click.option(
    "--simulator",
    type=click.Choice(["lipm", "mujoco"]),
    default="lipm",
    show_default=True,
    help="The world: the linear inverted pendulum, a point mass on two feet; or physics, a body "
    "with joints and motors, from a stand.",
)
@click.option(
    "--duration",
    type=float,
    default=6.0,
    show_default="6, of a body 10",
    metavar="S",
    help="How long to walk [s].",
)
@click.option(
    "--push",
    "pushes",
    multiple=True,
    metavar="FX,FY@START+DURATION",
    help="A force [N] on the CoM (body: its base) from START for DURATION [s]; repeatable.",
)
@click.option(
    "--leg-speed",
    type=float,
    metavar="M/S",
    help="Speed limit of the swing foot along each axis; the robot's own if left out.",
)
@click.option(
    "--leg-acceleration",
    type=float,
    metavar="M/S^2",
    help="Likewise its acceleration limit.",
)
@click.option(
    "--double-support",
    type=float,
    default=0.0,
    show_default=True,
    metavar="FRACTION",
    help="Part of each step for which both feet share the load, for example 0.2.",
)
@click.option(
    "--unprojected",
    is_flag=True,
    help="Let the ZMP of tracking leave the foot, as the paper's figures do.",
)
@mapping_option
@click.option(
    "--truth",
    is_flag=True,
    help="Body: give the controller the true state, not an estimate from encoders, inertial unit "
    "and feet.",
)
@click.option(
    "--turning",
    type=float,
    default=0.0,
    show_default=True,
    metavar="RAD/S",
    help="Body: turn, counter-clockwise; at most 2.5 to either side.",
)
@click.option("--stand-at", type=float, metavar="S", help="Body: come to a stand from then on [s].")
@click.option(
    "--friction",
    type=float,
    default=0.8,
    show_default=True,
    metavar="MU",
    help="Body: coefficient of the floor.",
)
@click.option(
    "--payload",
    type=float,
    default=0.0,
    show_default=True,
    metavar="KG",
    help="Body: mass at its base that the controller does not know of; at most its own.",
)
@click.option(
    "--mass-error",
    type=float,
    default=0.0,
    show_default=True,
    metavar="FRACTION",
    help="Body: by how much all links are heavier than the controller believes, for example -0.1.",
)
@click.option(
    "--bumps",
    type=float,
    default=0.0,
    show_default=True,
    metavar="M",
    help="Body: height of the highest of the boards that lie on the floor, at most 0.03.",
)
@click.option(
    "--delay",
    type=float,
    default=0.0,
    show_default=True,
    metavar="S",
    help="Body: delay of the sensors; the estimate accounts for it.",
)
@click.option(
    "--seed",
    type=int,
    default=0,
    show_default=True,
    metavar="N",
    help="Body: of the sensors' noise, and of where the boards lie; not with neither.",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw the walk (.png, .pdf, .svg).",
)
@click.option(
    "--plot-decisions",
    "decision_plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw what the unified controller decided, with its limits (.png, .pdf, .svg).",
)
@click.option(
    "--video",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Body: film the walk (.mp4, .gif).",
)
@click.option(
    "--save",
    type=click.Path(path_type=Path),
    metavar="FILE.mcap|.npz",
    help="Keep every cycle of the walk, as a log for ROS 2, Foxglove and PlotJuggler or for NumPy.",
)
@click.option(
    "--dump",
    type=click.Path(path_type=Path),
    metavar="FILE.npz",
    help="Keep the last steps with all states, if the robot falls or a number is NaN.",
)
@json_option
def walk(
    robot: str, velocity: tuple[float, float], changes: tuple[str, ...],
    footholds: Path | None, controller: str, settings: Path | None, simulator: str, duration: float,
    pushes: tuple[str, ...], leg_speed: float | None, leg_acceleration: float | None,
    double_support: float, unprojected: bool, mapping: str, truth: bool, turning: float,
    stand_at: float | None, friction: float, payload: float, mass_error: float, bumps: float,
    delay: float, seed: int, plot: Path | None, decision_plot: Path | None, video: Path | None,
    save: Path | None, dump: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Walk, get pushed, recover; report what happened.

    Exits with 0 if the robot still walks, with 1 if it fell or a body does not walk at the speed
    that is commanded, with 2 if the command is wrong.

    Example: surefoot walk --push 176,0@1.1+0.2 --plot walk.png
    """
    from surefoot.dcm.pushes import parse_push

    forces = [parse_push(text) for text in pushes]
    velocities = [(time, (x, y)) for x, y, time in map(parse_change, changes)]
    refuse_of_other_world(simulator, OF_POINT_MASS, OF_BODY)
    key, parameters = read_settings(settings, controller)
    decided = None
    if simulator == "mujoco":
        body_walk = BodyWalk(
            robot, key, parameters,
            velocity if given("velocity") else BODY_VELOCITY, velocities,
            duration if given("duration") else BODY_DURATION, forces, leg_speed, leg_acceleration,
            mapping, truth, turning, stand_at,
            World(friction, payload, mass_error, bumps, delay, seed),
        )  # fmt: skip
        check_body_walk(body_walk)
        _check_outputs([plot], video, save, dump)
        rollout = walk_body(body_walk)
    else:
        _check_outputs([plot, decision_plot], None, save, dump)
        if unprojected:
            parameters["project_zmp"] = False
        if double_support != 0.0:
            parameters["double_support"] = double_support
        with compiling_notice():
            chosen = _controller(
                robot, leg_speed, leg_acceleration, key, velocity, footholds, parameters
            )
            _check_decides(chosen, decision_plot)
            from surefoot.rollout.decisions import DecisionLog
            from surefoot.worlds.point.simulate import simulate

            log = DecisionLog()
            rollout = simulate(
                chosen, duration, forces, velocity_changes=velocities, watch=log, dump=dump
            )
        decided = log.records if len(log.records) else None
    if save is not None:
        rollout.save(save)
    if plot is not None:
        rollout.plot(plot)
    if video is not None:
        film_body(rollout, video)
    _report(rollout, decided, decision_plot, as_json)


def parse_change(text: str) -> tuple[float, float, float]:
    """VX,VY@TIME as numbers [m/s, m/s, s].

    Raises:
        ParameterError: the text has another form.
    """
    from surefoot.dcm.pushes import NUMBER

    match = re.fullmatch(rf"({NUMBER}),({NUMBER})@({NUMBER})", text)
    if match is None:
        raise ParameterError(
            "--then VX,VY@TIME in metres per second and seconds",
            repr(text),
            "write for example --then 0.3,0.1@2.5, without spaces",
        )
    x, y, time = map(float, match.groups())
    return x, y, time


def _controller(
    robot: str, leg_speed: float | None, leg_acceleration: float | None, name: str,
    velocity: tuple[float, float], footholds: Path | None, parameters: dict[str, Any],
) -> Controller:  # fmt: skip
    """The controller of a point mass, for a velocity or for footholds; arguments as of `walk`."""
    from surefoot.control.registry import find_method, methods
    from surefoot.robot.robot import load_robot

    body = load_robot(robot).with_leg(max_speed=leg_speed, max_acceleration=leg_acceleration)
    if footholds is not None:
        return _foothold_controller(footholds, body, parameters)
    chosen = find_method(name)
    for parameter in OPTION_OF.keys() & parameters:
        if not chosen.takes(parameter):
            able = [one.key for one in methods() if one.takes(parameter)]
            raise ParameterError(
                f"{OPTION_OF[parameter]} with a controller that knows it ({', '.join(able)})",
                f"--controller {name}",
                "leave the option out, or choose another controller",
            )
    return chosen.controller(body, velocity, **parameters)


def _foothold_controller(path: Path, robot: Robot, parameters: dict[str, Any]) -> Controller:
    from surefoot.control.foothold_tracking import FootholdTracking
    from surefoot.dcm.footholds import load_footholds

    for name in ("velocity", "changes", "controller", "settings"):
        if given(name):
            raise ParameterError(
                "--footholds alone: they say where and when to step",
                f"--{'then' if name == 'changes' else name} too",
                "leave one of them out",
            )
    return FootholdTracking(robot, load_footholds(path, robot), **parameters)


def _check_outputs(
    pictures: list[Path | None], video: Path | None, save: Path | None, dump: Path | None
) -> None:
    """Refuse before the walk, not after it, results that could not be kept."""
    from surefoot.checks import optional_module

    if save is not None:
        from surefoot.rollout.files import check_rollout_path

        check_rollout_path(save)
    if dump is not None:
        from surefoot.rollout.dump import check_dump_path

        check_dump_path(dump)
    for path in pictures:
        if path is not None:
            check_plotting()
            from surefoot.show.walk_figure import check_figure_path

            check_figure_path(path)
    if video is not None:
        for module in ("imageio_ffmpeg", "PIL", "matplotlib"):
            optional_module(module, "films", "video")
        from surefoot.show.film import check_video_path

        check_video_path(video)


def _check_decides(controller: Controller, decision_plot: Path | None) -> None:
    from surefoot.control.unified.controller import UnifiedController

    if decision_plot is not None and not isinstance(controller, UnifiedController):
        raise ParameterError(
            "--plot-decisions with the controller that keeps its decisions, unified",
            type(controller).__name__,
            "leave the option out, or walk with --controller unified",
        )


def _report(
    rollout: Rollout, decided: NDArray[np.void] | None, decision_plot: Path | None, as_json: bool
) -> NoReturn:
    """Draw the decisions, print the walk, and exit with its status."""
    from rich.console import Console

    from surefoot.show.summary import holds_course, print_walk, walk_summary

    if decided is not None and decision_plot is not None:
        from surefoot.show.decisions import DecidedWalk, draw_decisions

        draw_decisions([DecidedWalk(rollout, decided)], decision_plot)
    if rollout.body is not None:
        from surefoot.show.body_summary import body_summary, print_body

        if as_json:
            print_json(body_summary(rollout, rollout.body))
        else:
            print_body(rollout, rollout.body, Console())
    elif as_json:
        print_json(walk_summary(rollout, decided))
    else:
        print_walk(rollout, Console(), decided)
    sys.exit(0 if not rollout.fallen and holds_course(rollout) else 1)

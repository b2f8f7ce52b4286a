"""`surefoot walk`: walk, get pushed, recover; report what happened."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import click

from surefoot.cli.walk_body import check_body, walk_body
from surefoot.errors import ParameterError
from surefoot.options import (
    check_plotting,
    compiling_notice,
    controller_option,
    given,
    json_option,
    legs_unknown_option,
    mapping_option,
    moved_robot,
    number_option,
    path_option,
    print_json,
    progress_bar,
    read_settings,
    refuse_of_other_world,
    robot_option,
    settings_option,
    simulator_option,
    velocity_option,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from surefoot.interface import Controller
    from surefoot.robot.robot import Robot
    from surefoot.rollout.rollout import Rollout

BODY_DEFAULTS: dict[str, Any] = {"velocity": (0.3, 0.0), "duration": 10.0}
"""Of a walk in physics [m/s, s]."""

OF_BODY = (
    "mapping", "truth", "turning", "stand_at", "friction", "payload", "mass_error", "bumps",
    "delay", "seed", "video",
)  # fmt: skip
"""Options that a point mass has no use for."""

OF_POINT_MASS = ("footholds", "double_support", "unprojected", "decision_plot", "legs_unknown")
"""Options that a body has no use for."""

OPTION_OF = {"project_zmp": "--unprojected", "double_support": "--double-support"}
"""Options that are parameters of some controllers."""


@click.command()
@robot_option
@velocity_option(
    "Commanded velocity [m/s]: x forward, y to the left.", usual="0.5 0, of a body 0.3 0"
)
@click.option(
    "--then", "changes", multiple=True, metavar="VX,VY@TIME",
    help="Another velocity from TIME [s] on; may be repeated.",
)  # fmt: skip
@path_option(
    "--footholds", metavar="FILE.csv|.toml",
    about="Walk over these footholds instead of at a velocity, by tracking; then step in place.",
)  # fmt: skip
@controller_option
@settings_option
@simulator_option(
    "The world: the linear inverted pendulum, a point mass on two feet; the same on legs of mass; "
    "or physics, a body with joints and motors, from a stand."
)
@legs_unknown_option
@click.option(
    "--duration", type=float, default=6.0, show_default="6, of a body 10", metavar="S",
    help="How long to walk [s].",
)  # fmt: skip
@click.option(
    "--push", "pushes", multiple=True, metavar="FX,FY@START+DURATION",
    help="A force [N] on the CoM (body: its base) from START for DURATION [s]; repeatable.",
)  # fmt: skip
@number_option(
    "--leg-speed", "M/S",
    "Speed limit of the swing foot along each axis; the robot's own if left out.",
)  # fmt: skip
@number_option("--leg-acceleration", "M/S^2", "Likewise its acceleration limit.")
@number_option(
    "--double-support", "FRACTION",
    "Part of each step for which both feet share the load, for example 0.2.", 0.0,
)  # fmt: skip
@click.option(
    "--unprojected", is_flag=True,
    help="Let the ZMP of tracking leave the foot, as the paper's figures do.",
)  # fmt: skip
@mapping_option
@click.option(
    "--truth", is_flag=True,
    help="Body: give the controller the true state, not an estimate from encoders, inertial unit "
    "and feet.",
)  # fmt: skip
@number_option(
    "--turning", "RAD/S", "Body: turn, counter-clockwise; at most 2.5 to either side.", 0.0
)
@number_option("--stand-at", "S", "Body: come to a stand from then on [s].")
@number_option("--friction", "MU", "Body: coefficient of the floor.", 0.8)
@number_option(
    "--payload", "KG",
    "Body: mass at its base that the controller does not know of; at most its own.", 0.0,
)  # fmt: skip
@number_option(
    "--mass-error", "FRACTION",
    "Body: by how much all links are heavier than the controller believes, for example -0.1.", 0.0,
)  # fmt: skip
@number_option(
    "--bumps", "M",
    "Body: height of the highest of the boards that lie on the floor, at most 0.03.", 0.0,
)  # fmt: skip
@number_option("--delay", "S", "Body: delay of the sensors; the estimate accounts for it.", 0.0)
@click.option(
    "--seed", type=int, default=0, show_default=True, metavar="N",
    help="Body: of the sensors' noise, and of where the boards lie; not with neither.",
)  # fmt: skip
@path_option("--plot", about="Draw the walk (.png, .pdf, .svg).")
@path_option(
    "--plot-decisions",
    "decision_plot",
    about="Draw what the unified controller decided, with its limits (.png, .pdf, .svg).",
)
@path_option("--video", about="Body: film the walk (.mp4, .gif).")
@path_option(
    "--save", metavar="FILE.mcap|.npz",
    about="Keep every cycle of the walk, as a log for ROS 2, Foxglove and PlotJuggler or for "
    "NumPy.",
)  # fmt: skip
@path_option(
    "--dump", metavar="FILE.npz",
    about="Keep the last steps with all states, if the robot falls or a number is NaN.",
)  # fmt: skip
@json_option
def walk(**options: Any) -> None:
    """Walk, get pushed, recover; report what happened.

    Exits with 0 if the robot still walks, with 1 if it fell or a body does not walk at the speed
    that is commanded, with 2 if the command is wrong.

    Example: surefoot walk --push 176,0@1.1+0.2 --plot walk.png
    """
    from surefoot.dcm.pushes import parse_push

    asked = SimpleNamespace(**options)
    asked.pushes = [parse_push(text) for text in asked.pushes]
    asked.changes = [parse_change(text) for text in asked.changes]
    refuse_of_other_world(asked.simulator, OF_POINT_MASS, OF_BODY)
    asked.controller, asked.parameters = read_settings(asked.settings, asked.controller)
    if asked.simulator == "mujoco":
        usual = {name: value for name, value in BODY_DEFAULTS.items() if not given(name)}
        vars(asked).update(usual)
        check_body(asked)
    _check_outputs(asked)
    rollout, decided = (walk_body if asked.simulator == "mujoco" else _walk_point_mass)(asked)
    if asked.save is not None:
        rollout.save(asked.save)
    if asked.plot is not None:
        rollout.plot(asked.plot)
    if asked.video is not None:
        from surefoot.show.film import film_walk

        with progress_bar("filming") as report:
            film_walk(rollout, asked.video, report)
    if asked.decision_plot is not None and decided is not None:
        from surefoot.show.decisions import DecidedWalk, draw_decisions

        draw_decisions([DecidedWalk(rollout, decided)], asked.decision_plot)
    sys.exit(_report(rollout, decided, asked.as_json))


def parse_change(text: str) -> tuple[float, tuple[float, float]]:
    """VX,VY@TIME as a time and a velocity [s, m/s].

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
    return time, (x, y)


def _check_outputs(asked: SimpleNamespace) -> None:
    """Refuse before the walk, not after it, results that could not be kept."""
    from surefoot.checks import check_writable, optional_module

    if asked.save is not None:
        from surefoot.rollout.files import check_rollout_path

        check_rollout_path(asked.save)
    if asked.dump is not None:
        from surefoot.rollout.dump import check_dump_path

        check_dump_path(asked.dump)
    for path in filter(None, (asked.plot, asked.decision_plot)):
        check_plotting()
        from surefoot.show.picture_file import FORMATS

        check_writable(path, FORMATS)
    if asked.video is not None:
        for module in ("imageio_ffmpeg", "PIL", "matplotlib"):
            optional_module(module, "films", "video")
        from surefoot.show.film import FORMATS

        check_writable(asked.video, FORMATS)


def _report(rollout: Rollout, decided: NDArray[np.void] | None, as_json: bool) -> int:
    """Print the walk; the exit status."""
    from rich.console import Console

    from surefoot.show.summary import holds_course, print_walk, walk_summary

    measures = None
    if rollout.body is not None:
        from surefoot.rollout.measures import measure_body

        measures = measure_body(rollout, rollout.body)
    if as_json:
        print_json(walk_summary(rollout, decided, measures))
    else:
        print_walk(rollout, Console(), decided, measures)
    return 0 if not rollout.fallen and holds_course(rollout) else 1


def _walk_point_mass(asked: SimpleNamespace) -> tuple[Rollout, NDArray[np.void] | None]:
    """The walk, and its decisions if its controller has any."""
    if asked.unprojected:
        asked.parameters["project_zmp"] = False
    if asked.double_support != 0.0:
        asked.parameters["double_support"] = asked.double_support
    with compiling_notice():
        controller = _point_mass_controller(asked)
        _check_decides(controller, asked.decision_plot)
        from surefoot.rollout.decisions import DecisionLog
        from surefoot.worlds.point.simulate import simulate

        log = DecisionLog()
        rollout = simulate(
            controller, asked.duration, asked.pushes, velocity_changes=asked.changes, watch=log,
            dump=asked.dump,
        )  # fmt: skip
    return rollout, log.records if len(log.records) else None


def _point_mass_controller(asked: SimpleNamespace) -> Controller:
    """For a velocity, or for footholds."""
    from surefoot.control.registry import find_method, methods
    from surefoot.robot.robot import load_robot

    robot = load_robot(asked.robot).with_leg(
        max_speed=asked.leg_speed, max_acceleration=asked.leg_acceleration
    )
    robot = moved_robot(robot, asked.simulator, asked.legs_unknown)
    if asked.footholds is not None:
        return _foothold_controller(asked.footholds, robot, asked.parameters)
    chosen = find_method(asked.controller)
    for parameter in OPTION_OF.keys() & asked.parameters:
        if not chosen.takes(parameter):
            able = [one.key for one in methods() if one.takes(parameter)]
            raise ParameterError(
                f"{OPTION_OF[parameter]} with a controller that knows it ({', '.join(able)})",
                f"--controller {asked.controller}",
                "leave the option out, or choose another controller",
            )
    return chosen.controller(robot, asked.velocity, **asked.parameters)


def _foothold_controller(path: Path, robot: Robot, parameters: dict[str, Any]) -> Controller:
    from surefoot.control.foothold_tracking import FootholdTracking
    from surefoot.dcm.footholds import load_footholds

    for name in filter(given, ("velocity", "changes", "controller", "settings")):
        raise ParameterError(
            "--footholds alone: they say where and when to step",
            f"--{'then' if name == 'changes' else name} too",
            "leave one of them out",
        )
    return FootholdTracking(robot, load_footholds(path, robot), **parameters)


def _check_decides(controller: Controller, decision_plot: Path | None) -> None:
    from surefoot.control.unified.controller import UnifiedController

    if decision_plot is not None and not isinstance(controller, UnifiedController):
        raise ParameterError(
            "--plot-decisions with the controller that keeps its decisions, unified",
            type(controller).__name__,
            "leave the option out, or walk with --controller unified",
        )

"""`surefoot live`: a page in the browser on which the robot walks, is pushed and steered."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from surefoot.cli.serving import host_option, open_option, port_option, serve_page
from surefoot.options import compiling_notice, controller_option, robot_option

if TYPE_CHECKING:
    from surefoot.live.controls import Menu
    from surefoot.live.run import Choice
    from surefoot.live.stage import MakeFigure
    from surefoot.worlds.steering import Steering
    from surefoot.worlds.world import World


@click.command()
@robot_option
@click.option(
    "--velocity",
    nargs=2,
    type=float,
    default=(0.3, 0.0),
    show_default=True,
    metavar="VX VY",
    help="Forward and to the left [m/s].",
)
@controller_option
@click.option(
    "--ghost",
    default="",
    metavar="NAME",
    help="A second controller beside it, under the same pushes.",
)
@click.option(
    "--simulator",
    type=click.Choice(["lipm", "mujoco"]),
    default="lipm",
    show_default=True,
    help="The point mass, or the body in physics.",
)
@host_option
@port_option
@open_option
def live(
    robot: str,
    velocity: tuple[float, float],
    controller: str,
    ghost: str,
    simulator: str,
    host: str,
    port: int,
    open_page: bool,
) -> None:
    """Watch a robot walk in the browser; push it, steer it, switch controllers.

    The page is served on this machine alone unless --host says otherwise, and needs no internet.
    """
    from surefoot.checks import optional_module
    from surefoot.worlds.steering import Steering

    optional_module("viser", "the live page", "live")
    from surefoot.live.page import LivePage
    from surefoot.live.run import Choice, LiveRun

    choice = Choice(robot, controller, ghost, simulator)
    with compiling_notice(4.0, "a minute" if simulator == "mujoco" else "10 s"):
        run = LiveRun(make_walk, choice, Steering(velocity))
    menu = live_menu(choice)
    serve_page(
        host, port, open_page, "the page is at",
        lambda server: LivePage(server, run, figure_of, menu),
    )  # fmt: skip


def make_walk(choice: Choice, key: str, steering: Steering) -> World:
    """A walk from its beginning.

    Args:
        choice: robot and simulator.
        key: of the controller's method.
        steering: where to go.

    Raises:
        SurefootError: there is no such robot or method, it cannot walk so fast, or an extra is
            missing.
    """
    from surefoot.robot.robot import load_robot

    robot = load_robot(choice.robot)
    walk = (
        _body(robot, key, steering)
        if choice.simulator == "mujoco"
        else _point(robot, key, steering)
    )
    walk.steer(steering)
    return walk


def _point(robot: Any, key: str, steering: Steering) -> World:
    from surefoot.control.registry import find_method
    from surefoot.worlds.point.world import PointWorld

    return PointWorld(find_method(key).controller(robot, steering.velocity))


def _body(robot: Any, key: str, steering: Steering) -> World:
    from surefoot.checks import optional_module

    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    from surefoot.robot.multibody import load_multibody
    from surefoot.worlds.body.gait import body_control, body_controller, walking_robot
    from surefoot.worlds.body.sensors import BodyNoise, usual_estimator
    from surefoot.worlds.body.world import BodyWorld

    multibody = load_multibody(robot)
    controller = body_controller(key, walking_robot(multibody), steering.velocity)
    noise = BodyNoise.of(robot)
    estimator = usual_estimator(multibody, noise)
    control = body_control(controller, multibody)
    return BodyWorld(control, noise=noise, estimator=estimator)


def figure_of(walk: World) -> MakeFigure:
    """How a walk is drawn: with its mechanism's looks if it has one."""
    from surefoot.live.figure import PointFigure

    multibody = getattr(walk, "multibody", None)
    if multibody is None:
        return lambda scene, name, opacity: PointFigure(scene, name, walk.robot, opacity)
    from surefoot.live.body_figure import BodyFigure

    return lambda scene, name, opacity: BodyFigure(scene, name, multibody, opacity)


def live_menu(choice: Choice) -> Menu:
    """What there is to choose from, with a file of the command line."""
    from importlib.util import find_spec

    from surefoot.control.registry import methods
    from surefoot.live.controls import Menu
    from surefoot.robot.robot import preset_names

    quick = [one for one in methods() if not one.slow]
    controllers = {
        "lipm": [one.key for one in quick],
        "mujoco": [one.key for one in quick if not one.leans],
    }
    # A slow one can be asked for by name.
    asked = [key for key in (choice.controller, choice.ghost) if key]
    controllers[choice.simulator] = list(dict.fromkeys([*controllers[choice.simulator], *asked]))
    robots = list(dict.fromkeys([choice.robot, *preset_names()]))
    physics = find_spec("mujoco") is not None and find_spec("daqp") is not None
    return Menu(robots, controllers, ["lipm", "mujoco"] if physics else ["lipm"])

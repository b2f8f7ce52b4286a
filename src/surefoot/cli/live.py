"""`surefoot live` and `surefoot replay`: a walk in the browser, under way or saved."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.options import (
    SIMULATORS,
    Option,
    compiling_notice,
    controller_option,
    moved_robot,
    path_option,
    robot_option,
    simulator_option,
    velocity_option,
)

if TYPE_CHECKING:
    import viser

    from surefoot.live.panels import Menu
    from surefoot.live.replay import Scenes
    from surefoot.live.run import Choice
    from surefoot.live.stage import MakeFigure
    from surefoot.robot.multibody import Multibody
    from surefoot.robot.robot import Robot
    from surefoot.rollout.rollout import Rollout
    from surefoot.worlds.steering import Steering
    from surefoot.worlds.world import World


def page_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Where a page is served, and whether it is opened."""
    options: tuple[Option, ...] = (
        click.option(
            "--host", default="127.0.0.1", show_default=True,
            help="Address to serve on; 0.0.0.0 lets other machines watch and push.",
        ),
        click.option(
            "--port", default=8080, show_default=True, type=click.IntRange(1, 65535),
            help="The first free port from this one on.",
        ),
        click.option(
            "--open/--no-open", "open_page", default=True, show_default=True,
            help="Open the page in a browser.",
        ),
    )  # fmt: skip
    for option in reversed(options):
        command = option(command)
    return command


@click.command()
@robot_option
@velocity_option("Forward and to the left [m/s].", (0.3, 0.0))
@controller_option
@click.option(
    "--ghost", default="", metavar="NAME",
    help="A second controller beside it, under the same pushes.",
)  # fmt: skip
@simulator_option("The point mass, the same on legs of mass, or the body in physics.")
@page_options
def live(
    robot: str, velocity: tuple[float, float], controller: str, ghost: str, simulator: str,
    host: str, port: int, open_page: bool,
) -> None:  # fmt: skip
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
    _serve(
        host, port, open_page, "the page is at",
        lambda server: LivePage(server, run, figure_of, menu),
    )  # fmt: skip


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@path_option(
    "--html", "page", metavar="OUT.html",
    about="Write one file that plays the walk without a network, and end.",
)  # fmt: skip
@page_options
def replay(file: Path, page: Path | None, host: str, port: int, open_page: bool) -> None:
    """Play FILE, a walk saved by `surefoot walk --save` or on the live page."""
    from surefoot.checks import check_writable, optional_module

    optional_module("viser", "playback", "live")
    from surefoot.live.replay import ReplayPage, scenes_of

    if page is not None:
        optional_module("matplotlib", "plots of a page", "plot")
        check_writable(page, (".html",))
    rollout = _load(file)
    scenes, figure = scenes_of(rollout), _figure_of_rollout(rollout)
    if page is not None:
        _write(scenes, figure, file, page)
        return
    _serve(
        host, port, open_page, f"{file} is played at",
        lambda server: ReplayPage(server, scenes, figure),
    )  # fmt: skip


def _serve(
    host: str, port: int, open_page: bool, words: str, make: Callable[[viser.ViserServer], Any]
) -> None:
    """Serve a page until Ctrl-C.

    Args:
        host, port, open_page: as of the options.
        words: what stands before the address when it is printed.
        make: the page, with `draw` and `serve`, on its server.

    Raises:
        ParameterError: this machine has no such address, or no free port.
    """
    from surefoot.live.page import page_server, stop, url_of

    server = page_server(host, port)
    page = make(server)
    page.draw()
    click.echo(f"{words} {url_of(server)} (Ctrl-C ends it)")
    if open_page:
        click.launch(url_of(server))
    try:
        page.serve()
    except KeyboardInterrupt:
        click.echo("ended", err=True)
    finally:
        stop(server)


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
    if choice.simulator == "mujoco":
        walk = _body_world(choice.robot, key, steering.velocity)
    else:
        walk = _point_world(choice, key, steering.velocity)
    walk.steer(steering)
    return walk


def _point_world(choice: Choice, key: str, velocity: tuple[float, float]) -> World:
    from surefoot.control.registry import find_method
    from surefoot.robot.robot import load_robot
    from surefoot.worlds.point.world import PointWorld

    robot = moved_robot(load_robot(choice.robot), choice.simulator, legs_unknown=False)
    return PointWorld(find_method(key).controller(robot, velocity))


def _body_world(robot: str, key: str, velocity: tuple[float, float]) -> World:
    from surefoot.cli.walk_body import make_body_control, require_physics

    require_physics()
    from surefoot.worlds.body.sensors import BodyNoise, usual_estimator
    from surefoot.worlds.body.world import BodyWorld

    control = make_body_control(robot, key, velocity)
    noise = BodyNoise.of(control.multibody.robot)
    return BodyWorld(control, noise=noise, estimator=usual_estimator(control.multibody, noise))


def figure_of(walk: World) -> MakeFigure:
    """How a walk is drawn: with the shapes of its mechanism if it has one."""
    return _figure(walk.robot, getattr(walk, "multibody", None))


def _figure_of_rollout(rollout: Rollout) -> MakeFigure:
    """How a saved walk is drawn: as a point mass too if the mechanism is not installed."""
    from surefoot.checks import optional_module
    from surefoot.errors import SurefootError

    if rollout.body is None:
        return _figure(rollout.robot)
    try:
        optional_module("mujoco", "the looks of a body", "mujoco")
        from surefoot.robot.multibody import load_multibody

        return _figure(rollout.body.robot, load_multibody(rollout.body.robot))
    except SurefootError as error:
        click.echo(f"note: drawn as a point mass on legs: {error}", err=True)
        return _figure(rollout.body.believed)


def _figure(robot: Robot, multibody: Multibody | None = None) -> MakeFigure:
    if multibody is None:
        from surefoot.live.figure import PointFigure

        return lambda scene, name, opacity: PointFigure(scene, name, robot, opacity)
    from surefoot.live.body_figure import BodyFigure

    return lambda scene, name, opacity: BodyFigure(scene, name, multibody, opacity)


def live_menu(choice: Choice) -> Menu:
    """What there is to choose from, with a file of the command line."""
    from importlib.util import find_spec

    from surefoot.control.registry import methods
    from surefoot.live.panels import Menu
    from surefoot.robot.robot import preset_names

    quick = [one for one in methods() if not one.slow]
    all_keys = [one.key for one in quick]
    controllers = {
        "lipm": all_keys,
        "three-mass": all_keys,
        "mujoco": [one.key for one in quick if not one.leans],
    }
    # A slow one can be asked for by name.
    asked = [key for key in (choice.controller, choice.ghost) if key]
    controllers[choice.simulator] = list(dict.fromkeys([*controllers[choice.simulator], *asked]))
    robots = list(dict.fromkeys([choice.robot, *preset_names()]))
    physics = find_spec("mujoco") is not None and find_spec("daqp") is not None
    return Menu(robots, controllers, [one for one in SIMULATORS if physics or one != "mujoco"])


def _load(file: Path) -> Rollout:
    """The walk; a note says what is missing of it."""
    from surefoot.rollout.rollout import load_rollout

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rollout = load_rollout(file)
    for one in caught:
        click.echo(f"note: {one.message}", err=True)
    return rollout


def _write(scenes: Scenes, figure: MakeFigure, file: Path, page: Path) -> None:
    import tempfile

    from surefoot.live.page import page_server, stop
    from surefoot.live.replay import write_page
    from surefoot.show.words import title

    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / "walk.svg"
        scenes.rollout.plot(drawn)
        plots = drawn.read_text(encoding="utf-8")
    server = page_server("127.0.0.1", 8080)
    try:
        name = f"{file.name}: {', '.join(title(scenes.rollout))}"
        write_page(server, scenes, figure, name, plots[plots.index("<svg") :], page)
    finally:
        stop(server)
    click.echo(f"{page}: {page.stat().st_size / 1e6:.1f} MB")

"""`surefoot replay`: a saved walk in the browser, or as one file to send around."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.cli.serving import host_option, open_option, port_option, serve_page

if TYPE_CHECKING:
    from surefoot.live.replay import Scenes
    from surefoot.live.stage import MakeFigure
    from surefoot.rollout.rollout import Rollout


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--html",
    "page",
    type=click.Path(path_type=Path),
    metavar="OUT.html",
    help="Write one file that plays the walk without a network, and end.",
)
@host_option
@port_option
@open_option
def replay(file: Path, page: Path | None, host: str, port: int, open_page: bool) -> None:
    """Play FILE, a walk saved by `surefoot walk --save` or on the live page."""
    from surefoot.checks import check_writable, optional_module

    optional_module("viser", "playback", "live")
    from surefoot.live.replay import ReplayPage, scenes_of

    if page is not None:
        optional_module("matplotlib", "plots of a page", "plot")
        check_writable(page, (".html",))
    rollout = _load(file)
    scenes, figure = scenes_of(rollout), _figure(rollout)
    if page is not None:
        _write(scenes, figure, file, page)
        return
    serve_page(
        host, port, open_page, f"{file} is played at",
        lambda server: ReplayPage(server, scenes, figure),
    )  # fmt: skip


def _load(file: Path) -> Rollout:
    """The walk; a note says what is missing of it."""
    from surefoot.rollout.rollout import load_rollout

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        rollout = load_rollout(file)
    for one in caught:
        click.echo(f"note: {one.message}", err=True)
    return rollout


def _figure(rollout: Rollout) -> MakeFigure:
    from surefoot.errors import SurefootError
    from surefoot.live.figure import PointFigure

    robot = rollout.robot
    if rollout.body is not None:
        try:
            return _mechanism(rollout.body.robot)
        except SurefootError as error:
            click.echo(f"note: drawn as a point mass on legs: {error}", err=True)
            robot = rollout.body.believed
    return lambda scene, name, opacity: PointFigure(scene, name, robot, opacity)


def _mechanism(robot: Any) -> MakeFigure:
    from surefoot.checks import optional_module

    optional_module("mujoco", "the looks of a body", "mujoco")
    from surefoot.live.body_figure import BodyFigure
    from surefoot.robot.multibody import load_multibody

    multibody = load_multibody(robot)
    return lambda scene, name, opacity: BodyFigure(scene, name, multibody, opacity)


def _write(scenes: Scenes, figure: MakeFigure, file: Path, page: Path) -> None:
    import tempfile

    from surefoot.live.replay import write_page
    from surefoot.live.server import page_server, stop
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

"""The command line: the one place, beside the package's front door, that wires everything.

Imports are inside the commands, so that `surefoot --help` starts at once.
"""

from __future__ import annotations

import re
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.errors import ParameterError, SurefootError
from surefoot.version import VERSION

if TYPE_CHECKING:
    from surefoot.models.interfaces import Controller
    from surefoot.models.robot import Robot

RECOVERED, FELL, MISUSE = 0, 1, 2
"""Exit status of `surefoot walk`."""

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


class _Commands(click.Group):
    """A group that tells a caller's mistake in one line and exits with 2."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except SurefootError as error:
            click.echo(f"error: {error}", err=True)
            ctx.exit(MISUSE)


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(VERSION, prog_name="surefoot")
def main() -> None:
    """Make a biped walk, and keep walking when it is pushed."""


@main.command()
@click.option(
    "--robot",
    default="paper-biped",
    show_default=True,
    metavar="NAME|FILE.toml",
    help="A preset (see `surefoot robots`) or your own file.",
)
@click.option(
    "--velocity",
    nargs=2,
    type=float,
    default=(0.5, 0.0),
    show_default=True,
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
@click.option(
    "--controller",
    type=click.Choice(["hybrid", "tracking"]),
    default="hybrid",
    show_default=True,
    help="The paper's hybrid, or DCM tracking alone.",
)
@click.option(
    "--simulator",
    type=click.Choice(["lipm"]),
    default="lipm",
    show_default=True,
    expose_value=False,
    help="The world: the linear inverted pendulum, a point mass on two feet.",
)
@click.option(
    "--duration",
    type=float,
    default=6.0,
    show_default=True,
    metavar="S",
    help="How long to walk [s].",
)
@click.option(
    "--push",
    "pushes",
    multiple=True,
    metavar="FX,FY@START+DURATION",
    help="A force [N] on the trunk from START for DURATION [s]; may be repeated.",
)
@click.option(
    "--leg-speed",
    type=float,
    metavar="M/S",
    help="Speed limit of the swing foot; the robot's own if left out.",
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
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw the walk (.png, .pdf, .svg).",
)
@click.option(
    "--save",
    type=click.Path(path_type=Path),
    metavar="FILE.npz",
    help="Keep every cycle of the walk.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
def walk(
    robot: str, velocity: tuple[float, float], changes: tuple[str, ...],
    footholds: Path | None, controller: str, duration: float, pushes: tuple[str, ...],
    leg_speed: float | None, double_support: float, unprojected: bool,
    plot: Path | None, save: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Walk, get pushed, recover; tell what happened.

    Exits with 0 if the robot still walks, with 1 if it fell, with 2 if the command is wrong.

    Example: surefoot walk --push 176,0@1.1+0.2 --plot walk.png
    """
    from surefoot.models.pushes import Push

    forces = [Push(start, time, (x, y)) for x, y, start, time in map(parse_push, pushes)]
    velocities = [(time, (x, y)) for x, y, time in map(parse_change, changes)]
    _check_outputs(plot, save)
    parameters = {"project_zmp": not unprojected, "double_support": double_support}
    with _compiling_notice():
        body = _robot(robot, leg_speed)
        if footholds is None:
            brain = _controller(controller, body, velocity, **parameters)
        else:
            brain = _foothold_controller(footholds, body, **parameters)
        from surefoot.simulation.outcome import Outcome
        from surefoot.simulation.simulate import simulate

        rollout = simulate(brain, duration, forces, velocity_changes=velocities)
    if save is not None:
        rollout.save(save)
    if plot is not None:
        rollout.plot(plot)
    _print_walk(rollout, as_json)
    sys.exit(FELL if rollout.outcome is Outcome.FELL else RECOVERED)


@main.command()
@click.option("--show", metavar="NAME", help="Print the file of a preset, to start your own from.")
def robots(show: str | None) -> None:
    """List the robots that Surefoot ships."""
    from surefoot.models.robot import load_robot, preset_names, preset_text

    if show is not None:
        click.echo(preset_text(show), nl=False)
        return
    from rich.console import Console
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("name", "mass [kg]", "CoM height [m]", "hip [m]", "where it comes from"):
        table.add_column(column, no_wrap=column == "name")
    for name in preset_names():
        robot = load_robot(name)
        table.add_row(
            name, f"{robot.mass:g}", f"{robot.com_height:g}", f"{robot.hip:g}", robot.description
        )
    Console().print(table)


@main.command()
@click.option(
    "--robot",
    default="paper-biped",
    show_default=True,
    metavar="NAME|FILE.toml",
    help="A preset (see `surefoot robots`) or your own file.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
def limits(robot: str, as_json: bool) -> None:
    """Print what a robot can do at most: speeds, and the DCM offsets that can still be saved."""
    from surefoot.viewers.limits_summary import limits_summary, print_limits

    numbers = limits_summary(_robot(robot, None))
    if as_json:
        _print_json(numbers)
        return
    from rich.console import Console

    print_limits(numbers, Console())


@main.command()
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("paper"),
    show_default=True,
    metavar="DIR",
    help="Folder for the report and its pictures.",
)
def reproduce(out: Path) -> None:
    """Reproduce the paper, figure by figure and number by number; write a report.

    DIR/paper.html needs nothing else; DIR/paper.md says the same, with the pictures beside it.
    """
    import dataclasses

    _check_plotting()
    from surefoot.checks import check_folder
    from surefoot.models.robot import load_robot
    from surefoot.studies.one_step import limits_table
    from surefoot.studies.paper_claims import paper_parameters, reproduce_paper
    from surefoot.viewers.paper_axes import png
    from surefoot.viewers.paper_figures import CAPTIONS, decision_time_figures, paper_figures
    from surefoot.viewers.paper_report import PaperReport, Table, write_paper_report

    check_folder(out)
    robot = load_robot("paper-biped").replace(mass=70.0)
    click.echo("walking, pushing and scanning; this takes under a minute ...", err=True)
    results = reproduce_paper(robot)
    report = PaperReport(
        claims=[dataclasses.astuple(claim) for claim in results.claims],
        parameters=paper_parameters(robot),
        pictures={n: png(f) for n, f in paper_figures(results.rollouts).items()},
        captions=CAPTIONS,
        tables=[Table(*limits_table(results.limits))],
        clock_pictures={n: png(f) for n, f in decision_time_figures(results.rollouts).items()},
    )
    for claim in results.claims:
        click.echo(f"{claim.figure}, {claim.text}: {claim.verdict}")
    click.echo(f"report: {write_paper_report(report, out)[0]}")


def parse_push(text: str) -> tuple[float, float, float, float]:
    """FX,FY@START+DURATION as numbers [N, N, s, s].

    Raises:
        ParameterError: the text has another form.
    """
    match = re.fullmatch(rf"({_NUMBER}),({_NUMBER})@({_NUMBER})\+({_NUMBER}|inf)", text)
    if match is None:
        raise ParameterError(
            "--push FX,FY@START+DURATION in newtons and seconds",
            repr(text),
            "write for example --push 176,0@1.1+0.2, without spaces",
        )
    x, y, start, duration = map(float, match.groups())
    return x, y, start, duration


def parse_change(text: str) -> tuple[float, float, float]:
    """VX,VY@TIME as numbers [m/s, m/s, s].

    Raises:
        ParameterError: the text has another form.
    """
    match = re.fullmatch(rf"({_NUMBER}),({_NUMBER})@({_NUMBER})", text)
    if match is None:
        raise ParameterError(
            "--then VX,VY@TIME in metres per second and seconds",
            repr(text),
            "write for example --then 0.3,0.1@2.5, without spaces",
        )
    x, y, time = map(float, match.groups())
    return x, y, time


def _robot(name_or_path: str, leg_speed: float | None) -> Robot:
    from msgspec import structs

    from surefoot.models.robot import load_robot

    robot = load_robot(name_or_path)
    if leg_speed is None:
        return robot
    return robot.replace(swing=structs.replace(robot.swing, max_speed=leg_speed))


def _controller(
    name: str, robot: Robot, velocity: tuple[float, float], **parameters: Any
) -> Controller:
    from surefoot.control.dcm_tracking import DcmTracking
    from surefoot.control.hybrid import HybridController

    kind = {"hybrid": HybridController, "tracking": DcmTracking}[name]
    return kind(robot, velocity, **parameters)


def _foothold_controller(path: Path, robot: Robot, **parameters: Any) -> Controller:
    from surefoot.control.foothold_tracking import FootholdTracking
    from surefoot.models.footholds import load_footholds

    given = click.get_current_context().get_parameter_source
    for name in ("velocity", "changes", "controller"):
        if given(name) is not click.core.ParameterSource.DEFAULT:
            raise ParameterError(
                "--footholds alone: they say where and when to step",
                f"--{'then' if name == 'changes' else name} too",
                "leave one of them out",
            )
    return FootholdTracking(robot, load_footholds(path, robot), **parameters)


def _check_outputs(plot: Path | None, save: Path | None) -> None:
    """Tell before the walk, not after it, that its results could not be kept."""
    from surefoot.checks import check_writable

    if save is not None:
        check_writable(save, (".npz",))
    if plot is not None:
        _check_plotting()
        from surefoot.viewers.walk_figure import check_figure_path

        check_figure_path(plot)


def _check_plotting() -> None:
    try:
        import matplotlib  # noqa: F401
    except ModuleNotFoundError as error:
        from surefoot.errors import MissingExtraError

        raise MissingExtraError("pictures", "plot") from error


@contextmanager
def _compiling_notice() -> Iterator[None]:
    """Say what takes so long, should it take long: the very first run on a machine compiles."""
    timer = threading.Timer(
        1.5,
        click.echo,
        ("compiling for this machine, only this once (about 10 s) ...",),
        {"err": True},
    )
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _print_walk(rollout: Any, as_json: bool) -> None:
    from surefoot.viewers.walk_summary import print_walk, walk_summary

    if as_json:
        _print_json(walk_summary(rollout))
        return
    from rich.console import Console

    print_walk(rollout, Console())


def _print_json(values: dict[str, Any]) -> None:
    import json

    click.echo(json.dumps(values, indent=2, allow_nan=False))

"""What several commands share: their options, JSON, and what they print while they work."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.errors import ParameterError

if TYPE_CHECKING:
    from surefoot.robot.robot import Robot

Option = Callable[[Callable[..., Any]], Callable[..., Any]]
"""What `click.option` makes."""

robot_option = click.option(
    "--robot",
    default="paper-biped",
    show_default=True,
    metavar="NAME|FILE.toml",
    help="A preset (see `surefoot robots`) or your own file.",
)


class _MethodOption(click.Option):
    """An option whose help lists the methods that are installed: looked up when help is shown."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        from surefoot.control.registry import method_names

        self.help = f"What decides: {', '.join(method_names())}; or module:Class."
        return super().get_help_record(ctx)


class _MappingOption(click.Option):
    """Likewise the mappings of a body."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        from surefoot.worlds.body.mapping import mapping_names

        usual, *others = mapping_names()
        self.help = (
            f"Body: what moves its joints: {usual}, the usual one, or {', '.join(others)}, or "
            "module:Class."
        )
        return super().get_help_record(ctx)


mapping_option = click.option("--mapping", metavar="NAME", cls=_MappingOption)
controller_option = click.option(
    "--controller", default="unified", show_default=True, metavar="METHOD", cls=_MethodOption
)


def path_option(*names: str, metavar: str = "FILE", about: str) -> Option:
    """A file."""
    return click.option(*names, type=click.Path(path_type=Path), metavar=metavar, help=about)


def number_option(name: str, metavar: str, about: str, default: float | None = None) -> Option:
    """A number; with a default, the help says it."""
    return click.option(
        name, type=float, default=default, show_default=default is not None, metavar=metavar,
        help=about,
    )  # fmt: skip


def velocity_option(
    about: str, default: tuple[float, float] | None = (0.5, 0.0), usual: str | bool = True
) -> Option:
    """A velocity; the help says `usual` for its default, if that depends on others."""
    return click.option(
        "--velocity", nargs=2, type=float, default=default,
        show_default=usual if default is not None else False, metavar="VX VY", help=about,
    )  # fmt: skip


SIMULATORS = "lipm", "three-mass", "mujoco"
"""The worlds: a point mass, one on legs of mass, a body in physics."""


def simulator_option(about: str) -> Option:
    """The world: that of a point mass, with massless or heavy legs, or of a body."""
    return click.option(
        "--simulator", type=click.Choice(SIMULATORS), default="lipm", show_default=True, help=about
    )


legs_unknown_option = click.option(
    "--legs-unknown", is_flag=True,
    help="Three-mass: the ZMP is not moved by what the legs' masses need.",
)  # fmt: skip


def moved_robot(robot: Robot, simulator: str, legs_unknown: bool) -> Robot:
    """The robot as a simulator of the command line moves it.

    Raises:
        RobotError: it has no masses of legs.
        ParameterError: `--legs-unknown` with another simulator.
    """
    if simulator == "three-mass":
        return robot.with_heavy_legs(known=not legs_unknown)
    if legs_unknown:
        raise ParameterError(
            "--legs-unknown with --simulator three-mass",
            f"--simulator {simulator}",
            "leave --legs-unknown out, or choose the other simulator",
        )
    return robot


settings_option = path_option(
    "--settings", metavar="FILE.toml",
    about="Controller and parameters from a file, such as `surefoot tune` writes.",
)  # fmt: skip
json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")


def check_plotting() -> None:
    """Tell early that pictures cannot be drawn.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    from surefoot.checks import optional_module

    optional_module("matplotlib", "pictures", "plot")


@contextmanager
def compiling_notice(patience: float = 1.5, about: str = "10 s") -> Iterator[None]:
    """Say what takes so long, should it take long: the very first run on a machine compiles.

    Args:
        patience: time without a word [s].
        about: how long it may take.
    """
    timer = threading.Timer(
        patience,
        click.echo,
        (f"compiling for this machine, only this once (about {about}) ...",),
        {"err": True},
    )
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def given(name: str) -> bool:
    """Whether an option stands on the command line."""
    source = click.get_current_context().get_parameter_source(name)
    return source is not click.core.ParameterSource.DEFAULT


def option_of(name: str) -> str:
    """An option as it is written on the command line, by its name in Python."""
    return {one.name: one.opts[0] for one in click.get_current_context().command.params}[name]


def refuse_of_other_world(
    simulator: str, of_point_mass: Iterable[str], of_body: Iterable[str]
) -> None:
    """Refuse options that make no sense with a simulator.

    Args:
        simulator: one of `SIMULATORS`.
        of_point_mass: options that a body has no use for, by their names in Python.
        of_body: likewise, those that a point mass has no use for.

    Raises:
        ParameterError: one is given; it is named.
    """
    refused, other = (of_point_mass, "lipm") if simulator == "mujoco" else (of_body, "mujoco")
    for option in map(option_of, filter(given, refused)):
        raise ParameterError(
            f"{option} with --simulator {other}",
            f"--simulator {simulator}",
            f"leave {option} out, or choose the other simulator",
        )


def read_settings(path: Path | None, controller: str) -> tuple[str, dict[str, Any]]:
    """Controller and parameters of a command: from a file if there is one.

    Raises:
        FileError: the file cannot be read.
        ParameterError: it is wrong, or --controller is given too.
    """
    if path is None:
        return controller, {}
    if given("controller"):
        raise ParameterError(
            "--settings alone: it names the controller", "--controller too", "leave one of them out"
        )
    from surefoot.control.settings import load_settings

    chosen = load_settings(path)
    return chosen.controller, dict(chosen.parameters)


def print_json(values: dict[str, Any]) -> None:
    """Print values for machines; a number that JSON has no word for is a defect."""
    click.echo(json.dumps(values, indent=2, allow_nan=False))


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error, from what is there already to all that is wanted."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Left

    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), Left())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("cells", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)

"""What several commands share: the robot, plots and JSON, and a word while kernels compile."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

robot_option = click.option(
    "--robot",
    default="paper-biped",
    show_default=True,
    metavar="NAME|FILE.toml",
    help="A preset (see `surefoot robots`) or your own file.",
)
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


def print_json(values: dict[str, Any]) -> None:
    """Print values for machines; a number that JSON has no word for is a defect."""
    click.echo(json.dumps(values, indent=2, allow_nan=False))

"""The command line: the one place, beside the package's front door, that wires everything.

A command is an entry point of the group `surefoot.commands`, of this package or of any other: a
study brings its own. A command is imported when it is called, or listed; what it needs, when it
runs. So `surefoot --help` starts at once.
"""

from __future__ import annotations

from typing import Any

import click

from surefoot.errors import ParameterError, SurefootError
from surefoot.plugins import load, places
from surefoot.version import VERSION

GROUP = "surefoot.commands"
"""The group of entry points."""

MISUSE = 2
"""Exit status of a command that is wrong."""


class _Commands(click.Group):
    """Commands by entry point; a caller's mistake is printed on one line and exits with 2."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(places(GROUP))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        place = places(GROUP).get(cmd_name)
        if place is None:
            return None
        try:
            command = load(place)
            if not isinstance(command, click.Command):
                raise ParameterError(
                    f"a command at {place}", repr(command), "decorate it with @click.command()"
                )
        except Exception as error:  # one broken package leaves the help of the others readable
            return _Broken(cmd_name, error)
        return command

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except SurefootError as error:
            click.echo(f"error: {error}", err=True)
            ctx.exit(MISUSE)


class _Broken(click.Command):
    """A command that cannot be imported: listed with the reason, which it raises if called."""

    def __init__(self, name: str, error: Exception) -> None:
        self.error = error
        super().__init__(
            name,
            short_help=f"cannot be loaded: {error}",
            context_settings={"ignore_unknown_options": True, "allow_extra_args": True},
            add_help_option=False,
        )

    def invoke(self, ctx: click.Context) -> Any:
        raise self.error


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(VERSION, prog_name="surefoot")
def main() -> None:
    """Make a biped walk, and keep walking when it is pushed."""

"""The command line: the one place, beside the package's front door, that wires everything.

Imports are inside the commands, so that `surefoot --help` starts at once.
"""

from __future__ import annotations

from typing import Any

import click

from surefoot.cli.cite import cite
from surefoot.cli.limits import limits
from surefoot.cli.live import live
from surefoot.cli.replay import replay
from surefoot.cli.robots import robots
from surefoot.cli.walk import walk
from surefoot.errors import SurefootError
from surefoot.plugins import load, places
from surefoot.studies.compare.command import compare
from surefoot.studies.gentleness.command import gentleness
from surefoot.studies.push_map.command import push_map
from surefoot.studies.reproduce.command import reproduce
from surefoot.studies.sweep.command import sweep
from surefoot.studies.tune.command import tune
from surefoot.version import VERSION

MISUSE = 2
"""Exit status of a command that is wrong."""


class _Commands(click.Group):
    """A group that tells a caller's mistake in one line and exits with 2.

    Commands that other packages bring, as entry points of `surefoot.commands`, come after its own.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(dict.fromkeys([*super().list_commands(ctx), *places("surefoot.commands")]))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        own = super().get_command(ctx, cmd_name)
        brought = {} if own is not None else places("surefoot.commands")
        return load(brought[cmd_name]) if cmd_name in brought else own

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


for command in (
    walk, live, replay, robots, limits, reproduce, compare, push_map, gentleness, sweep, tune,
    cite,
):  # fmt: skip
    main.add_command(command)

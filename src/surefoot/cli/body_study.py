"""A study of bodies on the command line: robot after robot, what failed, and what is kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import click

INCOMPLETE, STOPPED = 1, 130
"""Exit status if a cell could not be measured, and if the study was stopped."""

Progress = Callable[[str], AbstractContextManager[Callable[[int, int], None]]]
"""Shows how far something is, by its name."""


def study_bodies(
    protocols: Sequence[Any],
    out: Path,
    measure: Callable[[Any, Path], Any],
    show: Callable[[list[Any]], None],
) -> int:
    """Measure, tell what could not be measured, and show the rest; the exit status.

    Args:
        protocols: one for each robot.
        out: has a folder for each of them.
        measure: makes a result with `failures` of a protocol and its folder.
        show: shows all results.

    Raises:
        SurefootError: see `checks.check_folder`, and what `measure` raises.
    """
    from surefoot.checks import check_folder

    check_folder(out)
    try:
        results = [measure(protocol, out / protocol.robot.name) for protocol in protocols]
    except KeyboardInterrupt:
        click.echo(
            f"stopped; what is measured is kept in {out}, and the same command goes on there",
            err=True,
        )
        return STOPPED
    failures = [failure for result in results for failure in result.failures]
    for failure in failures:
        click.echo(f"could not be measured: {failure.cell}: {failure.error}", err=True)
    show(results)
    return INCOMPLETE if failures else 0

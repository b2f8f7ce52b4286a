"""A study of bodies on the command line: robot after robot, what failed, and what is kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from surefoot.studies.engine.command import stopped_by_ctrl_c, tell_failures

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
    with stopped_by_ctrl_c(out):
        results = [measure(protocol, out / protocol.robot.name) for protocol in protocols]
    status = tell_failures([failure for result in results for failure in result.failures])
    show(results)
    return status

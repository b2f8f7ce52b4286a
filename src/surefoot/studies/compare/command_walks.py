"""`surefoot compare --simulator mujoco --disturbance`: bodies walk while something is wrong."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.errors import ParameterError
from surefoot.options import check_plotting, compiling_notice, given, print_json
from surefoot.studies.compare.body_study import Progress, study_bodies

if TYPE_CHECKING:
    from surefoot.studies.compare.body_robustness import WalkProtocol

OF_PUSHES = {
    "phases": "--phases",
    "step": "--step",
    "estimate": "--estimate",
    "quick": "--quick",
    "explain": "--explain",
}
"""Options that walks without pushes have no use for; their state is always estimated."""

OF_WALKS = {"seeds": "--seeds", "duration": "--duration"}
"""Options that only they have."""


@dataclass(frozen=True)
class WalkQuestion:
    """What the command line asks of bodies that are disturbed; see `studies.compare.command`."""

    robots: tuple[str, ...]
    velocity: tuple[float, float]
    methods: tuple[str, ...]
    disturbances: tuple[str, ...]
    seeds: int
    duration: float
    workers: int
    out: Path


def refuse_of_pushes(simulator: str, disturbances: tuple[str, ...]) -> None:
    """Refuse options that make no sense with a disturbance of a body, or without.

    Raises:
        ParameterError: there is one; it is named.
    """
    walks = simulator == "mujoco" and bool(disturbances)
    for name, option in (OF_PUSHES if walks else OF_WALKS).items():
        if not given(name):
            continue
        if walks:
            raise ParameterError(
                f"{option} without --disturbance: bodies that are disturbed are not pushed",
                f"{option} and --disturbance {disturbances[0]}",
                "leave one of them out",
            )
        raise ParameterError(
            f"{option} with --simulator mujoco and --disturbance",
            f"--simulator {simulator}" if simulator != "mujoco" else "no --disturbance",
            f"leave {option} out, or add what is missing",
        )


def compare_walks(question: WalkQuestion, progress: Progress, as_json: bool) -> int:
    """Walk, print and report; the exit status.

    Raises:
        SurefootError: see `studies.compare.body_robustness.walk_disturbed`.
    """
    check_plotting()
    protocols = _protocols(question)
    from surefoot.studies.compare.body_robustness import walk_disturbed

    def measure(protocol: WalkProtocol, folder: Path) -> Any:
        with progress("walking") as report:
            return walk_disturbed(protocol, folder, workers=question.workers, report=report)

    def show(results: list[Any]) -> None:
        _show(results, question.out, as_json)

    return study_bodies(protocols, question.out, measure, show)


def _protocols(question: WalkQuestion) -> list[WalkProtocol]:
    """The walks, one set for each robot.

    Raises:
        SurefootError: a robot, a method, a disturbance or a number is not there, or an extra.
    """
    from surefoot.checks import optional_module
    from surefoot.robot.robot import load_robot

    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    from surefoot.studies.compare.body_conditions import BODY_CONDITIONS, USUAL
    from surefoot.studies.compare.body_push import mechanism_of
    from surefoot.studies.compare.body_robustness import WalkProtocol

    asked = tuple(dict.fromkeys((USUAL, *question.disturbances)))
    if "all" in asked:
        asked = tuple(one.key for one in BODY_CONDITIONS)
    protocols = [
        WalkProtocol(
            load_robot(name),
            question.velocity,
            question.methods or ("unified",),
            asked,
            question.seeds,
            question.duration,
        )
        for name in question.robots
    ]
    with compiling_notice(4.0, "a minute"):
        for protocol in protocols:
            mechanism_of(protocol.robot)
    return protocols


def _show(results: list[Any], out: Path, as_json: bool) -> None:
    from rich.console import Console

    from surefoot.studies.compare.body_walk_report import write_walk_report
    from surefoot.studies.compare.body_walks import body_walks, print_body_walks

    measured = [
        body_walks(one.rows, one.methods, one.conditions, one.provenance) for one in results
    ]
    files = write_walk_report(measured, out)
    if as_json:
        print_json({"robots": [result.as_numbers() for result in results]})
        return
    console = Console()
    for one in measured:
        print_body_walks(one, console)
        click.echo()
    click.echo(f"report: {files[0]}, picture: {files[1]}, a table in the folder of each robot")

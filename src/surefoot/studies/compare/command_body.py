"""`surefoot compare --simulator mujoco`: methods against each other on bodies that are pushed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from surefoot.errors import ParameterError
from surefoot.options import check_plotting, compiling_notice, given, print_json
from surefoot.studies.compare.body_study import Progress, study_bodies

if TYPE_CHECKING:
    from surefoot.studies.compare.body_protocol import BodyProtocol

BODY_VELOCITY, BODY_STEP = (0.3, 0.0), 2.0
"""Of a comparison in physics, unless it is told [m/s, N s]."""

QUICK_PHASES, QUICK_STEP = 2, 10.0
"""Of `--quick` [-, N s]."""

OF_BODY = {"estimate": "--estimate", "quick": "--quick", "explain": "--explain"}
"""Options that a point mass has no use for."""

OF_POINT_MASS = {
    "mass": "--mass",
    "leg_speeds": "--leg-speed",
    "durations": "--push-duration",
    "full": "--full",
    "directions": "--directions",
}
"""Options that a body has no use for: its mass and legs are what they are."""


@dataclass(frozen=True)
class BodyQuestion:
    """What the command line asks of bodies; see `studies.compare.command` for the options."""

    robots: tuple[str, ...]
    velocity: tuple[float, float]
    methods: tuple[str, ...]
    phases: int
    step: float
    estimate: bool
    explain: bool
    workers: int
    out: Path


def refuse_others(simulator: str, robots: tuple[str, ...]) -> None:
    """Refuse options that make no sense with a simulator.

    Raises:
        ParameterError: there is one; it is named.
    """
    wrong, other = (OF_BODY, "mujoco") if simulator == "lipm" else (OF_POINT_MASS, "lipm")
    for name, option in wrong.items():
        if given(name):
            raise ParameterError(
                f"{option} with --simulator {other}",
                f"--simulator {simulator}",
                f"leave {option} out, or choose the other simulator",
            )
    if simulator == "lipm" and len(robots) > 1:
        raise ParameterError(
            "one --robot with --simulator lipm",
            ", ".join(robots),
            "give a command for each, or choose --simulator mujoco",
        )
    if len(set(robots)) < len(robots):
        raise ParameterError("every --robot once", ", ".join(robots), "leave the others out")


def compare_bodies(question: BodyQuestion, progress: Progress, as_json: bool) -> int:
    """Measure, print and report; the exit status.

    Raises:
        SurefootError: see `studies.compare.body_compare.compare_on_body`.
    """
    check_plotting()
    protocols = _protocols(question)
    from surefoot.studies.compare.body_compare import compare_on_body
    from surefoot.studies.compare.body_limits import explain_worst

    explained: list[dict[str, Any]] = []

    def measure(protocol: BodyProtocol, folder: Path) -> Any:
        with progress("measuring") as report:
            result = compare_on_body(protocol, folder, workers=question.workers, report=report)
        if question.explain:
            with progress("explaining") as report:
                explained.extend(explain_worst(protocol, result.rows, report))
        return result

    def show(results: list[Any]) -> None:
        _show(results, explained, question.out, as_json)

    return study_bodies(protocols, question.out, measure, show)


def _protocols(question: BodyQuestion) -> list[BodyProtocol]:
    """The questions, one set for each robot.

    Raises:
        SurefootError: a robot, a method or a number is not there, or an extra.
    """
    from surefoot.checks import optional_module
    from surefoot.robot.robot import load_robot

    optional_module("mujoco", "physics", "mujoco")
    optional_module("daqp", "inverse dynamics", "mujoco")
    from surefoot.studies.compare.body_protocol import BODY_METHODS, BodyProtocol
    from surefoot.studies.compare.body_push import controller_of

    protocols = [
        BodyProtocol(
            load_robot(name),
            question.velocity,
            methods=question.methods or tuple(one.key for one in BODY_METHODS),
            phases=question.phases,
            step=question.step,
            estimate=question.estimate,
        )
        for name in question.robots
    ]
    with compiling_notice(4.0, "a minute"):
        for protocol in protocols:
            for key in protocol.methods:
                controller_of(protocol, key)
    return protocols


def _show(results: list[Any], explained: list[dict[str, Any]], out: Path, as_json: bool) -> None:
    from rich.console import Console

    from surefoot.studies.compare.body_push_report import write_body_report
    from surefoot.studies.compare.body_pushes import body_pushes, print_body_pushes, print_explained

    measured = [
        body_pushes(one.rows, one.methods, one.mass, one.step, one.provenance) for one in results
    ]
    files = write_body_report(measured, out, explained)
    if as_json:
        numbers = [result.as_numbers() for result in results]
        print_json({"robots": numbers, "explained": explained})
        return
    console = Console()
    for one in measured:
        print_body_pushes(one, console)
        print_explained(one, explained, console)
        click.echo()
    click.echo(f"page: {files[0]}, report: {files[1]}, a table in the folder of each robot")
